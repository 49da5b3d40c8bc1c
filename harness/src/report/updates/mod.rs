//! The table of structures that follow animations; along the camera's path that of [`walk`].

mod walk;

use std::ptr;

use crate::report::document::{Document, set_heading};
use crate::report::format;
use crate::report::group::{Role, groups};
use crate::report::metrics::{SPEED, STRUCTURE};
use crate::report::sheet::{Cell, Sheet, Table};
use crate::report::tables::Placed;
use crate::report::{Report, cells, metrics, peers, rows, summary};
use crate::results::{FRESH_BUILD, Record, Row, SceneFollowed, TraceRecord, UpdatesRecord, time_ratio};
use itertools::Itertools as _;

/// The statistic of structures that tells their quality, by its name in `validate`.
const SAH_COST: &str = "sah_cost";

/// The table.
pub(super) fn report(record: &Record, updates: &UpdatesRecord) -> Report {
    // The name comes from a file.
    let name = format::file_stem(record.table.as_deref().unwrap_or("updates"));
    let page_name = format!("{}.md", peers::stem(&name));
    if updates.scenes.iter().any(|scene| !scene.frame_scene_sha256.is_empty()) {
        walk::rows(record, updates).and(Report::of_page(page_name, walk::page(record, updates)))
    } else {
        let (groups, scenes) = (groups(record), scenes(record, updates));
        rows(record, &groups, own(), |row| row_of(&scenes, row)).and(Report::of_page(page_name, page(record, updates)))
    }
}

/// A scene that was followed, with its rows.
struct Followed<'a> {
    times_s: &'a [f64],
    rows: Vec<&'a Row>,
}

/// Every scene that has rows.
fn scenes<'a>(record: &'a Record, updates: &'a UpdatesRecord) -> Vec<Followed<'a>> {
    let of_scene = |scene: &'a SceneFollowed| {
        let is_of = |row: &&Row| (&row.scene.name, &row.scene.sha256) == (&scene.scene, &scene.scene_sha256);
        Followed { times_s: &scene.times_s, rows: record.rows.iter().filter(is_of).collect() }
    };
    updates.scenes.iter().map(of_scene).filter(|scene| !scene.rows.is_empty()).collect()
}

fn update_mode(row: &Row) -> &str {
    row.update_mode.as_ref().map_or(FRESH_BUILD, |update_mode| &update_mode.name)
}

/// The fresh build of a row's tracer.
fn fresh_of<'a>(scene: &Followed<'a>, row: &Row) -> Option<&'a Row> {
    scene.rows.iter().find(|other| update_mode(other) == FRESH_BUILD && other.tracer == row.tracer).copied()
}

fn sah_cost(row: &Row) -> Option<f64> {
    row.structure_statistics.get(SAH_COST).copied()
}

/// The title, and where it was measured.
fn head(record: &Record, title: &str) -> Document {
    let smoke = if record.preset == "smoke" { " (smoke run: figures only show that things work)" } else { "" };
    Document::titled(&format!("Table {}: {title}", record.table.as_deref().unwrap_or_default()))
        .item(format!("Machine: {}", record.provenance.machine.label()))
        .item(format!("Commit: {}", format::commit(&record.provenance.commit, record.provenance.dirty)))
        .item(format!("Rules: version {}", record.provenance.rules_version))
        .item(format!("Preset: {}{smoke}", record.preset))
        .item(format!("Started: {}", record.provenance.started))
        .and(summary::notes(record))
}

fn page(record: &Record, updates: &UpdatesRecord) -> Document {
    let head = head(record, "structures that follow animations").paragraph(format!(
        "Every structure is built over the first frame and follows {} frames, evenly over the animation (to its \
         middle, where it comes back to its start), in {} counted passes. Times \
         are medians over all updates with an order-statistic interval in brackets; each names its clock. At the last frame \
         all trace the same rays, beside a fresh build over that frame: × fresh is the ratio to that build's time or speed, \
         by the clock of both, else by the host's. The controls score what they must, else there would be no table.",
        updates.frames, updates.passes
    ));
    let section = |scene: &Followed<'_>| {
        let until = format!("To {} s.", scene.times_s.last().copied().unwrap_or_default());
        let sets = ray_sets(scene).map(|(rays, sha256)| traces(scene, rays, sha256));
        Document::default().scene(2, &scene.rows[0].scene, "").paragraph(until).table(structures(scene)).and(sets)
    };
    head.and(scenes(record, updates).iter().map(section)).and(summary::skipped(&record.skipped))
}

/// A scene's row with one of its traces.
struct TableRow<'a> {
    scene: &'a Followed<'a>,
    row: &'a Row,
    trace: &'a TraceRecord,
}

impl TableRow<'_> {
    fn on_page(&self) -> Option<cells::TableRow<'_>> {
        Some((Role::Tracer, self.row, self.trace))
    }

    /// How many times as fast the trace is as that of a fresh build.
    fn speed_over_fresh(&self) -> Option<f64> {
        let fresh = fresh_of(self.scene, self.row)?;
        let beside = trace_of(fresh, &self.trace.rays, &self.trace.rays_sha256)?;
        time_ratio(&self.trace.times, &beside.times).map(|slower| 1.0 / slower)
    }
}

/// What its last update took over the time of a fresh build.
fn time_over_fresh(row: &Row, fresh: Option<&Row>) -> Option<Cell> {
    time_ratio(row.build.first(), fresh?.build.first()).map(|ratio| Cell::Number(ratio, 3))
}

fn cost_over_fresh(row: &Row, fresh: Option<&Row>) -> Option<f64> {
    Some(sah_cost(row)? / sah_cost(fresh?)?)
}

fn row_of<'a>(scenes: &'a [Followed<'a>], (.., (_, row, trace)): &Placed<'a>) -> Option<TableRow<'a>> {
    let scene = scenes.iter().find(|scene| scene.rows.iter().any(|own| ptr::eq(*own, *row)))?;
    Some(TableRow { scene, row, trace })
}

/// What is told of rows beside fresh builds.
fn own<'a>() -> Sheet<'a, TableRow<'a>> {
    Sheet::<TableRow<'_>>::new()
        .csv_column("update_time_over_fresh", |row| time_over_fresh(row.row, fresh_of(row.scene, row.row)))
        .csv_column("sah_cost_over_fresh", |row| cost_over_fresh(row.row, fresh_of(row.scene, row.row)))
        .csv_column("speed_over_fresh", TableRow::speed_over_fresh)
}

const OVER_FRESH: &str = "× fresh";

fn structures(scene: &Followed<'_>) -> Table {
    let rows: Vec<_> = scene.rows.iter().map(|row| (*row, fresh_of(scene, row))).collect();
    let sheet = Sheet::<(&Row, Option<&Row>)>::new()
        .column("tracer", |(row, _)| row.label())
        .column("update mode", |(row, _)| update_mode(row).to_owned())
        .clock("clock", |(row, _)| Some(row.build.first()))
        .column("update time (ms) ↓", |(row, _)| row.build.first())
        .column(OVER_FRESH, |(row, fresh)| time_over_fresh(row, *fresh))
        .column("SAH cost ↓", |(row, _)| sah_cost(row))
        .column(OVER_FRESH, |(row, fresh)| cost_over_fresh(row, *fresh))
        .structure(STRUCTURE, |(row, _)| Some(row));
    sheet.table(&rows)
}

/// Names and hashes of the ray sets, in order of first appearance.
fn ray_sets<'a>(scene: &Followed<'a>) -> impl Iterator<Item = (&'a String, &'a String)> {
    let traces = scene.rows.iter().flat_map(|row| &row.traces);
    traces.map(|trace| (&trace.rays, &trace.rays_sha256)).unique()
}

fn trace_of<'a>(row: &'a Row, rays: &str, sha256: &str) -> Option<&'a TraceRecord> {
    row.traces.iter().find(|trace| trace.rays == rays && trace.rays_sha256 == sha256)
}

fn traces(scene: &Followed<'_>, rays: &str, sha256: &str) -> Document {
    let traced = scene.rows.iter().filter_map(|row| Some((*row, trace_of(row, rays, sha256)?)));
    let found: Vec<cells::TableRow<'_>> = traced.map(|(row, trace)| (Role::Tracer, row, trace)).collect();
    let Some((.., first)) = found.first() else { return Document::default() };
    let rows: Vec<TableRow<'_>> = found.iter().map(|(_, row, trace)| TableRow { scene, row, trace }).collect();
    let sheet = Sheet::<TableRow<'_>>::new()
        .name(TableRow::on_page)
        .column("update mode", |row| update_mode(row.row).to_owned())
        .own_clock(TableRow::on_page)
        .taken(SPEED, TableRow::on_page)
        .column("× fresh ↑", |row| {
            row.speed_over_fresh().filter(|_| metrics::judged(row.trace)).map(|ratio| Cell::Number(ratio, 3))
        })
        .right(first.query, TableRow::on_page)
        // Those of a whole set are no cost of a ray.
        .counted_that(false, &found, TableRow::on_page);
    Document::default().rays(3, rays, set_heading(rays, first.query, first.count)).table(sheet.table(&rows))
}
