//! Ratios of times: by which clock, and how sure they are.
//!
//! One rule of clocks: two times that the same clock took are set against one another as they are; of different clocks both are
//! taken by the host's, which measures work on the host as such and work on a device from submission until done. Where one of
//! them has no such time there is no ratio.
//!
//! The interval of a ratio comes from order statistics of each lot, [`median_interval_of`], combined: from the least of one over the
//! greatest of the other to the opposite. It assumes nothing about how times scatter (they are skewed, and have outliers), has
//! no seed, and its coverage is known for any number of samples: the product of both, since the lots are independent. A
//! bootstrap of the ratio has none of the three; of ten samples its intervals of a median are known to be too narrow. The
//! price is that it is wide: it covers more often than it says.

use serde::Serialize;
use tracebench_api::ClockKind;

use super::Times;
use crate::statistics::{median, median_interval_of};

/// A time by the host's clock, milliseconds: that of work on the host, or round a submission.
pub fn host_ms(times: &Times) -> Option<f64> {
    let measured = match times.clock {
        ClockKind::Host => (!times.samples_ms.is_empty()).then_some(times.median_ms),
        ClockKind::DeviceTimestamps | ClockKind::SubmitToDone => times.submit_to_done_median_ms,
    };
    measured.filter(|ms| *ms > 0.0)
}

/// Two times by the clock that timed both, else by the host's; milliseconds.
pub fn common_clock(one: &Times, other: &Times) -> Option<[f64; 2]> {
    let own = |times: &Times| (!times.samples_ms.is_empty() && times.median_ms > 0.0).then_some(times.median_ms);
    if one.clock == other.clock { Some([own(one)?, own(other)?]) } else { Some([host_ms(one)?, host_ms(other)?]) }
}

/// How many times as long one took as the other.
pub fn time_ratio(one: &Times, other: &Times) -> Option<f64> {
    common_clock(one, other).map(|[one, other]| one / other)
}

/// Coverage that is wanted of each lot, so that both together cover with 95 %: its square root.
const WANTED_COVERAGE: f64 = 0.974_679_434_480_896_2;

/// Samples on either side below which nothing is said to have moved: the ranges of two lots of three from one distribution
/// are disjoint one time in ten, of four one time in 35 (2 / 70, by counting arrangements), of ten, whose intervals leave out
/// the ends, less than one time in a thousand.
pub const LEAST_SAMPLES: usize = 4;

/// A ratio of medians with its interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Ratio {
    /// The ratio.
    pub value: f64,
    /// Its interval.
    pub interval: [f64; 2],
    /// Least probability that the interval covers the ratio of the distributions' medians.
    pub coverage: f64,
}

/// What is to be said of a ratio of speeds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Movement {
    /// Faster beyond noise and threshold.
    Faster,
    /// Slower beyond noise and threshold.
    Slower,
    /// Neither.
    Within,
    /// Fewer than [`LEAST_SAMPLES`] samples: nothing can be said.
    TooFewSamples,
}

impl Ratio {
    /// The speed of `after` over that of `before`, of samples of times; `None` without samples, or for a time of nothing.
    pub fn of_speeds(before: &[f64], after: &[f64]) -> Option<Self> {
        if before.is_empty() || after.is_empty() {
            return None;
        }
        let (before_interval, before_coverage) = median_interval_of(before, WANTED_COVERAGE);
        let (after_interval, after_coverage) = median_interval_of(after, WANTED_COVERAGE);
        let ratio = Self {
            value: median(before) / median(after),
            interval: [before_interval[0] / after_interval[1], before_interval[1] / after_interval[0]],
            coverage: before_coverage * after_coverage,
        };
        let all = [ratio.value, ratio.interval[0], ratio.interval[1]];
        all.iter().all(|value| value.is_finite() && *value > 0.0).then_some(ratio)
    }

    /// What is to be said: a ratio moved if its interval excludes 1 and the slower takes more than `threshold` longer (a
    /// share) than the faster.
    pub fn movement(&self, fewest_samples: usize, threshold: f64) -> Movement {
        let [low, high] = self.interval;
        let change = self.value.max(1.0 / self.value) - 1.0;
        match () {
            () if fewest_samples < LEAST_SAMPLES => Movement::TooFewSamples,
            () if change <= threshold => Movement::Within,
            () if low > 1.0 => Movement::Faster,
            () if high < 1.0 => Movement::Slower,
            () => Movement::Within,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rays::sampling::Stream;

    /// Times about 10 ms that scatter by `scatter` as logarithms do (skewed to long times), one in `outliers` twice as long.
    fn times(stream: &mut Stream, count: usize, scatter: f64, outliers: f64) -> Vec<f64> {
        let mut normal = || {
            let radius = (-2.0 * (1.0 - stream.unit()).ln()).sqrt();
            let normal = radius * (std::f64::consts::TAU * stream.unit()).cos();
            (normal, stream.unit())
        };
        let time =
            |(normal, chance): (f64, f64)| 10.0 * (scatter * normal).exp() * if chance < outliers { 2.0 } else { 1.0 };
        (0..count).map(|_| time(normal())).collect()
    }

    fn movement(before: &[f64], after: &[f64]) -> Movement {
        Ratio::of_speeds(before, after).unwrap().movement(before.len().min(after.len()), 0.05)
    }

    const TRIALS: usize = 2000;

    /// How often pairs of lots are said to have moved, and how often their medians differ by more than 5 %.
    fn rates(count: usize, scatter: f64, outliers: f64, slowdown: f64) -> (f64, f64) {
        let mut stream = Stream::new(7, 900, (count as u64) << 20 | (scatter * 1e3) as u64);
        let (mut moved, mut naive) = (0, 0);
        for _ in 0..TRIALS {
            let before = times(&mut stream, count, scatter, outliers);
            let after: Vec<f64> = times(&mut stream, count, scatter, outliers).iter().map(|ms| ms * slowdown).collect();
            let said = movement(&before, &after);
            assert!(slowdown < 1.1 || said != Movement::Faster);
            moved += usize::from(matches!(said, Movement::Slower | Movement::Faster));
            let ratio = median(&before) / median(&after);
            naive += usize::from(ratio.max(1.0 / ratio) > 1.05);
        }
        (moved as f64 / TRIALS as f64, naive as f64 / TRIALS as f64)
    }

    /// Proves that lots of one distribution are hardly ever said to have moved, however many samples there are and however
    /// they scatter, where holding medians against the threshold alone (the negative control) would often say so.
    #[test]
    fn false_alarms_are_rare() {
        for (count, most) in [(4, 0.04), (6, 0.01), (10, 0.002), (20, 0.002)] {
            for (scatter, outliers) in [(0.02, 0.0), (0.1, 0.0), (0.3, 0.0), (0.05, 0.2)] {
                let (moved, _) = rates(count, scatter, outliers, 1.0);
                assert!(moved <= most, "{count} samples, scatter {scatter}: {moved}");
            }
        }
        let (_, naive) = rates(10, 0.2, 0.0, 1.0);
        assert!(naive > 0.3, "{naive}");
        // Four samples are the fewest: three would be wrong too often.
        let disjoint = (0..TRIALS).filter(|trial| {
            let mut stream = Stream::new(8, 901, *trial as u64);
            let (before, after) = (times(&mut stream, 3, 0.2, 0.0), times(&mut stream, 3, 0.2, 0.0));
            matches!(
                Ratio::of_speeds(&before, &after).unwrap().movement(LEAST_SAMPLES, 0.0),
                Movement::Slower | Movement::Faster
            )
        });
        assert!(disjoint.count() as f64 / TRIALS as f64 > 0.05);
    }

    /// Proves that a true slowdown of 20 % is said where samples scatter less than it, and one of 3 %, below the threshold,
    /// is not however clear it is.
    #[test]
    fn true_changes_are_found() {
        assert!(rates(10, 0.03, 0.0, 1.2).0 > 0.99);
        // Two slow outliers among ten samples hide it, which is one lot in four: the price of few false alarms.
        assert!(rates(10, 0.03, 0.1, 1.2).0 > 0.6);
        assert!(rates(6, 0.02, 0.0, 1.2).0 > 0.95);
        assert_eq!(rates(10, 0.001, 0.0, 1.03).0, 0.0);
    }

    /// Proves that intervals cover the true ratio at least as often as they say.
    #[test]
    fn intervals_cover() {
        for count in [6, 10, 15] {
            let mut stream = Stream::new(9, 902, count as u64);
            let mut covered = 0;
            let mut coverage = 0.0;
            for _ in 0..TRIALS {
                let before = times(&mut stream, count, 0.2, 0.0);
                let after: Vec<f64> = times(&mut stream, count, 0.1, 0.0).iter().map(|ms| ms * 1.25).collect();
                let ratio = Ratio::of_speeds(&before, &after).unwrap();
                coverage = ratio.coverage;
                covered += usize::from(ratio.interval[0] <= 0.8 && 0.8 <= ratio.interval[1]);
            }
            assert!(covered as f64 / TRIALS as f64 >= coverage && coverage > 0.93, "{count}: {covered} {coverage}");
        }
    }

    /// Ends: nothing timed, times of nothing, too few samples, either direction.
    #[test]
    fn movements_have_directions() {
        assert!(Ratio::of_speeds(&[], &[1.0]).is_none() && Ratio::of_speeds(&[0.0; 4], &[1.0; 4]).is_none());
        let (quick, slow) = (vec![1.0, 1.1, 1.2, 1.3, 1.1], vec![2.0, 2.1, 2.2, 2.3, 2.2]);
        assert_eq!(movement(&quick, &slow), Movement::Slower);
        assert_eq!(movement(&slow, &quick), Movement::Faster);
        assert_eq!(movement(&quick, &quick), Movement::Within);
        assert_eq!(movement(&quick[..3], &slow), Movement::TooFewSamples);
        assert_eq!(Ratio::of_speeds(&quick, &quick).unwrap().value, 1.0);
    }
}
