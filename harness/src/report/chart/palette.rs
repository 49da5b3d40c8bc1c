//! A colour and a shape for every tracer, the same in every chart of a run.

use itertools::Itertools as _;
use plotters::style::RGBColor;

use super::frame::{Entry, Sample};
use super::{LONGEST_TRACER, cut};
use crate::results::Record;

/// Text.
pub(super) const INK: RGBColor = RGBColor(0x22, 0x22, 0x22);
/// Captions, tick labels, controls.
pub(super) const GREY: RGBColor = RGBColor(0x66, 0x66, 0x66);
/// Lines of controls.
pub(super) const CONTROL: RGBColor = RGBColor(0x8C, 0x8C, 0x8C);
pub(super) const GRID: RGBColor = RGBColor(0xE2, 0xE2, 0xE2);
/// The row for zero.
pub(super) const SHADE: RGBColor = RGBColor(0xF1, 0xF1, 0xF1);

/// Colours that stay apart for most colour-blind readers: Okabe and Ito's, then darker ones after Tol, and a violet far from all of these.
const COLOURS: [u32; 13] = [
    0x0072B2, 0xD55E00, 0x009E73, 0xCC79A7, 0x56B4E9, 0xE69F00, 0x332288, 0x882255, 0x117733, 0x999933, 0xAA4499,
    0x661100, 0x8877FF,
];

/// One of them, in turn.
pub(super) fn colour(index: usize) -> RGBColor {
    let [_, red, green, blue] = COLOURS[index % COLOURS.len()].to_be_bytes();
    RGBColor(red, green, blue)
}

/// A colour as pages name it.
pub(in crate::report) fn hex(RGBColor(red, green, blue): RGBColor) -> String {
    format!("#{red:02X}{green:02X}{blue:02X}")
}

/// A marker's outline as corners on the unit circle; y points down, as on the canvas.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Shape {
    Circle,
    /// A regular polygon with so many corners, turned by so many degrees from pointing up.
    Polygon(u32, u32),
    /// A star with so many points, turned by so many degrees.
    Star(u32, u32),
}

const SHAPES: [Shape; 13] = [
    Shape::Circle,
    Shape::Polygon(4, 45),
    Shape::Polygon(3, 0),
    Shape::Polygon(4, 0),
    Shape::Polygon(3, 180),
    Shape::Polygon(5, 0),
    Shape::Star(5, 0),
    Shape::Star(4, 0),
    Shape::Polygon(3, 90),
    Shape::Polygon(6, 0),
    Shape::Polygon(3, 270),
    Shape::Star(4, 45),
    Shape::Star(3, 0),
];

impl Shape {
    /// The corners for a radius; as large to the eye as a circle of that radius.
    pub(super) fn corners(self, radius: f64) -> Vec<(f64, f64)> {
        let (count, degrees, grown, inner) = match self {
            Self::Circle => (32, 0, 1.0, 1.0),
            Self::Polygon(3, turned) => (3, turned, 1.35, 1.0),
            Self::Polygon(4, turned) => (4, turned, 1.25, 1.0),
            Self::Polygon(count, turned) => (count, turned, 1.12, 1.0),
            Self::Star(points, turned) => (2 * points, turned, 1.4, 0.45),
        };
        let corner = |index: u32| {
            let angle = f64::from(degrees).to_radians() + std::f64::consts::TAU * f64::from(index) / f64::from(count);
            let radius = radius * grown * if index % 2 == 1 { inner } else { 1.0 };
            (radius * angle.sin(), -radius * angle.cos())
        };
        (0..count).map(corner).collect()
    }

    /// By how much a radius must shrink for an outline of a width.
    pub(super) fn rim(self, width: f64) -> f64 {
        match self {
            Self::Circle => width,
            Self::Polygon(3, _) => width * 1.6,
            Self::Polygon(4, _) => width * 1.15,
            Self::Polygon(..) => width * 1.1,
            // Thin at the points, so that something of the inside is left.
            Self::Star(..) => width * 1.7,
        }
    }
}

/// What a tracer looks like.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Style {
    pub colour: RGBColor,
    pub shape: Shape,
}

/// What stands for any tracer in a key.
pub(super) const PLAIN: Style = Style { colour: GREY, shape: Shape::Circle };

/// The styles of a run's configurations.
#[derive(Debug)]
pub(super) struct Styles {
    labels: Vec<String>,
}

impl Styles {
    /// By the order in which labels first appear.
    pub(super) fn of(record: &Record) -> Self {
        Self::of_labels(record.rows.iter().map(|one| one.label()))
    }

    /// By the order of the labels themselves.
    pub(super) fn of_labels(all: impl Iterator<Item = String>) -> Self {
        Self { labels: all.unique().collect() }
    }

    /// A configuration's style. After all of them colours come again with other shapes.
    pub(super) fn get(&self, label: &str) -> Style {
        let index = self.labels.iter().position(|each| each == label).unwrap_or(0);
        let turn = index / COLOURS.len();
        Style { colour: colour(index), shape: SHAPES[(index + turn) % SHAPES.len()] }
    }

    /// Who is who.
    pub(super) fn legend(&self, sample: fn(Style) -> Sample) -> Vec<Entry> {
        self.labels.iter().map(|label| Entry::new(sample(self.get(label)), cut(label, LONGEST_TRACER))).collect()
    }
}
