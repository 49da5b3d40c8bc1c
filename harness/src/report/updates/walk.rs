//! The table of frames along the camera's path: the time of all frames together, and the accuracy at each.

use std::ptr;

use itertools::Itertools as _;
use tracebench_api::Query;

use super::head;
use crate::report::document::{Document, set_heading};
use crate::report::format::{self, NONE, clock_code, clock_of, percent};
use crate::report::group::groups;
use crate::report::metrics::{Better, FIRST_BUILD, TRACE_TIME, headed};
use crate::report::sheet::{Cell, Column, Sheet, Table};
use crate::report::tables::Placed;
use crate::report::{self, Report, metrics, summary};
use crate::results::{Record, SceneFollowed, TraceRecord, UpdatesRecord};
use crate::studies::updates::{Total, Walker, walkers};

/// The way that totals are set against.
const REBUILD: &str = "rebuild";

/// Walks of one ray set.
struct Set<'a> {
    rays: &'a str,
    walkers: Vec<Walker<'a>>,
}

/// Every ray set of a scene, in the order of the first rows.
fn sets<'a>(record: &'a Record, scene: &'a SceneFollowed) -> Vec<Set<'a>> {
    let traces = record.rows.iter().filter(|row| row.scene.name == scene.scene).flat_map(|row| &row.traces);
    let set = |rays| Set { rays, walkers: walkers(record, scene, rays) };
    traces.map(|trace| trace.rays.as_str()).unique().map(set).filter(|set| !set.walkers.is_empty()).collect()
}

/// The tracer as the first row that it has names it.
fn label(walker: &Walker<'_>) -> String {
    walker.frames.iter().flatten().next().map_or_else(String::new, |(row, _)| row.label())
}

/// The way, marked where what it reuses is invalid.
fn way_of(walker: &Walker<'_>) -> String {
    if walker.stale_by.is_empty() {
        return walker.update_mode.to_owned();
    }
    format!("{} (**stale**: moved {})", walker.update_mode, walker.stale_by.join(", "))
}

/// The total of the same tracer that is rebuilt at every frame.
fn rebuilt(set: &Set<'_>, walker: &Walker<'_>) -> Option<Total> {
    let tracer = |walker: &Walker<'_>| walker.frames[0].map(|(row, _)| row.tracer.clone());
    set.walkers.iter().find(|other| other.update_mode == REBUILD && tracer(other) == tracer(walker))?.total()
}

/// The shares of a trace that tell its accuracy.
fn shares(trace: &TraceRecord) -> Vec<Option<f64>> {
    metrics::right_of(trace).into_iter().map(|accuracy| accuracy.share).collect()
}

fn shares_as_text(shares: &[Option<f64>], trials: u64) -> String {
    let text = |share: &Option<f64>| share.map_or_else(|| NONE.to_owned(), |share| percent(share, trials));
    shares.iter().map(text).collect::<Vec<_>>().join(" / ")
}

/// The least of each share over all frames; nothing where a frame has none.
fn least(walker: &Walker<'_>) -> Option<(Vec<Option<f64>>, u64)> {
    let mut least: Option<(Vec<Option<f64>>, u64)> = None;
    for (_, trace) in walker.frames.iter().copied().collect::<Option<Vec<_>>>()? {
        let (found, trials) = (shares(trace), metrics::trials(trace));
        least = Some(match least {
            None => (found, trials),
            Some((known, fewest)) => {
                let both = known.iter().zip(&found).map(|(known, found)| Some(known.as_ref()?.min(*found.as_ref()?)));
                (both.collect(), fewest.min(trials))
            }
        });
    }
    least
}

fn trace_ms(walker: &Walker<'_>, frame: usize) -> Option<f64> {
    let (_, trace) = walker.frames[frame]?;
    TRACE_TIME.value(trace)
}

/// Mean over frames, where all have a value.
fn mean(values: impl Iterator<Item = Option<f64>>) -> Option<f64> {
    let values: Vec<f64> = values.collect::<Option<_>>()?;
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

pub(super) fn page(record: &Record, updates: &UpdatesRecord) -> Document {
    let head = head(record, "frames along the camera's path").paragraph(format!(
        "The eye moves at every one of {0} frames, evenly along the scene's camera path (without one, straight to another viewpoint of \
         it), and a scene that moves does so over the same frames. Every frame has its own rays and truth. All build over the first \
         frame; at every later one the structure is reused as it is, refitted, or rebuilt, {1} times each. *All frames* is the first \
         build, what is done to the structure at every later frame, and the traces of all {2} frames, sums of medians of one clock \
         (of the host's where they are of several); × rebuild is the ratio to the same tracer rebuilt at every frame. **Stale**: \
         the move invalidates the method's structure, so that its reuse is no way to use it; its rows show what its answers depend \
         on. The controls score what they must at every frame, else there would be no table.",
        updates.frames,
        updates.passes,
        updates.frames + 1
    ));
    let section = |scene: &SceneFollowed| {
        let sets = sets(record, scene);
        let (row, _) = sets.iter().flat_map(|set| &set.walkers).find_map(|walker| walker.frames[0])?;
        let moves = match scene.times_s.last() {
            Some(end) if scene.frame_scene_sha256.iter().any(|hash| *hash != scene.frame_scene_sha256[0]) => {
                format!("moves to {end} s")
            }
            _ => "stands still".to_owned(),
        };
        let page = Document::default().scene(2, &row.scene, "").paragraph(format!("The scene {moves}."));
        Some(page.and(sets.iter().map(totals)))
    };
    head.and(updates.scenes.iter().filter_map(section)).and(summary::skipped(&record.skipped))
}

fn totals(set: &Set<'_>) -> Document {
    let Some((_, first)) = set.walkers.iter().find_map(|walker| walker.frames[0]) else { return Document::default() };
    let accuracy = match first.query {
        Query::Closest => "agreement, least of all frames (%): hit_miss / tight / footprint",
        Query::Any => "balanced accuracy, least of all frames (%)",
    };
    // No time without the accuracy of the same frames.
    let judged = |walker: &Walker<'_>| {
        let whole = least(walker).is_some_and(|(shares, _)| shares.iter().all(Option::is_some));
        whole.then_some(())
    };
    let sheet = Sheet::<Walker<'_>>::new()
        .column("tracer", label)
        .column("update mode", way_of)
        .column("clock", |walker| {
            let clock = || walker.frames[0].map(|(_, trace)| clock_of(&trace.times));
            walker.total().map(|total| format::clock(total.clock).to_owned()).or_else(clock)
        })
        .column(FIRST_BUILD.heading(), |walker| walker.update(0))
        .column("update, mean of frames (ms) ↓", |walker| {
            mean(later(walker).map(|frame| walker.update(frame).map(|times| times.median_ms)))
        })
        .column("trace, mean of frames (ms) ↓", move |walker| {
            judged(walker).and_then(|()| mean(later(walker).map(|frame| trace_ms(walker, frame))))
        })
        .column("all frames (ms) ↓", move |walker| judged(walker).and_then(|()| Some(walker.total()?.ms)))
        .column("× rebuild ↓", move |walker| {
            judged(walker).and_then(|()| over_rebuilt(set, walker)).map(|ratio| Cell::Number(ratio, 3))
        })
        .column(headed(accuracy, Better::Higher), |walker| {
            least(walker).map(|(shares, trials)| shares_as_text(&shares, trials))
        });
    let title = format!("{} a frame", set_heading(set.rays, first.query, first.count));
    let page = Document::default().rays(3, set.rays, title).table(sheet.table(&set.walkers));
    page.paragraph("At every frame:").table(accuracies(set))
}

fn later(walker: &Walker<'_>) -> std::ops::Range<usize> {
    1..walker.frames.len()
}

/// The total over that of the same tracer that is rebuilt at every frame.
fn over_rebuilt(set: &Set<'_>, walker: &Walker<'_>) -> Option<f64> {
    walker.total()?.over(&rebuilt(set, walker)?)
}

fn accuracies(set: &Set<'_>) -> Table {
    let frames = set.walkers.first().map_or(0, |walker| walker.frames.len());
    let of_frame = |frame: usize| {
        Column::new(format!("frame {frame} (%) ↑"), move |walker: &Walker<'_>| {
            let (_, trace) = walker.frames.get(frame).copied().flatten()?;
            Some(shares_as_text(&shares(trace), metrics::trials(trace)))
        })
    };
    let sheet = Sheet::<Walker<'_>>::new()
        .column("tracer", label)
        .column("update mode", way_of)
        .with((0..frames).map(of_frame).collect());
    sheet.table(&set.walkers)
}

/// What is told of later frames: the time of all frames on their way.
pub(super) fn rows(record: &Record, updates: &UpdatesRecord) -> Report {
    type Walk<'a> = (&'a Set<'a>, &'a Walker<'a>);
    let groups = groups(record);
    let sets: Vec<Set<'_>> = updates.scenes.iter().flat_map(|scene| sets(record, scene)).collect();
    let walk = |(.., (_, _, trace)): &Placed<'_>| {
        let mut all = sets.iter().flat_map(|set| set.walkers.iter().map(move |walker| (set, walker)));
        all.find(|(_, walker)| walker.frames.iter().skip(1).flatten().any(|(_, own)| ptr::eq(*own, *trace)))
    };
    let own = Sheet::<Walk<'_>>::new()
        .csv_column("all_frames_clock", |(_, walker)| walker.total().map(|total| clock_code(total.clock)))
        .csv_column("all_frames_ms", |(_, walker)| walker.total().map(|total| total.ms))
        .csv_column("all_frames_over_rebuild", |(set, walker)| over_rebuilt(set, walker));
    report::rows(record, &groups, own, walk)
}
