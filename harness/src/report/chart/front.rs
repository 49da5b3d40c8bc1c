//! Fronts: what points cost against what they get wrong.

use plotters::prelude::DrawingBackend;
use plotters::style::RGBColor;

use super::axis::{LogAxis, labels, log_range, percent_label};
use super::canvas::{Align, Canvas, Drawn, Figure, register, text_width};
use super::frame::{Entry as Line, Frame, Rect, Sample};
use super::palette::{CONTROL, GREY, INK, Shape, Style, Styles};
use super::{LONGEST_NAME, LONGEST_SET, cut, untimed_caption};
use crate::report::format::{self, thousands};
use crate::report::pareto::{as_read, cost_name};
use crate::report::verdict::{self, Verdict};
use crate::results::{FrontPoint, ParetoRecord, Run};
use crate::studies::pareto::{Amount, By, Cost, Entry, Field, Spot, Standing, Wrong};

const PLOT_HEIGHT: f64 = 300.0;
const ON_FRONT: f64 = 4.5;
const HOLLOW: f64 = 5.0;
const FAINT: f64 = 2.8;
/// How much of a faint colour is white.
const WHITENED: f64 = 0.55;
/// Size of the names beside points.
const NAME_SIZE: f64 = 9.5;
/// Height of a line of them.
const NAME_LINE: f64 = 12.0;
/// From where to where below a mark its arrow goes.
const ARROW: [f64; 2] = [6.0, 13.0];
/// Half the length of the caps at the ends of bars.
const CAP: f64 = 2.5;

/// A panel that is asked for.
pub(in crate::report) struct PanelOf<'a> {
    /// Its title.
    pub title: String,
    /// What is along its lower axis.
    pub cost: Cost,
    /// The points.
    pub entries: Vec<Entry<'a>>,
}

/// A point's place.
#[derive(Debug)]
struct Mark {
    style: Style,
    x: Amount,
    error: Amount,
    /// The height at which it is drawn.
    y: f64,
    at_bound: bool,
    standing: Standing,
    name: String,
    cost: f64,
}

/// Corners of a front, the cheapest first, by value and height.
type Corners = Vec<(f64, f64)>;

#[derive(Debug)]
struct Panel {
    title: String,
    x_name: String,
    x_range: (f64, f64),
    marks: Vec<Mark>,
    /// Each tracer's own, with its colour.
    own: Vec<(RGBColor, Corners)>,
    controls: Vec<(String, f64)>,
}

/// The chart.
#[derive(Debug)]
pub(in crate::report) struct FrontFigure {
    frame: Frame,
    panels: Vec<Panel>,
    y_name: String,
    /// Decimal logarithm of the least error that is shown.
    floor: f64,
}

/// A colour of its own for every tracer of a record; its presets differ in form and in how dark they are.
#[derive(Debug)]
pub(in crate::report) struct FrontStyles {
    styles: Styles,
}

impl FrontStyles {
    pub(in crate::report) fn of(record: &ParetoRecord) -> Self {
        Self { styles: Styles::of_labels(record.points.iter().map(|point| point.tracer.clone())) }
    }

    pub(super) fn get(&self, point: &FrontPoint) -> Style {
        let Style { colour, .. } = self.styles.get(&point.tracer);
        if point.preset == "published" {
            Style { colour, shape: Shape::Circle }
        } else {
            Style { colour: mixed(colour, RGBColor(0, 0, 0), 0.35), shape: Shape::Polygon(4, 0) }
        }
    }
}

/// A colour with a part of another.
fn mixed(RGBColor(r, g, b): RGBColor, RGBColor(to_r, to_g, to_b): RGBColor, part: f64) -> RGBColor {
    let mix = |from: u8, to: u8| (f64::from(from) + (f64::from(to) - f64::from(from)) * part).round() as u8;
    RGBColor(mix(r, to_r), mix(g, to_g), mix(b, to_b))
}

fn faint(style: Style) -> Style {
    Style { colour: mixed(style.colour, RGBColor(255, 255, 255), WHITENED), ..style }
}

impl FrontFigure {
    /// Lays out panels over one ray set under one rule.
    pub(in crate::report) fn new(
        run: &Run,
        field: &Field<'_>,
        by: By,
        what: &str,
        panels: Vec<PanelOf<'_>>,
        styles: &FrontStyles,
        columns: usize,
    ) -> Self {
        // Texts are measured while the figure is laid out; a font that fails is reported when it is drawn.
        let _ = register();
        let panels: Vec<Panel> = panels.into_iter().map(|asked| panel(field, by, &asked, styles)).collect();
        let drawn = panels.iter().flat_map(|panel| &panel.marks).map(|mark| mark.y);
        let floor = drawn.filter(|y| *y > 0.0).fold(0.1, f64::min).log10() - 0.25;
        let grey = Style { colour: GREY, shape: Shape::Circle };
        let line = |sample, label: &str| Line { sample, label: label.to_owned() };
        let key = vec![
            line(Sample::Filled(grey), "on the front of all tracers"),
            line(Sample::Hollow(grey), "within noise of it"),
            line(Sample::Filled(faint(grey)), "behind"),
            line(Sample::Filled(Style { shape: Shape::Polygon(4, 0), ..grey }), "improved preset"),
            line(Sample::Dashes, "control"),
            line(Sample::Bars, "95 % interval of the error, order-statistic interval of the time"),
        ];
        let mut legend: Vec<Line> = Vec::new();
        for entry in &field.entries {
            let name = entry.point.contender();
            if legend.iter().all(|line| line.label != name) {
                legend.push(Line { sample: Sample::Line(styles.get(entry.point)), label: name });
            }
        }
        let scene = &field.scene.scene;
        let name = cut(&scene.name, LONGEST_NAME);
        let void = if verdict::controls(run) == Verdict::Sound { "" } else { "VOID, CONTROLS FAIL: " };
        let rays = format!("{}, {}", cut(field.rays, LONGEST_SET), format::query(field.query));
        let titles = [
            format!("{what}: {name} ({} triangles), {rays}", thousands(scene.triangles)),
            format!(
                "{void}viewpoint {}; {} rays; wrong by {}; arrow: fewer than 3 of N rays wrong, drawn at the bound 3/N",
                field.viewpoint.name,
                thousands(field.count),
                by.name()
            ),
        ];
        let clock = "Times by the host's clock, of work on a device from submission until done.";
        let caption = format!("{clock} {}", untimed_caption(&run.provenance, &run.preset));
        let frame = Frame::in_columns(columns, PLOT_HEIGHT, panels.len(), titles, &caption, key, legend);
        let y_name = match by {
            By::Rule(_) => "wrong rays, 1 − agreement (%)",
            By::BalancedAccuracy => "1 − balanced accuracy (%)",
        };
        Self { frame, panels, y_name: y_name.to_owned(), floor }
    }
}

fn panel<'a>(field: &Field<'a>, by: By, asked: &PanelOf<'a>, styles: &FrontStyles) -> Panel {
    let mark = |(entry, spot, standing): (Entry<'a>, Spot, Standing)| {
        let wrong = Wrong::of(entry.trace, by)?;
        let x = as_read(field, asked.cost, field.cost(&entry, asked.cost)?);
        Some(Mark {
            style: styles.get(entry.point),
            x,
            error: wrong.share,
            y: spot.error,
            at_bound: wrong.at_bound(),
            standing,
            name: entry.point.contender(),
            cost: spot.cost,
        })
    };
    let marks: Vec<Mark> = field.standings(&asked.entries, asked.cost, by).into_iter().filter_map(mark).collect();
    let mut own = Vec::new();
    for tracer in field.tracers() {
        let entries: Vec<Entry<'a>> =
            asked.entries.iter().copied().filter(|entry| entry.point.tracer == tracer).collect();
        let Some(first) = entries.first() else { continue };
        let published = FrontPoint { preset: "published".to_owned(), ..first.point.clone() };
        let on: Vec<(f64, f64, f64)> = field
            .front(&entries, asked.cost, by)
            .into_iter()
            .map(|(_, spot)| {
                let read = as_read(field, asked.cost, Amount::exact(spot.cost)).value;
                (spot.cost, read, spot.error)
            })
            .collect();
        own.push((styles.get(&published).colour, corners(on)));
    }
    let mut controls = Vec::new();
    for (row, trace) in &field.controls {
        controls.extend(Wrong::of(trace, by).map(|wrong| (row.label(), wrong.drawn())));
    }
    let x_range = log_range(marks.iter().flat_map(|mark| mark.x.interval.into_iter().chain([mark.x.value])));
    Panel { title: asked.title.clone(), x_name: cost_name(asked.cost), x_range, marks, own, controls }
}

/// Points of a front (cost, value, height) as places in the order of cost.
fn corners(mut on: Vec<(f64, f64, f64)>) -> Corners {
    on.sort_by(|a, b| a.0.total_cmp(&b.0).then(b.2.total_cmp(&a.2)));
    on.into_iter().map(|(_, value, height)| (value, height)).collect()
}

/// The line round what a front has: what is cheaper is not to be had below it, up to the next point.
fn steps(places: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let mut line: Vec<(f64, f64)> = Vec::new();
    for (x, y) in places.iter().copied() {
        if let Some((_, height)) = line.last().copied() {
            line.push((x, height));
        }
        line.push((x, y));
    }
    line
}

/// What a mark covers: left, right, top and bottom.
fn box_of((left, top): (f64, f64), mark: &Mark) -> [f64; 4] {
    let below = if mark.at_bound { ARROW[1] } else { ON_FRONT };
    [left - ON_FRONT, left + ON_FRONT, top - ON_FRONT, top + below]
}

/// The box round a line that goes along or up.
fn box_round(from: (f64, f64), to: (f64, f64)) -> [f64; 4] {
    [from.0.min(to.0), from.0.max(to.0), from.1.min(to.1), from.1.max(to.1)]
}

/// Whether two boxes lie less than a hair apart.
fn meet(one: &[f64; 4], other: &[f64; 4]) -> bool {
    one[0] < other[1] + 2.0 && other[0] < one[1] + 2.0 && one[2] < other[3] + 1.0 && other[2] < one[3] + 1.0
}

impl Figure for FrontFigure {
    fn size(&self) -> (f64, f64) {
        self.frame.size()
    }

    fn draw<DB: DrawingBackend>(&self, canvas: &Canvas<DB>) -> Drawn {
        self.frame.draw(canvas)?;
        for (index, panel) in self.panels.iter().enumerate() {
            self.draw_panel(canvas, panel, self.frame.panel(index))?;
        }
        Ok(())
    }
}

impl FrontFigure {
    fn draw_panel<DB: DrawingBackend>(&self, canvas: &Canvas<DB>, panel: &Panel, rect: Rect) -> Drawn {
        let x = LogAxis::new(panel.x_range, rect.left, rect.right);
        // A little above 100 %, so that markers there are whole.
        let y = LogAxis::new((self.floor, 0.3), rect.bottom, rect.top);
        let ticks = x.ticks(8);
        for (tick, text) in ticks.iter().zip(labels(&ticks)) {
            rect.tick_below(canvas, x.at(tick.value), text.as_deref())?;
        }
        for tick in y.ticks(9).into_iter().filter(|tick| tick.value <= 1.0 + 1e-9) {
            let text = tick.labelled.then(|| percent_label(tick.value));
            rect.tick_left(canvas, y.at(tick.value), text.as_deref())?;
        }
        rect.title(canvas, &panel.title)?;
        rect.axis_names(canvas, &panel.x_name, &self.y_name)?;
        let controls: Vec<_> = panel.controls.iter().map(|(name, share)| (name.clone(), y.at(*share))).collect();
        for (_, height) in &controls {
            canvas.dashed((rect.left, *height), (rect.right, *height), CONTROL, 1.0)?;
        }
        rect.names_right(canvas, &controls)?;
        rect.edge(canvas)?;
        let at = |(value, height): &(f64, f64)| (x.at(*value), y.at(*height));
        for (colour, corners) in &panel.own {
            let places: Vec<(f64, f64)> = corners.iter().map(at).collect();
            canvas.path(&steps(&places), mixed(*colour, RGBColor(255, 255, 255), 0.3), 0.75)?;
        }
        let on_front = panel.marks.iter().filter(|mark| mark.standing == Standing::OnFront);
        let front = corners(on_front.map(|mark| (mark.cost, mark.x.value, mark.y)).collect());
        let places: Vec<(f64, f64)> = front.iter().map(at).collect();
        canvas.path(&steps(&places), INK, 1.5)?;
        // What is behind lies below what is on the front.
        let mut order: Vec<&Mark> = panel.marks.iter().collect();
        order.sort_by_key(|mark| std::cmp::Reverse(mark.standing));
        for mark in &order {
            self.draw_mark(canvas, mark, (x.at(mark.x.value), y.at(mark.y)), [&x, &y])?;
        }
        // Names keep off the line of the front and those of controls.
        let mut lines: Vec<[f64; 4]> = steps(&places).windows(2).map(|ends| box_round(ends[0], ends[1])).collect();
        lines.extend(controls.iter().map(|(_, height)| box_round((rect.left, *height), (rect.right, *height))));
        self.draw_names(canvas, panel, rect, [&x, &y], lines)?;
        if panel.marks.is_empty() {
            rect.note(canvas, "no point was timed and judged")?;
        }
        Ok(())
    }

    fn draw_mark<DB: DrawingBackend>(
        &self,
        canvas: &Canvas<DB>,
        mark: &Mark,
        place: (f64, f64),
        [x, y]: [&LogAxis; 2],
    ) -> Drawn {
        let (colour, (left, top)) = (mark.style.colour, place);
        if mark.standing == Standing::OnFront {
            let ends = mark.x.interval.map(|end| x.at(end));
            canvas.path(&[(ends[0], top), (ends[1], top)], colour, 1.0)?;
            let heights = mark.error.interval.map(|share| y.at(share.max(10.0_f64.powf(self.floor))));
            canvas.path(&[(left, heights[0]), (left, heights[1])], colour, 1.0)?;
            for end in heights.into_iter().filter(|end| (end - top).abs() > 2.0 * ON_FRONT) {
                canvas.path(&[(left - CAP, end), (left + CAP, end)], colour, 1.0)?;
            }
        }
        if mark.at_bound {
            let [from, to] = ARROW.map(|end| top + end);
            canvas.path(&[(left, from), (left, to)], colour, 1.0)?;
            canvas.path(&[(left - 2.5, to - 3.0), (left, to), (left + 2.5, to - 3.0)], colour, 1.0)?;
        }
        match mark.standing {
            Standing::OnFront => canvas.filled_marker(place, ON_FRONT, mark.style),
            Standing::WithinNoise => canvas.hollow_marker(place, HOLLOW, mark.style),
            Standing::Behind => canvas.filled_marker(place, FAINT, faint(mark.style)),
        }
    }

    /// The names of points on the front, each where it meets no other; of neighbours of the same name one.
    fn draw_names<DB: DrawingBackend>(
        &self,
        canvas: &Canvas<DB>,
        panel: &Panel,
        rect: Rect,
        [x, y]: [&LogAxis; 2],
        lines: Vec<[f64; 4]>,
    ) -> Drawn {
        let mut on: Vec<&Mark> = panel.marks.iter().filter(|mark| mark.standing == Standing::OnFront).collect();
        on.sort_by(|a, b| a.cost.total_cmp(&b.cost).then(b.y.total_cmp(&a.y)));
        on.dedup_by(|next, before| next.name == before.name);
        let mut taken: Vec<[f64; 4]> = Vec::new();
        let place = |mark: &Mark| (x.at(mark.x.value), y.at(mark.y));
        let marks = panel.marks.iter().map(|mark| box_of(place(mark), mark));
        let drawn: Vec<[f64; 4]> = marks.chain(lines).collect();
        for mark in on {
            let (left, top) = place(mark);
            let width = text_width(&mark.name, NAME_SIZE);
            let covers = |(begin, middle): &(f64, f64)| {
                [*begin, begin + width, middle - NAME_LINE / 2.0, middle + NAME_LINE / 2.0]
            };
            let free = |corner: &(f64, f64)| {
                let own = covers(corner);
                let inside = own[0] >= rect.left + 2.0
                    && own[1] <= rect.right - 2.0
                    && own[2] >= rect.top + 2.0
                    && own[3] <= rect.bottom - 2.0;
                inside && !taken.iter().any(|other| meet(&own, other))
            };
            let clear = |corner: &(f64, f64)| free(corner) && !drawn.iter().any(|other| meet(&covers(corner), other));
            let corners = [
                (left + 8.0, top - 8.0),
                (left + 8.0, top + 8.0),
                (left - 8.0 - width, top - 8.0),
                (left - 8.0 - width, top + 8.0),
                (left - width / 2.0, top - 15.0),
                (left - width / 2.0, top + 20.0),
                (left + 8.0, top - 22.0),
                (left - 8.0 - width, top - 22.0),
                (left + 8.0, top + 22.0),
                (left - 8.0 - width, top + 22.0),
                (left - width / 2.0, top + 34.0),
            ];
            // One that finds no room is told by its colour and form.
            let found = corners.iter().copied().find(clear).or_else(|| corners.iter().copied().find(free));
            let Some((begin, middle)) = found else { continue };
            taken.push(covers(&(begin, middle)));
            canvas.text(&mark.name, (begin, middle), Align::Start, NAME_SIZE, mark.style.colour)?;
        }
        Ok(())
    }
}
