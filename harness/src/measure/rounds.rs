//! The rounds of an interleaved set: in which order, with which fixed kernels, and how many.

use std::time::Instant;

use tracebench_api::{Gpu, Residency, Timing, TracerError};

use super::kernels::Kernels;
use crate::rays::sampling::Stream;
use crate::results::{Adaptive, COVERAGE, MIN_ROUNDS, SampleSchedule, StopReason, of_rounds};
use crate::statistics::median;

/// Rounds that no interleaved set goes beyond: intervals shrink with the root of their number.
pub(crate) const MAX_ROUNDS: usize = 200;

/// A time below which no interval is waited for, milliseconds: it is near a clock's resolution.
const NEGLIGIBLE_MS: f64 = 0.02;

/// Tells the numbers that orders are drawn by from those of rays.
const TAG: u64 = 0x0d3;

/// The order of a round: every participant once, all orders as likely (Fisher, Yates).
pub(crate) fn order(seed: u64, round: usize, participants: usize) -> Vec<usize> {
    let mut stream = Stream::new(seed, TAG, round as u64);
    let mut order: Vec<usize> = (0..participants).collect();
    for last in (1..participants).rev() {
        order.swap(last, (stream.unit() * (last + 1) as f64) as usize);
    }
    order
}

/// A round.
pub(crate) struct Round {
    /// The participants, in turn.
    pub order: Vec<usize>,
    /// Whether its times count.
    pub counts: bool,
}

/// The rounds of an interleaved set.
#[derive(Default)]
pub(crate) struct Rounds<'a> {
    /// None where nothing is timed: all is done once, in the order of participants.
    pub sampling: Option<SampleSchedule>,
    /// The fixed kernels with their counted samples.
    pub kernels: Vec<(Residency, &'a Kernels, Vec<Timing>)>,
    pub order_seed: u64,
    pub participants: usize,
    pub begun: usize,
    pub counted_since: Option<Instant>,
    /// Of every counted round.
    pub orders: Vec<Vec<usize>>,
    /// What ended it, once it has.
    pub stop_reason: Option<StopReason>,
    /// The widest interval when it ended.
    pub widest_interval: Option<f64>,
    /// Seconds from the first counted round on.
    pub sampled_s: f64,
}

impl Rounds<'_> {
    /// How many there are at least, that which warms up among them.
    pub fn least(&self) -> usize {
        self.sampling.map_or(1, |sampling| sampling.min_rounds as usize + 1)
    }

    /// The next round, after its kernels; `None` when it is enough. `timed` gives the counted samples of all configurations, by kind of
    /// work: those of a kind are compared.
    ///
    /// # Errors
    /// What the device says.
    pub fn next<'t, const KINDS: usize>(
        &mut self,
        gpu: Option<&Gpu>,
        timed: impl FnOnce() -> [Vec<&'t [Timing]>; KINDS],
    ) -> Result<Option<Round>, TracerError> {
        self.sampled_s = self.counted_since.map_or(0.0, |since| since.elapsed().as_secs_f64());
        if self.begun >= self.least() && self.ends(timed) {
            return Ok(None);
        }
        let counts = self.sampling.is_some() && self.begun > 0;
        for (side, kernels, timings) in &mut self.kernels {
            let timing = kernels.sample(*side, gpu)?;
            timings.extend(Some(timing).filter(|_| counts));
        }
        let order = match self.sampling {
            Some(_) => order(self.order_seed, self.begun, self.participants),
            None => (0..self.participants).collect(),
        };
        if counts {
            self.counted_since.get_or_insert_with(Instant::now);
            self.orders.push(order.clone());
        }
        self.begun += 1;
        Ok(Some(Round { order, counts }))
    }

    fn ends<'t, const KINDS: usize>(&mut self, timed: impl FnOnce() -> [Vec<&'t [Timing]>; KINDS]) -> bool {
        let Some(sampling) = self.sampling else { return true };
        let counted = self.orders.len();
        if !is_due(sampling.adaptive, counted, self.sampled_s) {
            return false;
        }
        let limit = sampling.adaptive.map(|adaptive| adaptive.ratio_precision);
        let kinds = timed();
        self.widest_interval = kinds.iter().filter_map(|kind| widest(&timed_samples(kind), limit)).reduce(f64::max);
        self.stop_reason = ended(sampling.adaptive, counted, self.sampled_s, self.widest_interval);
        self.stop_reason.is_some()
    }
}

/// Whether intervals are looked at after so many rounds: at first after each, later after every so many, since each look costs time, and
/// a chance to stop by luck.
pub(crate) fn is_due(adaptive: Option<Adaptive>, rounds: usize, sampled_s: f64) -> bool {
    let up = adaptive.is_none_or(|adaptive| sampled_s >= adaptive.time_limit_s) || rounds >= MAX_ROUNDS;
    up || rounds.is_multiple_of((rounds / 16).max(1))
}

/// Whether sampling ends after at least as many rounds as there must be, and why.
pub(crate) fn ended(
    adaptive: Option<Adaptive>,
    rounds: usize,
    sampled_s: f64,
    widest: Option<f64>,
) -> Option<StopReason> {
    let Some(Adaptive { ratio_precision, time_limit_s }) = adaptive else { return Some(StopReason::Rounds) };
    match () {
        () if widest.is_none_or(|width| width < ratio_precision) => Some(StopReason::Interval),
        () if sampled_s >= time_limit_s => Some(StopReason::TimeLimit),
        () if rounds >= MAX_ROUNDS => Some(StopReason::MaxRounds),
        () => None,
    }
}

/// The widest interval that the ratio of any two lots has, in shares: its upper end over its lower one, less 1. The first that is not
/// narrower than a limit stands for all. None where there are no two, or too few rounds.
pub(crate) fn widest(timed_samples: &[TimedSamples], limit: Option<f64>) -> Option<f64> {
    let mut widest: Option<f64> = None;
    for (index, one) in timed_samples.iter().enumerate() {
        for other in &timed_samples[..index] {
            let both = if one.clock == other.clock { [&one.own, &other.own] } else { [&one.by_host, &other.by_host] };
            let [low, high] =
                of_rounds(both[0], both[1], COVERAGE).filter(|found| found.coverage >= COVERAGE)?.interval;
            widest = Some(widest.unwrap_or(0.0).max(high / low - 1.0));
            if widest >= limit && limit.is_some() {
                return widest;
            }
        }
    }
    widest
}

/// What one configuration's samples are told by.
pub(crate) struct TimedSamples {
    clock: tracebench_api::ClockKind,
    own: Vec<f64>,
    by_host: Vec<f64>,
}

/// The lots that an interval is waited for.
fn timed_samples(timed: &[&[Timing]]) -> Vec<TimedSamples> {
    let believed = super::records::are_believed(timed.iter().copied());
    let samples = |timings: &&[Timing]| {
        let clock = timings.first()?.clock;
        let by_host = timings.iter().map(|timing| timing.submit_to_done_ms.unwrap_or(timing.total_ms)).collect();
        let own: Vec<f64> = timings.iter().map(|timing| timing.total_ms).collect();
        let waited = timings.len() >= MIN_ROUNDS as usize && median(&own) >= NEGLIGIBLE_MS;
        let own = if believed && Timing::plausible(timings) { own } else { Vec::clone(&by_host) };
        waited.then_some(TimedSamples { clock, own, by_host })
    };
    timed.iter().filter_map(samples).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    impl TimedSamples {
        /// Times by the host's clock.
        pub(crate) fn of_host(times_ms: Vec<f64>) -> Self {
            Self { clock: tracebench_api::ClockKind::Host, by_host: times_ms.clone(), own: times_ms }
        }
    }

    /// Every order has every participant once, is drawn again by the same seed, and puts every participant first about as often.
    #[test]
    fn orders_are_shuffled() {
        let mut first = [0; 5];
        for round in 0..2000 {
            let drawn = order(7, round, 5);
            let mut sorted = drawn.clone();
            sorted.sort_unstable();
            assert_eq!(sorted, [0, 1, 2, 3, 4]);
            assert_eq!(drawn, order(7, round, 5));
            first[drawn[0]] += 1;
        }
        assert!(first.iter().all(|count| (330..470).contains(count)), "{first:?}");
        assert!((0..20).any(|round| order(7, round, 5) != order(8, round, 5)));
        assert_eq!((order(7, 1, 0), order(7, 1, 1)), (vec![], vec![0]));
    }

    /// SampleSchedule ends after fixed rounds, once all intervals are narrow, when the time is up, or at the most rounds; not before.
    #[test]
    fn sampling_ends() {
        let adaptive = Some(Adaptive { ratio_precision: 0.1, time_limit_s: 5.0 });
        assert_eq!(ended(None, 3, 100.0, None), Some(StopReason::Rounds));
        assert_eq!(ended(adaptive, 12, 1.0, Some(0.09)), Some(StopReason::Interval));
        assert_eq!(ended(adaptive, 12, 1.0, None), Some(StopReason::Interval));
        assert_eq!(ended(adaptive, 12, 1.0, Some(0.11)), None);
        assert_eq!(ended(adaptive, 12, 5.0, Some(0.11)), Some(StopReason::TimeLimit));
        assert_eq!(ended(adaptive, MAX_ROUNDS, 1.0, Some(0.11)), Some(StopReason::MaxRounds));
        let looks = (12..100).filter(|rounds| is_due(adaptive, *rounds, 1.0)).count();
        assert!((30..60).contains(&looks) && (12..32).all(|rounds| is_due(adaptive, rounds, 1.0)), "{looks}");
        assert!(!is_due(adaptive, 99, 1.0) && is_due(adaptive, 99, 5.0) && is_due(adaptive, MAX_ROUNDS, 1.0));
    }

    /// The widest interval is that of the worst pair: one that scatters keeps all waiting, one that is too short to tell does not.
    #[test]
    fn the_worst_pair_counts() {
        let timings = |ms: f64, scatter: f64| -> Vec<Timing> {
            let sample = |round: usize| Timing {
                clock: tracebench_api::ClockKind::Host,
                total_ms: ms * (1.0 + scatter * (round * 5 % 12) as f64),
                phases: Vec::new(),
                submit_to_done_ms: None,
                grown: false,
            };
            (0..12).map(sample).collect()
        };
        let of =
            |all: &[Vec<Timing>]| widest(&timed_samples(&all.iter().map(|each| &each[..]).collect::<Vec<_>>()), None);
        let (steady, slower, wild) = (timings(1.0, 0.0), timings(2.0, 0.001), timings(1.0, 0.05));
        assert!(of(&[steady.clone(), slower.clone()]).unwrap() < 0.02);
        assert!(of(&[steady.clone(), slower, wild]).unwrap() > 0.3);
        assert_eq!(of(std::slice::from_ref(&steady)), None);
        assert_eq!(of(&[steady, timings(0.001, 0.05)]), None);
    }
}
