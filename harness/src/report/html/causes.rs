//! Causes of wrong answers as stacked bars.

use std::fmt::Write as _;

use super::Place;
use super::pieces::{Piece, Rank, Tags, escape};
use crate::report::chart::colour;
use crate::report::format::{significant, thousands};
use crate::report::metrics;
use crate::results::{OCCLUSION, Rule};
use crate::studies::pareto::By;

/// A row a tracer as its presets have it: how many rays are wrong, and why.
struct Row<'a> {
    place: &'a Place<'a>,
    tracer: &'a str,
    label: String,
    wrong: u64,
    trials: u64,
    causes: Vec<(&'a str, u64)>,
}

/// The causes of all places; nothing where no wrong answer has one.
pub(super) fn causes(places: &[Place<'_>], machines: &[String]) -> Vec<Piece> {
    let rows: Vec<Row<'_>> = places.iter().flat_map(rows).collect();
    let mut known: Vec<(&str, u64)> = Vec::new();
    for (name, rays) in rows.iter().flat_map(|row| &row.causes) {
        match known.iter_mut().find(|(known, _)| known == name) {
            Some((_, all)) => *all += rays,
            None => known.push((*name, *rays)),
        }
    }
    if known.is_empty() {
        return Vec::new();
    }
    // Frequent ones take the colours that are told apart best.
    known.sort_by_key(|(_, rays)| std::cmp::Reverse(*rays));
    let colour_of = |name: &str| colour(known.iter().position(|(known, _)| *known == name).unwrap_or(0));
    let key =
        |(name, _): &(&str, u64)| format!("<li><i style=\"background:{}\"></i>{}</li>", colour_of(name), escape(name));
    let key: String = known.iter().map(key).collect();
    let mut html = format!(
        "<p>Every tracer as its presets have it. A bar is all of the wrong rays, its parts are their causes (%), by the rule beside it.</p>\n\
         <ul class=\"key\">{key}</ul>\n<div class=\"wide\" tabindex=\"0\"><table><thead><tr>"
    );
    for heading in
        ["tracer", "rays", "scene", "machine", "rule", "wrong (%)", "wrong rays", "causes (% of the wrong rays)"]
    {
        let _ = write!(html, "<th scope=\"col\">{heading}</th>");
    }
    html.push_str("</tr></thead><tbody>\n");
    for row in &rows {
        let field = row.place.field;
        let tags = Tags { tracer: Some(row.tracer), ..row.place.tags() }.text();
        let _ = write!(html, "<tr{tags}>");
        let share = row.wrong as f64 / row.trials.max(1) as f64 * 100.0;
        for cell in [
            row.label.clone(),
            field.rays.to_owned(),
            field.scene.scene.name.clone(),
            row.place.read.machine.to_string(),
            rule(row.place.by).to_owned(),
            significant(share, 3),
            thousands(row.wrong),
        ] {
            let _ = write!(html, "<td>{}</td>", escape(&cell));
        }
        let _ = writeln!(html, "<td>{}</td></tr>", bar(row, machines, &colour_of));
    }
    html.push_str("</tbody></table></div>\n");
    vec![Piece::Heavy { rank: Rank::Page, what: "causes".to_owned(), tags: String::new(), html }]
}

fn bar(row: &Row<'_>, machines: &[String], colour_of: &dyn Fn(&str) -> String) -> String {
    let all: u64 = row.causes.iter().map(|(_, rays)| rays).sum();
    let percent = |rays: u64| rays as f64 / all.max(1) as f64 * 100.0;
    let words: Vec<String> = row.causes.iter().map(|(name, rays)| format!("{name} {:.1} %", percent(*rays))).collect();
    let alt = format!(
        "{}, {}, machine {}: {}",
        row.label,
        row.place.title(),
        machines[row.place.read.machine - 1],
        words.join(", ")
    );
    let parts: String = row
        .causes
        .iter()
        .zip(&words)
        .map(|((name, rays), words)| {
            let (width, colour) = (percent(*rays), colour_of(name));
            format!("<i style=\"width:{width:.2}%;background:{colour}\" title=\"{}\"></i>", escape(words))
        })
        .collect();
    let most: String = words.iter().take(2).map(|words| format!("{}; ", escape(words))).collect();
    let more = if words.len() > 2 { format!("{} more", words.len() - 2) } else { String::new() };
    let most = format!("{most}{more}");
    format!(
        "<span class=\"bar\" role=\"img\" aria-label=\"{}\">{parts}</span><small>{}</small>",
        escape(&alt),
        most.trim_end_matches("; ")
    )
}

/// The rule under which causes stand.
fn rule(by: By) -> &'static str {
    match by {
        By::Rule(Rule::HitMiss) => Rule::Tight.name(),
        By::Rule(rule) => rule.name(),
        By::BalancedAccuracy => OCCLUSION,
    }
}

fn rows<'a>(place: &'a Place<'a>) -> impl Iterator<Item = Row<'a>> {
    // Of a study of fronts the points that every contender starts from.
    let is_further = |index: usize| {
        let (before, contender) = (&place.record.points[..index], place.record.points[index].contender());
        place.read.run.pareto.is_some() && before.iter().any(|point| point.contender() == contender)
    };
    place.field.entries.iter().filter(move |entry| !is_further(entry.index)).filter_map(|entry| {
        let causes = entry.trace.judgement.causes().get(rule(place.by))?;
        let mut causes: Vec<(&str, u64)> =
            causes.iter().filter(|(_, rays)| **rays > 0).map(|(name, rays)| (name.as_str(), *rays)).collect();
        causes.sort_by_key(|(name, rays)| (std::cmp::Reverse(*rays), *name));
        let wrong: u64 = causes.iter().map(|(_, rays)| rays).sum();
        let (label, trials) = (entry.point.label(), metrics::trials(entry.trace));
        (wrong > 0).then(|| Row { place, tracer: &entry.point.tracer, label, wrong, trials, causes })
    })
}
