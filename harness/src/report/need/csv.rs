//! The table of steps: a row a scene, viewpoint, tracer, ray set and structure.

use super::value_of;
use crate::report::metrics::STRUCTURE;
use crate::report::sheet::{Cell, Column, Sheet, Table};
use crate::results::{ChangedRays, Run};
use crate::studies::need::{Curve, Step};

/// A structure beside the whole one.
pub(super) struct Row<'a> {
    pub curve: &'a Curve<'a>,
    pub step: &'a Step<'a>,
    /// What it has less of, for people.
    pub less: String,
}

/// The steps of a curve.
pub(super) fn steps<'a>(curve: &'a Curve<'a>) -> impl Iterator<Item = Row<'a>> {
    let single = curve
        .axes
        .iter()
        .flat_map(|axis| axis.steps.iter().map(move |step| (format!("{}={}", axis.name, value_of(axis, step)), step)));
    let all = single.chain(curve.joint.iter().map(|step| (step.point.label(), step)));
    all.map(move |(less, step)| Row { curve, step, less })
}

/// What a smaller structure has, loses and takes.
pub(super) fn of_steps<'a>(sheet: Sheet<'a, Row<'a>>) -> Sheet<'a, Row<'a>> {
    let changed = |of: fn(ChangedRays) -> u64| move |row: &Row<'a>| row.step.changed.map(of);
    let lost = |row: &Row<'a>| row.step.lost().map(|(value, interval)| Cell::Percent(value, interval));
    let enough = |row: &Row<'a>| row.step.changed.map(|_| row.step.is_enough());
    let enough_in_time = |row: &Row<'a>| row.step.changed.map(|_| row.step.is_enough_in_time());
    let times_as_long = Column::new("times_as_long", |row: &Row<'a>| row.step.times_as_long);
    sheet
        .and(STRUCTURE.of_structure(|row: &Row<'a>| row.step.row).headed("MiB ↓"))
        .column("touched_bytes", |row| row.step.touched_bytes())
        .column("compared_rays", changed(|changed| changed.rays))
        .column("newly_wrong_rays", changed(|changed| changed.newly_wrong))
        .column("newly_right_rays", changed(|changed| changed.newly_right))
        .and(Column::new("lost_share", lost).beside(&["lost_low_share", "lost_high_share"]).headed("rays lost (%) ↓"))
        .and(Column::new("is_enough", enough).headed("enough"))
        .and(times_as_long.beside(&["times_as_long_low", "times_as_long_high"]).headed("times as long ↓"))
        .and(Column::new("is_enough_in_time", enough_in_time).headed("enough in time"))
}

/// The whole table.
pub(super) fn table<'a>(run: &Run, curves: &'a [Curve<'a>]) -> Table {
    let whole = |curve: &'a Curve<'a>| Row { curve, step: &curve.whole, less: String::new() };
    let rows: Vec<Row<'_>> =
        curves.iter().flat_map(|curve| std::iter::once(whole(curve)).chain(steps(curve))).collect();
    let sheet = Sheet::<Row<'_>>::new()
        .scene_of(|row| (&row.curve.record.scene, &row.curve.record.scene_sha256))
        .column("viewpoint", |row| row.curve.record.viewpoint.clone())
        .column("is_own_viewpoint", |row| row.curve.record.view == 0)
        .column("tracer", |row| row.curve.record.tracer.clone())
        .column("preset", |row| row.curve.record.preset.clone())
        .column("rule", |row| row.curve.record.rule.name())
        .column("rays", |row| row.curve.rays.to_owned())
        .json("shrunk_json", |row| &row.step.point.shrunk)
        .json("parameters_json", |row| &row.step.point.parameters)
        .sizes(|row| (row.step.point.frame, row.step.point.face))
        .column("skipped", |row| row.step.point.skipped.clone())
        .then(of_steps)
        .provenance(&run.provenance, &run.preset);
    sheet.table(&rows)
}
