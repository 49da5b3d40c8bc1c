//! `sweep.md`.

use std::fmt::Write as _;

use super::{Cell, Curve, View};
use crate::report::format::thousands;
use crate::report::group::Role;
use crate::report::markdown::{inline, literal};
use crate::report::metrics::{BUILD_TIME, SPEED, STRUCTURE, USED};
use crate::report::sheet::{self, Sheet};
use crate::report::{cells, summary};
use crate::results::Run;
use crate::results::SweepRecord;
use crate::studies::sweep::RESOLUTION;

/// The whole page.
pub(super) fn page(run: &Run, sweep: &SweepRecord, views: &[View<'_>]) -> String {
    let mut text = summary::head(run, &format!("Sweep of {}", inline(&sweep.tracer)));
    let _ = writeln!(
        text,
        "\n{} points; {}. The tracer's own values, with an asterisk below: {}. All points were measured in turn, \
         sample by sample.",
        sweep.points.len(),
        if sweep.grid { "all combinations of two parameters" } else { "one parameter changed at a time" },
        sweep
            .axes
            .iter()
            .map(|axis| format!("{}={}", inline(&axis.name), inline(&axis.own)))
            .collect::<Vec<_>>()
            .join(", "),
    );
    let mut scene = "";
    let mut axis = "";
    for view in views {
        let here = view.group.stem.as_str();
        if here != scene {
            let name = literal(&view.group.scene.name);
            let _ = writeln!(text, "\n## {name} ({} triangles)", thousands(view.group.scene.triangles));
            (scene, axis) = (here, "");
        }
        if view.axis.name != axis {
            let _ = writeln!(text, "\n### {}\n\n{}.", inline(&view.axis.name), inline(&view.axis.effect));
            axis = &view.axis.name;
        }
        text += &section(view);
    }
    text + &summary::skipped(&run.skipped)
}

fn section(view: &View<'_>) -> String {
    let set = view.set;
    let title = set.heading();
    let mut text =
        format!("\n#### {title}\n\n![{} over {}]({}.svg)\n", inline(&set.title), inline(&view.axis.name), view.stem());
    let all: Vec<_> = view.curves.iter().flat_map(|curve| &curve.cells).collect();
    let rows: Vec<_> =
        all.iter().filter_map(|cell| cell.measured).map(|(run, trace)| (Role::Contender, run, trace)).collect();
    text += &cells::coverage(&rows);
    let scene = &view.group.scene.name;
    let mut sheet = Sheet::<Place<'_>>::new();
    if let Some(other) = view.other {
        sheet = sheet.told(&other.name, |(curve, _)| curve.other.map(str::to_owned));
    }
    sheet = sheet.told(&view.axis.name, |(_, cell)| {
        format!("{}{}", cell.value, if cell.value == view.axis.own { " *" } else { "" })
    });
    if [Some(view.axis), view.other].iter().flatten().any(|axis| axis.name == RESOLUTION) {
        sheet = sheet.told("frame, faces (px)", |(_, cell)| {
            let [width, height] = cell.point.frame;
            format!("{width}×{height}, {}", cell.point.face)
        });
    }
    let sheet = sheet
        .metric(STRUCTURE, |(_, cell): &Place<'_>| match cell.measured {
            Some((run, _)) => Some(sheet::Cell::Bytes(run.memory.structure_bytes as f64)),
            None => cell.point.skipped.contains_key(scene).then(|| "skipped, see below".into()),
        })
        .structure(USED, |row| row.1.measured.map(|(run, _)| run))
        .clock("build_clock", |row| row.1.measured.map(|(run, _)| run.build.first()))
        .builds(BUILD_TIME.label, |row| row.1.measured.map(|(run, _)| run))
        .own_clock(measured)
        .taken(SPEED, measured)
        .right(set.query, measured)
        // How much of what is stored rays touched.
        .counted_that(true, &rows, measured);
    let places: Vec<Place<'_>> =
        view.curves.iter().flat_map(|curve| curve.cells.iter().map(move |cell| (curve, cell))).collect();
    let _ = write!(text, "\n{}", sheet.markdown(&places));
    text
}

/// A place along a curve.
type Place<'a> = (&'a Curve<'a>, &'a Cell<'a>);

fn measured<'a>((_, cell): &'a Place<'_>) -> Option<cells::Row<'a>> {
    cell.measured.map(|(run, trace)| (Role::Contender, run, trace))
}
