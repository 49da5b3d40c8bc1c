//! Numbers with how sure they are, from which verdicts are told.
//!
//! What is counted is exact. What is timed lies in an interval, and there may be doubts of which an interval says nothing. What is
//! made of several estimates takes every one of them at either end of its interval, so that it covers at least as often as they
//! do together.

use std::collections::BTreeSet;
use std::ops::{Add, Div, Mul, Sub};

/// A number with how sure it is.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Estimate {
    /// The number.
    pub value: f64,
    /// Where it lies; of what is counted the number itself, twice.
    pub interval: [f64; 2],
    /// Whether a time is in it, or the share of a sample: what lies in an interval.
    pub timed: bool,
    /// Whether the interval holds methods at equal launch settings and each at its best.
    pub at_launch_settings: bool,
    /// What keeps anything from being said by it.
    pub doubts: BTreeSet<String>,
    /// What stands beside it, in words.
    pub note: Option<String>,
}

impl From<f64> for Estimate {
    fn from(value: f64) -> Self {
        Self { value, interval: [value; 2], ..Self::default() }
    }
}

impl Estimate {
    /// Of a time.
    pub(super) fn timed(value: f64, interval: [f64; 2], doubts: impl IntoIterator<Item = String>) -> Self {
        Self { timed: true, interval, doubts: doubts.into_iter().collect(), ..Self::from(value) }
    }

    /// Something that rises with it.
    pub(super) fn rising(self, of: impl Fn(f64) -> f64) -> Self {
        Self { value: of(self.value), interval: self.interval.map(of), ..self }
    }

    /// The same with what is found at other launch settings: it lies wherever any of these does.
    pub(super) fn spread_over(self, others: impl IntoIterator<Item = Self>) -> Self {
        others.into_iter().fold(Self { at_launch_settings: true, ..self }, |all, other| Self {
            interval: [all.interval[0].min(other.interval[0]), all.interval[1].max(other.interval[1])],
            doubts: all.doubts.into_iter().chain(other.doubts).collect(),
            ..all
        })
    }

    /// The same with a doubt.
    pub(super) fn doubted(mut self, caveat: String) -> Self {
        self.doubts.insert(caveat);
        self
    }

    /// Something made of the values of two, each taken at both ends.
    fn with(self, other: Self, of: impl Fn(f64, f64) -> f64) -> Self {
        let ends = self.interval.iter().flat_map(|own| other.interval.iter().map(|other| of(*own, *other)));
        let (low, high) =
            ends.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), end| (low.min(end), high.max(end)));
        Self {
            value: of(self.value, other.value),
            interval: [low, high],
            timed: self.timed || other.timed,
            at_launch_settings: self.at_launch_settings || other.at_launch_settings,
            doubts: self.doubts.into_iter().chain(other.doubts).collect(),
            note: None,
        }
    }

    fn reduce(all: impl IntoIterator<Item = Self>, of: fn(f64, f64) -> f64) -> Option<Self> {
        all.into_iter().reduce(|one, other| one.with(other, of))
    }

    /// The largest, none of none.
    pub(super) fn greatest(all: impl IntoIterator<Item = Self>) -> Option<Self> {
        Self::reduce(all, f64::max)
    }

    /// The least, none of none.
    pub(super) fn least(all: impl IntoIterator<Item = Self>) -> Option<Self> {
        Self::reduce(all, f64::min)
    }

    /// The mean, none of none.
    pub(super) fn mean(all: impl IntoIterator<Item = Self>) -> Option<Self> {
        let all: Vec<Self> = all.into_iter().collect();
        let count = all.len() as f64;
        Self::reduce(all, |one, other| one + other).map(|sum| sum / count)
    }
}

/// As numbers add up, for ends that lie in the same order.
macro_rules! operator {
    ($trait:ident, $function:ident, $sign:tt) => {
        impl<T: Into<Estimate>> $trait<T> for Estimate {
            type Output = Self;

            fn $function(self, other: T) -> Self {
                self.with(other.into(), |one, other| one $sign other)
            }
        }
    };
}

operator!(Add, add, +);
operator!(Sub, sub, -);
operator!(Mul, mul, *);

impl<T: Into<Self>> Div<T> for Estimate {
    type Output = Self;

    /// Unbounded where the divisor may be nothing.
    fn div(self, other: T) -> Self {
        let other = other.into();
        let open = other.interval[0] <= 0.0 && other.interval[1] >= 0.0;
        let found = self.with(other, |one, other| one / other);
        if open { Self { interval: [f64::NEG_INFINITY, f64::INFINITY], ..found } } else { found }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(found: &Estimate, value: f64, interval: [f64; 2]) {
        let close = |a: f64, b: f64| (a - b).abs() < 1e-12;
        let all = close(found.value, value) && (0..2).all(|end| close(found.interval[end], interval[end]));
        assert!(all, "{found:?}, not {value} {interval:?}");
    }

    /// What is made of estimates lies where its parts can lie, whatever the signs; doubts are kept, each once.
    #[test]
    fn intervals_are_carried_through() {
        let [drift, few] = ["drift", "few rounds"].map(str::to_owned);
        let one = Estimate::timed(2.0, [1.0, 4.0], [drift.clone()]);
        let other = Estimate::timed(10.0, [8.0, 20.0], [drift.clone(), few.clone()]);
        near(&(one.clone() + other.clone()), 12.0, [9.0, 24.0]);
        near(&(one.clone() - other.clone()), -8.0, [-19.0, -4.0]);
        near(&(other.clone() / one.clone()), 5.0, [2.0, 20.0]);
        near(&((one.clone() - 3.0) * other.clone()), -10.0, [-40.0, 20.0]);
        near(&(Estimate::from(100.0) - one.clone() * 100.0), -100.0, [-300.0, 0.0]);
        near(&((one.clone() - 1.0) * 100.0), 100.0, [0.0, 300.0]);
        let both = [one.clone(), Estimate::timed(3.0, [2.0, 3.5], [])];
        near(&Estimate::greatest(both.clone()).unwrap(), 3.0, [2.0, 4.0]);
        near(&Estimate::least(both.clone()).unwrap(), 2.0, [1.0, 3.5]);
        near(&Estimate::mean(both).unwrap(), 2.5, [1.5, 3.75]);
        let all = one + other;
        assert!(all.timed && all.doubts.into_iter().eq([drift, few]));
        assert!(!(Estimate::from(1.0) / 2.0).timed && Estimate::mean([]).is_none());
    }
}
