//! A paper's table or figure measured here: `table_NAME.md` and `verdicts_NAME.json`, with charts.

mod claims;
pub(super) mod measured;
mod published;
pub(super) mod told;

pub use claims::claims_of;
pub(crate) use claims::claims_report;

use super::{Experiment, Paper, PublishedTable, Rows, judge, with_rows};
use crate::files;
use crate::report::chart::series::series;
use crate::report::document::Document;
use crate::report::{self, Report, ReportError, summary};
use crate::results::{Record, Row};

/// What the sections and charts of a page are made from.
pub(crate) struct Page<'a> {
    /// The paper.
    pub paper: &'static Paper,
    /// Its table or figure.
    pub experiment: &'a Experiment,
    /// What was measured.
    pub rows: &'a Rows<'a>,
}

impl Page<'_> {
    /// The published tables that the page stands beside.
    fn beside(&self) -> impl Iterator<Item = &'static PublishedTable> {
        let is_beside = |table: &&PublishedTable| self.experiment.published.contains(&table.id.as_str());
        self.paper.published.tables.iter().filter(is_beside)
    }

    /// The first of them.
    pub(super) fn printed(&self) -> Option<&'static PublishedTable> {
        self.beside().next()
    }

    /// What stands there in a column of the scene that a row's scene stands for, with further labels.
    pub(super) fn printed_of(&self, row: &Row, labels: &[(&str, &str)], column: &str) -> Option<f64> {
        let scene = self.experiment.stands_for(&row.scene)?;
        self.printed()?.value(&[&[("scene", scene)], labels].concat(), column)
    }
}

/// An experiment over a run.
pub(crate) fn report(paper: &'static Paper, experiment: &Experiment, record: &Record) -> Result<Report, ReportError> {
    let mut record = with_rows(record).into_owned();
    record.rows.retain(|one| experiment.holds(&one.tracer.name));
    let rows = Rows::of(&record);
    let own = paper.claims.iter().filter(|claim| claim.table() == Some(experiment.name));
    let judged: Vec<_> = own.map(|claim| judge(paper, claim, &rows)).collect();
    let page = Page { paper, experiment, rows: &rows };
    let charts = experiment.charts.iter().filter_map(|name| paper.pages.charts.get(*name));
    let charts = charts
        .flat_map(|told| told::charts(&page, told))
        .map(|(stem, chart)| Document::default().chart(stem, chart.title.clone(), series(&record, chart)));
    let document = summary::head(&record, &format!("Table {}: {}", experiment.name, experiment.summary))
        .and(notes(experiment, &rows))
        .and(published::section(&paper.published.paper, &page.beside().collect::<Vec<_>>()))
        .and(measured::sections(&page))
        .and(charts)
        .and(claims::section(&judged))
        .and(summary::skipped(&record.skipped));
    let verdicts = format!("verdicts_{}.json", experiment.name.replace('-', "_"));
    let data = vec![(verdicts.clone(), files::json(&verdicts, &judged)?)];
    Ok(Report { data, ..Report::of_page(report::table_page(experiment.name), document) })
}

/// What deviates from the paper, and which scenes stand for its own.
fn notes(experiment: &Experiment, rows: &Rows<'_>) -> Document {
    let mut notes: Vec<String> = experiment.notes.iter().map(|note| (*note).to_owned()).collect();
    let [measured, all] = rows.of_all(experiment);
    if measured < all {
        notes.push(format!(
            "{measured} of {all} rows of the table were measured on the scenes that stand for the paper's."
        ));
    }
    notes.extend(rows.scenes.iter().map(|scene| {
        let record = &scene.rows[0].scene;
        let scaled = if record.scale.is_some_and(|scale| scale != 1.0) { "is scaled down and " } else { "" };
        match experiment.stands_for(record) {
            Some(published) => format!("{} stands for the paper's {published}.", record.name),
            None => format!("{} {scaled}stands for none of the paper's scenes.", record.name),
        }
    }));
    Document::default().items(notes)
}
