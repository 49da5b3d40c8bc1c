//! Causes of wrong answers as stacked bars.

use super::Place;
use super::pieces::{Piece, Rank, Tags, escape};
use super::read::Names;
use super::write::plain_html;
use crate::report::chart::colour;
use crate::report::document::Document;
use crate::report::metrics;
use crate::report::sheet::{Cell, Sheet};
use crate::results::{OCCLUSION, Rule, gathered};
use crate::studies::pareto::By;

/// A row a tracer as its presets have it: how many rays are wrong, and why.
struct TableRow<'a> {
    place: &'a Place<'a>,
    label: String,
    wrong: u64,
    trials: u64,
    causes: Vec<(&'a str, u64)>,
}

/// The causes of all places; nothing where no wrong answer has one.
pub(super) fn causes(places: &[Place<'_>], names: &Names) -> Vec<Piece> {
    let rows: Vec<TableRow<'_>> = places.iter().flat_map(rows).collect();
    let known = gathered(rows.iter().flat_map(|row| row.causes.iter().copied())).into_iter();
    let mut known: Vec<(&str, u64)> = known.map(|(name, rays)| (name, rays.into_iter().sum())).collect();
    if known.is_empty() {
        return Vec::new();
    }
    // Frequent ones take the colours that are distinguished best.
    known.sort_by_key(|(_, rays)| std::cmp::Reverse(*rays));
    let colour_of = |name: &str| colour(known.iter().position(|(known, _)| *known == name).unwrap_or(0));
    let key =
        |(name, _): &(&str, u64)| format!("<li><i style=\"background:{}\"></i>{}</li>", colour_of(name), escape(name));
    let key: String = known.iter().map(key).collect();
    let parts = |row: &TableRow<'_>| {
        let all: u64 = row.causes.iter().map(|(_, rays)| rays).sum();
        let part = |(name, rays): &(&str, u64)| ((*name).to_owned(), *rays as f64 / all.max(1) as f64, colour_of(name));
        Cell::Parts(row.causes.iter().map(part).collect())
    };
    let sheet = Sheet::<TableRow<'_>>::new()
        .column("tracer", |row| row.label.clone())
        .column("rays", |row| row.place.field.rays)
        .column("scene", |row| Cell::Name(row.place.field.scene.scene.name.clone()))
        .column("machine", |row| row.place.read.machine.to_string())
        .column("rule", |row| rule(row.place.by))
        .column("wrong (%)", |row| Cell::Number(row.wrong as f64 / row.trials.max(1) as f64 * 100.0, 3))
        .column("wrong rays", |row| row.wrong)
        .column("causes (% of the wrong rays)", parts);
    let html = format!(
        "<p>Every tracer as its presets have it. A bar is all of the wrong rays, its parts are their causes (%), by the rule beside it.</p>\n\
         <ul class=\"key\">{key}</ul>\n{}",
        plain_html(&Document::default().table(sheet.table(&rows)), 3, names)
    );
    vec![Piece::heavy(Rank::Page, "causes", Tags::default(), html)]
}

/// The rule under which causes stand.
fn rule(by: By) -> &'static str {
    match by {
        By::Rule(Rule::HitMiss) => Rule::Tight.name(),
        By::Rule(rule) => rule.name(),
        By::BalancedAccuracy => OCCLUSION,
    }
}

fn rows<'a>(place: &'a Place<'a>) -> impl Iterator<Item = TableRow<'a>> {
    // Of a study of fronts the points that every configuration starts from.
    let is_further = |index: usize| {
        let (before, config) = (&place.field.section.points[..index], place.field.section.points[index].config());
        place.read.record.pareto.is_some() && before.iter().any(|point| point.config() == config)
    };
    place.field.entries.iter().filter(move |entry| !is_further(entry.index)).filter_map(|entry| {
        let causes = entry.trace.judgement.causes().get(rule(place.by))?;
        let mut causes: Vec<(&str, u64)> =
            causes.iter().filter(|(_, rays)| **rays > 0).map(|(name, rays)| (name.as_str(), *rays)).collect();
        causes.sort_by_key(|(name, rays)| (std::cmp::Reverse(*rays), *name));
        let wrong: u64 = causes.iter().map(|(_, rays)| rays).sum();
        let (label, trials) = (entry.point.label(), metrics::trials(entry.trace));
        (wrong > 0).then_some(TableRow { place, label, wrong, trials, causes })
    })
}
