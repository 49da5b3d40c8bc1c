//! Whether something drifts: rank correlation with the round, and the slope that goes with it.

use super::median;

/// How samples move over their rounds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trend {
    /// By how much they change from the first round to the last: the median of the slopes between all pairs (Theil 1950, Sen 1968).
    pub change: f64,
    /// Standard deviations that Kendall's count of pairs in order lies off what it is without a trend (Mann 1945), neighbours being as
    /// alike as they are.
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
    let change = median(&slopes) * (n - 1.0);
    let rest: Vec<f64> =
        samples.iter().enumerate().map(|(round, one)| one - change * round as f64 / (n - 1.0)).collect();
    let spread = (n * (n - 1.0) * (2.0 * n + 5.0) / 18.0 * inflation(&rest)).sqrt();
    // Less one for continuity.
    let deviations = f64::copysign((f64::abs(in_order) - 1.0).max(0.0), in_order) / spread;
    Some(Trend { change, deviations })
}

/// How many times the variance of Kendall's count is that of independent samples, where neighbours are alike (Hamed, Rao 1998, by the
/// autocorrelation of ranks that is beyond chance): a machine that is slow for some rounds in a row is no drift.
fn inflation(samples: &[f64]) -> f64 {
    let n = samples.len() as f64;
    let mut order: Vec<usize> = (0..samples.len()).collect();
    order.sort_by(|one, other| samples[*one].total_cmp(&samples[*other]));
    let mut ranks = vec![0.0; samples.len()];
    for (rank, place) in order.into_iter().enumerate() {
        ranks[place] = rank as f64 - (n - 1.0) / 2.0;
    }
    let all: f64 = ranks.iter().map(|rank| rank * rank).sum();
    let beyond = |lag: usize| {
        let alike = ranks.iter().zip(&ranks[lag..]).map(|(one, other)| one * other).sum::<f64>() / all;
        let left = n - lag as f64;
        if alike > 1.96 / n.sqrt() { left * (left - 1.0) * (left - 2.0) * alike } else { 0.0 }
    };
    1.0 + 2.0 / (n * (n - 1.0) * (n - 2.0)) * (1..samples.len() / 2).map(beyond).sum::<f64>()
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
        // Slow for some rounds in a row is less sure than as many slow rounds here and there.
        let waves: Vec<f64> = (0..48).map(|round| f64::from(round / 8 % 2) + 0.01 * f64::from(round * 7 % 5)).collect();
        let mixed: Vec<f64> = (0..48).map(|round| f64::from((round + 5) * (round + 9) * 37 % 101)).collect();
        assert!(inflation(&waves) > 3.0 && inflation(&mixed) < 2.0, "{} {}", inflation(&waves), inflation(&mixed));
        // One stray sample is no trend, however far it strays.
        let mut stray = [10.0; 20];
        stray[19] = 1000.0;
        assert_eq!(trend(&stray).unwrap().change, 0.0);
    }
}
