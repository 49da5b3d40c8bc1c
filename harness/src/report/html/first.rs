//! The first screen: a plain sentence a need, one chart, three links; and which to choose for every ray set, in a line: ray sets of which the
//! same is said share one.

use std::fmt::Write as _;

use itertools::Itertools as _;

use super::answer::{ASKED, is_smoke, is_within_noise};
use super::pieces::{Tags, escape};
use super::read::Records;
use super::write::inline;
use super::{Place, told};
use crate::report::pareto::page::{asked, too_few};
use crate::report::verdict;
use crate::results::gathered;
use crate::studies::pareto::{Aim, best};

/// So many tracers are named in a sentence; others are counted.
const MAX_NAMED: usize = 3;

/// Sentences, a chart with its figure, and links to what most readers look for next; `others` are sections with their titles.
pub(super) fn screen(places: &[Place<'_>], records: &Records<'_>, chart: &str, others: &[(&str, &str)]) -> String {
    let mut html = "<section id=\"first\">\n<div class=\"needs\">".to_owned();
    let machines = records.machines.len();
    for machine in 1..=machines {
        let cases = cases_of(places, machine);
        if !cases.is_empty() {
            html += &sentences(&cases, (machines > 1).then_some(machine));
        }
    }
    let told = records.all.iter().filter(|read| places.is_empty() && verdict::controls(&read.record).is_empty());
    let told = told.flat_map(|read| told::sentences(&read.record));
    let told: String = told.map(|told| format!("<li>{}</li>\n", inline(&told))).collect();
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
        let (won, nobody) = winners(cases, aim);
        let others = match won.len().saturating_sub(MAX_NAMED) {
            0 => None,
            1 => Some("1 other".to_owned()),
            count => Some(format!("{count} others")),
        };
        let named = won.into_iter().take(MAX_NAMED).chain(others).chain(nobody).join(", ");
        let _ = writeln!(html, "<li>{} is {named}{}.</li>", capitalised(aim.name()), unsure(cases));
    }
    html + "</ul>\n"
}

pub(super) fn capitalised(name: &str) -> String {
    let mut letters = name.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

/// A list a machine.
pub(super) fn in_short(places: &[Place<'_>]) -> String {
    let mut html = String::new();
    let numbers = places.iter().map(|place| place.read.machine).unique().sorted();
    for machine in numbers {
        let (own, least) = (cases_of(places, machine), asked(ASKED));
        let _ = writeln!(
            html,
            "<p>On machine {machine}, where at least {least} of the answers must be right, take</p>\n<ul>"
        );
        let by_rays = gathered(own.iter().map(|place| (place.field.rays, *place))).into_iter();
        let name = |rays: &str| {
            format!("<span{}>{}</span>", Tags { rays: Some(rays), ..Tags::default() }.text(), escape(rays))
        };
        for (said, names) in gathered(by_rays.map(|(rays, cases)| (said(&cases), name(rays)))) {
            let _ = writeln!(html, "<li>for {}{said}</li>", names.concat());
        }
        html += "</ul>\n";
    }
    if html.is_empty() {
        html += "<p>No record here is of fronts or a plain run, so none says who to take.</p>\n";
    }
    html
}

/// The cases of a machine: smoke runs count where there is nothing else.
fn cases_of<'p, 'a>(places: &'p [Place<'a>], machine: usize) -> Vec<&'p Place<'a>> {
    let mut own: Vec<&Place<'_>> = places.iter().filter(|place| place.read.machine == machine).collect();
    if own.iter().any(|place| !is_smoke(&place.read.record)) {
        own.retain(|place| !is_smoke(&place.read.record));
    }
    own
}

/// Who is best for a need, in words: every tracer with how many cases it has and in how many of these another may be as good, the most
/// first; and nobody, if that is so in some.
fn winners(cases: &[&Place<'_>], aim: Aim) -> (Vec<String>, Option<String>) {
    let won = gathered(cases.iter().map(|place| {
        let found = best(place.field, &place.field.entries, place.by, ASKED, aim);
        let noisy = found.as_ref().is_some_and(|found| is_within_noise(place, ASKED, aim, found));
        (found.map(|found| found.point.tracer.as_str()), noisy)
    }));
    let counted = won.into_iter().map(|(tracer, noisy)| (tracer, noisy.len(), noisy.iter().filter(|is| **is).count()));
    let each = |(tracer, count, noisy): (Option<&str>, usize, usize)| {
        let name = tracer.map_or_else(|| "nobody".to_owned(), |name| format!("<strong>{}</strong>", escape(name)));
        match (cases.len(), noisy) {
            (1, 0) => name,
            (1, _) => format!("{name} (within noise)"),
            (all, 0) => format!("{name} (in {count} of {all})"),
            (all, noisy) => format!("{name} (in {count} of {all}, {noisy} of them within noise)"),
        }
    };
    let (won, nobody): (Vec<_>, Vec<_>) =
        counted.sorted_by_key(|(_, count, _)| std::cmp::Reverse(*count)).partition(|(tracer, ..)| tracer.is_some());
    (won.into_iter().map(each).collect(), nobody.into_iter().map(each).next())
}

/// In how many cases there are too few rays to tell.
fn unsure(cases: &[&Place<'_>]) -> String {
    let unsure = cases.iter().filter(|place| !too_few(ASKED, place.field).is_empty()).count();
    match (unsure, cases.len()) {
        (0, _) => String::new(),
        (_, 1) => "; too few rays to tell".to_owned(),
        (some, all) => format!("; in {some} of {all} too few rays to tell"),
    }
}

/// Which to choose for a ray set, in how many of its cases, which are scenes, or records of the same scene.
fn said(cases: &[&Place<'_>]) -> String {
    let scenes: Vec<&str> = cases.iter().map(|place| place.field.scene.scene.name.as_str()).unique().collect();
    let where_to = match (scenes.as_slice(), cases.len()) {
        ([scene], 1) => format!(" in {}", escape(scene)),
        ([scene], count) => format!(" in {} ({count} records)", escape(scene)),
        (scenes, count) if scenes.len() == count => format!(" in {count} scenes"),
        (scenes, count) => format!(" in {} scenes ({count} cases of a record)", scenes.len()),
    };
    let tracers = cases.iter().map(|place| place.field.tracers().len());
    let of = match (tracers.clone().min().unwrap_or(0), tracers.max().unwrap_or(0)) {
        (least, most) if least == most => format!(", of {most} tracers"),
        (least, most) => format!(", of {least} to {most} tracers"),
    };
    let winners = Aim::ALL.map(|aim| {
        let (won, nobody) = winners(cases, aim);
        format!("{} {}", aim.name(), won.into_iter().chain(nobody).join(", "))
    });
    format!("{where_to}{of}: {}{}", winners.join("; "), unsure(cases))
}
