//! The table of an ablation over one run: `table_NAME.md` and `table_NAME.csv`.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use super::ReportError;
use super::format::{NONE, clock_code, clock_of, mib, query, significant, statistic, thousands, with_interval};
use super::group::{Group, RaySet, Role, groups};
use super::markdown::{Table, inline};
use super::peers::stem;
use super::tables::{accuracy_columns, number, to_csv};
use super::{cells, metrics, summary};
use crate::ablation::peer;
use crate::contenders::Ablation;
use crate::results::{Ratio, Run, Timed, TraceRecord, TracerRun};

/// Statistics of structures that have columns of their own.
const STATISTICS: [&str; 2] = ["references", "nodes"];

/// The files: name and contents.
pub(crate) fn files(ablation: &Ablation, run: &Run) -> Result<Vec<(String, Vec<u8>)>, ReportError> {
    let mut run = run.clone();
    run.runs.retain(|row| ablation.holds(&row.tracer.name));
    run.skipped.retain(|row| row.tracer.as_deref().is_none_or(|name| ablation.holds(name)));
    let groups = groups(&run);
    let stem = stem(ablation.name);
    let csv = format!("{stem}.csv");
    let rows = to_csv(&csv, rows(&run, &groups))?;
    Ok(vec![(format!("{stem}.md"), page(ablation, &run, &groups).into_bytes()), (csv, rows)])
}

/// The rows that times are set against: the first one of the tracer, as published, and the peer.
fn references<'a>(group: &Group<'a>) -> [Option<&'a TracerRun>; 2] {
    let name = peer().map_or("", |peer| peer.name());
    let is_peer = |row: &&TracerRun| row.tracer.name == name;
    let rows = || group.contenders.iter().copied();
    [rows().find(|row| !is_peer(row)), rows().find(is_peer)]
}

fn trace_of<'a>(row: &'a TracerRun, set: &RaySet<'_>) -> Option<&'a TraceRecord> {
    row.traces.iter().find(|trace| set.holds(trace))
}

/// How many times as fast a row traces a set as another.
fn speed_over(run: &Run, set: &RaySet<'_>, reference: Option<&TracerRun>, row: &TracerRun) -> Option<Ratio> {
    let reference = reference?;
    run.paired(&Timed::trace(reference, trace_of(reference, set)?), &Timed::trace(row, trace_of(row, set)?)).ratio
}

fn page(ablation: &Ablation, run: &Run, groups: &[Group<'_>]) -> String {
    let mut text = summary::head(run, &format!("Table {}: {}", ablation.name, ablation.summary));
    let name = peer().map_or("", |peer| peer.name());
    let _ = writeln!(
        text,
        "\nRows are one switch after the other from the published form on, then the improved form, and that with single switches taken \
         back. × first and × {name} are how many times as fast a row is as the first one, and as {name} as published, in the same run."
    );
    for group in groups {
        let triangles = thousands(group.scene.triangles);
        let _ = writeln!(text, "\n## {} ({triangles} triangles)\n", inline(&group.scene.name));
        text += &structures(group);
        for set in &group.ray_sets {
            text += &traces(run, group, set);
        }
    }
    text + &summary::skipped(&run.skipped)
}

fn structures(group: &Group<'_>) -> String {
    let headings =
        ["row", "build clock", "build (ms) ↓", "structure (MiB) ↓", "references", "nodes", "phases of the build (ms)"];
    let mut table = Table::new(&headings.map(str::to_owned));
    for row in &group.contenders {
        let times = &row.build.times;
        let phase = |phase: &crate::results::PhaseRecord| format!("{} {}", phase.name, significant(phase.median_ms, 3));
        let [references, nodes] = STATISTICS
            .map(|name| row.structure_statistics.get(name).copied().map_or_else(|| NONE.to_owned(), statistic));
        table.row(&[
            row.label(),
            clock_of(times),
            with_interval(times.median_ms, times.interval_ms, 4),
            mib(row.memory.structure_bytes),
            references,
            nodes,
            times.phases.iter().map(phase).collect::<Vec<_>>().join(", "),
        ]);
    }
    table.text
}

fn traces(run: &Run, group: &Group<'_>, set: &RaySet<'_>) -> String {
    let all = group.traces(set);
    let rows: Vec<_> = all.iter().filter(|(role, ..)| *role == Role::Contender).cloned().collect();
    let counters: BTreeSet<&str> =
        rows.iter().flat_map(|(.., trace)| trace.counters.keys().map(String::as_str)).collect();
    let accuracies: &[&str] = match set.query {
        tracebench_api::Query::Closest => &["agreement hit_miss ↑", "agreement tight ↑", "agreement footprint ↑"],
        tracebench_api::Query::Any => &["balanced accuracy ↑"],
    };
    let name = peer().map_or("", |peer| peer.name());
    let mut headings = vec!["row".to_owned(), metrics::SPEED.heading(), "× first ↑".to_owned(), format!("× {name} ↑")];
    headings.extend(accuracies.iter().map(|&name| name.to_owned()));
    headings.extend(cells::counter_headings(&rows, &counters));
    let mut table = Table::new(&headings);
    for (role, row, trace) in &rows {
        let (judged, accuracies) = cells::accuracies(trace);
        let [label, _, _, speed, ..] = cells::speed_cells(*role, row, trace, judged);
        // A ratio is a speed: never without its accuracy.
        let ratios = references(group).map(|reference| speed_over(run, set, reference, row).filter(|_| judged));
        let told = |ratio: Option<Ratio>| {
            ratio.map_or_else(|| NONE.to_owned(), |ratio| with_interval(ratio.value, ratio.interval, 3))
        };
        let mut cells = vec![label, speed];
        cells.extend(ratios.map(told));
        cells.extend(accuracies);
        cells.extend(cells::counters(row, trace, &counters));
        table.row(&cells);
    }
    let title = format!("{}: {}, {} rays", inline(&set.title), query(set.query), thousands(set.count));
    format!("\n### {title}\n{}\n{}", cells::coverage(&all), table.text)
}

/// One row a tracer's row and ray set.
fn rows(run: &Run, groups: &[Group<'_>]) -> Vec<Vec<String>> {
    let counters: BTreeSet<&String> =
        run.runs.iter().flat_map(|row| &row.traces).flat_map(|trace| trace.counters.keys()).collect();
    let fixed = [
        "scene",
        "scene_sha256",
        "triangles",
        "viewpoint",
        "row",
        "build_clock",
        "build_median_ms",
        "structure_bytes",
        "references",
        "nodes",
        "rays",
        "rays_sha256",
        "count_rays",
        "clock",
        "mrays_per_s",
        "speed_over_first",
        "speed_over_peer",
        "agreement_hit_miss_share",
        "agreement_tight_share",
        "agreement_footprint_share",
        "balanced_accuracy_share",
        "ties_rays",
        "hits_sha256",
        "commit",
        "machine",
    ];
    let mut header: Vec<String> = fixed.map(str::to_owned).to_vec();
    header.extend(counters.iter().map(|name| format!("counter_{name}_per_ray")));
    let mut all = vec![header];
    for group in groups {
        for row in &group.contenders {
            for (set, trace) in group.ray_sets.iter().filter_map(|set| Some((set, trace_of(row, set)?))) {
                let ratios = references(group).map(|reference| speed_over(run, set, reference, row));
                let mut cells = vec![
                    row.scene.name.clone(),
                    row.scene.sha256.clone(),
                    row.scene.triangles.to_string(),
                    row.viewpoint.name.clone(),
                    row.label(),
                    clock_code(row.build.times.clock).to_owned(),
                    number(Some(row.build.times.median_ms)),
                    row.memory.structure_bytes.to_string(),
                ];
                cells.extend(STATISTICS.map(|name| number(row.structure_statistics.get(name).copied())));
                cells.extend([trace.rays.clone(), trace.rays_sha256.clone(), trace.count.to_string()]);
                cells.extend([clock_code(trace.times.clock).to_owned(), number(metrics::speed(trace))]);
                cells.extend(ratios.map(|ratio| number(ratio.map(|ratio| ratio.value))));
                cells.extend(accuracy_columns(trace));
                cells.extend([trace.hits_sha256.clone(), run.provenance.commit.clone()]);
                cells.push(run.provenance.machine_of(row.machine).label());
                cells.extend(
                    counters.iter().map(|name| number(trace.counters.get(*name).map(|counter| counter.per_ray))),
                );
                all.push(cells);
            }
        }
    }
    all
}
