//! Error against speed: what a tracer's speed costs in wrong rays.

use tracebench_api::Query;

use super::axis::log_range;
use super::curves::Measured;
use super::frame::{Entry, Frame, Sample};
use super::palette::{PLAIN, Style, Styles};
use super::panel::{Aside, Axis, Chart, Mark, Panel, Scale, level};
use super::{caption, clocks, error_name, legend_label, panel_title, titles};
use crate::report::group::{Group, RaySet, Role};
use crate::report::metrics;
use crate::results::{Record, TraceRecord};

const FILLED: f64 = 4.5;
const HOLLOW: f64 = 6.5;

/// A tracer's place.
#[derive(Debug)]
struct Point {
    style: Style,
    speed: f64,
    speed_interval: [f64; 2],
    /// Under the rule that sampled methods can meet, or of the balanced accuracy.
    filled: Measured,
    /// Under the tight rule.
    hollow: Option<Measured>,
}

/// The configurations' places in a ray set, and the controls' names and errors.
type Shown = (Vec<Point>, Vec<(String, f64)>);

/// The chart of a group.
pub(in crate::report) fn chart(record: &Record, group: &Group<'_>) -> Chart {
    let styles = &Styles::of(record);
    let shown: Vec<Shown> = group.ray_sets.iter().map(|set| shown(group, set, styles)).collect();
    let points = || shown.iter().flat_map(|(points, _)| points);
    let speeds = log_range(points().flat_map(|point| point.speed_interval.into_iter().chain([point.speed])));
    let one_ray = group.ray_sets.iter().map(|set| 1.0 / set.count.max(1) as f64);
    let errors = points().flat_map(|point| [Some(point.filled), point.hollow]).flatten().map(|error| error.value);
    let has = |query| group.ray_sets.iter().any(|set| set.query == query);
    let filled = match (has(Query::Closest), has(Query::Any)) {
        (true, true) => "closest hit: footprint rule; any hit: balanced accuracy",
        (false, true) => "balanced accuracy",
        _ => "footprint rule",
    };
    let mut key = vec![Entry::new(Sample::Filled(PLAIN), filled)];
    if has(Query::Closest) {
        key.push(Entry::new(Sample::Hollow(PLAIN), "closest hit: tight rule"));
    }
    key.push(Entry::new(Sample::Dashes, "control"));
    let bars = "95 % interval of the error, order-statistic interval of the speed";
    key.push(Entry::new(Sample::Bars, bars));
    let clocks = clocks(group);
    let legend = group
        .configs
        .iter()
        .map(|one| Entry::new(Sample::Filled(styles.get(&one.label())), legend_label(one, &clocks)));
    let titles = titles("Error against speed", record, group);
    let frame = Frame::new(shown.len(), titles, &caption(record, group), key, legend.collect());
    let scales = [Scale::Log(speeds, 8), Scale::down_to(one_ray.chain(errors))];
    let panels = group.ray_sets.iter().zip(shown).map(|(set, shown)| panel(set, shown, &scales)).collect();
    Chart { frame, panels }
}

fn shown(group: &Group<'_>, set: &RaySet<'_>, styles: &Styles) -> Shown {
    let mut points = Vec::new();
    let mut controls: Vec<(String, f64)> = Vec::new();
    for (role, row, trace) in group.traces(set) {
        let Some((filled, hollow)) = errors(trace) else { continue };
        let name = row.label();
        if role == Role::Control {
            controls.push((name.clone(), filled.value));
            // A second line only where the rules differ enough to be seen.
            if let Some(tight) = hollow.filter(|tight| !close(tight.value, filled.value)) {
                controls.push((format!("{name}, tight"), tight.value));
            }
        } else if let Some(speed) = metrics::speed(trace) {
            let speed_interval = metrics::speed_interval(trace).unwrap_or([speed, speed]);
            points.push(Point { style: styles.get(&name), speed, speed_interval, filled, hollow });
        }
    }
    (points, controls)
}

fn panel(set: &RaySet<'_>, (points, controls): Shown, [x, y]: &[Scale; 2]) -> Panel {
    // All bars before all markers: a bar over a marker would hide which kind it is.
    let bars = points.iter().flat_map(|point| {
        [Some(point.filled), point.hollow].into_iter().flatten().map(|error| Mark::Bars {
            place: (point.speed, error.value),
            across: Some(point.speed_interval),
            up: error.interval,
            colour: point.style.colour,
            aside: Aside::default(),
        })
    });
    let marker = |point: &Point, error: Measured, radius: f64, hollow: bool| Mark::Marker {
        place: (point.speed, error.value),
        radius,
        style: point.style,
        hollow,
        aside: Aside::default(),
    };
    // Hollow ones first: they are larger, and where both rules agree the filled one sits inside.
    let hollow = points.iter().filter_map(|point| Some(marker(point, point.hollow?, HOLLOW, true)));
    let filled = points.iter().map(|point| marker(point, point.filled, FILLED, false));
    Panel {
        title: panel_title(set),
        x: Axis { name: metrics::SPEED.axis(), scale: x.clone() },
        y: Axis { name: error_name(set.query), scale: y.clone() },
        controls: controls.into_iter().map(|(name, share)| level(name, share)).collect(),
        marks: bars.chain(hollow).chain(filled).collect(),
        note: points.is_empty().then_some("no tracer was timed on these rays"),
    }
}

fn errors(trace: &TraceRecord) -> Option<(Measured, Option<Measured>)> {
    match metrics::right_of(trace).as_slice() {
        [_, tight, footprint] => Some((footprint.wrong_share()?, tight.wrong_share())),
        [balanced] => Some((balanced.wrong_share()?, None)),
        _ => None,
    }
}

fn close(a: f64, b: f64) -> bool {
    a == b || (a > 0.0 && b > 0.0 && (a / b).log10().abs() < 0.03)
}
