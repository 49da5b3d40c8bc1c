//! The charts, each as SVG and PNG from one drawing.

mod axis;
pub(super) mod break_even;
mod canvas;
mod curves;
pub(super) mod difficulty;
mod frame;
mod front;
mod palette;
mod panel;
mod scale;
pub(super) mod scatter;
pub(crate) mod series;
pub(super) mod speed;
pub(super) mod sweep;
#[cfg(test)]
mod tests;
pub(super) mod tolerance;
pub(super) mod tune;

use itertools::Itertools as _;
use tracebench_api::Query;

use super::format;
use super::group::{Group, RaySet};
use super::metrics::BALANCED;
use super::pareto::{as_read, rays_a_pixel};
use super::verdict::{self, Verdict};
use super::{Contents, ReportError};
use crate::results::{ParetoRecord, Provenance, Record, Row};
use crate::studies::pareto::{Amount, By, Cost, Field};
pub(super) use canvas::DrawError;
pub use canvas::without_images;
use front::{FrontFigure, PanelOf};
pub(super) use front::{FrontLayers, FrontStyles, PointMark};
use series::SeriesChart;
#[cfg(test)]
pub(super) use tests::{check_png, check_svg};

/// The most characters of a scene's name in a title.
const LONGEST_NAME: usize = 32;
/// The most characters of a ray set's name in a panel's title.
const LONGEST_SET: usize = 16;
/// The most characters of a tracer's name in a legend.
const LONGEST_TRACER: usize = 64;

/// The most characters of a parameter's name or value.
const LONGEST_VALUE: usize = 32;

/// What the names of the charts' files begin with.
pub(super) const STEMS: [&str; 4] = ["error_vs_speed_", "agreement_over_tolerance_", super::sweep::STEM, "figure_"];

/// A chart as data.
#[derive(Debug)]
pub(crate) enum Drawing {
    /// Panels of marks.
    Panels(panel::Chart),
    /// Fronts.
    Fronts(FrontFigure),
    /// Values over settings, with its caption.
    Series(SeriesChart, String),
}

impl Drawing {
    /// As SVG.
    pub(super) fn svg(&self) -> Result<String, DrawError> {
        match self {
            Self::Panels(chart) => canvas::to_svg(chart),
            Self::Fronts(figure) => canvas::to_svg(figure),
            Self::Series(chart, caption) => canvas::to_svg(&series::figure(chart, caption)),
        }
    }

    /// A chart a tracer, where its panels are of tracers.
    pub(super) fn by_tracer(&self) -> Vec<(String, Self)> {
        let Self::Series(chart, caption) = self else { return Vec::new() };
        let parts = chart.by_tracer().into_iter();
        parts.map(|(tracer, part)| (tracer.to_owned(), Self::Series(part, caption.clone()))).collect()
    }

    /// As PNG.
    pub(super) fn png(&self) -> Result<Vec<u8>, DrawError> {
        match self {
            Self::Panels(chart) => canvas::to_png(chart),
            Self::Fronts(figure) => canvas::to_png(figure),
            Self::Series(chart, caption) => canvas::to_png(&series::figure(chart, caption)),
        }
    }
}

/// Charts as files, SVG and PNG.
pub(super) fn files<'a>(charts: impl Iterator<Item = (&'a str, &'a Drawing)>) -> Result<Contents, ReportError> {
    let mut files = Vec::new();
    for (stem, drawing) in charts {
        let fail = |error: DrawError| made(stem, &error);
        files.push((format!("{stem}.svg"), drawing.svg().map_err(fail)?.into_bytes()));
        files.push((format!("{stem}.png"), drawing.png().map_err(fail)?));
    }
    Ok(files)
}

/// The fronts of every cost over one ray set by one rule.
pub(super) fn fronts(record: &Record, section: &ParetoRecord, field: &Field<'_>, by: By) -> FrontFigure {
    let panel = |cost: Cost| PanelOf { title: front_title(cost), cost, entries: field.entries.clone() };
    let panels: Vec<PanelOf<'_>> = Cost::all(&section.rays_per_pixel).into_iter().map(panel).collect();
    let columns = if panels.len() > 4 { 3 } else { 2 };
    FrontFigure::new(record, field, by, "Fronts", panels, &FrontStyles::of(section), columns)
}

/// Those at matched bytes and build time, where there are any.
pub(super) fn matched_fronts(
    record: &Record,
    section: &ParetoRecord,
    field: &Field<'_>,
    by: By,
) -> Option<FrontFigure> {
    let panels: Vec<PanelOf<'_>> =
        [Cost::Bytes, Cost::Build].into_iter().flat_map(|cost| matched(field, cost)).collect();
    let what = "Fronts at matched bytes and build time";
    (!panels.is_empty()).then(|| FrontFigure::new(record, field, by, what, panels, &FrontStyles::of(section), 3))
}

/// The colours that causes and the like take in turn.
pub(super) fn colour(index: usize) -> String {
    palette::hex(palette::COLOURS[index % palette::COLOURS.len()])
}

pub(super) fn made(what: &str, error: &DrawError) -> ReportError {
    ReportError::NotMade { what: what.to_owned(), reason: error.to_string() }
}

fn front_title(cost: Cost) -> String {
    match cost {
        Cost::Trace => "speed".to_owned(),
        Cost::Build => "build time".to_owned(),
        Cost::Bytes => "bytes to trace".to_owned(),
        Cost::Frame(rays) => format!("frame of {}", rays_a_pixel(rays)),
    }
}

/// Panels of speed over the points that are within a budget, the least first.
fn matched<'a>(field: &Field<'a>, cost: Cost) -> Vec<PanelOf<'a>> {
    let panel = |budget: f64| {
        let read = format::significant(as_read(field, cost, Amount::exact(budget)).value, 2);
        let title = match cost {
            Cost::Bytes => format!("speed within {read} MiB"),
            _ => format!("speed within a build of {read} ms"),
        };
        PanelOf { title, cost: Cost::Trace, entries: field.within(cost, budget) }
    };
    field.budgets(cost).into_iter().map(panel).collect()
}

/// The title of a group's chart, and the line under it.
fn titles(what: &str, record: &Record, group: &Group<'_>) -> [String; 2] {
    let [width, height] = group.viewpoint.ray_image;
    let triangles = format::thousands(group.scene.triangles);
    let name = cut(&group.scene.name, LONGEST_NAME);
    let invalid = if verdict::controls(record) == Verdict::Sound { "" } else { "VOID, CONTROLS FAIL: " };
    [
        format!("{what}: {name} ({triangles} triangles)"),
        format!("{invalid}viewpoint {}; rays from the pixels of a {width} × {height} image", group.viewpoint.name),
    ]
}

/// Where, from what and how often a group was measured.
fn caption(record: &Record, group: &Group<'_>) -> String {
    let samples = group.configs.iter().flat_map(|one| &one.traces).map(|trace| trace.times.samples_ms.len());
    let (fewest, most) = samples.fold((usize::MAX, 0), |(low, high), count| (low.min(count), high.max(count)));
    let samples = match (fewest, most) {
        (_, 0) => "nothing timed".to_owned(),
        (1, 1) => "1 sample".to_owned(),
        (fewest, most) if fewest == most => format!("{most} samples"),
        (fewest, most) => format!("{fewest} to {most} samples"),
    };
    let smoke = if record.preset == "smoke" { " (figures only show that things work)" } else { "" };
    let clocks = clocks(group);
    let clocks = match clocks.as_slice() {
        [] => String::new(),
        [clock] => format!("; clock: {clock}"),
        several => format!("; clocks: {} (times of different clocks do not compare)", several.join(", ")),
    };
    let commit = format::commit(&record.provenance.commit, record.provenance.dirty);
    // The machine last: its name is the one that can be too long for the page.
    let machine = record.provenance.machine.label();
    format!("Commit {commit}; preset {}{smoke}; {samples}{clocks}. Machine: {machine}.", record.preset)
}

/// The clocks that timed a group's configurations.
fn clocks(group: &Group<'_>) -> Vec<&'static str> {
    let traces = group.configs.iter().flat_map(|row| &row.traces);
    traces.map(|trace| format::clock(trace.times.clock)).unique().collect()
}

/// Where and by what figures were made that are no times.
fn untimed_caption(from: &Provenance, preset: &str) -> String {
    let smoke = if preset == "smoke" { " (figures only show that things work)" } else { "" };
    let commit = format::commit(&from.commit, from.dirty);
    format!("Commit {commit}; preset {preset}{smoke}. Machine: {}.", from.machine.label())
}

fn name_with_unit(name: &str, unit: &str) -> String {
    let name = cut(name, LONGEST_VALUE);
    if unit.is_empty() { name } else { format!("{name} ({unit})") }
}

/// What an axis of wrong answers is called.
fn error_name(query: Query) -> String {
    match query {
        Query::Closest => "wrong rays, 1 − agreement (%)".to_owned(),
        Query::Any => format!("1 − {} (%)", BALANCED.label),
    }
}

/// A panel's title.
fn panel_title(set: &RaySet<'_>) -> String {
    let (name, count) = (cut(&set.title, LONGEST_SET), format::thousands(set.count));
    format!("{name}: {}, {count} rays", format::query(set.query))
}

/// A configuration's name in a legend, with its clock where clocks differ.
fn legend_label(row: &Row, clocks: &[&str]) -> String {
    let label = cut(&row.label(), LONGEST_TRACER);
    match row.traces.first() {
        Some(trace) if clocks.len() > 1 => format!("{label} [{}]", format::clock(trace.times.clock)),
        _ => label,
    }
}

/// A name cut to so many characters, so that what must stand beside it has room.
fn cut(name: &str, most: usize) -> String {
    if name.chars().count() <= most {
        return name.to_owned();
    }
    let kept: String = name.chars().take(most).collect();
    format!("{}…", kept.trim_end())
}
