//! Tables whose rows are tracers at settings, over one run: `table_NAME.md`.

use itertools::Itertools as _;

use super::document::Document;
use super::format::significant;
use super::group::{Group, RaySet, groups};
use super::means::{by_default, default_means, same_hits};
use super::metrics::{BUILD_RATE, STRUCTURE};
use super::sheet::{self, Cell, Column, Sheet};
use super::tables::Placed;
use super::{Report, cells, means, metrics, rows, summary};
use crate::peers::{Rows, Table};
use crate::results::{Means, Run, Times, TracerRun, host_ms};

/// Statistics of structures that have columns of their own on pages, by their names in `validate`.
const STATISTICS: [(&str, &str); 3] = [("references", "references"), ("nodes", "nodes"), ("sah_cost", "SAH cost ↓")];

/// A table: rows are the tracers that belong into it.
pub(crate) fn report(table: &Table, run: &Run) -> Report {
    let all = groups(run);
    let besides_of_rows = rows(run, &all, own(table, run), |row| table.holds(&row.2.1.tracer.name).then_some(*row));
    let mut run = run.clone();
    run.runs.retain(|one| table.holds(&one.tracer.name));
    // What follows a name is a preset, or what was set.
    let is_held = |label: &str| table.holds(label.split([':', ' ']).next().unwrap_or_default());
    run.skipped.retain(|one| one.tracer.as_deref().is_none_or(is_held));
    let groups = groups(&run);
    Report::of_page(format!("{}.md", stem(table.name)), page(table, &run, &groups)).and(besides_of_rows)
}

/// What the files of a table are called, without their ends.
pub(crate) fn stem(name: &str) -> String {
    format!("table_{}", name.replace('-', "_"))
}

/// How many times as fast as the reference, both by the host's clock.
fn ratio(reference: Option<&Times>, own: &Times) -> Option<f64> {
    Some(host_ms(reference?)? / host_ms(own)?)
}

/// The reference of a group: as published where that ran, since it comes first.
fn reference_of<'a>(table: &Table, group: &Group<'a>) -> Option<&'a TracerRun> {
    group.contenders.iter().find(|run| run.tracer.name == table.reference()).copied()
}

/// What rows of a table are set beside: headings, and names for programs.
fn besides(table: &Table) -> Vec<(String, &'static str)> {
    let of_reference = format!("× {} ↑", table.reference());
    match table.rows {
        Rows::Peers { .. } => vec![(of_reference, "speed_over_reference")],
        Rows::Means => vec![("× default ↑".to_owned(), "speed_over_default")],
        Rows::Switches(_) => vec![("× first ↑".to_owned(), "speed_over_first"), (of_reference, "speed_over_peer")],
    }
}

/// How many times as fast a row traces a set as what it is set beside in that place.
fn over(table: &Table, run: &Run, place: usize, (group, set, (_, row, trace)): &Placed<'_>) -> Cell {
    let is_first = |other: &&&TracerRun| table.holds(&other.tracer.name) && other.tracer.name != table.reference();
    let reference = match table.rows {
        Rows::Means => by_default(run, group, row),
        Rows::Switches(_) if place == 0 => group.contenders.iter().find(is_first).copied(),
        _ => reference_of(table, group),
    };
    let Some(reference) = reference else { return Cell::None };
    match table.rows {
        Rows::Peers { .. } => {
            let ratio = set.trace_of(reference).and_then(|other| ratio(Some(&other.times), &trace.times));
            Cell::number(ratio, 3)
        }
        Rows::Means | Rows::Switches(_) => set.paired(run, reference, row).and_then(|found| found.ratio).into(),
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

/// How many times as fast the reference is built as something else; only peers are set beside it.
fn build_over(table: &Table, row: &TracerRun, reference: Option<&TracerRun>) -> Cell {
    match table.rows {
        Rows::Peers { .. } => Cell::number(ratio(reference.map(|run| run.build.first()), row.build.first()), 3),
        Rows::Means | Rows::Switches(_) => Cell::Absent,
    }
}

fn structures(table: &Table, group: &Group<'_>) -> sheet::Table {
    let reference = reference_of(table, group);
    // The launch shapes no structure.
    let told = |run: &TracerRun| match run.tracer.means().filter(|_| table.rows == Rows::Means) {
        Some(Means { reads, .. }) => format!("{} reads={reads}", run.tracer.name),
        None => run.label(),
    };
    let rows: Vec<&TracerRun> = group.contenders.iter().copied().unique_by(|run| told(run)).collect();
    let statistic = |(name, heading)| {
        let of = move |run: &&TracerRun| run.structure_statistics.get(name).copied();
        Column::told(heading, move |run| of(run).map_or(Cell::Absent, Cell::Statistic))
    };
    let sheet = Sheet::<&TracerRun>::new()
        .told("tracer", |run| told(run))
        .clock("build_clock", |run| Some(run.build.first()))
        .builds("build", |run| Some(run))
        .structure(BUILD_RATE, |run| Some(run))
        .told(format!("× {} ↑", table.reference()), |run| build_over(table, run, reference))
        .structure(STRUCTURE, |run| Some(run))
        .told("bytes a triangle, used of them ↓", |run| {
            metrics::per_triangle(run).map(|bytes| significant(bytes, 4)).join(", ")
        })
        // Statistics that no structure of a page tells have no column there.
        .with(STATISTICS.map(statistic).into())
        .build_phases("phases of the build (ms)", ", ", |run| run);
    sheet.table(&rows)
}

fn traces(table: &Table, run: &Run, group: &Group<'_>, set: &RaySet<'_>) -> Document {
    let beside = |(place, (heading, _)): (usize, (String, &str))| {
        // A ratio is a speed: never without its accuracy.
        Column::told(heading, move |row: &cells::Row<'_>| {
            if metrics::judged(row.2) { over(table, run, place, &(group, set, *row)) } else { Cell::None }
        })
    };
    cells::traces(group, set, |sheet| {
        sheet.with(besides(table).into_iter().enumerate().map(beside).collect()).told("hits", move |(_, row, trace)| {
            if table.rows == Rows::Means { same_hits(group, set, row, trace) } else { Cell::Absent }
        })
    })
}

/// What is told of rows beside others.
fn own<'a>(table: &'a Table, run: &'a Run) -> Sheet<'a, Placed<'a>> {
    let beside = |(place, (_, name)): (usize, (String, &'static str))| {
        Column::new(name, move |row: &Placed<'_>| over(table, run, place, row))
    };
    Sheet::<Placed<'_>>::new()
        .column("build_speed_over_reference", |(group, _, (_, row, _))| {
            build_over(table, row, reference_of(table, group))
        })
        .with(besides(table).into_iter().enumerate().map(beside).collect())
}
