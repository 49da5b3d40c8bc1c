//! Fronts: what points cost against what they get wrong.

mod names;

use std::cmp::Reverse;

use itertools::Itertools as _;
use plotters::style::RGBColor;
use tracebench_api::Query;

use super::canvas::{Align, Canvas};
use super::frame::{Chart, Entry as Line, Rect, Sample};
use super::palette::{INK, PLAIN, Shape, Style, colour};
use super::panel::{Along, Axis, Mark, Panel, Scale, level};
use super::scale::log_range;
use super::{error_name, field_title, fronts_caption, invalid};
use crate::report::format::{significant, thousands};
use crate::report::pareto::{as_read, cost_name, rays_a_pixel};
use crate::report::verdict;
use crate::results::{FrontPoint, Row, TraceRecord};
use crate::studies::pareto::{Amount, By, Cost, Entry, Field, FrontStatus, Standing, Wrong};
pub(in crate::report) use names::Name;
use names::names;

const PLOT_HEIGHT: f64 = 300.0;
/// Radii of points on the front and within noise of it.
pub(in crate::report) const ON_FRONT: f64 = 4.5;
pub(in crate::report) const HOLLOW: f64 = 5.0;
const FAINT: f64 = 2.8;
/// Of a tracer's best point behind the front.
const BEST: f64 = 3.8;
/// How much of a faint colour is white.
const WHITENED: f64 = 0.55;
/// Size of the names beside points.
pub(in crate::report) const NAME_SIZE: f64 = 9.5;
/// Width of the line of the front of all.
pub(in crate::report) const FRONT_WIDTH: f64 = 1.5;
/// Width of the line of a tracer's own front, and of that from a point to its name.
pub(in crate::report) const OWN_WIDTH: f64 = 0.75;
/// From where to where below a point its arrow goes.
const ARROW: [f64; 2] = [6.0, 13.0];
/// Half the length of the caps at the ends of bars.
const CAP: f64 = 2.5;

/// A panel that is asked for: its title, what is along its lower axis, and the points.
type Asked<'a> = (String, Cost, Vec<Entry<'a>>);

/// A line through places.
pub(in crate::report) type Places = Vec<(f64, f64)>;

/// A corner of a front: cost, cost as people read it, and height.
type Corner = (f64, f64, f64);

/// A point.
#[derive(Clone, Debug)]
pub(in crate::report) struct Point {
    /// Its place among the record's points.
    pub index: usize,
    pub tracer: String,
    style: Style,
    /// What it costs as people read it.
    pub x: Amount,
    error: Amount,
    /// The height at which it is drawn.
    pub y: f64,
    at_bound: bool,
    /// How it stands.
    pub front_status: FrontStatus,
    /// Whether no point of its tracer is wrong less often, nor as often and cheaper.
    pub is_best: bool,
    /// What it is called.
    pub name: String,
    /// By how much points are distinguished.
    pub cost: f64,
}

/// The points of a panel.
#[derive(Clone, Debug)]
pub(super) struct Points {
    all: Vec<Point>,
    /// What is along the lower axis.
    cost: Cost,
    /// Each tracer's own front, with its name and colour.
    own: Vec<(String, RGBColor, Vec<Corner>)>,
}

/// What a panel shows of points.
pub(in crate::report) struct Layer<'a> {
    /// The line of each tracer's own front, with its name and colour.
    pub own: Vec<(&'a str, RGBColor, Places)>,
    /// That of the front of all.
    pub front: Places,
    /// The points, those on the front last.
    pub points: Vec<Placed<'a>>,
    pub names: Vec<Name<'a>>,
}

/// A point in its place.
pub(in crate::report) struct Placed<'a> {
    pub point: &'a Point,
    /// Where it is.
    pub place: (f64, f64),
    /// The bars of its intervals, round its place.
    pub bars: Vec<Places>,
    /// The arrow below it if it is drawn at the bound, round its place.
    pub arrow: Vec<Places>,
}

/// A colour of its own for every tracer of a field's record.
fn colour_of(field: &Field<'_>, tracer: &str) -> RGBColor {
    let mut tracers = field.section.points.iter().map(|point| &point.tracer).unique();
    colour(tracers.position(|other| other == tracer).unwrap_or(0))
}

/// A tracer's presets differ in form and in how dark they are.
pub(super) fn style_of(field: &Field<'_>, point: &FrontPoint) -> Style {
    let colour = colour_of(field, &point.tracer);
    if point.preset == "published" {
        Style { colour, shape: Shape::Circle }
    } else {
        Style { colour: mixed(colour, RGBColor(0, 0, 0), 0.35), shape: Shape::Polygon(4, 0) }
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

/// The fronts of the costs that are wanted over one ray set by one rule.
pub(in crate::report) fn fronts(field: &Field<'_>, by: By, is_wanted: impl Fn(Cost) -> bool) -> Chart {
    let title = |cost: Cost| match cost {
        Cost::Trace => "speed".to_owned(),
        Cost::Build => "first build".to_owned(),
        Cost::Bytes => "bytes to trace".to_owned(),
        Cost::Frame(rays) => format!("frame of {}", rays_a_pixel(rays)),
    };
    let costs = Cost::all(&field.section.rays_per_pixel).into_iter().filter(|cost| is_wanted(*cost));
    let asked: Vec<Asked<'_>> = costs.map(|cost| (title(cost), cost, field.entries.clone())).collect();
    let columns = if asked.len() > 4 { 3 } else { asked.len().min(2) };
    chart(field, by, "Fronts", asked).in_columns(columns, PLOT_HEIGHT)
}

/// Those of speed over the points within budgets, the least first: at matched bytes and first build, where there are any.
pub(in crate::report) fn matched(field: &Field<'_>, by: By) -> Option<Chart> {
    let within = |cost: Cost, budget: f64| {
        let read = significant(as_read(field, cost, Amount::exact(budget)).value, 2);
        let title = match cost {
            Cost::Bytes => format!("speed within {read} MiB"),
            _ => format!("speed within a first build of {read} ms"),
        };
        (title, Cost::Trace, field.within(cost, budget))
    };
    let of_cost = |cost| field.budgets(cost).into_iter().map(move |budget| within(cost, budget));
    let asked: Vec<Asked<'_>> = [Cost::Bytes, Cost::Build].into_iter().flat_map(of_cost).collect();
    let what = "Fronts at matched bytes and first build";
    (!asked.is_empty()).then(|| chart(field, by, what, asked).in_columns(3, PLOT_HEIGHT))
}

/// Panels over one ray set under one rule.
fn chart(field: &Field<'_>, by: By, what: &str, asked: Vec<Asked<'_>>) -> Chart {
    let points: Vec<Points> = asked.iter().map(|(_, cost, all)| Points::of(field, by, *cost, all)).collect();
    let drawn = points.iter().flat_map(|points| &points.all).map(|point| point.y);
    // The decimal logarithm of the least error that is shown.
    let floor = drawn.filter(|y| *y > 0.0).fold(0.1, f64::min).log10() - 0.25;
    let panels = asked.into_iter().zip(points).map(|((title, ..), points)| panel(field, by, title, points, floor));
    let key = vec![
        Line::new(Sample::Filled(PLAIN), "on the front of all tracers"),
        Line::new(Sample::Hollow(PLAIN), "within noise of it"),
        Line::new(Sample::Filled(faint(PLAIN)), "behind; at full strength and named: the tracer's least wrong"),
        Line::new(Sample::Filled(Style { shape: Shape::Polygon(4, 0), ..PLAIN }), "improved preset"),
        Line::new(Sample::Dashes, "control"),
        Line::new(Sample::Bars, "95 % interval of the error, order-statistic interval of the time"),
    ];
    let configs = field.entries.iter().unique_by(|entry| entry.point.config());
    let line = |entry: &Entry<'_>| Line::new(Sample::Line(style_of(field, entry.point)), entry.point.config());
    let below = format!(
        "{}viewpoint {}; {} rays; wrong by {}; arrow: fewer than 3 of N rays wrong, drawn at the bound 3/N",
        invalid(&verdict::controls(field.record)),
        field.viewpoint.name,
        thousands(field.count),
        by.name()
    );
    let legends = [configs.map(line).collect(), key];
    Chart::new(panels.collect(), [field_title(what, field), below], fronts_caption(field.record), legends)
}

fn panel(field: &Field<'_>, by: By, title: String, points: Points, floor: f64) -> Panel {
    let control = |(row, trace): &(&Row, &TraceRecord)| Some(level(row.label(), Wrong::of(trace, by)?.drawn()));
    let all = &points.all;
    let x_range = log_range(all.iter().flat_map(|point| point.x.interval.into_iter().chain([point.x.value])));
    let query = if by == By::BalancedAccuracy { Query::Any } else { Query::Closest };
    Panel {
        title,
        x: Axis { name: cost_name(points.cost), scale: Scale::Log(x_range, 8) },
        // A little above 100 %, so that markers there are whole.
        y: Axis { name: error_name(query), scale: Scale::Shares((floor, 0.3), 0.0) },
        controls: field.controls.iter().filter_map(control).collect(),
        note: all.is_empty().then_some("no point was timed and judged"),
        marks: vec![Mark::Points(points)],
    }
}

/// The line round a front on the canvas, in the order of cost: what is cheaper is not to be had below it, up to the next point.
fn line_round(mut corners: Vec<Corner>, [x, y]: [&Along<'_>; 2]) -> Places {
    corners.sort_by(|a, b| a.0.total_cmp(&b.0).then(b.2.total_cmp(&a.2)));
    let mut line = Places::new();
    for (left, top) in corners.into_iter().map(|(_, value, height)| (x.at(value), y.at(height))) {
        line.extend(line.last().map(|(_, height)| (left, *height)));
        line.push((left, top));
    }
    line
}

impl Point {
    /// Its colour, and its outline round its place; of a circle none.
    pub(in crate::report) fn look(&self) -> (RGBColor, Option<Places>) {
        let Style { colour, shape } = self.style;
        (colour, (shape != Shape::Circle).then(|| shape.corners(ON_FRONT)))
    }

    fn placed(&self, [x, y]: [&Along<'_>; 2]) -> Placed<'_> {
        let place = (x.at(self.x.value), y.at(self.y));
        let across = self.x.interval.map(|end| x.at(end) - place.0);
        let up = self.error.interval.map(|share| y.at(share) - place.1);
        let mut bars = vec![vec![(across[0], 0.0), (across[1], 0.0)], vec![(0.0, up[0]), (0.0, up[1])]];
        let far = up.into_iter().filter(|end| end.abs() > 2.0 * ON_FRONT);
        bars.extend(far.map(|end| vec![(-CAP, end), (CAP, end)]));
        let [from, to] = ARROW;
        let arrow = [vec![(0.0, from), (0.0, to)], vec![(-CAP, to - 3.0), (0.0, to), (CAP, to - 3.0)]];
        Placed { point: self, place, bars, arrow: if self.at_bound { arrow.into() } else { Vec::new() } }
    }
}

impl Points {
    fn of<'a>(field: &Field<'a>, by: By, cost: Cost, entries: &[Entry<'a>]) -> Self {
        let point = |(entry, spot, front_status): Standing<'a>| {
            let wrong = Wrong::of(entry.trace, by)?;
            Some(Point {
                index: entry.index,
                tracer: entry.point.tracer.clone(),
                style: style_of(field, entry.point),
                x: as_read(field, cost, field.cost(&entry, cost)?),
                error: wrong.share,
                y: spot.error,
                at_bound: wrong.at_bound(),
                front_status,
                is_best: false,
                name: entry.point.config(),
                cost: spot.cost,
            })
        };
        let read = |value: f64| as_read(field, cost, Amount::exact(value)).value;
        let corner = |(_, spot, _): Standing<'a>| (spot.cost, read(spot.cost), spot.error);
        let own = |tracer: &str| {
            let entries: Vec<Entry<'a>> = entries.iter().copied().filter(|each| each.point.tracer == tracer).collect();
            entries.first()?;
            let mut front = field.front_statuses(&entries, cost, by);
            front.retain(|(.., front_status)| *front_status == FrontStatus::OnFront);
            Some((tracer.to_owned(), colour_of(field, tracer), front.into_iter().map(corner).collect()))
        };
        let mut all: Vec<Point> = field.front_statuses(entries, cost, by).into_iter().filter_map(point).collect();
        for tracer in field.tracers() {
            let better = |a: &&mut Point, b: &&mut Point| a.y.total_cmp(&b.y).then(a.cost.total_cmp(&b.cost));
            let best = all.iter_mut().filter(|point| point.tracer == tracer).min_by(better);
            best.into_iter().for_each(|best| best.is_best = true);
        }
        Self { all, cost, own: field.tracers().into_iter().filter_map(own).collect() }
    }

    /// What a panel shows of them.
    pub(super) fn layer(&self, panel: &Panel, rect: Rect) -> Layer<'_> {
        let [x, y] = &panel.axes(rect);
        let own = self.own.iter();
        let own = own.map(|(tracer, colour, corners)| (&**tracer, *colour, line_round(corners.clone(), [x, y])));
        let on_front = self.all.iter().filter(|point| point.front_status == FrontStatus::OnFront);
        let front = line_round(on_front.map(|point| (point.cost, point.x.value, point.y)).collect(), [x, y]);
        let mut points: Vec<Placed<'_>> = self.all.iter().map(|point| point.placed([x, y])).collect();
        let names = names(panel, rect, &front, &points);
        points.sort_by_key(|Placed { point, .. }| (Reverse(point.front_status), point.is_best));
        Layer { own: own.collect(), front, points, names }
    }
}

impl Chart {
    /// What its panels show of points, with what is along their lower axes.
    pub(in crate::report) fn layers(&self) -> impl Iterator<Item = (Cost, Layer<'_>)> {
        self.panels.iter().enumerate().flat_map(move |(index, panel)| {
            panel.marks.iter().filter_map(move |mark| match mark {
                Mark::Points(points) => Some((points.cost, points.layer(panel, self.rect(index)))),
                _ => None,
            })
        })
    }

    /// Everything but its points, as SVG.
    pub(in crate::report) fn ground(mut self) -> String {
        self.panels.iter_mut().for_each(|panel| panel.marks.clear());
        self.svg()
    }
}

/// Draws what a panel shows of points.
pub(super) fn draw(canvas: &mut Canvas, Layer { own, front, points, names }: Layer<'_>) {
    for (_, colour, line) in &own {
        canvas.path(line, mixed(*colour, RGBColor(255, 255, 255), 0.3), OWN_WIDTH);
    }
    canvas.path(&front, INK, FRONT_WIDTH);
    for Placed { point: Point { front_status, is_best, style, .. }, place, bars, arrow } in points {
        let bars = if *front_status == FrontStatus::OnFront { bars } else { Vec::new() };
        for line in bars.into_iter().chain(arrow) {
            let line: Places = line.iter().map(|(x, y)| (place.0 + x, place.1 + y)).collect();
            canvas.path(&line, style.colour, 1.0);
        }
        match front_status {
            FrontStatus::OnFront => canvas.filled_marker(place, ON_FRONT, *style),
            FrontStatus::WithinNoise => canvas.hollow_marker(place, HOLLOW, *style),
            FrontStatus::Behind if *is_best => canvas.filled_marker(place, BEST, *style),
            FrontStatus::Behind => canvas.filled_marker(place, FAINT, faint(*style)),
        }
    }
    for Name { point, place, leader } in names {
        canvas.path(&leader, point.style.colour, OWN_WIDTH);
        canvas.text(&point.name, place, Align::Left, NAME_SIZE, point.style.colour);
    }
}
