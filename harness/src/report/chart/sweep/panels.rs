//! What the panels of a sweep's chart show, taken from its views.

use itertools::Itertools as _;
use tracebench_api::{ClockKind, Query};

use super::super::axis::log_range;
use super::super::curves::{Curve, Measured, Values, measured};
use super::super::palette::Style;
use super::super::panel::{Aside, Axis, Control, Panel, Scale, level};
use crate::report::format;
use crate::report::group::Role;
use crate::report::metrics::{self, BALANCED, BUILD_TIME, SPEED, STRUCTURE};
use crate::report::sweep::{Cell, View};
use crate::results::{Row, Times, TraceRecord};

/// Panels of values from zero up, unless they differ by more than this.
const LINEAR_RATIO: f64 = 10.0;

/// A rule by which answers are right: its name, and its place among those of a query.
pub(super) type Rule = (&'static str, usize);

/// The rules by which answers to a query are told.
pub(super) fn rules(query: Query) -> Vec<Rule> {
    metrics::rules(query).iter().enumerate().map(|(place, name)| (*name, place)).collect()
}

/// How often answers are wrong by a rule.
fn wrong(trace: &TraceRecord, (_, place): Rule) -> Option<Measured> {
    metrics::right_of(trace).get(place)?.wrong_share()
}

/// A figure of each of a view's curves, which have so many styles, in the order of the axis.
fn curves(
    view: &View<'_>,
    styles: &[Style],
    hollow: bool,
    figure: impl Fn(&Row, &TraceRecord) -> Option<Measured>,
) -> Vec<Curve> {
    let of = |cell: &Cell<'_>| cell.measured.and_then(|(row, trace)| figure(row, trace)).filter(Measured::is_finite);
    let all = view.curves.iter().zip(styles).enumerate().map(|(order, (curve, style))| {
        let cell = |value: &String| curve.cells.iter().find(|cell| cell.value == value);
        let at = view.axis.values.iter().map(|value| cell(value).and_then(of)).collect();
        Curve { style: *style, hollow, aside: Aside(order, styles.len()), at }
    });
    all.collect()
}

fn magnitudes(title: String, name: &str, values: &Values, curves: &[Curve]) -> Panel {
    let all = || measured(curves).map(|one| one.value);
    let (least, most) =
        all().fold((f64::INFINITY, 0.0_f64), |(least, most), value| (least.min(value), most.max(value)));
    let y = if least > 0.0 && most > LINEAR_RATIO * least {
        Axis { name: format!("{name}, log"), scale: Scale::Log(log_range(all()), 6) }
    } else {
        // An interval far beyond every value would leave no room for these.
        let ends = measured(curves).flat_map(|one| one.interval);
        let top = ends.filter(|end| *end <= 2.0 * most).fold(most, f64::max);
        Axis { name: name.to_owned(), scale: Scale::Span([0.0, if top > 0.0 { 1.08 * top } else { 1.0 }]) }
    };
    values.panel(title, y, curves, Vec::new())
}

pub(super) fn memory(view: &View<'_>, values: &Values, styles: &[Style]) -> Panel {
    let mib = |bytes: u64| Some(Measured::exact(bytes as f64 / f64::from(1 << 20)));
    let mut all = curves(view, styles, true, |row, _| mib(metrics::used_bytes(row)));
    all.extend(curves(view, styles, false, |row, _| mib(row.memory.structure_bytes)));
    magnitudes("structure's memory".to_owned(), &STRUCTURE.axis(), values, &all)
}

pub(super) fn build(view: &View<'_>, values: &Values, styles: &[Style]) -> Panel {
    let time = |row: &Row| {
        let Times { median_ms, interval_ms, samples_ms, .. } = row.build.first();
        (!samples_ms.is_empty()).then_some(Measured { value: *median_ms, interval: *interval_ms })
    };
    let title = format!("build: {}", clock_names(view, |row, _| row.build.first().clock));
    let all = curves(view, styles, false, |row, _| time(row));
    magnitudes(title, &BUILD_TIME.called("build").axis(), values, &all)
}

pub(super) fn speed(view: &View<'_>, values: &Values, styles: &[Style]) -> Panel {
    // Without an accuracy there is no speed.
    let speed = |trace: &TraceRecord| {
        let value = metrics::speed(trace).filter(|_| metrics::judged(trace))?;
        Some(Measured { value, interval: metrics::speed_interval(trace).unwrap_or([value; 2]) })
    };
    let title = format!("trace: {}", clock_names(view, |_, trace| trace.times.clock));
    magnitudes(title, &SPEED.axis(), values, &curves(view, styles, false, |_, trace| speed(trace)))
}

/// The clocks of what a panel shows.
fn clock_names(view: &View<'_>, clock: impl Fn(&Row, &TraceRecord) -> ClockKind) -> String {
    let measured = view.curves.iter().flat_map(|curve| &curve.cells).filter_map(|cell| cell.measured);
    let names = measured.map(|(row, trace)| format::clock(clock(row, trace))).unique().join(" / ");
    if names.is_empty() { "nothing timed".to_owned() } else { names }
}

/// Errors by several rules, with a style each, of a view with one curve.
pub(super) fn errors(view: &View<'_>, values: &Values, rules: &[Rule], styles: &[Style]) -> Panel {
    let mut all = Vec::new();
    for (order, (rule, style)) in rules.iter().zip(styles).enumerate() {
        let of_rule = curves(view, &[*style], false, |_, trace| wrong(trace, *rule));
        all.extend(of_rule.into_iter().map(|curve| Curve { aside: Aside(order, rules.len()), ..curve }));
    }
    // The last rule is the one by which charts of speed show controls.
    error_panel(view, values, "wrong rays".to_owned(), rules.last(), &all)
}

/// Errors by one rule.
pub(super) fn errors_by(view: &View<'_>, values: &Values, rule: &Rule, styles: &[Style]) -> Panel {
    let all = curves(view, styles, false, |_, trace| wrong(trace, *rule));
    error_panel(view, values, format!("wrong rays: {}", rule.0), Some(rule), &all)
}

fn error_panel(view: &View<'_>, values: &Values, title: String, of_controls: Option<&Rule>, all: &[Curve]) -> Panel {
    let mut controls: Vec<Control> = Vec::new();
    for (_, row, trace) in view.group.traces(view.set).into_iter().filter(|(role, ..)| *role == Role::Control) {
        let Some(wrong) = of_controls.and_then(|rule| wrong(trace, *rule)) else { continue };
        let control = level(row.label(), wrong.value);
        // Points that were tried alone have controls of their own; they score the same.
        if !controls.contains(&control) {
            controls.push(control);
        }
    }
    let name = match view.set.query {
        Query::Any => format!("1 − {} (%), log", BALANCED.label),
        Query::Closest => "wrong rays (%), log".to_owned(),
    };
    let one_ray = 1.0 / view.set.count.max(1) as f64;
    let scale = Scale::down_to(measured(all).map(|one| one.value).chain([one_ray]));
    values.panel(title, Axis { name, scale }, all, controls)
}
