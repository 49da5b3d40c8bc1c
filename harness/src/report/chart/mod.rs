//! The charts, each as SVG and PNG from one drawing.

pub(super) mod break_even;
mod canvas;
mod curves;
pub(super) mod difficulty;
mod frame;
pub(super) mod front;
mod palette;
mod panel;
pub(super) mod runs;
mod scale;
pub(crate) mod series;
pub(super) mod sweep;
#[cfg(test)]
mod tests;

use std::error::Error;

use itertools::Itertools as _;
use tracebench_api::Query;

use super::document::set_heading;
use super::format;
use super::group::{Group, RaySet};
use super::metrics::BALANCED;
use super::verdict;
use super::{Contents, ReportError};
use crate::results::{Record, Row, SceneRecord};
use crate::studies::pareto::Field;
pub(super) use canvas::SCALE;
pub use canvas::without_images;
pub(crate) use frame::Chart;
pub(super) use palette::hex;
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

/// Charts as files, SVG and PNG.
pub(super) fn files<'a>(charts: impl Iterator<Item = (&'a str, &'a Chart)>) -> Result<Contents, ReportError> {
    let mut files = Vec::new();
    for (stem, chart) in charts {
        let drawn = chart.drawn();
        files.push((format!("{stem}.svg"), drawn.svg().into_bytes()));
        let fail = |error: Box<dyn Error>| ReportError::NotMade(stem.to_owned(), error.to_string());
        files.push((format!("{stem}.png"), drawn.png().map_err(fail)?));
    }
    Ok(files)
}

/// The colours that causes and the like take in turn.
pub(super) fn colour(index: usize) -> String {
    hex(palette::colour(index))
}

/// What stands before all else where controls fail.
fn invalid(failed: &[String]) -> &'static str {
    if failed.is_empty() { "" } else { "VOID, CONTROLS FAIL: " }
}

fn scene_title(what: &str, scene: &SceneRecord) -> String {
    format!("{what}: {} ({} triangles)", cut(&scene.name, LONGEST_NAME), format::thousands(scene.triangles))
}

/// The title of a group's chart, and the line under it.
fn titles(what: &str, record: &Record, group: &Group<'_>) -> [String; 2] {
    let [width, height] = group.viewpoint.ray_image;
    let (invalid, viewpoint) = (invalid(&verdict::controls(record)), &group.viewpoint.name);
    let below = format!("{invalid}viewpoint {viewpoint}; rays from the pixels of a {width} × {height} image");
    [scene_title(what, group.scene), below]
}

/// The title of a chart of a ray set of a study of fronts.
fn field_title(what: &str, field: &Field<'_>) -> String {
    let rays = cut(field.rays, LONGEST_SET);
    format!("{}, {rays}, {}", scene_title(what, &field.scene.scene), format::query(field.query))
}

/// Where and by what figures of fronts were made.
fn fronts_caption(record: &Record) -> String {
    let clock = "Times by the host's clock, of work on a device from submission until done.";
    format!("{clock} {}", caption_with(record, ""))
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
    let clocks = clocks(group);
    let clocks = match clocks.as_slice() {
        [] => String::new(),
        [clock] => format!("; clock: {clock}"),
        several => format!("; clocks: {} (times of different clocks do not compare)", several.join(", ")),
    };
    caption_with(record, &format!("; {samples}{clocks}"))
}

/// The clocks that timed a group's configurations.
fn clocks(group: &Group<'_>) -> Vec<&'static str> {
    let traces = group.configs.iter().flat_map(|row| &row.traces);
    traces.map(|trace| format::clock(trace.times.clock)).unique().collect()
}

/// Where and by what figures were made, and more.
fn caption_with(record: &Record, more: &str) -> String {
    let Record { provenance: from, preset, .. } = record;
    let smoke = if preset == "smoke" { " (figures only show that things work)" } else { "" };
    let commit = format::commit(&from.commit, from.dirty);
    // The machine last: its name is the one that can be too long for the page.
    format!("Commit {commit}; preset {preset}{smoke}{more}. Machine: {}.", from.machine.label())
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
    set_heading(&cut(&set.title, LONGEST_SET), set.query, set.count)
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
