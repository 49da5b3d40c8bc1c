//! The table of an ablation over one run: `table_NAME.md` and `table_NAME.csv`.

use std::fmt::Write as _;

use super::ReportError;
use super::group::{Group, RaySet, Role, TracedRow, groups, sections, traced_rows};
use super::metrics::{COUNT, SPEED};
use super::peers::stem;
use super::sheet::{Cell, Column, Sheet};
use super::{cells, metrics, summary};
use crate::ablation::peer;
use crate::contenders::Ablation;
use crate::results::{Ratio, Run, TracerRun};

/// Statistics of structures that have columns of their own.
const STATISTICS: [&str; 2] = ["references", "nodes"];

/// The files: name and contents.
pub(crate) fn files(ablation: &Ablation, run: &Run) -> Result<Vec<(String, Vec<u8>)>, ReportError> {
    let mut run = run.clone();
    run.runs.retain(|row| ablation.holds(&row.tracer.name));
    run.skipped.retain(|row| row.tracer.as_deref().is_none_or(|name| ablation.holds(name)));
    let groups = groups(&run);
    let stem = stem(ablation.name);
    let file = format!("{stem}.csv");
    let rows = csv(&file, &run, &groups)?;
    Ok(vec![(format!("{stem}.md"), page(ablation, &run, &groups).into_bytes()), (file, rows)])
}

/// The rows that times are set against: the first one of the tracer, as published, and the peer.
fn references<'a>(group: &Group<'a>) -> [Option<&'a TracerRun>; 2] {
    let name = peer().map_or("", |peer| peer.name());
    let is_peer = |row: &&TracerRun| row.tracer.name == name;
    let rows = || group.contenders.iter().copied();
    [rows().find(|row| !is_peer(row)), rows().find(is_peer)]
}

/// How many times as fast a row traces a set as another.
fn speed_over(run: &Run, set: &RaySet<'_>, reference: Option<&TracerRun>, row: &TracerRun) -> Option<Ratio> {
    set.paired(run, reference?, row)?.ratio
}

fn page(ablation: &Ablation, run: &Run, groups: &[Group<'_>]) -> String {
    let mut text = summary::head(run, &format!("Table {}: {}", ablation.name, ablation.summary));
    let name = peer().map_or("", |peer| peer.name());
    let _ = writeln!(
        text,
        "\nRows are one switch after the other from the published form on, then the improved form, and that with single switches taken \
         back. × first and × {name} are how many times as fast a row is as the first one, and as {name} as published, in the same run."
    );
    text + &sections(run, groups, structures, |group, set| traces(run, group, set))
}

fn structures(group: &Group<'_>) -> String {
    let sheet = Sheet::<&TracerRun>::new()
        .told("row", |row| row.label())
        .build(|row| Some(row))
        .then(|sheet| statistics(sheet, |row| row))
        .build_phases("phases of the build (ms)", ", ", |row| row);
    sheet.markdown(&group.contenders)
}

/// Statistics of structures.
fn statistics<'a, R>(sheet: Sheet<'a, R>, of: impl Fn(&R) -> &TracerRun + Copy + 'a) -> Sheet<'a, R> {
    let column = |name: &'static str| {
        let said = move |row: &R| of(row).structure_statistics.get(name).copied().map(Cell::Statistic);
        Column::new(name, said).headed(name)
    };
    sheet.with(STATISTICS.map(column).into())
}

fn traces(run: &Run, group: &Group<'_>, set: &RaySet<'_>) -> String {
    let all = group.traces(set);
    let rows: Vec<_> = all.iter().filter(|(role, ..)| *role == Role::Contender).copied().collect();
    let references = references(group);
    let over = |place: usize| {
        // A ratio is a speed: never without its accuracy.
        move |(_, row, trace): &cells::Row<'_>| {
            speed_over(run, set, references[place], row).filter(|_| metrics::judged(trace))
        }
    };
    let name = peer().map_or("", |peer| peer.name());
    let sheet = Sheet::<cells::Row<'_>>::new()
        .told("row", |(_, row, _)| row.label())
        .taken(SPEED, cells::own)
        .told("× first ↑", over(0))
        .told(format!("× {name} ↑"), over(1))
        .right(set.query, cells::own)
        .counted(&rows, cells::own);
    format!("\n### {}\n{}\n{}", set.heading(), cells::coverage(&all), sheet.markdown(&rows))
}

fn csv(file: &str, run: &Run, groups: &[Group<'_>]) -> Result<Vec<u8>, ReportError> {
    let over = |place: usize| {
        move |row: &TracedRow<'_>| {
            speed_over(run, row.set, references(row.group)[place], row.row).map(|ratio| ratio.value)
        }
    };
    let sheet = Sheet::<TracedRow<'_>>::new()
        .scene(|row| &row.row.scene)
        .column("viewpoint", |row| row.row.viewpoint.name.clone())
        .column("row", |row| row.row.label())
        .build(|row| Some(row.row))
        .then(|sheet| statistics(sheet, |row| row.row))
        .rays(|row| Some(row.trace))
        .trace(COUNT, |row| Some(row.trace))
        .clock("clock", |row| Some(&row.trace.times))
        .trace(SPEED, |row| Some(row.trace))
        .column("speed_over_first", over(0))
        .column("speed_over_peer", over(1))
        .accuracy(|row| Some(row.trace))
        .hits(|row| Some(row.trace))
        .commit(&run.provenance)
        .machine_of(&run.provenance, |row| row.row)
        .counters(&run.runs, |row| Some(&row.trace.counters));
    sheet.csv(file, &traced_rows(groups))
}
