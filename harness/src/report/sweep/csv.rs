//! `sweep.csv`: a row a scene, axis, value and ray set, also of what was skipped.

use super::{Cell, View};
use crate::report::metrics::{Traced, USED};
use crate::report::sheet::{Sheet, Table};
use crate::results::Run;
use crate::results::SweepRecord;

type Row<'a> = (&'a View<'a>, &'a Cell<'a>);

fn measured<'a>((_, cell): &'a Row<'_>) -> Option<Traced<'a>> {
    cell.measured
}

/// The whole table.
pub(super) fn table<'a>(run: &Run, sweep: &SweepRecord, views: &'a [View<'a>]) -> Table {
    let of_view = |view: &'a View<'a>| {
        view.curves.iter().flat_map(|curve| &curve.cells).map(move |cell| (view, cell)).collect::<Vec<_>>()
    };
    let rows: Vec<Row<'a>> = views.iter().flat_map(of_view).collect();
    let sheet = Sheet::<Row<'_>>::new()
        .scene(|(view, _)| view.group.scene)
        .column("viewpoint", |(view, _)| view.group.viewpoint.name.clone())
        .column("tracer", |_| sweep.tracer.clone())
        .column("parameter", |(view, _)| view.axis.name.clone())
        .column("unit", |(view, _)| view.axis.unit.clone())
        .column("value", |(_, cell)| cell.value.to_owned())
        .column("is_own", |(view, cell)| cell.value == view.axis.own)
        .json("values_json", |(_, cell)| &cell.point.values)
        .json("parameters_json", |(_, cell)| &cell.point.parameters)
        .sizes(|(_, cell)| (cell.point.frame, cell.point.face))
        .column("rays", |(view, _)| view.set.title.clone())
        .query(|(view, _)| Some(view.set.query))
        .column("skipped", |(view, cell)| cell.point.skipped.get(&view.group.scene.name).cloned())
        .column("rays_sha256", |row| measured(row).map(|(_, trace)| trace.rays_sha256.clone()))
        .hits(|row| measured(row).map(|(_, trace)| trace))
        .clock("clock", |row| measured(row).map(|(_, trace)| &trace.times))
        .clock("build_clock", |row| measured(row).map(|(run, _)| run.build.first()))
        .structure(USED, |row| measured(row).map(|(run, _)| run))
        .provenance(&run.provenance, &run.preset)
        .metrics(&run.runs, measured);
    sheet.table(&rows)
}
