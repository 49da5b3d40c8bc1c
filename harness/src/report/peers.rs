//! Tables of peers over one run: `table_NAME.md` and `table_NAME.csv`.

use std::collections::BTreeSet;

use super::Report;
use super::document::Document;
use super::format::significant;
use super::group::{Group, RaySet, groups, sections};
use super::metrics::{COUNT, SPEED, STEADY_BUILD, STRUCTURE};
use super::sheet::{self, Cell, Column, Sheet};
use super::{cells, metrics, summary};
use crate::peers::Table;
use crate::results::host_ms;
use crate::results::{Run, Times, TraceRecord, TracerRun};

/// Statistics of structures that have columns of their own, by their names in `validate`.
const NODES: &str = "nodes";
const SAH_COST: &str = "sah_cost";

/// A table: rows are the tracers of its family.
pub(crate) fn report(table: &Table, run: &Run) -> Report {
    let mut run = run.clone();
    run.runs.retain(|one| table.holds(&one.tracer.name));
    // What follows a name is a preset, or what was set.
    let is_held = |label: &str| table.holds(label.split([':', ' ']).next().unwrap_or_default());
    run.skipped.retain(|one| one.tracer.as_deref().is_none_or(is_held));
    let groups = groups(&run);
    Report::of_table(&stem(table.name), page(table, &run, &groups), csv(table, &run, &groups))
}

/// What the files of a table are called, without their ends.
pub(crate) fn stem(name: &str) -> String {
    format!("table_{}", name.replace('-', "_"))
}

/// How many times as fast as the reference, both by the host's clock.
fn ratio(reference: Option<&Times>, own: &Times) -> Option<f64> {
    Some(host_ms(reference?)? / host_ms(own)?)
}

/// Millions of triangles a second at the median and at the ends of its interval.
fn build_rate(run: &TracerRun) -> Option<Cell> {
    let times = run.build.first();
    let rate = |ms: f64| run.scene.triangles as f64 / (ms * 1e3);
    let [fast, slow] = times.interval_ms;
    (!times.samples_ms.is_empty() && fast > 0.0)
        .then(|| Cell::Measured(rate(times.median_ms), Some([rate(slow), rate(fast)]), 4))
}

fn statistic_of(run: &TracerRun, name: &str) -> Option<f64> {
    run.structure_statistics.get(name).copied()
}

/// Bytes of the structure a triangle: allocated, and used of them.
fn bytes_per_triangle(run: &TracerRun) -> [f64; 2] {
    [run.memory.structure_bytes, metrics::used_bytes(run)].map(|bytes| bytes as f64 / run.scene.triangles.max(1) as f64)
}

/// The reference of a group: as published where that ran, since it comes first.
fn reference_of<'a>(table: &Table, group: &Group<'a>) -> Option<&'a TracerRun> {
    group.contenders.iter().find(|run| run.tracer.name == table.reference()).copied()
}

fn page(table: &Table, run: &Run, groups: &[Group<'_>]) -> Document {
    let how = format!(
        "× {0} is how many times as fast as {0} (its first row) a tracer is in the same run, both by the host's clock: work on \
         the host as it is timed, work on the device from submission until done (`submit_to_done_median_ms`). Rates of device \
         work beside them are by the clock that their row names. SAH cost: node visits and triangle tests that a random line \
         through the root is expected to take; nodes of different widths differ in what a visit costs.",
        table.reference()
    );
    let sections = sections(run, groups, |group| structures(table, group), |group, set| traces(table, group, set));
    summary::head(run, &format!("Table {}: {}", table.name, table.summary)).words(how).and(sections)
}

/// Columns of structures beside the reference's.
fn of_structures<'a, R>(
    sheet: Sheet<'a, R>,
    table: &'a Table,
    of: impl Fn(&R) -> &TracerRun + Copy + 'a,
    reference: impl Fn(&R) -> Option<&TracerRun> + Copy + 'a,
) -> Sheet<'a, R> {
    let over = move |row: &R| ratio(reference(row).map(|run| run.build.first()), of(row).build.first());
    let over = move |row: &R| over(row).map(|ratio| Cell::Number(ratio, 3));
    sheet
        .clock("build_clock", move |row| Some(of(row).build.first()))
        .and(
            Column::new("build_mtriangles_per_s", move |row| build_rate(of(row)))
                .beside(&["build_mtriangles_per_s_low", "build_mtriangles_per_s_high"])
                .headed("build rate (Mtriangles/s) ↑"),
        )
        .column("build_host_ms", move |row| host_ms(of(row).build.first()))
        .structure(STEADY_BUILD, move |row| Some(of(row)))
        .and(Column::new("build_speed_over_reference", over).headed(format!("× {} ↑", table.reference())))
        .told("nodes", move |row| statistic_of(of(row), NODES).map(Cell::Statistic))
        .structure(STRUCTURE, move |row| Some(of(row)))
        .column("bytes_per_triangle", move |row| bytes_per_triangle(of(row))[0])
        .column("used_bytes_per_triangle", move |row| bytes_per_triangle(of(row))[1])
        .told("bytes a triangle, used of them ↓", move |row| {
            bytes_per_triangle(of(row)).map(|bytes| significant(bytes, 4)).join(", ")
        })
        .told("SAH cost ↓", move |row| statistic_of(of(row), SAH_COST))
}

fn structures(table: &Table, group: &Group<'_>) -> sheet::Table {
    let reference = reference_of(table, group);
    let sheet = Sheet::<&TracerRun>::new()
        .told("tracer", |run| run.label())
        .then(|sheet| of_structures(sheet, table, |run| run, move |_| reference));
    sheet.table(&group.contenders)
}

fn traces(table: &Table, group: &Group<'_>, set: &RaySet<'_>) -> Document {
    let beside = reference_of(table, group).and_then(|run| set.trace_of(run));
    cells::traces(group, set, |sheet| {
        // A ratio is a speed: never without its accuracy.
        sheet.told(format!("× {} ↑", table.reference()), move |(.., trace)| {
            let ratio = ratio(beside.map(|trace| &trace.times), &trace.times).filter(|_| metrics::judged(trace));
            ratio.map(|ratio| Cell::Number(ratio, 3))
        })
    })
}

/// A tracer with one of its traces; one without any has a structure all the same.
struct Row<'a> {
    run: &'a TracerRun,
    trace: Option<&'a TraceRecord>,
    reference: Option<&'a TracerRun>,
    /// The same rays traced by the reference.
    beside: Option<&'a TraceRecord>,
}

fn rows<'a>(table: &Table, groups: &[Group<'a>]) -> Vec<Row<'a>> {
    let mut rows = Vec::new();
    for group in groups {
        let reference = reference_of(table, group);
        for run in group.contenders.iter().copied() {
            let traces: Vec<Option<&TraceRecord>> = match run.traces.as_slice() {
                [] => vec![None],
                traces => traces.iter().map(Some).collect(),
            };
            rows.extend(traces.into_iter().map(|trace| {
                let beside = trace.and_then(|trace| {
                    let same =
                        |other: &&TraceRecord| other.rays_sha256 == trace.rays_sha256 && other.rays == trace.rays;
                    reference?.traces.iter().find(same)
                });
                Row { run, trace, reference, beside }
            }));
        }
    }
    rows
}

fn csv(table: &Table, run: &Run, groups: &[Group<'_>]) -> sheet::Table {
    let statistics: BTreeSet<&String> = run.runs.iter().flat_map(|one| one.structure_statistics.keys()).collect();
    let statistic = |name: &&'_ String| {
        let name = (*name).clone();
        Column::new(format!("structure_{name}"), move |row: &Row<'_>| statistic_of(row.run, &name))
    };
    let sheet = Sheet::<Row<'_>>::new()
        .scene(|row| &row.run.scene)
        .column("viewpoint", |row| row.run.viewpoint.name.clone())
        .tracer(|row| row.run)
        .column("residency", |row| row.run.tracer.residency.clone())
        .then(|sheet| of_structures(sheet, table, |row| row.run, |row| row.reference))
        .rays(|row| row.trace)
        .query(|row| row.trace.map(|trace| trace.query))
        .trace(COUNT, |row| row.trace)
        .clock("clock", |row| row.trace.map(|trace| &trace.times))
        .whole_trace(SPEED, |row| row.trace)
        .column("trace_host_ms", |row| row.trace.and_then(|trace| host_ms(&trace.times)))
        .column("speed_over_reference", |row| ratio(row.beside.map(|trace| &trace.times), &row.trace?.times))
        .accuracy(|row| row.trace)
        .constant("reference", table.reference())
        .whole_provenance(run, None)
        .with(statistics.iter().map(statistic).collect())
        .counters(&run.runs, |row| row.trace.map(|trace| &trace.counters));
    sheet.table(&rows(table, groups))
}
