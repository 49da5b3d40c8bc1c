//! Fronts, operating points and break-even: charts with points that can be asked, and the tables of their pages.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use itertools::Itertools as _;

use super::Place;
use super::pieces::{Piece, Rank, Tags, escape};
use super::read::Names;
use super::write::{figure, plain_html};
use crate::report::chart::front::{
    self, FRONT_WIDTH, HOLLOW, Layer, NAME_SIZE, Name, ON_FRONT, OWN_WIDTH, Placed, Places, Point,
};
use crate::report::chart::{Chart, SCALE, hex};
use crate::report::document::Document;
use crate::report::format::{significant, size, with_interval};
use crate::report::metrics;
use crate::report::pareto::{cost_name, page};
use crate::results::said as said_value;
use crate::studies::pareto::{By, Cost, FrontStatus, Wrong};

/// Charts of fronts, with who is on them.
pub(super) fn fronts(places: &[Place<'_>], names: &Names) -> Vec<Piece> {
    let mut pieces = Vec::new();
    for place in places {
        let chart = |of_speed| front::fronts(place.field, place.by, |cost| (cost == Cost::Trace) == of_speed);
        pieces.push(place.piece(Rank::Front, "fronts", with_points(place, chart(true))));
        pieces.push(place.piece(Rank::Front, "fronts of other costs", with_points(place, chart(false))));
        let on_fronts = by_rule(place, |by| page::front_points(place.field, by));
        pieces.push(opened(Rank::Full, place, ["points on fronts", "Points on fronts: "], &on_fronts, names));
    }
    let of_record = |place: &Place<'_>| Piece::fixed(points(place));
    pieces.extend(places.iter().unique_by(|place| place.number).map(of_record));
    pieces
}

/// Operating points, and how far every tracer gets.
pub(super) fn operating_points(places: &[Place<'_>], names: &Names) -> Vec<Piece> {
    let piece = |place: &Place<'_>| {
        let points = |by| page::operating_points(place.field, by).and(page::reach(place.field, by));
        opened(Rank::Page, place, ["operating points", ""], &by_rule(place, points), names)
    };
    places.iter().map(piece).collect()
}

/// Who overtakes whom.
pub(super) fn break_even(places: &[Place<'_>], names: &Names) -> Vec<Piece> {
    let mut pieces = Vec::new();
    for place in places {
        // The chart stands above.
        let text = page::break_even(place.field, place.by, String::new());
        let Some((_, chart)) = text.charts().next() else { continue };
        let (title, machine) = (place.title(), place.read.label());
        let alt = format!("Time of a frame over its number of rays, by tracer: {title}");
        let caption = format!("{title}. Time of a frame (ms) over rays a frame, of every tracer. {machine}.");
        let chart = figure(&chart.svg(), &alt, &caption, place.tags());
        pieces.push(place.piece(Rank::Chart, "break-even chart", chart));
        pieces.push(opened(Rank::Page, place, ["break-even", ""], &text, names));
    }
    pieces
}

/// What is told of a place by every rule.
fn by_rule(place: &Place<'_>, of: impl Fn(By) -> Document) -> Document {
    let rule = |by: &By| Document::default().heading(3, format!("By {}", by.name())).and(of(*by));
    Document::default().and(By::all(place.field.query).iter().map(rule))
}

/// What is told of a place, as a part that opens; what stands before the place's title where it is told of, and there.
fn opened(rank: Rank, place: &Place<'_>, [what, title]: [&str; 2], text: &Document, names: &Names) -> Piece {
    let title = format!("{title}{}", place.title());
    place.piece(rank, what, details(&title, &place.tags().text(), &plain_html(text, 2, names)))
}

/// A part that opens.
pub(super) fn details(title: &str, tags: &str, html: &str) -> String {
    format!("<details{tags}><summary>{}</summary>{html}</details>\n", escape(title))
}

/// Every point of a record with all of its parameters.
fn points(place: &Place<'_>) -> String {
    let mut rows = String::new();
    for (index, point) in place.field.section.points.iter().enumerate() {
        let parameters = point.parameters.iter().map(|(name, value)| format!("{name}={}", said_value(value))).join(" ");
        let (id, tags, label) = (id(place, index), Tags::of_tracer(&point.tracer).text(), escape(&point.label()));
        let (parameters, size) = (escape(&parameters), format!("{}, {}", size(point.frame), point.face));
        let _ = writeln!(rows, "<tr id=\"{id}\"{tags}><td>{label}</td><td>{parameters}</td><td>{size}</td></tr>");
    }
    let table = format!(
        "<div class=\"wide\" tabindex=\"0\"><table><thead><tr><th scope=\"col\">point</th><th scope=\"col\">parameters</th>\
         <th scope=\"col\">frame, faces (px)</th></tr></thead><tbody>\n{rows}</tbody></table></div>"
    );
    details(&format!("Points of {} with all parameters", place.read.name), "", &table)
}

fn id(place: &Place<'_>, index: usize) -> String {
    format!("r{}p{index}", place.number)
}

/// A chart with its points on top.
fn with_points(place: &Place<'_>, chart: Chart) -> String {
    let mut marks = format!(
        "<g class=\"points\" transform=\"scale({SCALE})\" \
         style=\"--front:{FRONT_WIDTH};--own:{OWN_WIDTH};--name:{NAME_SIZE}px;--hollow:{}\">\n",
        HOLLOW / ON_FRONT
    );
    for (cost, Layer { own, front, points, names }) in chart.layers() {
        let costs: Vec<_> = place.field.unsurely_beaten(&place.field.entries, cost, place.by);
        let beaten: BTreeMap<usize, Vec<usize>> = costs.into_iter().collect();
        let _ = writeln!(marks, "<g class=\"panel\" role=\"group\" aria-label=\"{}\">", escape(&cost_name(cost)));
        for (tracer, colour, line) in own {
            let (tags, colour) = (Tags::of_tracer(tracer).text(), hex(colour));
            let _ = writeln!(marks, "<path class=\"own\"{tags} stroke=\"{colour}\" d=\"{}\"/>", path(&line));
        }
        let _ = writeln!(marks, "<path class=\"line\" d=\"{}\"/>", path(&front));
        for (index, placed) in points.iter().enumerate() {
            marks += &mark(place, placed, cost, index == 0, beaten.get(&placed.point.index));
        }
        for Name { point, place: (left, top), leader } in names {
            let (tags, colour) = (Tags::of_tracer(&point.tracer).text(), hex(point.look().0));
            let (name, line) = (escape(&point.name), path(&leader));
            let _ = writeln!(marks, "<path class=\"own\"{tags} stroke=\"{colour}\" d=\"{line}\"/>");
            let _ = writeln!(marks, "<text{tags} x=\"{left:.1}\" y=\"{top:.1}\" fill=\"{colour}\">{name}</text>");
        }
        marks.push_str("</g>\n");
    }
    marks.push_str("</g>\n</svg>");
    // On top of everything that is drawn.
    let ground = chart.ground();
    let svg = ground.trim_end().strip_suffix("</svg>").unwrap_or(&ground).to_owned() + &marks;
    let (title, by, machine) = (place.title(), place.by.name(), place.read.label());
    let alt = format!("Fronts of {title}: what points cost against what they get wrong");
    let caption = format!(
        "{title}. Wrong rays (%) by {by} over cost. Points tell their parameters when they are pointed at or have the focus (arrow keys). \
         {machine}."
    );
    figure(&svg, &alt, &caption, place.tags()).replacen("role=\"img\"", "role=\"group\"", 1)
}

/// A line through places as the path of an SVG.
fn path(places: &Places) -> String {
    let short = |length: f64| (length * 100.0).round() / 100.0;
    let step = |(index, (x, y)): (usize, &(f64, f64))| {
        format!("{}{} {}", if index == 0 { "M" } else { "L" }, short(*x), short(*y))
    };
    places.iter().enumerate().map(step).collect()
}

/// What a point is and does, in words.
fn said(place: &Place<'_>, point: &Point, cost: Cost) -> String {
    let entry = place.field.entries.iter().find(|entry| entry.index == point.index);
    let label = place.field.section.points[point.index].label();
    let wrong = entry.and_then(|entry| Some((Wrong::of(entry.trace, place.by)?, metrics::trials(entry.trace))));
    let right = wrong.map_or_else(String::new, |(wrong, trials)| format!("; right {}", page::right(&wrong, trials)));
    let read = match cost {
        Cost::Bytes => significant(point.x.value, 4),
        _ => with_interval(point.x.value, point.x.interval, 4),
    };
    format!("{label}; {} {read}{right}", cost_name(cost))
}

fn mark(place: &Place<'_>, placed: &Placed<'_>, cost: Cost, first: bool, beaten: Option<&Vec<usize>>) -> String {
    let Placed { point, place: (left, top), bars, arrow } = placed;
    let front_status = match point.front_status {
        FrontStatus::OnFront => "front",
        FrontStatus::WithinNoise => "noise",
        FrontStatus::Behind => "behind",
    };
    let best = if point.is_best { " best" } else { "" };
    let near = beaten
        .filter(|near| !near.is_empty())
        .map_or_else(String::new, |near| format!(" data-near=\"{}\"", near.iter().join(" ")));
    let (colour, outline) = point.look();
    let dot = match outline {
        Some(line) => format!("<path class=\"dot\" d=\"{}z\"/>", path(&line)),
        None => format!("<circle class=\"dot\" r=\"{ON_FRONT}\"/>"),
    };
    let [bars, arrow] = [bars, arrow].map(|lines| lines.iter().map(path).collect::<String>());
    let arrow = if arrow.is_empty() { arrow } else { format!("<path class=\"arrow\" d=\"{arrow}\"/>") };
    let (tags, index, colour) = (Tags::of_tracer(&point.tracer).text(), point.index, hex(colour));
    let (id, said, order) = (id(place, index), escape(&said(place, point, cost)), if first { 0 } else { -1 });
    let data = format!("data-index=\"{index}\" data-cost=\"{}\" data-error=\"{}\"", point.cost, point.y);
    format!(
        "<g class=\"mark {front_status}{best}\"{tags} data-point=\"{id}\" {data}{near} tabindex=\"{order}\" role=\"img\" \
         aria-label=\"{said}\" color=\"{colour}\" transform=\"translate({left:.2} {top:.2})\"><path class=\"bars\" d=\"{bars}\"/>\
         {arrow}{dot}</g>\n"
    )
}
