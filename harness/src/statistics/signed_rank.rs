//! Intervals of what paired samples differ by: the signed-rank interval (Wilcoxon 1945; Hodges, Lehmann 1963; Hollander, Wolfe,
//! Chicken, Nonparametric Statistical Methods, section 3.3).

/// Samples up to which the distribution of the rank sum is counted; beyond it the normal one stands in, whose far tails are
/// heavier than the true ones, so that intervals are rather too wide than too narrow.
const COUNTED: usize = 40;

/// Where the middle of a symmetric distribution lies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Middle {
    /// The median of the means of all pairs of samples (Hodges, Lehmann).
    pub value: f64,
    /// Order statistics of these means.
    pub interval: [f64; 2],
    /// Probability that the interval covers the middle.
    pub coverage: f64,
}

/// The middle of samples with an interval that covers it with at least `wanted` where there are enough samples for that (12
/// reach 99.9 %), else the whole range; `None` for no samples.
///
/// Samples must be symmetric about their middle, which need be no more than this: differences of two whose places in every round
/// are drawn by lot are symmetric about 0 where both are alike, whatever the noise, its tails and its ties to earlier rounds.
pub fn middle(samples: &[f64], wanted: f64) -> Option<Middle> {
    let mut means = Vec::with_capacity(samples.len() * (samples.len() + 1) / 2);
    for (index, one) in samples.iter().enumerate() {
        means.extend(samples[..=index].iter().map(|other| f64::midpoint(*one, *other)));
    }
    let (left_out, coverage) = ends(samples.len(), wanted);
    let last = means.len().checked_sub(1)?;
    let mut at = |place: usize| *means.select_nth_unstable_by(place, f64::total_cmp).1;
    let value = f64::midpoint(at(last / 2), at(last.div_ceil(2)));
    Some(Middle { value, interval: [at(left_out), at(last - left_out)], coverage })
}

/// How many means may be left out at either end of so many samples' so that the rest covers the middle with at least `wanted`,
/// and what it covers.
pub fn ends(samples: usize, wanted: f64) -> (usize, f64) {
    let tail = (1.0 - wanted) / 2.0;
    if samples > COUNTED {
        let n = samples as f64;
        let (mean, spread) = (n * (n + 1.0) / 4.0, (n * (n + 1.0) * (2.0 * n + 1.0) / 24.0).sqrt());
        let left_out = (mean - 0.5 - normal_quantile(tail) * spread).max(0.0) as usize;
        return (left_out, wanted);
    }
    // How many of the 2^n ways to give ranks signs have a sum of the positive ones: ranks are added one after the other.
    let mut ways = vec![1.0_f64];
    for rank in 1..=samples {
        let longer = ways.len() + rank;
        ways = (0..longer)
            .map(|sum| {
                let with = sum.checked_sub(rank).and_then(|rest| ways.get(rest));
                ways.get(sum).unwrap_or(&0.0) + with.unwrap_or(&0.0)
            })
            .collect();
    }
    let all = 2.0_f64.powi(samples as i32);
    let mut below = ways[0] / all;
    let mut left_out = 0;
    while left_out + 1 < ways.len() / 2 && below + ways[left_out + 1] / all <= tail {
        left_out += 1;
        below += ways[left_out] / all;
    }
    (left_out, (1.0 - 2.0 * below).max(0.0))
}

/// How many standard deviations above the mean a normal distribution has this much left (Abramowitz, Stegun 26.2.23, off by at
/// most 4.5e-4, which is added).
fn normal_quantile(tail: f64) -> f64 {
    let t = (-2.0 * tail.ln()).sqrt();
    let above = 2.515_517 + t * (0.802_853 + t * 0.010_328);
    t - above / (1.0 + t * (1.432_788 + t * (0.189_269 + t * 0.001_308))) + 4.5e-4
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against tabulated critical values of the rank sum, two-sided (Hollander, Wolfe, Chicken, table A.4; Wilcoxon, Wilcox 1964):
    /// at 5 % the sums up to 13 for 12 samples, 52 for 20, 137 for 30; at 1 % 7, 37, 109. So many means are left out at either end.
    #[test]
    fn ends_match_tables() {
        for (samples, at_95, at_99) in [(12, 13, 7), (20, 52, 37), (30, 137, 109)] {
            assert_eq!((ends(samples, 0.95).0, ends(samples, 0.99).0), (at_95, at_99), "{samples}");
        }
        // Twelve are enough for 99.9 %, ten are not: all ways but the two with all signs alike.
        assert!(ends(12, 0.999).1 >= 0.999);
        assert_eq!(ends(10, 0.999), (0, 1.0 - 2.0 / 1024.0));
        // The normal stand-in leaves out no more than counting does.
        let (counted, normal) = (ends(COUNTED, 0.999).0, ends(COUNTED + 1, 0.999).0);
        assert!(counted.abs_diff(normal) < 20, "{counted} {normal}");
        assert!((normal_quantile(0.025) - 1.96).abs() < 1e-3 && (normal_quantile(0.0005) - 3.2905).abs() < 1e-3);
    }

    /// Worked out by hand: means of 1, 2, 4 are 1, 1.5, 2, 2.5, 3, 4.
    #[test]
    fn middles_are_of_means() {
        let found = middle(&[4.0, 1.0, 2.0], 0.5).unwrap();
        assert_eq!((found.value, found.interval), (2.25, [1.5, 3.0]));
        assert_eq!(middle(&[7.0], 0.999), Some(Middle { value: 7.0, interval: [7.0; 2], coverage: 0.0 }));
        assert!(middle(&[], 0.999).is_none());
    }
}
