//! What the panels of a sweep's chart show, taken from its views.

use tracebench_api::{ClockKind, Query};

use super::super::axis::log_range;
use super::super::palette::Style;
use super::super::plot::{Mark, Panel, Scale, Series, share_scale};
use crate::report::format;
use crate::report::group::Role;
use crate::report::metrics::{self, BALANCED, BUILD_TIME, SPEED, STRUCTURE};
use crate::report::sweep::{Cell, Curve, View};
use crate::results::{Times, TraceRecord, TracerRun};

/// Panels of values from zero up, unless they differ by more than this.
const LINEAR_RATIO: f64 = 10.0;

/// A rule by which answers are right: its name, and its place among those of a query.
pub(super) type Rule = (&'static str, usize);

/// The rules by which answers to a query are told.
pub(super) fn rules(query: Query) -> Vec<Rule> {
    metrics::rules(query).iter().enumerate().map(|(place, name)| (*name, place)).collect()
}

/// How often answers are wrong by a rule.
fn wrong(trace: &TraceRecord, (_, place): Rule) -> Option<Mark> {
    let right = metrics::right_of(trace).get(place).copied()?;
    let [low, high] = right.interval.unwrap_or([right.share?; 2]);
    Some(Mark { value: (1.0 - right.share?).max(0.0), interval: [(1.0 - high).max(0.0), (1.0 - low).max(0.0)] })
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

pub(super) fn memory(view: &View<'_>, style_of: impl Fn(&Curve<'_>) -> Style) -> Panel {
    let mib = |bytes: u64| Some(Mark::exact(bytes as f64 / f64::from(1 << 20)));
    let series = view.curves.iter().flat_map(|curve| {
        let style = style_of(curve);
        [
            Series { style, hollow: true, marks: marks(view, curve, |run, _| mib(metrics::used_bytes(run))) },
            Series { style, hollow: false, marks: marks(view, curve, |run, _| mib(run.memory.structure_bytes)) },
        ]
    });
    magnitudes("structure's memory", &STRUCTURE.axis(), series.collect())
}

pub(super) fn build(view: &View<'_>, style_of: impl Fn(&Curve<'_>) -> Style) -> Panel {
    let time = |run: &TracerRun| {
        let Times { median_ms, interval_ms, samples_ms, .. } = &run.build.times;
        (!samples_ms.is_empty()).then_some(Mark { value: *median_ms, interval: *interval_ms })
    };
    let of = |curve| Series { style: style_of(curve), hollow: false, marks: marks(view, curve, |run, _| time(run)) };
    let clocks = clock_names(view, |run, _| run.build.times.clock);
    magnitudes(&format!("build: {clocks}"), &BUILD_TIME.called("build").axis(), view.curves.iter().map(of).collect())
}

pub(super) fn speed(view: &View<'_>, style_of: impl Fn(&Curve<'_>) -> Style) -> Panel {
    // Without an accuracy there is no speed.
    let speed = |trace: &TraceRecord| {
        let value = metrics::speed(trace).filter(|_| metrics::judged(trace))?;
        Some(Mark { value, interval: metrics::speed_interval(trace).unwrap_or([value; 2]) })
    };
    let of =
        |curve| Series { style: style_of(curve), hollow: false, marks: marks(view, curve, |_, trace| speed(trace)) };
    let clocks = clock_names(view, |_, trace| trace.times.clock);
    magnitudes(&format!("trace: {clocks}"), &SPEED.axis(), view.curves.iter().map(of).collect())
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

pub(super) fn errors(view: &View<'_>, curve: &Curve<'_>, rule: Rule, style: Style) -> Series {
    Series { style, hollow: false, marks: marks(view, curve, |_, trace| wrong(trace, rule)) }
}

pub(super) fn error_panel(view: &View<'_>, title: &str, shown: &[Rule], series: Vec<Series>) -> Panel {
    let found = series.iter().flat_map(|series| series.marks.iter().flatten()).map(|mark| mark.value);
    let scale = share_scale(view.set.count, found);
    let mut controls: Vec<(String, f64)> = Vec::new();
    for (_, run, trace) in view.group.traces(view.set).into_iter().filter(|(role, ..)| *role == Role::Control) {
        // The last rule is the one by which charts of speed show controls.
        let Some(share) = shown.last().and_then(|rule| wrong(trace, *rule)).map(|wrong| wrong.value) else { continue };
        let name = run.label();
        // Points that were tried alone have controls of their own; they score the same.
        if !controls.contains(&(name.clone(), share)) {
            controls.push((name, share));
        }
    }
    let y_name = match view.set.query {
        Query::Any => format!("1 − {} (%), log", BALANCED.label),
        Query::Closest => "wrong rays (%), log".to_owned(),
    };
    Panel { title: title.to_owned(), y_name, scale, series, controls }
}
