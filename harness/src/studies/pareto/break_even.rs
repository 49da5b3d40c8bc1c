//! Break-even: at how many rays a frame one method overtakes another.
//!
//! What a trace takes is fitted to three numbers of rays as `a + b rays`, by least squares of relative errors, with neither part below
//! nothing. The fit is a sum of the
//! measured times with known weights, so the ends of their intervals give the ends of its own at every number of rays, with nothing
//! assumed about how times scatter. What is done once a frame comes to it: nothing where the geometry stands still, a refit or a build
//! where it moves. Where the intervals of two methods overlap nobody can tell which is cheaper.

use itertools::Itertools as _;
use tracebench_api::named;

use super::field::Amount;

/// How far beyond the measured numbers of rays costs are compared with one another, times.
pub const BEYOND: f64 = 16.0;

/// Steps over the range in which a change of the cheaper one is looked for, and halvings that place it.
const STEPS: u32 = 240;
const HALVINGS: u32 = 40;

named! {
    /// What becomes of the geometry from frame to frame.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
    pub enum Motion {
        /// It stands still: structures are kept.
        Static = "static",
        /// Its vertices move: structures are refitted, or built where a method cannot.
        Refitted = "refitted",
        /// It is another one in every frame: structures are built.
        Rebuilt = "rebuilt",
    }
}

/// What traces take by their number of rays.
#[derive(Clone, Debug, PartialEq)]
pub struct Fit {
    /// Numbers of rays with the time of each, milliseconds.
    pub samples: Vec<(f64, Amount)>,
    /// By sample the weights of its time in `a` and in `b`.
    weights: Vec<[f64; 2]>,
}

impl Fit {
    /// A line through times of different numbers of rays; `None` for fewer than two numbers, or times that are none.
    pub fn new(samples: Vec<(f64, Amount)>) -> Option<Self> {
        let sound = |(rays, ms): &(f64, Amount)| *rays > 0.0 && ms.value.is_finite() && ms.value > 0.0;
        if !samples.iter().all(sound) {
            return None;
        }
        // Relative errors count alike, so a time weighs as the square of its inverse.
        let weight = |ms: &Amount| 1.0 / (ms.value * ms.value);
        let sum = |of: &dyn Fn(f64) -> f64| samples.iter().map(|(rays, ms)| weight(ms) * of(*rays)).sum::<f64>();
        let (ones, rays, squares) = (sum(&|_| 1.0), sum(&|rays| rays), sum(&|rays| rays * rays));
        let determinant = ones * squares - rays * rays;
        if samples.len() < 2 || determinant <= 1e-12 * ones * squares {
            return None;
        }
        let line = |own: f64| [(squares - rays * own) / determinant, (ones * own - rays) / determinant];
        let through_zero = |own: f64| [0.0, own / squares];
        let flat = |_: f64| [1.0 / ones, 0.0];
        let fitted = |of: &dyn Fn(f64) -> [f64; 2]| {
            let weigh = |(own, ms): &(f64, Amount)| of(*own).map(|part| weight(ms) * part);
            Self { weights: samples.iter().map(weigh).collect(), samples: samples.clone() }
        };
        // Neither part is less than nothing.
        let found = fitted(&line);
        Some(match found.parts().map(|part| part.value < 0.0) {
            [true, _] => fitted(&through_zero),
            [_, true] => fitted(&flat),
            _ => found,
        })
    }

    /// The time of so many rays.
    pub fn at(&self, rays: f64) -> Amount {
        self.sum(|[a, b]| a + b * rays)
    }

    /// The constant part, milliseconds a trace, and the part a ray, milliseconds.
    pub fn parts(&self) -> [Amount; 2] {
        [self.sum(|[a, _]| a), self.sum(|[_, b]| b)]
    }

    fn sum(&self, weight: impl Fn([f64; 2]) -> f64) -> Amount {
        let parts = self.samples.iter().zip(&self.weights).map(|((_, ms), weights)| ms.times(weight(*weights)));
        parts.fold(Amount::exact(0.0), Amount::and)
    }

    fn ends(&self) -> [f64; 2] {
        let rays = || self.samples.iter().map(|(rays, _)| *rays);
        [rays().fold(f64::INFINITY, f64::min), rays().fold(0.0, f64::max)]
    }
}

/// What a method takes for a frame.
#[derive(Clone, Debug, PartialEq)]
pub struct FrameCost {
    /// What it does once a frame, milliseconds.
    pub once: Amount,
    /// Its traces.
    pub traces: Fit,
    /// Why no verdict rests on these times, if none does.
    pub caveat: Option<String>,
}

impl FrameCost {
    /// The time of a frame with so many rays, milliseconds.
    pub fn at(&self, rays: f64) -> Amount {
        self.once.and(self.traces.at(rays))
    }
}

/// Which of two methods is cheaper, by the number of rays a frame.
#[derive(Clone, Debug, PartialEq)]
pub enum BreakEven {
    /// One is, at every number of rays that was looked at: 0 the first, 1 the second.
    Always(usize),
    /// One is for fewer rays than so many, the other for more.
    At {
        /// Who is cheaper below: 0 the first, 1 the second.
        below: usize,
        /// The number of rays.
        rays: f64,
        /// From where on, and up to where, the intervals of both overlap.
        interval: [f64; 2],
        /// Whether it lies beyond the numbers of rays that were measured.
        beyond_measured: bool,
    },
    /// Nobody can tell, and why.
    Undecided(String),
}

impl BreakEven {
    /// From how many rays on, with its interval, and whether it lies beyond what was measured.
    pub fn at(&self) -> Option<(f64, [f64; 2], bool)> {
        match *self {
            Self::At { rays, interval, beyond_measured, .. } => Some((rays, interval, beyond_measured)),
            Self::Always(_) | Self::Undecided(_) => None,
        }
    }

    /// Why nobody can tell.
    pub fn undecided(&self) -> Option<&str> {
        if let Self::Undecided(why) = self { Some(why) } else { None }
    }
}

/// The least and the greatest number of rays that was measured of two methods.
fn measured(one: &FrameCost, other: &FrameCost) -> [f64; 2] {
    let ([low, high], [other_low, other_high]) = (one.traces.ends(), other.traces.ends());
    [low.min(other_low), high.max(other_high)]
}

/// The numbers of rays at which two methods are compared with one another: those measured, and so many times beyond.
pub fn range(one: &FrameCost, other: &FrameCost) -> [f64; 2] {
    let [least, most] = measured(one, other);
    [least / BEYOND, most * BEYOND]
}

/// Which of two is cheaper where.
pub fn break_even(one: &FrameCost, other: &FrameCost) -> BreakEven {
    if let Some(caveat) = one.caveat.clone().or_else(|| other.caveat.clone()) {
        return BreakEven::Undecided(caveat);
    }
    let [least, most] = range(one, other);
    // Who is surely cheaper.
    let cheaper = |rays: f64| {
        let (one, other) = (one.at(rays).interval, other.at(rays).interval);
        [(one, other), (other, one)].iter().position(|([_, most], [least, _])| most < least)
    };
    let (Some(below), Some(above)) = (cheaper(least), cheaper(most)) else {
        return BreakEven::Undecided("intervals overlap".to_owned());
    };
    let step = |index: u32| least * (most / least).powf(f64::from(index) / f64::from(STEPS));
    let said: Vec<Option<usize>> = (0..=STEPS).map(|index| cheaper(step(index))).collect();
    if below == above {
        // Lines that are apart at both ends do not meet between; their intervals may.
        let overlap = said.contains(&None);
        return if overlap { BreakEven::Undecided("intervals overlap".to_owned()) } else { BreakEven::Always(below) };
    }
    // Halved down to where the one stops being surely cheaper, from a place where it is and one where it is not.
    let edge = |mut sure: f64, mut unsure: f64, who: usize| {
        for _ in 0..HALVINGS {
            let middle = (sure * unsure).sqrt();
            if cheaper(middle) == Some(who) { sure = middle } else { unsure = middle }
        }
        sure
    };
    let first = said.iter().position(|who| *who != Some(below)).unwrap_or(0) as u32;
    let last = said.iter().rposition(|who| *who != Some(above)).unwrap_or(0) as u32;
    let low = edge(step(first.saturating_sub(1)), step(first), below);
    let high = edge(step((last + 1).min(STEPS)), step(last), above);
    let difference = |rays: f64| one.at(rays).value - other.at(rays).value;
    let (at_none, at_one) = (difference(0.0), difference(1.0));
    let rays = at_none / (at_none - at_one);
    let [measured_least, measured_most] = measured(one, other);
    let beyond_measured = !(measured_least..=measured_most).contains(&rays);
    BreakEven::At { below, rays, interval: [low, high], beyond_measured }
}

/// A stretch of numbers of rays over which one of several methods is cheapest.
#[derive(Clone, Debug, PartialEq)]
pub struct Stretch {
    /// Which.
    pub who: usize,
    /// From how many rays on.
    pub from: f64,
    /// How it overtakes the one before; none of the first.
    pub overtakes: Option<BreakEven>,
}

/// Who is cheapest of several methods, from the fewest rays to the most; by the values alone, with what is sure of each change.
pub fn stretches(costs: &[FrameCost]) -> Vec<Stretch> {
    let all = || costs.iter().map(|cost| range(cost, cost));
    let least = all().map(|[low, _]| low).fold(f64::INFINITY, f64::min);
    let most = all().map(|[_, high]| high).fold(0.0, f64::max);
    let cheapest = |rays: f64| {
        let at = costs.iter().enumerate().map(|(place, cost)| (cost.at(rays).value, place));
        at.min_by(|one, other| one.0.total_cmp(&other.0)).map(|(_, place)| place)
    };
    let steps = (0..=STEPS).map(|index| least * (most / least).powf(f64::from(index) / f64::from(STEPS)));
    let by_rays = steps.map_while(|rays| Some((cheapest(rays)?, rays))).dedup_by(|one, other| one.0 == other.0);
    let changes: Vec<(usize, f64)> = by_rays.collect();
    let first = changes.first().map(|&(who, from)| Stretch { who, from, overtakes: None });
    let later = changes.windows(2).map(|pair| {
        let [(last, _), (who, rays)] = [pair[0], pair[1]];
        let found = break_even(&costs[last], &costs[who]);
        Stretch { who, from: found.at().map_or(rays, |(rays, ..)| rays), overtakes: Some(found) }
    });
    first.into_iter().chain(later).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A method whose traces take a line exactly, with intervals of a share to both sides.
    fn method(once: f64, [fixed, per_ray]: [f64; 2], share: f64) -> FrameCost {
        let amount = |value: f64| Amount { value, interval: [value * (1.0 - share), value * (1.0 + share)] };
        let samples = [1e3, 4e3, 16e3].map(|rays| (rays, amount(fixed + per_ray * rays)));
        FrameCost { once: amount(once), traces: Fit::new(samples.to_vec()).unwrap(), caveat: None }
    }

    fn near(found: f64, expected: f64) -> bool {
        (found / expected - 1.0).abs() < 1e-6
    }

    /// Proves that a fit gives back the line that times lie on, that its interval at a measured number of rays holds that of the time,
    /// and that one number of rays, measured often, is no line.
    #[test]
    fn fits_give_lines_back() {
        let found = method(0.0, [2.0, 1e-3], 0.01).traces;
        let [fixed, per_ray] = found.parts();
        assert!(near(fixed.value, 2.0) && near(per_ray.value, 1e-3));
        for rays in [0.5e3, 1e3, 4e3, 16e3, 1e6] {
            let at = found.at(rays);
            assert!(near(at.value, 2.0 + 1e-3 * rays) && at.interval[0] < at.value && at.value < at.interval[1]);
        }
        // Against the weighted normal equations solved for numbers that lie on no line.
        let bent = [(1.0, 1.5), (2.0, 2.0), (4.0, 4.2)].map(|(rays, ms)| (rays, Amount::exact(ms)));
        let [fixed, per_ray] = Fit::new(bent.to_vec()).unwrap().parts();
        let gradient = |of: fn(f64) -> f64| {
            let off = |(rays, ms): &(f64, Amount)| (fixed.value + per_ray.value * rays - ms.value) / ms.value.powi(2);
            bent.iter().map(|sample| off(sample) * of(sample.0)).sum::<f64>().abs()
        };
        assert!(gradient(|_| 1.0) < 1e-12 && gradient(|rays| rays) < 1e-12);
        // Where the line would begin below nothing it goes through nothing, where it would fall it is flat: no other line with parts that
        // are not less than nothing is nearer.
        for (samples, is_least) in
            [([(1.0, 1.0), (2.0, 2.2), (4.0, 5.0)], 0), ([(1.0, 3.0), (2.0, 2.0), (4.0, 2.1)], 1)]
        {
            let fit = Fit::new(samples.map(|(rays, ms)| (rays, Amount::exact(ms))).to_vec()).unwrap();
            let [fixed, per_ray] = fit.parts().map(|part| part.value);
            assert_eq!([fixed, per_ray][is_least], 0.0, "{fixed} {per_ray}");
            let off =
                |a: f64, b: f64| samples.iter().map(|(rays, ms)| ((a + b * rays) / ms - 1.0).powi(2)).sum::<f64>();
            for (a, b) in [(0.01, 0.0), (0.0, 0.01), (0.01, 0.01), (0.01, -0.005), (-0.005, 0.01), (-0.01, -0.01)] {
                let (a, b) = ((fixed + a).max(0.0), (per_ray + b).max(0.0));
                assert!(off(a, b) >= off(fixed, per_ray) - 1e-12, "{a} {b}");
            }
        }
        let same = vec![(5.0, Amount::exact(1.0)), (5.0, Amount::exact(1.1))];
        assert!(Fit::new(same).is_none() && Fit::new(Vec::new()).is_none());
        assert!(Fit::new(vec![(1.0, Amount::exact(0.0)), (2.0, Amount::exact(1.0))]).is_none());
    }

    /// Proves that two methods meet where the formula says, (A - B) / (b - a) of what they do once and of what a ray takes, in either
    /// order; that the interval holds it; and that one which is cheaper in both is so always.
    #[test]
    fn lines_meet_where_the_formula_says() {
        let (slow_build, slow_trace) = (method(20.0, [1.0, 1e-3], 0.0), method(4.0, [1.0, 3e-3], 0.0));
        let expected = (20.0 - 4.0) / (3e-3 - 1e-3);
        let found = break_even(&slow_build, &slow_trace);
        let BreakEven::At { below: 1, rays, interval: [low, high], beyond_measured: false } = found else {
            panic!("{found:?}")
        };
        assert!(near(rays, expected) && near(low, expected) && near(high, expected), "{rays} {low} {high}");
        let turned = break_even(&slow_trace, &slow_build);
        assert!(matches!(turned, BreakEven::At { below: 0, rays, .. } if near(rays, expected)), "{turned:?}");
        // Far out it is told that nothing was measured there.
        let far = break_even(&method(200.0, [1.0, 1e-3], 0.0), &slow_trace);
        assert!(matches!(far, BreakEven::At { beyond_measured: true, .. }), "{far:?}");
        let better = method(3.0, [0.5, 2e-3], 0.0);
        assert_eq!(break_even(&better, &slow_trace), BreakEven::Always(0));
        assert_eq!(break_even(&slow_trace, &better), BreakEven::Always(1));
    }

    /// Proves that intervals which overlap at an end decide nothing, that wider ones give a wider stretch of overlap which holds the
    /// exact place, and that a doubt about the times is the verdict.
    #[test]
    fn overlapping_intervals_are_undecided() {
        let pair = |share: f64| (method(50.0, [1.0, 1e-3], share), method(4.0, [1.0, 9e-3], share));
        let expected = 46.0 / 8e-3;
        let mut widths = Vec::new();
        for share in [0.001, 0.01, 0.05] {
            let (one, other) = pair(share);
            let found = break_even(&one, &other);
            let BreakEven::At { rays, interval: [low, high], .. } = found else { panic!("{found:?}") };
            assert!(near(rays, expected) && low < expected && expected < high);
            widths.push(high / low);
        }
        assert!(widths[0] < widths[1] && widths[1] < widths[2]);
        let (one, other) = pair(0.6);
        assert!(matches!(break_even(&one, &other), BreakEven::Undecided(_)));
        assert!(matches!(break_even(&one, &one), BreakEven::Undecided(_)));
        let (one, other) = pair(0.001);
        let doubted = FrameCost { caveat: Some("drift".to_owned()), ..other };
        for found in [break_even(&one, &doubted), break_even(&doubted, &one)] {
            assert_eq!(found, BreakEven::Undecided("drift".to_owned()));
        }
    }

    /// Proves that the cheapest of several change hands in the order of what a ray takes, and that one which is never cheapest is not
    /// there.
    #[test]
    fn stretches_follow_the_lower_envelope() {
        let costs = [
            method(100.0, [1.0, 1e-3], 0.0),
            method(10.0, [1.0, 4e-3], 0.0),
            method(99.0, [1.0, 4.1e-3], 0.0),
            method(1.0, [0.1, 2e-2], 0.0),
        ];
        let found = stretches(&costs);
        assert_eq!(found.iter().map(|stretch| stretch.who).collect::<Vec<_>>(), [3, 1, 0]);
        assert!(found[0].overtakes.is_none());
        assert!(near(found[1].from, 9.9 / 16e-3) && near(found[2].from, 90.0 / 3e-3), "{found:?}");
        assert!(stretches(&[]).is_empty());
    }
}
