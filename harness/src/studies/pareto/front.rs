//! Fronts: of points with a cost and an error those that no other beats in both.

use tracebench_api::named;

/// A point's cost and error; less is better of both.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CostAndError {
    /// What it costs.
    pub cost: f64,
    /// What it gets wrong.
    pub error: f64,
}

named! {
    /// How a point stands to a front.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
    pub enum FrontStatus {
        /// Nothing is better in one and as good in the other.
        OnFront = "front",
        /// Points of the front are, but none of them by more than noise, neither in cost nor in error.
        WithinNoise = "within_noise",
        /// Behind the front.
        Behind = "behind",
    }
}

impl CostAndError {
    /// Whether this is as good in both and better in one.
    pub fn dominates(&self, other: &Self) -> bool {
        let as_good = self.cost <= other.cost && self.error <= other.error;
        as_good && (self.cost < other.cost || self.error < other.error)
    }

    fn is_sound(&self) -> bool {
        self.cost.is_finite() && self.error.is_finite()
    }
}

/// How every point stands to the front of all; what is no number is behind. `surely(q, p)` says whether point q is better than p by more
/// than noise, in cost or in error.
pub fn front_statuses(spots: &[CostAndError], surely: impl Fn(usize, usize) -> bool) -> Vec<FrontStatus> {
    let beaten = |point: usize| spots.iter().any(|other| other.is_sound() && other.dominates(&spots[point]));
    let front: Vec<usize> = (0..spots.len()).filter(|point| spots[*point].is_sound() && !beaten(*point)).collect();
    // Whatever beats a point is beaten by one of the front, or stands on it.
    let front_status = |point: usize| {
        let mut above = front.iter().filter(|other| spots[**other].dominates(&spots[point])).peekable();
        if !spots[point].is_sound() {
            FrontStatus::Behind
        } else if above.peek().is_none() {
            FrontStatus::OnFront
        } else if above.any(|other| surely(*other, point)) {
            FrontStatus::Behind
        } else {
            FrontStatus::WithinNoise
        }
    };
    (0..spots.len()).map(front_status).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rays::sampling::Stream;

    fn spots(of: &[(f64, f64)]) -> Vec<CostAndError> {
        of.iter().map(|(cost, error)| CostAndError { cost: *cost, error: *error }).collect()
    }

    /// The places of a front's points; of points in the same place all.
    fn front(spots: &[CostAndError]) -> Vec<usize> {
        let front_statuses = front_statuses(spots, |_, _| true);
        (0..spots.len()).filter(|point| front_statuses[*point] == FrontStatus::OnFront).collect()
    }

    /// Points drawn from few values, so that many share a cost, an error or both.
    fn drawn(seed: u64, count: usize) -> Vec<CostAndError> {
        let mut stream = Stream::new(seed, 912, count as u64);
        let mut value = || (stream.unit() * 12.0).floor();
        (0..count).map(|_| CostAndError { cost: value(), error: value() }).collect()
    }

    /// The front by brute force and in other words: for a point's cost no lower error, for its error no lower cost is to be had.
    fn by_brute_force(spots: &[CostAndError]) -> Vec<bool> {
        let on = |point: &CostAndError| {
            let min_error = spots
                .iter()
                .filter(|each| each.cost <= point.cost)
                .map(|each| each.error)
                .fold(f64::INFINITY, f64::min);
            let min_cost = spots
                .iter()
                .filter(|each| each.error <= point.error)
                .map(|each| each.cost)
                .fold(f64::INFINITY, f64::min);
            min_error == point.error && min_cost == point.cost
        };
        spots.iter().map(on).collect()
    }

    /// Proves that fronts are those of brute force, also where points share places; that no point of one is dominated; and that the
    /// check notices a point that is put there wrongly.
    #[test]
    fn fronts_are_those_of_brute_force() {
        for seed in 0..200 {
            let spots = drawn(seed, 1 + seed as usize % 40);
            let found: Vec<bool> = front_statuses(&spots, |_, _| true)
                .into_iter()
                .map(|front_status| front_status == FrontStatus::OnFront)
                .collect();
            assert_eq!(found, by_brute_force(&spots), "seed {seed}");
            let mut front = front(&spots);
            front.sort_by(|a, b| spots[*a].cost.total_cmp(&spots[*b].cost));
            let dominated = |of: &[usize]| of.iter().any(|p| spots.iter().any(|q| q.dominates(&spots[*p])));
            assert!(!front.is_empty() && !dominated(&front));
            assert!(front.windows(2).all(|pair| spots[pair[0]].error >= spots[pair[1]].error));
            let wrong: Vec<usize> = (0..spots.len()).collect();
            assert_eq!(dominated(&wrong), front.len() < spots.len());
        }
    }

    /// Planted points: ends, corners, a point that shares a cost, one that shares an error, twins, and what is no number.
    #[test]
    fn planted_points() {
        let planted = spots(&[
            (1.0, 9.0),
            (2.0, 5.0),
            (2.0, 6.0),
            (3.0, 5.0),
            (4.0, 1.0),
            (4.0, 1.0),
            (9.0, 9.0),
            (f64::NAN, 0.0),
            (0.0, f64::INFINITY),
        ]);
        assert_eq!(front(&planted), [0, 1, 4, 5]);
        assert_eq!(front(&[]), Vec::<usize>::new());
    }

    /// A point that is perfect and free has every front to itself; one that is nearly so does not.
    #[test]
    fn perfect_and_free_is_the_whole_front() {
        for seed in 0..50 {
            let mut spots = drawn(seed, 30);
            for spot in &mut spots {
                (spot.cost, spot.error) = (spot.cost + 1.0, spot.error + 1.0);
            }
            spots.push(CostAndError { cost: 0.0, error: 0.0 });
            assert_eq!(front(&spots), [30]);
            let least = spots[..30].iter().map(|spot| spot.cost).fold(f64::INFINITY, f64::min);
            spots[30].cost = least + 0.5;
            assert!(front(&spots).len() > 1);
        }
    }

    /// Within noise is a point that every point of the front beats by noise alone; one that is sure suffices to put it behind, and a
    /// point behind does not matter.
    #[test]
    fn noise_is_told_from_distance() {
        let spots = spots(&[(1.0, 2.0), (1.1, 1.9), (1.15, 2.0), (5.0, 2.0)]);
        let apart = |least: f64| move |q: usize, p: usize| [1.0, 1.1, 1.15, 5.0][p] - [1.0, 1.1, 1.15, 5.0][q] > least;
        let of = |least: f64| front_statuses(&spots, apart(least))[2..].to_vec();
        assert_eq!(of(0.2), [FrontStatus::WithinNoise, FrontStatus::Behind]);
        assert_eq!(of(0.1), [FrontStatus::Behind, FrontStatus::Behind]);
        assert_eq!(of(9.0), [FrontStatus::WithinNoise, FrontStatus::WithinNoise]);
    }
}
