//! The page of a run of cases: the matrix, its reasons, and what was measured.

use std::fmt::Write as _;

use super::format;
use super::markdown::Table;
use crate::cases;
use crate::results::Provenance;
use crate::studies::stability::{CaseMatrix, Cell, Stability, Verdict, percent};

/// The file with the matrix.
pub const STABILITY_TABLE: &str = "stability.md";

/// The matrix of cases and tracers with the reasons below it, as Markdown.
pub fn matrix(stability: &Stability) -> String {
    let tracers = stability.tracers();
    let mut table = Table::new(&[vec!["case".to_owned()], tracers].concat());
    for CaseMatrix { case, cells } in &stability.cases {
        let name = if case.void.is_some() { format!("{} (VOID)", case.name) } else { case.name.clone() };
        let cells = cells.iter().map(|cell| cell.text.clone());
        table.row(&std::iter::once(name).chain(cells).collect::<Vec<_>>());
    }
    let mut text = table.text;
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
            let from = expectation.from.map(|from| format!(" from {}", with_unit(from, &case.knob.unit)));
            let name = format!("{}{}", case.name, from.unwrap_or_default());
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

fn with_unit(value: f64, unit: &str) -> String {
    format!("{} {unit}", knob_value(value)).trim_end().to_owned()
}

/// A knob's value: plain where that is short.
pub(super) fn knob_value(value: f64) -> String {
    let plain = value.to_string();
    if plain.len() <= 6 { plain } else { format!("{value:e}") }
}

pub(super) fn page(stability: &Stability) -> String {
    let Provenance { machine, commit, dirty, started, .. } = &stability.provenance;
    let mut text = format!(
        "# Stability\n\n{started}, commit {}. Machine: {}.\n\n![Wrong rays over strength](error_vs_strength.svg)\n\n{}",
        format::commit(commit, *dirty),
        machine.label(),
        matrix(stability)
    );
    for CaseMatrix { case, cells } in &stability.cases {
        let _ = writeln!(text, "\n## {}\n\n{}.\n", case.name, case.summary);
        let knob = cases::label(&case.knob.name, &case.knob.unit);
        let shared = ["rays", "hit", "miss", "ties", "show the difficulty"].map(str::to_owned);
        let of_tracers = cells.iter().map(|cell| format!("{}: tight, footprint", cell.tracer));
        let mut table = Table::new(&[vec![knob], shared.to_vec(), of_tracers.collect()].concat());
        for (index, strength) in case.strengths.iter().enumerate() {
            let counts = [strength.rays, strength.true_hits, strength.true_misses, strength.ties];
            let mut row = vec![knob_value(strength.strength)];
            row.extend(counts.map(format::thousands));
            row.push(percent(strength.featured));
            row.extend(cells.iter().map(|cell| figures(cell, index)));
            table.row(&row);
        }
        let _ = writeln!(text, "{}\nThe difficulty: rays that {}.", table.text, case.feature);
    }
    text
}

fn figures(cell: &Cell, index: usize) -> String {
    let Some(measured) = cell.measured.get(index) else { return format::NONE.to_owned() };
    let Some(wrong) = measured.wrong else { return measured.error.clone().unwrap_or_else(|| format::NONE.to_owned()) };
    let mark = if measured.as_expected == Some(false) && cell.verdict != Verdict::Unstated { " **!**" } else { "" };
    format!("{}, {}{mark}", percent(wrong.tight), percent(wrong.footprint))
}
