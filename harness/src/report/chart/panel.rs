//! Panels of marks over two axes, and the one renderer of all charts that are made of such.

use plotters::prelude::DrawingBackend;
use plotters::style::RGBColor;

use super::canvas::{Align, Canvas, Drawn, Figure, shorten, text_width};
use super::frame::{Frame, Rect, TICK_SIZE};
use super::palette::{CONTROL, GREY, SHADE, Style};
pub(super) use super::scale::{Along, Aside, Scale};

/// Half the length of the caps at the ends of bars.
const CAP: f64 = 3.0;
/// Bars that end nearer than this to their marker get no cap: it would touch the marker.
const CAPPED: f64 = 9.0;
/// Markers along a curve are apart from each other by at least this much, so that the line shows between them.
const MARKER_GAP: f64 = 48.0;
/// Between the names of neighbouring steps.
const STEP_GAP: f64 = 4.0;

/// An axis.
#[derive(Clone, Debug)]
pub(super) struct Axis {
    /// Its name with the unit.
    pub name: String,
    /// What stands along it.
    pub scale: Scale,
}

/// By both axes.
pub(super) type Position = (f64, f64);

/// Something in a panel, drawn over what stands before it.
#[derive(Clone, Debug)]
pub(super) enum Mark {
    /// A line through places, so wide, moved aside.
    Line { places: Vec<Position>, colour: RGBColor, width: f64, dashed: bool, aside: Aside },
    /// A marker.
    Marker { place: Position, radius: f64, style: Style, hollow: bool, aside: Aside },
    /// Some of the places of a curve, from a part of a gap on: the markers of curves that coincide stand side by side.
    Along { places: Vec<Position>, radius: f64, style: Style, from: f64 },
    /// The intervals of a place by the lower axis, if it has one there, and by the left one.
    Bars { place: Position, across: Option<[f64; 2]>, up: [f64; 2], colour: RGBColor, aside: Aside },
    /// A hollow marker so far above its place, or below it, within the panel.
    Above { place: Position, by: f64, radius: f64, style: Style },
    /// A value of the lower axis.
    Rule(f64),
    /// A word upwards at a value of the lower axis.
    Upwards(f64, &'static str),
    /// Words at the foot.
    Words(String),
    /// Names beside the right edge, of lines that end at their places.
    Names(Vec<(Position, String, RGBColor)>),
}

/// A control's name, and the places that its dashes lead through, on to the right edge.
pub(super) type Control = (String, Vec<Position>);

/// A control that is the same all along the lower axis. One beyond the left axis has its name at the edge, and no dashes.
pub(super) fn level(name: String, value: f64) -> Control {
    (name, vec![(f64::NEG_INFINITY, value)])
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
    /// Controls.
    pub controls: Vec<Control>,
    /// What it shows.
    pub marks: Vec<Mark>,
    /// What is said of a panel that has nothing to show.
    pub note: Option<&'static str>,
}

/// A chart of such panels.
#[derive(Debug)]
pub(crate) struct Chart {
    /// What is round them.
    pub(super) frame: Frame,
    /// They.
    pub(super) panels: Vec<Panel>,
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
        let [column, row] = [&self.x, &self.y].map(|axis| axis.scale.zero_room());
        if row > 0.0 {
            canvas.fill((rect.left, rect.bottom - row), (rect.right, rect.bottom), SHADE)?;
        }
        if column > 0.0 {
            canvas.fill((rect.left, rect.top), (rect.left + column, rect.bottom), SHADE)?;
        }
        if let Scale::Steps(_, Some(step)) = self.x.scale {
            let [left, right] = [-0.5, 0.5].map(|half| x.at(step as f64 + half));
            canvas.fill((left, rect.top), (right, rect.bottom), SHADE)?;
        }
        let ticks = x.ticks(&self.x.scale, |text| text_width(text, TICK_SIZE));
        // Names of steps stand on two lines where one is too narrow.
        let room = x.step().unwrap_or(f64::INFINITY);
        let wide = |text: &String| text_width(text, TICK_SIZE) > room - STEP_GAP;
        let lines = if ticks.iter().filter_map(|(_, text)| text.as_ref()).any(wide) { 2 } else { 1 };
        for (index, (place, text)) in ticks.iter().enumerate() {
            let text = text.as_ref().map(|text| shorten(text, TICK_SIZE, lines as f64 * room - STEP_GAP));
            rect.tick_below(canvas, *place, text.as_deref(), index % lines)?;
        }
        for (place, text) in y.ticks(&self.y.scale, |_| TICK_SIZE) {
            rect.tick_left(canvas, place, text.as_deref())?;
        }
        if row > 0.0 {
            canvas.text("0", (rect.left - 8.0, y.at(0.0)), Align::End, TICK_SIZE, GREY)?;
        }
        if column > 0.0 {
            rect.tick_below(canvas, x.at(0.0), Some("0"), 0)?;
        }
        rect.title(canvas, &self.title)?;
        rect.axis_names(canvas, &self.x.name, &self.y.name, lines)?;
        let mut names = Vec::new();
        for (name, places) in &self.controls {
            let across = |value: f64| if value == f64::NEG_INFINITY { rect.left } else { x.at(value) };
            let mut points: Vec<Position> = places.iter().map(|place| (across(place.0), y.at(place.1))).collect();
            let Some((_, height)) = points.last().copied() else { continue };
            // On to the edge, where its name is.
            points.push((rect.right, height));
            if places.iter().all(|place| y.holds(place.1)) {
                canvas.dashed_path(&points, CONTROL, 1.0)?;
            }
            names.push((name.clone(), height, GREY));
        }
        rect.names_right(canvas, &names)?;
        rect.edge(canvas)
    }
}

fn draw_mark<DB: DrawingBackend>(canvas: &Canvas<DB>, mark: &Mark, rect: Rect, [x, y]: [&Along; 2]) -> Drawn {
    let at = |(across, up): &Position, aside: Aside| (x.at(*across) + x.aside(aside), y.at(*up));
    match mark {
        Mark::Line { places, colour, width, dashed, aside } => {
            let points: Vec<Position> = places.iter().map(|place| at(place, *aside)).collect();
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
        Mark::Bars { place, across, up, colour, aside } => {
            let (left, top) = at(place, *aside);
            if let Some([slow, fast]) = across.map(|ends| ends.map(|end| x.at(end))) {
                canvas.path(&[(slow, top), (fast, top)], *colour, 1.0)?;
                for end in [slow, fast].into_iter().filter(|end| (end - left).abs() > CAPPED) {
                    canvas.path(&[(end, top - CAP), (end, top + CAP)], *colour, 1.0)?;
                }
            }
            let [least, most] = [y.low_end(place.1, up[0]), y.at(up[1])];
            canvas.path(&[(left, least), (left, most)], *colour, 1.0)?;
            for end in [least, most].into_iter().filter(|end| (end - top).abs() > CAPPED) {
                canvas.path(&[(left - CAP, end), (left + CAP, end)], *colour, 1.0)?;
            }
            Ok(())
        }
        Mark::Above { place, by, radius, style } => {
            let (left, top) = at(place, Aside::default());
            let top = (top - by).clamp(rect.top + radius, rect.bottom - radius);
            canvas.hollow_marker((left, top), *radius, *style)
        }
        Mark::Rule(value) => canvas.dashed((x.at(*value), rect.top), (x.at(*value), rect.bottom), CONTROL, 1.0),
        Mark::Upwards(value, word) => {
            let middle = (x.at(*value), (rect.top + rect.bottom) / 2.0);
            canvas.text_upwards(word, middle, TICK_SIZE, GREY)
        }
        Mark::Words(words) => {
            let words = shorten(words, TICK_SIZE, rect.right - rect.left - 8.0);
            canvas.text(&words, (rect.right - 4.0, rect.bottom - 9.0), Align::End, TICK_SIZE, GREY)
        }
        Mark::Names(all) => {
            let mut names = Vec::new();
            for (place, name, colour) in all {
                let (left, top) = at(place, Aside::default());
                canvas.path(&[(left, top), (rect.right, top)], CONTROL, 0.5)?;
                names.push((name.clone(), top, *colour));
            }
            rect.names_right(canvas, &names)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::canvas::to_svg;
    use super::super::palette::INK;
    use super::*;

    fn drawn(x: Scale, controls: Vec<Control>, marks: Vec<Mark>) -> String {
        let axis = |scale| Axis { name: String::new(), scale };
        let (x, y) = (axis(x), axis(Scale::Span([50.0, 100.0])));
        let panels = vec![Panel { title: String::new(), x, y, controls, marks, note: None }];
        let frame = Frame::new(1, [const { String::new() }; 2], "", Vec::new(), Vec::new());
        to_svg(&Chart { frame, panels }).unwrap()
    }

    fn lines_with<'a>(svg: &'a str, all: &[&str]) -> Vec<&'a str> {
        svg.lines().filter(|line| all.iter().all(|each| line.contains(each))).collect()
    }

    /// A control on the axis has dashes from edge to edge, also across a column for zero; one beyond it has none, and both have
    /// their names.
    #[test]
    fn controls_beyond_the_axis_are_named_alone() {
        let dashes = |value: f64| {
            let svg = drawn(Scale::LogAndZero((0.0, 1.0), 5), vec![level("oracle".to_owned(), value)], Vec::new());
            assert!(svg.contains("oracle"), "{svg}");
            let paths = lines_with(&svg, &["#8C8C8C", "stroke-width=\"2\""]);
            let dashes = paths.iter().map(|path| path.matches('M').count()).sum::<usize>();
            (dashes, paths.first().is_some_and(|path| path.contains("d=\"M140,")))
        };
        assert_eq!([60.0, 100.0, 49.0, 101.0].map(|value| dashes(value).0 > 40), [true, true, false, false]);
        assert_eq!(
            [60.0, 49.0].map(dashes).map(|(count, from_edge)| (count > 0, from_edge)),
            [(true, true), (false, false)]
        );
    }

    /// Names of steps that are too wide for one line take two; what is shaded is as wide as a step.
    #[test]
    fn wide_steps_take_two_lines() {
        let heights = |name: &str| {
            let names = (0..4).map(|step| format!("{name}{step}")).collect();
            let svg = drawn(Scale::Steps(names, Some(1)), Vec::new(), Vec::new());
            assert_eq!(lines_with(&svg, &["<rect", "#F1F1F1"]).len(), 1, "{svg}");
            let named = lines_with(&svg, &["<text", "text-anchor=\"middle\"", "font-size=\"21\""]);
            let height = |line: &&str| line.split(" y=\"").nth(1).unwrap().split('"').next().unwrap().to_owned();
            named.iter().map(height).collect::<std::collections::BTreeSet<_>>().len()
        };
        assert_eq!([heights("v"), heights("a rather long value of it ")], [1, 2]);
    }

    /// A marker above its place is above it, and at the edge where there is no room.
    #[test]
    fn markers_above_stay_inside() {
        let height = |value: f64, by: f64| {
            let style = Style { colour: INK, shape: super::super::palette::Shape::Circle };
            let mark = Mark::Above { place: (1.0, value), by, radius: 4.0, style };
            let svg = drawn(Scale::Steps(vec![String::new(); 3], None), Vec::new(), vec![mark]);
            let circle = lines_with(&svg, &["<circle", "#222222"])[0].to_owned();
            circle.split(" cy=\"").nth(1).unwrap().split('"').next().unwrap().parse::<f64>().unwrap()
        };
        let middle = height(75.0, 0.0);
        assert_eq!([height(75.0, 12.0), height(75.0, -12.0)], [middle - 24.0, middle + 24.0]);
        assert_eq!(height(f64::INFINITY, -9.0), height(100.0, -9.0));
        assert!(height(100.0, 12.0) == height(f64::INFINITY, 99.0) && height(100.0, 12.0) < height(100.0, -9.0));
    }
}
