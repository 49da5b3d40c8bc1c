//! Panels of marks over the values of a parameter: what they hold, where it stands, how it is drawn.

use plotters::prelude::DrawingBackend;

use super::axis::{LogAxis, labels, log_range, percent_label};
use super::canvas::{Align, Canvas, DrawError, Drawn, shorten, text_width};
use super::frame::{AXIS_SIZE, Rect, TICK_SIZE};
use super::palette::{CONTROL, GREY, INK, SHADE, Style};
use crate::report::format::significant;
use crate::studies::sweep::Multiple;

/// Height of the row for zero at the foot of a panel of shares; a logarithm never gets there.
const ZERO_ROW: f64 = 24.0;
/// Width of the column for zero beside a logarithmic axis.
const ZERO_COLUMN: f64 = 32.0;
/// The most decades of shares shown.
const DEEPEST: f64 = -9.0;
const FILLED: f64 = 4.0;
const HOLLOW: f64 = 6.0;
/// Between neighbouring values below a panel.
const VALUE_GAP: f64 = 4.0;
/// Half the length of the caps at the ends of bars.
const CAP: f64 = 2.5;

/// A value with its interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Mark {
    /// The value.
    pub value: f64,
    /// Its interval.
    pub interval: [f64; 2],
}

impl Mark {
    /// A value that is known exactly.
    pub(super) fn exact(value: f64) -> Self {
        Self { value, interval: [value; 2] }
    }
}

/// Marks by the place of their value; `None` where nothing was measured.
#[derive(Debug)]
pub(super) struct Series {
    /// Its look.
    pub style: Style,
    /// Dashed with hollow markers.
    pub hollow: bool,
    /// By the place of the value.
    pub marks: Vec<Option<Mark>>,
}

/// What stands along the left axis.
#[derive(Debug)]
pub(super) enum Scale {
    /// From zero up to a value.
    Linear(f64),
    /// From a value up to another.
    Span([f64; 2]),
    /// Over decimal logarithms.
    Log((f64, f64)),
    /// Shares, with a row for zero; the decimal logarithm of the least that is not.
    Share(f64),
}

/// The scale of shares of so many rays: down to the least that there is, at most to a single ray.
pub(super) fn share_scale(rays: u64, shares: impl Iterator<Item = f64>) -> Scale {
    let one_ray = 1.0 / rays.max(1) as f64;
    let least = shares.chain([one_ray]).filter(|share| *share > 0.0).fold(0.1, f64::min);
    Scale::Share(least.log10().floor().max(DEEPEST))
}

/// A panel.
#[derive(Debug)]
pub(super) struct Panel {
    /// Its title.
    pub title: String,
    /// The left axis's name with the unit.
    pub y_name: String,
    /// The left axis.
    pub scale: Scale,
    /// What is shown.
    pub series: Vec<Series>,
    /// Controls' names and values.
    pub controls: Vec<(String, f64)>,
}

/// The values along the lower axis.
#[derive(Debug)]
pub(super) struct Values {
    name: String,
    labels: Vec<String>,
    /// Values at which nothing was measured.
    skipped: Vec<bool>,
    spacing: Spacing,
}

#[derive(Debug)]
enum Spacing {
    /// At equal distances, whatever they are. Whether there is anything between one and the next, so that a line may lead
    /// there: not between names.
    Even { connected: bool },
    /// By their logarithms, with a place for zero.
    Log(Vec<f64>),
}

impl Values {
    /// At equal distances.
    pub(super) fn even(name: String, values: &[String], labels: Vec<String>, skipped: Vec<bool>) -> Self {
        let is_number = |value: &String| value.parse::<f64>().is_ok() || Multiple::parse(value).is_some();
        let spacing = Spacing::Even { connected: values.iter().all(is_number) };
        Self { name, labels, skipped, spacing }
    }

    /// By their logarithms if they are numbers from zero up, two of them above it; else at equal distances.
    pub(super) fn logarithmic(name: String, values: &[String], labels: Vec<String>, skipped: Vec<bool>) -> Self {
        let number = |value: &String| value.parse::<f64>().ok().filter(|number| number.is_finite() && *number >= 0.0);
        let numbers: Option<Vec<f64>> = values.iter().map(number).collect();
        match numbers.filter(|numbers| numbers.iter().filter(|number| **number > 0.0).count() > 1) {
            Some(numbers) => Self { name, labels, skipped, spacing: Spacing::Log(numbers) },
            None => Self::even(name, values, labels, skipped),
        }
    }
}

/// The places of one panel.
#[derive(Debug)]
pub(super) struct Places {
    /// The rectangle of its data.
    pub rect: Rect,
    x: Vec<f64>,
    along: Along,
    up: Up,
}

#[derive(Debug)]
enum Along {
    Even { column: f64, connected: bool },
    Log { axis: LogAxis, zero: Option<f64> },
}

#[derive(Debug)]
enum Up {
    Linear { least: f64, most: f64 },
    Log(LogAxis),
    Share { axis: LogAxis, zero: f64 },
}

impl Places {
    /// The places of a panel's values in its rectangle.
    pub(super) fn new(rect: Rect, values: &Values, scale: &Scale) -> Self {
        let up = match scale {
            Scale::Linear(most) => Up::Linear { least: 0.0, most: *most },
            Scale::Span([least, most]) => Up::Linear { least: *least, most: *most },
            Scale::Log(range) => Up::Log(LogAxis::new(*range, rect.bottom, rect.top)),
            // A little above 100 %, so that markers there are whole.
            Scale::Share(floor) => Up::Share {
                axis: LogAxis::new((*floor, 0.3), rect.bottom - ZERO_ROW, rect.top),
                zero: rect.bottom - ZERO_ROW / 2.0,
            },
        };
        let (x, along) = match &values.spacing {
            Spacing::Even { connected } => {
                let column = (rect.right - rect.left) / values.labels.len().max(1) as f64;
                let x = (0..values.labels.len()).map(|index| rect.left + (index as f64 + 0.5) * column).collect();
                (x, Along::Even { column, connected: *connected })
            }
            Spacing::Log(numbers) => {
                let zero = numbers.contains(&0.0).then_some(rect.left + ZERO_COLUMN / 2.0);
                let left = rect.left + if zero.is_some() { ZERO_COLUMN } else { 0.0 };
                let axis = LogAxis::new(log_range(numbers.iter().copied()), left, rect.right);
                let at = |number: &f64| zero.filter(|_| *number == 0.0).unwrap_or_else(|| axis.at(*number));
                (numbers.iter().map(at).collect(), Along::Log { axis, zero })
            }
        };
        Self { rect, x, along, up }
    }

    /// The room that each value has; by logarithms it has none of its own.
    pub(super) fn column(&self) -> f64 {
        match self.along {
            Along::Even { column, .. } => column,
            Along::Log { .. } => 0.0,
        }
    }

    /// Where a value is, by its place in the order.
    pub(super) fn x(&self, index: usize) -> f64 {
        self.x.get(index).copied().unwrap_or(self.rect.left)
    }

    /// Whether there is anything between a value and the next.
    fn leads_on(&self, index: usize) -> bool {
        match self.along {
            Along::Even { connected, .. } => connected,
            Along::Log { zero, .. } => zero != self.x.get(index).copied(),
        }
    }

    /// The height of a value.
    pub(super) fn y(&self, value: f64) -> f64 {
        match &self.up {
            Up::Linear { least, most } => {
                let part = ((value - least) / (most - least)).clamp(0.0, 1.0);
                self.rect.bottom + (self.rect.top - self.rect.bottom) * part
            }
            Up::Log(axis) => axis.at(value),
            Up::Share { axis, zero } => {
                if value > 0.0 {
                    axis.at(value)
                } else {
                    *zero
                }
            }
        }
    }

    /// Whether a value is on the axis.
    fn holds(&self, value: f64) -> bool {
        match &self.up {
            Up::Linear { least, most } => (*least..=*most).contains(&value),
            _ => true,
        }
    }
    /// The place of an interval's lower end: one below the axis ends at it, not in the row for zero.
    fn low_end(&self, mark: &Mark) -> f64 {
        match &self.up {
            Up::Share { axis, .. } if mark.value > 0.0 => axis.at(mark.interval[0]),
            _ => self.y(mark.interval[0]),
        }
    }
}

/// Draws a panel over what is there already.
pub(super) fn draw_panel<DB: DrawingBackend>(
    canvas: &Canvas<DB>,
    panel: &Panel,
    values: &Values,
    places: &Places,
) -> Drawn {
    let rect = places.rect;
    draw_ticks(canvas, places)?;
    // Below a second line of values.
    let drop = if draw_values(canvas, values, places)? { 42.0 } else { 35.0 };
    rect.title(canvas, &panel.title)?;
    let middle = (rect.left + rect.right) / 2.0;
    let name = shorten(&values.name, AXIS_SIZE, rect.right - rect.left);
    canvas.text(&name, (middle, rect.bottom + drop), Align::Middle, AXIS_SIZE, INK)?;
    canvas.text_upwards(&panel.y_name, (rect.left - 57.0, (rect.top + rect.bottom) / 2.0), AXIS_SIZE, INK)?;
    let controls: Vec<_> = panel.controls.iter().map(|(name, value)| (name.clone(), places.y(*value))).collect();
    // One beyond the axis has its name at the edge, and no line.
    for ((_, y), (_, value)) in controls.iter().zip(&panel.controls) {
        if places.holds(*value) {
            canvas.dashed((rect.left, *y), (rect.right, *y), CONTROL, 1.0)?;
        }
    }
    rect.names_right(canvas, &controls)?;
    rect.edge(canvas)?;
    draw_series(canvas, panel, places)
}

/// The values below, and what was skipped; whether names take two lines.
fn draw_values<DB: DrawingBackend>(canvas: &Canvas<DB>, values: &Values, places: &Places) -> Result<bool, DrawError> {
    let rect = places.rect;
    let two_lines = match &places.along {
        Along::Even { column, .. } => draw_names(canvas, &values.labels, places, *column)?,
        Along::Log { axis, zero } => {
            if let Some(zero) = zero {
                canvas.fill((rect.left, rect.top), (rect.left + ZERO_COLUMN, rect.bottom), SHADE)?;
                rect.tick_below(canvas, *zero, Some("0"))?;
            }
            let ticks = axis.ticks(5);
            for (tick, text) in ticks.iter().zip(labels(&ticks)) {
                rect.tick_below(canvas, axis.at(tick.value), text.as_deref())?;
            }
            false
        }
    };
    for (index, _) in values.skipped.iter().enumerate().filter(|(_, skipped)| **skipped) {
        let middle = (places.x(index), (rect.top + rect.bottom) / 2.0);
        canvas.text_upwards("skipped", middle, TICK_SIZE, GREY)?;
    }
    Ok(two_lines)
}

/// Names at equal distances, on two lines where one is too narrow, and whether they are.
fn draw_names<DB: DrawingBackend>(
    canvas: &Canvas<DB>,
    names: &[String],
    places: &Places,
    column: f64,
) -> Result<bool, DrawError> {
    let bottom = places.rect.bottom;
    let two_lines = names.iter().any(|name| text_width(name, TICK_SIZE) > column - VALUE_GAP);
    for (index, name) in names.iter().enumerate() {
        let x = places.x(index);
        places.rect.tick_below(canvas, x, None)?;
        let room = if two_lines { 2.0 } else { 1.0 } * column - VALUE_GAP;
        let drop = if two_lines && index % 2 == 1 { 24.5 } else { 14.0 };
        canvas.text(&shorten(name, TICK_SIZE, room), (x, bottom + drop), Align::Middle, TICK_SIZE, GREY)?;
    }
    Ok(two_lines)
}

fn draw_ticks<DB: DrawingBackend>(canvas: &Canvas<DB>, places: &Places) -> Drawn {
    let rect = places.rect;
    match &places.up {
        Up::Linear { least, most } => {
            let step = round_step(most - least, 6.0);
            let steps = (least / step - 1e-9).ceil() as i64..=(most / step + 1e-9).floor() as i64;
            for index in steps {
                let value = index as f64 * step;
                let text = if index == 0 { "0".to_owned() } else { step_label(value, step) };
                rect.tick_left(canvas, places.y(value), Some(&text))?;
            }
            Ok(())
        }
        Up::Log(axis) => {
            let ticks = axis.ticks(6);
            for (tick, text) in ticks.iter().zip(labels(&ticks)) {
                rect.tick_left(canvas, axis.at(tick.value), text.as_deref())?;
            }
            Ok(())
        }
        Up::Share { axis, zero } => {
            for tick in axis.ticks(6).into_iter().filter(|tick| tick.value <= 1.0 + 1e-9) {
                let text = tick.labelled.then(|| percent_label(tick.value));
                rect.tick_left(canvas, axis.at(tick.value), text.as_deref())?;
            }
            // The floor: below it there is nothing but zero.
            canvas.path(&[(rect.left, rect.bottom - ZERO_ROW), (rect.right, rect.bottom - ZERO_ROW)], GREY, 0.5)?;
            canvas.text("0", (rect.left - 8.0, *zero), Align::End, TICK_SIZE, GREY)
        }
    }
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
    if decimals > 4.0 || value >= 1e6 { significant(value, 2) } else { format!("{value:.0$}", decimals as usize) }
}

fn draw_series<DB: DrawingBackend>(canvas: &Canvas<DB>, panel: &Panel, places: &Places) -> Drawn {
    // Series that coincide stand side by side; the hollow one of a pair goes round its filled one.
    let shown: Vec<usize> = (0..panel.series.len()).filter(|index| !panel.series[*index].hollow).collect();
    let gap = (2.0 * FILLED + 2.0).min(0.8 * places.column() / shown.len().max(1) as f64);
    let aside = |index: usize| {
        let order = shown.iter().position(|each| *each >= index).unwrap_or(0);
        gap * (order as f64 - (shown.len() as f64 - 1.0) / 2.0)
    };
    let at = |index: usize, place: usize, mark: &Mark| (places.x(place) + aside(index), places.y(mark.value));
    for (index, series) in panel.series.iter().enumerate() {
        let marks: Vec<_> = series.marks.iter().enumerate().collect();
        for pair in marks.windows(2).filter(|pair| places.leads_on(pair[0].0)) {
            let [(from, Some(a)), (to, Some(b))] = pair else { continue };
            let (a, b) = (at(index, *from, a), at(index, *to, b));
            if series.hollow {
                canvas.dashed(a, b, series.style.colour, 1.0)?;
            } else {
                canvas.path(&[a, b], series.style.colour, 1.5)?;
            }
        }
        for (place, mark) in marks.iter().filter_map(|(place, mark)| Some((*place, (*mark).as_ref()?))) {
            let (x, y) = at(index, place, mark);
            let ends = [places.low_end(mark), places.y(mark.interval[1])];
            canvas.path(&[(x, ends[0]), (x, ends[1])], series.style.colour, 1.0)?;
            for end in ends.into_iter().filter(|end| (end - y).abs() > 2.0 * FILLED) {
                canvas.path(&[(x - CAP, end), (x + CAP, end)], series.style.colour, 1.0)?;
            }
        }
    }
    for (index, series) in panel.series.iter().enumerate().filter(|(_, series)| series.hollow) {
        for (place, mark) in series.marks.iter().enumerate().filter_map(|(place, mark)| Some((place, mark.as_ref()?))) {
            canvas.hollow_marker(at(index, place, mark), HOLLOW, series.style)?;
        }
    }
    for (index, series) in panel.series.iter().enumerate().filter(|(_, series)| !series.hollow) {
        for (place, mark) in series.marks.iter().enumerate().filter_map(|(place, mark)| Some((place, mark.as_ref()?))) {
            canvas.filled_marker(at(index, place, mark), FILLED, series.style)?;
        }
    }
    if panel.series.iter().all(|series| series.marks.iter().all(Option::is_none)) {
        places.rect.note(canvas, "nothing was measured")?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ticks are round, few, and told apart by their labels.
    #[test]
    fn linear_ticks_are_round() {
        for most in [1e-5, 0.03, 0.9, 1.0, 7.3, 99.0, 1234.0, 5e7] {
            let step = round_step(most, 6.0);
            let count = (most / step).floor();
            assert!((2.0..=6.0).contains(&count), "{most}: {count}");
            let labels: Vec<_> = (1..=count as u32).map(|index| step_label(f64::from(index) * step, step)).collect();
            assert!(labels.windows(2).all(|pair| pair[0] != pair[1]), "{labels:?}");
            assert!(labels.iter().all(|label| label.len() <= 7), "{labels:?}");
        }
        assert_eq!((round_step(60.0, 6.0), step_label(0.30000000000000004, 0.1).as_str()), (10.0, "0.3"));
    }

    /// Numbers from zero up stand by their logarithms, zero beside them and no line to it; names, negative numbers and a lone
    /// number stand at equal distances.
    #[test]
    fn values_have_places() {
        let rect = Rect { left: 100.0, top: 0.0, right: 400.0, bottom: 200.0 };
        let of = |values: &[&str]| {
            let values: Vec<String> = values.iter().map(|value| (*value).to_owned()).collect();
            let skipped = vec![false; values.len()];
            Places::new(
                rect,
                &Values::logarithmic(String::new(), &values, values.clone(), skipped),
                &Scale::Linear(1.0),
            )
        };
        let log = of(&["0", "0.001", "0.01", "0.1"]);
        assert!(log.x(0) < 100.0 + ZERO_COLUMN && log.x(1) > 100.0 + ZERO_COLUMN && log.x(3) < 400.0, "{log:?}");
        assert!((log.x(2) - log.x(1) - (log.x(3) - log.x(2))).abs() < 1e-9, "{log:?}");
        assert_eq!([0, 1, 2].map(|index| log.leads_on(index)), [false, true, true]);
        assert!(of(&["1", "2", "16"]).leads_on(0));
        for values in [&["a", "b", "c"][..], &["-1", "1", "2"], &["0", "1", "x"]] {
            let even = of(values);
            assert_eq!([0, 1, 2].map(|index| even.x(index)), [150.0, 250.0, 350.0], "{values:?}");
        }
        assert_eq!(of(&["0", "1"]).x(0), 175.0);
        assert!(of(&["-1", "1", "2"]).leads_on(0) && !of(&["a", "b"]).leads_on(0));
    }
}
