//! Error against speed: what a tracer's speed costs in wrong rays.

use plotters::prelude::DrawingBackend;
use tracebench_api::Query;

use super::axis::{LogAxis, labels, log_range, percent_label};
use super::canvas::{Align, Canvas, Drawn, Figure, register};
use super::frame::{Entry, Frame, Rect, Sample, TICK_SIZE};
use super::palette::{CONTROL, GREY, SHADE, Shape, Style, Styles};
use super::{caption, clocks, legend_label, panel_title, titles};
use crate::report::group::{Group, RaySet, Role};
use crate::report::metrics;
use crate::report::sheet::Accuracy;
use crate::results::{Run, TraceRecord};

/// Height of the row for zero at the foot of a panel; a logarithm never gets there.
const ZERO_ROW: f64 = 26.0;
/// The most decades of error shown: beyond it shares hang on single rays of impossible sets.
const DEEPEST: f64 = -9.0;
const FILLED: f64 = 4.5;
const HOLLOW: f64 = 6.5;
/// Half the length of the caps at the ends of bars.
const CAP: f64 = 3.0;
/// Bars that end nearer than this to their marker get no cap: it would touch the marker.
const CAPPED: f64 = 9.0;

/// An error with its interval.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Error {
    share: f64,
    interval: [f64; 2],
}

/// A tracer's place.
#[derive(Debug)]
struct Point {
    style: Style,
    speed: f64,
    speed_interval: [f64; 2],
    /// Under the rule that sampled methods can meet, or of the balanced accuracy.
    filled: Error,
    /// Under the tight rule.
    hollow: Option<Error>,
}

#[derive(Debug)]
struct Panel {
    title: String,
    error_name: &'static str,
    points: Vec<Point>,
    /// Controls' names and errors.
    controls: Vec<(String, f64)>,
}

/// The chart.
#[derive(Debug)]
pub(super) struct SpeedFigure {
    frame: Frame,
    panels: Vec<Panel>,
    speeds: (f64, f64),
    /// Decimal logarithm of the least error above zero that is shown.
    floor: f64,
}

impl SpeedFigure {
    /// Takes what it shows from a group.
    pub(super) fn new(run: &Run, group: &Group<'_>, styles: &Styles) -> Self {
        // Texts are measured while the figure is laid out; a font that fails is reported when it is drawn.
        let _ = register();
        let panels: Vec<Panel> = group.ray_sets.iter().map(|set| panel(group, set, styles)).collect();
        let points = || panels.iter().flat_map(|panel| &panel.points);
        let speeds = log_range(points().flat_map(|point| point.speed_interval.into_iter().chain([point.speed])));
        let one_ray = group.ray_sets.iter().map(|set| 1.0 / set.count.max(1) as f64);
        let errors = points().flat_map(|point| [Some(point.filled), point.hollow]).flatten().map(|error| error.share);
        let least = one_ray.chain(errors).filter(|share| *share > 0.0).fold(0.1, f64::min);
        let floor = least.log10().floor().max(DEEPEST);
        let grey = Style { colour: GREY, shape: Shape::Circle };
        let has = |query| group.ray_sets.iter().any(|set| set.query == query);
        let filled = match (has(Query::Closest), has(Query::Any)) {
            (true, true) => "closest hit: footprint rule; any hit: balanced accuracy",
            (false, true) => "balanced accuracy",
            _ => "footprint rule",
        };
        let mut key = vec![Entry { sample: Sample::Filled(grey), label: filled.to_owned() }];
        if has(Query::Closest) {
            key.push(Entry { sample: Sample::Hollow(grey), label: "closest hit: tight rule".to_owned() });
        }
        key.push(Entry { sample: Sample::Dashes, label: "control".to_owned() });
        let bars = "95 % interval of the error, order-statistic interval of the speed";
        key.push(Entry { sample: Sample::Bars, label: bars.to_owned() });
        let clocks = clocks(group);
        let legend = group
            .contenders
            .iter()
            .map(|one| Entry { sample: Sample::Filled(styles.get(&one.label())), label: legend_label(one, &clocks) });
        let titles = titles("Error against speed", run, group);
        let frame = Frame::new(panels.len(), titles, &caption(run, group), key, legend.collect());
        Self { frame, panels, speeds, floor }
    }
}

fn panel(group: &Group<'_>, set: &RaySet<'_>, styles: &Styles) -> Panel {
    let mut points = Vec::new();
    let mut controls: Vec<(String, f64)> = Vec::new();
    for (role, run, trace) in group.traces(set) {
        let Some((filled, hollow)) = errors(trace) else { continue };
        let name = run.label();
        if role == Role::Control {
            controls.push((name.clone(), filled.share));
            // A second line only where the rules differ enough to be seen.
            if let Some(tight) = hollow.filter(|tight| !close(tight.share, filled.share)) {
                controls.push((format!("{name}, tight"), tight.share));
            }
        } else if let Some(speed) = metrics::speed(trace) {
            let speed_interval = metrics::speed_interval(trace).unwrap_or([speed, speed]);
            points.push(Point { style: styles.get(&name), speed, speed_interval, filled, hollow });
        }
    }
    Panel {
        title: panel_title(set),
        error_name: match set.query {
            Query::Closest => "wrong rays, 1 − agreement (%)",
            Query::Any => "1 − balanced accuracy (%)",
        },
        points,
        controls,
    }
}

fn errors(trace: &TraceRecord) -> Option<(Error, Option<Error>)> {
    let error = |right: &Accuracy| {
        let [low, high] = right.interval.unwrap_or([right.share?; 2]);
        Some(Error { share: (1.0 - right.share?).max(0.0), interval: [(1.0 - high).max(0.0), (1.0 - low).max(0.0)] })
    };
    match metrics::right_of(trace).as_slice() {
        [_, tight, footprint] => Some((error(footprint)?, error(tight))),
        [balanced] => Some((error(balanced)?, None)),
        _ => None,
    }
}

fn close(a: f64, b: f64) -> bool {
    a == b || (a > 0.0 && b > 0.0 && (a / b).log10().abs() < 0.03)
}

/// The axes of one panel.
struct Scales {
    rect: Rect,
    x: LogAxis,
    y: LogAxis,
    /// The middle of the row for zero.
    zero: f64,
}

impl Scales {
    fn error(&self, share: f64) -> f64 {
        if share > 0.0 { self.y.at(share) } else { self.zero }
    }
}

impl Figure for SpeedFigure {
    fn size(&self) -> (f64, f64) {
        self.frame.size()
    }

    fn draw<DB: DrawingBackend>(&self, canvas: &Canvas<DB>) -> Drawn {
        self.frame.draw(canvas)?;
        for (index, panel) in self.panels.iter().enumerate() {
            let rect = self.frame.panel(index);
            let scales = Scales {
                rect,
                x: LogAxis::new(self.speeds, rect.left, rect.right),
                // A little above 100 %, so that markers there are whole.
                y: LogAxis::new((self.floor, 0.3), rect.bottom - ZERO_ROW, rect.top),
                zero: rect.bottom - ZERO_ROW / 2.0,
            };
            draw_panel(canvas, panel, &scales)?;
        }
        Ok(())
    }
}

fn draw_panel<DB: DrawingBackend>(canvas: &Canvas<DB>, panel: &Panel, scales: &Scales) -> Drawn {
    let rect = scales.rect;
    canvas.fill((rect.left, rect.bottom - ZERO_ROW), (rect.right, rect.bottom), SHADE)?;
    let ticks = scales.x.ticks(8);
    for (tick, text) in ticks.iter().zip(labels(&ticks)) {
        rect.tick_below(canvas, scales.x.at(tick.value), text.as_deref())?;
    }
    for tick in scales.y.ticks(9).into_iter().filter(|tick| tick.value <= 1.0 + 1e-9) {
        let text = tick.labelled.then(|| percent_label(tick.value));
        rect.tick_left(canvas, scales.y.at(tick.value), text.as_deref())?;
    }
    canvas.text("0", (rect.left - 8.0, scales.zero), Align::End, TICK_SIZE, GREY)?;
    rect.title(canvas, &panel.title)?;
    rect.axis_names(canvas, &metrics::SPEED.axis(), panel.error_name)?;
    let controls: Vec<_> = panel.controls.iter().map(|(name, share)| (name.clone(), scales.error(*share))).collect();
    for (_, y) in &controls {
        canvas.dashed((rect.left, *y), (rect.right, *y), CONTROL, 1.0)?;
    }
    rect.names_right(canvas, &controls)?;
    rect.edge(canvas)?;
    // All bars before all markers: a bar over a marker would hide which kind it is.
    for point in &panel.points {
        for error in [Some(point.filled), point.hollow].into_iter().flatten() {
            draw_bars(canvas, point, error, scales)?;
        }
    }
    // Hollow ones first: they are larger, and where both rules agree the filled one sits inside.
    for point in &panel.points {
        if let Some(tight) = point.hollow {
            let place = (scales.x.at(point.speed), scales.error(tight.share));
            canvas.hollow_marker(place, HOLLOW, point.style)?;
        }
    }
    for point in &panel.points {
        let place = (scales.x.at(point.speed), scales.error(point.filled.share));
        canvas.filled_marker(place, FILLED, point.style)?;
    }
    if panel.points.is_empty() {
        rect.note(canvas, "no contender was timed on these rays")?;
    }
    Ok(())
}

fn draw_bars<DB: DrawingBackend>(canvas: &Canvas<DB>, point: &Point, error: Error, scales: &Scales) -> Drawn {
    let (x, y) = (scales.x.at(point.speed), scales.error(error.share));
    let [slow, fast] = point.speed_interval.map(|speed| scales.x.at(speed));
    let colour = point.style.colour;
    canvas.path(&[(slow, y), (fast, y)], colour, 1.0)?;
    for end in [slow, fast].into_iter().filter(|end| (end - x).abs() > CAPPED) {
        canvas.path(&[(end, y - CAP), (end, y + CAP)], colour, 1.0)?;
    }
    let [least, most] = error.interval;
    // An error above zero whose interval reaches below the axis ends at the axis, not in the row for zero.
    let least = if error.share > 0.0 { scales.y.at(least) } else { y };
    let most = scales.error(most);
    canvas.path(&[(x, least), (x, most)], colour, 1.0)?;
    for end in [least, most].into_iter().filter(|end| (end - y).abs() > CAPPED) {
        canvas.path(&[(x - CAP, end), (x + CAP, end)], colour, 1.0)?;
    }
    Ok(())
}
