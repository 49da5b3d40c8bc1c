//! Tables of peers over one run: `table_NAME.md` and `table_NAME.csv`.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use super::ReportError;
use super::format::{
    self, NONE, clock_code, clock_of, mib, optional, significant, statistic, thousands, with_interval,
};
use super::group::{Group, RaySet, Role, groups};
use super::markdown::{Table as Markdown, inline};
use super::metrics;
use super::tables::{accuracy_columns, code, number, to_csv};
use super::{cells, summary};
use crate::peers::Table;
use crate::results::host_ms;
use crate::results::{Run, Times, TraceRecord, TracerRun};

/// Statistics of structures that have columns of their own, by their names in `validate`.
const NODES: &str = "nodes";
const SAH_COST: &str = "sah_cost";

/// The files of a table: name and contents. Rows are the tracers of the table's family.
pub(crate) fn files(table: &Table, run: &Run) -> Result<Vec<(String, Vec<u8>)>, ReportError> {
    let mut run = run.clone();
    run.runs.retain(|one| table.holds(&one.tracer.name));
    // What follows a name is a preset, or what was set.
    let is_held = |label: &str| table.holds(label.split([':', ' ']).next().unwrap_or_default());
    run.skipped.retain(|one| one.tracer.as_deref().is_none_or(is_held));
    let groups = groups(&run);
    let stem = stem(table.name);
    let csv = format!("{stem}.csv");
    let rows = to_csv(&csv, rows(table, &run, &groups))?;
    Ok(vec![(format!("{stem}.md"), page(table, &run, &groups).into_bytes()), (csv, rows)])
}

/// What the files of a table are called, without their ends.
pub(crate) fn stem(name: &str) -> String {
    format!("table_{}", name.replace('-', "_"))
}

/// How many times as fast as the reference, both by the host's clock.
fn ratio(reference: Option<&Times>, own: &Times) -> Option<f64> {
    Some(host_ms(reference?)? / host_ms(own)?)
}

/// Millions of triangles a second at the median and at the ends of its interval.
fn build_rate(run: &TracerRun) -> Option<(f64, [f64; 2])> {
    let times = &run.build.times;
    let rate = |ms: f64| run.scene.triangles as f64 / (ms * 1e3);
    let [fast, slow] = times.interval_ms;
    (!times.samples_ms.is_empty() && fast > 0.0).then(|| (rate(times.median_ms), [rate(slow), rate(fast)]))
}

fn statistic_of(run: &TracerRun, name: &str) -> Option<f64> {
    run.structure_statistics.get(name).copied()
}

/// Bytes of the structure a triangle: allocated, and used of them.
fn bytes_per_triangle(run: &TracerRun) -> [f64; 2] {
    let used: u64 = run.memory.structure.iter().map(|part| part.used_bytes).sum();
    [run.memory.structure_bytes, used].map(|bytes| bytes as f64 / run.scene.triangles.max(1) as f64)
}

/// The reference of a group: as published where that ran, since it comes first.
fn reference_of<'a>(table: &Table, group: &Group<'a>) -> Option<&'a TracerRun> {
    group.contenders.iter().find(|run| run.tracer.name == table.reference()).copied()
}

fn page(table: &Table, run: &Run, groups: &[Group<'_>]) -> String {
    let mut text = summary::head(run, &format!("Table {}: {}", table.name, table.summary));
    let _ = writeln!(
        text,
        "\n× {0} is how many times as fast as {0} (its first row) a tracer is in the same run, both by the host's clock: work on \
         the host as it is timed, work on the device from submission until done (`submit_to_done_median_ms`). Rates of device \
         work beside them are by the clock that their row names. SAH cost: node visits and triangle tests that a random line \
         through the root is expected to take; nodes of different widths differ in what a visit costs.",
        table.reference()
    );
    for group in groups {
        let triangles = thousands(group.scene.triangles);
        let _ = writeln!(text, "\n## {} ({triangles} triangles)\n", inline(&group.scene.name));
        text += &structures(table, group);
        for set in &group.ray_sets {
            text += &traces(table, group, set);
        }
    }
    text + &summary::skipped(&run.skipped)
}

fn structures(table: &Table, group: &Group<'_>) -> String {
    let reference = reference_of(table, group);
    let times = format!("× {} ↑", table.reference());
    let mut rows = Markdown::new(&[
        "tracer".to_owned(),
        "build clock".to_owned(),
        "build rate (Mtriangles/s) ↑".to_owned(),
        times,
        "nodes".to_owned(),
        metrics::STRUCTURE.heading(),
        "bytes a triangle, used of them ↓".to_owned(),
        "SAH cost ↓".to_owned(),
    ]);
    for run in &group.contenders {
        let rate = build_rate(run).map(|(rate, interval)| with_interval(rate, interval, 4));
        rows.row(&[
            run.label(),
            clock_of(&run.build.times),
            rate.unwrap_or_else(|| NONE.to_owned()),
            optional(ratio(reference.map(|run| &run.build.times), &run.build.times), 3),
            statistic_of(run, NODES).map_or_else(|| NONE.to_owned(), statistic),
            mib(run.memory.structure_bytes),
            bytes_per_triangle(run).map(|bytes| significant(bytes, 4)).join(", "),
            optional(statistic_of(run, SAH_COST), 4),
        ]);
    }
    rows.text
}

fn traces(table: &Table, group: &Group<'_>, set: &RaySet<'_>) -> String {
    let all = group.traces(set);
    let rows: Vec<_> = all.iter().filter(|(role, ..)| *role == Role::Contender).cloned().collect();
    let reference = rows.iter().find(|(_, run, _)| run.tracer.name == table.reference()).map(|(.., trace)| *trace);
    let counters: BTreeSet<&str> =
        rows.iter().flat_map(|(.., trace)| trace.counters.keys().map(String::as_str)).collect();
    let accuracies: &[&str] = match set.query {
        tracebench_api::Query::Closest => &["agreement hit_miss ↑", "agreement tight ↑", "agreement footprint ↑"],
        tracebench_api::Query::Any => &["balanced accuracy ↑"],
    };
    let mut headings = vec!["tracer".to_owned(), "clock".to_owned(), metrics::SPEED.heading()];
    headings.push(format!("× {} ↑", table.reference()));
    headings.extend(accuracies.iter().map(|&name| name.to_owned()));
    headings.extend(cells::counter_headings(&rows, &counters));
    let mut markdown = Markdown::new(&headings);
    for (role, run, trace) in &rows {
        let (judged, accuracies) = cells::accuracies(trace);
        let [label, clock, _, speed, ..] = cells::speed_cells(*role, run, trace, judged);
        // A ratio is a speed: never without its accuracy.
        let ratio = ratio(reference.map(|trace| &trace.times), &trace.times).filter(|_| judged);
        let mut cells = vec![label, clock, speed, optional(ratio, 3)];
        cells.extend(accuracies);
        cells.extend(cells::counters(run, trace, &counters));
        markdown.row(&cells);
    }
    let title = format!("{}: {}, {} rays", inline(&set.title), format::query(set.query), thousands(set.count));
    format!("\n### {title}\n{}\n{}", cells::coverage(&all), markdown.text)
}

/// One row a tracer and ray set, with every scalar of the table.
fn rows(table: &Table, run: &Run, groups: &[Group<'_>]) -> Vec<Vec<String>> {
    let all = || run.runs.iter();
    let statistics: BTreeSet<&String> = all().flat_map(|one| one.structure_statistics.keys()).collect();
    let counters: BTreeSet<&String> = all().flat_map(|one| &one.traces).flat_map(|one| one.counters.keys()).collect();
    let fixed = [
        "scene",
        "scene_sha256",
        "triangles",
        "viewpoint",
        "tracer",
        "tracer_name",
        "parameters_json",
        "residency",
        "build_clock",
        "build_mtriangles_per_s",
        "build_mtriangles_per_s_low",
        "build_mtriangles_per_s_high",
        "build_host_ms",
        "build_speed_over_reference",
        "structure_bytes",
        "bytes_per_triangle",
        "used_bytes_per_triangle",
        "rays",
        "rays_sha256",
        "query",
        "count_rays",
        "clock",
        "mrays_per_s",
        "mrays_per_s_low",
        "mrays_per_s_high",
        "trace_host_ms",
        "speed_over_reference",
        "agreement_hit_miss_share",
        "agreement_tight_share",
        "agreement_footprint_share",
        "balanced_accuracy_share",
        "ties_rays",
        "reference",
        "commit",
        "dirty",
        "run_preset",
        "machine",
    ];
    let mut header: Vec<String> = fixed.map(str::to_owned).to_vec();
    header.extend(statistics.iter().map(|name| format!("structure_{name}")));
    header.extend(counters.iter().map(|name| format!("counter_{name}_per_ray")));
    let mut rows = vec![header];
    for group in groups {
        let reference = reference_of(table, group);
        for one in &group.contenders {
            // A tracer without any traced set has a structure all the same.
            let traces: Vec<Option<&TraceRecord>> = match one.traces.as_slice() {
                [] => vec![None],
                traces => traces.iter().map(Some).collect(),
            };
            for trace in traces {
                let beside = trace.and_then(|trace| {
                    let same =
                        |other: &&TraceRecord| other.rays_sha256 == trace.rays_sha256 && other.rays == trace.rays;
                    reference?.traces.iter().find(same)
                });
                let mut row = structure_cells(one, reference);
                row.extend(trace.map_or_else(|| vec![String::new(); 15], |trace| trace_cells(trace, beside)));
                let dirty = run.provenance.dirty.map_or_else(String::new, |dirty| dirty.to_string());
                row.extend([table.reference().to_owned(), run.provenance.commit.clone(), dirty, run.preset.clone()]);
                row.push(run.provenance.machine.label());
                row.extend(statistics.iter().map(|name| number(statistic_of(one, name))));
                let counter =
                    |name: &&String| number(trace.and_then(|trace| trace.counters.get(*name)).map(|each| each.per_ray));
                row.extend(counters.iter().map(counter));
                rows.push(row);
            }
        }
    }
    rows
}

fn structure_cells(run: &TracerRun, reference: Option<&TracerRun>) -> Vec<String> {
    let rate = build_rate(run);
    let end = |index: usize| number(rate.map(|(_, interval)| interval[index]));
    vec![
        run.scene.name.clone(),
        run.scene.sha256.clone(),
        run.scene.triangles.to_string(),
        run.viewpoint.name.clone(),
        run.label(),
        run.tracer.name.clone(),
        serde_json::to_string(&run.tracer.parameters).unwrap_or_default(),
        run.tracer.residency.clone(),
        clock_code(run.build.times.clock).to_owned(),
        number(rate.map(|(rate, _)| rate)),
        end(0),
        end(1),
        number(host_ms(&run.build.times)),
        number(ratio(reference.map(|run| &run.build.times), &run.build.times)),
        run.memory.structure_bytes.to_string(),
        number(Some(bytes_per_triangle(run)[0])),
        number(Some(bytes_per_triangle(run)[1])),
    ]
}

fn trace_cells(trace: &TraceRecord, beside: Option<&TraceRecord>) -> Vec<String> {
    let interval = metrics::speed_interval(trace);
    let end = |index: usize| number(interval.map(|interval| interval[index]));
    let mut cells = vec![
        trace.rays.clone(),
        trace.rays_sha256.clone(),
        code(trace.query),
        trace.count.to_string(),
        clock_code(trace.times.clock).to_owned(),
        number(metrics::speed(trace)),
        end(0),
        end(1),
        number(host_ms(&trace.times)),
        number(ratio(beside.map(|trace| &trace.times), &trace.times)),
    ];
    cells.extend(accuracy_columns(trace));
    cells
}
