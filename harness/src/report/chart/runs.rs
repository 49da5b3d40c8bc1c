//! Charts of runs: error against speed, what a tracer's speed costs in wrong rays; and agreement over tolerance, how near hits must be asked to
//! be before a tracer fails.

use tracebench_api::Query;

use super::curves::Measured;
use super::frame::{Chart, Entry, Sample};
use super::palette::{PLAIN, Style, Styles};
use super::panel::{Aside, Axis, Control, Mark, Panel, Position, Scale, level};
use super::scale::log_range;
use super::{caption, clocks, error_name, legend_label, panel_title, titles};
use crate::report::group::{Group, RaySet, Role};
use crate::report::metrics;
use crate::results::{Record, TraceRecord};

const FILLED: f64 = 4.5;
const HOLLOW: f64 = 6.5;

/// A tracer's place.
struct Point {
    style: Style,
    speed: Measured,
    /// Under the rule that sampled methods can meet, or of the balanced accuracy.
    filled: Measured,
    /// Under the tight rule.
    hollow: Option<Measured>,
}

impl Point {
    fn errors(&self) -> impl Iterator<Item = Measured> {
        [Some(self.filled), self.hollow].into_iter().flatten()
    }
}

/// Error against speed over a group.
pub(in crate::report) fn speed(record: &Record, group: &Group<'_>) -> Chart {
    let styles = &Styles::of(record);
    let shown: Vec<_> = group.ray_sets.iter().map(|set| points(group, set, styles)).collect();
    let points = || shown.iter().flat_map(|(points, _)| points);
    let speeds = log_range(points().flat_map(|point| point.speed.interval.into_iter().chain([point.speed.value])));
    let one_ray = group.ray_sets.iter().map(|set| 1.0 / set.count.max(1) as f64);
    let scale = Scale::down_to(one_ray.chain(points().flat_map(Point::errors).map(|error| error.value)));
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
    let panel = |(set, (points, controls)): (&RaySet<'_>, (Vec<Point>, Vec<Control>))| Panel {
        title: panel_title(set),
        x: Axis { name: metrics::SPEED.axis(), scale: Scale::Log(speeds, 8) },
        y: Axis { name: error_name(set.query), scale: scale.clone() },
        controls,
        marks: marks(&points),
        note: points.is_empty().then_some("no tracer was timed on these rays"),
    };
    let panels = group.ray_sets.iter().zip(shown).map(panel).collect();
    let titles = titles("Error against speed", record, group);
    Chart::new(panels, titles, caption(record, group), [legend(group, styles, Sample::Filled, &clocks(group)), key])
}

fn legend(group: &Group<'_>, styles: &Styles, sample: fn(Style) -> Sample, clocks: &[&str]) -> Vec<Entry> {
    group.configs.iter().map(|row| Entry::new(sample(styles.get(&row.label())), legend_label(row, clocks))).collect()
}

/// The configurations' places in a ray set, and the controls.
fn points(group: &Group<'_>, set: &RaySet<'_>, styles: &Styles) -> (Vec<Point>, Vec<Control>) {
    let (mut points, mut controls) = (Vec::new(), Vec::new());
    for (role, row, trace) in group.traces(set) {
        let Some((filled, hollow)) = errors(trace) else { continue };
        let name = row.label();
        if role == Role::Control {
            controls.push(level(name.clone(), filled.value));
            // A second line only where the rules differ enough to be seen.
            let close = |a: f64, b: f64| a == b || (a > 0.0 && b > 0.0 && (a / b).log10().abs() < 0.03);
            if let Some(tight) = hollow.filter(|tight| !close(tight.value, filled.value)) {
                controls.push(level(format!("{name}, tight"), tight.value));
            }
        } else if let Some(value) = metrics::speed(trace) {
            let speed = Measured { value, interval: metrics::speed_interval(trace).unwrap_or([value; 2]) };
            points.push(Point { style: styles.get(&name), speed, filled, hollow });
        }
    }
    (points, controls)
}

/// All bars before all markers: a bar over a marker would hide which kind it is. Hollow markers first: they are larger, and where both rules
/// agree the filled one sits inside.
fn marks(points: &[Point]) -> Vec<Mark> {
    let bars = points.iter().flat_map(|point| {
        point.errors().map(|error| Mark::Bars {
            place: (point.speed.value, error.value),
            across: Some(point.speed.interval),
            up: error.interval,
            colour: point.style.colour,
            aside: Aside::default(),
        })
    });
    let place = |point: &Point, error: Measured| (point.speed.value, error.value);
    let hollow = |point: &Point| Some(Mark::marker(place(point, point.hollow?), HOLLOW, point.style, true));
    let filled = points.iter().map(|point| Mark::marker(place(point, point.filled), FILLED, point.style, false));
    bars.chain(points.iter().filter_map(hollow)).chain(filled).collect()
}

fn errors(trace: &TraceRecord) -> Option<(Measured, Option<Measured>)> {
    match metrics::right_of(trace).as_slice() {
        [_, tight, footprint] => Some((footprint.wrong_share()?, tight.wrong_share())),
        [balanced] => Some((balanced.wrong_share()?, None)),
        _ => None,
    }
}

/// A curve: tolerance and agreement, by rising tolerance.
type Curve = Vec<Position>;

/// Those of the configurations, and of the controls.
type Curves = (Vec<(Style, Curve)>, Vec<Control>);

/// Agreement over tolerance over a group.
pub(in crate::report) fn tolerance(record: &Record, group: &Group<'_>) -> Chart {
    let styles = &Styles::of(record);
    let sets = || group.ray_sets.iter().filter(|set| set.query == Query::Closest);
    let shown: Vec<_> = sets().map(|set| curves(group, set, styles)).collect();
    let configs = shown.iter().flat_map(|(configs, _)| configs.iter().map(|(_, curve)| curve));
    let all = configs.chain(shown.iter().flat_map(|(_, controls)| controls.iter().map(|(_, curve)| curve)));
    let tolerances = log_range(all.flatten().map(|(tolerance, _)| *tolerance));
    let panel = |(set, (configs, controls)): (&RaySet<'_>, Curves)| {
        let line = |(style, curve): &(Style, Curve)| Mark::line(curve, style.colour, 2.0);
        let markers = |(index, (style, curve)): (usize, &(Style, Curve))| Mark::Along {
            places: curve.clone(),
            radius: 4.0,
            style: *style,
            from: index as f64 / configs.len() as f64,
        };
        Panel {
            title: panel_title(set),
            x: Axis { name: "tolerance (scene diagonals)".to_owned(), scale: Scale::Log(tolerances, 6) },
            y: Axis { name: "agreement (%)".to_owned(), scale: Scale::Whole },
            controls,
            marks: configs.iter().map(line).chain(configs.iter().enumerate().map(markers)).collect(),
            note: configs.is_empty().then_some("no tracer traced these rays"),
        }
    };
    let panels = sets().zip(shown).map(panel).collect();
    let titles = titles("Agreement over tolerance", record, group);
    let legends = [legend(group, styles, Sample::Line, &[]), vec![Entry::new(Sample::Dashes, "control")]];
    Chart::new(panels, titles, caption(record, group), legends)
}

/// The curves over a ray set.
fn curves(group: &Group<'_>, set: &RaySet<'_>, styles: &Styles) -> Curves {
    let (mut configs, mut controls) = (Vec::new(), Vec::new());
    for (role, row, trace) in group.traces(set) {
        let Some(judgement) = metrics::closest(trace) else { continue };
        let whole = |point: &&[f64; 2]| point[0] > 0.0 && point.iter().all(|each| each.is_finite());
        let mut curve: Curve =
            judgement.curve.iter().filter(whole).map(|[tolerance, share]| (*tolerance, *share)).collect();
        curve.sort_by(|a, b| a.0.total_cmp(&b.0));
        let name = row.label();
        match role {
            _ if curve.is_empty() => {}
            Role::Control => controls.push((name, curve)),
            Role::Tracer => configs.push((styles.get(&name), curve)),
        }
    }
    (configs, controls)
}
