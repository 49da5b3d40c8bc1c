//! A sweep: memory, build, trace and error over the values of one parameter, in small panels.
//!
//! One curve has one error panel with every rule in it; the curves of a grid have a panel a rule.

#[cfg(test)]
mod tests;

use itertools::Itertools as _;
use tracebench_api::{ClockKind, Query};

use super::curves::{Curve, Measured, Values, measured};
use super::frame::{Chart, Entry, Sample};
use super::palette::{INK, PLAIN, Shape, Style, Styles};
use super::panel::{Aside, Axis, Mark, Panel, Scale, level};
use super::scale::log_range;
use super::{LONGEST_VALUE, caption, cut, invalid, panel_title, scene_title};
use crate::cases;
use crate::report::format;
use crate::report::group::Role;
use crate::report::metrics::{self, BALANCED, BUILD_TIME, SPEED, STRUCTURE};
use crate::report::sweep::{self, Cell, View};
use crate::report::verdict;
use crate::results::{Record, Row, Times, TraceRecord, said};
use crate::studies::sweep::RESOLUTION;
use crate::studies::tune::Label;

const PLOT_HEIGHT: f64 = 190.0;

/// Panels of values from zero up, unless they differ by more than this.
const LINEAR_RATIO: f64 = 10.0;

/// The chart of a view.
pub(in crate::report) fn chart(record: &Record, view: &View<'_>) -> Chart {
    let rules = metrics::rules(view.set.query);
    let curve_styles = Styles::of_labels(view.curves.iter().map(curve_label));
    let rule_styles = Styles::of_labels(rules.iter().map(|name| (*name).to_owned()));
    let skipped = |value: &String| {
        let cells = || view.curves.iter().flat_map(|curve| &curve.cells).filter(|cell| cell.value == value);
        cells().next().is_some() && cells().all(|cell| cell.measured.is_none())
    };
    let all = &view.axis.values;
    let own = all.iter().position(|value| *value == view.axis.own);
    let values = Values::even(cases::label(&cut(&view.axis.name, LONGEST_VALUE), &view.axis.unit), all, own);
    let values = values.skipping(all.iter().map(skipped));
    let plain = Style { colour: INK, shape: Shape::Circle };
    let of_curve = |curve| if view.other.is_none() { plain } else { curve_styles.get(&curve_label(curve)) };
    let styles: Vec<Style> = view.curves.iter().map(of_curve).collect();
    let mut panels = vec![memory(view, &values, &styles)];
    if !record.is_untimed() {
        panels.extend([build(view, &values, &styles), speed(view, &values, &styles)]);
    }
    let legend = match view.other {
        None => {
            let of_rule = |place: usize| {
                let (style, aside) = (rule_styles.get(rules[place]), Aside(place, rules.len()));
                view.curves.iter().map(move |of| curve(view, of, style, false, aside, |_, trace| wrong(trace, place)))
            };
            let all: Vec<Curve> = (0..rules.len()).flat_map(of_rule).collect();
            // The last rule is the one by which charts of speed show controls.
            panels.push(error_panel(view, &values, "wrong rays".to_owned(), rules.len() - 1, &all));
            rule_styles.legend(Sample::Line)
        }
        Some(other) => {
            panels.extend(rules.iter().enumerate().map(|(place, rule)| {
                let all = curves(view, &styles, false, |_, trace| wrong(trace, place));
                error_panel(view, &values, format!("wrong rays: {rule}"), place, &all)
            }));
            let entry = |of: &sweep::Curve<'_>| {
                let own = if of.other == Some(&other.own) { " (own)" } else { "" };
                let label = format!("{}={}{own}", other.name, cut(of.other.unwrap_or_default(), LONGEST_VALUE));
                Entry::new(Sample::Line(curve_styles.get(&curve_label(of))), label)
            };
            view.curves.iter().map(entry).collect()
        }
    };
    let key = vec![
        Entry::new(Sample::Hollow(PLAIN), "memory: of it used"),
        Entry::new(Sample::Dashes, "control"),
        Entry::new(Sample::Bars, "95 % interval of the error, order-statistic intervals of the times"),
    ];
    let chosen = chosen(view);
    for panel in &mut panels {
        let places = chosen.iter().filter_map(|(_, value)| all.iter().position(|each| each == value));
        // Below the curves.
        panel.marks.splice(0..0, places.map(|place| Mark::Rule(values.places[place])));
    }
    let columns = if panels.len() > 4 { 3 } else { 2 };
    let told = chosen.iter().map(|(label, value)| format!("{} {}", label.name(), cut(value, LONGEST_VALUE))).join(", ");
    let told = if told.is_empty() { told } else { format!("Upright dashes: {told}. ") };
    let caption = others(record, view) + &told + &caption(record, view.group);
    Chart::new(panels, titled(record, view), caption, [legend, key]).in_columns(columns, PLOT_HEIGHT)
}

/// The values that would be chosen.
fn chosen<'a>(view: &View<'a>) -> Vec<(Label, &'a str)> {
    let of = |label: Label| Some((label, view.tuned?.chosen(label)?));
    Label::ALL.into_iter().filter_map(of).collect()
}

fn curve_label(curve: &sweep::Curve<'_>) -> String {
    curve.other.unwrap_or_default().to_owned()
}

fn titled(record: &Record, view: &View<'_>) -> [String; 2] {
    let what = match &record.sweep {
        Some(sweep) => format!("{} over {}", cut(&sweep.tracer, LONGEST_VALUE), cut(&view.axis.name, LONGEST_VALUE)),
        None => cut(&view.axis.name, LONGEST_VALUE),
    };
    let (invalid, viewpoint) = (invalid(&verdict::controls(record)), cut(&view.group.viewpoint.name, LONGEST_VALUE));
    let set = panel_title(view.set);
    let below = format!("{invalid}{set}; viewpoint {viewpoint}; shaded column: the tracer's own value");
    [scene_title(&what, view.group.scene), below]
}

/// The parameters that are not along the axes.
fn others(record: &Record, view: &View<'_>) -> String {
    let Some(point) = record.sweep.as_ref().and_then(|sweep| sweep.points.first()) else { return String::new() };
    let along = |name: &str| name == view.axis.name || view.other.is_some_and(|other| other.name == name);
    let parameters = point.parameters.iter().filter(|(name, _)| !along(name));
    let parts = parameters.map(|(name, v)| format!("{name}={}", cut(&said(v), LONGEST_VALUE))).join(", ");
    let size = (!along(RESOLUTION)).then(|| format!("frame {}, faces {}", format::size(point.frame), point.face));
    let told = [Some(parts).filter(|parts| !parts.is_empty()), size].into_iter().flatten().join("; ");
    if told.is_empty() { told } else { format!("Others: {told}. ") }
}

/// How often answers are wrong by the rule of a place.
fn wrong(trace: &TraceRecord, rule: usize) -> Option<Measured> {
    metrics::right_of(trace).get(rule)?.wrong_share()
}

/// A figure of one of a view's curves, in the order of the axis.
fn curve(
    view: &View<'_>,
    of: &sweep::Curve<'_>,
    style: Style,
    hollow: bool,
    aside: Aside,
    figure: impl Fn(&Row, &TraceRecord) -> Option<Measured>,
) -> Curve {
    let figure = |cell: &Cell<'_>| cell.measured.and_then(|(row, trace)| figure(row, trace));
    let at = |value: &String| of.cells.iter().find(|cell| cell.value == value).and_then(figure);
    let at = view.axis.values.iter().map(|value| at(value).filter(Measured::is_finite)).collect();
    Curve { style, hollow, aside, at }
}

/// The same of all curves, which have so many styles.
fn curves(
    view: &View<'_>,
    styles: &[Style],
    hollow: bool,
    figure: impl Fn(&Row, &TraceRecord) -> Option<Measured>,
) -> Vec<Curve> {
    let all = view.curves.iter().zip(styles).enumerate();
    all.map(|(order, (of, style))| curve(view, of, *style, hollow, Aside(order, styles.len()), &figure)).collect()
}

fn magnitudes(title: String, name: &str, values: &Values, curves: &[Curve]) -> Panel {
    let all = || measured(curves).map(|one| one.value);
    let (least, most) = all().minmax().into_option().unwrap_or_default();
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

fn memory(view: &View<'_>, values: &Values, styles: &[Style]) -> Panel {
    let mib = |bytes: u64| Some(Measured::exact(bytes as f64 / f64::from(1 << 20)));
    let mut all = curves(view, styles, true, |row, _| mib(metrics::used_bytes(row)));
    all.extend(curves(view, styles, false, |row, _| mib(row.memory.structure_bytes)));
    magnitudes("structure's memory".to_owned(), &STRUCTURE.axis(), values, &all)
}

fn build(view: &View<'_>, values: &Values, styles: &[Style]) -> Panel {
    let time = |row: &Row| {
        let Times { median_ms, interval_ms, samples_ms, .. } = row.build.first();
        (!samples_ms.is_empty()).then_some(Measured { value: *median_ms, interval: *interval_ms })
    };
    let title = format!("build: {}", clock_names(view, |row, _| row.build.first().clock));
    let all = curves(view, styles, false, |row, _| time(row));
    magnitudes(title, &BUILD_TIME.called("build").axis(), values, &all)
}

fn speed(view: &View<'_>, values: &Values, styles: &[Style]) -> Panel {
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

/// Errors, with those of controls by the rule of a place.
fn error_panel(view: &View<'_>, values: &Values, title: String, rule: usize, all: &[Curve]) -> Panel {
    let controls = view.group.traces(view.set).into_iter().filter(|(role, ..)| *role == Role::Control);
    let control = |(_, row, trace): (Role, &Row, &TraceRecord)| Some(level(row.label(), wrong(trace, rule)?.value));
    let name = match view.set.query {
        Query::Any => format!("1 − {} (%), log", BALANCED.label),
        Query::Closest => "wrong rays (%), log".to_owned(),
    };
    let one_ray = 1.0 / view.set.count.max(1) as f64;
    let scale = Scale::down_to(measured(all).map(|one| one.value).chain([one_ray]));
    values.panel(title, Axis { name, scale }, all, controls.filter_map(control).collect())
}
