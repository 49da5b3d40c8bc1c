//! Logarithmic axes, and labels that make room for each other.

use crate::report::format::significant;

/// A logarithmic axis from one place on the canvas to another.
#[derive(Clone, Copy, Debug)]
pub(super) struct LogAxis {
    /// Decimal logarithm of the lower end.
    low: f64,
    /// Decimal logarithm of the upper end.
    high: f64,
    /// Where the lower end is.
    from: f64,
    /// Where the upper end is.
    to: f64,
}

/// A tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Tick {
    /// Its value.
    pub value: f64,
    /// Whether it gets a label.
    pub labelled: bool,
}

/// Decimal logarithms that enclose all positive, finite values with some air, at least a decade apart; a decade around
/// 1 if there are none.
pub(super) fn log_range(values: impl IntoIterator<Item = f64>) -> (f64, f64) {
    let logarithms = values.into_iter().filter(|value| value.is_finite() && *value > 0.0).map(f64::log10);
    let (low, high) =
        logarithms.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), each| (low.min(each), high.max(each)));
    if !low.is_finite() {
        return (-0.5, 0.5);
    }
    let air = 0.06 * (high - low) + 0.1;
    let missing = (1.0 - (high - low + 2.0 * air)).max(0.0);
    (low - air - missing / 2.0, high + air + missing / 2.0)
}

impl LogAxis {
    /// An axis over a range of decimal logarithms.
    pub(super) fn new((low, high): (f64, f64), from: f64, to: f64) -> Self {
        Self { low, high: high.max(low + 1e-9), from, to }
    }

    /// Where a value is; values off the axis are at its ends.
    pub(super) fn at(&self, value: f64) -> f64 {
        let part = if value > 0.0 { (value.log10() - self.low) / (self.high - self.low) } else { 0.0 };
        self.from + (self.to - self.from) * part.clamp(0.0, 1.0)
    }

    /// Ticks at powers of ten and between them; over many decades only every second or third is labelled, over few
    /// also 2 and 5.
    pub(super) fn ticks(&self, max_labels: usize) -> Vec<Tick> {
        let decades = self.high - self.low;
        let step = (decades / max_labels.max(1) as f64).ceil().max(1.0) as i64;
        let between = decades * 3.0 <= max_labels as f64;
        let mut ticks = Vec::new();
        for decade in self.low.floor() as i64..=self.high.ceil() as i64 {
            for digit in 1..10 {
                let value = f64::from(digit) * 10_f64.powi(decade as i32);
                if !(self.low - 1e-9..=self.high + 1e-9).contains(&value.log10()) {
                    continue;
                }
                let labelled = match digit {
                    1 => decade.rem_euclid(step) == 0,
                    2 | 5 => between,
                    _ => false,
                };
                if digit == 1 || decades <= 6.0 {
                    ticks.push(Tick { value, labelled });
                }
            }
        }
        ticks
    }
}

/// Labels of the ticks that get one: all plain where that is short, else all powers of ten with raised exponents.
pub(super) fn labels(ticks: &[Tick]) -> Vec<Option<String>> {
    let plain = |tick: &&Tick| (0.0009..200_000.0).contains(&tick.value);
    let powers = ticks.iter().filter(|tick| tick.labelled).any(|tick| !plain(&tick));
    let label = |tick: &Tick| if powers { power_of_ten(tick.value) } else { significant(tick.value, 1) };
    ticks.iter().map(|tick| tick.labelled.then(|| label(tick))).collect()
}

fn power_of_ten(value: f64) -> String {
    let exponent = (value.log10() + 1e-9).floor();
    let raised = |c: char| match c {
        '-' => '⁻',
        '0' => '⁰',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        digit => char::from_u32('⁴' as u32 + (digit as u32).saturating_sub('4' as u32)).unwrap_or(digit),
    };
    let exponent_text: String = (exponent as i64).to_string().chars().map(raised).collect();
    match (value / 10_f64.powf(exponent)).round() as i64 {
        1 => format!("10{exponent_text}"),
        digit => format!("{digit}·10{exponent_text}"),
    }
}

/// A share's tick in percent.
pub(super) fn percent_label(share: f64) -> String {
    let percent = share * 100.0;
    let decimals = (-percent.log10().floor()).clamp(0.0, 12.0) as usize;
    format!("{percent:.decimals$} %")
}

/// Moves places apart until neighbours are a gap apart, keeping their order and staying between two bounds while there
/// is room.
pub(super) fn spread(places: &[f64], gap: f64, low: f64, high: f64) -> Vec<f64> {
    let mut order: Vec<usize> = (0..places.len()).collect();
    order.sort_by(|a, b| places[*a].total_cmp(&places[*b]));
    let mut moved = places.to_vec();
    let mut least = low;
    for &index in &order {
        moved[index] = moved[index].max(least);
        least = moved[index] + gap;
    }
    let mut most = high;
    for &index in order.iter().rev() {
        moved[index] = moved[index].min(most);
        most = moved[index] - gap;
    }
    moved
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
            let axis = LogAxis::new((low, high), 0.0, 300.0);
            assert!(axis.ticks(6).iter().any(|tick| tick.labelled));
            assert!((0.0..=300.0).contains(&axis.at(0.0)));
        }
    }

    /// Labels are short at every size.
    #[test]
    fn labels_are_short() {
        let of = |values: &[f64]| {
            let ticks: Vec<_> = values.iter().map(|value| Tick { value: *value, labelled: true }).collect();
            labels(&ticks).into_iter().flatten().collect::<Vec<_>>()
        };
        assert_eq!(of(&[0.01, 1.0, 200.0]), ["0.01", "1", "200"]);
        assert_eq!(of(&[1e-6, 1.0, 1e14]), ["10⁻⁶", "10⁰", "10¹⁴"]);
        assert_eq!(of(&[1e-6, 2e-6]), ["10⁻⁶", "2·10⁻⁶"]);
        assert_eq!(percent_label(1.0), "100 %");
        assert_eq!(percent_label(1e-5), "0.001 %");
    }

    /// Crowded places end a gap apart, in order, within bounds.
    #[test]
    fn crowded_places_spread() {
        let moved = spread(&[10.0, 10.0, 9.0, 50.0], 5.0, 0.0, 52.0);
        assert_eq!(moved, [14.0, 19.0, 9.0, 50.0]);
        let moved = spread(&[52.0, 51.0], 5.0, 0.0, 52.0);
        assert_eq!(moved, [52.0, 47.0]);
    }
}
