//! Whether a tracer has any wrong ray: every ray set from five viewpoints of every scene.

use itertools::Itertools as _;

use tracebench_api::Preset;

use crate::plan::{Plan, ViewRequest};
use crate::registry;
use crate::report::document::Document;
use crate::report::metrics::{Traced, wrong_tight};
use crate::report::sheet::{Cell, Sheet};
use crate::report::summary;
use crate::results::{Record, Row, TraceRecord};

/// From so many viewpoints a scene is seen.
const VIEWPOINTS: usize = 5;

/// Its stable name.
pub const NAME: &str = "exact";
/// What it shows, in one line.
pub(super) const SUMMARY: &str =
    "whether a tracer has any wrong ray: every ray set from five viewpoints of every scene, with status 1 if it has";
/// What is set where nothing else is said: no ray set of it is to outweigh the others.
pub const SETTINGS: [&str; 1] = ["rays.pixel_random_count=2"];

/// The tracer where none is named: the first with analytic hits whose weaknesses a remedy sequence takes away, as improved.
pub fn tracer() -> String {
    let first = registry::first(|each| each.is_analytic() && !each.remedies.is_empty());
    first.map_or_else(String::new, |first| format!("{}:{}", first.name(), Preset::Improved.name()))
}

/// A plan from each viewpoint: the scene's own cameras first, then others on the circle through its default one.
pub fn plans(plan: &Plan) -> Vec<Plan> {
    (0..VIEWPOINTS).map(|place| Plan { view: ViewRequest::Nth(place, VIEWPOINTS), ..plan.clone() }).collect()
}

/// That rays are wrong: `table` fails with it.
pub fn fault(record: &Record) -> Option<String> {
    let wrong = counts(record.rows.iter().flat_map(|row| &row.traces))[1];
    (wrong > 0).then(|| format!("{wrong} rays are wrong under `tight`"))
}

/// Rays, wrong rays under `tight` and ambiguous rays of some traces.
fn counts<'a>(traces: impl IntoIterator<Item = &'a TraceRecord>) -> [u64; 3] {
    let of =
        |TraceRecord { count, judgement, .. }: &TraceRecord| [*count, wrong_tight(judgement), judgement.ambiguous()];
    let add = |sums: [u64; 3], trace: [u64; 3]| std::array::from_fn(|place| sums[place] + trace[place]);
    traces.into_iter().map(of).fold([0; 3], add)
}

/// Its page below a title.
pub(super) fn page(record: &Record, title: &str) -> Document {
    let rows: Vec<Traced<'_>> =
        record.rows.iter().flat_map(|row| row.traces.iter().map(move |trace| (row, trace))).collect();
    let [count, wrong, ambiguous_rays] = counts(rows.iter().map(|(_, trace)| *trace));
    let told = |count: u64| Cell::Count(count).describe();
    let by_view = Sheet::<Row>::new()
        .column("scene", |row| Cell::Name(row.scene.name.clone()))
        .column("viewpoint", |row| Cell::Name(row.viewpoint.name.clone()))
        .column("tracer", |row| row.label())
        .column("sets of rays", |row| row.traces.len() as u64)
        .column("rays", |row| counts(&row.traces)[0])
        .column("wrong ↓", |row| counts(&row.traces)[1])
        .column("ambiguous", |row| counts(&row.traces)[2]);
    let by_set = Sheet::<Traced<'_>>::new()
        .column("scene", |(row, _)| Cell::Name(row.scene.name.clone()))
        .column("viewpoint", |(row, _)| Cell::Name(row.viewpoint.name.clone()))
        .column("tracer", |(row, _)| row.label())
        .column("rays", |(_, trace)| trace.rays.clone())
        .column("wrong of", |(_, trace)| counts([*trace])[..2].iter().rev().map(|count| told(*count)).join(" of "));
    let wrong_sets: Vec<Traced<'_>> = rows.iter().filter(|(_, trace)| counts([*trace])[1] > 0).copied().collect();
    let words = format!(
        "**{} of {} rays are wrong under `tight`**, ambiguous ones included; {} are ambiguous.",
        told(wrong),
        told(count),
        told(ambiguous_rays)
    );
    summary::head(record, title)
        .paragraph(words)
        .heading(2, "By viewpoint")
        .table(by_view.table(&record.rows))
        .below("Sets with wrong rays:", by_set.table(&wrong_sets))
        .and(summary::skipped(&record.skipped))
}
