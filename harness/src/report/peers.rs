//! Tables whose rows are tracers at settings, over one run: `table_NAME.md`.

use itertools::Itertools as _;

use super::beside::{self, Place};
use super::document::Document;
use super::format::significant;
use super::group::{Group, RaySet, groups};
use super::metrics::{BUILD_RATE, SPEED, STRUCTURE};
use super::sheet::{self, Cell, Column, Sheet};
use super::tables::Placed;
use super::{Report, cells, metrics, rows, summary};
use crate::peers::{Rows, Table};
use crate::results::{LaunchSettings, Record, Row, Times, TraceRecord, host_ms};

/// Statistics of structures that have columns of their own on pages, by their names in `validate`.
const STATISTICS: [(&str, &str); 3] = [("references", "references"), ("nodes", "nodes"), ("sah_cost", "SAH cost ↓")];

/// A table: rows are the tracers that belong into it.
pub(crate) fn report(table: &Table, record: &Record) -> Report {
    let all = groups(record);
    let besides_of_rows =
        rows(record, &all, own(table, record), |row| table.holds(&row.2.1.tracer.name).then_some(*row));
    let mut record = record.clone();
    record.rows.retain(|one| table.holds(&one.tracer.name));
    // What follows a name is a preset, or what was set.
    let is_held = |label: &str| table.holds(label.split([':', ' ']).next().unwrap_or_default());
    record.skipped.retain(|one| one.tracer.as_deref().is_none_or(is_held));
    let groups = groups(&record);
    Report::of_page(super::table_page(table.name), page(table, &record, &groups)).and(besides_of_rows)
}

/// How many times as fast as the reference, both by the host's clock.
fn ratio(reference: Option<&Times>, own: &Times) -> Option<f64> {
    Some(host_ms(reference?)? / host_ms(own)?)
}

/// The reference of a group: as published where that ran, since it comes first.
fn reference_of<'a>(table: &Table, group: &Group<'a>) -> Option<&'a Row> {
    group.configs.iter().find(|row| row.tracer.name == table.reference()).copied()
}

/// What rows of a table are set beside: headings, and names for programs.
fn besides(table: &Table) -> Vec<(String, &'static str)> {
    let of_reference = format!("× {} ↑", table.reference());
    match table.rows {
        Rows::Peers { .. } => vec![(of_reference, "speed_over_reference")],
        Rows::LaunchSettings => vec![("× default ↑".to_owned(), "speed_over_default")],
        Rows::Switches(_) => vec![("× first ↑".to_owned(), "speed_over_first"), (of_reference, "speed_over_peer")],
    }
}

/// How many times as fast a row traces a set as what it is set beside in that place.
fn over(table: &Table, record: &Record, place: usize, (group, set, (_, row, trace)): &Placed<'_>) -> Cell {
    let is_first = |other: &&&Row| table.holds(&other.tracer.name) && other.tracer.name != table.reference();
    let reference = match table.rows {
        // The same tracer by the means that all take where nothing is set.
        Rows::LaunchSettings => record.provenance.launch.as_ref().and_then(|taken| {
            let is_default = |other: &&&Row| other.tracer.launch().as_ref() == Some(&taken.launch);
            group.configs.iter().filter(|other| other.tracer.name == row.tracer.name).find(is_default).copied()
        }),
        Rows::Switches(_) if place == 0 => group.configs.iter().find(is_first).copied(),
        _ => reference_of(table, group),
    };
    let Some(reference) = reference else { return Cell::None };
    match table.rows {
        Rows::Peers { .. } => {
            let ratio = set.trace_of(reference).and_then(|other| ratio(Some(&other.times), &trace.times));
            Cell::number(ratio, 3)
        }
        Rows::LaunchSettings | Rows::Switches(_) => {
            set.paired(record, reference, row).and_then(|found| found.ratio).into()
        }
    }
}

/// What the table is of, and what is taken where nothing is set.
fn default_launch(record: &Record) -> String {
    let text = "`memory_access` is what a search reads the structure from, `rays_per_lane` how many rays a lane answers one after the other; both are \
                the same choice for every tracer. × default is how many times as fast a row is as the same tracer by the means that are taken \
                here where nothing is set.";
    let Some(taken) = &record.provenance.launch else { return text.to_owned() };
    let told = taken.probe.as_ref().map(|probe| {
        let (texture, many) = (probe.texture_gain(), probe.many_rays_gain());
        let [texture, many] = [texture, many].map(|gain| significant(gain, 3));
        format!(
            ": in the probe textures were {texture} times as fast as buffers, {} rays a lane {many} times as one",
            probe.many_rays
        )
    });
    format!("{text} Default: {}{}.", taken.launch, told.unwrap_or_else(|| ", as given".to_owned()))
}

/// Whether a row answers as the first of its tracer does.
fn same_hits(group: &Group<'_>, set: &RaySet<'_>, row: &Row, trace: &TraceRecord) -> Cell {
    let of_tracer = |other: &&&Row| other.tracer.name == row.tracer.name;
    let first = group.configs.iter().filter(of_tracer).find_map(|other| set.trace_of(other));
    if first.is_none_or(|first| first.hits_sha256 == trace.hits_sha256) { "the same" } else { "OTHERS" }.into()
}

fn page(table: &Table, record: &Record, groups: &[Group<'_>]) -> Document {
    let words = match table.rows {
        Rows::Peers { .. } => format!(
            "× {0} is how many times as fast as {0} (its first row) a tracer is in the same run, both by the host's clock: work on \
             the host as it is timed, work on the device from submission until done (`submit_to_done_median_ms`). Rates of device \
             work beside them are by the clock that their row names. SAH cost: node visits and triangle tests that a random line \
             through the root is expected to take; nodes of different widths differ in what a visit costs.",
            table.reference()
        ),
        Rows::LaunchSettings => default_launch(record),
        Rows::Switches(_) => format!(
            "Rows are one switch after the other from the published form on, then the improved form, and that with single switches taken \
             back. × first and × {0} are how many times as fast a row is as the first one, and as {0} as published, in the same record.",
            table.reference()
        ),
    };
    let section = |group: &Group<'_>| {
        let of_set = |set: &RaySet<'_>| {
            let traces = traces(table, record, group, set);
            let beside = || beside::table(Place { record, group, set });
            if table.rows == Rows::LaunchSettings { traces.and(beside()) } else { traces }
        };
        let sets = group.ray_sets.iter().map(of_set);
        Document::default().scene(2, group.scene, "").table(structures(table, group)).and(sets)
    };
    summary::head(record, &format!("Table {}: {}", table.name, table.summary))
        .paragraph(words)
        .and(groups.iter().map(section))
        .and(summary::skipped(&record.skipped))
}

/// How many times as fast the reference is built as something else; only peers are set beside it.
fn build_over(table: &Table, row: &Row, reference: Option<&Row>) -> Cell {
    match table.rows {
        Rows::Peers { .. } => Cell::number(ratio(reference.map(|row| row.build.first()), row.build.first()), 3),
        Rows::LaunchSettings | Rows::Switches(_) => Cell::Absent,
    }
}

fn structures(table: &Table, group: &Group<'_>) -> sheet::Table {
    let reference = reference_of(table, group);
    // The launch shapes no structure.
    let told = |row: &Row| match row.tracer.launch().filter(|_| table.rows == Rows::LaunchSettings) {
        Some(LaunchSettings { memory_access, .. }) => format!("{} memory_access={memory_access}", row.tracer.name),
        None => row.label(),
    };
    let rows: Vec<&Row> = group.configs.iter().copied().unique_by(|row| told(row)).collect();
    let statistic = |(name, heading)| {
        let of = move |row: &&Row| row.structure_statistics.get(name).copied();
        Column::new(heading, move |row| of(row).map_or(Cell::Absent, Cell::Statistic))
    };
    let sheet = Sheet::<&Row>::new()
        .column("tracer", |row| told(row))
        .clock("build_clock", |row| Some(row.build.first()))
        .builds("build", |row| Some(row))
        .structure(BUILD_RATE, |row| Some(row))
        .column(format!("× {} ↑", table.reference()), |row| build_over(table, row, reference))
        .structure(STRUCTURE, |row| Some(row))
        .column("bytes a triangle, used of them ↓", |row| {
            metrics::per_triangle(row).map(|bytes| significant(bytes, 4)).join(", ")
        })
        // Statistics that no structure of a page tells have no column there.
        .with(STATISTICS.map(statistic).into())
        .build_phases("phases of the build (ms)", ", ", |row| row);
    sheet.table(&rows)
}

/// The traces of configurations over a ray set below its heading.
fn traces(table: &Table, record: &Record, group: &Group<'_>, set: &RaySet<'_>) -> Document {
    let beside = |(place, (heading, _)): (usize, (String, &str))| {
        // A ratio is a speed: never without its accuracy.
        Column::new(heading, move |row: &cells::TableRow<'_>| {
            if metrics::judged(row.2) { over(table, record, place, &(group, set, *row)) } else { Cell::None }
        })
    };
    let all = group.traces(set);
    let rows: Vec<cells::TableRow<'_>> = all.iter().copied().filter(cells::contends).collect();
    let sheet = Sheet::<cells::TableRow<'_>>::new()
        .name()
        .own_clock()
        .taken(SPEED)
        .with(besides(table).into_iter().enumerate().map(beside).collect())
        .column("hits", |(_, row, trace)| match table.rows {
            Rows::LaunchSettings => same_hits(group, set, row, trace),
            Rows::Peers { .. } | Rows::Switches(_) => Cell::Absent,
        })
        .right(set.query)
        .counted(&rows, |_| true);
    set.headed(3, "").paragraph(cells::coverage(&all)).table(sheet.table(&rows))
}

/// What is told of rows beside others.
fn own<'a>(table: &'a Table, record: &'a Record) -> Sheet<'a, Placed<'a>> {
    let beside = |(place, (_, name)): (usize, (String, &'static str))| {
        Column::csv(name, move |row: &Placed<'_>| over(table, record, place, row))
    };
    Sheet::<Placed<'_>>::new()
        .csv_column("build_speed_over_reference", |(group, _, (_, row, _))| {
            build_over(table, row, reference_of(table, group))
        })
        .with(besides(table).into_iter().enumerate().map(beside).collect())
}
