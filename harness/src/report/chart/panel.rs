//! Panels of marks over two axes, and the one renderer of all charts that are made of such.

use plotters::style::RGBColor;

use super::canvas::{Align, Canvas, shorten, text_width};
use super::frame::{LEFT, RIGHT, Rect};
use super::front::{self, Points};
use super::palette::{CONTROL, GREY, GRID, INK, SHADE, Style};
pub(super) use super::scale::{Along, Aside, Scale};

const TITLE_SIZE: f64 = 13.0;
const TICK_SIZE: f64 = 10.5;
/// Size of axes' names.
const AXIS_SIZE: f64 = 11.5;
/// Half the length of the caps at the ends of bars.
const CAP: f64 = 3.0;
/// Bars that end nearer than this to their marker get no cap: it would touch the marker.
const CAPPED: f64 = 9.0;
/// Markers along a curve are apart from each other by at least this much, so that the line shows between them.
const MARKER_GAP: f64 = 48.0;
/// Between the names of neighbouring steps.
const STEP_GAP: f64 = 4.0;
/// Of more steps than these some may do without their names.
const MANY_STEPS: usize = 8;

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
    /// A value of the lower axis.
    Rule(f64),
    /// A word upwards at a value of the lower axis.
    Upwards(f64, &'static str),
    /// Words at the foot.
    Words(String),
    /// Names beside the right edge, of lines that end at their places.
    Names(Vec<(Position, String, RGBColor)>),
    /// Points with the fronts that they are on.
    Points(Points),
}

impl Mark {
    /// A solid line.
    pub(super) fn line(places: &[Position], colour: RGBColor, width: f64) -> Self {
        Self::Line { places: places.to_vec(), colour, width, dashed: false, aside: Aside::default() }
    }

    /// A marker at its place.
    pub(super) fn marker(place: Position, radius: f64, style: Style, hollow: bool) -> Self {
        Self::Marker { place, radius, style, hollow, aside: Aside::default() }
    }
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
    pub title: String,
    pub x: Axis,
    pub y: Axis,
    pub controls: Vec<Control>,
    pub marks: Vec<Mark>,
    /// What is said of a panel that has nothing to show.
    pub note: Option<&'static str>,
}

impl Panel {
    /// Its axes on the canvas.
    pub(super) fn axes(&self, rect: Rect) -> [Along<'_>; 2] {
        [Along::new(&self.x.scale, rect.left, rect.right), Along::new(&self.y.scale, rect.bottom, rect.top)]
    }

    /// Draws it.
    pub(super) fn draw(&self, canvas: &mut Canvas, rect: Rect) {
        let [x, y] = &self.axes(rect);
        self.draw_ground(canvas, rect, [x, y]);
        self.marks.iter().for_each(|mark| self.draw_mark(canvas, mark, rect, [x, y]));
        if let Some(note) = self.note {
            let middle = ((rect.left + rect.right) / 2.0, (rect.top + rect.bottom) / 2.0);
            let note = shorten(note, AXIS_SIZE, rect.right - rect.left - 8.0);
            canvas.text(&note, middle, Align::Center, AXIS_SIZE, GREY);
        }
    }

    fn draw_ground(&self, canvas: &mut Canvas, rect: Rect, [x, y]: [&Along<'_>; 2]) {
        let Rect { left, top, right, bottom } = rect;
        let [column, row] = [&self.x, &self.y].map(|axis| axis.scale.zero_room());
        if row > 0.0 {
            canvas.fill((left, bottom - row), (right, bottom), SHADE);
        }
        if column > 0.0 {
            canvas.fill((left, top), (left + column, bottom), SHADE);
        }
        if let Scale::Steps(_, Some(step)) = self.x.scale {
            let [from, to] = [-0.5, 0.5].map(|half| x.at(step as f64 + half));
            canvas.fill((from, top), (to, bottom), SHADE);
        }
        let ticks = x.ticks(|text| text_width(text, TICK_SIZE));
        // Names of steps stand on two lines where one is too narrow; of many, where two are, every second stands, the shaded one among them.
        let room = x.step().unwrap_or(f64::INFINITY);
        let widths = ticks.iter().filter_map(|(_, text)| Some(text_width(text.as_ref()?, TICK_SIZE)));
        let widest = widths.fold(0.0, f64::max);
        let lines = if widest > room - STEP_GAP { 2 } else { 1 };
        let every = if ticks.len() > MANY_STEPS && widest > 2.0 * room - STEP_GAP { 2 } else { 1 };
        let first = if let Scale::Steps(_, Some(own)) = self.x.scale { own % every } else { 0 };
        let width = (lines * every) as f64 * room - STEP_GAP;
        for (index, (place, text)) in ticks.iter().enumerate() {
            let text = text.as_ref().filter(|_| index % every == first).map(|text| shorten(text, TICK_SIZE, width));
            tick_below(canvas, rect, *place, text.as_deref(), index / every % lines);
        }
        for (y, text) in y.ticks(|_| TICK_SIZE) {
            if let Some(text) = text {
                canvas.path(&[(left, y), (right, y)], GRID, 1.0);
                canvas.path(&[(left - 5.0, y), (left, y)], GREY, 1.0);
                canvas.text(&text, (left - 8.0, y), Align::Right, TICK_SIZE, GREY);
            } else {
                canvas.path(&[(left - 3.0, y), (left, y)], GREY, 0.5);
            }
        }
        if row > 0.0 {
            canvas.text("0", (left - 8.0, y.at(0.0)), Align::Right, TICK_SIZE, GREY);
        }
        if column > 0.0 {
            tick_below(canvas, rect, x.at(0.0), Some("0"), 0);
        }
        // The title has the space beside the panel, too.
        let title = shorten(&self.title, TITLE_SIZE, right - left + RIGHT - 6.0);
        canvas.text(&title, (left, top - 14.0), Align::Left, TITLE_SIZE, INK);
        let below = ((left + right) / 2.0, bottom + if lines > 1 { 42.0 } else { 35.0 });
        canvas.text(&shorten(&self.x.name, AXIS_SIZE, right - left + LEFT), below, Align::Center, AXIS_SIZE, INK);
        canvas.text_upwards(&self.y.name, (left - 57.0, (top + bottom) / 2.0), AXIS_SIZE, INK);
        let mut names = Vec::new();
        for (name, places) in &self.controls {
            let across = |value: f64| if value == f64::NEG_INFINITY { left } else { x.at(value) };
            let mut points: Vec<Position> = places.iter().map(|place| (across(place.0), y.at(place.1))).collect();
            let Some((_, height)) = points.last().copied() else { continue };
            // On to the edge, where its name is.
            points.push((right, height));
            if places.iter().all(|place| y.holds(place.1)) {
                canvas.dashed(&points, CONTROL, 1.0);
            }
            names.push((name.as_str(), height, GREY));
        }
        names_right(canvas, rect, &names);
        canvas.path(&[(left, top), (right, top), (right, bottom), (left, bottom), (left, top)], GREY, 1.0);
    }

    fn draw_mark(&self, canvas: &mut Canvas, mark: &Mark, rect: Rect, [x, y]: [&Along<'_>; 2]) {
        let at = |(across, up): &Position, aside: Aside| (x.at(*across) + x.aside(aside), y.at(*up));
        match mark {
            Mark::Line { places, colour, width, dashed, aside } => {
                let points: Vec<Position> = places.iter().map(|place| at(place, *aside)).collect();
                let draw = if *dashed { Canvas::dashed } else { Canvas::path };
                draw(canvas, &points, *colour, *width);
            }
            Mark::Marker { place, radius, style, hollow, aside } => {
                let draw = if *hollow { Canvas::hollow_marker } else { Canvas::filled_marker };
                draw(canvas, at(place, *aside), *radius, *style);
            }
            Mark::Along { places, radius, style, from } => {
                let mut next = rect.left + MARKER_GAP * from;
                for point in places.iter().map(|place| at(place, Aside::default())) {
                    if point.0 >= next {
                        canvas.filled_marker(point, *radius, *style);
                        next = point.0 + MARKER_GAP;
                    }
                }
            }
            Mark::Bars { place, across, up, colour, aside } => {
                let (left, top) = at(place, *aside);
                if let Some([slow, fast]) = across.map(|ends| ends.map(|end| x.at(end))) {
                    canvas.path(&[(slow, top), (fast, top)], *colour, 1.0);
                    for end in [slow, fast].into_iter().filter(|end| (end - left).abs() > CAPPED) {
                        canvas.path(&[(end, top - CAP), (end, top + CAP)], *colour, 1.0);
                    }
                }
                let [least, most] = [y.low_end(place.1, up[0]), y.at(up[1])];
                canvas.path(&[(left, least), (left, most)], *colour, 1.0);
                for end in [least, most].into_iter().filter(|end| (end - top).abs() > CAPPED) {
                    canvas.path(&[(left - CAP, end), (left + CAP, end)], *colour, 1.0);
                }
            }
            Mark::Rule(value) => {
                canvas.dashed(&[(x.at(*value), rect.top), (x.at(*value), rect.bottom)], CONTROL, 1.0);
            }
            Mark::Upwards(value, word) => {
                let middle = (x.at(*value), (rect.top + rect.bottom) / 2.0);
                canvas.text_upwards(word, middle, TICK_SIZE, GREY);
            }
            Mark::Words(words) => {
                let words = shorten(words, TICK_SIZE, rect.right - rect.left - 8.0);
                canvas.text(&words, (rect.right - 4.0, rect.bottom - 9.0), Align::Right, TICK_SIZE, GREY);
            }
            Mark::Names(all) => {
                let mut names = Vec::new();
                for (place, name, colour) in all {
                    let (left, top) = at(place, Aside::default());
                    canvas.path(&[(left, top), (rect.right, top)], CONTROL, 0.5);
                    names.push((name.as_str(), top, *colour));
                }
                names_right(canvas, rect, &names);
            }
            Mark::Points(points) => front::draw(canvas, points.layer(self, rect)),
        }
    }
}

/// A tick of the lower axis with its grid line, its label on a line of several.
fn tick_below(canvas: &mut Canvas, Rect { top, bottom, .. }: Rect, x: f64, label: Option<&str>, line: usize) {
    if let Some(label) = label {
        canvas.path(&[(x, top), (x, bottom)], GRID, 1.0);
        canvas.path(&[(x, bottom), (x, bottom + 5.0)], GREY, 1.0);
        let drop = 15.0 + TICK_SIZE * line as f64;
        canvas.text(label, (x, bottom + drop), Align::Center, TICK_SIZE, GREY);
    } else {
        canvas.path(&[(x, bottom), (x, bottom + 3.0)], GREY, 0.5);
    }
}

/// Names in the gutter on the right, moved apart, each led to its height.
fn names_right(canvas: &mut Canvas, Rect { top, right, bottom, .. }: Rect, names: &[(&str, f64, RGBColor)]) {
    let wanted: Vec<f64> = names.iter().map(|(_, y, _)| *y).collect();
    let places = spread(&wanted, 12.5, top + 4.0, bottom - 4.0);
    for ((name, y, colour), place) in names.iter().zip(places) {
        canvas.path(&[(right, *y), (right + 5.0, *y), (right + 11.0, place)], CONTROL, 0.5);
        let name = shorten(name, TICK_SIZE, RIGHT - 14.0);
        canvas.text(&name, (right + 13.0, place), Align::Left, TICK_SIZE, *colour);
    }
}

/// Moves places apart until neighbours are a gap apart, keeping their order and staying between two bounds while there
/// is room.
fn spread(places: &[f64], gap: f64, low: f64, high: f64) -> Vec<f64> {
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
    use super::super::frame::Chart;
    use super::*;

    fn drawn(x: Scale, controls: Vec<Control>, marks: Vec<Mark>) -> String {
        let axis = |scale| Axis { name: String::new(), scale };
        let (x, y) = (axis(x), axis(Scale::Span([50.0, 100.0])));
        let panels = vec![Panel { title: String::new(), x, y, controls, marks, note: None }];
        Chart::new(panels, [const { String::new() }; 2], String::new(), [const { Vec::new() }; 2]).drawn().svg()
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
            let dashes = paths.iter().map(|path| path.matches('m').count()).sum::<usize>();
            (dashes, paths.first().is_some_and(|path| path.contains("d=\"m140,")))
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

    /// Proves that of many steps whose names fit no two lines every second one is named, whole, the shaded one among them.
    #[test]
    fn of_many_wide_steps_every_second_is_named() {
        let names: Vec<String> = (0..14).map(|step| format!("0.123456789012{step:02}")).collect();
        let svg = drawn(Scale::Steps(names.clone(), Some(1)), Vec::new(), Vec::new());
        let named: Vec<usize> = (0..14).filter(|step| svg.contains(&names[*step])).collect();
        assert_eq!(named, [1, 3, 5, 7, 9, 11, 13]);
        assert!(!svg.contains('…'), "{svg}");
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
