//! Comparisons of made-up runs, each with one thing planted.

use super::*;
use crate::report::comparison_text;
use crate::report::fixture;
use crate::results::Judgement;
use crate::statistics::{median, median_interval, wilson};

fn held(a: &Record, b: &Record) -> Comparison {
    compare(("a", a), ("b", b), DEFAULT_THRESHOLD)
}

/// Everything that is said of a comparison, but the rows themselves.
fn said(comparison: &Comparison) -> Vec<String> {
    let mut said = comparison.regressions();
    said.extend(comparison.differences.clone());
    said.extend(comparison.builds.iter().filter(|row| !row.bytes.is_empty()).map(|_| "bytes".to_owned()));
    said.extend(comparison.builds.iter().filter(|row| !row.statistics.is_empty()).map(|_| "statistics".to_owned()));
    said.extend(comparison.traces.iter().filter(|row| !row.same_hits).map(|_| "hits".to_owned()));
    said.extend(comparison.traces.iter().filter(|row| !row.bytes.is_empty()).map(|_| "trace bytes".to_owned()));
    said.extend(comparison.traces.iter().filter(|row| !row.counters.is_empty()).map(|_| "counters".to_owned()));
    said.extend(comparison.only_in_a.iter().map(|key| format!("a: {}", key.sentence())));
    said.extend(comparison.only_in_b.iter().map(|key| format!("b: {}", key.sentence())));
    said
}

fn scale(times: &mut Times, factor: impl Fn(usize) -> f64) {
    for (index, sample) in times.samples_ms.iter_mut().enumerate() {
        *sample *= factor(index);
    }
    times.median_ms = median(&times.samples_ms);
    times.interval_ms = median_interval(&times.samples_ms).0;
}

/// Proves that a run compared with itself has every row, moves nothing and changes nothing.
#[test]
fn the_same_run_is_the_same() {
    for record in [fixture::typical(), fixture::crowded()] {
        let found = held(&record, &record);
        assert_eq!(said(&found), Vec::<String>::new());
        assert_eq!(
            (found.builds.len(), found.traces.len()),
            (record.rows.len(), record.rows.len() * fixture::SETS.len())
        );
        assert!(found.traces.iter().all(|row| row.speed.ratio.unwrap().value == 1.0));
        assert!(found.traces.iter().flat_map(|row| &row.accuracy).all(|accuracy| accuracy.shift == Shift::Same));
        assert!(comparison_text(&found).contains("## Moved beyond noise\n\nNothing."));
    }
}

/// Proves that a planted slowdown of 20 % of one trace and of one build is said of these and of nothing else, that turned
/// round it is a speed-up and no regression, and that a higher threshold lets it pass.
#[test]
fn a_slowdown_is_found() {
    let record = fixture::typical();
    let mut slower = record.clone();
    scale(&mut slower.rows[0].traces[1].times, |_| 1.2);
    assert_eq!(said(&held(&record, &slower)), ["room bvh-cpu diffuse: slower"]);
    assert!(comparison_text(&held(&record, &slower)).contains("room bvh-cpu diffuse: **slower**, ratio 0.833 ["));
    let turned = held(&slower, &record);
    assert_eq!(said(&turned), Vec::<String>::new());
    assert_eq!(turned.traces[1].speed.movement, Some(Movement::Faster));
    assert_eq!(said(&compare(("a", &record), ("b", &slower), 0.25)), Vec::<String>::new());
    // The fixture's builds scatter over 20 %: 15 % more is within that, a doubling is not.
    let mut build = record.clone();
    scale(&mut build.rows[1].build.times, |_| 1.15);
    assert_eq!(said(&held(&record, &build)), Vec::<String>::new());
    scale(&mut build.rows[1].build.times, |_| 2.0);
    assert_eq!(said(&held(&record, &build)), ["room screen-dda: build slower"]);
    // First and steady builds each by itself; beside a record of before them only phases are the same.
    let whole = fixture::with_whole_builds(record.clone());
    let mut steady = whole.clone();
    scale(steady.rows[1].build.steady.as_mut().unwrap(), |_| 2.0);
    assert_eq!(said(&held(&whole, &steady)), ["room screen-dda: steady build slower"]);
    assert!(comparison_text(&held(&whole, &steady)).contains("| steady build |"));
    let beside = held(&record, &steady);
    assert_eq!((said(&beside), beside.builds[1].speed.ratio.unwrap().value), (Vec::new(), 1.0));
    assert!(beside.builds.iter().all(|row| row.steady_speed.is_none()));
}

/// Proves that scatter like that of the samples is not taken for a change, even where the medians differ by more than the
/// threshold, and that times of different clocks are not set against each other.
#[test]
fn noise_is_not_a_change() {
    let record = fixture::typical();
    let mut noisy = record.clone();
    for (index, one) in noisy.rows.iter_mut().enumerate() {
        scale(&mut one.build.times, |sample| 1.0 + 0.08 * ((sample * 7 + index) % 3) as f64);
        for trace in &mut one.traces {
            scale(&mut trace.times, |sample| 1.0 + 0.2 * ((sample * 3 + index) % 10) as f64 - 0.7);
        }
    }
    let found = held(&record, &noisy);
    let moved = |ratio: f64| ratio.max(1.0 / ratio) > 1.05;
    assert!(found.traces.iter().any(|row| moved(row.speed.ratio.unwrap().value)));
    assert_eq!(said(&found), Vec::<String>::new());
    let mut other = record.clone();
    scale(&mut other.rows[0].traces[0].times, |_| 5.0);
    other.rows[0].traces[0].times.clock = ClockKind::SubmitToDone;
    let found = held(&record, &other);
    assert!(said(&found).is_empty() && found.traces[0].speed.ratio.is_none());
    assert!(comparison_text(&found).contains("clocks differ"));
}

/// Turns right hits of a closest-hit trace to misses.
fn lose(trace: &mut TraceRecord, rays: u64) {
    let Judgement::Closest(judgement) = &mut trace.judgement else { panic!("a closest-hit set") };
    let trials = trace.count - judgement.left_out();
    for classes in [&mut judgement.classes.tight, &mut judgement.classes.footprint] {
        (classes.true_hit, classes.false_miss) = (classes.true_hit - rays, classes.false_miss + rays);
    }
    let right = |classes: &crate::results::Classes| classes.true_hit + classes.true_miss;
    let (tight, footprint) = (right(&judgement.classes.tight), right(&judgement.classes.footprint));
    let hit_miss = trials - judgement.classes.tight.false_hit - judgement.classes.tight.false_miss;
    let share = |right: u64| Some(right as f64 / trials as f64);
    judgement.agreement.hit_miss = share(hit_miss);
    (judgement.agreement.tight, judgement.agreement.footprint) = (share(tight), share(footprint));
    judgement.interval.hit_miss = wilson(hit_miss, trials);
    (judgement.interval.tight, judgement.interval.footprint) = (wilson(tight, trials), wilson(footprint, trials));
    trace.hits_sha256 = "0".repeat(64);
}

/// Proves that a planted loss of accuracy is said by every rule that it concerns, of any-hit sets too, that turned round it is
/// none, and that a ray or two more are shown as counts and other answers but not as a loss.
#[test]
fn a_loss_of_accuracy_is_found() {
    let record = fixture::typical();
    let mut worse = record.clone();
    lose(&mut worse.rows[0].traces[0], 400);
    let rules = ["hit_miss", "tight", "footprint"];
    let expected = rules.map(|rule| format!("room bvh-cpu primary: less accurate by {rule}"));
    assert_eq!(held(&record, &worse).regressions(), expected);
    assert!(said(&held(&record, &worse)).contains(&"hits".to_owned()));
    assert!(comparison_text(&held(&record, &worse)).contains("**less accurate** by tight: "));
    assert!(held(&worse, &record).regressions().is_empty());
    let mut little = record.clone();
    lose(&mut little.rows[0].traces[0], 2);
    let found = held(&record, &little);
    assert_eq!(said(&found), ["hits"]);
    let tight = &found.traces[0].accuracy[1];
    assert_eq!((tight.b_wrong, tight.shift), (tight.a_wrong + 2, Shift::Within));
    let mut any = record.clone();
    let Judgement::Any(judgement) = &mut any.rows[0].traces[2].judgement else { panic!("an any-hit set") };
    judgement.occlusion.balanced_accuracy = Some(0.9);
    judgement.occlusion.balanced_accuracy_interval = Some([0.89, 0.91]);
    judgement.occlusion.false_free += 9;
    assert_eq!(held(&record, &any).regressions(), ["room bvh-cpu ao: less accurate by balanced accuracy"]);
}

/// Proves that bytes, counters and statistics that changed by one are said, and that they are no regression.
#[test]
fn exact_changes_are_found() {
    let record = fixture::typical();
    let mut changed = record.clone();
    changed.rows[0].memory.structure_bytes += 1;
    changed.rows[1].structure_statistics.insert("nodes".to_owned(), 4322.0);
    changed.rows[0].traces[0].per_trace_bytes -= 1;
    changed.rows[1].traces[2].counters.get_mut("nodes").unwrap().total += 1;
    let found = held(&record, &changed);
    assert_eq!(said(&found), ["bytes", "statistics", "trace bytes", "counters"]);
    assert!(found.regressions().is_empty());
    assert_eq!(found.builds[1].statistics["nodes"], [Some(4321.0), Some(4322.0)]);
    assert!(comparison_text(&found).contains("nodes 4,321 → 4,322"));
    // A file of before structures were asked has no statistics: nothing changed.
    changed.rows[1].structure_statistics.clear();
    assert!(held(&record, &changed).builds[1].statistics.is_empty());
}

/// Proves that rows match by content and not by name: another preset's name and place is the same row, other parameters,
/// rays, scenes and viewpoints are not; and that machines, commits and seeds that differ are said.
#[test]
fn rows_match_by_content() {
    let record = fixture::typical();
    let mut same = record.clone();
    same.rows.reverse();
    for one in &mut same.rows {
        one.tracer.preset = "improved".to_owned();
        one.viewpoint.name = "window".to_owned();
    }
    assert_eq!(said(&held(&record, &same)), Vec::<String>::new());
    let only = |change: &dyn Fn(&mut Row)| {
        let mut other = record.clone();
        change(&mut other.rows[0]);
        said(&held(&record, &other))
    };
    let whole = ["a: room bvh-cpu", "b: room bvh-cpu"];
    assert_eq!(
        only(&|one| one.tracer.parameters.insert("stride".to_owned(), 2.into()).map(drop).unwrap_or_default()),
        whole
    );
    assert_eq!(only(&|one| one.scene.sha256 = "1".repeat(64)), whole);
    assert_eq!(only(&|one| one.viewpoint.eye[1] += 0.1), whole);
    assert_eq!(only(&|one| one.viewpoint.frame = [64, 64]), whole);
    assert_eq!(
        only(&|one| one.traces[0].rays_sha256 = "1".repeat(64)),
        ["a: room bvh-cpu primary", "b: room bvh-cpu primary"]
    );
    let mut elsewhere = record.clone();
    elsewhere.provenance.machine.threads = 64;
    elsewhere.provenance.machine.adapter = None;
    elsewhere.provenance.commit = "f".repeat(40);
    elsewhere.seed += 1;
    let found = held(&record, &elsewhere);
    let about: Vec<&str> = found.differences.iter().map(|line| line.split(':').next().unwrap()).collect();
    assert_eq!(about, ["threads", "adapter", "commit", "seed"]);
    let text = comparison_text(&found);
    assert!(found.differences.iter().all(|line| text.contains(line.as_str())));
}
