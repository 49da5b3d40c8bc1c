//! The table of equal means over one run: `table_means.md` and `table_means.csv`.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use super::ReportError;
use super::format::{NONE, clock_code, clock_of, mib, query, significant, thousands, with_interval};
use super::group::{Group, RaySet, Role, groups};
use super::markdown::{Table, inline};
use super::tables::{accuracy_columns, number, to_csv};
use super::{cells, metrics, summary};
use crate::results::{Answer, Means, Paired, Run, Timed, TraceRecord, TracerRun, at_means};

/// By how much speeds may differ and still be the same, a share.
const SAME: f64 = 0.05;

/// The files: name and contents.
pub(crate) fn files(run: &Run) -> Result<Vec<(String, Vec<u8>)>, ReportError> {
    let mut run = run.clone();
    run.runs.retain(|row| row.tracer.means().is_some());
    let groups = groups(&run);
    let csv = "table_means.csv";
    let rows = to_csv(csv, rows(&run, &groups))?;
    Ok(vec![("table_means.md".to_owned(), page(&run, &groups).into_bytes()), (csv.to_owned(), rows)])
}

/// The row of the same tracer by the means that all take where nothing is set.
fn by_default<'a>(run: &Run, group: &Group<'a>, of: &TracerRun) -> Option<&'a TracerRun> {
    let default = &run.provenance.means.as_ref()?.means;
    let is_default =
        |row: &&TracerRun| row.tracer.name == of.tracer.name && row.tracer.means().as_ref() == Some(default);
    group.contenders.iter().copied().find(is_default)
}

/// A row's trace of a ray set.
fn trace_of<'a>(row: &'a TracerRun, set: &RaySet<'_>) -> Option<&'a TraceRecord> {
    row.traces.iter().find(|trace| set.holds(trace))
}

/// How many times as long one took over a ray set as the other.
fn paired(run: &Run, set: &RaySet<'_>, one: &TracerRun, other: &TracerRun) -> Option<Paired> {
    let found = run.paired(&Timed::trace(one, trace_of(one, set)?), &Timed::trace(other, trace_of(other, set)?));
    found.ratio.is_some().then_some(found)
}

fn page(run: &Run, groups: &[Group<'_>]) -> String {
    let mut text =
        summary::head(run, "Table means: every tracer that searches on the device, by each way to read and to launch");
    let _ = writeln!(
        text,
        "\n`reads` is what a search reads the structure from, `rays_per_lane` how many rays a lane answers one after the other; both are \
         the same choice for every tracer. × default is how many times as fast a row is as the same tracer by the means that are taken \
         here where nothing is set."
    );
    if let Some(taken) = &run.provenance.means {
        let told = taken.probe.as_ref().map(|probe| {
            let (texture, many) = (probe.texture_gain(), probe.many_rays_gain());
            let [texture, many] = [texture, many].map(|gain| significant(gain, 3));
            format!(
                ": in the probe textures were {texture} times as fast as buffers, {} rays a lane {many} times as one",
                probe.many_rays
            )
        });
        let _ = writeln!(text, "Default: {}{}.", taken.means, told.unwrap_or_else(|| ", as given".to_owned()));
    }
    for group in groups {
        let triangles = thousands(group.scene.triangles);
        let _ = writeln!(text, "\n## {} ({triangles} triangles)\n", inline(&group.scene.name));
        text += &structures(group);
        for set in &group.ray_sets {
            text += &traces(run, group, set);
            text += &between(run, group, set);
        }
    }
    text + &summary::skipped(&run.skipped)
}

fn structures(group: &Group<'_>) -> String {
    let headings = ["tracer", "build clock", "build (ms) ↓", "structure (MiB) ↓", "phases of the build (ms)"];
    let mut table = Table::new(&headings.map(str::to_owned));
    let mut shown: BTreeSet<(&str, String)> = BTreeSet::new();
    for row in &group.contenders {
        // The launch does not shape it.
        let Some(Means { reads, .. }) = row.tracer.means() else { continue };
        if !shown.insert((&row.tracer.name, reads.clone())) {
            continue;
        }
        let times = &row.build.times;
        let phase = |phase: &crate::results::PhaseRecord| format!("{} {}", phase.name, significant(phase.median_ms, 3));
        table.row(&[
            format!("{} reads={reads}", row.tracer.name),
            clock_of(times),
            with_interval(times.median_ms, times.interval_ms, 4),
            mib(row.memory.structure_bytes),
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
    let mut headings = ["tracer", "clock"].map(str::to_owned).to_vec();
    headings.extend([metrics::SPEED.heading(), "× default ↑".to_owned(), "hits".to_owned()]);
    headings.extend(accuracies.iter().map(|&name| name.to_owned()));
    headings.extend(cells::counter_headings(&rows, &counters));
    let mut table = Table::new(&headings);
    for (role, row, trace) in &rows {
        let (judged, accuracies) = cells::accuracies(trace);
        let [label, clock, _, speed, ..] = cells::speed_cells(*role, row, trace, judged);
        let default = by_default(run, group, row);
        // A ratio is a speed: never without its accuracy.
        let ratio = default.filter(|_| judged).and_then(|default| paired(run, set, default, row)?.ratio);
        let ratio = ratio.map_or_else(|| NONE.to_owned(), |ratio| with_interval(ratio.value, ratio.interval, 3));
        let first = rows.iter().find(|(_, other, _)| other.tracer.name == row.tracer.name);
        let same = first.is_none_or(|(.., first)| first.hits_sha256 == trace.hits_sha256);
        let mut cells = vec![label, clock, speed, ratio, if same { "the same" } else { "OTHERS" }.to_owned()];
        cells.extend(accuracies);
        cells.extend(cells::counters(row, trace, &counters));
        table.row(&cells);
    }
    let title = format!("{}: {}, {} rays", inline(&set.title), query(set.query), thousands(set.count));
    format!("\n### {title}\n{}\n{}", cells::coverage(&all), table.text)
}

/// What is said of one beside another.
fn said(answer: &Answer) -> &'static str {
    match answer {
        Answer::Longer => "slower",
        Answer::Shorter => "faster",
        Answer::Same => "the same",
        Answer::Undecided(_) => "undecided",
    }
}

/// Every two methods at equal means and at each one's best.
fn between(run: &Run, group: &Group<'_>, set: &RaySet<'_>) -> String {
    let mut names: Vec<&str> = Vec::new();
    for row in &group.contenders {
        if !names.contains(&&*row.tracer.name) {
            names.push(&row.tracer.name);
        }
    }
    let of = |name: &str| -> Vec<&TracerRun> {
        group.contenders.iter().copied().filter(|row| row.tracer.name == name).collect()
    };
    let time_ms = |row: &TracerRun| {
        trace_of(row, set).filter(|trace| !trace.times.samples_ms.is_empty()).map(|trace| trace.times.median_ms)
    };
    let headings = ["method", "beside", "× as fast at equal means", "× as fast at each one's best", "so it is"];
    let mut table = Table::new(&headings.map(str::to_owned));
    let mut rows = 0;
    for (place, one) in names.iter().enumerate() {
        for other in &names[place + 1..] {
            // The time of the other over that of the one is the speed of the one over that of the other.
            let found = at_means(&of(one), &of(other), time_ms, |one, other| paired(run, set, other, one));
            let cell =
                |found: &Paired| found.ratio.map_or_else(|| NONE.to_owned(), |ratio| significant(ratio.value, 3));
            let equal: Vec<String> =
                found.equal.iter().map(|(means, found)| format!("{} ({means})", cell(found))).collect();
            let best = found.best.as_ref().map_or_else(
                || NONE.to_owned(),
                |([one, other], found)| {
                    let [one, other] =
                        [one, other].map(|means| means.as_ref().map_or_else(String::new, ToString::to_string));
                    format!("{} ({one} beside {other})", cell(found))
                },
            );
            let verdict = found.agreed(|found| said(&found.answer(SAME))).map(|said| match said {
                // How long the other takes.
                "slower" => "faster",
                "faster" => "slower",
                said => said,
            });
            let verdict = verdict.unwrap_or("undecided");
            table.row(&[(*one).to_owned(), (*other).to_owned(), equal.join(", "), best, verdict.to_owned()]);
            rows += 1;
        }
    }
    if rows == 0 { String::new() } else { format!("\n{}", table.text) }
}

/// One row a tracer, its means and a ray set.
fn rows(run: &Run, groups: &[Group<'_>]) -> Vec<Vec<String>> {
    let counters: BTreeSet<&String> =
        run.runs.iter().flat_map(|row| &row.traces).flat_map(|trace| trace.counters.keys()).collect();
    let fixed = [
        "scene",
        "scene_sha256",
        "triangles",
        "viewpoint",
        "tracer",
        "reads",
        "rays_per_lane",
        "build_clock",
        "build_median_ms",
        "structure_bytes",
        "rays",
        "rays_sha256",
        "count_rays",
        "clock",
        "mrays_per_s",
        "speed_over_default",
        "speed_over_default_low",
        "speed_over_default_high",
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
            let Some(Means { reads, rays_per_lane }) = row.tracer.means() else { continue };
            for (set, trace) in group.ray_sets.iter().filter_map(|set| Some((set, trace_of(row, set)?))) {
                let ratio = by_default(run, group, row).and_then(|default| paired(run, set, default, row)?.ratio);
                let mut cells = vec![
                    row.scene.name.clone(),
                    row.scene.sha256.clone(),
                    row.scene.triangles.to_string(),
                    row.viewpoint.name.clone(),
                    row.tracer.name.clone(),
                    reads.clone(),
                    rays_per_lane.to_string(),
                    clock_code(row.build.times.clock).to_owned(),
                    number(Some(row.build.times.median_ms)),
                    row.memory.structure_bytes.to_string(),
                    trace.rays.clone(),
                    trace.rays_sha256.clone(),
                    trace.count.to_string(),
                    clock_code(trace.times.clock).to_owned(),
                    number(metrics::speed(trace)),
                    number(ratio.map(|ratio| ratio.value)),
                    number(ratio.map(|ratio| ratio.interval[0])),
                    number(ratio.map(|ratio| ratio.interval[1])),
                ];
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
