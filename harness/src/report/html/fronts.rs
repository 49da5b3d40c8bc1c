//! Fronts, operating points and break-even: charts with points that can be asked, and the tables of their pages.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use super::Place;
use super::pieces::{Piece, Rank, Tags, escape};
use super::read::Names;
use super::write::{figure, plain_html};
use crate::report::chart::{self, FrontLayers, PointMark};
use crate::report::document::Document;
use crate::report::format::with_interval;
use crate::report::pareto::page;
use crate::report::{ReportError, metrics};
use crate::results::{self, FrontPoint};
use crate::studies::pareto::{By, Cost, FrontStatus, Wrong};

/// Charts of fronts, with who is on them.
pub(super) fn fronts(places: &[Place<'_>], machines: &[String], names: &Names) -> Result<Vec<Piece>, ReportError> {
    let mut pieces = Vec::new();
    for place in places {
        let figure = chart::fronts(&place.read.record, place.section, place.field, place.by);
        let layers = figure.layers().map_err(|error| chart::made("fronts", &error))?;
        pieces.push(Piece::Heavy {
            rank: Rank::Front,
            what: format!("fronts of {}", place.title()),
            html: front(place, &layers, &machines[place.read.machine - 1]),
            tags: place.tags().text(),
        });
        let on_fronts = by_rule(place, |by| page::front_points(&place.read.record, place.section, place.field, by));
        pieces.push(opened(Rank::Full, place, ["points on fronts", "Points on fronts: "], &on_fronts, names));
    }
    for (index, place) in places.iter().enumerate() {
        if places[..index].iter().all(|known| !std::ptr::eq(known.read, place.read)) {
            pieces.push(Piece::Fixed(points(place)));
        }
    }
    Ok(pieces)
}

/// Operating points, and how far every tracer gets.
pub(super) fn operating_points(places: &[Place<'_>], names: &Names) -> Vec<Piece> {
    let piece = |place: &Place<'_>| {
        let points = |by| page::operating_points(place.shown, place.field, by).and(page::reach(place.field, by));
        opened(Rank::Page, place, ["operating points", ""], &by_rule(place, points), names)
    };
    places.iter().map(piece).collect()
}

/// Who overtakes whom.
pub(super) fn break_even(places: &[Place<'_>], machines: &[String], names: &Names) -> Result<Vec<Piece>, ReportError> {
    let mut pieces = Vec::new();
    for place in places {
        let machine = &machines[place.read.machine - 1];
        // The chart stands above.
        let text = page::break_even(&place.read.record, place.section, place.shown, place.field, place.by);
        let Some((_, drawing)) = text.charts().next() else { continue };
        let svg = drawing.svg().map_err(|error| chart::made("break-even", &error))?;
        let alt = format!("Time of a frame over its number of rays, by tracer: {}", place.title());
        let caption = format!("{}. Time of a frame (ms) over rays a frame, of every tracer. {machine}.", place.title());
        pieces.push(Piece::Heavy {
            rank: Rank::Chart,
            what: format!("break-even chart of {}", place.title()),
            html: figure(&svg, &alt, &caption, place.tags()),
            tags: place.tags().text(),
        });
        pieces.push(opened(Rank::Page, place, ["break-even", ""], &text, names));
    }
    Ok(pieces)
}

/// What is told of a place by every rule.
fn by_rule(place: &Place<'_>, of: impl Fn(By) -> Document) -> Document {
    let rule = |by: &By| Document::default().heading(3, format!("By {}", by.name())).and(of(*by));
    Document::default().and(By::all(place.field.query).iter().map(rule))
}

/// What is told of a place, as a part that opens; what stands before the place's title where it is told of, and there.
fn opened(rank: Rank, place: &Place<'_>, [what, title]: [&str; 2], text: &Document, names: &Names) -> Piece {
    let (of, tags) = (place.title(), place.tags().text());
    let html = details(&format!("{title}{of}"), &tags, &plain_html(text, 2, names));
    Piece::Heavy { rank, what: format!("{what} of {of}"), html, tags }
}

/// A part that opens.
pub(super) fn details(title: &str, tags: &str, html: &str) -> String {
    format!("<details{tags}><summary>{}</summary>{html}</details>\n", escape(title))
}

/// Every point of a record with all of its parameters.
fn points(place: &Place<'_>) -> String {
    let mut rows = String::new();
    for (index, point) in place.section.points.iter().enumerate() {
        let _ = writeln!(
            rows,
            "<tr id=\"{}\"{}><td>{}</td><td>{}</td><td>{}×{}, {}</td></tr>",
            id(place, index),
            Tags { tracer: Some(&point.tracer), ..Tags::default() }.text(),
            escape(&point.label()),
            escape(&parameters(point)),
            point.frame[0],
            point.frame[1],
            point.face,
        );
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

fn parameters(point: &FrontPoint) -> String {
    let all: Vec<String> =
        point.parameters.iter().map(|(name, value)| format!("{name}={}", results::said(value))).collect();
    all.join(" ")
}

/// A chart with its points on top.
fn front(place: &Place<'_>, layers: &FrontLayers, machine: &str) -> String {
    let FrontLayers { ground, scale, widths: [front, own], radii: [on_front, hollow], name_size, panels } = layers;
    let mut marks = format!(
        "<g class=\"points\" transform=\"scale({scale})\" style=\"--front:{front};--own:{own};--name:{name_size}px;--hollow:{}\">\n",
        hollow / on_front
    );
    for panel in panels {
        let costs: Vec<_> = place.field.unsurely_beaten(&place.field.entries, panel.cost, place.by);
        let beaten: BTreeMap<usize, Vec<usize>> = costs.into_iter().collect();
        let _ = writeln!(marks, "<g class=\"panel\" role=\"group\" aria-label=\"{}\">", escape(&panel.cost_name));
        for (tracer, colour, path) in &panel.own {
            let tags = Tags { tracer: Some(tracer), ..Tags::default() }.text();
            let _ = writeln!(marks, "<path class=\"own\"{tags} stroke=\"{colour}\" d=\"{path}\"/>");
        }
        let _ = writeln!(marks, "<path class=\"line\" d=\"{}\"/>", panel.front);
        for (place_in_panel, point) in panel.points.iter().enumerate() {
            let said = said(place, point, &panel.cost_name, panel.cost);
            marks +=
                &mark(&id(place, point.index), point, &said, place_in_panel == 0, beaten.get(&point.index), *on_front);
        }
        for (name, point, (left, top)) in
            panel.points.iter().filter_map(|point| point.name.as_ref().map(|(name, at)| (name, point, at)))
        {
            let tags = Tags { tracer: Some(&point.tracer), ..Tags::default() }.text();
            let _ = writeln!(
                marks,
                "<text{tags} x=\"{left:.1}\" y=\"{top:.1}\" fill=\"{}\">{}</text>",
                point.colour,
                escape(name)
            );
        }
        marks.push_str("</g>\n");
    }
    marks.push_str("</g>\n</svg>");
    // On top of everything that is drawn.
    let svg = ground.trim_end().strip_suffix("</svg>").unwrap_or(ground).to_owned() + &marks;
    let alt = format!("Fronts of {}: what points cost against what they get wrong", place.title());
    let caption = format!(
        "{}. Wrong rays (%) by {} over cost. Points tell their parameters when they are pointed at or have the focus (arrow keys). {machine}.",
        place.title(),
        place.by.name()
    );
    figure(&svg, &alt, &caption, place.tags()).replacen("role=\"img\"", "role=\"group\"", 1)
}

/// What a point is and does, in words.
fn said(place: &Place<'_>, point: &PointMark, cost_name: &str, cost: Cost) -> String {
    let entry = place.field.entries.iter().find(|entry| entry.index == point.index);
    let label = place.section.points[point.index].label();
    let wrong = entry.and_then(|entry| Some((Wrong::of(entry.trace, place.by)?, metrics::trials(entry.trace))));
    let right = wrong.map_or_else(String::new, |(wrong, trials)| format!("; right {}", page::right(&wrong, trials)));
    let read = match cost {
        Cost::Bytes => crate::report::format::significant(point.read.value, 4),
        _ => with_interval(point.read.value, point.read.interval, 4),
    };
    format!("{label}; {cost_name} {read}{right}")
}

fn mark(id: &str, point: &PointMark, said: &str, first: bool, beaten: Option<&Vec<usize>>, radius: f64) -> String {
    let front_status = match point.front_status {
        FrontStatus::OnFront => "front",
        FrontStatus::WithinNoise => "noise",
        FrontStatus::Behind => "behind",
    };
    let best = if point.is_best { " best" } else { "" };
    let tags = Tags { tracer: Some(&point.tracer), ..Tags::default() }.text();
    let near: Vec<String> = beaten.into_iter().flatten().map(usize::to_string).collect();
    let near = if near.is_empty() { String::new() } else { format!(" data-near=\"{}\"", near.join(" ")) };
    let [cost, error] = point.spot;
    let (left, top) = point.place;
    let dot = match &point.outline {
        Some(path) => format!("<path class=\"dot\" d=\"{path}\"/>"),
        None => format!("<circle class=\"dot\" r=\"{radius}\"/>"),
    };
    let arrow = point.arrow.as_ref().map_or_else(String::new, |path| format!("<path class=\"arrow\" d=\"{path}\"/>"));
    format!(
        "<g class=\"mark {front_status}{best}\"{tags} data-point=\"{id}\" data-index=\"{}\" data-cost=\"{cost}\" data-error=\"{error}\"{near} \
         tabindex=\"{}\" role=\"img\" aria-label=\"{}\" color=\"{}\" transform=\"translate({left:.2} {top:.2})\">\
         <path class=\"bars\" d=\"{}\"/>{arrow}{dot}</g>\n",
        point.index,
        if first { 0 } else { -1 },
        escape(said),
        point.colour,
        point.bars,
    )
}
