//! Which to choose for every ray set, in a line; ray sets of which the same is said share one.

use std::fmt::Write as _;

use itertools::Itertools as _;

use super::Place;
use super::answer::{ASKED, is_smoke, is_within_noise};
use super::pieces::{Tags, escape};
use crate::report::group::gathered;
use crate::report::pareto::page::{asked, too_few};
use crate::studies::pareto::{Aim, best};

/// A list a machine.
pub(super) fn text(places: &[Place<'_>]) -> String {
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
pub(super) fn cases_of<'p, 'a>(places: &'p [Place<'a>], machine: usize) -> Vec<&'p Place<'a>> {
    let mut own: Vec<&Place<'_>> = places.iter().filter(|place| place.read.machine == machine).collect();
    if own.iter().any(|place| !is_smoke(&place.read.record)) {
        own.retain(|place| !is_smoke(&place.read.record));
    }
    own
}

/// Who is best for a need, in words: every tracer with how many cases it has and in how many of these another may be as good, the most
/// first; nobody comes last.
pub(super) fn winners(cases: &[&Place<'_>], aim: Aim) -> Vec<String> {
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
    counted.sorted_by_key(|(tracer, count, _)| (tracer.is_none(), std::cmp::Reverse(*count))).map(each).collect()
}

/// In how many cases there are too few rays to tell.
pub(super) fn unsure(cases: &[&Place<'_>]) -> String {
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
    let winners = Aim::ALL.map(|aim| format!("{} {}", aim.name(), winners(cases, aim).join(", ")));
    format!("{where_to}{of}: {}{}", winners.join("; "), unsure(cases))
}
