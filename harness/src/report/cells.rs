//! Cells of tables that tell of traces: never a speed without its accuracy.

use std::collections::BTreeSet;

use super::format::{NONE, clock_of, percent_with_interval, significant, statistic, thousands, with_interval};
use super::group::Role;
use super::metrics;
use crate::results::{Classes, ClosestJudgement, CounterRecord, Judgement, Occlusion, TraceRecord, TracerRun};

/// A trace with its place in the table.
pub(crate) type Row<'a> = (Role, &'a TracerRun, &'a TraceRecord);

/// Label, clock, rays, speed and time; the last two only beside an accuracy, and never for controls, which trace
/// nothing.
pub(crate) fn speed_cells(role: Role, run: &TracerRun, trace: &TraceRecord, judged: bool) -> [String; 5] {
    let clock = if role == Role::Control { NONE.to_owned() } else { clock_of(&trace.times) };
    let speed = metrics::speed(trace).filter(|_| judged && role == Role::Contender);
    let [speed, time] = match speed {
        Some(speed) => {
            let interval = metrics::speed_interval(trace).unwrap_or([speed, speed]);
            [with_interval(speed, interval, 4), with_interval(trace.times.median_ms, trace.times.interval_ms, 4)]
        }
        None => [NONE.to_owned(), NONE.to_owned()],
    };
    [label(role, run), clock, thousands(trace.count), speed, time]
}

/// Whether anything could be judged, and the cells that tell the accuracy of a trace: three of a closest-hit set, one of
/// an any-hit set.
pub(crate) fn accuracies(trace: &TraceRecord) -> (bool, Vec<String>) {
    accuracies_of(&trace.judgement, metrics::trials(trace))
}

/// [`accuracies`] of so many rays that count.
pub(super) fn accuracies_of(judgement: &Judgement, trials: u64) -> (bool, Vec<String>) {
    match judgement {
        Judgement::Closest(closest) => (closest.agreement.tight.is_some(), agreements(closest, trials).to_vec()),
        Judgement::Any(any) => (any.occlusion.balanced_accuracy.is_some(), vec![accuracy(&any.occlusion, trials)]),
    }
}

/// The three agreements, always together: share, interval, wrong rays.
fn agreements(judgement: &ClosestJudgement, trials: u64) -> [String; 3] {
    let (agreement, interval) = (&judgement.agreement, &judgement.interval);
    let hit_or_miss = |classes: &Classes| classes.false_hit + classes.false_miss;
    let all = |classes: &Classes| hit_or_miss(classes) + classes.early + classes.late;
    let cell = |share: Option<f64>, interval, wrong| match share {
        Some(share) => {
            let share = percent_with_interval(share, interval, trials);
            format!("{share}; {} wrong of {}", thousands(wrong), thousands(trials))
        }
        None => "every ray is a tie".to_owned(),
    };
    [
        cell(agreement.hit_miss, interval.hit_miss, hit_or_miss(&judgement.classes.tight)),
        cell(agreement.tight, interval.tight, all(&judgement.classes.tight)),
        cell(agreement.footprint, interval.footprint, all(&judgement.classes.footprint)),
    ]
}

/// The accuracy of an any-hit set: share, interval, wrong rays.
fn accuracy(occlusion: &Occlusion, trials: u64) -> String {
    let wrong = occlusion.false_occluded + occlusion.false_free;
    occlusion.balanced_accuracy.map_or_else(
        || "every ray is a tie".to_owned(),
        |share| {
            let share = percent_with_interval(share, occlusion.balanced_accuracy_interval, trials);
            format!("{share}; {} wrong of {}", thousands(wrong), thousands(trials))
        },
    )
}

/// The intervals' coverage, which few samples cannot bring to 95 %.
pub(crate) fn coverage(rows: &[Row<'_>]) -> String {
    let timed = rows.iter().filter(|(role, _, trace)| *role == Role::Contender && !trace.times.samples_ms.is_empty());
    let (mut low, mut high, mut samples) = (f64::INFINITY, 0.0_f64, u64::MAX);
    for (_, _, trace) in timed {
        low = low.min(trace.times.interval_coverage);
        high = high.max(trace.times.interval_coverage);
        samples = samples.min(trace.times.samples_ms.len() as u64);
    }
    if !low.is_finite() {
        return String::new();
    }
    let share = |share: f64| format!("{:.1} %", share * 100.0);
    let range = if low == high { share(low) } else { format!("{} to {}", share(low), share(high)) };
    format!("\nAt least {samples} samples a row; the intervals of times cover the median with {range}.\n")
}

/// How much of what a structure stores a set of rays touched: the count, and the share where the structure says how many of
/// the same it has. `None` for what is counted ray by ray.
pub(super) fn touched(run: &TracerRun, name: &str, counter: &CounterRecord) -> Option<String> {
    if counter.greatest_per_ray.is_some() {
        return None;
    }
    let stored =
        name.strip_suffix("_touched").and_then(|of| run.structure_statistics.get(of)).filter(|all| **all > 0.0);
    Some(match stored {
        Some(stored) => {
            let share = significant(counter.total as f64 / stored * 100.0, 3);
            format!("{} ({share} % of {})", thousands(counter.total), statistic(*stored))
        }
        None => thousands(counter.total),
    })
}

/// Headings of counters: means per ray, but for what is counted over a set.
pub(crate) fn counter_headings(rows: &[Row<'_>], names: &BTreeSet<&str>) -> Vec<String> {
    let of_set = |name: &str| {
        let counters = rows.iter().filter_map(|(.., trace)| trace.counters.get(name));
        counters.into_iter().any(|counter| counter.greatest_per_ray.is_none())
    };
    names.iter().map(|name| if of_set(name) { format!("{name} ↓") } else { format!("{name} per ray ↓") }).collect()
}

/// Cells of counters: the mean per ray, or what a set touched.
pub(crate) fn counters(run: &TracerRun, trace: &TraceRecord, names: &BTreeSet<&str>) -> Vec<String> {
    let cell = |name: &str| {
        let counter = trace.counters.get(name)?;
        Some(touched(run, name, counter).unwrap_or_else(|| significant(counter.per_ray, 4)))
    };
    names.iter().map(|name| cell(name).unwrap_or_else(|| NONE.to_owned())).collect()
}

/// The tracer's label, marked if it is a control's.
pub(super) fn label(role: Role, run: &TracerRun) -> String {
    match role {
        Role::Control => format!("{} (control)", run.label()),
        Role::Contender => run.label(),
    }
}

#[cfg(test)]
mod tests {
    use tracebench_api::Query;

    use super::*;
    use crate::report::fixture::{self, Quality};

    /// What a set touched stands beside what the structure says it stores, by name; without such a name the count stands
    /// alone, and what is counted ray by ray is none of it.
    #[test]
    fn touched_beside_stored() {
        let quality =
            Quality { missed: 0.0, blur: 0.0, speed: 1.0, clock: tracebench_api::ClockKind::DeviceTimestamps };
        let run = fixture::run(&[("bvh-gpu", quality)], &[("diffuse", Query::Closest)]).runs.remove(0);
        let of_set = CounterRecord { total: 1234, per_ray: 0.01, greatest_per_ray: None };
        // The structure of the fixture has 4321 nodes.
        let cell = |name: &str, counter: &CounterRecord| touched(&run, name, counter);
        assert_eq!(cell("nodes_touched", &of_set).as_deref(), Some("1,234 (28.6 % of 4,321)"));
        assert_eq!(cell("pixels_touched", &of_set).as_deref(), Some("1,234"));
        assert_eq!(cell("nodes", &of_set).as_deref(), Some("1,234"));
        let none = CounterRecord { total: 0, ..of_set.clone() };
        assert_eq!(cell("nodes_touched", &none).as_deref(), Some("0 (0 % of 4,321)"));
        assert_eq!(cell("nodes_touched", &CounterRecord { greatest_per_ray: Some(3), ..of_set }), None);
    }

    /// The summary, the table of peers and the page of a sweep show it, and none of them as a mean per ray.
    #[test]
    fn every_table_shows_what_was_touched() {
        let mut run = crate::report::sweep::tests::sweep_run(
            &[("node", "cwbvh", &["cwbvh", "bvh2"])],
            &[("diffuse", Query::Closest)],
            false,
        );
        for one in &mut run.runs {
            one.tracer.name = "bvh-gpu".to_owned();
            let counter = CounterRecord { total: 1234, per_ray: 0.015_625, greatest_per_ray: None };
            one.traces[0].counters.insert("nodes_touched".to_owned(), counter);
        }
        run.sweep.as_mut().unwrap().tracer = "bvh-gpu".to_owned();
        run.table = Some("bvh".to_owned());
        let folder = tempfile::TempDir::new().unwrap();
        crate::report::write_derived(&run, folder.path(), fixture::tables).unwrap();
        for (name, rows) in [("summary.md", 2), ("table_bvh.md", 2), ("sweep.md", 2)] {
            let text = std::fs::read_to_string(folder.path().join(name)).unwrap();
            assert_eq!(text.matches("1,234 (28.6 % of 4,321)").count(), rows, "{name}: {text}");
            assert!(!text.contains("0.0156") && !text.contains("nodes_touched per ray"), "{name}");
            assert_eq!(text.contains("37.00"), name != "sweep.md", "{name}: means of what is counted ray by ray");
        }
    }
}
