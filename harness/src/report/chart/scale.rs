//! What stands along the axes of panels, where values are on it, and its ticks with their labels.

use itertools::Itertools as _;

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
/// The least span of logarithms.
const LEAST_SPAN: f64 = 1e-9;

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
#[derive(Clone, Copy, Debug)]
pub(super) struct Along<'a> {
    scale: &'a Scale,
    /// Where it begins and ends.
    ends: [f64; 2],
}

impl<'a> Along<'a> {
    /// A scale from one place on the canvas to another.
    pub(super) fn new(scale: &'a Scale, from: f64, to: f64) -> Self {
        Self { scale, ends: [from, to] }
    }

    /// A length from the beginning on.
    fn inwards(&self, length: f64) -> f64 {
        if self.ends[1] < self.ends[0] { -length } else { length }
    }

    /// Where a value above zero is by its logarithm, beside the place for zero.
    fn log_at(&self, (low, high): (f64, f64), value: f64) -> f64 {
        let (from, to) = (self.ends[0] + self.inwards(self.scale.zero_room()), self.ends[1]);
        let part = if value > 0.0 { (value.log10() - low) / (high.max(low + LEAST_SPAN) - low) } else { 0.0 };
        from + (to - from) * part.clamp(0.0, 1.0)
    }

    /// Where a value is; values off the axis are at its ends.
    pub(super) fn at(&self, value: f64) -> f64 {
        let [from, to] = self.ends;
        let linear = |[from, to]: [f64; 2], [least, most]: [f64; 2]| {
            from + (to - from) * ((value - least) / (most - least)).clamp(0.0, 1.0)
        };
        match self.scale {
            Scale::LogAndZero(..) | Scale::Shares(..) if value.is_nan() || value <= 0.0 => {
                from + self.inwards(self.scale.zero_room()) / 2.0
            }
            Scale::Log(range, _) | Scale::LogAndZero(range, _) | Scale::Shares(range, _) => self.log_at(*range, value),
            Scale::Whole => linear([from + self.inwards(AIR), to - self.inwards(AIR)], [0.0, 1.0]),
            Scale::Span(values) => linear([from, to], *values),
            Scale::Steps(steps, _) => from + (to - from) * ((value + 0.5) / steps.len().max(1) as f64),
        }
    }

    /// Whether a value is not beyond the ends.
    pub(super) fn holds(&self, value: f64) -> bool {
        match self.scale {
            Scale::Whole => (0.0..=1.0).contains(&value),
            Scale::Span([least, most]) => (*least..=*most).contains(&value),
            _ => true,
        }
    }

    /// The lower end of an interval: of a value above zero one below the axis ends at it, not at the place of zero.
    pub(super) fn low_end(&self, value: f64, low: f64) -> f64 {
        match self.scale {
            Scale::LogAndZero(range, _) | Scale::Shares(range, _) if value > 0.0 => self.log_at(*range, low),
            Scale::LogAndZero(..) | Scale::Shares(..) => self.at(0.0),
            _ => self.at(low),
        }
    }

    /// The room of a step, where there are any.
    pub(super) fn step(&self) -> Option<f64> {
        let Scale::Steps(steps, _) = self.scale else { return None };
        Some((self.ends[1] - self.ends[0]) / steps.len().max(1) as f64)
    }

    /// How far aside something stands; where there are no steps, nothing does.
    pub(super) fn aside(&self, Aside(place, of): Aside) -> f64 {
        let gap = self.step().filter(|_| of > 0).map_or(0.0, |step| ASIDE.min(0.8 * step / of as f64));
        gap * (place as f64 - (of as f64 - 1.0) / 2.0)
    }

    /// Ticks: places with their labels, each as long along the axis as is said. Logarithms have as many as do not touch.
    pub(super) fn ticks(&self, length: impl Fn(&str) -> f64) -> Vec<(f64, Option<String>)> {
        match self.scale {
            Scale::Log(range, most) | Scale::LogAndZero(range, most) => {
                let of = |most: usize| -> Vec<(f64, Option<String>)> {
                    let ticks = log_ticks(*range, most);
                    let texts = labels(&ticks);
                    ticks.iter().map(|(value, _)| self.log_at(*range, *value)).zip(texts).collect()
                };
                let fewer = (1..=*most).rev().map(of).find(|ticks| are_apart(ticks, &length));
                fewer.unwrap_or_else(|| of(*most))
            }
            Scale::Shares(range, _) => {
                let ticks = log_ticks(*range, 9).into_iter().filter(|(share, _)| *share <= 1.0 + 1e-9);
                let labelled = |(share, has_label): Tick| has_label.then(|| percent_label(share));
                ticks.map(|tick| (self.log_at(*range, tick.0), labelled(tick))).collect()
            }
            Scale::Steps(steps, _) => {
                steps.iter().enumerate().map(|(step, label)| (self.at(step as f64), Some(label.clone()))).collect()
            }
            Scale::Span([least, most]) => {
                let step = round_step(most - least, SPAN_TICKS);
                let multiples = (least / step - 1e-9).ceil() as i64..=(most / step + 1e-9).floor() as i64;
                let values = multiples.map(|index| index as f64 * step);
                values.map(|value| (self.at(value), Some(step_label(value, step)))).collect()
            }
            Scale::Whole => {
                let percent = (0..=100).step_by(20);
                percent.map(|percent| (self.at(f64::from(percent) / 100.0), Some(format!("{percent} %")))).collect()
            }
        }
    }
}

/// A tick: its value, and whether it gets a label.
type Tick = (f64, bool);

/// Decimal logarithms that enclose all positive, finite values with some air, at least a decade apart; a decade around
/// 1 if there are none.
pub(super) fn log_range(values: impl IntoIterator<Item = f64>) -> (f64, f64) {
    let logarithms = values.into_iter().filter(|value| value.is_finite() && *value > 0.0).map(f64::log10);
    let Some((low, high)) = logarithms.minmax_by(f64::total_cmp).into_option() else { return (-0.5, 0.5) };
    let air = 0.06 * (high - low) + 0.1;
    let missing = (1.0 - (high - low + 2.0 * air)).max(0.0);
    (low - air - missing / 2.0, high + air + missing / 2.0)
}

/// Ticks at powers of ten and between them; over many decades only every second or third is labelled, over few
/// also 2 and 5.
fn log_ticks((low, high): (f64, f64), max_labels: usize) -> Vec<Tick> {
    let high = high.max(low + LEAST_SPAN);
    let decades = high - low;
    let step = (decades / max_labels.max(1) as f64).ceil().max(1.0) as i64;
    let between = decades * 3.0 <= max_labels as f64;
    let mut ticks = Vec::new();
    for (decade, digit) in (low.floor() as i64..=high.ceil() as i64).cartesian_product(1..10) {
        let value = f64::from(digit) * 10_f64.powi(decade as i32);
        let labelled = match digit {
            1 => decade.rem_euclid(step) == 0,
            2 | 5 => between,
            _ => false,
        };
        if (low - 1e-9..=high + 1e-9).contains(&value.log10()) && (digit == 1 || decades <= 6.0) {
            ticks.push((value, labelled));
        }
    }
    ticks
}

/// Labels of the ticks that get one: all plain where that is short, else all powers of ten with raised exponents.
fn labels(ticks: &[Tick]) -> Vec<Option<String>> {
    let powers = ticks.iter().any(|(value, labelled)| *labelled && !(0.0009..200_000.0).contains(value));
    let label = |value: f64| if powers { power_of_ten(value) } else { significant(value, 1) };
    ticks.iter().map(|(value, labelled)| labelled.then(|| label(*value))).collect()
}

fn power_of_ten(value: f64) -> String {
    let exponent = (value.log10() + 1e-9).floor();
    // What is no digit is a minus.
    let raised = |c: char| c.to_digit(10).and_then(|digit| "⁰¹²³⁴⁵⁶⁷⁸⁹".chars().nth(digit as usize)).unwrap_or('⁻');
    let exponent_text: String = (exponent as i64).to_string().chars().map(raised).collect();
    match (value / 10_f64.powf(exponent)).round() as i64 {
        1 => format!("10{exponent_text}"),
        digit => format!("{digit}·10{exponent_text}"),
    }
}

/// A share's tick in percent.
fn percent_label(share: f64) -> String {
    let percent = share * 100.0;
    let decimals = (-percent.log10().floor()).clamp(0.0, 12.0) as usize;
    format!("{percent:.decimals$} %")
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

    /// No values, equal values, zeros and NaN still give a range that can be drawn.
    #[test]
    fn ranges_are_never_empty() {
        for values in [vec![], vec![0.0, f64::NAN, -1.0], vec![3.0, 3.0], vec![1e-5, 1e5]] {
            let (low, high) = log_range(values);
            assert!(low.is_finite() && high - low >= 1.0 - 1e-9);
            assert!(log_ticks((low, high), 6).iter().any(|(_, labelled)| *labelled));
            let scale = Scale::Log((low, high), 6);
            assert!((0.0..=300.0).contains(&Along::new(&scale, 0.0, 300.0).at(0.0)));
        }
    }

    /// Labels are short at every size.
    #[test]
    fn labels_are_short() {
        let of = |values: &[f64]| {
            let ticks: Vec<_> = values.iter().map(|value| (*value, true)).collect();
            labels(&ticks).into_iter().flatten().collect::<Vec<_>>()
        };
        assert_eq!(of(&[0.01, 1.0, 200.0]), ["0.01", "1", "200"]);
        assert_eq!(of(&[1e-6, 1.0, 1e14]), ["10⁻⁶", "10⁰", "10¹⁴"]);
        assert_eq!(of(&[1e-6, 2e-6]), ["10⁻⁶", "2·10⁻⁶"]);
        assert_eq!(percent_label(1.0), "100 %");
        assert_eq!(percent_label(1e-5), "0.001 %");
    }

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
            let ticks = Along::new(&scale, 0.0, room).ticks(|text| letter * text.len() as f64);
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
            let scale = Scale::LogAndZero((-3.0, 0.0), 5);
            let along = Along::new(&scale, from, to);
            let (zero, least, most) = (along.at(0.0), along.at(1e-9), along.at(9.0));
            assert_eq!((zero - from).abs(), ZERO_COLUMN / 2.0);
            assert_eq!(((least - from).abs(), most), (ZERO_COLUMN, to));
            assert_eq!((along.low_end(0.1, 0.0), along.low_end(0.0, 0.0)), (least, zero));
        }
        let (span, steps) = (Scale::Span([60.0, 110.0]), Scale::Steps(vec![String::new(); 4], None));
        let span = Along::new(&span, 0.0, 100.0);
        assert_eq!([0.0, 60.0, 85.0, 120.0].map(|value| span.at(value)), [0.0, 0.0, 50.0, 100.0]);
        assert_eq!([59.0, 60.0, 110.0, 111.0].map(|value| span.holds(value)), [false, true, true, false]);
        // Only steps have room aside.
        let steps = Along::new(&steps, 0.0, 40.0);
        assert_eq!([0, 1].map(|place| steps.aside(Aside(place, 2))), [-2.0, 2.0]);
        assert_eq!(span.aside(Aside(1, 2)), 0.0);
    }
}
