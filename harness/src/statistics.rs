//! Medians, order-statistic intervals, trends and Wilson intervals.

mod trend;

pub use trend::{Trend, trend};

/// Standard normal quantile of a two-sided 95 % interval.
const Z_95: f64 = 1.959_963_984_540_054;

/// The coverage that intervals aim at.
const WANTED_COVERAGE: f64 = 0.95;

/// The median; the mean of the middle two for an even count; 0 for none.
pub fn median(samples: &[f64]) -> f64 {
    let sorted = sorted(samples);
    match sorted.len() {
        0 => 0.0,
        count if count % 2 == 1 => sorted[count / 2],
        count => f64::midpoint(sorted[count / 2 - 1], sorted[count / 2]),
    }
}

/// A percentile (0 to 100) by the nearest-rank rule; `None` for no samples.
pub fn percentile(samples: &[f64], percent: f64) -> Option<f64> {
    let sorted = sorted(samples);
    let rank = (percent / 100.0 * sorted.len() as f64).ceil() as usize;
    sorted.get(rank.saturating_sub(1)).copied()
}

/// The narrowest symmetric interval of order statistics that covers the distribution's median with at least 95 %, and
/// its coverage. With fewer than six samples even the whole range covers less; then it is the range.
///
/// The k-th smallest and k-th largest of n samples enclose the median unless fewer than k samples fall on one side:
/// coverage = 1 - 2 P(Binomial(n, 1/2) < k).
pub fn median_interval(samples: &[f64]) -> ([f64; 2], f64) {
    median_interval_of(samples, WANTED_COVERAGE)
}

/// [`median_interval`] with at least another coverage, where there are enough samples for it.
pub fn median_interval_of(samples: &[f64], wanted_coverage: f64) -> ([f64; 2], f64) {
    let sorted = sorted(samples);
    let count = sorted.len();
    if count == 0 {
        return ([0.0, 0.0], 0.0);
    }
    // P(Binomial(n, 1/2) = k), k after k, by logarithms so that large n do not overflow.
    let mut logarithm = -(count as f64) * std::f64::consts::LN_2;
    let mut chosen = 1;
    let mut tail = logarithm.exp();
    let mut coverage = 1.0 - 2.0 * tail;
    while 2 * (chosen + 1) <= count {
        logarithm += ((count + 1 - chosen) as f64 / chosen as f64).ln();
        tail += logarithm.exp();
        if 1.0 - 2.0 * tail < wanted_coverage {
            break;
        }
        coverage = 1.0 - 2.0 * tail;
        chosen += 1;
    }
    ([sorted[chosen - 1], sorted[count - chosen]], coverage.max(0.0))
}

/// The 95 % Wilson score interval of a share; `None` for no trials.
pub fn wilson(successes: u64, trials: u64) -> Option<[f64; 2]> {
    if trials == 0 {
        return None;
    }
    let n = trials as f64;
    let share = successes as f64 / n;
    let z2 = Z_95 * Z_95;
    let centre = (share + z2 / (2.0 * n)) / (1.0 + z2 / n);
    let half = Z_95 / (1.0 + z2 / n) * (share * (1.0 - share) / n + z2 / (4.0 * n * n)).sqrt();
    // At shares of 0 and 1 the end is exact; rounding must not push it off.
    let low = if successes == 0 { 0.0 } else { (centre - half).max(0.0) };
    let high = if successes == trials { 1.0 } else { (centre + half).min(1.0) };
    Some([low, high])
}

fn sorted(samples: &[f64]) -> Vec<f64> {
    let mut sorted = samples.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn medians_and_percentiles() {
        assert_eq!(median(&[3.0, 1.0, 2.0]), 2.0);
        assert_eq!(median(&[4.0, 1.0, 2.0, 3.0]), 2.5);
        let hundred: Vec<f64> = (1..=100).map(f64::from).collect();
        assert_eq!(percentile(&hundred, 95.0), Some(95.0));
        assert_eq!(percentile(&hundred, 50.0), Some(50.0));
        assert_eq!(percentile(&[7.0], 99.0), Some(7.0));
        assert_eq!(percentile(&[], 50.0), None);
    }

    /// Against tabulated order statistics: n = 10 gives the 2nd and 9th with 97.9 %, n = 20 the 6th and 15th with
    /// 95.9 %, n = 3 the range with 75 %.
    #[test]
    fn median_intervals_match_tables() {
        let upto = |n: i32| (1..=n).map(f64::from).collect::<Vec<_>>();
        let (interval, coverage) = median_interval(&upto(10));
        assert_eq!(interval, [2.0, 9.0]);
        assert!((coverage - 0.978_515_625).abs() < 1e-12);
        let (interval, coverage) = median_interval(&upto(20));
        assert_eq!(interval, [6.0, 15.0]);
        assert!((coverage - 0.958_610_5).abs() < 1e-6);
        let (interval, coverage) = median_interval(&upto(3));
        assert_eq!(interval, [1.0, 3.0]);
        assert!((coverage - 0.75).abs() < 1e-12);
        assert!(median_interval(&upto(5000)).1 >= 0.95);
    }

    /// Against values worked out from Wilson's formula (1927): 8 of 10 and the ends.
    #[test]
    fn wilson_matches_known_values() {
        let [low, high] = wilson(8, 10).unwrap();
        assert!((low - 0.490_162_5).abs() < 1e-6 && (high - 0.943_317_8).abs() < 1e-6);
        assert_eq!(wilson(0, 50).unwrap()[0], 0.0);
        assert_eq!(wilson(50, 50).unwrap()[1], 1.0);
        assert!(wilson(0, 0).is_none());
    }
}
