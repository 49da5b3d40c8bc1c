//! Break-even: what a frame takes by its number of rays. Points of one tracer look alike: numbers tell them apart.

use itertools::Itertools as _;
use plotters::style::RGBColor;

use super::axis::log_range;
use super::frame::{Entry as Line, Frame, STRONG, Sample};
use super::front::{FrontStyles, faint};
use super::palette::{PLAIN, Style};
use super::panel::{Aside, Axis, Chart, Mark, Panel, Position, Scale};
use super::{LONGEST_NAME, LONGEST_SET, cut, untimed_caption};
use crate::report::format::{self, percent, thousands};
use crate::results::{ParetoRecord, Record};
use crate::studies::pareto::{BEYOND, BreakEven, Class, ClassCost, Entry, Field};

const PLOT_HEIGHT: f64 = 240.0;
const MEASURED: f64 = 3.0;
/// Widths of lines of points that are cheapest somewhere, and of those that never are.
const WIDTHS: [f64; 2] = [1.5, 0.75];
/// Places of a line.
const PLACES: u32 = 64;

/// Numbers of points, from 1, in the order in which they are met.
struct Numbers<'a>(Vec<Entry<'a>>);

impl<'a> Numbers<'a> {
    fn of(classes: &[Class<'a>]) -> Self {
        let met = classes.iter().flat_map(|class| &class.costs).map(|cost| cost.entry);
        Self(met.unique_by(|entry| entry.index).collect())
    }

    fn get(&self, entry: &Entry<'_>) -> String {
        let place = self.0.iter().position(|known| known.index == entry.index);
        place.map_or_else(String::new, |place| (place + 1).to_string())
    }
}

/// The chart of who overtakes whom: a panel a class.
pub(in crate::report) fn chart(
    record: &Record,
    section: &ParetoRecord,
    field: &Field<'_>,
    classes: &[Class<'_>],
) -> Chart {
    let styles = &FrontStyles::of(section);
    let numbers = Numbers::of(classes);
    let panels: Vec<Panel> = classes.iter().map(|class| panel(class, styles, &numbers)).collect();
    let key = vec![
        Line::new(Sample::Strong(PLAIN), "the cheapest"),
        Line::new(Sample::Line(faint(PLAIN)), "never the cheapest"),
        Line::new(Sample::Filled(PLAIN), "measured"),
        Line::new(Sample::Dashes, "the cheapest is beaten, decided by intervals that do not overlap"),
    ];
    let named = |entry: &Entry<'_>| Line {
        sample: Sample::Line(styles.get(entry.point)),
        label: format!("{}: {}", numbers.get(entry), entry.point.label()),
    };
    let legend: Vec<Line> = numbers.0.iter().map(named).collect();
    let scene = &field.scene.scene;
    let rays = format!("{}, {}", cut(field.rays, LONGEST_SET), format::query(field.query));
    let by = classes.first().map_or("", |class| class.by.name());
    let titles = [
        format!("Break-even: {} ({} triangles), {rays}", cut(&scene.name, LONGEST_NAME), thousands(scene.triangles)),
        format!("viewpoint {}; points that are right as often, by {by}", field.viewpoint.name),
    ];
    let clock = "Times by the host's clock, of work on a device from submission until done.";
    let caption = format!("{clock} {}", untimed_caption(&record.provenance, &record.preset));
    let frame = Frame::in_columns(3, PLOT_HEIGHT, panels.len(), titles, &caption, key, legend);
    Chart { frame, panels }
}

/// What a point takes.
struct Curve {
    style: Style,
    /// Whether it is never the cheapest.
    is_behind: bool,
    line: Vec<Position>,
    measured: Vec<Position>,
    /// Where it is the cheapest.
    strong: Vec<Vec<Position>>,
    /// What it is called beside its end, as dark as the legend has it.
    name: (String, RGBColor),
}

fn curve(class: &Class<'_>, place: usize, cost: &ClassCost<'_>, styles: &FrontStyles, numbers: &Numbers<'_>) -> Curve {
    let rays = || cost.cost.traces.samples.iter().map(|(rays, _)| *rays);
    let least = rays().fold(f64::INFINITY, f64::min) / BEYOND;
    let most = rays().fold(0.0, f64::max) * BEYOND;
    let point = |rays: f64| (rays, cost.cost.at(rays).value);
    let drawn = |all: Vec<Position>| -> Vec<Position> { all.into_iter().filter(|(_, ms)| *ms > 0.0).collect() };
    let between = |least: f64, most: f64| {
        let at = |place: u32| least * (most / least).powf(f64::from(place) / f64::from(PLACES));
        drawn((0..=PLACES).map(|place| point(at(place))).collect())
    };
    let until = |next: usize| class.stretches.get(next).map_or(most, |stretch| stretch.from).min(most);
    let own = class.stretches.iter().enumerate().filter(|(_, stretch)| stretch.who == place);
    let strong: Vec<Vec<Position>> = own
        .map(|(index, stretch)| (stretch.from.max(least), until(index + 1)))
        .filter(|(from, to)| from < to)
        .map(|(from, to)| between(from, to))
        .collect();
    let style = styles.get(cost.entry.point);
    Curve {
        style: if strong.is_empty() { faint(style) } else { style },
        is_behind: strong.is_empty(),
        line: between(least, most),
        measured: drawn(rays().map(point).collect()),
        strong,
        name: (numbers.get(&cost.entry), style.colour),
    }
}

fn panel(class: &Class<'_>, styles: &FrontStyles, numbers: &Numbers<'_>) -> Panel {
    let decided = |overtakes: &BreakEven| match overtakes {
        BreakEven::At { rays, .. } => Some(*rays),
        BreakEven::Always(_) | BreakEven::Undecided(_) => None,
    };
    let overtakes: Vec<&BreakEven> = class.stretches.iter().filter_map(|stretch| stretch.overtakes.as_ref()).collect();
    let of = |(place, cost): (usize, &ClassCost<'_>)| curve(class, place, cost, styles, numbers);
    let mut curves: Vec<Curve> = class.costs.iter().enumerate().map(of).collect();
    // Those that are cheapest somewhere lie on top.
    curves.sort_by_key(|curve| !curve.is_behind);
    let all = || curves.iter().flat_map(|curve| &curve.line);
    let scales = [log_range(all().map(|(rays, _)| *rays)), log_range(all().map(|(_, ms)| *ms))];
    let [x, y] = scales.map(|range| Scale::Log(range, 6));
    let aside = Aside::default();
    let line = |places: &[Position], colour, width| Mark::Line {
        places: places.to_vec(),
        colour,
        width,
        dashed: false,
        aside,
    };
    let mut marks: Vec<Mark> = overtakes.iter().filter_map(|found| decided(found)).map(Mark::Rule).collect();
    for Curve { style, is_behind, line: places, measured, strong, .. } in &curves {
        marks.push(line(places, style.colour, WIDTHS[usize::from(*is_behind)]));
        marks.extend(strong.iter().map(|places| line(places, style.colour, STRONG)));
        let marker =
            |place: &Position| Mark::Marker { place: *place, radius: MEASURED, style: *style, hollow: false, aside };
        marks.extend(measured.iter().map(marker));
    }
    let name = |Curve { line, name: (name, colour), .. }: &Curve| Some((*line.last()?, name.clone(), *colour));
    marks.push(Mark::Names(curves.iter().filter_map(name).collect()));
    let undecided = overtakes.iter().filter(|found| decided(found).is_none()).count();
    if undecided > 0 {
        let changes = if undecided == 1 { "change" } else { "changes" };
        marks.push(Mark::Words(format!("{undecided} {changes} undecided")));
    }
    Panel {
        title: format!("{}, at least {} % right", class.motion.name(), percent(class.level, 10_000)),
        x: Axis { name: "rays a frame".to_owned(), scale: x },
        y: Axis { name: "frame (ms)".to_owned(), scale: y },
        controls: Vec::new(),
        marks,
        note: curves.is_empty().then_some("no point is right so often"),
    }
}
