//! Curves over the values of a parameter or over the steps of a setting: where these stand, what joins them, and which marks
//! curves are drawn with.

use super::palette::Style;
use super::panel::{Aside, Axis, Control, Mark, Panel, Position, Scale};
use super::{LONGEST_VALUE, cut};
pub(super) use crate::studies::pareto::Amount as Measured;
use crate::studies::sweep::Multiple;

const FILLED: f64 = 4.0;
const HOLLOW: f64 = 6.0;
/// Widths of lines: solid and dashed ones.
const WIDTHS: [f64; 2] = [2.0, 1.0];

/// A curve.
#[derive(Debug)]
pub(super) struct Curve {
    pub style: Style,
    /// Dashed with hollow markers.
    pub hollow: bool,
    /// Where it stands beside others that may coincide with it.
    pub aside: Aside,
    /// What was measured at each of the values.
    pub at: Vec<Option<Measured>>,
}

/// What was measured anywhere on curves.
pub(super) fn measured(curves: &[Curve]) -> impl Iterator<Item = &Measured> + Clone {
    curves.iter().flat_map(|curve| curve.at.iter().flatten())
}

/// The values along the lower axis.
#[derive(Clone, Debug)]
pub(super) struct Values {
    pub axis: Axis,
    /// Where each is.
    pub places: Vec<f64>,
    /// Where nothing was measured.
    skipped: Vec<f64>,
    /// Whether there is anything between two places, so that a line may lead from one to the other.
    joined: bool,
}

impl Values {
    /// Steps at equal distances, of which one may be shaded.
    pub(super) fn steps(name: String, labels: Vec<String>, shaded: Option<usize>) -> Self {
        let places = (0..labels.len()).map(|step| step as f64).collect();
        let axis = Axis { name, scale: Scale::Steps(labels, shaded) };
        Self { axis, places, skipped: Vec::new(), joined: true }
    }

    /// Values of a parameter at equal distances, of which one may be shaded. Lines join numbers, and not names.
    pub(super) fn even(name: String, values: &[String], shaded: Option<usize>) -> Self {
        let is_number = |value: &String| value.parse::<f64>().is_ok() || Multiple::parse(value).is_some();
        let numbers = values.iter().all(is_number);
        let labels = values.iter().map(|value| cut(value, LONGEST_VALUE)).collect();
        Self { joined: numbers, ..Self::steps(name, labels, shaded) }
    }

    /// With those marked at which nothing was measured.
    pub(super) fn skipping(self, skipped: impl Iterator<Item = bool>) -> Self {
        let skipped = self.places.iter().zip(skipped).filter_map(|(place, skipped)| skipped.then_some(*place));
        Self { skipped: skipped.collect(), ..self }
    }

    /// A panel of curves. Points that were tried alone have controls of their own; they score the same, and stand there once.
    pub(super) fn panel(&self, title: String, y: Axis, curves: &[Curve], all: Vec<Control>) -> Panel {
        let mut controls: Vec<Control> = Vec::new();
        for control in all {
            if !controls.contains(&control) {
                controls.push(control);
            }
        }
        let skipped = self.skipped.iter().map(|place| Mark::Upwards(*place, "skipped"));
        let note = measured(curves).next().is_none().then_some("nothing was measured");
        Panel { title, x: self.axis.clone(), y, controls, marks: skipped.chain(self.marks(curves)).collect(), note }
    }

    /// The marks of curves: all lines before all bars before all markers, which tell by their form what they are; hollow ones
    /// first: they are larger, and a filled one at the same place sits inside.
    fn marks(&self, curves: &[Curve]) -> Vec<Mark> {
        let [mut lines, mut bars, mut hollow, mut filled] = [const { Vec::new() }; 4];
        for Curve { style, hollow: dashed, aside, at } in curves {
            let (style, dashed, aside, colour) = (*style, *dashed, *aside, style.colour);
            let found = self.places.iter().zip(at).map(|(place, one)| Some((*place, (*one)?)));
            let places: Vec<Option<Position>> = found.clone().map(|one| one.map(|(x, one)| (x, one.value))).collect();
            for pair in places.windows(2) {
                let &[Some(one), Some(other)] = pair else { continue };
                if self.joined {
                    let width = WIDTHS[usize::from(dashed)];
                    lines.push(Mark::Line { places: vec![one, other], colour, width, dashed, aside });
                }
            }
            for (x, Measured { value, interval: up }) in
                found.flatten().filter(|(_, one)| one.interval != [one.value; 2])
            {
                bars.push(Mark::Bars { place: (x, value), across: None, up, colour, aside });
            }
            let (markers, radius) = if dashed { (&mut hollow, HOLLOW) } else { (&mut filled, FILLED) };
            let marker = |place| Mark::Marker { place, radius, style, hollow: dashed, aside };
            markers.extend(places.into_iter().flatten().map(marker));
        }
        lines.into_iter().chain(bars).chain(hollow).chain(filled).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::super::palette::{INK, Shape};
    use super::*;

    fn values(all: &[&str]) -> Values {
        let all: Vec<String> = all.iter().map(|value| (*value).to_owned()).collect();
        Values::even(String::new(), &all, None)
    }

    /// Marks of a curve by kind: lines by the places of their ends, bars, markers.
    fn marks(values: &Values, at: Vec<Option<Measured>>) -> (Vec<[f64; 2]>, Vec<f64>, Vec<f64>) {
        let style = Style { colour: INK, shape: Shape::Circle };
        let curve = Curve { style, hollow: false, aside: Aside::default(), at };
        let (mut lines, mut bars, mut markers) = (Vec::new(), Vec::new(), Vec::new());
        for mark in values.marks(&[curve]) {
            match mark {
                Mark::Line { places, .. } => lines.push([places[0].0, places[1].0]),
                Mark::Bars { place, .. } => bars.push(place.0),
                Mark::Marker { place, .. } => markers.push(place.0),
                other => panic!("{other:?}"),
            }
        }
        (lines, bars, markers)
    }

    /// Values stand at equal distances, and lines join numbers, and not names.
    #[test]
    fn lines_join_numbers() {
        for (all, lines) in [(&["a", "b", "c"][..], 0), (&["-1", "1", "2"], 2), (&["0", "1"], 1), (&["0", "1", "x"], 0)]
        {
            let even = values(all);
            let (drawn, ..) = marks(&even, vec![Some(Measured::exact(1.0)); all.len()]);
            assert!(matches!(&even.axis.scale, Scale::Steps(names, None) if names.as_slice() == all), "{even:?}");
            assert_eq!((even.places[1], drawn.len()), (1.0, lines), "{all:?}");
        }
    }

    /// Where nothing was measured there is no line, no bar and no marker; what is known exactly has no bar.
    #[test]
    fn gaps_stay_open() {
        let at = vec![
            Some(Measured { value: 1.0, interval: [0.5, 2.0] }),
            Some(Measured::exact(2.0)),
            None,
            Some(Measured::exact(3.0)),
        ];
        let four = values(&["1", "2", "4", "8"]);
        assert_eq!(marks(&four, at), (vec![[0.0, 1.0]], vec![0.0], vec![0.0, 1.0, 3.0]));
        let none = four.panel(String::new(), four.axis.clone(), &[], Vec::new());
        assert_eq!(none.note, Some("nothing was measured"));
    }
}
