//! The table of frames along the camera's path: the time of all frames together, and the accuracy at each.

use std::fmt::Write as _;

use super::{head, interval_of, way};
use crate::report::format::{self, NONE, clock_code, clock_of, optional, percent, thousands};
use crate::report::markdown::{Table as Markdown, inline};
use crate::report::tables::{accuracy_columns, code, number};
use crate::report::{metrics, summary};
use crate::results::{Judgement, Run, SceneFollowed, TraceRecord, UpdatesRecord};
use crate::studies::updates::{Total, Walker, walkers};

/// The way that totals are set against.
const REBUILD: &str = "rebuild";

/// Walks of one ray set.
struct Set<'a> {
    rays: &'a str,
    walkers: Vec<Walker<'a>>,
}

/// Every ray set of a scene, in the order of the first rows.
fn sets<'a>(run: &'a Run, scene: &'a SceneFollowed) -> Vec<Set<'a>> {
    let mut names: Vec<&str> = Vec::new();
    for trace in run.runs.iter().filter(|row| row.scene.name == scene.scene).flat_map(|row| &row.traces) {
        if !names.contains(&trace.rays.as_str()) {
            names.push(&trace.rays);
        }
    }
    let set = |rays| Set { rays, walkers: walkers(run, scene, rays) };
    names.into_iter().map(set).filter(|set| !set.walkers.is_empty()).collect()
}

/// The tracer as the first row that it has names it.
fn label(walker: &Walker<'_>) -> String {
    walker.frames.iter().flatten().next().map_or_else(String::new, |(row, _)| row.label())
}

/// The way, marked where what it reuses is invalid.
fn way_of(walker: &Walker<'_>) -> String {
    if walker.stale_by.is_empty() {
        return walker.way.to_owned();
    }
    format!("{} (**stale**: moved {})", walker.way, walker.stale_by.join(", "))
}

/// The total of the same tracer that is rebuilt at every frame.
fn rebuilt(set: &Set<'_>, walker: &Walker<'_>) -> Option<Total> {
    let tracer = |walker: &Walker<'_>| walker.frames[0].map(|(row, _)| row.tracer.clone());
    set.walkers.iter().find(|other| other.way == REBUILD && tracer(other) == tracer(walker))?.total()
}

/// The shares of a trace that tell its accuracy: three of a closest-hit set, one of an any-hit set.
fn shares(trace: &TraceRecord) -> Vec<Option<f64>> {
    match &trace.judgement {
        Judgement::Closest(closest) => {
            vec![closest.agreement.hit_miss, closest.agreement.tight, closest.agreement.footprint]
        }
        Judgement::Any(any) => vec![any.occlusion.balanced_accuracy],
    }
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
    let (row, trace) = walker.frames[frame]?;
    (metrics::TRACE_TIME.column.value)(row, trace)
}

/// Mean over frames, where all have a value.
fn mean(values: impl Iterator<Item = Option<f64>>) -> Option<f64> {
    let values: Vec<f64> = values.collect::<Option<_>>()?;
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

pub(super) fn page(run: &Run, updates: &UpdatesRecord) -> String {
    let mut text = head(run, "frames along the camera's path");
    let _ = writeln!(
        text,
        "\nThe eye moves at every one of {0} frames, evenly along the scene's camera path (without one, straight to another viewpoint of \
         it), and a scene that moves does so over the same frames. Every frame has its own rays and truth. All build over the first \
         frame; at every later one the structure is reused as it is, refitted, or rebuilt, {1} times each. *All frames* is the first \
         build, what is done to the structure at every later frame, and the traces of all {2} frames, sums of medians of one clock \
         (of the host's where they are of several); × rebuild is the ratio to the same tracer rebuilt at every frame. **Stale**: \
         the move invalidates the method's structure, so that its reuse is no way to use it; its rows show what its answers depend \
         on. The controls score what they must at every frame, else there would be no table.",
        updates.frames,
        updates.passes,
        updates.frames + 1
    );
    for scene in &updates.scenes {
        let sets = sets(run, scene);
        let first = sets.iter().flat_map(|set| &set.walkers).find_map(|walker| walker.frames[0]);
        let Some((row, _)) = first else { continue };
        let moves = match scene.times_s.last() {
            Some(end) if scene.walked.iter().any(|hash| *hash != scene.walked[0]) => format!("moves to {end} s"),
            _ => "stands still".to_owned(),
        };
        let (name, triangles) = (inline(&row.scene.name), thousands(row.scene.triangles));
        let _ = writeln!(text, "\n## {name} ({triangles} triangles)\n\nThe scene {moves}.");
        for set in &sets {
            text += &totals(set);
            text += &accuracies(set);
        }
    }
    text + &summary::skipped(&run.skipped)
}

fn totals(set: &Set<'_>) -> String {
    let Some((_, first)) = set.walkers.iter().find_map(|walker| walker.frames[0]) else { return String::new() };
    let closest = matches!(first.judgement, Judgement::Closest(_));
    let accuracy = if closest {
        "agreement, least of all frames (%): hit_miss / tight / footprint ↑"
    } else {
        "balanced accuracy, least of all frames (%) ↑"
    };
    let headings = [
        "tracer",
        "way",
        "clock",
        "first build (ms) ↓",
        "update, mean of frames (ms) ↓",
        "trace, mean of frames (ms) ↓",
        "all frames (ms) ↓",
        "× rebuild ↓",
        accuracy,
    ];
    let mut markdown = Markdown::new(&headings.map(str::to_owned));
    for walker in &set.walkers {
        let later = 1..walker.frames.len();
        let update = mean(later.clone().map(|frame| walker.update(frame).map(|times| times.median_ms)));
        let trace = mean(later.map(|frame| trace_ms(walker, frame)));
        let (total, least) = (walker.total(), least(walker));
        // No time without the accuracy of the same frames.
        let judged = least.as_ref().is_some_and(|(shares, _)| shares.iter().all(Option::is_some));
        let ratio = total.zip(rebuilt(set, walker)).and_then(|(own, rebuilt)| own.over(&rebuilt));
        let clocks = walker.frames[0].map_or_else(|| NONE.to_owned(), |(_, trace)| clock_of(&trace.times));
        markdown.row(&[
            label(walker),
            way_of(walker),
            total.map_or(clocks, |total| format::clock(total.clock).to_owned()),
            walker.update(0).and_then(interval_of).unwrap_or_else(|| NONE.to_owned()),
            optional(update, 4),
            optional(trace.filter(|_| judged), 4),
            optional(total.filter(|_| judged).map(|total| total.ms), 4),
            optional(ratio.filter(|_| judged), 3),
            least.map_or_else(|| NONE.to_owned(), |(shares, trials)| shares_as_text(&shares, trials)),
        ]);
    }
    let title =
        format!("{}: {}, {} rays a frame", inline(set.rays), format::query(first.query), thousands(first.count));
    format!("\n### {title}\n\n{}", markdown.text)
}

fn accuracies(set: &Set<'_>) -> String {
    let frames = set.walkers.first().map_or(0, |walker| walker.frames.len());
    let mut headings = vec!["tracer".to_owned(), "way".to_owned()];
    headings.extend((0..frames).map(|frame| format!("frame {frame} (%) ↑")));
    let mut markdown = Markdown::new(&headings);
    for walker in &set.walkers {
        let cell = |there: &Option<(_, &TraceRecord)>| {
            there.map_or_else(|| NONE.to_owned(), |(_, trace)| shares_as_text(&shares(trace), metrics::trials(trace)))
        };
        let mut cells = vec![label(walker), way_of(walker)];
        cells.extend(walker.frames.iter().map(cell));
        markdown.row(&cells);
    }
    format!("\nAt every frame:\n\n{}", markdown.text)
}

/// One row a scene, ray set, tracer, way and frame.
pub(super) fn rows(run: &Run, updates: &UpdatesRecord) -> Vec<Vec<String>> {
    let header = [
        "scene",
        "scene_sha256",
        "triangles",
        "frames",
        "passes",
        "frame",
        "animation_time_s",
        "viewpoint",
        "tracer",
        "tracer_name",
        "parameters_json",
        "way",
        "stale_by",
        "update_clock",
        "update_median_ms",
        "update_low_ms",
        "update_high_ms",
        "structure_bytes",
        "rays",
        "rays_sha256",
        "query",
        "count_rays",
        "clock",
        "trace_median_ms",
        "trace_low_ms",
        "trace_high_ms",
        "mrays_per_s",
        "agreement_hit_miss_share",
        "agreement_tight_share",
        "agreement_footprint_share",
        "balanced_accuracy_share",
        "ties_rays",
        "all_frames_clock",
        "all_frames_ms",
        "all_frames_over_rebuild",
        "commit",
        "run_preset",
        "machine",
    ];
    let mut rows = vec![header.map(str::to_owned).to_vec()];
    for scene in &updates.scenes {
        for set in sets(run, scene) {
            for walker in &set.walkers {
                let total = walker.total();
                let ratio = total.zip(rebuilt(&set, walker)).and_then(|(own, rebuilt)| own.over(&rebuilt));
                let measured =
                    walker.frames.iter().enumerate().filter_map(|(frame, there)| there.map(|there| (frame, there)));
                for (frame, (row, trace)) in measured {
                    let (update, times) = (walker.update(frame), &trace.times);
                    let timed = |ms: f64| number((!times.samples_ms.is_empty()).then_some(ms));
                    let mut cells = vec![
                        row.scene.name.clone(),
                        row.scene.sha256.clone(),
                        row.scene.triangles.to_string(),
                        updates.frames.to_string(),
                        updates.passes.to_string(),
                        frame.to_string(),
                        number(Some(row.viewpoint.time_s)),
                        row.viewpoint.name.clone(),
                        row.label(),
                        row.tracer.name.clone(),
                        serde_json::to_string(&row.tracer.parameters).unwrap_or_default(),
                        // The first frame is a fresh build for every way that begins there.
                        if frame == 0 { format!("{}, {}", way(row), walker.way) } else { walker.way.to_owned() },
                        row.way.as_ref().map(|way| way.stale_by.join(" ")).unwrap_or_default(),
                        update.map_or_else(String::new, |times| clock_code(times.clock).to_owned()),
                        number(update.map(|times| times.median_ms)),
                        number(update.map(|times| times.interval_ms[0])),
                        number(update.map(|times| times.interval_ms[1])),
                        row.memory.structure_bytes.to_string(),
                        trace.rays.clone(),
                        trace.rays_sha256.clone(),
                        code(trace.query),
                        trace.count.to_string(),
                        clock_code(times.clock).to_owned(),
                        timed(times.median_ms),
                        timed(times.interval_ms[0]),
                        timed(times.interval_ms[1]),
                        number(metrics::speed(trace)),
                    ];
                    cells.extend(accuracy_columns(trace));
                    cells.push(total.map_or_else(String::new, |total| clock_code(total.clock).to_owned()));
                    cells.extend([number(total.map(|total| total.ms)), number(ratio)]);
                    cells.extend([run.provenance.commit.clone(), run.preset.clone(), run.provenance.machine.label()]);
                    rows.push(cells);
                }
            }
        }
    }
    rows
}
