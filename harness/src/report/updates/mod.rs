//! The table of structures that follow animations; along the camera's path that of [`walk`].

mod walk;

use std::collections::BTreeSet;
use std::fmt::Write as _;

use crate::report::format::{self, NONE, clock_code, clock_of, mib, optional, thousands, with_interval};
use crate::report::markdown::{Table as Markdown, inline};
use crate::report::tables::{accuracy_columns, code, number, to_csv};
use crate::report::{ReportError, cells, metrics, summary};
use crate::results::{
    FRESH_BUILD, Judgement, Run, SceneFollowed, Times, TraceRecord, TracerRun, UpdatesRecord, time_ratio,
};

/// The statistic of structures that tells their quality, by its name in `validate`.
const SAH_COST: &str = "sah_cost";

/// The table, as Markdown and CSV: names and contents.
pub(super) fn files(run: &Run, updates: &UpdatesRecord) -> Result<Vec<(String, Vec<u8>)>, ReportError> {
    // The name comes from a file.
    let stem = format!("table_{}", format::file_stem(run.table.as_deref().unwrap_or("updates")).replace('-', "_"));
    let csv = format!("{stem}.csv");
    let walked = updates.scenes.iter().any(|scene| !scene.walked.is_empty());
    let (page, rows) = if walked {
        (walk::page(run, updates), walk::rows(run, updates))
    } else {
        (page(run, updates), rows(run, updates))
    };
    let rows = to_csv(&csv, rows)?;
    Ok(vec![(format!("{stem}.md"), page.into_bytes()), (csv, rows)])
}

/// A scene that was followed, with its rows.
struct Followed<'a> {
    times_s: &'a [f64],
    rows: Vec<&'a TracerRun>,
}

/// Every scene that has rows.
fn scenes<'a>(run: &'a Run, updates: &'a UpdatesRecord) -> Vec<Followed<'a>> {
    let of_scene = |scene: &'a SceneFollowed| {
        let is_of = |row: &&TracerRun| (&row.scene.name, &row.scene.sha256) == (&scene.scene, &scene.scene_sha256);
        Followed { times_s: &scene.times_s, rows: run.runs.iter().filter(is_of).collect() }
    };
    updates.scenes.iter().map(of_scene).filter(|scene| !scene.rows.is_empty()).collect()
}

fn way(row: &TracerRun) -> &str {
    row.way.as_ref().map_or(FRESH_BUILD, |way| &way.name)
}

/// The fresh build of a row's tracer.
fn fresh_of<'a>(scene: &Followed<'a>, row: &TracerRun) -> Option<&'a TracerRun> {
    scene.rows.iter().find(|other| way(other) == FRESH_BUILD && other.tracer == row.tracer).copied()
}

fn sah_cost(row: &TracerRun) -> Option<f64> {
    row.structure_statistics.get(SAH_COST).copied()
}

fn interval_of(times: &Times) -> Option<String> {
    (!times.samples_ms.is_empty()).then(|| with_interval(times.median_ms, times.interval_ms, 4))
}

/// Own over fresh, by the rule of clocks.
fn over_fresh(own: &Times, fresh: Option<&Times>) -> Option<f64> {
    time_ratio(own, fresh?)
}

/// The title, and where it was measured.
fn head(run: &Run, title: &str) -> String {
    let mut text = format!("# Table {}: {title}\n\n", inline(run.table.as_deref().unwrap_or_default()));
    let mut item = |name: &str, value: &str| {
        let _ = writeln!(text, "- {name}: {}", inline(value));
    };
    item("Machine", &run.provenance.machine.label());
    item("Commit", &format::commit(&run.provenance.commit, run.provenance.dirty));
    let smoke = if run.preset == "smoke" { " (smoke run: figures only show that things work)" } else { "" };
    item("Preset", &format!("{}{smoke}", run.preset));
    item("Started", &run.provenance.started);
    text
}

fn page(run: &Run, updates: &UpdatesRecord) -> String {
    let mut text = head(run, "structures that follow animations");
    let _ = writeln!(
        text,
        "\nEvery structure is built over the first frame and follows {} frames, evenly over the animation (to its \
         middle, where it comes back to its start), in {} counted passes. Times \
         are medians over all updates with an order-statistic interval in brackets; each names its clock. At the last frame \
         all trace the same rays, beside a fresh build over that frame: × fresh is the ratio to that build's time or speed, \
         by the clock of both, else by the host's. The controls score what they must, else there would be no table.",
        updates.frames, updates.passes
    );
    for scene in &scenes(run, updates) {
        let _ = writeln!(
            text,
            "\n## {} ({} triangles)\n\nTo {} s.\n",
            inline(&scene.rows[0].scene.name),
            thousands(scene.rows[0].scene.triangles),
            scene.times_s.last().copied().unwrap_or_default()
        );
        text += &structures(scene);
        for (rays, sha256) in ray_sets(scene) {
            text += &traces(scene, &rays, &sha256);
        }
    }
    text + &summary::skipped(&run.skipped)
}

fn structures(scene: &Followed<'_>) -> String {
    let headings =
        ["tracer", "way", "clock", "update time (ms) ↓", "× fresh", "SAH cost ↓", "× fresh", "structure (MiB) ↓"];
    let mut markdown = Markdown::new(&headings.map(str::to_owned));
    for row in &scene.rows {
        let fresh = fresh_of(scene, row);
        let cost = sah_cost(row);
        markdown.row(&[
            row.label(),
            way(row).to_owned(),
            clock_of(&row.build.times),
            interval_of(&row.build.times).unwrap_or_else(|| NONE.to_owned()),
            optional(over_fresh(&row.build.times, fresh.map(|fresh| &fresh.build.times)), 3),
            optional(cost, 4),
            optional(cost.zip(fresh.and_then(sah_cost)).map(|(own, fresh)| own / fresh), 4),
            mib(row.memory.structure_bytes),
        ]);
    }
    markdown.text
}

/// Names and hashes of the ray sets, in order of first appearance.
fn ray_sets(scene: &Followed<'_>) -> Vec<(String, String)> {
    let mut sets = Vec::new();
    for trace in scene.rows.iter().flat_map(|row| &row.traces) {
        let set = (trace.rays.clone(), trace.rays_sha256.clone());
        if !sets.contains(&set) {
            sets.push(set);
        }
    }
    sets
}

fn trace_of<'a>(row: &'a TracerRun, rays: &str, sha256: &str) -> Option<&'a TraceRecord> {
    row.traces.iter().find(|trace| trace.rays == rays && trace.rays_sha256 == sha256)
}

fn traces(scene: &Followed<'_>, rays: &str, sha256: &str) -> String {
    let found: Vec<_> =
        scene.rows.iter().filter_map(|row| trace_of(row, rays, sha256).map(|trace| (row, trace))).collect();
    let Some((_, first)) = found.first() else { return String::new() };
    let accuracies: &[&str] = match first.judgement {
        Judgement::Closest(_) => &["agreement hit_miss ↑", "agreement tight ↑", "agreement footprint ↑"],
        Judgement::Any(_) => &["balanced accuracy ↑"],
    };
    // Those of a whole set are no cost of a ray.
    let per_ray = found.iter().flat_map(|(_, trace)| &trace.counters).filter(|(_, one)| one.greatest_per_ray.is_some());
    let counters: BTreeSet<&String> = per_ray.map(|(name, _)| name).collect();
    let mut headings = vec!["tracer".to_owned(), "way".to_owned(), "clock".to_owned(), metrics::SPEED.heading()];
    headings.push("× fresh ↑".to_owned());
    headings.extend(accuracies.iter().map(|&name| name.to_owned()));
    headings.extend(counters.iter().map(|name| format!("{name} per ray ↓")));
    let mut markdown = Markdown::new(&headings);
    for (row, trace) in &found {
        let (judged, accuracies) = cells::accuracies(trace);
        let fresh = fresh_of(scene, row).and_then(|fresh| trace_of(fresh, rays, sha256));
        let speed = metrics::speed(trace).filter(|_| judged);
        let speed = speed.map(|speed| with_interval(speed, metrics::speed_interval(trace).unwrap_or([speed; 2]), 4));
        let ratio =
            over_fresh(&trace.times, fresh.map(|fresh| &fresh.times)).filter(|_| judged).map(|slower| 1.0 / slower);
        let mut cells = vec![row.label(), way(row).to_owned(), clock_of(&trace.times)];
        cells.extend([speed.unwrap_or_else(|| NONE.to_owned()), optional(ratio, 3)]);
        cells.extend(accuracies);
        cells.extend(counters.iter().map(|name| optional(trace.counters.get(*name).map(|each| each.per_ray), 4)));
        markdown.row(&cells);
    }
    let title = format!("{}: {}, {} rays", inline(rays), format::query(first.query), thousands(first.count));
    format!("\n### {title}\n\n{}", markdown.text)
}

/// One row a scene, tracer, way and ray set.
fn rows(run: &Run, updates: &UpdatesRecord) -> Vec<Vec<String>> {
    let header = [
        "scene",
        "scene_sha256",
        "triangles",
        "frames",
        "passes",
        "tracer",
        "tracer_name",
        "parameters_json",
        "way",
        "update_clock",
        "update_median_ms",
        "update_low_ms",
        "update_high_ms",
        "update_time_over_fresh",
        "sah_cost",
        "sah_cost_over_fresh",
        "structure_bytes",
        "rays",
        "rays_sha256",
        "query",
        "count_rays",
        "clock",
        "mrays_per_s",
        "mrays_per_s_low",
        "mrays_per_s_high",
        "speed_over_fresh",
        "agreement_hit_miss_share",
        "agreement_tight_share",
        "agreement_footprint_share",
        "balanced_accuracy_share",
        "ties_rays",
        "commit",
        "run_preset",
        "machine",
    ];
    let mut rows = vec![header.map(str::to_owned).to_vec()];
    let scenes = scenes(run, updates);
    for (scene, row, trace) in scenes.iter().flat_map(|scene| {
        scene.rows.iter().flat_map(move |row| row.traces.iter().map(move |trace| (scene, *row, trace)))
    }) {
        let fresh = fresh_of(scene, row);
        let beside = fresh.and_then(|fresh| trace_of(fresh, &trace.rays, &trace.rays_sha256));
        let (update, cost) = (&row.build.times, sah_cost(row));
        let timed = |ms: f64| number((!update.samples_ms.is_empty()).then_some(ms));
        let speed = metrics::speed_interval(trace);
        let mut cells = vec![
            row.scene.name.clone(),
            row.scene.sha256.clone(),
            row.scene.triangles.to_string(),
            updates.frames.to_string(),
            updates.passes.to_string(),
            row.label(),
            row.tracer.name.clone(),
            serde_json::to_string(&row.tracer.parameters).unwrap_or_default(),
            way(row).to_owned(),
            clock_code(update.clock).to_owned(),
            timed(update.median_ms),
            timed(update.interval_ms[0]),
            timed(update.interval_ms[1]),
            number(over_fresh(update, fresh.map(|fresh| &fresh.build.times))),
            number(cost),
            number(cost.zip(fresh.and_then(sah_cost)).map(|(own, fresh)| own / fresh)),
            row.memory.structure_bytes.to_string(),
            trace.rays.clone(),
            trace.rays_sha256.clone(),
            code(trace.query),
            trace.count.to_string(),
            clock_code(trace.times.clock).to_owned(),
            number(metrics::speed(trace)),
            number(speed.map(|[low, _]| low)),
            number(speed.map(|[_, high]| high)),
            number(over_fresh(&trace.times, beside.map(|fresh| &fresh.times)).map(|slower| 1.0 / slower)),
        ];
        cells.extend(accuracy_columns(trace));
        cells.extend([run.provenance.commit.clone(), run.preset.clone(), run.provenance.machine.label()]);
        rows.push(cells);
    }
    rows
}
