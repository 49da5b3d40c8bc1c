//! Whether any ray is wrong: `table_exact.md`.

use itertools::Itertools as _;

use super::document::Document;
use super::metrics::wrong_tight;
use super::sheet::{Cell, Sheet};
use super::{Report, peers, summary};
use crate::results::{Run, TraceRecord, TracerRun};

/// A tracer with one of its traces.
type Row<'a> = (&'a TracerRun, &'a TraceRecord);

/// Rays, wrong rays under `tight` and ambiguous rays of some traces.
fn counts<'a>(traces: impl IntoIterator<Item = &'a TraceRecord>) -> [u64; 3] {
    let of =
        |TraceRecord { count, judgement, .. }: &TraceRecord| [*count, wrong_tight(judgement), judgement.ambiguous()];
    let add = |sums: [u64; 3], trace: [u64; 3]| std::array::from_fn(|place| sums[place] + trace[place]);
    traces.into_iter().map(of).fold([0; 3], add)
}

/// Wrong rays of a whole run.
pub fn wrong_rays(run: &Run) -> u64 {
    counts(run.runs.iter().flat_map(|row| &row.traces))[1]
}

/// The table.
pub(crate) fn report(name: &str, title: &str, run: &Run) -> Report {
    let rows: Vec<Row<'_>> = run.runs.iter().flat_map(|row| row.traces.iter().map(move |trace| (row, trace))).collect();
    Report::of_page(format!("{}.md", peers::stem(name)), page(title, run, &rows))
}

fn page(title: &str, run: &Run, rows: &[Row<'_>]) -> Document {
    let [count, wrong, ties] = counts(rows.iter().map(|(_, trace)| *trace));
    let told = |count: u64| Cell::Count(count).told();
    let by_view = Sheet::<&TracerRun>::new()
        .told("scene", |row| Cell::Name(row.scene.name.clone()))
        .told("viewpoint", |row| Cell::Name(row.viewpoint.name.clone()))
        .told("tracer", |row| row.label())
        .told("sets of rays", |row| row.traces.len() as u64)
        .told("rays", |row| counts(&row.traces)[0])
        .told("wrong ↓", |row| counts(&row.traces)[1])
        .told("ambiguous", |row| counts(&row.traces)[2]);
    let by_set = Sheet::<Row<'_>>::new()
        .told("scene", |(row, _)| Cell::Name(row.scene.name.clone()))
        .told("viewpoint", |(row, _)| Cell::Name(row.viewpoint.name.clone()))
        .told("tracer", |(row, _)| row.label())
        .told("rays", |(_, trace)| trace.rays.clone())
        .told("wrong of", |(_, trace)| counts([*trace])[..2].iter().rev().map(|count| told(*count)).join(" of "));
    let wrong_sets: Vec<Row<'_>> = rows.iter().filter(|(_, trace)| counts([*trace])[1] > 0).copied().collect();
    let words = format!(
        "**{} of {} rays are wrong under `tight`**, ambiguous ones included; {} are ambiguous.",
        told(wrong),
        told(count),
        told(ties)
    );
    summary::head(run, title)
        .words(words)
        .heading(2, "By viewpoint")
        .table(by_view.table(&run.runs.iter().collect::<Vec<_>>()))
        .below("Sets with wrong rays:", by_set.table(&wrong_sets))
        .and(summary::skipped(&run.skipped))
}
