//! What stands along the axes of panels, where values are on it, and its ticks.

use super::axis::{LogAxis, labels, percent_label};
use crate::report::format::significant;

/// Height of the row for zero at the foot of a panel of shares; a logarithm never gets there.
pub(super) const ZERO_ROW: f64 = 26.0;
/// Width of the column for zero beside a logarithmic axis.
const ZERO_COLUMN: f64 = 32.0;
/// Above all and below none of a linear share, where lines often run.
const AIR: f64 = 10.0;
/// The most decades of shares shown: beyond it shares hang on single rays of impossible sets.
const DEEPEST: f64 = -9.0;
/// Marks that would coincide stand this far apart where there is room.
const ASIDE: f64 = 13.0;
/// Between labels of neighbouring ticks.
const LABEL_GAP: f64 = 4.0;
/// The most ticks of a span.
const SPAN_TICKS: f64 = 6.0;

/// What stands along an axis.
#[derive(Clone, Debug)]
pub(super) enum Scale {
    /// Decimal logarithms between two, with so many labels at most.
    Log((f64, f64), usize),
    /// The same beside a place for zero.
    LogAndZero((f64, f64), usize),
    /// Shares between two decimal logarithms, over a row of a height for zero.
    Shares((f64, f64), f64),
    /// Shares from none to all.
    Whole,
    /// Values from one to another.
    Span([f64; 2]),
    /// Steps at equal distances, whatever their values; places count them. One may be shaded.
    Steps(Vec<String>, Option<usize>),
}

impl Scale {
    /// Shares down to the least of some, at most to one in ten.
    pub(super) fn down_to(shares: impl Iterator<Item = f64>) -> Self {
        let least = shares.filter(|share| *share > 0.0).fold(0.1, f64::min);
        // A little above 100 %, so that markers there are whole.
        Self::Shares((least.log10().floor().max(DEEPEST), 0.3), ZERO_ROW)
    }

    /// The room for zero at its beginning.
    pub(super) fn zero_room(&self) -> f64 {
        match self {
            Self::Shares(_, row) => *row,
            Self::LogAndZero(..) => ZERO_COLUMN,
            _ => 0.0,
        }
    }
}

/// How far something stands aside of its step: its place among so many.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Aside(pub usize, pub usize);

/// A scale on the canvas.
#[derive(Debug)]
pub(super) enum Along {
    Log(LogAxis),
    /// With the place of zero.
    LogAndZero(LogAxis, f64),
    /// Between two ends, from one value to another.
    Linear([f64; 2], [f64; 2]),
    /// Between two ends, so many.
    Steps([f64; 2], usize),
}

impl Along {
    /// A scale from one place on the canvas to another.
    pub(super) fn new(scale: &Scale, from: f64, to: f64) -> Self {
        let inwards = |length: f64| if to < from { -length } else { length };
        match scale {
            Scale::Log(range, _) => Self::Log(LogAxis::new(*range, from, to)),
            Scale::LogAndZero(range, _) | Scale::Shares(range, _) => {
                let room = inwards(scale.zero_room());
                Self::LogAndZero(LogAxis::new(*range, from + room, to), from + room / 2.0)
            }
            Scale::Whole => Self::Linear([from + inwards(AIR), to - inwards(AIR)], [0.0, 1.0]),
            Scale::Span(values) => Self::Linear([from, to], *values),
            Scale::Steps(steps, _) => Self::Steps([from, to], steps.len().max(1)),
        }
    }

    /// Where a value is; values off the axis are at its ends.
    pub(super) fn at(&self, value: f64) -> f64 {
        match self {
            Self::Log(axis) => axis.at(value),
            Self::LogAndZero(axis, _) if value > 0.0 => axis.at(value),
            Self::LogAndZero(_, zero) => *zero,
            Self::Linear([from, to], [least, most]) => {
                from + (to - from) * ((value - least) / (most - least)).clamp(0.0, 1.0)
            }
            Self::Steps([from, to], count) => from + (to - from) * ((value + 0.5) / *count as f64),
        }
    }

    /// Whether a value is not beyond the ends.
    pub(super) fn holds(&self, value: f64) -> bool {
        if let Self::Linear(_, [least, most]) = self { (*least..=*most).contains(&value) } else { true }
    }

    /// The lower end of an interval: of a value above zero one below the axis ends at it, not at the place of zero.
    pub(super) fn low_end(&self, value: f64, low: f64) -> f64 {
        match self {
            Self::LogAndZero(axis, _) if value > 0.0 => axis.at(low),
            Self::LogAndZero(_, zero) => *zero,
            _ => self.at(low),
        }
    }

    /// The room of a step, where there are any.
    pub(super) fn step(&self) -> Option<f64> {
        if let Self::Steps([from, to], count) = self { Some((to - from) / *count as f64) } else { None }
    }

    /// How far aside something stands; where there are no steps, nothing does.
    pub(super) fn aside(&self, Aside(place, of): Aside) -> f64 {
        let gap = self.step().filter(|_| of > 0).map_or(0.0, |step| ASIDE.min(0.8 * step / of as f64));
        gap * (place as f64 - (of as f64 - 1.0) / 2.0)
    }

    /// Ticks: places with their labels, each as long along the axis as is said. Logarithms have as many as do not touch.
    pub(super) fn ticks(&self, scale: &Scale, length: impl Fn(&str) -> f64) -> Vec<(f64, Option<String>)> {
        match (scale, self) {
            (Scale::Log(_, most) | Scale::LogAndZero(_, most), Self::Log(axis) | Self::LogAndZero(axis, _)) => {
                let of = |most: usize| -> Vec<(f64, Option<String>)> {
                    let ticks = axis.ticks(most);
                    let texts = labels(&ticks);
                    ticks.iter().map(|tick| axis.at(tick.value)).zip(texts).collect()
                };
                let fewer = (1..=*most).rev().map(of).find(|ticks| are_apart(ticks, &length));
                fewer.unwrap_or_else(|| of(*most))
            }
            (_, Self::LogAndZero(axis, _)) => {
                let ticks = axis.ticks(9).into_iter().filter(|tick| tick.value <= 1.0 + 1e-9);
                ticks.map(|tick| (axis.at(tick.value), tick.labelled.then(|| percent_label(tick.value)))).collect()
            }
            (Scale::Steps(steps, _), _) => {
                steps.iter().enumerate().map(|(step, label)| (self.at(step as f64), Some(label.clone()))).collect()
            }
            (Scale::Span([least, most]), _) => {
                let step = round_step(most - least, SPAN_TICKS);
                let multiples = (least / step - 1e-9).ceil() as i64..=(most / step + 1e-9).floor() as i64;
                let values = multiples.map(|index| index as f64 * step);
                values.map(|value| (self.at(value), Some(step_label(value, step)))).collect()
            }
            _ => {
                let percent = (0..=100).step_by(20);
                percent.map(|percent| (self.at(f64::from(percent) / 100.0), Some(format!("{percent} %")))).collect()
            }
        }
    }
}

/// Whether there are labels, each so long, and gaps between them.
fn are_apart(ticks: &[(f64, Option<String>)], length: impl Fn(&str) -> f64) -> bool {
    let labelled: Vec<(f64, f64)> =
        ticks.iter().filter_map(|(place, text)| Some((*place, length(text.as_ref()?) / 2.0))).collect();
    !labelled.is_empty()
        && labelled.windows(2).all(|pair| (pair[1].0 - pair[0].0).abs() >= pair[0].1 + pair[1].1 + LABEL_GAP)
}

/// A step of 1, 2 or 5 times a power of ten of which no more than so many fit.
fn round_step(most: f64, steps: f64) -> f64 {
    let least = most / steps;
    let power = 10.0_f64.powf(least.log10().floor());
    let digit = [1.0, 2.0, 5.0].into_iter().find(|digit| digit * power >= least * (1.0 - 1e-9)).unwrap_or(10.0);
    digit * power
}

/// A multiple of a step with as many decimals as the step has.
fn step_label(value: f64, step: f64) -> String {
    let decimals = (-step.log10().floor()).max(0.0);
    match value {
        0.0 => "0".to_owned(),
        _ if decimals > 4.0 || value >= 1e6 => significant(value, 2),
        _ => format!("{value:.0$}", decimals as usize),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ticks are round, few, and distinguished by their labels.
    #[test]
    fn linear_ticks_are_round() {
        for most in [1e-5, 0.03, 0.9, 1.0, 7.3, 99.0, 1234.0, 5e7] {
            let step = round_step(most, SPAN_TICKS);
            let count = (most / step).floor();
            assert!((2.0..=6.0).contains(&count), "{most}: {count}");
            let labels: Vec<_> = (0..=count as u32).map(|index| step_label(f64::from(index) * step, step)).collect();
            assert!(labels.windows(2).all(|pair| pair[0] != pair[1]), "{labels:?}");
            assert!(labels.iter().all(|label| label.len() <= 7), "{labels:?}");
        }
        assert_eq!((round_step(60.0, 6.0), step_label(0.30000000000000004, 0.1).as_str()), (10.0, "0.3"));
    }

    /// Labels of logarithms do not touch: there are fewer of them where they are long or the axis is short, and never none.
    #[test]
    fn logarithmic_labels_do_not_touch() {
        let labelled = |range: (f64, f64), room: f64, letter: f64| -> Vec<String> {
            let scale = Scale::Log(range, 8);
            let ticks = Along::new(&scale, 0.0, room).ticks(&scale, |text| letter * text.len() as f64);
            assert!(are_apart(&ticks, |text| letter * text.len() as f64), "{ticks:?}");
            ticks.into_iter().filter_map(|(_, text)| text).collect()
        };
        let range = (3.4, 5.0);
        assert_eq!(labelled(range, 270.0, 0.0), ["5000", "10000", "20000", "50000", "100000"]);
        assert_eq!(labelled(range, 270.0, 10.0), ["10000", "100000"]);
        assert_eq!(labelled((0.0, 2.0), 270.0, 6.0), ["1", "2", "5", "10", "20", "50", "100"]);
        assert_eq!(labelled((0.0, 5.0), 90.0, 6.0), ["1", "100", "10000"]);
    }

    /// Zero stands beside logarithms, upwards as from left to right, and an interval of something above it never gets there;
    /// spans hold what is on them alone.
    #[test]
    fn values_have_places() {
        for (from, to) in [(0.0, 100.0), (200.0, 100.0)] {
            let along = Along::new(&Scale::LogAndZero((-3.0, 0.0), 5), from, to);
            let (zero, least, most) = (along.at(0.0), along.at(1e-9), along.at(9.0));
            assert_eq!((zero - from).abs(), ZERO_COLUMN / 2.0);
            assert_eq!(((least - from).abs(), most), (ZERO_COLUMN, to));
            assert_eq!((along.low_end(0.1, 0.0), along.low_end(0.0, 0.0)), (least, zero));
        }
        let span = Along::new(&Scale::Span([60.0, 110.0]), 0.0, 100.0);
        assert_eq!([0.0, 60.0, 85.0, 120.0].map(|value| span.at(value)), [0.0, 0.0, 50.0, 100.0]);
        assert_eq!([59.0, 60.0, 110.0, 111.0].map(|value| span.holds(value)), [false, true, true, false]);
        // Only steps have room aside.
        let steps = Along::new(&Scale::Steps(vec![String::new(); 4], None), 0.0, 40.0);
        assert_eq!([0, 1].map(|place| steps.aside(Aside(place, 2))), [-2.0, 2.0]);
        assert_eq!(span.aside(Aside(1, 2)), 0.0);
    }
}
