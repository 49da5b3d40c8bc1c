//! The files of structures that follow animations: `updates.json`, and the table made of it.

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use super::format::{self, NONE, clock_code, clock_of, mib, optional, thousands, with_interval};
use super::markdown::{Table as Markdown, inline};
use super::metrics;
use super::tables::{accuracy_columns, code, number, to_csv};
use super::{ReportError, cells, files, summary};
use crate::results::{Judgement, Times, TraceRecord};
use crate::studies::updates::{FRESH_BUILD, SceneUpdates, UpdateRow, Updates};

/// The file that holds everything.
pub(super) const UPDATES_FILE: &str = "updates.json";

/// The statistic of structures that tells their quality, by its name in `validate`.
const SAH_COST: &str = "sah_cost";

/// Writes `updates.json` and the table, and gives the paths.
///
/// # Errors
/// If the folder or a file cannot be written.
pub fn write_updates(updates: &Updates, directory: &Path) -> Result<Vec<PathBuf>, ReportError> {
    files::create_directory(directory)?;
    let path = directory.join(UPDATES_FILE);
    files::write(&path, &files::json(UPDATES_FILE, updates)?)?;
    let mut paths = vec![path];
    paths.extend(write_updates_table(updates, directory)?);
    Ok(paths)
}

/// Writes the table, as Markdown and CSV, and gives the paths.
///
/// # Errors
/// If the folder or a file cannot be written.
pub fn write_updates_table(updates: &Updates, directory: &Path) -> Result<Vec<PathBuf>, ReportError> {
    files::create_directory(directory)?;
    // The name comes from a file.
    let stem = format!("table_{}", format::file_stem(&updates.table).replace('-', "_"));
    let csv = format!("{stem}.csv");
    let contents = [(format!("{stem}.md"), page(updates).into_bytes()), (csv.clone(), to_csv(&csv, rows(updates))?)];
    let write = |(name, contents): (String, Vec<u8>)| {
        let path = directory.join(name);
        files::write(&path, &contents).map(|()| path)
    };
    contents.into_iter().map(write).collect()
}

/// The fresh build of a row's tracer.
fn fresh_of<'a>(scene: &'a SceneUpdates, row: &UpdateRow) -> Option<&'a UpdateRow> {
    scene.rows.iter().find(|other| other.way == FRESH_BUILD && other.tracer == row.tracer)
}

fn sah_cost(row: &UpdateRow) -> Option<f64> {
    row.structure_statistics.get(SAH_COST).copied()
}

fn interval_of(times: &Times) -> Option<String> {
    (!times.samples_ms.is_empty()).then(|| with_interval(times.median_ms, times.interval_ms, 4))
}

/// Own over fresh, of times by the same clock.
fn over_fresh(own: &Times, fresh: Option<&Times>) -> Option<f64> {
    let fresh = fresh.filter(|fresh| fresh.clock == own.clock && fresh.median_ms > 0.0)?;
    (!own.samples_ms.is_empty()).then_some(own.median_ms / fresh.median_ms)
}

fn page(updates: &Updates) -> String {
    let mut text = format!("# Table {}: structures that follow animations\n\n", inline(&updates.table));
    let mut item = |name: &str, value: &str| {
        let _ = writeln!(text, "- {name}: {}", inline(value));
    };
    item("Machine", &updates.provenance.machine.label());
    item("Commit", &format::commit(&updates.provenance.commit, updates.provenance.dirty));
    let smoke = if updates.preset == "smoke" { " (smoke run: figures only show that things work)" } else { "" };
    item("Preset", &format!("{}{smoke}", updates.preset));
    item("Started", &updates.provenance.started);
    let _ = writeln!(
        text,
        "\nEvery structure is built over the first frame and follows {} frames, evenly over the animation (to its \
         middle, where it comes back to its start), in {} counted passes. Times \
         are medians over all updates with an order-statistic interval in brackets; each names its clock. At the last frame \
         all trace the same rays, beside a fresh build over that frame: × fresh is the ratio to that build's time or speed, \
         where both have the same clock. The controls score what they must, else there would be no table.",
        updates.frames, updates.passes
    );
    for scene in &updates.scenes {
        let _ = writeln!(
            text,
            "\n## {} ({} triangles)\n\nTo {} s.\n",
            inline(&scene.scene.name),
            thousands(scene.scene.triangles),
            scene.times_s.last().copied().unwrap_or_default()
        );
        text += &structures(scene);
        for (rays, sha256) in ray_sets(scene) {
            text += &traces(scene, &rays, &sha256);
        }
    }
    text + &summary::skipped(&updates.skipped)
}

fn structures(scene: &SceneUpdates) -> String {
    let headings =
        ["tracer", "way", "clock", "update time (ms) ↓", "× fresh", "SAH cost ↓", "× fresh", "structure (MiB) ↓"];
    let mut markdown = Markdown::new(&headings.map(str::to_owned));
    for row in &scene.rows {
        let fresh = fresh_of(scene, row);
        let cost = sah_cost(row);
        markdown.row(&[
            row.tracer.label(),
            row.way.clone(),
            clock_of(&row.update),
            interval_of(&row.update).unwrap_or_else(|| NONE.to_owned()),
            optional(over_fresh(&row.update, fresh.map(|fresh| &fresh.update)), 3),
            optional(cost, 4),
            optional(cost.zip(fresh.and_then(sah_cost)).map(|(own, fresh)| own / fresh), 4),
            mib(row.memory.structure_bytes),
        ]);
    }
    markdown.text
}

/// Names and hashes of the ray sets, in order of first appearance.
fn ray_sets(scene: &SceneUpdates) -> Vec<(String, String)> {
    let mut sets = Vec::new();
    for trace in scene.rows.iter().flat_map(|row| &row.traces) {
        let set = (trace.rays.clone(), trace.rays_sha256.clone());
        if !sets.contains(&set) {
            sets.push(set);
        }
    }
    sets
}

fn trace_of<'a>(row: &'a UpdateRow, rays: &str, sha256: &str) -> Option<&'a TraceRecord> {
    row.traces.iter().find(|trace| trace.rays == rays && trace.rays_sha256 == sha256)
}

fn traces(scene: &SceneUpdates, rays: &str, sha256: &str) -> String {
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
        let mut cells = vec![row.tracer.label(), row.way.clone(), clock_of(&trace.times)];
        cells.extend([speed.unwrap_or_else(|| NONE.to_owned()), optional(ratio, 3)]);
        cells.extend(accuracies);
        cells.extend(counters.iter().map(|name| optional(trace.counters.get(*name).map(|each| each.per_ray), 4)));
        markdown.row(&cells);
    }
    let title = format!("{}: {}, {} rays", inline(rays), format::query(first.query), thousands(first.count));
    format!("\n### {title}\n\n{}", markdown.text)
}

/// One row a scene, tracer, way and ray set.
fn rows(updates: &Updates) -> Vec<Vec<String>> {
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
    for (scene, row, trace) in updates.scenes.iter().flat_map(|scene| {
        scene.rows.iter().flat_map(move |row| row.traces.iter().map(move |trace| (scene, row, trace)))
    }) {
        let fresh = fresh_of(scene, row);
        let beside = fresh.and_then(|fresh| trace_of(fresh, &trace.rays, &trace.rays_sha256));
        let (update, cost) = (&row.update, sah_cost(row));
        let timed = |ms: f64| number((!update.samples_ms.is_empty()).then_some(ms));
        let speed = metrics::speed_interval(trace);
        let mut cells = vec![
            scene.scene.name.clone(),
            scene.scene.sha256.clone(),
            scene.scene.triangles.to_string(),
            updates.frames.to_string(),
            updates.passes.to_string(),
            row.tracer.label(),
            row.tracer.name.clone(),
            serde_json::to_string(&row.tracer.parameters).unwrap_or_default(),
            row.way.clone(),
            clock_code(update.clock).to_owned(),
            timed(update.median_ms),
            timed(update.interval_ms[0]),
            timed(update.interval_ms[1]),
            number(over_fresh(update, fresh.map(|fresh| &fresh.update))),
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
        cells.extend([updates.provenance.commit.clone(), updates.preset.clone(), updates.provenance.machine.label()]);
        rows.push(cells);
    }
    rows
}
