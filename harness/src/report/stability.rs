//! The page of a run of cases: the matrix, its reasons, and what was measured.

use super::Report;
use super::chart::difficulty;
use super::document::Document;
use super::format;
use super::sheet::Sheet;
use super::summary::footprint_of_many;
use crate::cases;
use crate::results::{CaseRecord, DifficultyLevel, ExpectationRecord, Provenance, Record, Skipped, gathered};
use crate::studies::stability::{CaseMatrix, Cell, Stability, Verdict, percent};

/// The chart, without its end.
const CHART: &str = "error_vs_difficulty";

/// The matrix of cases and tracers with the reasons below it, as Markdown.
pub fn matrix(stability: &Stability) -> String {
    document(stability).markdown()
}

fn document(stability: &Stability) -> Document {
    let mut sheet = Sheet::<CaseMatrix>::new().column("case", |CaseMatrix { case, .. }| {
        if case.invalid.is_some() { format!("{} (VOID)", case.name) } else { case.name.clone() }
    });
    for (place, tracer) in stability.tracers().into_iter().enumerate() {
        sheet = sheet.column(tracer, move |of| of.cells.get(place).map(|cell| cell.text.clone()));
    }
    let counts = if stability.counts { "" } else { "Parameters were changed: verdicts are shown but do not count." };
    let skipped =
        |skipped: &Skipped| format!("Skipped {}: {}", skipped.tracer.as_deref().unwrap_or("all"), skipped.reason);
    let invalid = |CaseMatrix { case, .. }: &CaseMatrix| {
        Some(format!("**{}** is invalid: {}", case.name, case.invalid.as_ref()?))
    };
    Document::default()
        .table(sheet.table(&stability.cases))
        .paragraph(counts)
        .paragraphs(stability.skipped.iter().map(skipped))
        .paragraphs(stability.cases.iter().filter_map(invalid))
        .items(reasons(stability))
}

/// Why tracers may be wrong where they may; the same words for several cases once.
fn reasons(stability: &Stability) -> Vec<String> {
    let told = |(case, cell): (&CaseRecord, &Cell)| {
        let expectation = cell.expectation.as_ref().filter(|_| cell.verdict != Verdict::Unavailable)?;
        let ExpectationRecord { reason, source, .. } = expectation;
        let source = if source.is_empty() { String::new() } else { format!(" ({source})") };
        (!reason.is_empty()).then(|| ((cell.tracer.clone(), format!("{reason}{source}")), case.name.clone()))
    };
    let cells = stability.cases.iter().flat_map(|of| of.cells.iter().map(move |cell| (&of.case, cell)));
    let said = gathered(cells.filter_map(told)).into_iter();
    said.map(|((tracer, reason), cases)| format!("{tracer}, {}: {reason}.", cases.join("; "))).collect()
}

/// A difficulty parameter's value: plain where that is short.
pub(super) fn difficulty_value(value: f64) -> String {
    let plain = value.to_string();
    if plain.len() <= 6 { plain } else { format!("{value:e}") }
}

/// What is made of a run of cases: page and chart.
pub(super) fn report(record: &Record) -> Option<Report> {
    Some(Report::of_page("stability.md", page(&Stability::of(record)?, footprint_of_many(&record.rows))))
}

fn page(stability: &Stability, footprint: Option<String>) -> Document {
    let Provenance { machine, commit, dirty, started, rules_version, .. } = &stability.provenance;
    let (commit, machine) = (format::commit(commit, *dirty), machine.label());
    let head = format!("{started}, commit {commit}, rules version {rules_version}. Machine: {machine}.");
    let chart = difficulty::chart(stability);
    let head = Document::titled("Stability").paragraph(head).paragraphs(footprint);
    let head = head.chart(CHART, "Wrong rays over the difficulty level", chart);
    head.and(document(stability)).and(stability.cases.iter().map(section))
}

fn section(CaseMatrix { case, cells }: &CaseMatrix) -> Document {
    let difficulty_parameter = cases::label(&case.difficulty_parameter.name, &case.difficulty_parameter.unit);
    let mut sheet = Sheet::<(usize, &DifficultyLevel)>::new()
        .column(difficulty_parameter, |(_, at)| difficulty_value(at.difficulty_level))
        .column("rays", |(_, at)| at.rays)
        .column("hit", |(_, at)| at.true_hits)
        .column("miss", |(_, at)| at.true_misses)
        .column("ambiguous rays", |(_, at)| at.ambiguous_rays)
        .column("show the difficulty", |(_, at)| percent(at.featured));
    for cell in cells {
        sheet = sheet.column(format!("{}: tight, footprint", cell.tracer), move |(place, _)| figures(cell, *place));
    }
    let rows: Vec<_> = case.difficulty_levels.iter().enumerate().collect();
    let page =
        Document::default().heading(2, &case.name).paragraph(format!("{}.", case.summary)).table(sheet.table(&rows));
    page.paragraph(format!("The difficulty: rays that {}.", case.feature))
}

fn figures(cell: &Cell, place: usize) -> Option<String> {
    let measured = cell.measured.get(place)?;
    let Some(wrong) = measured.wrong else { return measured.no_answer.as_ref().map(|why| why.error.clone()) };
    let mark = if measured.as_expected == Some(false) && cell.verdict != Verdict::Unstated { " **!**" } else { "" };
    Some(format!("{}, {}{mark}", percent(wrong.tight), percent(wrong.footprint)))
}
