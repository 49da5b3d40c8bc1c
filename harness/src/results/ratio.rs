//! Ratios of times: by which clock, and how sure they are.
//!
//! One rule of clocks: two times that the same clock took are set against one another as they are; of different clocks both are
//! taken by the host's, which measures work on the host as such and work on a device from submission until done. Where one of
//! them has no such time there is no ratio.
//!
//! Within an interleaved set ratios are of paired rounds ([`super::paired`]). Of times that were not taken together
//! the interval of a ratio comes from order statistics of each lot, [`median_interval_of`], combined: from the least of one over the
//! greatest of the other to the opposite. It assumes nothing about how times scatter (they are skewed, and have outliers), has
//! no seed, and its coverage is known for any number of samples: the product of both, since the lots are independent. A
//! bootstrap of the ratio has none of the three; of ten samples its intervals of a median are known to be too narrow. The
//! price is that it is wide: it covers more often than it says.

use serde::Serialize;
use tracebench_api::ClockKind;

use super::{MIN_ROUNDS, Times};
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

/// A ratio of medians with its interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Ratio {
    /// The ratio.
    pub value: f64,
    /// Its interval.
    pub interval: [f64; 2],
    /// Least probability that the interval covers the true ratio.
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
    /// Neither: the whole interval is within the threshold.
    Within,
    /// Nobody can tell.
    Undecided,
}

impl Ratio {
    /// How many times as long one takes as the other, of lots of times that were not taken together; `None` without samples, or
    /// for a time of nothing.
    pub fn of_times(one: &[f64], other: &[f64], coverage: f64) -> Option<Self> {
        if one.is_empty() || other.is_empty() {
            return None;
        }
        // Both must cover for the ratio to be covered.
        let of_samples = |lot: &[f64]| {
            let (interval, covered) = median_interval_of(lot, coverage.sqrt());
            Self { value: median(lot), interval, coverage: covered }
        };
        let ratio = of_samples(one).over(&of_samples(other));
        let all = [ratio.value, ratio.interval[0], ratio.interval[1]];
        all.iter().all(|value| value.is_finite() && *value > 0.0).then_some(ratio)
    }

    /// This over another one that does not depend on it.
    #[must_use]
    pub fn over(&self, other: &Self) -> Self {
        let ([low, high], [other_low, other_high]) = (self.interval, other.interval);
        Self {
            value: self.value / other.value,
            interval: [low / other_high, high / other_low],
            coverage: self.coverage * other.coverage,
        }
    }

    /// What is to be said of a ratio of speeds from so many samples: it moved if its interval leaves out 1 and the slower takes
    /// more than `threshold` longer (a share) than the faster, it did not if the whole interval is within the threshold.
    pub fn movement(&self, fewest_samples: usize, threshold: f64) -> Movement {
        let [low, high] = self.interval;
        let change = self.value.max(1.0 / self.value) - 1.0;
        match () {
            () if fewest_samples < MIN_ROUNDS as usize => Movement::Undecided,
            () if low > 1.0 && change > threshold => Movement::Faster,
            () if high < 1.0 && change > threshold => Movement::Slower,
            () if high <= 1.0 + threshold && low >= 1.0 / (1.0 + threshold) => Movement::Within,
            () => Movement::Undecided,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rays::sampling::Stream;
    use crate::results::COVERAGE;

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
        Ratio::of_times(before, after, COVERAGE).unwrap().movement(before.len().min(after.len()), 0.05)
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
        for count in [12, 20] {
            for (scatter, outliers) in [(0.02, 0.0), (0.1, 0.0), (0.3, 0.0), (0.05, 0.2)] {
                let (moved, _) = rates(count, scatter, outliers, 1.0);
                assert!(moved <= 0.001, "{count} samples, scatter {scatter}: {moved}");
            }
        }
        let (_, naive) = rates(12, 0.2, 0.0, 1.0);
        assert!(naive > 0.3, "{naive}");
    }

    /// Proves that a true slowdown of 20 % is said where samples scatter less than it, and one of 3 %, below the threshold,
    /// is not however clear it is; fewer samples than a verdict needs say nothing however clear it is.
    #[test]
    fn true_changes_are_found() {
        assert!(rates(12, 0.03, 0.0, 1.2).0 > 0.99);
        // Slow outliers, one sample in ten, hide it in few lots of thirty: the price of few false alarms.
        assert!(rates(30, 0.03, 0.1, 1.2).0 > 0.8);
        assert_eq!(rates(12, 0.001, 0.0, 1.03).0, 0.0);
        assert_eq!(rates(11, 0.001, 0.0, 2.0).0, 0.0);
    }

    /// Proves that intervals cover the true ratio at least as often as they say.
    #[test]
    fn intervals_cover() {
        for count in [12, 15, 20] {
            let mut stream = Stream::new(9, 902, count as u64);
            let mut covered = 0;
            let mut coverage = 0.0;
            for _ in 0..TRIALS {
                let before = times(&mut stream, count, 0.2, 0.0);
                let after: Vec<f64> = times(&mut stream, count, 0.1, 0.0).iter().map(|ms| ms * 1.25).collect();
                let ratio = Ratio::of_times(&before, &after, COVERAGE).unwrap();
                coverage = ratio.coverage;
                covered += usize::from(ratio.interval[0] <= 0.8 && 0.8 <= ratio.interval[1]);
            }
            assert!(
                coverage >= COVERAGE && covered as f64 / TRIALS as f64 >= COVERAGE,
                "{count}: {covered} {coverage}"
            );
        }
    }

    /// Ends: nothing timed, times of nothing, either direction, the same, and neither.
    #[test]
    fn movements_have_directions() {
        assert!(Ratio::of_times(&[], &[1.0], COVERAGE).is_none());
        assert!(Ratio::of_times(&[0.0; 4], &[1.0; 4], COVERAGE).is_none());
        let lot = |scale: f64| (0..12).map(|sample| scale * (1.0 + 0.01 * f64::from(sample % 5))).collect::<Vec<_>>();
        let (quick, slow) = (lot(1.0), lot(2.0));
        assert_eq!(movement(&quick, &slow), Movement::Slower);
        assert_eq!(movement(&slow, &quick), Movement::Faster);
        assert_eq!(movement(&quick, &quick), Movement::Within);
        assert_eq!(movement(&quick, &lot(1.03)), Movement::Undecided);
        assert_eq!(Ratio::of_times(&quick, &quick, COVERAGE).unwrap().value, 1.0);
    }
}
