//! Whether something drifts: rank correlation with the round, and the slope that goes with it.

use super::median;

/// How samples move over their rounds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trend {
    /// By how much they change from the first round to the last: the median of the slopes between all pairs (Theil 1950, Sen 1968).
    pub change: f64,
    /// Standard deviations that Kendall's count of pairs in order lies off what it is expected to be without a trend (Mann 1945).
    pub deviations: f64,
}

/// The trend of samples in order; `None` below three.
pub fn trend(samples: &[f64]) -> Option<Trend> {
    let count = samples.len();
    if count < 3 {
        return None;
    }
    let mut slopes = Vec::with_capacity(count * (count - 1) / 2);
    let mut in_order = 0.0;
    for (later, one) in samples.iter().enumerate() {
        for (earlier, other) in samples[..later].iter().enumerate() {
            let step = one - other;
            slopes.push(step / (later - earlier) as f64);
            in_order += if step == 0.0 { 0.0 } else { step.signum() };
        }
    }
    let n = count as f64;
    let spread = (n * (n - 1.0) * (2.0 * n + 5.0) / 18.0).sqrt();
    // Less one for continuity.
    let deviations = f64::copysign((f64::abs(in_order) - 1.0).max(0.0), in_order) / spread;
    Some(Trend { change: median(&slopes) * (n - 1.0), deviations })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Worked out by hand: of 1, 2, 4, 3 five of six pairs rise, slopes are 1, 1.5, 2, 2/3, 1/2, -1.
    #[test]
    fn trends_are_of_pairs() {
        let found = trend(&[1.0, 2.0, 4.0, 3.0]).unwrap();
        assert!((found.change - 3.0 * f64::midpoint(2.0 / 3.0, 1.0)).abs() < 1e-12);
        assert!((found.deviations - 3.0 / (4.0 * 3.0 * 13.0 / 18.0_f64).sqrt()).abs() < 1e-12);
        assert_eq!(trend(&[5.0; 12]), Some(Trend { change: 0.0, deviations: 0.0 }));
        assert!(trend(&[1.0, 2.0]).is_none());
        // One stray sample is no trend, however far it strays.
        let mut stray = [10.0; 20];
        stray[19] = 1000.0;
        assert_eq!(trend(&stray).unwrap().change, 0.0);
    }
}
