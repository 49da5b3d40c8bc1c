//! `summary.md`: the run for people. No row tells a speed without the accuracy of the same trace.

use std::fmt::Write as _;

use tracebench_api::{Query, Rasterizer};

use super::cells::{Row, accuracies, coverage, label, speed_cells, touched};
use super::distances;
use super::format::{self, NONE, clock_of, mib, optional, percent, significant, statistic, thousands, with_interval};
use super::group::{Group, RaySet, Role};
use super::markdown::{Table, inline};
use super::metrics::{self, Metric};
use super::surfaces;
use super::verdict::{self, Verdict};
use crate::results::{
    AnyJudgement, Classes, EndedBy, Judgement, LEAST_ROUNDS, MARK, Provenance, RaceRecord, Run, Skipped,
};

/// How many causes a row names.
const TOP_CAUSES: usize = 5;

/// The whole summary.
pub(super) fn summary(run: &Run, groups: &[Group<'_>]) -> String {
    let mut text = head(run, "tracebench: speed and accuracy of the same rays");
    if groups.is_empty() {
        text += "\nNothing ran.\n";
    }
    for group in groups {
        text += &scene(group);
        text += &build_table(group);
        for set in &group.ray_sets {
            text += &ray_set(group, set);
        }
    }
    text + &skipped(&run.skipped)
}

/// What holds of the whole run, below a title.
pub(crate) fn head(run: &Run, title: &str) -> String {
    let mut text = head_of(&run.provenance, &run.preset, run.seed, &verdict::controls(run), title);
    if !run.races.is_empty() {
        let _ = writeln!(text, "- Clock: {}", inline(&clock(run)));
    }
    text += "\n";
    if run.provenance.machine.adapter.as_ref().is_some_and(|adapter| adapter.kind == "software") {
        text += "**The adapter is software: accuracy, counters and bytes lead; device times are those of a software \
                 adapter and say little of hardware.**\n\n";
    }
    if run.runs.iter().any(|row| row.window > 0) {
        let _ = writeln!(
            text,
            "Not all contenders fit one window, in which they take turns. Rows with{MARK} were measured in a later one; their times \
             are set as the first contender's of their scene, which every window has, was slower or faster there.\n"
        );
    }
    text += "Times are medians with an order-statistic interval in brackets; shares have 95 % Wilson intervals. Ties, \
             rays whose truth hangs on rounding, are left out of every share. Each time names its clock; times of \
             different clocks do not compare. ↑ more is better, ↓ less is better. 1 MiB is 2^20 bytes.\n";
    text
}

/// How long was sampled, and which races decide nothing.
fn clock(run: &Run) -> String {
    let rounds = || run.races.iter().map(|race| race.orders.len());
    let (fewest, most) = (rounds().min(), rounds().max());
    let name = |race: &RaceRecord| format!("{} of {}", race.work, race.scene);
    let those = |what: &str, wanted: &dyn Fn(&RaceRecord) -> bool| {
        let found: Vec<String> = run.races.iter().filter(|race| wanted(race)).map(name).collect();
        if found.is_empty() { String::new() } else { format!("; {what} in {}: {}", found.len(), found.join(", ")) }
    };
    let (fewest, most) = (fewest.unwrap_or(0), most.unwrap_or(0));
    let few = if fewest < LEAST_ROUNDS as usize { "; fewer than 12 decide nothing" } else { "" };
    format!(
        "{} races of {fewest} to {most} rounds{few}{}{}{}",
        run.races.len(),
        those("intervals wider than wanted when the time was up", &|race| race.ended_by == EndedBy::TimeLimit),
        those("**drift**", &|race| race.drift),
        those("**void times**", &|race| race.twice.iter().any(|twice| !twice.passed)),
    )
}

/// Where, when and of what something was measured, below a title.
pub(super) fn head_of(from: &Provenance, preset: &str, seed: u64, controls: &Verdict, title: &str) -> String {
    let mut text = format!("# {title}\n\n");
    let mut item = |name: &str, value: String| {
        let _ = writeln!(text, "- {name}: {}", inline(&value));
    };
    item("Machine", from.machine.label());
    if let Some(adapter) = &from.machine.adapter {
        let timestamps = if adapter.timestamps { "device timestamps" } else { "no device timestamps" };
        item(
            "Adapter",
            format!(
                "{} ({}, {}, {} {}), {timestamps}",
                adapter.name, adapter.kind, adapter.backend, adapter.driver, adapter.driver_version
            ),
        );
    }
    if let Some(found) = &from.machine.rasterizer {
        let Rasterizer { snap_pixels, depth_error, depth_error_beyond_view, reach } = found;
        item(
            "Rasterizer",
            format!(
                "borders drawn up to {snap_pixels:.4} pixels from where they are; interpolated depth off by {depth_error:.1e}, of \
                 triangles that reach far out of the view by {depth_error_beyond_view:.1e}; triangles drawn whole up to {reach:.0} heights of \
                 the eye above them"
            ),
        );
    }
    let memory = from.machine.memory_bytes.map_or_else(|| "unknown".to_owned(), |bytes| format!("{} MiB", mib(bytes)));
    item("System", format!("{}; memory {memory}; {}", from.machine.os, from.machine.rustc));
    let tree = match from.dirty {
        Some(true) => " with uncommitted changes",
        Some(false) => "",
        None => " (unknown whether the tree was changed)",
    };
    item("Commit", format!("{}{tree}", from.commit));
    let preset = match preset {
        "smoke" => "smoke (smoke run: figures only show that things work)",
        other => other,
    };
    item("Preset", preset.to_owned());
    item("Seed", seed.to_string());
    item("Started", from.started.clone());
    item("Controls", controls.sentence());
    text
}

fn scene(group: &Group<'_>) -> String {
    let (scene, viewpoint) = (group.scene, group.viewpoint);
    let mut text = format!("\n## {} ({} triangles)\n\n", inline(&scene.name), thousands(scene.triangles));
    let _ = write!(
        text,
        "Hash `{}`, diagonal {} scene units",
        format::hash_prefix(&scene.sha256),
        significant(scene.diagonal, 4)
    );
    if let Some(scale) = scene.scale {
        let _ = write!(text, ", scale {scale}");
    }
    let [x, y, z] = viewpoint.eye.map(|each| significant(f64::from(each), 4));
    let _ = writeln!(
        text,
        ". Viewpoint {} at ({x}, {y}, {z}), {}° vertical field of view, time {} s; rays start from the pixels of a \
         {} image{}.",
        inline(&viewpoint.name),
        significant(f64::from(viewpoint.vertical_fov_degrees), 4),
        viewpoint.time_s,
        size(viewpoint.ray_image),
        viewpoint.said_of_rays()
    );
    if scene.zero_area_triangles_dropped + scene.duplicate_triangles_kept > 0 {
        let _ = writeln!(
            text,
            "\nImport: {} triangles of zero area dropped, {} duplicate triangles kept.",
            thousands(scene.zero_area_triangles_dropped),
            thousands(scene.duplicate_triangles_kept)
        );
    }
    for warning in &scene.warnings {
        let _ = writeln!(text, "\nImport: {}.", inline(warning.trim_end_matches('.')));
    }
    let stem = &group.stem;
    let _ = writeln!(text, "\n![Error against speed](error_vs_speed_{stem}.svg)");
    if group.ray_sets.iter().any(|set| set.query == Query::Closest) {
        let _ = writeln!(text, "\n![Agreement over tolerance](agreement_over_tolerance_{stem}.svg)");
    }
    text
}

fn build_table(group: &Group<'_>) -> String {
    // Runs of before structures were asked have nothing to say here.
    let says = group.contenders.iter().any(|run| !run.structure_statistics.is_empty());
    let mut headings = vec![
        "tracer".to_owned(),
        "residency".to_owned(),
        "frame, faces (px)".to_owned(),
        "clock".to_owned(),
        metrics::BUILD_TIME.heading(),
        "phases (ms)".to_owned(),
        metrics::STRUCTURE.heading(),
        metrics::GEOMETRY.heading(),
        metrics::BUILD_PEAK.heading(),
    ];
    if says {
        headings.push("what the structure says of itself".to_owned());
    }
    let mut table = Table::new(&headings);
    for run in &group.contenders {
        let build = &run.build;
        let time = match build.times.samples_ms.is_empty() {
            true => NONE.to_owned(),
            false => with_interval(build.times.median_ms, build.times.interval_ms, 4),
        };
        let phases: Vec<_> = build
            .times
            .phases
            .iter()
            .map(|phase| format!("{} {}", phase.name, significant(phase.median_ms, 3)))
            .collect();
        let mut cells = vec![
            run.label(),
            run.tracer.residency.clone(),
            format!("{}, {}", size(run.viewpoint.frame), run.viewpoint.face),
            clock_of(&build.times),
            time,
            phases.join("; "),
            mib(run.memory.structure_bytes),
            mib(run.memory.geometry_bytes),
            mib(run.memory.build_peak_bytes),
        ];
        if says {
            let said = run.structure_statistics.iter().map(|(name, value)| format!("{name} {}", statistic(*value)));
            cells.push(said.collect::<Vec<_>>().join("; "));
        }
        table.row(&cells);
    }
    if group.contenders.is_empty() { String::new() } else { format!("\n### Build\n\n{}", table.text) }
}

fn ray_set(group: &Group<'_>, set: &RaySet<'_>) -> String {
    let rows = group.traces(set);
    let mut text = format!(
        "\n### {}: {}, {} rays{}\n",
        inline(&set.title),
        format::query(set.query),
        thousands(set.count),
        surfaces::heading(&rows)
    );
    if rows.iter().any(|(_, _, trace)| many_ties(&trace.judgement)) {
        text += "\n**More than one ray in a thousand is a tie.**\n";
    }
    text += &coverage(&rows);
    match set.query {
        Query::Closest => closest_tables(&mut text, &rows),
        Query::Any => any_tables(&mut text, &rows),
    }
    text += &distances::tables(&rows);
    text += &surfaces::tables(&rows);
    text += &causes(&rows);
    text += &counters(&rows);
    text += &statuses(&rows);
    text
}

fn closest_tables(text: &mut String, rows: &[Row<'_>]) {
    let agreement = |metric: &Metric| format!("agreement {}", metric.heading());
    let mut main = Table::new(&[
        "tracer".to_owned(),
        "clock".to_owned(),
        "rays".to_owned(),
        metrics::SPEED.heading(),
        metrics::TRACE_TIME.heading(),
        agreement(&metrics::HIT_MISS),
        agreement(&metrics::TIGHT),
        agreement(&metrics::FOOTPRINT),
        "position error p50 / p95 / p99 (scene units) ↓".to_owned(),
        metrics::IDENTITY.heading(),
        metrics::TIES.heading(),
    ]);
    let mut classes = Table::new(
        &["tracer", "rule", "true hit", "true miss", "false hit", "false miss", "early", "late"].map(str::to_owned),
    );
    for (role, run, trace) in rows {
        let Judgement::Closest(judgement) = &trace.judgement else { continue };
        let (judged, accuracies) = accuracies(trace);
        let mut cells = speed_cells(*role, run, trace, judged).to_vec();
        cells.extend(accuracies);
        let position = judgement.position_error;
        cells.push(format!(
            "{} / {} / {}",
            optional(position.p50, 3),
            optional(position.p95, 3),
            optional(position.p99, 3)
        ));
        let identities = judgement.classes.tight.true_hit;
        cells.push(
            judgement.identity.map_or_else(|| NONE.to_owned(), |share| format!("{} %", percent(share, identities))),
        );
        cells.push(thousands(judgement.ties));
        main.row(&cells);
        for (rule, counts) in [("tight", &judgement.classes.tight), ("footprint", &judgement.classes.footprint)] {
            let Classes { true_hit, true_miss, false_hit, false_miss, early, late } = counts;
            let counts = [true_hit, true_miss, false_hit, false_miss, early, late].map(|count| thousands(*count));
            let mut cells = vec![label(*role, run), rule.to_owned()];
            cells.extend(counts);
            classes.row(&cells);
        }
    }
    let _ = write!(text, "\n{}\nClasses, rays:\n\n{}", main.text, classes.text);
}

fn any_tables(text: &mut String, rows: &[Row<'_>]) {
    let mut main = Table::new(&[
        "tracer".to_owned(),
        "clock".to_owned(),
        "rays".to_owned(),
        metrics::SPEED.heading(),
        metrics::TRACE_TIME.heading(),
        metrics::BALANCED.heading(),
        "rightly occluded".to_owned(),
        "rightly free".to_owned(),
        "wrongly occluded ↓".to_owned(),
        "wrongly free ↓".to_owned(),
        metrics::TIES.heading(),
    ]);
    for (role, run, trace) in rows {
        let Judgement::Any(AnyJudgement { occlusion, ties, .. }) = &trace.judgement else { continue };
        let (judged, accuracies) = accuracies(trace);
        let mut cells = speed_cells(*role, run, trace, judged).to_vec();
        cells.extend(accuracies);
        let counts = [occlusion.true_occluded, occlusion.true_free, occlusion.false_occluded, occlusion.false_free];
        cells.extend(counts.map(thousands));
        cells.push(thousands(*ties));
        main.row(&cells);
    }
    let _ = write!(text, "\n{}", main.text);
}

fn causes(rows: &[Row<'_>]) -> String {
    let mut table = Table::new(&["tracer", "rule", "wrong rays", "causes, most frequent first"].map(str::to_owned));
    let mut any = false;
    for (role, run, trace) in rows.iter().filter(|(role, ..)| *role == Role::Contender) {
        for (rule, causes) in trace.judgement.causes() {
            let all: u64 = causes.values().sum();
            let mut sorted: Vec<_> = causes.iter().filter(|(_, rays)| **rays > 0).collect();
            sorted.sort_by_key(|(name, rays)| (std::cmp::Reverse(**rays), (*name).clone()));
            let share = |rays: u64| rays as f64 / all.max(1) as f64 * 100.0;
            let named =
                |(name, rays): &(&String, &u64)| format!("{name} {} ({:.1} %)", thousands(**rays), share(**rays));
            let mut listed: Vec<_> = sorted.iter().take(TOP_CAUSES).map(named).collect();
            if sorted.len() > TOP_CAUSES {
                let rest: u64 = sorted[TOP_CAUSES..].iter().map(|(_, rays)| **rays).sum();
                listed.push(format!("others {} ({:.1} %)", thousands(rest), share(rest)));
            }
            if !listed.is_empty() {
                table.row(&[label(*role, run), rule.clone(), thousands(all), listed.join(", ")]);
                any = true;
            }
        }
    }
    if any { format!("\nCauses of wrong answers:\n\n{}", table.text) } else { String::new() }
}

fn counters(rows: &[Row<'_>]) -> String {
    let mut table =
        Table::new(&["tracer", "counter", "mean per ray", "greatest per ray", "over the whole set"].map(str::to_owned));
    let mut any = false;
    for (role, run, trace) in rows.iter().filter(|(role, ..)| *role == Role::Contender) {
        for (name, counter) in &trace.counters {
            let greatest = counter.greatest_per_ray.map_or(NONE.to_owned(), thousands);
            let (mean, whole) = match touched(run, name, counter) {
                Some(touched) => (NONE.to_owned(), touched),
                None => (significant(counter.per_ray, 4), NONE.to_owned()),
            };
            table.row(&[label(*role, run), name.clone(), mean, greatest, whole]);
            any = true;
        }
    }
    if any { format!("\nCounters, from a variant that is not timed:\n\n{}", table.text) } else { String::new() }
}

fn statuses(rows: &[Row<'_>]) -> String {
    let mut table = Table::new(&["tracer", "rays by the status that the tracer gave"].map(str::to_owned));
    let mut any = false;
    for (role, run, trace) in rows.iter().filter(|(role, ..)| *role == Role::Contender) {
        let named = trace.statuses.iter().filter(|(_, rays)| **rays > 0);
        let listed: Vec<_> = named.map(|(name, rays)| format!("{name} {}", thousands(*rays))).collect();
        if !listed.is_empty() {
            table.row(&[label(*role, run), listed.join(", ")]);
            any = true;
        }
    }
    if any { format!("\nHow rays ended:\n\n{}", table.text) } else { String::new() }
}

/// What did not run.
pub(crate) fn skipped(skipped: &[Skipped]) -> String {
    let mut text = "\n## Skipped\n\n".to_owned();
    if skipped.is_empty() {
        return text + "Nothing.\n";
    }
    let mut table = Table::new(&["tracer", "scene", "rays", "reason"].map(str::to_owned));
    for each in skipped {
        let or_all = |name: &Option<String>| name.clone().unwrap_or_else(|| "all".to_owned());
        table.row(&[or_all(&each.tracer), each.scene.clone(), or_all(&each.rays), each.reason.clone()]);
    }
    text += &table.text;
    text
}

fn many_ties(judgement: &Judgement) -> bool {
    match judgement {
        Judgement::Closest(judgement) => judgement.many_ties,
        Judgement::Any(judgement) => judgement.many_ties,
    }
}

fn size([width, height]: [u32; 2]) -> String {
    format!("{width}×{height}")
}
