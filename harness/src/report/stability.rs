//! The page of a run of cases: the matrix, its reasons, and what was measured.

use std::fmt::Write as _;

use super::format;
use super::sheet::Sheet;
use crate::cases;
use crate::results::{Provenance, Strength};
use crate::studies::stability::{CaseMatrix, Cell, Stability, Verdict, percent};

/// The file with the matrix.
pub const STABILITY_TABLE: &str = "stability.md";

/// The matrix of cases and tracers with the reasons below it, as Markdown.
pub fn matrix(stability: &Stability) -> String {
    let mut sheet = Sheet::<CaseMatrix>::new().told("case", |CaseMatrix { case, .. }| {
        if case.void.is_some() { format!("{} (VOID)", case.name) } else { case.name.clone() }
    });
    for (place, tracer) in stability.tracers().into_iter().enumerate() {
        sheet = sheet.told(tracer, move |of| of.cells.get(place).map(|cell| cell.text.clone()));
    }
    let mut text = sheet.markdown(&stability.cases);
    if !stability.counts {
        text.push_str("\nParameters were changed: verdicts are shown but do not count.\n");
    }
    for skipped in &stability.skipped {
        let _ = writeln!(text, "\nSkipped {}: {}", skipped.tracer.as_deref().unwrap_or("all"), skipped.reason);
    }
    for CaseMatrix { case, .. } in &stability.cases {
        if let Some(reason) = &case.void {
            let _ = writeln!(text, "\n**{}** is void: {reason}", case.name);
        }
    }
    let reasons: Vec<String> = reasons(stability);
    if !reasons.is_empty() {
        let _ = writeln!(text, "\n{}", reasons.join("\n"));
    }
    text
}

/// Why tracers may be wrong where they may; the same words for several cases once.
fn reasons(stability: &Stability) -> Vec<String> {
    let mut said: Vec<(String, String, Vec<String>)> = Vec::new();
    for CaseMatrix { case, cells } in &stability.cases {
        for cell in cells.iter().filter(|cell| cell.verdict != Verdict::Unavailable) {
            let Some(expectation) = cell.expectation.as_ref().filter(|each| !each.reason.is_empty()) else { continue };
            let name = case.name.clone();
            let mut reason = expectation.reason.clone();
            if !expectation.source.is_empty() {
                let _ = write!(reason, " ({})", expectation.source);
            }
            match said.iter_mut().find(|(tracer, known, _)| *tracer == cell.tracer && *known == reason) {
                Some((_, _, cases)) => cases.push(name),
                None => said.push((cell.tracer.clone(), reason, vec![name])),
            }
        }
    }
    said.into_iter().map(|(tracer, reason, cases)| format!("- {tracer}, {}: {reason}.", cases.join("; "))).collect()
}

/// A knob's value: plain where that is short.
pub(super) fn knob_value(value: f64) -> String {
    let plain = value.to_string();
    if plain.len() <= 6 { plain } else { format!("{value:e}") }
}

pub(super) fn page(stability: &Stability) -> String {
    let Provenance { machine, commit, dirty, started, rules_version, .. } = &stability.provenance;
    let mut text = format!(
        "# Stability\n\n{started}, commit {}, rules version {rules_version}. Machine: {}.\n\n![Wrong rays over strength](error_vs_strength.svg)\n\n{}",
        format::commit(commit, *dirty),
        machine.label(),
        matrix(stability)
    );
    for CaseMatrix { case, cells } in &stability.cases {
        let _ = writeln!(text, "\n## {}\n\n{}.\n", case.name, case.summary);
        let knob = cases::label(&case.knob.name, &case.knob.unit);
        let mut sheet = Sheet::<(usize, &Strength)>::new()
            .told(knob, |(_, at)| knob_value(at.strength))
            .told("rays", |(_, at)| at.rays)
            .told("hit", |(_, at)| at.true_hits)
            .told("miss", |(_, at)| at.true_misses)
            .told("ties", |(_, at)| at.ties)
            .told("show the difficulty", |(_, at)| percent(at.featured));
        for cell in cells {
            sheet = sheet.told(format!("{}: tight, footprint", cell.tracer), move |(place, _)| figures(cell, *place));
        }
        let rows: Vec<_> = case.strengths.iter().enumerate().collect();
        let _ = writeln!(text, "{}\nThe difficulty: rays that {}.", sheet.markdown(&rows), case.feature);
    }
    text
}

fn figures(cell: &Cell, place: usize) -> Option<String> {
    let measured = cell.measured.get(place)?;
    let Some(wrong) = measured.wrong else { return measured.error.clone() };
    let mark = if measured.as_expected == Some(false) && cell.verdict != Verdict::Unstated { " **!**" } else { "" };
    Some(format!("{}, {}{mark}", percent(wrong.tight), percent(wrong.footprint)))
}
