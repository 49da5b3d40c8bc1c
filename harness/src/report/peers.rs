//! Tables whose rows are tracers at settings, over one run: `table_NAME.md` and `table_NAME.csv`.

use std::collections::BTreeSet;

use itertools::Itertools as _;

use super::document::Document;
use super::format::significant;
use super::group::{Group, RaySet, groups};
use super::means::{by_default, default_means, same_hits};
use super::metrics::{COUNT, SPEED, STRUCTURE};
use super::sheet::{self, Cell, Column, Columns, Sheet};
use super::{Report, cells, means, metrics, summary};
use crate::peers::{Rows, Table};
use crate::results::{Means, Run, Times, TraceRecord, TracerRun, host_ms};

/// Statistics of structures that have columns of their own on pages, by their names in `validate`.
const STATISTICS: [(&str, &str); 3] = [("references", "references"), ("nodes", "nodes"), ("sah_cost", "SAH cost ↓")];

/// A table: rows are the tracers that belong into it.
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

/// What rows of a table are set beside: headings, and names for programs.
fn besides(table: &Table) -> Vec<(String, Vec<&'static str>)> {
    let of_reference = format!("× {} ↑", table.reference());
    match table.rows {
        Rows::Peers { .. } => vec![(of_reference, vec!["speed_over_reference"])],
        Rows::Means => vec![(
            "× default ↑".to_owned(),
            vec!["speed_over_default", "speed_over_default_low", "speed_over_default_high"],
        )],
        Rows::Switches(_) => {
            vec![("× first ↑".to_owned(), vec!["speed_over_first"]), (of_reference, vec!["speed_over_peer"])]
        }
    }
}

/// How many times as fast a row traces a set as what it is set beside in that place.
fn over(table: &Table, run: &Run, place: usize, row: &Row<'_>) -> Cell {
    let reference = match table.rows {
        Rows::Means => by_default(run, row.group, row.run),
        Rows::Switches(_) if place == 0 => {
            row.group.contenders.iter().find(|other| other.tracer.name != table.reference()).copied()
        }
        _ => reference_of(table, row.group),
    };
    let (Some(reference), Some((set, trace))) = (reference, row.traced) else { return Cell::None };
    match table.rows {
        Rows::Peers { .. } => {
            let ratio = set.trace_of(reference).and_then(|other| ratio(Some(&other.times), &trace.times));
            Cell::number(ratio, 3)
        }
        Rows::Means | Rows::Switches(_) => set.paired(run, reference, row.run).and_then(|found| found.ratio).into(),
    }
}

/// A tracer with one of its traces; one without any has a structure all the same.
#[derive(Clone, Copy)]
struct Row<'a> {
    group: &'a Group<'a>,
    run: &'a TracerRun,
    traced: Option<(&'a RaySet<'a>, &'a TraceRecord)>,
}

impl<'a> Row<'a> {
    fn trace(&self) -> Option<&'a TraceRecord> {
        self.traced.map(|(_, trace)| trace)
    }
}

fn page(table: &Table, run: &Run, groups: &[Group<'_>]) -> Document {
    let words = match table.rows {
        Rows::Peers { .. } => format!(
            "× {0} is how many times as fast as {0} (its first row) a tracer is in the same run, both by the host's clock: work on \
             the host as it is timed, work on the device from submission until done (`submit_to_done_median_ms`). Rates of device \
             work beside them are by the clock that their row names. SAH cost: node visits and triangle tests that a random line \
             through the root is expected to take; nodes of different widths differ in what a visit costs.",
            table.reference()
        ),
        Rows::Means => default_means(run),
        Rows::Switches(_) => format!(
            "Rows are one switch after the other from the published form on, then the improved form, and that with single switches taken \
             back. × first and × {0} are how many times as fast a row is as the first one, and as {0} as published, in the same run.",
            table.reference()
        ),
    };
    let section = |group: &Group<'_>| {
        let of_set = |set: &RaySet<'_>| {
            let traces = traces(table, run, group, set);
            if table.rows == Rows::Means { traces.and(means::between(run, group, set)) } else { traces }
        };
        let sets = group.ray_sets.iter().map(of_set);
        Document::default().scene(2, group.scene, "").table(structures(table, group)).and(sets)
    };
    summary::head(run, &format!("Table {}: {}", table.name, table.summary))
        .words(words)
        .and(groups.iter().map(section))
        .and(summary::skipped(&run.skipped))
}

/// Columns of structures beside the reference's.
fn of_structures<'a, R>(
    sheet: Sheet<'a, R>,
    table: &'a Table,
    of: impl Fn(&R) -> &TracerRun + Copy + 'a,
    reference: impl Fn(&R) -> Option<&TracerRun> + Copy + 'a,
) -> Sheet<'a, R> {
    let over = move |row: &R| match table.rows {
        Rows::Peers { .. } => {
            Cell::number(ratio(reference(row).map(|run| run.build.first()), of(row).build.first()), 3)
        }
        Rows::Means | Rows::Switches(_) => Cell::Absent,
    };
    sheet
        .clock("build_clock", move |row| Some(of(row).build.first()))
        .builds("build", move |row| Some(of(row)))
        .and(
            Column::new("build_mtriangles_per_s", move |row| build_rate(of(row)))
                .beside(&["build_mtriangles_per_s_low", "build_mtriangles_per_s_high"])
                .headed("build rate (Mtriangles/s) ↑"),
        )
        .column("build_host_ms", move |row| host_ms(of(row).build.first()))
        .and(Column::new("build_speed_over_reference", over).headed(format!("× {} ↑", table.reference())))
        .structure(STRUCTURE, move |row| Some(of(row)))
        .column("bytes_per_triangle", move |row| bytes_per_triangle(of(row))[0])
        .column("used_bytes_per_triangle", move |row| bytes_per_triangle(of(row))[1])
        .told("bytes a triangle, used of them ↓", move |row| {
            bytes_per_triangle(of(row)).map(|bytes| significant(bytes, 4)).join(", ")
        })
        .with(statistics(of))
        .build_phases("phases of the build (ms)", ", ", of)
}

/// Statistics that no structure of a page tells have no column there.
fn statistics<'a, R>(of: impl Fn(&R) -> &TracerRun + Copy + 'a) -> Columns<'a, R> {
    let told = move |(name, heading): (&'static str, &'static str)| {
        Column::told(heading, move |row: &R| statistic_of(of(row), name).map_or(Cell::Absent, Cell::Statistic))
    };
    STATISTICS.map(told).into()
}

fn structures(table: &Table, group: &Group<'_>) -> sheet::Table {
    let reference = reference_of(table, group);
    // The launch shapes no structure.
    let told = |run: &TracerRun| match run.tracer.means().filter(|_| table.rows == Rows::Means) {
        Some(Means { reads, .. }) => format!("{} reads={reads}", run.tracer.name),
        None => run.label(),
    };
    let rows: Vec<&TracerRun> = group.contenders.iter().copied().unique_by(|run| told(run)).collect();
    let sheet = Sheet::<&TracerRun>::new()
        .told("tracer", |run| told(run))
        .then(|sheet| of_structures(sheet, table, |run| run, move |_| reference));
    sheet.table(&rows)
}

fn traces(table: &Table, run: &Run, group: &Group<'_>, set: &RaySet<'_>) -> Document {
    let beside = |(place, (heading, _)): (usize, (String, Vec<&str>))| {
        // A ratio is a speed: never without its accuracy.
        Column::told(heading, move |(_, of, trace): &cells::Row<'_>| {
            let row = Row { group, run: of, traced: Some((set, *trace)) };
            if metrics::judged(trace) { over(table, run, place, &row) } else { Cell::None }
        })
    };
    cells::traces(group, set, |sheet| {
        sheet.with(besides(table).into_iter().enumerate().map(beside).collect()).told("hits", move |(_, row, trace)| {
            if table.rows == Rows::Means { same_hits(group, set, row, trace) } else { Cell::Absent }
        })
    })
}

fn rows<'a>(groups: &'a [Group<'a>]) -> Vec<Row<'a>> {
    let of_run = |group: &'a Group<'a>, run: &'a TracerRun| {
        let set_of =
            |trace: &'a TraceRecord| group.ray_sets.iter().find(|set| set.holds(trace)).map(|set| (set, trace));
        let traced: Vec<_> = run.traces.iter().map(set_of).collect();
        let traced = if traced.is_empty() { vec![None] } else { traced };
        traced.into_iter().map(move |traced| Row { group, run, traced })
    };
    groups.iter().flat_map(|group| group.contenders.iter().flat_map(move |run| of_run(group, run))).collect()
}

fn csv(table: &Table, run: &Run, groups: &[Group<'_>]) -> sheet::Table {
    let names: BTreeSet<&String> = run.runs.iter().flat_map(|one| one.structure_statistics.keys()).collect();
    let statistic = |name: &&'_ String| {
        let name = (*name).clone();
        Column::new(format!("structure_{name}"), move |row: &Row<'_>| statistic_of(row.run, &name))
    };
    let means = |of: fn(Means) -> Cell| move |row: &Row<'_>| row.run.tracer.means().map_or(Cell::Absent, of);
    let beside = |(place, (_, names)): (usize, (String, Vec<&'static str>))| {
        Column::new(names[0], move |row: &Row<'_>| over(table, run, place, row)).beside(&names[1..])
    };
    let sheet = Sheet::<Row<'_>>::new()
        .scene(|row| &row.run.scene)
        .column("viewpoint", |row| row.run.viewpoint.name.clone())
        .tracer(|row| row.run)
        .column("reads", means(|means| means.reads.into()))
        .column("rays_per_lane", means(|means| means.rays_per_lane.into()))
        .column("residency", |row| row.run.tracer.residency.clone())
        .then(|sheet| of_structures(sheet, table, |row| row.run, |row| reference_of(table, row.group)))
        .rays(|row| row.trace())
        .query(|row| row.trace().map(|trace| trace.query))
        .trace(COUNT, |row| row.trace())
        .clock("clock", |row| row.trace().map(|trace| &trace.times))
        .whole_trace(SPEED, |row| row.trace())
        .column("trace_host_ms", |row| row.trace().and_then(|trace| host_ms(&trace.times)))
        .with(besides(table).into_iter().enumerate().map(beside).collect())
        .accuracy(|row| row.trace())
        .hits(|row| row.trace())
        .constant("reference", table.reference())
        .commit(&run.provenance)
        .constant("dirty", run.provenance.dirty)
        .constant("run_preset", &*run.preset)
        .machine_of(&run.provenance, |row| row.run)
        .with(names.iter().map(statistic).collect())
        .counters(&run.runs, |row| row.trace().map(|trace| &trace.counters));
    sheet.table(&rows(groups))
}
