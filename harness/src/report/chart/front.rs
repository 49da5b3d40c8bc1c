//! Fronts: what points cost against what they get wrong.

mod layer;
mod names;

pub(in crate::report) use layer::{FrontLayers, PointMark};

use itertools::Itertools as _;
use plotters::prelude::DrawingBackend;
use plotters::style::RGBColor;

use tracebench_api::Query;

use super::axis::log_range;
use super::canvas::{Align, Canvas, Drawn, Figure};
use super::frame::{Entry as Line, Frame, Rect, Sample};
use super::palette::{INK, PLAIN, Shape, Style, Styles};
use super::panel::{self, Along, Axis, Scale};
use super::{LONGEST_NAME, LONGEST_SET, cut, error_name, untimed_caption};
use crate::report::format::{self, thousands};
use crate::report::pareto::{as_read, cost_name};
use crate::report::verdict::{self, Verdict};
use crate::results::{FrontPoint, ParetoRecord, Record};
use crate::studies::pareto::{Amount, By, Cost, CostAndError, Entry, Field, FrontStatus, Wrong};

const PLOT_HEIGHT: f64 = 300.0;
const ON_FRONT: f64 = 4.5;
const HOLLOW: f64 = 5.0;
const FAINT: f64 = 2.8;
/// Of a tracer's best point behind the front.
const BEST: f64 = 3.8;
/// How much of a faint colour is white.
const WHITENED: f64 = 0.55;
/// Size of the names beside points.
const NAME_SIZE: f64 = 9.5;
/// Width of the line of the front of all.
const FRONT_WIDTH: f64 = 1.5;
/// Width of the line of a tracer's own front.
const OWN_WIDTH: f64 = 0.75;
/// From where to where below a mark its arrow goes.
const ARROW: [f64; 2] = [6.0, 13.0];
/// Half the length of the caps at the ends of bars.
const CAP: f64 = 2.5;

/// A panel that is asked for.
pub(in crate::report) struct PanelOf<'a> {
    /// Its title.
    pub title: String,
    /// What is along its lower axis.
    pub cost: Cost,
    /// The points.
    pub entries: Vec<Entry<'a>>,
}

/// A point's place.
#[derive(Debug)]
struct Mark {
    /// Its place among the record's points.
    index: usize,
    tracer: String,
    style: Style,
    x: Amount,
    error: Amount,
    /// The height at which it is drawn.
    y: f64,
    at_bound: bool,
    front_status: FrontStatus,
    /// Whether no point of its tracer is wrong less often, nor as often and cheaper.
    is_best: bool,
    name: String,
    cost: f64,
}

/// Corners of a front, the cheapest first, by value and height.
type Corners = Vec<(f64, f64)>;

#[derive(Debug)]
struct Panel {
    /// What does not hang on who is shown.
    ground: panel::Panel,
    marks: Vec<Mark>,
    cost: Cost,
    /// Each tracer's own, with its name and colour.
    own: Vec<(String, RGBColor, Corners)>,
}

/// The chart.
#[derive(Debug)]
pub(crate) struct FrontFigure {
    frame: Frame,
    panels: Vec<Panel>,
    /// Decimal logarithm of the least error that is shown.
    floor: f64,
}

/// A colour of its own for every tracer of a record; its presets differ in form and in how dark they are.
#[derive(Debug)]
pub(in crate::report) struct FrontStyles {
    styles: Styles,
}

impl FrontStyles {
    pub(in crate::report) fn of(section: &ParetoRecord) -> Self {
        Self { styles: Styles::of_labels(section.points.iter().map(|point| point.tracer.clone())) }
    }

    pub(super) fn get(&self, point: &FrontPoint) -> Style {
        let Style { colour, .. } = self.styles.get(&point.tracer);
        if point.preset == "published" {
            Style { colour, shape: Shape::Circle }
        } else {
            Style { colour: mixed(colour, RGBColor(0, 0, 0), 0.35), shape: Shape::Polygon(4, 0) }
        }
    }
}

/// A colour with a part of another.
fn mixed(RGBColor(r, g, b): RGBColor, RGBColor(to_r, to_g, to_b): RGBColor, part: f64) -> RGBColor {
    let mix = |from: u8, to: u8| (f64::from(from) + (f64::from(to) - f64::from(from)) * part).round() as u8;
    RGBColor(mix(r, to_r), mix(g, to_g), mix(b, to_b))
}

/// What stands behind.
pub(super) fn faint(style: Style) -> Style {
    Style { colour: mixed(style.colour, RGBColor(255, 255, 255), WHITENED), ..style }
}

impl FrontFigure {
    /// Lays out panels over one ray set under one rule.
    pub(in crate::report) fn new(
        record: &Record,
        field: &Field<'_>,
        by: By,
        what: &str,
        panels: Vec<PanelOf<'_>>,
        styles: &FrontStyles,
        columns: usize,
    ) -> Self {
        let mut panels: Vec<Panel> = panels.into_iter().map(|asked| panel(field, by, &asked, styles)).collect();
        let drawn = panels.iter().flat_map(|panel| &panel.marks).map(|mark| mark.y);
        let floor = drawn.filter(|y| *y > 0.0).fold(0.1, f64::min).log10() - 0.25;
        for panel in &mut panels {
            // A little above 100 %, so that markers there are whole.
            panel.ground.y.scale = Scale::Shares((floor, 0.3), 0.0);
        }
        let key = vec![
            Line::new(Sample::Filled(PLAIN), "on the front of all tracers"),
            Line::new(Sample::Hollow(PLAIN), "within noise of it"),
            Line::new(Sample::Filled(faint(PLAIN)), "behind; at full strength and named: the tracer's least wrong"),
            Line::new(Sample::Filled(Style { shape: Shape::Polygon(4, 0), ..PLAIN }), "improved preset"),
            Line::new(Sample::Dashes, "control"),
            Line::new(Sample::Bars, "95 % interval of the error, order-statistic interval of the time"),
        ];
        let configs = field.entries.iter().unique_by(|entry| entry.point.config());
        let line = |entry: &Entry<'_>| Line::new(Sample::Line(styles.get(entry.point)), entry.point.config());
        let legend = configs.map(line).collect();
        let scene = &field.scene.scene;
        let name = cut(&scene.name, LONGEST_NAME);
        let invalid = if verdict::controls(record) == Verdict::Sound { "" } else { "VOID, CONTROLS FAIL: " };
        let rays = format!("{}, {}", cut(field.rays, LONGEST_SET), format::query(field.query));
        let titles = [
            format!("{what}: {name} ({} triangles), {rays}", thousands(scene.triangles)),
            format!(
                "{invalid}viewpoint {}; {} rays; wrong by {}; arrow: fewer than 3 of N rays wrong, drawn at the bound 3/N",
                field.viewpoint.name,
                thousands(field.count),
                by.name()
            ),
        ];
        let clock = "Times by the host's clock, of work on a device from submission until done.";
        let caption = format!("{clock} {}", untimed_caption(&record.provenance, &record.preset));
        let frame = Frame::in_columns(columns, PLOT_HEIGHT, panels.len(), titles, &caption, key, legend);
        Self { frame, panels, floor }
    }
}

fn panel<'a>(field: &Field<'a>, by: By, asked: &PanelOf<'a>, styles: &FrontStyles) -> Panel {
    let mark = |(entry, spot, front_status): (Entry<'a>, CostAndError, FrontStatus)| {
        let wrong = Wrong::of(entry.trace, by)?;
        let x = as_read(field, asked.cost, field.cost(&entry, asked.cost)?);
        Some(Mark {
            index: entry.index,
            tracer: entry.point.tracer.clone(),
            style: styles.get(entry.point),
            x,
            error: wrong.share,
            y: spot.error,
            at_bound: wrong.at_bound(),
            front_status,
            is_best: false,
            name: entry.point.config(),
            cost: spot.cost,
        })
    };
    let mut marks: Vec<Mark> =
        field.front_statuses(&asked.entries, asked.cost, by).into_iter().filter_map(mark).collect();
    let mut own = Vec::new();
    for tracer in field.tracers() {
        let better = |a: &&mut Mark, b: &&mut Mark| a.y.total_cmp(&b.y).then(a.cost.total_cmp(&b.cost));
        if let Some(best) = marks.iter_mut().filter(|mark| mark.tracer == tracer).min_by(better) {
            best.is_best = true;
        }
        let entries: Vec<Entry<'a>> =
            asked.entries.iter().copied().filter(|entry| entry.point.tracer == tracer).collect();
        let Some(first) = entries.first() else { continue };
        let published = FrontPoint { preset: "published".to_owned(), ..first.point.clone() };
        let on: Vec<(f64, f64, f64)> = field
            .front(&entries, asked.cost, by)
            .into_iter()
            .map(|(_, spot)| {
                let read = as_read(field, asked.cost, Amount::exact(spot.cost)).value;
                (spot.cost, read, spot.error)
            })
            .collect();
        own.push((tracer.to_owned(), styles.get(&published).colour, corners(on)));
    }
    let mut controls = Vec::new();
    for (row, trace) in &field.controls {
        controls.extend(Wrong::of(trace, by).map(|wrong| panel::level(row.label(), wrong.drawn())));
    }
    let x_range = log_range(marks.iter().flat_map(|mark| mark.x.interval.into_iter().chain([mark.x.value])));
    let query = if by == By::BalancedAccuracy { Query::Any } else { Query::Closest };
    let ground = panel::Panel {
        title: asked.title.clone(),
        x: Axis { name: cost_name(asked.cost), scale: Scale::Log(x_range, 8) },
        y: Axis { name: error_name(query), scale: Scale::Whole },
        controls,
        marks: Vec::new(),
        note: marks.is_empty().then_some("no point was timed and judged"),
    };
    Panel { ground, marks, cost: asked.cost, own }
}

/// Points of a front (cost, value, height) as places in the order of cost.
fn corners(mut on: Vec<(f64, f64, f64)>) -> Corners {
    on.sort_by(|a, b| a.0.total_cmp(&b.0).then(b.2.total_cmp(&a.2)));
    on.into_iter().map(|(_, value, height)| (value, height)).collect()
}

/// The line round a front on the canvas.
fn line_round(corners: &Corners, [x, y]: [&Along; 2]) -> Vec<(f64, f64)> {
    steps(&corners.iter().map(|(value, height)| (x.at(*value), y.at(*height))).collect::<Vec<_>>())
}

/// The colour of the line of a tracer's own front.
fn own_colour(colour: RGBColor) -> RGBColor {
    mixed(colour, RGBColor(255, 255, 255), 0.3)
}

impl Mark {
    fn place(&self, [x, y]: [&Along; 2]) -> (f64, f64) {
        (x.at(self.x.value), y.at(self.y))
    }
}

impl Panel {
    /// The corners of the front of all.
    fn front(&self) -> Corners {
        let on_front = self.marks.iter().filter(|mark| mark.front_status == FrontStatus::OnFront);
        corners(on_front.map(|mark| (mark.cost, mark.x.value, mark.y)).collect())
    }

    /// The marks as they are drawn: what is behind lies below what is on the front.
    fn in_order(&self) -> Vec<&Mark> {
        let mut order: Vec<&Mark> = self.marks.iter().collect();
        order.sort_by_key(|mark| (std::cmp::Reverse(mark.front_status), mark.is_best));
        order
    }
}

/// The line round what a front has: what is cheaper is not to be had below it, up to the next point.
fn steps(places: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let mut line: Vec<(f64, f64)> = Vec::new();
    for (x, y) in places.iter().copied() {
        if let Some((_, height)) = line.last().copied() {
            line.push((x, height));
        }
        line.push((x, y));
    }
    line
}

impl Figure for FrontFigure {
    fn size(&self) -> (f64, f64) {
        self.frame.size()
    }

    fn draw<DB: DrawingBackend>(&self, canvas: &Canvas<DB>) -> Drawn {
        self.frame.draw(canvas)?;
        for (index, panel) in self.panels.iter().enumerate() {
            panel.ground.draw(canvas, self.frame.panel(index))?;
            self.draw_points(canvas, panel, self.frame.panel(index))?;
        }
        Ok(())
    }
}

impl FrontFigure {
    fn draw_points<DB: DrawingBackend>(&self, canvas: &Canvas<DB>, panel: &Panel, rect: Rect) -> Drawn {
        let [x, y] = panel.ground.axes(rect);
        for (_, colour, corners) in &panel.own {
            canvas.path(&line_round(corners, [&x, &y]), own_colour(*colour), OWN_WIDTH)?;
        }
        canvas.path(&line_round(&panel.front(), [&x, &y]), INK, FRONT_WIDTH)?;
        for mark in panel.in_order() {
            self.draw_mark(canvas, mark, mark.place([&x, &y]), [&x, &y])?;
        }
        for name in self.names(panel, rect) {
            canvas.text(&name.mark.name, name.place, Align::Start, NAME_SIZE, name.mark.style.colour)?;
        }
        Ok(())
    }

    fn draw_mark<DB: DrawingBackend>(
        &self,
        canvas: &Canvas<DB>,
        mark: &Mark,
        place: (f64, f64),
        [x, y]: [&Along; 2],
    ) -> Drawn {
        let (colour, (left, top)) = (mark.style.colour, place);
        if mark.front_status == FrontStatus::OnFront {
            let ends = mark.x.interval.map(|end| x.at(end));
            canvas.path(&[(ends[0], top), (ends[1], top)], colour, 1.0)?;
            let heights = mark.error.interval.map(|share| y.at(share.max(10.0_f64.powf(self.floor))));
            canvas.path(&[(left, heights[0]), (left, heights[1])], colour, 1.0)?;
            for end in heights.into_iter().filter(|end| (end - top).abs() > 2.0 * ON_FRONT) {
                canvas.path(&[(left - CAP, end), (left + CAP, end)], colour, 1.0)?;
            }
        }
        if mark.at_bound {
            let [from, to] = ARROW.map(|end| top + end);
            canvas.path(&[(left, from), (left, to)], colour, 1.0)?;
            canvas.path(&[(left - 2.5, to - 3.0), (left, to), (left + 2.5, to - 3.0)], colour, 1.0)?;
        }
        match mark.front_status {
            FrontStatus::OnFront => canvas.filled_marker(place, ON_FRONT, mark.style),
            FrontStatus::WithinNoise => canvas.hollow_marker(place, HOLLOW, mark.style),
            FrontStatus::Behind if mark.is_best => canvas.filled_marker(place, BEST, mark.style),
            FrontStatus::Behind => canvas.filled_marker(place, FAINT, faint(mark.style)),
        }
    }
}
