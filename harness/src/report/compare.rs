//! A comparison of two runs as text.

use itertools::Itertools as _;

use super::document::Document;
use super::format::{self, NONE, clock, optional, percent, significant, thousands};
use super::sheet::{Cell, Sheet, Table};
use crate::compare::{Accuracy, BuildRow, Changes, Comparison, Key, Shift, Side, Speed, TraceRow};
use crate::results::{MIN_ROUNDS, Movement};

/// The whole comparison, as Markdown.
pub fn comparison_text(comparison: &Comparison) -> String {
    let side = |(name, side): (&str, &Side)| {
        let Side { path, started, machine, .. } = side;
        format!("{name}: {path}, {started}, commit {}, {machine}", format::commit(&side.commit, side.dirty))
    };
    let sides = [("A", &comparison.a), ("B", &comparison.b)].map(side).into_iter();
    let items = sides.chain(comparison.differences.iter().map(|difference| format!("**differs**, {difference}")));
    let mut page = Document::titled("Comparison of two runs").items(items).paragraph(format!(
        "Ratios are speed of B over speed of A: below 1 is slower. Intervals combine order statistics of both; what they \
         cover stands beside. A time moved if its interval excludes 1 and the slower takes more than {threshold} % longer; it is within \
         {threshold} % if the whole interval is; else it is undecided, as it is with fewer than {MIN_ROUNDS} samples, with invalid \
         times, and where the fixed kernel tells of a machine that changed its speed. An accuracy moved if the 95 % intervals \
         are disjoint.",
        threshold = significant(comparison.threshold * 100.0, 3)
    ));
    page = page.and(moved(comparison));
    if comparison.is_empty() {
        page = page.paragraph("Nothing stands in both runs.");
    } else {
        page = page.heading(2, "Builds").table(builds(comparison));
        if !comparison.traces.is_empty() {
            page = page.heading(2, "Traces").table(traces(comparison));
        }
    }
    page.and([("A", &comparison.only_in_a), ("B", &comparison.only_in_b)].map(|(name, keys)| only(name, keys)))
        .markdown()
}

fn moved(comparison: &Comparison) -> Document {
    let mut lines = Vec::new();
    for row in &comparison.builds {
        let moved =
            |(build, speed): (&str, &Speed)| Some(format!("{}: {build} {}", row.key.sentence(), movement(speed)?));
        lines.extend(row.speeds().filter_map(moved));
    }
    for row in &comparison.traces {
        let shifts = row.accuracy.iter().filter_map(|accuracy| {
            let what = match accuracy.shift {
                Shift::Worse => "**less accurate**",
                Shift::Better => "more accurate",
                Shift::Same | Shift::Within => return None,
            };
            Some(format!("{what} by {}: {} wrong rays, were {}", accuracy.rule, accuracy.b_wrong, accuracy.a_wrong))
        });
        let said = movement(&row.speed).into_iter().chain(shifts);
        lines.extend(said.map(|what| format!("{}: {what}", row.key.sentence())));
    }
    let exact = |row: &&BuildRow| !row.bytes.is_empty() || !row.statistics.is_empty();
    let builds = comparison.builds.iter().filter(exact).count();
    let changed = |row: &&TraceRow| !row.same_hits || !row.bytes.is_empty() || !row.counters.is_empty();
    let traces = comparison.traces.iter().filter(changed).count();
    Document::default()
        .heading(2, "Moved beyond noise")
        .paragraph(if lines.is_empty() { "Nothing." } else { "" })
        .items(lines)
        .paragraph(format!(
            "Exactly changed: {builds} of {} structures (bytes, statistics), {traces} of {} traces (answers, bytes, counters).",
            comparison.builds.len(),
            comparison.traces.len()
        ))
}

fn movement(speed: &Speed) -> Option<String> {
    let ratio = speed.ratio?;
    let what = match speed.movement? {
        Movement::Slower => "**slower**",
        Movement::Faster => "faster",
        Movement::Within | Movement::Undecided => return None,
    };
    Some(format!("{what}, ratio {}", Cell::from(ratio).describe()))
}

/// With clock, times and ratio of a row, and what is to be said of it.
fn speed<'a, R>(sheet: Sheet<'a, R>, of: impl Fn(&R) -> &Speed + Copy + 'a) -> Sheet<'a, R> {
    let said = |speed: &Speed| match (speed.movement, speed.a_clock == speed.b_clock) {
        (_, false) => Some(format!("clocks differ: {} against {}", clock(speed.a_clock), clock(speed.b_clock))),
        (Some(Movement::Slower), _) => Some("**slower**".to_owned()),
        (Some(Movement::Faster), _) => Some("faster".to_owned()),
        (Some(Movement::Within), _) => Some("the same".to_owned()),
        (Some(Movement::Undecided), _) => {
            let reason = speed.undecided_because.as_deref().unwrap_or("the interval does not separate");
            Some(format!("undecided: {reason}"))
        }
        (None, _) => None,
    };
    sheet
        .column("clock", move |row| clock(of(row).a_clock))
        .column("A, B (ms)", move |row| [of(row).a_ms, of(row).b_ms].map(|ms| optional(ms, 4)).join(", "))
        .column("ratio", move |row| of(row).ratio)
        .column("coverage", move |row| of(row).ratio.map(|ratio| format!("{:.1} %", ratio.coverage * 100.0)))
        .column("time", move |row| said(of(row)))
}

fn changed(changes: &Changes) -> String {
    let value = |value: &Option<f64>| Cell::from(value.map(Cell::Statistic)).describe();
    let each = |(name, [a, b]): (&String, &[Option<f64>; 2])| format!("{name} {} → {}", value(a), value(b));
    if changes.is_empty() { "same".to_owned() } else { changes.iter().map(each).join("; ") }
}

fn builds(comparison: &Comparison) -> Table {
    let sheet = Sheet::<(&BuildRow, &str, &Speed)>::new()
        .column("scene", |(row, ..)| Cell::Name(row.key.scene.clone()))
        .column("tracer", |(row, ..)| row.key.tracer.clone())
        .column("what", |(_, what, _)| (*what).to_owned());
    let sheet = speed(sheet, |(.., speed)| speed)
        .column("bytes", |(row, ..)| changed(&row.bytes))
        .column("structure", |(row, ..)| changed(&row.statistics));
    let of_row = |row| BuildRow::speeds(row).map(move |(what, speed)| (row, what, speed));
    sheet.table(&comparison.builds.iter().flat_map(of_row).collect_vec())
}

fn traces(comparison: &Comparison) -> Table {
    let sheet = Sheet::<TraceRow>::new()
        .column("scene", |row| Cell::Name(row.key.scene.clone()))
        .column("tracer", |row| row.key.tracer.clone())
        .column("rays", |row| row.key.rays.clone().unwrap_or_default());
    // No speed stands without its accuracy.
    speed(sheet, |row| &row.speed)
        .column("accuracy, A → B", |row| row.accuracy.iter().map(accuracy).join("; "))
        .column("answers", |row| if row.same_hits { "same" } else { "differ" })
        .column("counters, totals", |row| changed(&row.counters))
        .column("bytes", |row| changed(&row.bytes))
        .table(&comparison.traces)
}

fn accuracy(accuracy: &Accuracy) -> String {
    let Accuracy { rule, a, b, a_wrong, b_wrong, rays, shift } = accuracy;
    let share = |share: &Option<f64>| share.map_or_else(|| NONE.to_owned(), |share| percent(share, *rays));
    let wrong = |count: &u64| thousands(*count);
    let said = match shift {
        Shift::Same => return format!("{rule} {} % ({} wrong)", share(a), wrong(a_wrong)),
        Shift::Worse => " **less**",
        Shift::Better => " more",
        Shift::Within => "",
    };
    format!("{rule} {} → {} % ({} → {} wrong){said}", share(a), share(b), wrong(a_wrong), wrong(b_wrong))
}

fn only(name: &str, keys: &[Key]) -> Document {
    if keys.is_empty() {
        return Document::default();
    }
    let item = |key: &Key| {
        let Key { scene_sha256, viewpoint, rays_sha256, .. } = key;
        let rays =
            rays_sha256.as_ref().map_or_else(String::new, |hash| format!(", rays {}", format::hash_prefix(hash)));
        let about = format!("scene {}{rays}, viewpoint {viewpoint}", format::hash_prefix(scene_sha256));
        format!("{} ({about})", key.sentence())
    };
    Document::default().heading(2, format!("Only in {name}")).items(keys.iter().map(item))
}
