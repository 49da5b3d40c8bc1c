//! The clock, tried on recorded noise: interleaved sets are replayed with the orders, the stopping and the verdicts that real ones have.
//!
//! noise.csv was recorded by `tracebench doctor --clock --record FILE --kind KIND --tracer TRACER --samples 200`, with `--load 2` where the
//! kind says loaded: a line a round has the fixed kernel and four configurations that are all the same, in the order in which they were
//! sampled, milliseconds. A replayed interleaved set begins at a round shuffled and goes on round by round, at the end from the first one
//! again; who of its configurations is in which place of a round is drawn by the harness's own lot.

use rayon::prelude::*;

use super::kernels::{drift, drifts};
use super::rounds::{MAX_ROUNDS, TimedSamples, ended, is_due, order, widest};
use crate::plan::SAMPLING;
use crate::rays::sampling::Stream;
use crate::results::{Answer, Caveat, Paired, StopReason};
use crate::statistics::median;

/// Interleaved sets that are replayed of configurations that are the same.
const RACES: usize = 20_000;
/// Interleaved sets that are replayed with one slowed.
const SLOWED_RACES: usize = 4_000;
const SLOWDOWN: f64 = 1.15;

/// Noise of one kind: by round the kernel and the configurations.
struct Noise {
    kind: &'static str,
    kernel: Vec<f64>,
    slots: Vec<Vec<f64>>,
}

fn recorded() -> Vec<Noise> {
    let mut kinds: Vec<Noise> = Vec::new();
    for line in include_str!("noise.csv").lines().filter(|line| !line.starts_with('#')) {
        let (kind, numbers) = line.split_once(',').unwrap();
        let numbers: Vec<f64> = numbers.split(',').map(|number| number.parse().unwrap()).collect();
        if kinds.last().is_none_or(|last| last.kind != kind) {
            kinds.push(Noise { kind, kernel: Vec::new(), slots: Vec::new() });
        }
        let noise = kinds.last_mut().unwrap();
        noise.kernel.push(numbers[0]);
        noise.slots.push(numbers[1..].to_vec());
    }
    kinds
}

/// What a replayed interleaved set came to.
struct Replayed {
    answer: Answer,
    stop_reason: StopReason,
    times: [Vec<f64>; 2],
}

/// An interleaved set of two, the second slowed by a factor.
fn replay(noise: &Noise, interleaved_set: u64, factor: f64) -> Replayed {
    // Seeds that differ in their lowest bit alone draw the same numbers.
    let seed = 2 * interleaved_set;
    let mut stream = Stream::new(seed, 0x9e9, 0);
    let begin = (stream.unit() * noise.slots.len() as f64) as usize;
    let (mut times, mut kernel, mut sampled_s) = ([Vec::new(), Vec::new()], Vec::new(), 0.0);
    loop {
        let round = times[0].len();
        let at = (begin + round) % noise.slots.len();
        let slots = &noise.slots[at];
        let places = order(seed, round, slots.len());
        for (participant, factor) in [1.0, factor].into_iter().enumerate() {
            let place = places.iter().position(|other| *other == participant).unwrap();
            times[participant].push(slots[place] * factor);
        }
        kernel.push(noise.kernel[at]);
        sampled_s += (noise.kernel[at] + slots.iter().sum::<f64>()) / 1e3;
        if round + 1 < SAMPLING.min_rounds as usize || !is_due(SAMPLING.adaptive, round + 1, sampled_s) {
            continue;
        }
        let timed_samples = [TimedSamples::of_host(times[0].clone()), TimedSamples::of_host(times[1].clone())];
        let width = widest(&timed_samples, None);
        if let Some(stop_reason) = ended(SAMPLING.adaptive, times[0].len(), sampled_s, width) {
            let (change, deviations) = drift(&kernel);
            let drift = drifts(change, deviations).then(|| noise.kind.to_owned());
            let answer = Paired::in_interleaved_set(&times[1], &times[0], drift, None).answer(0.05);
            return Replayed { answer, stop_reason, times };
        }
    }
}

fn differs(answer: &Answer) -> bool {
    matches!(answer, Answer::Longer | Answer::Shorter)
}

/// Proves that of 20,000 replayed interleaved sets of configurations that are the same at most 30 say that they differ, and that a rule
/// which holds medians alone against one another (the negative control) says so far more often.
#[test]
fn the_same_are_hardly_ever_told_apart() {
    let kinds = recorded();
    let said = |interleaved_set: usize| {
        let replayed = replay(&kinds[interleaved_set % kinds.len()], interleaved_set as u64, 1.0);
        let ratio = median(&replayed.times[1]) / median(&replayed.times[0]);
        [usize::from(differs(&replayed.answer)), usize::from(ratio.max(1.0 / ratio) > 1.05)]
    };
    let sum = |one: [usize; 2], other: [usize; 2]| [one[0] + other[0], one[1] + other[1]];
    let [differing, naive] = (0..RACES).into_par_iter().map(said).reduce(|| [0; 2], sum);
    println!("{differing} of {RACES} differ; by medians alone {naive}");
    assert!(differing <= 30, "{differing}");
    assert!(naive > 300, "{naive}");
}

/// Proves that one who is slowed by 15 % is found in 95 % of the interleaved sets, and never said to be the quicker; one slowed by nothing
/// to speak of (the negative control) is not found.
#[test]
fn the_slower_are_found() {
    let kinds = recorded();
    let interleaved_sets = SLOWED_RACES / kinds.len();
    let (mut found, mut wrong, mut slight) = (0, 0, 0);
    for noise in &kinds {
        let slowed: Vec<Replayed> = (0..interleaved_sets)
            .into_par_iter()
            .map(|interleaved_set| replay(noise, 1_000_000 + interleaved_set as u64, SLOWDOWN))
            .collect();
        let count = |wanted: &dyn Fn(&Replayed) -> bool| slowed.iter().filter(|replayed| wanted(replayed)).count();
        let here = count(&|replayed| replayed.answer == Answer::Longer);
        let drift = count(&|replayed| matches!(replayed.answer, Answer::Undecided(Caveat::Drift(_))));
        let in_time = count(&|replayed| replayed.stop_reason == StopReason::Interval);
        let rounds: Vec<f64> = slowed.iter().map(|replayed| replayed.times[0].len() as f64).collect();
        println!(
            "{}: found {here} of {interleaved_sets}, {drift} drift; {in_time} known well enough in time, {} rounds",
            noise.kind,
            median(&rounds)
        );
        assert!(rounds.iter().all(|rounds| *rounds <= MAX_ROUNDS as f64));
        found += here;
        wrong += count(&|replayed| replayed.answer == Answer::Shorter);
        let slightly = (0..interleaved_sets)
            .into_par_iter()
            .map(|interleaved_set| replay(noise, 2_000_000 + interleaved_set as u64, 1.001).answer);
        slight += slightly.filter(differs).count();
    }
    let interleaved_sets = interleaved_sets * kinds.len();
    println!("found {found} of {interleaved_sets}");
    assert!(found as f64 >= 0.95 * interleaved_sets as f64, "{found} of {interleaved_sets}");
    assert!(wrong == 0 && slight < interleaved_sets / 100, "{wrong} {slight}");
}
