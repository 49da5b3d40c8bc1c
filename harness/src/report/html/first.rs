//! The first screen: a plain sentence a need, one chart, three links.

use std::fmt::Write as _;

use itertools::Itertools as _;

use super::answer::ASKED;
use super::in_short::{cases_of, unsure, winners};
use super::read::Read;
use super::write::inline;
use super::{Place, told};
use crate::report::pareto::page::asked;
use crate::report::verdict::{self, Verdict};
use crate::studies::pareto::{Aim, best};

/// So many tracers are named in a sentence; others are counted.
const MAX_NAMED: usize = 3;

/// Sentences, a chart with its figure, and links to what most readers look for next; `others` are sections with their titles.
pub(super) fn screen(
    places: &[Place<'_>],
    records: &[Read<'_>],
    machines: &[String],
    chart: &str,
    others: &[(&'static str, &'static str)],
) -> String {
    let mut html = "<section id=\"first\">\n<div class=\"needs\">".to_owned();
    for machine in 1..=machines.len() {
        let cases = cases_of(places, machine);
        if !cases.is_empty() {
            html += &sentences(&cases, (machines.len() > 1).then_some(machine));
        }
    }
    let told = records.iter().filter(|read| places.is_empty() && verdict::controls(&read.record) == Verdict::Sound);
    let told: String = told.flat_map(|read| told::sentences(&read.record)).map(|told| item(&inline(&told))).collect();
    if !told.is_empty() {
        let _ = writeln!(html, "<ul>\n{told}</ul>");
    }
    let budget = (!places.is_empty()).then_some(("budget", "Within your budget"));
    let links = budget.into_iter().chain(others.iter().copied().filter(|(id, _)| *id != "rules"));
    let links = links.take(2).chain([("rules", "How it is measured and judged")]);
    let links = links.map(|(id, title)| format!("<a href=\"#{id}\">{title}</a>")).join(" · ");
    let _ = write!(html, "</div>\n{chart}<p>{links}</p>\n</section>\n");
    html
}

/// The case that tells methods apart the most: of those that the fewest tracers answer well enough the one with the most tracers.
pub(super) fn hardest<'p, 'a>(places: &'p [Place<'a>]) -> Option<&'p Place<'a>> {
    places.iter().min_by_key(|place| {
        let tracers = place.field.tracers();
        let enough =
            |tracer: &&&str| best(place.field, &place.field.of_tracer(tracer), place.by, ASKED, Aim::Fastest).is_some();
        (tracers.iter().filter(enough).count(), std::cmp::Reverse(tracers.len()))
    })
}

/// Who answers each need in how many of all cases.
fn sentences(cases: &[&Place<'_>], machine: Option<usize>) -> String {
    let count = |what: &str, all: usize| format!("{all} {what}{}", if all == 1 { "" } else { "s" });
    let scenes = cases.iter().map(|place| &place.field.scene.scene.name).unique().count();
    let rays = cases.iter().map(|place| place.field.rays).unique().count();
    let begin = machine.map_or_else(|| "Where".to_owned(), |machine| format!("On machine {machine}, where"));
    let mut html = format!(
        "<p>{begin} at least {} of the answers must be right, over {} and {}:</p>\n<ul>\n",
        asked(ASKED),
        count("scene", scenes),
        count("ray set", rays)
    );
    for aim in Aim::ALL {
        let won = winners(cases, aim);
        let rest = if won.len() > MAX_NAMED { format!(", {} others", won.len() - MAX_NAMED) } else { String::new() };
        let named = won[..won.len().min(MAX_NAMED)].join(", ");
        html += &item(&format!("{} is {named}{rest}{}.", capitalised(aim.name()), unsure(cases)));
    }
    html + "</ul>\n"
}

fn item(html: &str) -> String {
    format!("<li>{html}</li>\n")
}

fn capitalised(name: &str) -> String {
    let mut letters = name.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}
