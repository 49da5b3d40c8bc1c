//! Paired ratios of made-up records.

use tracebench_api::Query;

use super::*;
use crate::report::fixture::{self, Quality};
use crate::results::KernelRecord;

const SETS: [(&str, Query); 2] = [("primary", Query::Closest), ("diffuse", Query::Closest)];

/// Two contenders whose times rise and fall together by half, the second 1.2 times as slow with a scatter of 2 %.
fn run() -> Run {
    let quality = Quality { missed: 0.0, blur: 0.0, speed: 1.0, clock: ClockKind::DeviceTimestamps };
    let mut run = fixture::run(&[("a", quality), ("b", quality)], &SETS);
    for (row, factor) in run.runs.iter_mut().zip([1.0, 1.2]) {
        let traces = row.traces.iter_mut().map(|trace| &mut trace.times);
        for times in traces.chain([&mut row.build.times]) {
            let scatter = |round: usize| if factor > 1.0 { 0.98 + 0.002 * (round * 7 % 20) as f64 } else { 1.0 };
            let machine = |round: usize| 10.0 * (1.0 + 0.5 * (round * 3 % 20) as f64 / 20.0);
            times.samples_ms = (0..20).map(|round| factor * machine(round) * scatter(round)).collect();
            times.submit_to_done_samples_ms = times.samples_ms.iter().map(|ms| ms + 0.5).collect();
            times.median_ms = median(&times.samples_ms);
        }
    }
    run
}

fn traced<'a>(run: &'a Run, row: usize, set: usize) -> Timed<'a> {
    Timed::trace(&run.runs[row], &run.runs[row].traces[set])
}

fn near(found: f64, expected: f64) -> bool {
    (found / expected - 1.0).abs() < 0.01
}

/// Proves that what slows both in a round cancels: the interval of paired rounds is narrow where that of two lots is wide.
#[test]
fn rounds_are_paired() {
    let run = run();
    let found = run.paired(&traced(&run, 1, 0), &traced(&run, 0, 0));
    let ratio = found.sure().unwrap();
    assert_eq!((found.pairing, found.answer(0.02)), (Pairing::Rounds, Answer::Longer));
    assert!(near(ratio.value, 1.2) && ratio.interval[1] / ratio.interval[0] < 1.04 && ratio.coverage >= COVERAGE);
    assert_eq!(run.paired(&traced(&run, 0, 0), &traced(&run, 1, 0)).answer(0.02), Answer::Shorter);
    assert_eq!(run.paired(&traced(&run, 0, 0), &traced(&run, 0, 0)).answer(0.02), Answer::Same);
    let lots = Ratio::of_times(&run.runs[1].build.times.samples_ms, &run.runs[0].build.times.samples_ms, COVERAGE);
    assert!(lots.unwrap().interval[1] / lots.unwrap().interval[0] > 1.3);
    // Rounds that are not the same ones do not cancel.
    let mut shifted = run.clone();
    shifted.runs[1].traces[0].times.samples_ms.rotate_left(5);
    let wrong = shifted.paired(&traced(&shifted, 1, 0), &traced(&shifted, 0, 0)).ratio.unwrap();
    assert!(wrong.interval[1] / wrong.interval[0] > 1.2);
}

/// Proves that times which the device took are set against one another by submissions where the host's clock is asked for, and by the
/// device's where it is not.
#[test]
fn the_host_may_be_asked() {
    let mut run = run();
    let first = run.runs[0].traces[0].times.submit_to_done_samples_ms.clone();
    let thrice = first.iter().map(|ms| 3.0 * ms).collect();
    run.runs[1].traces[0].times.submit_to_done_samples_ms = thrice;
    let (one, other) = (traced(&run, 1, 0), traced(&run, 0, 0));
    assert!(near(run.paired(&one, &other).sure().unwrap().value, 1.2));
    assert!(near(run.paired_on_host(&one, &other).sure().unwrap().value, 3.0));
    run.runs[0].traces[0].times.submit_to_done_samples_ms.clear();
    let (one, other) = (traced(&run, 1, 0), traced(&run, 0, 0));
    assert_eq!(run.paired_on_host(&one, &other).answer(0.02), Answer::Undecided(Doubt::NoTimes));
    assert!(near(run.paired(&one, &other).sure().unwrap().value, 1.2));
}

/// Proves that first and steady builds are each paired with their own kind, by the host's clock, also where the other half of a sum is
/// by the device's; and that a row of before these were told has its phases for both.
#[test]
fn first_and_steady_builds_are_told_apart() {
    let mut run = run();
    let samples = run.runs[0].build.times.samples_ms.clone();
    for (row, [first, steady]) in run.runs.iter_mut().zip([[8.0, 1.0], [4.0, 2.0]]) {
        let whole = |factor: f64| {
            let samples_ms: Vec<f64> = samples.iter().map(|ms| factor * ms).collect();
            let times = Times { clock: ClockKind::Host, samples_ms, phases: Vec::new(), ..row.build.times.clone() };
            Some(Box::new(Times { submit_to_done_samples_ms: Vec::new(), ..times }))
        };
        (row.build.first, row.build.steady) = (whole(first), whole(steady));
    }
    let ratio = |run: &Run, of: fn(&TracerRun) -> Timed<'_>| run.paired(&of(&run.runs[1]), &of(&run.runs[0])).sure();
    assert!(near(ratio(&run, |row| Timed::first_build(row)).unwrap().value, 0.5));
    assert!(near(ratio(&run, |row| Timed::steady_build(row)).unwrap().value, 2.0));
    let of_frame = |row| Timed::steady_build(&run.runs[row]).and(traced(&run, row, 0));
    assert!(run.paired(&of_frame(1), &of_frame(0)).sure().is_ok());
    let ours = run.runs[0].build.clone();
    run.runs.iter_mut().for_each(|row| (row.build.first, row.build.steady) = (None, None));
    let [before, first] = [ratio(&run, |row| Timed::steady_build(row)), ratio(&run, |row| Timed::first_build(row))];
    assert!(before == first && !near(before.unwrap().value, 2.0));
    // An update has no first build.
    let update = crate::results::BuildRecord { first: None, ..ours.clone() };
    assert!(std::ptr::eq(update.first(), update.steady()) && update.all().count() == 2 && ours.all().count() == 3);
}

/// Proves that phases, sums and multiples are taken round by round, by the clock of both.
#[test]
fn parts_are_paired_too() {
    let mut run = run();
    let sort = |row: &mut TracerRun, factor: f64| {
        let samples: Vec<f64> = row.build.times.samples_ms.iter().map(|ms| factor * ms).collect();
        row.build.times.phases[0].samples_ms = samples;
    };
    sort(&mut run.runs[0], 0.5);
    sort(&mut run.runs[1], 0.25);
    let of = |row: usize| Timed::build_phase(&run.runs[row], "sort");
    assert!(near(run.paired(&of(1), &of(0)).sure().unwrap().value, 0.6));
    let none = Timed::build_phase(&run.runs[0], "no such");
    assert_eq!(run.paired(&of(1), &none).answer(0.1), Answer::Undecided(Doubt::NoTimes));
    let sum = |row: usize| Timed::steady_build(&run.runs[row]).and(traced(&run, row, 0));
    let found = run.paired(&sum(1), &sum(0));
    assert!(near(found.sure().unwrap().value, 1.2) && found.pairing == Pairing::Rounds);
    let per_ray = run.paired(&traced(&run, 1, 0).times(0.5), &traced(&run, 0, 0));
    assert!(near(per_ray.sure().unwrap().value, 0.6));
    // A phase that some rounds lack belongs to no round.
    let mut gone = run.clone();
    gone.runs[0].build.times.phases[0].samples_ms.pop();
    let of = |row: usize| Timed::build_phase(&gone.runs[row], "sort");
    assert_eq!(gone.paired(&of(1), &of(0)).sure(), Err(Doubt::NoTimes));
    // Of different clocks both are told by the host's.
    let mut host = run.clone();
    host.runs[0].traces[0].times.clock = ClockKind::Host;
    let found = host.paired(&traced(&host, 1, 0), &traced(&host, 0, 0)).sure().unwrap();
    assert!(found.value > 1.2 && near(found.value, 1.2 + 0.5 / 12.4));
    host.runs[1].traces[0].times.submit_to_done_samples_ms.clear();
    assert_eq!(host.paired(&traced(&host, 1, 0), &traced(&host, 0, 0)).sure(), Err(Doubt::NoTimes));
}

/// Proves that whatever speaks against times is the doubt, and that the ratio is told all the same.
#[test]
fn doubts_are_named() {
    let said = |change: &dyn Fn(&mut Run)| {
        let mut run = run();
        change(&mut run);
        let found = run.paired(&traced(&run, 1, 0), &traced(&run, 0, 0));
        assert!(found.ratio.is_some());
        found.sure().unwrap_err()
    };
    let few = |run: &mut Run| run.runs.iter_mut().for_each(|row| row.traces[0].times.samples_ms.truncate(11));
    assert_eq!(said(&few), Doubt::FewRounds(11));
    assert_eq!(said(&|run| run.runs[0].traces[0].times.void = Some("why".to_owned())), Doubt::Void("why".to_owned()));
    assert_eq!(said(&|run| run.races[1].drift = true), Doubt::Drift("primary of room".to_owned()));
    assert_eq!(said(&|run| run.races.clear()), Doubt::Unrecorded);
    assert_eq!(said(&|run| run.runs[0].traces[0].times.race = None), Doubt::Unrecorded);
    let mut wide = run();
    wide.runs[1].traces[0].times.samples_ms.rotate_left(5);
    let found = wide.paired(&traced(&wide, 1, 0).times(0.84), &traced(&wide, 0, 0));
    assert_eq!(found.answer(0.05), Answer::Undecided(Doubt::Interval));
}

/// Proves that times of different races are two lots, and decide nothing where the fixed kernel took another time.
#[test]
fn different_races_are_not_paired() {
    let mut run = run();
    run.runs[0].traces[1].times.samples_ms.iter_mut().for_each(|ms| *ms *= 3.0);
    let kernel = |ms: f64| KernelRecord {
        clock: ClockKind::DeviceTimestamps,
        tasks: 512,
        samples_ms: vec![ms; 20],
        change: 0.0,
        deviations: 0.0,
        drifts: false,
    };
    run.races[1].kernels.push(kernel(1.0));
    run.races[2].kernels.push(kernel(1.05));
    let found = |run: &Run| run.paired(&traced(run, 0, 1), &traced(run, 0, 0));
    assert_eq!((found(&run).pairing, found(&run).answer(0.02)), (Pairing::Unpaired, Answer::Longer));
    run.races[2].kernels[0] = kernel(1.2);
    assert!(matches!(found(&run).sure(), Err(Doubt::Drift(_))) && found(&run).ratio.is_some());
}

/// Proves that a row of a later window goes through the anchor, aligned or not, and that without one it is a lot of its own.
#[test]
fn windows_go_through_the_anchor() {
    let plain = run();
    let mut run = plain.clone();
    // The later window ran at half the speed, and its own ups and downs.
    let slow = |row: &mut TracerRun| {
        row.window = 1;
        let traces = row.traces.iter_mut().map(|trace| &mut trace.times);
        for times in traces.chain([&mut row.build.times]) {
            times.samples_ms.iter_mut().for_each(|ms| *ms *= 2.0);
            times.samples_ms.rotate_left(3);
            times.median_ms *= 2.0;
            times.race = times.race.map(|race| race + 3);
        }
    };
    slow(&mut run.runs[1]);
    let mut anchor = plain.runs[0].clone();
    slow(&mut anchor);
    run.anchors.push(anchor);
    run.races = [run.races.clone(), run.races].concat();
    for run in [&run, &*run.aligned()] {
        let found = run.paired(&traced(run, 1, 0), &traced(run, 0, 0));
        let ratio = found.sure().unwrap();
        assert_eq!(found.pairing, Pairing::ThroughAnchor);
        assert!(near(ratio.value, 1.2) && ratio.interval[1] / ratio.interval[0] < 1.05 && ratio.coverage >= COVERAGE);
    }
    run.anchors.clear();
    let found = run.paired(&traced(&run, 1, 0), &traced(&run, 0, 0));
    assert!(found.pairing == Pairing::Unpaired && found.ratio.unwrap().value > 2.0);
}
