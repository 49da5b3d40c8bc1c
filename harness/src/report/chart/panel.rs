//! Panels of marks over two axes, and the one renderer of all charts that are made of such.

use plotters::prelude::DrawingBackend;
use plotters::style::RGBColor;

use super::axis::{LogAxis, labels, percent_label};
use super::canvas::{Align, Canvas, Drawn, Figure, shorten};
use super::frame::{Frame, Rect, TICK_SIZE};
use super::palette::{CONTROL, GREY, SHADE, Style};

/// Height of the row for zero at the foot of a panel of shares; a logarithm never gets there.
pub(super) const ZERO_ROW: f64 = 26.0;
/// Above all and below none of a linear share, where lines often run.
const AIR: f64 = 10.0;
/// Half the length of the caps at the ends of bars.
const CAP: f64 = 3.0;
/// Bars that end nearer than this to their marker get no cap: it would touch the marker.
const CAPPED: f64 = 9.0;
/// Markers along a curve are apart from each other by at least this much, so that the line shows between them.
const MARKER_GAP: f64 = 48.0;
/// Marks that would coincide stand this far apart where there is room.
const ASIDE: f64 = 13.0;

/// What stands along an axis.
#[derive(Clone, Debug)]
pub(super) enum Scale {
    /// Decimal logarithms between two, with so many labels at most.
    Log((f64, f64), usize),
    /// Shares between two decimal logarithms, over a row of a height for zero.
    Shares((f64, f64), f64),
    /// Shares from none to all.
    Whole,
    /// Steps at equal distances, whatever their values; places count them.
    Steps(Vec<String>),
}

/// An axis.
#[derive(Clone, Debug)]
pub(super) struct Axis {
    /// Its name with the unit.
    pub name: String,
    /// What stands along it.
    pub scale: Scale,
}

/// By both axes.
pub(super) type Place = (f64, f64);

/// Something in a panel, drawn over what stands before it.
#[derive(Clone, Debug)]
pub(super) enum Mark {
    /// A line through places, so wide, moved aside.
    Line { places: Vec<Place>, colour: RGBColor, width: f64, dashed: bool, aside: Aside },
    /// A marker.
    Marker { place: Place, radius: f64, style: Style, hollow: bool, aside: Aside },
    /// Some of the places of a curve, from a part of a gap on: the markers of curves that coincide stand side by side.
    Along { places: Vec<Place>, radius: f64, style: Style, from: f64 },
    /// The intervals of a place by both axes.
    Bars { place: Place, intervals: [[f64; 2]; 2], colour: RGBColor },
    /// A value of the lower axis.
    Rule(f64),
    /// Words at the foot.
    Words(String),
}

/// How far something stands aside of its step: its place among so many.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Aside(pub usize, pub usize);

/// Lines between neighbours of which both are there.
pub(super) fn between(
    places: &[Option<Place>],
    colour: RGBColor,
    width: f64,
    dashed: bool,
    aside: Aside,
) -> impl Iterator<Item = Mark> {
    let both = places.windows(2).filter_map(|pair| Some(vec![pair[0]?, pair[1]?]));
    both.map(move |places| Mark::Line { places, colour, width, dashed, aside })
}

/// A panel.
#[derive(Clone, Debug)]
pub(super) struct Panel {
    /// Its title.
    pub title: String,
    /// The lower axis.
    pub x: Axis,
    /// The left axis.
    pub y: Axis,
    /// Controls by name: dashes through places, on to the right edge.
    pub controls: Vec<(String, Vec<Place>)>,
    /// What it shows.
    pub marks: Vec<Mark>,
    /// What is said of a panel that has nothing to show.
    pub note: Option<&'static str>,
}

/// A chart of such panels.
#[derive(Debug)]
pub(super) struct Chart {
    /// What is round them.
    pub frame: Frame,
    /// They.
    pub panels: Vec<Panel>,
}

impl Figure for Chart {
    fn size(&self) -> (f64, f64) {
        self.frame.size()
    }

    fn draw<DB: DrawingBackend>(&self, canvas: &Canvas<DB>) -> Drawn {
        self.frame.draw(canvas)?;
        let mut panels = self.panels.iter().enumerate();
        panels.try_for_each(|(index, panel)| panel.draw(canvas, self.frame.panel(index)))
    }
}

/// An axis on the canvas.
#[derive(Debug)]
pub(super) enum Along {
    Log(LogAxis),
    Shares(LogAxis, f64),
    Linear([f64; 2]),
    Steps([f64; 2], usize),
}

impl Along {
    fn new(scale: &Scale, from: f64, to: f64) -> Self {
        let inwards = |length: f64| if to < from { -length } else { length };
        match scale {
            Scale::Log(range, _) => Self::Log(LogAxis::new(*range, from, to)),
            Scale::Shares(range, row) => {
                Self::Shares(LogAxis::new(*range, from + inwards(*row), to), from + inwards(row / 2.0))
            }
            Scale::Whole => Self::Linear([from + inwards(AIR), to - inwards(AIR)]),
            Scale::Steps(steps) => Self::Steps([from, to], steps.len().max(1)),
        }
    }

    /// Where a value is; values off the axis are at its ends.
    pub(super) fn at(&self, value: f64) -> f64 {
        match self {
            Self::Log(axis) => axis.at(value),
            Self::Shares(axis, _) if value > 0.0 => axis.at(value),
            Self::Shares(_, zero) => *zero,
            Self::Linear([from, to]) => from + (to - from) * value.clamp(0.0, 1.0),
            Self::Steps([from, to], count) => from + (to - from) * ((value + 0.5) / *count as f64),
        }
    }

    /// The lower end of an interval: of a share above zero one below the axis ends at it, not in the row for zero.
    fn low_end(&self, value: f64, low: f64) -> f64 {
        match self {
            Self::Shares(axis, _) if value > 0.0 => axis.at(low),
            Self::Shares(_, zero) => *zero,
            _ => self.at(low),
        }
    }

    fn aside(&self, Aside(place, of): Aside) -> f64 {
        let step = self.at(1.0) - self.at(0.0);
        if of == 0 { 0.0 } else { ASIDE.min(0.8 * step / of as f64) * (place as f64 - (of as f64 - 1.0) / 2.0) }
    }
}

/// Ticks of a scale: places with their labels.
fn ticks(scale: &Scale, along: &Along) -> Vec<(f64, Option<String>)> {
    match (scale, along) {
        (Scale::Log(_, most), Along::Log(axis)) => {
            let ticks = axis.ticks(*most);
            let texts = labels(&ticks);
            ticks.iter().map(|tick| axis.at(tick.value)).zip(texts).collect()
        }
        (_, Along::Shares(axis, _)) => {
            let ticks = axis.ticks(9).into_iter().filter(|tick| tick.value <= 1.0 + 1e-9);
            ticks.map(|tick| (axis.at(tick.value), tick.labelled.then(|| percent_label(tick.value)))).collect()
        }
        (Scale::Steps(steps), _) => {
            steps.iter().enumerate().map(|(step, label)| (along.at(step as f64), Some(label.clone()))).collect()
        }
        _ => {
            let percent = (0..=100).step_by(20);
            percent.map(|percent| (along.at(f64::from(percent) / 100.0), Some(format!("{percent} %")))).collect()
        }
    }
}

impl Panel {
    /// Its axes on the canvas.
    pub(super) fn axes(&self, rect: Rect) -> [Along; 2] {
        [Along::new(&self.x.scale, rect.left, rect.right), Along::new(&self.y.scale, rect.bottom, rect.top)]
    }

    /// Draws it.
    pub(super) fn draw<DB: DrawingBackend>(&self, canvas: &Canvas<DB>, rect: Rect) -> Drawn {
        let [x, y] = self.axes(rect);
        self.draw_ground(canvas, rect, [&x, &y])?;
        self.marks.iter().try_for_each(|mark| draw_mark(canvas, mark, rect, [&x, &y]))?;
        self.note.map_or(Ok(()), |note| rect.note(canvas, note))
    }

    fn draw_ground<DB: DrawingBackend>(&self, canvas: &Canvas<DB>, rect: Rect, [x, y]: [&Along; 2]) -> Drawn {
        let row = if let Scale::Shares(_, row) = self.y.scale { row } else { 0.0 };
        if row > 0.0 {
            canvas.fill((rect.left, rect.bottom - row), (rect.right, rect.bottom), SHADE)?;
        }
        for (place, text) in ticks(&self.x.scale, x) {
            rect.tick_below(canvas, place, text.as_deref())?;
        }
        for (place, text) in ticks(&self.y.scale, y) {
            rect.tick_left(canvas, place, text.as_deref())?;
        }
        if row > 0.0 {
            canvas.text("0", (rect.left - 8.0, y.at(0.0)), Align::End, TICK_SIZE, GREY)?;
        }
        rect.title(canvas, &self.title)?;
        rect.axis_names(canvas, &self.x.name, &self.y.name)?;
        let mut names = Vec::new();
        for (name, places) in &self.controls {
            let mut points: Vec<Place> = places.iter().map(|(across, up)| (x.at(*across), y.at(*up))).collect();
            let Some((_, height)) = points.last().copied() else { continue };
            // On to the edge, where its name is.
            points.push((rect.right, height));
            canvas.dashed_path(&points, CONTROL, 1.0)?;
            names.push((name.clone(), height));
        }
        rect.names_right(canvas, &names)?;
        rect.edge(canvas)
    }
}

fn draw_mark<DB: DrawingBackend>(canvas: &Canvas<DB>, mark: &Mark, rect: Rect, [x, y]: [&Along; 2]) -> Drawn {
    let at = |(across, up): &Place, aside: Aside| (x.at(*across) + x.aside(aside), y.at(*up));
    match mark {
        Mark::Line { places, colour, width, dashed, aside } => {
            let points: Vec<Place> = places.iter().map(|place| at(place, *aside)).collect();
            if *dashed { canvas.dashed_path(&points, *colour, *width) } else { canvas.path(&points, *colour, *width) }
        }
        Mark::Marker { place, radius, style, hollow: true, aside } => {
            canvas.hollow_marker(at(place, *aside), *radius, *style)
        }
        Mark::Marker { place, radius, style, aside, .. } => canvas.filled_marker(at(place, *aside), *radius, *style),
        Mark::Along { places, radius, style, from } => {
            let mut next = rect.left + MARKER_GAP * from;
            for point in places.iter().map(|place| (x.at(place.0), y.at(place.1))) {
                if point.0 >= next {
                    canvas.filled_marker(point, *radius, *style)?;
                    next = point.0 + MARKER_GAP;
                }
            }
            Ok(())
        }
        Mark::Bars { place, intervals, colour } => draw_bars(canvas, *place, intervals, *colour, [x, y]),
        Mark::Rule(value) => canvas.dashed((x.at(*value), rect.top), (x.at(*value), rect.bottom), CONTROL, 1.0),
        Mark::Words(words) => {
            let words = shorten(words, TICK_SIZE, rect.right - rect.left - 8.0);
            canvas.text(&words, (rect.right - 4.0, rect.bottom - 9.0), Align::End, TICK_SIZE, GREY)
        }
    }
}

fn draw_bars<DB: DrawingBackend>(
    canvas: &Canvas<DB>,
    place: Place,
    [across, up]: &[[f64; 2]; 2],
    colour: RGBColor,
    [x, y]: [&Along; 2],
) -> Drawn {
    let (left, top) = (x.at(place.0), y.at(place.1));
    let [slow, fast] = across.map(|end| x.at(end));
    canvas.path(&[(slow, top), (fast, top)], colour, 1.0)?;
    for end in [slow, fast].into_iter().filter(|end| (end - left).abs() > CAPPED) {
        canvas.path(&[(end, top - CAP), (end, top + CAP)], colour, 1.0)?;
    }
    let [least, most] = [y.low_end(place.1, up[0]), y.at(up[1])];
    canvas.path(&[(left, least), (left, most)], colour, 1.0)?;
    for end in [least, most].into_iter().filter(|end| (end - top).abs() > CAPPED) {
        canvas.path(&[(left - CAP, end), (left + CAP, end)], colour, 1.0)?;
    }
    Ok(())
}
