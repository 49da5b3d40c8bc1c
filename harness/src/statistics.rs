//! Medians, order-statistic intervals, trends and Wilson intervals.

mod trend;

pub use trend::{Trend, trend};

/// Standard normal quantile of a two-sided 95 % interval.
const Z_95: f64 = 1.959_963_984_540_054;

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

/// Spearman's rank correlation of pairs; values that are the same share the mean of their ranks. `None` for fewer than three pairs, and
/// where one side is the same throughout.
pub fn rank_correlation(pairs: &[[f64; 2]]) -> Option<f64> {
    let ranks = |side: usize| -> Vec<f64> {
        let below = |value: f64| pairs.iter().filter(|pair| pair[side] < value).count();
        let same = |value: f64| pairs.iter().filter(|pair| pair[side] == value).count();
        pairs.iter().map(|pair| below(pair[side]) as f64 + (same(pair[side]) as f64 + 1.0) / 2.0).collect()
    };
    let [one, other] = [ranks(0), ranks(1)];
    let mean = (pairs.len() as f64 + 1.0) / 2.0;
    let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - mean) * (b - mean)).sum::<f64>();
    let spread = (product(&one, &one) * product(&other, &other)).sqrt();
    (pairs.len() >= 3 && spread > 0.0).then(|| product(&one, &other) / spread)
}

/// The narrowest symmetric interval of order statistics that covers the distribution's median with at least 95 %, and
/// its coverage. With fewer than six samples even the whole range covers less; then it is the range.
///
/// The k-th smallest and k-th largest of n samples enclose the median unless fewer than k samples fall on one side:
/// coverage = 1 - 2 P(Binomial(n, 1/2) < k).
pub fn median_interval(samples: &[f64]) -> ([f64; 2], f64) {
    median_interval_of(samples, 0.95)
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

/// What so many trials without a single success leave possible: the upper end of the 95 % interval of their share (Hanley and
/// Lippman-Hand 1983, the rule of three); 1 for few trials.
pub fn rule_of_three(trials: u64) -> f64 {
    (3.0 / trials.max(1) as f64).min(1.0)
}

/// By how much a share changed between two judgements of the same trials: those that were `gained` less those that were `lost`, over
/// all, with its 95 % interval; `None` for no trials. The interval is the adjusted one of Agresti and Min (2005): half a trial is added
/// to each cell of the table of both judgements, so that no change at all has an interval, too.
pub fn paired_difference(gained: u64, lost: u64, trials: u64) -> Option<(f64, [f64; 2])> {
    if trials == 0 {
        return None;
    }
    let n = trials as f64 + 2.0;
    let (gained_half, lost_half) = (gained as f64 + 0.5, lost as f64 + 0.5);
    let difference = gained_half - lost_half;
    let half = Z_95 * (gained_half + lost_half - difference * difference / n).max(0.0).sqrt() / n;
    let centre = difference / n;
    let value = (gained as f64 - lost as f64) / trials as f64;
    Some((value, [(centre - half).max(-1.0), (centre + half).min(1.0)]))
}

fn sorted(samples: &[f64]) -> Vec<f64> {
    let mut sorted = samples.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted
}

#[cfg(test)]
mod tests {
    /// Ranks that agree, are reversed, and are shared give what the formula gives by hand; too few or equal ones nothing.
    #[test]
    fn rank_correlations() {
        let of = |one: &[f64], other: &[f64]| {
            rank_correlation(&one.iter().zip(other).map(|(a, b)| [*a, *b]).collect::<Vec<_>>())
        };
        assert_eq!(of(&[1.0, 2.0, 30.0], &[0.1, 0.2, 0.3]), Some(1.0));
        assert_eq!(of(&[1.0, 2.0, 30.0], &[3.0, 2.0, 1.0]), Some(-1.0));
        // Ranks 1, 2, 3, 4 beside 2, 1, 4, 3: 1 - 6 * 4 / 60.
        assert!((of(&[1.0, 2.0, 3.0, 4.0], &[2.0, 1.0, 4.0, 3.0]).unwrap() - 0.6).abs() < 1e-12);
        // Ranks 1, 2.5, 2.5 beside 1, 2, 3.
        assert!((of(&[1.0, 2.0, 2.0], &[1.0, 2.0, 3.0]).unwrap() - 0.75_f64.sqrt()).abs() < 1e-12);
        assert_eq!((of(&[1.0, 2.0], &[1.0, 2.0]), of(&[1.0; 3], &[1.0, 2.0, 3.0])), (None, None));
    }

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

    /// Against values worked out from the formula of Agresti and Min by hand, and its bounds: signs turn round with the direction, no
    /// change has an interval about 0, and one that leaves out the pairing is wider.
    #[test]
    fn paired_differences_match_the_formula() {
        let near = |found: f64, expected: f64| (found - expected).abs() < 1e-9;
        // (30.5 - 10.5) / 1002 and 1.96 sqrt(41 - 400 / 1002) / 1002.
        let (value, [low, high]) = paired_difference(30, 10, 1000).unwrap();
        assert!(near(value, 0.02) && near(low, 0.007_496_360_629) && near(high, 0.032_423_799_052), "{low} {high}");
        let (_, turned) = paired_difference(10, 30, 1000).unwrap();
        assert!(near(turned[0], -high) && near(turned[1], -low));
        let (none, [low, high]) = paired_difference(0, 0, 32_768).unwrap();
        assert!(none == 0.0 && near(low, -high) && high > 0.0 && high < 1e-4);
        let ends = paired_difference(5, 0, 5).unwrap().1;
        assert!(ends[1] <= 1.0 && paired_difference(0, 0, 0).is_none());
        // Unpaired, by the rates of 530 and 510 wrong of 1000 each, of which 500 are the same rays: wider by far.
        let unpaired = wilson(530, 1000).unwrap()[1] - wilson(510, 1000).unwrap()[0];
        let (_, paired) = paired_difference(30, 10, 1000).unwrap();
        assert!(unpaired > 2.0 * paired[1], "{unpaired}");
    }

    /// The interval of a paired difference covers the true one about as often as it says: of 400 rays of which each becomes wrong
    /// with one chance and right with another, drawn by a fixed sequence. One half as wide (the negative control) does not.
    #[test]
    fn paired_differences_cover() {
        let mut stream = crate::rays::sampling::Stream::new(3, 911, 0);
        let (trials, gain, loss) = (400_u64, 0.04, 0.01);
        let (mut covered, mut narrow) = (0, 0);
        const LOTS: usize = 2000;
        for _ in 0..LOTS {
            let (mut gained, mut lost) = (0, 0);
            for _ in 0..trials {
                let drawn = stream.unit();
                gained += u64::from(drawn < gain);
                lost += u64::from((gain..gain + loss).contains(&drawn));
            }
            let (_, [low, high]) = paired_difference(gained, lost, trials).unwrap();
            let (centre, half) = (f64::midpoint(low, high), (high - low) / 2.0);
            covered += usize::from((centre - (gain - loss)).abs() <= half);
            narrow += usize::from((centre - (gain - loss)).abs() <= half / 2.0);
        }
        let share = |count: usize| count as f64 / LOTS as f64;
        assert!((0.93..=0.985).contains(&share(covered)), "{}", share(covered));
        assert!(share(narrow) < 0.8, "{}", share(narrow));
    }

    #[test]
    fn nothing_of_many_leaves_three_of_many() {
        assert_eq!((rule_of_three(3000), rule_of_three(1), rule_of_three(0)), (0.001, 1.0, 1.0));
        // It is what the exact bound, 1 - 0.05 to the power of 1/N, comes to.
        let exact = 1.0 - 0.05_f64.powf(1.0 / 3000.0);
        assert!((rule_of_three(3000) / exact - 1.0).abs() < 0.01);
    }
}
