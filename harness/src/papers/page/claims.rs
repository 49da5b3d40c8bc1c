//! Claims with their verdicts: on an experiment's page, and all of a paper together.

use crate::files;
use crate::papers::{Claim, JudgedClaim, MeasuredBy, PAPERS, Paper, SceneValue, Test, Verdict, judge_all};
use crate::report::document::Document;
use crate::report::format::significant;
use crate::report::sheet::{Sheet, Table};
use crate::report::{Report, ReportError, summary};
use crate::results::Record;
use itertools::Itertools as _;

/// The claims that an experiment measures.
pub(super) fn section(judged: &[JudgedClaim]) -> Document {
    if judged.is_empty() {
        return Document::default();
    }
    Document::default().heading(2, "Claims").paragraph(HOW).table(table(judged, false))
}

const HOW: &str = "A claim holds if the values here lie in the range beside them; a percentage holds within 10 percentage points, \
                   or within half of its value where that is less. Where the paper gives no number, the range is this suite's and \
                   stands with the conditions. Of what is timed the interval stands beside the value; a verdict takes twelve rounds and an \
                   interval that lies on one side of every end of the range, and else is undecided. So is a claim with several quantities, by several \
                   readings of what the paper leaves open, that do not lead to one verdict. The adapter and its clock are those above: on a software adapter a ratio of times \
                   says what it says there.";

fn value(value: f64, unit: &str) -> String {
    let figure = significant(value, 4);
    if unit.is_empty() { figure } else { format!("{figure} {unit}") }
}

fn published(claim: &Claim) -> String {
    let unit = if claim.unit.is_empty() { String::new() } else { format!(" {}", claim.unit) };
    let figure = match claim.published.as_deref() {
        None => "no number".to_owned(),
        Some([low, high]) => format!("{low} to {high}{unit}"),
        Some(values) => values.iter().map(|value| format!("{value}{unit}")).collect::<Vec<_>>().join(", "),
    };
    match (&claim.own_figures, claim.agrees_with_own_figures) {
        (Some(own), Some(false)) => format!("{figure}; its own figures differ: {own}"),
        (Some(own), _) => format!("{figure}; its own figures: {own}"),
        (None, _) => figure,
    }
}

/// Where a time lies.
fn interval(of: &SceneValue) -> String {
    of.interval.map_or_else(String::new, |ends| {
        let [low, high] = ends.map(|end| significant(end, 4));
        format!(" [{low}, {high}]")
    })
}

/// Every scene's own figure, then the median; by every reading where there are several.
fn measured(judged: &JudgedClaim) -> Option<String> {
    let scenes = |values: &[SceneValue]| {
        let scene = |each: &SceneValue| format!("{} {}{}", each.scene, value(each.value, &judged.unit), interval(each));
        (!values.is_empty()).then(|| values.iter().map(scene).collect::<Vec<_>>().join(", "))
    };
    let median = judged.median.filter(|_| judged.values.len() > 1);
    let median = median.map_or_else(String::new, |median| format!("; median {}", value(median, &judged.unit)));
    let own = scenes(&judged.values).map(|values| values + &median);
    let others = judged.claim.either().iter().zip(&judged.either);
    let others = others.filter_map(|(either, values)| Some(format!("by `{either}` {}", scenes(values)?)));
    let all: Vec<String> = own.into_iter().chain(others).collect();
    (!all.is_empty()).then(|| all.join("; "))
}

fn rule(claim: &Claim) -> Option<String> {
    let either: String = claim.either().iter().map(|either| format!(" and `{either}` alike")).collect();
    match &claim.test {
        Test::Measured { quantity, rule, .. } => Some(format!("`{quantity}`{either}: {}", rule.describe())),
        Test::NotMeasurable { .. } => None,
    }
}

fn verdict(judged: &JudgedClaim) -> String {
    let reason = judged.reason.as_ref().map_or_else(String::new, |reason| format!(": {reason}"));
    let [measured, all] = judged.scenes;
    let part = if (1..all).contains(&measured) { format!(" ({measured} of {all} scenes)") } else { String::new() };
    format!("**{}**{part}{reason}", judged.verdict.name())
}

fn table(judged: &[JudgedClaim], with_table: bool) -> Table {
    let sheet = Sheet::<JudgedClaim>::new()
        .column("claim", |each| format!("`{}`: {}", each.claim.id, each.claim.statement))
        .column("section", |each| each.claim.section.clone())
        .column("conditions", |each| each.claim.conditions.clone())
        .column("published", |each| published(&each.claim))
        .column("here", measured)
        .column("holds if", |each| rule(&each.claim))
        .column("verdict", verdict);
    if with_table { sheet.column("table", measured_by).table(judged) } else { sheet.table(judged) }
}

/// The table with the run that it was measured in, and what part of its rows there was, unless all were there.
fn measured_by(judged: &JudgedClaim) -> Option<String> {
    let Some(MeasuredBy { table, rows: [measured, all], preset, scope, started, .. }) = &judged.measured_by else {
        return judged.claim.table().map(str::to_owned);
    };
    let rows = if measured < all { format!("{measured} of {all} rows, ") } else { String::new() };
    Some(format!("{table}, {rows}preset {preset}, {scope}, {started}"))
}

/// All claims of a paper together.
fn claims_page(paper: &Paper, rows: &[Record], judged: &[JudgedClaim]) -> Document {
    let machines = judged.iter().filter_map(|each| each.measured_by.as_ref()).map(|by| &by.machine).unique();
    let machines = machines.map(|machine| format!("Machine: {machine}"));
    let verdicts = Verdict::ALL.iter().map(|verdict| {
        let count = judged.iter().filter(|each| each.verdict == *verdict).count();
        format!("{}: {count}", verdict.name())
    });
    let own = rows.iter().filter(|record| is_of(paper, record)).flat_map(|record| &record.rows);
    let title = format!("Claims of {}", paper.published.paper.title);
    let head = machines.chain(verdicts).chain(summary::footprint_of_many(own));
    Document::titled(&title).items(head).paragraph(HOW).table(table(judged, true))
}

/// Whether a run was made for a table of a paper.
fn is_of(paper: &Paper, record: &Record) -> bool {
    record.table.as_deref().is_some_and(|table| paper.experiment(table).is_some())
}

/// The claims of every paper for one of whose tables a run was made, a page a paper.
pub fn claims_of(rows: &[Record]) -> Vec<Document> {
    let measured = PAPERS.iter().filter(|paper| rows.iter().any(|record| is_of(paper, record)));
    measured.map(|paper| claims_page(paper, rows, &judge_all(paper, rows))).collect()
}

/// All claims of a paper together, `claims_PAPER.md` and `claims_PAPER.json`.
///
/// # Errors
/// If they cannot be written as JSON.
pub(crate) fn claims_report(paper: &Paper, rows: &[Record]) -> Result<Report, ReportError> {
    let (stem, judged) = (format!("claims_{}", paper.name), judge_all(paper, rows));
    let name = format!("{stem}.json");
    let data = vec![(name.clone(), files::json(&name, &judged)?)];
    Ok(Report { pages: vec![(format!("{stem}.md"), claims_page(paper, rows, &judged))], data, ..Report::default() })
}
