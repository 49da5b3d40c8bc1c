//! Paired ratios of made-up records.

use tracebench_api::Query;

use super::*;
use crate::report::fixture::{self, Quality};
use crate::results::KernelRecord;

const SETS: [(&str, Query); 2] = [("primary", Query::Closest), ("diffuse", Query::Closest)];

/// Two configurations whose times rise and fall together by half, the second 1.2 times as slow with a scatter of 2 %.
fn run() -> Record {
    let quality = Quality { missed: 0.0, blur: 0.0, speed: 1.0, clock: ClockKind::DeviceTimestamps };
    let mut record = fixture::run(&[("a", quality), ("b", quality)], &SETS);
    for (row, factor) in record.rows.iter_mut().zip([1.0, 1.2]) {
        let traces = row.traces.iter_mut().map(|trace| &mut trace.times);
        for times in traces.chain([&mut row.build.times]) {
            let scatter = |round: usize| if factor > 1.0 { 0.98 + 0.002 * (round * 7 % 20) as f64 } else { 1.0 };
            let machine = |round: usize| 10.0 * (1.0 + 0.5 * (round * 3 % 20) as f64 / 20.0);
            times.samples_ms = (0..20).map(|round| factor * machine(round) * scatter(round)).collect();
            times.submit_to_done_samples_ms = times.samples_ms.iter().map(|ms| ms + 0.5).collect();
            times.median_ms = median(&times.samples_ms);
        }
    }
    record
}

fn traced<'a>(record: &'a Record, row: usize, set: usize) -> Timed<'a> {
    Timed::trace(&record.rows[row], &record.rows[row].traces[set])
}

fn near(found: f64, expected: f64) -> bool {
    (found / expected - 1.0).abs() < 0.01
}

/// Proves that what slows both in a round cancels: the interval of paired rounds is narrow where that of two lots is wide.
#[test]
fn rounds_are_paired() {
    let record = run();
    let found = record.paired(&traced(&record, 1, 0), &traced(&record, 0, 0));
    let ratio = found.sure().unwrap();
    assert_eq!((found.pairing, found.answer(0.02)), (Pairing::Rounds, Answer::Longer));
    assert!(near(ratio.value, 1.2) && ratio.interval[1] / ratio.interval[0] < 1.04 && ratio.coverage >= COVERAGE);
    assert_eq!(record.paired(&traced(&record, 0, 0), &traced(&record, 1, 0)).answer(0.02), Answer::Shorter);
    assert_eq!(record.paired(&traced(&record, 0, 0), &traced(&record, 0, 0)).answer(0.02), Answer::Same);
    let lots =
        Ratio::of_times(&record.rows[1].build.times.samples_ms, &record.rows[0].build.times.samples_ms, COVERAGE);
    assert!(lots.unwrap().interval[1] / lots.unwrap().interval[0] > 1.3);
    // Rounds that are not the same ones do not cancel.
    let mut shifted = record.clone();
    shifted.rows[1].traces[0].times.samples_ms.rotate_left(5);
    let wrong = shifted.paired(&traced(&shifted, 1, 0), &traced(&shifted, 0, 0)).ratio.unwrap();
    assert!(wrong.interval[1] / wrong.interval[0] > 1.2);
}

/// Proves that times which the device took are set against one another by submissions where the host's clock is asked for, and by the
/// device's where it is not.
#[test]
fn the_host_may_be_asked() {
    let mut record = run();
    let first = record.rows[0].traces[0].times.submit_to_done_samples_ms.clone();
    let thrice = first.iter().map(|ms| 3.0 * ms).collect();
    record.rows[1].traces[0].times.submit_to_done_samples_ms = thrice;
    let (one, other) = (traced(&record, 1, 0), traced(&record, 0, 0));
    assert!(near(record.paired(&one, &other).sure().unwrap().value, 1.2));
    assert!(near(record.paired_on_host(&one, &other).sure().unwrap().value, 3.0));
    record.rows[0].traces[0].times.submit_to_done_samples_ms.clear();
    let (one, other) = (traced(&record, 1, 0), traced(&record, 0, 0));
    assert_eq!(record.paired_on_host(&one, &other).answer(0.02), Answer::Undecided(Caveat::NoTimes));
    assert!(near(record.paired(&one, &other).sure().unwrap().value, 1.2));
}

/// Proves that first and steady builds are each paired with their own kind, by the host's clock, also where the other half of a sum is
/// by the device's; and that a row of before these were told has its phases for both.
#[test]
fn first_and_steady_builds_are_told_apart() {
    let mut record = run();
    let samples = record.rows[0].build.times.samples_ms.clone();
    for (row, [first, steady]) in record.rows.iter_mut().zip([[8.0, 1.0], [4.0, 2.0]]) {
        let whole = |factor: f64| {
            let samples_ms: Vec<f64> = samples.iter().map(|ms| factor * ms).collect();
            let times = Times { clock: ClockKind::Host, samples_ms, phases: Vec::new(), ..row.build.times.clone() };
            Some(Box::new(Times { submit_to_done_samples_ms: Vec::new(), ..times }))
        };
        (row.build.first, row.build.steady) = (whole(first), whole(steady));
    }
    let ratio =
        |record: &Record, of: fn(&Row) -> Timed<'_>| record.paired(&of(&record.rows[1]), &of(&record.rows[0])).sure();
    assert!(near(ratio(&record, |row| Timed::first_build(row)).unwrap().value, 0.5));
    assert!(near(ratio(&record, |row| Timed::steady_build(row)).unwrap().value, 2.0));
    let of_frame = |row| Timed::steady_build(&record.rows[row]).and(traced(&record, row, 0));
    assert!(record.paired(&of_frame(1), &of_frame(0)).sure().is_ok());
    let ours = record.rows[0].build.clone();
    record.rows.iter_mut().for_each(|row| (row.build.first, row.build.steady) = (None, None));
    let [before, first] =
        [ratio(&record, |row| Timed::steady_build(row)), ratio(&record, |row| Timed::first_build(row))];
    assert!(before == first && !near(before.unwrap().value, 2.0));
    // An update has no first build.
    let update = BuildRecord { first: None, ..ours.clone() };
    assert!(std::ptr::eq(update.first(), update.steady()) && update.all().count() == 2 && ours.all().count() == 3);
}

/// Proves that phases, sums and multiples are taken round by round, by the clock of both.
#[test]
fn parts_are_paired_too() {
    let mut record = run();
    let sort = |row: &mut Row, factor: f64| {
        let samples: Vec<f64> = row.build.times.samples_ms.iter().map(|ms| factor * ms).collect();
        row.build.times.phases[0].samples_ms = samples;
    };
    sort(&mut record.rows[0], 0.5);
    sort(&mut record.rows[1], 0.25);
    let of = |row: usize| Timed::build_phase(&record.rows[row], "sort");
    assert!(near(record.paired(&of(1), &of(0)).sure().unwrap().value, 0.6));
    let none = Timed::build_phase(&record.rows[0], "no such");
    assert_eq!(record.paired(&of(1), &none).answer(0.1), Answer::Undecided(Caveat::NoTimes));
    let sum = |row: usize| Timed::steady_build(&record.rows[row]).and(traced(&record, row, 0));
    let found = record.paired(&sum(1), &sum(0));
    assert!(near(found.sure().unwrap().value, 1.2) && found.pairing == Pairing::Rounds);
    let per_ray = record.paired(&traced(&record, 1, 0).times(0.5), &traced(&record, 0, 0));
    assert!(near(per_ray.sure().unwrap().value, 0.6));
    // A phase that some rounds lack belongs to no round.
    let mut gone = record.clone();
    gone.rows[0].build.times.phases[0].samples_ms.pop();
    let of = |row: usize| Timed::build_phase(&gone.rows[row], "sort");
    assert_eq!(gone.paired(&of(1), &of(0)).sure(), Err(Caveat::NoTimes));
    // Of different clocks both are told by the host's.
    let mut host = record.clone();
    host.rows[0].traces[0].times.clock = ClockKind::Host;
    let found = host.paired(&traced(&host, 1, 0), &traced(&host, 0, 0)).sure().unwrap();
    assert!(found.value > 1.2 && near(found.value, 1.2 + 0.5 / 12.4));
    host.rows[1].traces[0].times.submit_to_done_samples_ms.clear();
    assert_eq!(host.paired(&traced(&host, 1, 0), &traced(&host, 0, 0)).sure(), Err(Caveat::NoTimes));
}

/// Proves that whatever speaks against times is the doubt, and that the ratio is told all the same.
#[test]
fn doubts_are_named() {
    let said = |change: &dyn Fn(&mut Record)| {
        let mut record = run();
        change(&mut record);
        let found = record.paired(&traced(&record, 1, 0), &traced(&record, 0, 0));
        assert!(found.ratio.is_some());
        found.sure().unwrap_err()
    };
    let few = |record: &mut Record| record.rows.iter_mut().for_each(|row| row.traces[0].times.samples_ms.truncate(11));
    assert_eq!(said(&few), Caveat::FewRounds(11));
    assert_eq!(
        said(&|record| record.rows[0].traces[0].times.invalid = Some("why".to_owned())),
        Caveat::Void("why".to_owned())
    );
    assert_eq!(said(&|record| record.interleaved_sets[1].drift = true), Caveat::Drift("primary of room".to_owned()));
    assert_eq!(said(&|record| record.interleaved_sets.clear()), Caveat::Unrecorded);
    assert_eq!(said(&|record| record.rows[0].traces[0].times.interleaved_set = None), Caveat::Unrecorded);
    let mut wide = run();
    wide.rows[1].traces[0].times.samples_ms.rotate_left(5);
    let found = wide.paired(&traced(&wide, 1, 0).times(0.84), &traced(&wide, 0, 0));
    assert_eq!(found.answer(0.05), Answer::Undecided(Caveat::Interval));
}

/// Proves that times of different interleaved sets are two lots, and decide nothing where the fixed kernel took another time.
#[test]
fn different_races_are_not_paired() {
    let mut record = run();
    record.rows[0].traces[1].times.samples_ms.iter_mut().for_each(|ms| *ms *= 3.0);
    let kernel = |ms: f64| KernelRecord {
        clock: ClockKind::DeviceTimestamps,
        tasks: 512,
        samples_ms: vec![ms; 20],
        change: 0.0,
        deviations: 0.0,
        drifts: false,
    };
    record.interleaved_sets[1].kernels.push(kernel(1.0));
    record.interleaved_sets[2].kernels.push(kernel(1.05));
    let found = |record: &Record| record.paired(&traced(record, 0, 1), &traced(record, 0, 0));
    assert_eq!((found(&record).pairing, found(&record).answer(0.02)), (Pairing::Unpaired, Answer::Longer));
    record.interleaved_sets[2].kernels[0] = kernel(1.2);
    assert!(matches!(found(&record).sure(), Err(Caveat::Drift(_))) && found(&record).ratio.is_some());
}

/// Proves that a row of a later resident batch goes through the anchor, aligned or not, and that without one it is a lot of its own.
#[test]
fn windows_go_through_the_anchor() {
    let plain = run();
    let mut record = plain.clone();
    // The later resident batch ran at half the speed, and its own ups and downs.
    let slow = |row: &mut Row| {
        row.resident_batch = 1;
        let traces = row.traces.iter_mut().map(|trace| &mut trace.times);
        for times in traces.chain([&mut row.build.times]) {
            times.samples_ms.iter_mut().for_each(|ms| *ms *= 2.0);
            times.samples_ms.rotate_left(3);
            times.median_ms *= 2.0;
            times.interleaved_set = times.interleaved_set.map(|interleaved_set| interleaved_set + 3);
        }
    };
    slow(&mut record.rows[1]);
    let mut anchor = plain.rows[0].clone();
    slow(&mut anchor);
    record.anchors.push(anchor);
    record.interleaved_sets = [record.interleaved_sets.clone(), record.interleaved_sets].concat();
    for record in [&record, &*record.aligned()] {
        let found = record.paired(&traced(record, 1, 0), &traced(record, 0, 0));
        let ratio = found.sure().unwrap();
        assert_eq!(found.pairing, Pairing::ThroughAnchor);
        assert!(near(ratio.value, 1.2) && ratio.interval[1] / ratio.interval[0] < 1.05 && ratio.coverage >= COVERAGE);
    }
    record.anchors.clear();
    let found = record.paired(&traced(&record, 1, 0), &traced(&record, 0, 0));
    assert!(found.pairing == Pairing::Unpaired && found.ratio.unwrap().value > 2.0);
}
