//! Who to take for every ray set, in a line; ray sets of which the same is said share one.

use std::fmt::Write as _;

use super::Place;
use super::answer::{ASKED, is_smoke};
use super::pieces::{Tags, escape};
use crate::report::pareto::page::asked;
use crate::studies::pareto::{Aim, best};

/// A list a machine.
pub(super) fn text(places: &[Place<'_>], machines: &[String]) -> String {
    let mut html = String::new();
    for machine in 1..=machines.len() {
        let mut own: Vec<&Place<'_>> = places.iter().filter(|place| place.read.machine == machine).collect();
        // Smoke runs count where there is nothing else.
        if own.iter().any(|place| !is_smoke(&place.read.run)) {
            own.retain(|place| !is_smoke(&place.read.run));
        }
        if own.is_empty() {
            continue;
        }
        let least = asked(ASKED);
        let _ = writeln!(
            html,
            "<p>On machine {machine}, where at least {least} of the answers must be right, take</p>\n<ul>"
        );
        let mut sets: Vec<&str> = Vec::new();
        for place in &own {
            if !sets.contains(&place.field.rays) {
                sets.push(place.field.rays);
            }
        }
        let mut lines: Vec<(String, String)> = Vec::new();
        for rays in sets {
            let cases: Vec<&Place<'_>> = own.iter().copied().filter(|place| place.field.rays == rays).collect();
            let tags = Tags { rays: Some(rays), ..Tags::default() }.text();
            let name = format!("<span{tags}>{}</span>", escape(rays));
            let said = said(&cases);
            match lines.iter_mut().find(|(_, known)| *known == said) {
                Some((names, _)) => *names += &name,
                None => lines.push((name, said)),
            }
        }
        for (names, said) in lines {
            let _ = writeln!(html, "<li>for {names}{said}</li>");
        }
        html += "</ul>\n";
    }
    if html.is_empty() {
        html += "<p>No record here is of fronts or a plain run, so none says who to take.</p>\n";
    }
    html
}

/// Whom to take for a ray set, in how many of its cases, which are scenes, or records of the same scene.
fn said(cases: &[&Place<'_>]) -> String {
    let mut scenes: Vec<&str> = Vec::new();
    for place in cases {
        if !scenes.contains(&place.field.scene.scene.name.as_str()) {
            scenes.push(&place.field.scene.scene.name);
        }
    }
    let where_to = match (scenes.as_slice(), cases.len()) {
        ([scene], 1) => format!(" in {}", escape(scene)),
        ([scene], count) => format!(" in {} ({count} records)", escape(scene)),
        (scenes, count) if scenes.len() == count => format!(" in {count} scenes"),
        (scenes, count) => format!(" in {} scenes ({count} cases of a record)", scenes.len()),
    };
    let winners = Aim::ALL.map(|aim| {
        let mut won: Vec<(Option<&str>, usize)> = Vec::new();
        for place in cases {
            let found = best(place.field, &place.field.entries, place.by, ASKED, aim);
            let tracer = found.map(|found| found.point.tracer.as_str());
            match won.iter_mut().find(|(known, _)| *known == tracer) {
                Some((_, count)) => *count += 1,
                None => won.push((tracer, 1)),
            }
        }
        won.sort_by_key(|(tracer, count)| (tracer.is_none(), std::cmp::Reverse(*count)));
        let each = |(tracer, count): &(Option<&str>, usize)| {
            let name = tracer.map_or_else(|| "nobody".to_owned(), |name| format!("<strong>{}</strong>", escape(name)));
            if cases.len() == 1 { name } else { format!("{name} (in {count} of {})", cases.len()) }
        };
        format!("{} {}", aim.name(), won.iter().map(each).collect::<Vec<_>>().join(", "))
    });
    format!("{where_to}: {}", winners.join("; "))
}
