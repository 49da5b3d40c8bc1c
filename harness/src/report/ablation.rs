//! The table of an ablation over one run: `table_NAME.md` and `table_NAME.csv`.

use super::Report;
use super::document::Document;
use super::group::{Group, RaySet, TracedRow, groups, sections, traced, traced_rows};
use super::metrics::{COUNT, SPEED};
use super::peers::stem;
use super::sheet::{Cell, Column, Sheet, Table};
use super::{cells, metrics, summary};
use crate::ablation::peer;
use crate::contenders::Ablation;
use crate::results::{Ratio, Run, TracerRun};

/// Statistics of structures that have columns of their own.
const STATISTICS: [&str; 2] = ["references", "nodes"];

/// The table.
pub(crate) fn report(ablation: &Ablation, run: &Run) -> Report {
    let mut run = run.clone();
    run.runs.retain(|row| ablation.holds(&row.tracer.name));
    run.skipped.retain(|row| row.tracer.as_deref().is_none_or(|name| ablation.holds(name)));
    let groups = groups(&run);
    Report::of_table(&stem(ablation.name), page(ablation, &run, &groups), csv(&run, &groups))
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

fn page(ablation: &Ablation, run: &Run, groups: &[Group<'_>]) -> Document {
    let name = peer().map_or("", |peer| peer.name());
    let how = format!(
        "Rows are one switch after the other from the published form on, then the improved form, and that with single switches taken \
         back. × first and × {name} are how many times as fast a row is as the first one, and as {name} as published, in the same run."
    );
    summary::head(run, &format!("Table {}: {}", ablation.name, ablation.summary)).words(how).and(sections(
        run,
        groups,
        structures,
        |group, set| traces(run, group, set),
    ))
}

fn structures(group: &Group<'_>) -> Table {
    let sheet = Sheet::<&TracerRun>::new()
        .told("tracer", |row| row.label())
        .build(|row| Some(row))
        .then(|sheet| statistics(sheet, |row| row))
        .build_phases("phases of the build (ms)", ", ", |row| row);
    sheet.table(&group.contenders)
}

/// Statistics of structures.
fn statistics<'a, R>(sheet: Sheet<'a, R>, of: impl Fn(&R) -> &TracerRun + Copy + 'a) -> Sheet<'a, R> {
    let column = |name: &'static str| {
        let said = move |row: &R| of(row).structure_statistics.get(name).copied().map(Cell::Statistic);
        Column::new(name, said).headed(name)
    };
    sheet.with(STATISTICS.map(column).into())
}

fn traces(run: &Run, group: &Group<'_>, set: &RaySet<'_>) -> Document {
    let references = references(group);
    let over = |place: usize| {
        // A ratio is a speed: never without its accuracy.
        let reference = references[place];
        move |(_, row, trace): &cells::Row<'_>| speed_over(run, set, reference, row).filter(|_| metrics::judged(trace))
    };
    let name = peer().map_or("", |peer| peer.name());
    cells::traces(group, set, |sheet| sheet.told("× first ↑", over(0)).told(format!("× {name} ↑"), over(1)))
}

fn csv(run: &Run, groups: &[Group<'_>]) -> Table {
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
        .then(|sheet| traced(sheet, run));
    sheet.table(&traced_rows(groups))
}
