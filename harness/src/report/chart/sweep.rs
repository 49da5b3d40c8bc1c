//! A sweep: memory, build, trace and error over the values of one parameter, in small panels.
//!
//! One curve has one error panel with every rule in it; the curves of a grid have a panel a rule.

use plotters::prelude::DrawingBackend;
use tracebench_api::{ClockKind, Query};

use super::axis::{LogAxis, labels, log_range, percent_label};
use super::canvas::{Align, Canvas, Drawn, Figure, register, shorten, text_width};
use super::frame::{AXIS_SIZE, Entry, Frame, Rect, Sample, TICK_SIZE};
use super::palette::{CONTROL, GREY, INK, SHADE, Shape, Style, Styles};
use super::{caption, cut, panel_title, titles};
use crate::report::format::{self, significant};
use crate::report::group::Role;
use crate::report::metrics;
use crate::report::sweep::{Cell, Curve, View};
use crate::results::{Judgement, Run, Times, TraceRecord, TracerRun};
use crate::sweep::{Multiple, RESOLUTION};

const PLOT_HEIGHT: f64 = 190.0;
/// Height of the row for zero at the foot of an error panel; a logarithm never gets there.
const ZERO_ROW: f64 = 24.0;
/// The most decades of error shown.
const DEEPEST: f64 = -9.0;
/// Panels of values from zero up, unless they differ by more than this.
const LINEAR_RATIO: f64 = 10.0;
const FILLED: f64 = 4.0;
const HOLLOW: f64 = 6.0;
/// Between neighbouring values below a panel.
const VALUE_GAP: f64 = 4.0;
/// Half the length of the caps at the ends of bars.
const CAP: f64 = 2.5;
/// The most characters of a value in the caption and in the legend.
const LONGEST_VALUE: usize = 32;

/// A value with its interval.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Mark {
    value: f64,
    interval: [f64; 2],
}

impl Mark {
    fn exact(value: f64) -> Self {
        Self { value, interval: [value; 2] }
    }
}

/// Marks by the place of their value; `None` where nothing was measured.
#[derive(Debug)]
struct Series {
    style: Style,
    /// Dashed with hollow markers.
    hollow: bool,
    marks: Vec<Option<Mark>>,
}

#[derive(Debug)]
enum Scale {
    /// From zero up to a value.
    Linear(f64),
    /// Over decimal logarithms.
    Log((f64, f64)),
    /// Shares, with a row for zero; the decimal logarithm of the least that is not.
    Share(f64),
}

#[derive(Debug)]
struct Panel {
    title: String,
    y_name: String,
    scale: Scale,
    series: Vec<Series>,
    /// Controls' names and errors.
    controls: Vec<(String, f64)>,
}

/// The chart.
#[derive(Debug)]
pub(super) struct SweepFigure {
    frame: Frame,
    panels: Vec<Panel>,
    x_name: String,
    values: Vec<String>,
    /// The place of the tracer's own value.
    own: Option<usize>,
    /// Values at which no curve was measured.
    skipped: Vec<bool>,
    /// Whether there is anything between one value and the next, so that a line may lead there: not between names.
    connected: bool,
}

/// How wrong answers are told: the rule's name, and the share that it finds right with its interval.
type Rule = (&'static str, fn(&TraceRecord) -> Option<(f64, Option<[f64; 2]>)>);

const CLOSEST_RULES: [Rule; 3] = [
    ("hit_miss", |trace| {
        let judgement = metrics::closest(trace)?;
        Some((judgement.agreement.hit_miss?, judgement.interval.hit_miss))
    }),
    ("tight", |trace| {
        let judgement = metrics::closest(trace)?;
        Some((judgement.agreement.tight?, judgement.interval.tight))
    }),
    ("footprint", |trace| {
        let judgement = metrics::closest(trace)?;
        Some((judgement.agreement.footprint?, judgement.interval.footprint))
    }),
];

const ANY_RULES: [Rule; 1] = [("balanced accuracy", |trace| {
    let occlusion = &metrics::any(trace)?.occlusion;
    Some((occlusion.balanced_accuracy?, occlusion.balanced_accuracy_interval))
})];

fn rules(query: Query) -> &'static [Rule] {
    match query {
        Query::Closest => &CLOSEST_RULES,
        Query::Any => &ANY_RULES,
    }
}

impl SweepFigure {
    /// Takes what it shows from a view.
    pub(super) fn new(run: &Run, view: &View<'_>) -> Self {
        // Texts are measured while the figure is laid out; a font that fails is reported when it is drawn.
        let _ = register();
        let rules = rules(view.set.query);
        let alone = view.other.is_none();
        let curve_styles = Styles::of_labels(view.curves.iter().map(curve_label));
        let style_of = |curve: &Curve<'_>| {
            if alone { Style { colour: INK, shape: Shape::Circle } } else { curve_styles.get(&curve_label(curve)) }
        };
        let rule_styles = Styles::of_labels(rules.iter().map(|(name, _)| (*name).to_owned()));
        let mut panels = vec![memory(view, style_of), build(view, style_of), speed(view, style_of)];
        if alone {
            let series = rules.iter().flat_map(|rule| {
                view.curves.iter().map(|curve| errors(view, curve, rule, rule_styles.get(rule.0))).collect::<Vec<_>>()
            });
            panels.push(error_panel(view, "wrong rays", rules, series.collect()));
        } else {
            for rule in rules {
                let series = view.curves.iter().map(|curve| errors(view, curve, rule, style_of(curve)));
                let title = format!("wrong rays: {}", rule.0);
                panels.push(error_panel(view, &title, std::slice::from_ref(rule), series.collect()));
            }
        }
        let values: Vec<String> = view.axis.values.iter().map(|value| cut(value, LONGEST_VALUE)).collect();
        let skipped = |value: &String| {
            let cells = || view.curves.iter().flat_map(|curve| &curve.cells).filter(|cell| cell.value == value);
            cells().next().is_some() && cells().all(|cell| cell.measured.is_none())
        };
        let skipped = view.axis.values.iter().map(skipped).collect();
        let is_number = |value: &String| value.parse::<f64>().is_ok() || Multiple::parse(value).is_some();
        Self {
            frame: frame(run, view, panels.len(), legend(view, rules, &rule_styles, &curve_styles)),
            x_name: name_with_unit(&view.axis.name, &view.axis.unit),
            own: view.axis.values.iter().position(|value| *value == view.axis.own),
            values,
            skipped,
            connected: view.axis.values.iter().all(is_number),
            panels,
        }
    }
}

fn name_with_unit(name: &str, unit: &str) -> String {
    let name = cut(name, LONGEST_VALUE);
    if unit.is_empty() { name } else { format!("{name} ({unit})") }
}

fn curve_label(curve: &Curve<'_>) -> String {
    curve.other.unwrap_or_default().to_owned()
}

fn legend(view: &View<'_>, rules: &[Rule], rule_styles: &Styles, curve_styles: &Styles) -> Vec<Entry> {
    match view.other {
        None => {
            let entry = |rule: &Rule| Entry { sample: Sample::Line(rule_styles.get(rule.0)), label: rule.0.to_owned() };
            rules.iter().map(entry).collect()
        }
        Some(other) => {
            let label = |curve: &Curve<'_>| {
                let own = if curve.other == Some(&other.own) { " (own)" } else { "" };
                format!("{}={}{own}", other.name, cut(curve.other.unwrap_or_default(), LONGEST_VALUE))
            };
            let entry =
                |curve| Entry { sample: Sample::Line(curve_styles.get(&curve_label(curve))), label: label(curve) };
            view.curves.iter().map(entry).collect()
        }
    }
}

fn frame(run: &Run, view: &View<'_>, panels: usize, legend: Vec<Entry>) -> Frame {
    let what = match &run.sweep {
        Some(sweep) => format!("{} over {}", cut(&sweep.tracer, LONGEST_VALUE), cut(&view.axis.name, LONGEST_VALUE)),
        None => cut(&view.axis.name, LONGEST_VALUE),
    };
    let [title, subtitle] = titles(&what, run, view.group);
    let void = if subtitle.starts_with("VOID") { "VOID, CONTROLS FAIL: " } else { "" };
    let subtitle = format!(
        "{void}{}; viewpoint {}; shaded: the tracer's own value",
        panel_title(view.set),
        cut(&view.group.viewpoint.name, LONGEST_VALUE)
    );
    let grey = Style { colour: GREY, shape: Shape::Circle };
    let mut key = vec![Entry { sample: Sample::Hollow(grey), label: "memory: of it used".to_owned() }];
    key.push(Entry { sample: Sample::Dashes, label: "control".to_owned() });
    let bars = "95 % interval of the error, order-statistic intervals of the times";
    key.push(Entry { sample: Sample::Bars, label: bars.to_owned() });
    let others = others(run, view);
    let caption = format!("{others}{}", caption(run, view.group));
    Frame::in_columns(if panels > 4 { 3 } else { 2 }, PLOT_HEIGHT, panels, [title, subtitle], &caption, key, legend)
}

/// The parameters that are not along the axes.
fn others(run: &Run, view: &View<'_>) -> String {
    let point = run.sweep.as_ref().and_then(|sweep| sweep.points.first());
    let along = |name: &str| name == view.axis.name || view.other.is_some_and(|other| other.name == name);
    let value = |value: &serde_json::Value| value.as_str().map_or_else(|| value.to_string(), str::to_owned);
    let parameters = point.into_iter().flat_map(|point| &point.parameters).filter(|(name, _)| !along(name));
    let parts: Vec<_> = parameters.map(|(name, v)| format!("{name}={}", cut(&value(v), LONGEST_VALUE))).collect();
    let size = point.filter(|_| !along(RESOLUTION)).map(|point| {
        let [width, height] = point.frame;
        format!("frame {width}×{height}, faces {}", point.face)
    });
    match (parts.join(", "), size) {
        (parts, None) if parts.is_empty() => String::new(),
        (parts, None) => format!("Others: {parts}. "),
        (parts, Some(size)) if parts.is_empty() => format!("Others: {size}. "),
        (parts, Some(size)) => format!("Others: {parts}; {size}. "),
    }
}

/// Marks in the order of the axis.
fn marks(
    view: &View<'_>,
    curve: &Curve<'_>,
    mark: impl Fn(&TracerRun, &TraceRecord) -> Option<Mark>,
) -> Vec<Option<Mark>> {
    let whole = |mark: &Mark| mark.value.is_finite() && mark.interval.iter().all(|end| end.is_finite());
    let of = |cell: &Cell<'_>| cell.measured.and_then(|(run, trace)| mark(run, trace)).filter(whole);
    let cell = |value: &String| curve.cells.iter().find(|cell| cell.value == value);
    view.axis.values.iter().map(|value| cell(value).and_then(of)).collect()
}

fn magnitudes(title: &str, y_name: &str, series: Vec<Series>) -> Panel {
    let all = || series.iter().flat_map(|series| series.marks.iter().flatten()).map(|mark| mark.value);
    let ends = || series.iter().flat_map(|series| series.marks.iter().flatten()).flat_map(|mark| mark.interval);
    let (least, most) =
        all().fold((f64::INFINITY, 0.0_f64), |(least, most), value| (least.min(value), most.max(value)));
    let (scale, y_name) = if least > 0.0 && most > LINEAR_RATIO * least {
        (Scale::Log(log_range(all())), format!("{y_name}, log"))
    } else {
        // An interval far beyond every value would leave no room for these.
        let top = ends().filter(|end| *end <= 2.0 * most).fold(most, f64::max);
        (Scale::Linear(if top > 0.0 { 1.08 * top } else { 1.0 }), y_name.to_owned())
    };
    Panel { title: title.to_owned(), y_name, scale, series, controls: Vec::new() }
}

fn memory(view: &View<'_>, style_of: impl Fn(&Curve<'_>) -> Style) -> Panel {
    let mib = |bytes: u64| Some(Mark::exact(bytes as f64 / f64::from(1 << 20)));
    let used = |run: &TracerRun| run.memory.structure.iter().map(|entry| entry.used_bytes).sum();
    let series = view.curves.iter().flat_map(|curve| {
        let style = style_of(curve);
        [
            Series { style, hollow: true, marks: marks(view, curve, |run, _| mib(used(run))) },
            Series { style, hollow: false, marks: marks(view, curve, |run, _| mib(run.memory.structure_bytes)) },
        ]
    });
    magnitudes("structure's memory", "structure (MiB)", series.collect())
}

fn build(view: &View<'_>, style_of: impl Fn(&Curve<'_>) -> Style) -> Panel {
    let time = |run: &TracerRun| {
        let Times { median_ms, interval_ms, samples_ms, .. } = &run.build.times;
        (!samples_ms.is_empty()).then_some(Mark { value: *median_ms, interval: *interval_ms })
    };
    let of = |curve| Series { style: style_of(curve), hollow: false, marks: marks(view, curve, |run, _| time(run)) };
    let clocks = clock_names(view, |run, _| run.build.times.clock);
    magnitudes(&format!("build: {clocks}"), "build (ms)", view.curves.iter().map(of).collect())
}

fn speed(view: &View<'_>, style_of: impl Fn(&Curve<'_>) -> Style) -> Panel {
    // Without an accuracy there is no speed.
    let judged = |trace: &TraceRecord| rules(trace.query).iter().all(|(_, right)| right(trace).is_some());
    let speed = |trace: &TraceRecord| {
        let value = metrics::speed(trace).filter(|_| judged(trace))?;
        Some(Mark { value, interval: metrics::speed_interval(trace).unwrap_or([value; 2]) })
    };
    let of =
        |curve| Series { style: style_of(curve), hollow: false, marks: marks(view, curve, |_, trace| speed(trace)) };
    let clocks = clock_names(view, |_, trace| trace.times.clock);
    magnitudes(&format!("trace: {clocks}"), "speed (Mrays/s)", view.curves.iter().map(of).collect())
}

/// The clocks of what a panel shows.
fn clock_names(view: &View<'_>, clock: impl Fn(&TracerRun, &TraceRecord) -> ClockKind) -> String {
    let mut names: Vec<&str> = Vec::new();
    for (run, trace) in view.curves.iter().flat_map(|curve| &curve.cells).filter_map(|cell| cell.measured) {
        let name = format::clock(clock(run, trace));
        if !names.contains(&name) {
            names.push(name);
        }
    }
    if names.is_empty() { "nothing timed".to_owned() } else { names.join(" / ") }
}

fn wrong((right, interval): (f64, Option<[f64; 2]>)) -> Mark {
    let [low, high] = interval.unwrap_or([right; 2]);
    Mark { value: (1.0 - right).max(0.0), interval: [(1.0 - high).max(0.0), (1.0 - low).max(0.0)] }
}

fn errors(view: &View<'_>, curve: &Curve<'_>, rule: &Rule, style: Style) -> Series {
    Series { style, hollow: false, marks: marks(view, curve, |_, trace| rule.1(trace).map(wrong)) }
}

fn error_panel(view: &View<'_>, title: &str, shown: &[Rule], series: Vec<Series>) -> Panel {
    let one_ray = 1.0 / view.set.count.max(1) as f64;
    let found = series.iter().flat_map(|series| series.marks.iter().flatten()).map(|mark| mark.value);
    let least = found.chain([one_ray]).filter(|share| *share > 0.0).fold(0.1, f64::min);
    let mut controls: Vec<(String, f64)> = Vec::new();
    for (_, run, trace) in view.group.traces(view.set).into_iter().filter(|(role, ..)| *role == Role::Control) {
        // The last rule is the one by which charts of speed show controls.
        let Some(share) = shown.last().and_then(|rule| rule.1(trace)).map(|right| wrong(right).value) else { continue };
        let name = run.tracer.label();
        // Points that were tried alone have controls of their own; they score the same.
        if !controls.contains(&(name.clone(), share)) {
            controls.push((name, share));
        }
    }
    let any = matches!(view.curves.iter().flat_map(|curve| &curve.cells).find_map(|cell| cell.measured),
        Some((_, trace)) if matches!(trace.judgement, Judgement::Any(_)));
    let y_name = if any { "1 − balanced accuracy (%), log" } else { "wrong rays (%), log" };
    let scale = Scale::Share(least.log10().floor().max(DEEPEST));
    Panel { title: title.to_owned(), y_name: y_name.to_owned(), scale, series, controls }
}

/// The places of one panel; values stand at equal distances, whatever they are.
struct Places {
    rect: Rect,
    count: usize,
    up: Up,
}

enum Up {
    Linear { most: f64 },
    Log(LogAxis),
    Share { axis: LogAxis, zero: f64 },
}

impl Places {
    fn new(rect: Rect, count: usize, scale: &Scale) -> Self {
        let up = match scale {
            Scale::Linear(most) => Up::Linear { most: *most },
            Scale::Log(range) => Up::Log(LogAxis::new(*range, rect.bottom, rect.top)),
            // A little above 100 %, so that markers there are whole.
            Scale::Share(floor) => Up::Share {
                axis: LogAxis::new((*floor, 0.3), rect.bottom - ZERO_ROW, rect.top),
                zero: rect.bottom - ZERO_ROW / 2.0,
            },
        };
        Self { rect, count, up }
    }

    fn column(&self) -> f64 {
        (self.rect.right - self.rect.left) / self.count.max(1) as f64
    }

    fn x(&self, index: usize) -> f64 {
        self.rect.left + (index as f64 + 0.5) * self.column()
    }

    fn y(&self, value: f64) -> f64 {
        match &self.up {
            Up::Linear { most } => {
                let part = (value / most).clamp(0.0, 1.0);
                self.rect.bottom + (self.rect.top - self.rect.bottom) * part
            }
            Up::Log(axis) => axis.at(value),
            Up::Share { axis, zero } => {
                if value > 0.0 {
                    axis.at(value)
                } else {
                    *zero
                }
            }
        }
    }

    /// The place of an interval's lower end: one below the axis ends at it, not in the row for zero.
    fn low_end(&self, mark: &Mark) -> f64 {
        match &self.up {
            Up::Share { axis, .. } if mark.value > 0.0 => axis.at(mark.interval[0]),
            _ => self.y(mark.interval[0]),
        }
    }
}

impl Figure for SweepFigure {
    fn size(&self) -> (f64, f64) {
        self.frame.size()
    }

    fn draw<DB: DrawingBackend>(&self, canvas: &Canvas<DB>) -> Drawn {
        self.frame.draw(canvas)?;
        for (index, panel) in self.panels.iter().enumerate() {
            let places = Places::new(self.frame.panel(index), self.values.len(), &panel.scale);
            self.draw_panel(canvas, panel, &places)?;
        }
        Ok(())
    }
}

impl SweepFigure {
    fn draw_panel<DB: DrawingBackend>(&self, canvas: &Canvas<DB>, panel: &Panel, places: &Places) -> Drawn {
        let rect = places.rect;
        if let Some(own) = self.own {
            let half = places.column() / 2.0;
            canvas.fill((places.x(own) - half, rect.top), (places.x(own) + half, rect.bottom), SHADE)?;
        }
        draw_ticks(canvas, places)?;
        self.draw_values(canvas, places)?;
        rect.title(canvas, &panel.title)?;
        // Below a second line of values.
        let (drop, middle) = (if self.two_lines(places) { 42.0 } else { 35.0 }, (rect.left + rect.right) / 2.0);
        let room = rect.right - rect.left;
        let name = shorten(&self.x_name, AXIS_SIZE, room);
        canvas.text(&name, (middle, rect.bottom + drop), Align::Middle, AXIS_SIZE, INK)?;
        canvas.text_upwards(&panel.y_name, (rect.left - 57.0, (rect.top + rect.bottom) / 2.0), AXIS_SIZE, INK)?;
        let controls: Vec<_> = panel.controls.iter().map(|(name, share)| (name.clone(), places.y(*share))).collect();
        for (_, y) in &controls {
            canvas.dashed((rect.left, *y), (rect.right, *y), CONTROL, 1.0)?;
        }
        rect.names_right(canvas, &controls)?;
        rect.edge(canvas)?;
        draw_series(canvas, panel, places, self.connected)
    }

    fn two_lines(&self, places: &Places) -> bool {
        self.values.iter().any(|value| text_width(value, TICK_SIZE) > places.column() - VALUE_GAP)
    }

    /// The values below, on two lines where one is too narrow, and what was skipped.
    fn draw_values<DB: DrawingBackend>(&self, canvas: &Canvas<DB>, places: &Places) -> Drawn {
        let rect = places.rect;
        let two_lines = self.two_lines(places);
        for (index, value) in self.values.iter().enumerate() {
            let x = places.x(index);
            rect.tick_below(canvas, x, None)?;
            let room = if two_lines { 2.0 } else { 1.0 } * places.column() - VALUE_GAP;
            let drop = if two_lines && index % 2 == 1 { 24.5 } else { 14.0 };
            canvas.text(&shorten(value, TICK_SIZE, room), (x, rect.bottom + drop), Align::Middle, TICK_SIZE, GREY)?;
            if self.skipped[index] {
                let middle = (x, (rect.top + rect.bottom) / 2.0);
                canvas.text_upwards("skipped", middle, TICK_SIZE, GREY)?;
            }
        }
        Ok(())
    }
}

fn draw_ticks<DB: DrawingBackend>(canvas: &Canvas<DB>, places: &Places) -> Drawn {
    let rect = places.rect;
    match &places.up {
        Up::Linear { most } => {
            let step = round_step(*most, 6.0);
            let count = (*most / step).floor() as u32;
            for index in 0..=count {
                let value = f64::from(index) * step;
                let text = if index == 0 { "0".to_owned() } else { step_label(value, step) };
                rect.tick_left(canvas, places.y(value), Some(&text))?;
            }
            Ok(())
        }
        Up::Log(axis) => {
            let ticks = axis.ticks(6);
            for (tick, text) in ticks.iter().zip(labels(&ticks)) {
                rect.tick_left(canvas, axis.at(tick.value), text.as_deref())?;
            }
            Ok(())
        }
        Up::Share { axis, zero } => {
            for tick in axis.ticks(6).into_iter().filter(|tick| tick.value <= 1.0 + 1e-9) {
                let text = tick.labelled.then(|| percent_label(tick.value));
                rect.tick_left(canvas, axis.at(tick.value), text.as_deref())?;
            }
            // The floor: below it there is nothing but zero.
            canvas.path(&[(rect.left, rect.bottom - ZERO_ROW), (rect.right, rect.bottom - ZERO_ROW)], GREY, 0.5)?;
            canvas.text("0", (rect.left - 8.0, *zero), Align::End, TICK_SIZE, GREY)
        }
    }
}

/// A step of 1, 2 or 5 times a power of ten of which no more than so many fit.
fn round_step(most: f64, steps: f64) -> f64 {
    let least = most / steps;
    let power = 10.0_f64.powf(least.log10().floor());
    let digit = [1.0, 2.0, 5.0].into_iter().find(|digit| digit * power >= least * (1.0 - 1e-9)).unwrap_or(10.0);
    digit * power
}

/// A multiple of a step with as many decimals as the step has.
fn step_label(value: f64, step: f64) -> String {
    let decimals = (-step.log10().floor()).max(0.0);
    if decimals > 4.0 || value >= 1e6 { significant(value, 2) } else { format!("{value:.0$}", decimals as usize) }
}

fn draw_series<DB: DrawingBackend>(canvas: &Canvas<DB>, panel: &Panel, places: &Places, connected: bool) -> Drawn {
    // Series that coincide stand side by side; the hollow one of a pair goes round its filled one.
    let shown: Vec<usize> = (0..panel.series.len()).filter(|index| !panel.series[*index].hollow).collect();
    let gap = (2.0 * FILLED + 2.0).min(0.8 * places.column() / shown.len().max(1) as f64);
    let aside = |index: usize| {
        let order = shown.iter().position(|each| *each >= index).unwrap_or(0);
        gap * (order as f64 - (shown.len() as f64 - 1.0) / 2.0)
    };
    let at = |index: usize, place: usize, mark: &Mark| (places.x(place) + aside(index), places.y(mark.value));
    for (index, series) in panel.series.iter().enumerate() {
        let marks: Vec<_> = series.marks.iter().enumerate().collect();
        for pair in marks.windows(2).filter(|_| connected) {
            let [(from, Some(a)), (to, Some(b))] = pair else { continue };
            let (a, b) = (at(index, *from, a), at(index, *to, b));
            if series.hollow {
                canvas.dashed(a, b, series.style.colour, 1.0)?;
            } else {
                canvas.path(&[a, b], series.style.colour, 1.5)?;
            }
        }
        for (place, mark) in marks.iter().filter_map(|(place, mark)| Some((*place, (*mark).as_ref()?))) {
            let (x, y) = at(index, place, mark);
            let ends = [places.low_end(mark), places.y(mark.interval[1])];
            canvas.path(&[(x, ends[0]), (x, ends[1])], series.style.colour, 1.0)?;
            for end in ends.into_iter().filter(|end| (end - y).abs() > 2.0 * FILLED) {
                canvas.path(&[(x - CAP, end), (x + CAP, end)], series.style.colour, 1.0)?;
            }
        }
    }
    for (index, series) in panel.series.iter().enumerate().filter(|(_, series)| series.hollow) {
        for (place, mark) in series.marks.iter().enumerate().filter_map(|(place, mark)| Some((place, mark.as_ref()?))) {
            canvas.hollow_marker(at(index, place, mark), HOLLOW, series.style)?;
        }
    }
    for (index, series) in panel.series.iter().enumerate().filter(|(_, series)| !series.hollow) {
        for (place, mark) in series.marks.iter().enumerate().filter_map(|(place, mark)| Some((place, mark.as_ref()?))) {
            canvas.filled_marker(at(index, place, mark), FILLED, series.style)?;
        }
    }
    if panel.series.iter().all(|series| series.marks.iter().all(Option::is_none)) {
        places.rect.note(canvas, "nothing was measured")?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::super::sweep_charts;
    use super::super::tests::{check_png, check_svg};
    use super::*;
    use crate::report::fixture::{self, Quality};
    use crate::report::group::groups;
    use crate::report::sweep::tests::{Swept, sweep_run};
    use crate::report::sweep::views;

    /// Draws every chart of a sweep, looks at each, and gives their names and SVGs.
    fn check(run: &Run) -> Vec<(String, String)> {
        let groups = groups(run);
        let files = sweep_charts(run, &views(run.sweep.as_ref().unwrap(), &groups)).unwrap();
        let mut drawn = Vec::new();
        for file in files {
            if file.name.ends_with(".svg") {
                let svg = String::from_utf8(file.contents).unwrap();
                check_svg(&file.name, &svg);
                drawn.push((file.name, svg));
            } else {
                check_png(&file.name, &file.contents);
            }
        }
        drawn
    }

    const SETS: [(&str, Query); 2] = [("diffuse", Query::Closest), ("ao", Query::Any)];
    const BUCKETS: Swept = ("buckets", "24", &["1", "4", "8", "16", "24", "32", "40"]);
    const RESOLUTIONS: Swept = (RESOLUTION, "1", &["1/4", "1/2", "1", "2"]);
    const CLIPS: Swept = ("clip", "polygon", &["polygon", "plane"]);

    /// A chart for every axis and ray set, with every value, the clocks, the machine, and each rule where they differ.
    #[test]
    fn ordinary_sweeps() {
        let run = sweep_run(&[BUCKETS, RESOLUTIONS, CLIPS], &SETS, false);
        let drawn = check(&run);
        assert_eq!(drawn.len(), 3 * 2);
        let svg = |name: &str| &drawn.iter().find(|(found, _)| found == name).unwrap().1;
        for wanted in
            ["hit_miss", "tight", "footprint", ">\n40\n", "device timestamps", "Example Processor", "always-hit"]
        {
            assert!(svg("sweep_room_buckets_diffuse.svg").contains(wanted), "{wanted}");
        }
        assert!(svg("sweep_room_clip_ao.svg").contains("balanced accuracy"));
        assert!(!svg("sweep_room_clip_ao.svg").contains("skipped"));
    }

    /// What was skipped is said in its place; a sweep of which nothing is left is drawn all the same.
    #[test]
    fn skipped_points() {
        let mut run = sweep_run(&[BUCKETS], &SETS, false);
        let gone = run.runs.pop().unwrap();
        let sweep = run.sweep.as_mut().unwrap();
        let point = sweep.points.iter_mut().find(|point| point.is_of(&gone)).unwrap();
        point.skipped.insert(gone.scene.name.clone(), "too large".to_owned());
        let drawn = check(&run);
        // Once in each of four panels.
        assert!(drawn.iter().all(|(_, svg)| svg.matches("skipped").count() == 4));
        // One run stays, on a point that is not of the sweep: it is shown nowhere.
        run.runs.truncate(1);
        run.runs[0].viewpoint.face += 1;
        assert!(check(&run).iter().all(|(_, svg)| svg.matches("nothing was measured").count() == 4));
    }

    /// Combinations: a curve a value of the second parameter, a panel a rule.
    #[test]
    fn grids() {
        let drawn = check(&sweep_run(&[BUCKETS, RESOLUTIONS], &SETS, true));
        assert_eq!(drawn.len(), 2);
        for wanted in ["resolution=1/4", "resolution=1 (own)", "wrong rays: tight", "wrong rays: footprint"] {
            assert!(drawn[0].1.contains(wanted), "{wanted}");
        }
    }

    /// As many values as there may be, names longer than any page, a single value.
    #[test]
    fn long_names_and_many_values() {
        let many: Vec<String> = (0..16).map(|index| format!("{}", 1000 * index)).collect();
        let many: Vec<&str> = many.iter().map(String::as_str).collect();
        let long = "a most particular and very long value of it ".repeat(4);
        let longer = long.clone() + "again";
        let name = "a parameter with a very long name ".repeat(5);
        let run = sweep_run(
            &[("buckets", "0", &many), (&name, &long, &[&long, &longer, "b"]), ("clip", "a", &["a"])],
            &SETS,
            false,
        );
        assert_eq!(check(&run).len(), 3 * 2);
        check(&sweep_run(&[("buckets", "0", &many), (&name, &long, &[&long, &longer])], &SETS, true));
    }

    /// Figures that no run should have, and a run of nothing but ties, which shows no speed.
    #[test]
    fn odd_figures() {
        let mut run = sweep_run(&[BUCKETS], &SETS, false);
        let oddities = [f64::NAN, f64::INFINITY, 0.0, -1.0, 1e300];
        for (odd, one) in oddities.into_iter().zip(&mut run.runs) {
            one.build.times.median_ms = odd;
            one.build.times.interval_ms = [odd, odd];
            one.memory.structure_bytes = u64::MAX;
            for trace in &mut one.traces {
                trace.mrays_per_s = odd;
                trace.times.interval_ms = [odd, odd];
            }
        }
        check(&run);
        let mut ties = sweep_run(&[BUCKETS], &[("diffuse", Query::Closest)], false);
        for trace in ties.runs.iter_mut().flat_map(|one| &mut one.traces) {
            if let Judgement::Closest(judgement) = &mut trace.judgement {
                (judgement.agreement, judgement.interval) = Default::default();
            }
        }
        // Neither errors nor speeds; memory and build are there.
        assert_eq!(check(&ties)[0].1.matches("nothing was measured").count(), 2);
    }

    /// Without a wrong ray, and with nothing but wrong ones.
    #[test]
    fn no_errors_and_nothing_but_errors() {
        for missed in [0.0, 1.0] {
            let mut run = sweep_run(&[BUCKETS], &SETS, false);
            let quality = Quality { missed, blur: missed, speed: 3.0, clock: ClockKind::Host };
            let other = fixture::run(&[("dirt", quality)], &SETS).runs.remove(0);
            run.runs.iter_mut().for_each(|one| one.traces.clone_from(&other.traces));
            check(&run);
        }
    }

    /// Ticks are round, few, and told apart by their labels.
    #[test]
    fn linear_ticks_are_round() {
        for most in [1e-5, 0.03, 0.9, 1.0, 7.3, 99.0, 1234.0, 5e7] {
            let step = round_step(most, 6.0);
            let count = (most / step).floor();
            assert!((2.0..=6.0).contains(&count), "{most}: {count}");
            let labels: Vec<_> = (1..=count as u32).map(|index| step_label(f64::from(index) * step, step)).collect();
            assert!(labels.windows(2).all(|pair| pair[0] != pair[1]), "{labels:?}");
            assert!(labels.iter().all(|label| label.len() <= 7), "{labels:?}");
        }
        assert_eq!((round_step(60.0, 6.0), step_label(0.30000000000000004, 0.1).as_str()), (10.0, "0.3"));
    }
}
