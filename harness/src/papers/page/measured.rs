//! What was measured: a paper's own sections, then structures and traces of every scene and resolution.

use std::collections::BTreeSet;

use tracebench_api::Query;

use super::Page;
use crate::papers::rows::{self, trace};
use crate::papers::{SceneRows, Scope};
use crate::report::format::{self, NONE, clock_of, mib, significant, statistic, thousands, with_interval};
use crate::report::group::Role;
use crate::report::markdown::{Table, inline};
use crate::report::{cells, metrics};
use crate::results::{Judgement, Times, TraceRecord, TracerRun};

/// Headings.
pub(in crate::papers) fn strings(headings: &[&str]) -> Vec<String> {
    headings.iter().map(|heading| (*heading).to_owned()).collect()
}

/// What was measured: the paper's own sections, then every scene and resolution.
pub(super) fn sections(page: &Page<'_>) -> String {
    let mut text = String::from("\n## Here\n");
    text.extend(page.experiment.sections.iter().map(|section| section(page)));
    for scene in &page.rows.scenes {
        text.extend(scene.by_resolution().iter().map(|at| at_resolution(page, at)));
    }
    text
}

fn at_resolution(page: &Page<'_>, scene: &SceneRows<'_>) -> String {
    let Some(first) = scene.runs.first() else { return String::new() };
    let viewpoint = &first.viewpoint;
    let size = |[width, height]: [u32; 2]| format!("{width}x{height}");
    let mut text = format!(
        "\n### {} ({} triangles), rays from {}, frame {}, faces {}{}\n\n",
        inline(&scene.label),
        thousands(first.scene.triangles),
        size(viewpoint.ray_image),
        size(viewpoint.frame),
        viewpoint.face,
        inline(&viewpoint.said_of_rays())
    );
    text += &structures(page, scene);
    for set in scene.ray_sets() {
        text += &traces(scene, set);
    }
    text
}

/// Counts, bytes and builds; times only in runs that tell accuracies too.
fn structures(page: &Page<'_>, scene: &SceneRows<'_>) -> String {
    let timed = scene.runs.iter().any(|run| !run.traces.is_empty());
    let known = |name: &str| scene.runs.iter().any(|run| run.structure_statistics.contains_key(name));
    let counts: Vec<_> = page.paper.counts.iter().filter(|(name, _)| known(name)).collect();
    let mut headings = strings(&["tracer"]);
    headings.extend(counts.iter().map(|(_, heading)| (*heading).to_owned()));
    headings.extend(Scope::ALL.map(|(_, heading)| heading.to_owned()));
    headings.push("structure alone, allocated (MiB) ↓".to_owned());
    if timed {
        headings.extend([strings(&["build clock"]), vec![metrics::BUILD_TIME.heading()]].concat());
        headings.push("phases (ms)".to_owned());
    }
    let mut table = Table::new(&headings);
    for run in &scene.runs {
        let count = |name: &str| rows::statistic(run, name).map_or_else(|| NONE.to_owned(), statistic);
        let mut cells = vec![run.label()];
        cells.extend(counts.iter().map(|(name, _)| count(name)));
        cells.extend(Scope::ALL.map(|(scope, _)| bytes(page, run, scope)));
        cells.push(mib(run.memory.structure_bytes));
        if timed {
            let times = &run.build.times;
            cells.push(clock_of(times));
            cells.push(if times.samples_ms.is_empty() {
                NONE.to_owned()
            } else {
                with_interval(times.median_ms, times.interval_ms, 4)
            });
            cells.push(phases(times));
        }
        table.row(&cells);
    }
    table.text
}

/// Every phase by its median.
fn phases(times: &Times) -> String {
    let phases = times.phases.iter().map(|each| format!("{} {}", each.name, significant(each.median_ms, 3)));
    phases.collect::<Vec<_>>().join("; ")
}

/// Bytes in a scope.
pub(super) fn bytes(page: &Page<'_>, run: &TracerRun, scope: Scope) -> String {
    page.paper.bytes(run, scope).map_or_else(|| NONE.to_owned(), |bytes| mib(bytes as u64))
}

fn traces(scene: &SceneRows<'_>, set: &str) -> String {
    let all: Vec<(Role, &TracerRun, &TraceRecord)> =
        scene.runs.iter().filter_map(|run| Some((Role::Contender, *run, trace(run, set)?))).collect();
    let Some((.., first)) = all.first() else { return String::new() };
    let counters: BTreeSet<&str> =
        all.iter().flat_map(|(.., trace)| trace.counters.keys().map(String::as_str)).collect();
    let accuracies: &[&str] = match first.query {
        Query::Closest => &["agreement hit_miss ↑", "agreement tight ↑", "agreement footprint ↑"],
        Query::Any => &["balanced accuracy ↑"],
    };
    let mut headings = strings(&["tracer", "clock"]);
    headings.extend([metrics::SPEED.heading(), metrics::TRACE_TIME.heading()]);
    headings.extend(strings(accuracies));
    let in_phases = all.iter().any(|(.., trace)| trace.times.phases.len() > 1);
    headings.extend(in_phases.then(|| "phases (ms)".to_owned()));
    headings.extend(cells::counter_headings(&all, &counters));
    let mut table = Table::new(&headings);
    for (role, run, trace) in &all {
        let (judged, accuracies) = cells::accuracies(trace);
        let [label, clock, _, speed, time] = cells::speed_cells(*role, run, trace, judged);
        let mut row = vec![label, clock, speed, time];
        row.extend(accuracies);
        row.extend(in_phases.then(|| if judged { phases(&trace.times) } else { NONE.to_owned() }));
        row.extend(cells::counters(run, trace, &counters));
        table.row(&row);
    }
    let title = format!("{}: {}, {} rays", inline(set), format::query(first.query), thousands(first.count));
    format!("\n**{title}**\n{}\n{}", cells::coverage(&all), table.text)
}

/// Speed and accuracy in one cell.
pub(in crate::papers) fn speed_with_accuracy(trace: &TraceRecord) -> Option<(f64, String)> {
    let accuracy = match &trace.judgement {
        Judgement::Closest(closest) => closest.agreement.tight,
        Judgement::Any(any) => any.occlusion.balanced_accuracy,
    };
    let (speed, accuracy) = metrics::speed(trace).zip(accuracy)?;
    let share = format::percent(accuracy, metrics::trials(trace));
    Some((speed, format!("{} at {share} %", significant(speed, 4))))
}

/// What stands above tables of times by [`time_with_accuracy`].
pub(in crate::papers) const TIMES: &str = "Times are medians by the host's clock with the accuracy of the same rays: agreement under hit_miss and footprint, of \
                     any-hit sets balanced accuracy, the worst where several sets are added up.";

/// Milliseconds of traces by the host's clock with the accuracy of the same rays, the least of theirs: agreement under `hit_miss`
/// and `footprint`, of any-hit sets balanced accuracy. None where one could not be judged, so that no time stands without it.
pub(in crate::papers) fn time_with_accuracy(traces: &[&TraceRecord]) -> Option<(f64, String)> {
    let mut ms = 0.0;
    let mut least: Option<(f64, String)> = None;
    for trace in traces {
        let percent = |share: f64| format::percent(share, metrics::trials(trace));
        let (accuracy, text) = match &trace.judgement {
            Judgement::Closest(closest) => {
                let (hit_miss, footprint) = closest.agreement.hit_miss.zip(closest.agreement.footprint)?;
                (footprint, format!("{} / {} %", percent(hit_miss), percent(footprint)))
            }
            Judgement::Any(any) => {
                let balanced = any.occlusion.balanced_accuracy?;
                (balanced, format!("{} %", percent(balanced)))
            }
        };
        ms += crate::results::host_ms(&trace.times)?;
        if least.as_ref().is_none_or(|(least, _)| accuracy < *least) {
            least = Some((accuracy, text));
        }
    }
    least.map(|(_, text)| (ms, format!("{} at {text}", significant(ms, 4))))
}
