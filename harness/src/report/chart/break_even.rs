//! Break-even: what a frame takes by its number of rays. Points of one tracer look alike: numbers tell them apart.

use itertools::Itertools as _;
use plotters::style::RGBColor;

use super::frame::{Chart, Entry as Line, STRONG, Sample};
use super::front::{faint, style_of};
use super::palette::PLAIN;
use super::panel::{Axis, Mark, Panel, Position, Scale};
use super::scale::log_range;
use super::{field_title, fronts_caption};
use crate::report::format::percent;
use crate::studies::pareto::{BEYOND, Class, ClassCost, Entry, Field};

const PLOT_HEIGHT: f64 = 240.0;
const MEASURED: f64 = 3.0;
/// Widths of lines of points that are cheapest somewhere, and of those that never are.
const WIDTHS: [f64; 2] = [1.5, 0.75];
/// Places of a line.
const PLACES: u32 = 64;

/// The chart of who overtakes whom: a panel a class.
pub(in crate::report) fn chart(field: &Field<'_>, classes: &[Class<'_>]) -> Chart {
    let met = classes.iter().flat_map(|class| &class.costs).map(|cost| cost.entry);
    let numbered: Vec<Entry<'_>> = met.unique_by(|entry| entry.index).collect();
    let key = vec![
        Line::new(Sample::Strong(PLAIN), "the cheapest"),
        Line::new(Sample::Line(faint(PLAIN)), "never the cheapest"),
        Line::new(Sample::Filled(PLAIN), "measured"),
        Line::new(Sample::Dashes, "the cheapest is beaten, decided by intervals that do not overlap"),
    ];
    let named = |entry: &Entry<'_>| {
        let label = format!("{}: {}", number(&numbered, entry), entry.point.label());
        Line::new(Sample::Line(style_of(field, entry.point)), label)
    };
    let legends = [numbered.iter().map(named).collect(), key];
    let by = classes.first().map_or("", |class| class.by.name());
    let below = format!("viewpoint {}; points that are right as often, by {by}", field.viewpoint.name);
    let panels = classes.iter().map(|class| panel(class, &numbered)).collect();
    Chart::new(panels, [field_title("Break-even", field), below], fronts_caption(field.record), legends)
        .in_columns(3, PLOT_HEIGHT)
}

/// A point's number, from 1, in the order in which they are met.
fn number(numbered: &[Entry<'_>], entry: &Entry<'_>) -> String {
    let place = numbered.iter().position(|known| known.index == entry.index);
    place.map_or_else(String::new, |place| (place + 1).to_string())
}

/// What a point takes.
struct Curve {
    /// Whether it is never the cheapest.
    is_behind: bool,
    line: Vec<Position>,
    marks: Vec<Mark>,
    /// As dark as the legend has it.
    colour: RGBColor,
}

fn curve(class: &Class<'_>, place: usize, cost: &ClassCost<'_>) -> Curve {
    let rays = || cost.cost.traces.samples.iter().map(|(rays, _)| *rays);
    let least = rays().fold(f64::INFINITY, f64::min) / BEYOND;
    let most = rays().fold(0.0, f64::max) * BEYOND;
    let point = |rays: f64| Some((rays, cost.cost.at(rays).value)).filter(|(_, ms)| *ms > 0.0);
    let between = |least: f64, most: f64| -> Vec<Position> {
        let at = |place: u32| least * (most / least).powf(f64::from(place) / f64::from(PLACES));
        (0..=PLACES).filter_map(|place| point(at(place))).collect()
    };
    let until = |next: usize| class.stretches.get(next).map_or(most, |stretch| stretch.from).min(most);
    // Where it is the cheapest.
    let own = class.stretches.iter().enumerate().filter(|(_, stretch)| stretch.who == place);
    let strong: Vec<Vec<Position>> = own
        .map(|(index, stretch)| (stretch.from.max(least), until(index + 1)))
        .filter(|(from, to)| from < to)
        .map(|(from, to)| between(from, to))
        .collect();
    let (own, is_behind, line) = (style_of(class.field, cost.entry.point), strong.is_empty(), between(least, most));
    let style = if is_behind { faint(own) } else { own };
    let mut marks = vec![Mark::line(&line, style.colour, WIDTHS[usize::from(is_behind)])];
    marks.extend(strong.iter().map(|places| Mark::line(places, style.colour, STRONG)));
    marks.extend(rays().filter_map(point).map(|place| Mark::marker(place, MEASURED, style, false)));
    Curve { is_behind, line, marks, colour: own.colour }
}

fn panel(class: &Class<'_>, numbered: &[Entry<'_>]) -> Panel {
    let overtakes = || class.stretches.iter().filter_map(|stretch| stretch.overtakes.as_ref());
    let of = |(place, cost): (usize, &ClassCost<'_>)| (number(numbered, &cost.entry), curve(class, place, cost));
    let mut curves: Vec<(String, Curve)> = class.costs.iter().enumerate().map(of).collect();
    // Those that are cheapest somewhere lie on top.
    curves.sort_by_key(|(_, curve)| !curve.is_behind);
    let all = || curves.iter().flat_map(|(_, curve)| &curve.line);
    let scales = [log_range(all().map(|(rays, _)| *rays)), log_range(all().map(|(_, ms)| *ms))];
    let [x, y] = scales.map(|range| Scale::Log(range, 6));
    let note = curves.is_empty().then_some("no point is right so often");
    let mut marks: Vec<Mark> = overtakes().filter_map(|found| Some(Mark::Rule(found.at()?.0))).collect();
    let mut names = Vec::new();
    for (name, Curve { line, marks: own, colour, .. }) in curves {
        marks.extend(own);
        names.extend(line.last().map(|end| (*end, name, colour)));
    }
    marks.push(Mark::Names(names));
    let undecided = overtakes().filter(|found| found.at().is_none()).count();
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
        note,
    }
}
