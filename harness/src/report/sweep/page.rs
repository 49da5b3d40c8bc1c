//! `sweep.md`.

use super::{Cell, Curve, View};
use crate::report::chart::{self, Drawing};
use crate::report::document::Document;
use crate::report::group::Role;
use crate::report::metrics::{BUILD_TIME, SPEED, STRUCTURE, USED};
use crate::report::sheet::{self, Sheet};
use crate::report::{cells, summary};
use crate::results::Record;
use crate::results::SweepRecord;
use crate::studies::sweep::RESOLUTION;

/// The whole page.
pub(super) fn page(record: &Record, sweep: &SweepRecord, views: &[View<'_>]) -> Document {
    let own = sweep.axes.iter().map(|axis| format!("{}={}", axis.name, axis.own));
    let mut page = summary::head(record, &format!("Sweep of {}", sweep.tracer)).paragraph(format!(
        "{} points; {}. The tracer's own values, with an asterisk below: {}. All points were measured in turn, sample by sample.",
        sweep.points.len(),
        if sweep.grid { "all combinations of two parameters" } else { "one parameter changed at a time" },
        own.collect::<Vec<_>>().join(", "),
    ));
    let mut scene = "";
    let mut axis = "";
    for view in views {
        let here = view.group.stem.as_str();
        if here != scene {
            page = page.scene(2, view.group.scene, "");
            (scene, axis) = (here, "");
        }
        if view.axis.name != axis {
            page = page.heading(3, &view.axis.name).paragraph(format!("{}.", view.axis.effect));
            axis = &view.axis.name;
        }
        page = page.and(section(record, view));
    }
    page.and(summary::skipped(&record.skipped))
}

fn section(record: &Record, view: &View<'_>) -> Document {
    let set = view.set;
    let all: Vec<_> = view.curves.iter().flat_map(|curve| &curve.cells).collect();
    let rows: Vec<_> =
        all.iter().filter_map(|cell| cell.measured).map(|(row, trace)| (Role::Tracer, row, trace)).collect();
    let scene = &view.group.scene.name;
    let mut sheet = Sheet::<Place<'_>>::new();
    if let Some(other) = view.other {
        sheet = sheet.column(&other.name, |(curve, _)| curve.other.map(str::to_owned));
    }
    sheet = sheet.column(&view.axis.name, |(_, cell)| {
        format!("{}{}", cell.value, if cell.value == view.axis.own { " *" } else { "" })
    });
    if [Some(view.axis), view.other].iter().flatten().any(|axis| axis.name == RESOLUTION) {
        sheet = sheet.column("frame, faces (px)", |(_, cell)| {
            let [width, height] = cell.point.frame;
            format!("{width}×{height}, {}", cell.point.face)
        });
    }
    let sheet = sheet
        .metric(STRUCTURE, |(_, cell): &Place<'_>| match cell.measured {
            Some((record, _)) => Some(sheet::Cell::Bytes(record.memory.structure_bytes as f64)),
            None => cell.point.skipped.contains_key(scene).then(|| "skipped, see below".into()),
        })
        .structure(USED, |row| row.1.measured.map(|(row, _)| row))
        .clock("build_clock", |row| row.1.measured.map(|(row, _)| row.build.first()))
        .builds(BUILD_TIME.label, |row| row.1.measured.map(|(row, _)| row))
        .own_clock(measured)
        .taken(SPEED, measured)
        .right(set.query, measured)
        // How much of what is stored rays touched.
        .counted_that(true, &rows, measured);
    let places: Vec<Place<'_>> =
        view.curves.iter().flat_map(|curve| curve.cells.iter().map(move |cell| (curve, cell))).collect();
    let drawing = Drawing::Panels(chart::sweep::chart(record, view));
    set.headed(4, "")
        .chart(view.stem(), format!("{} over {}", set.title, view.axis.name), drawing)
        .paragraph(cells::coverage(&rows))
        .table(sheet.table(&places))
}

/// A place along a curve.
type Place<'a> = (&'a Curve<'a>, &'a Cell<'a>);

fn measured<'a>((_, cell): &'a Place<'_>) -> Option<cells::TableRow<'a>> {
    cell.measured.map(|(row, trace)| (Role::Tracer, row, trace))
}
