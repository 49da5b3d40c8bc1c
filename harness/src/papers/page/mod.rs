//! A paper's table or figure measured here: `table_NAME.md` and `verdicts_NAME.json`, with charts.

pub(super) mod beside;
pub(super) mod charts;
mod claims;
pub(super) mod measured;
mod published;

use std::fmt::Write as _;

pub use claims::{claims_files, claims_of};
use measured::Row;

use super::{DataError, Experiment, Paper, PublishedTable, Rows, judge};
use crate::report::chart::series::series_chart;
use crate::report::markdown::inline;
use crate::report::{ReportError, peers, summary};
use crate::results::{Run, TracerRun};

/// What the sections and charts of a page are made from.
pub(crate) struct Page<'a> {
    /// The paper.
    pub paper: &'a Paper,
    /// Its table or figure.
    pub experiment: &'a Experiment,
    /// What was measured.
    pub rows: &'a Rows<'a>,
    /// What the paper printed.
    pub published: &'a [PublishedTable],
}

impl<'a> Page<'a> {
    /// The published table that the page stands beside, the first where there are several.
    pub(super) fn printed(&self) -> Option<&'a PublishedTable> {
        self.published.iter().find(|table| self.experiment.published.contains(&table.id.as_str()))
    }

    /// What stands there in a column of the scene that a row's scene stands for, with further labels.
    pub(super) fn printed_of(&self, run: &TracerRun, labels: &[(&str, &str)], column: &str) -> Option<f64> {
        let scene = self.experiment.stands_for(&run.scene)?;
        self.printed()?.value(&[&[("scene", scene)], labels].concat(), column)
    }

    /// Every row with its scene.
    pub(super) fn all(&self) -> impl Iterator<Item = Row<'a>> + use<'a> {
        self.rows.scenes.iter().flat_map(|scene| scene.runs.iter().map(move |run| (scene, *run)))
    }

    /// Those of a tracer.
    pub(super) fn of_tracer(&self, tracer: &'static str) -> impl Iterator<Item = Row<'a>> + use<'a> {
        self.all().filter(move |(_, run)| run.tracer.name == tracer)
    }
}

fn broken(error: &DataError) -> ReportError {
    ReportError::Made { what: "the page".to_owned(), reason: error.to_string() }
}

/// The files of an experiment: name and contents.
pub(crate) fn files(paper: &Paper, experiment: &Experiment, run: &Run) -> Result<Vec<(String, Vec<u8>)>, ReportError> {
    let mut run = run.clone();
    run.runs.retain(|one| experiment.holds(&one.tracer.name));
    let rows = Rows::of(&run);
    let published = paper.published().map_err(|error| broken(&error))?;
    let all = paper.claims().map_err(|error| broken(&error))?;
    let own = all.iter().filter(|claim| claim.table() == Some(experiment.name));
    let judged: Vec<_> = own.map(|claim| judge(paper, claim, &rows)).collect();
    let page = Page { paper, experiment, rows: &rows, published: &published.tables };
    let charts: Vec<_> = experiment.charts.iter().flat_map(|charts| charts(&page)).collect();
    let mut text = summary::head(&run, &format!("Table {}: {}", experiment.name, experiment.summary));
    text += &notes(experiment, &rows);
    let is_beside = |table: &&PublishedTable| experiment.published.contains(&table.id.as_str());
    text += &published::section(&published.paper, &published.tables.iter().filter(is_beside).collect::<Vec<_>>());
    text += &measured::sections(&page);
    for chart in &charts {
        let _ = writeln!(text, "\n![{}]({}.svg)", inline(&chart.title), chart.stem);
    }
    text += &claims::section(&judged);
    text += &summary::skipped(&run.skipped);
    let stem = peers::stem(experiment.name);
    let verdicts = format!("verdicts_{}.json", experiment.name.replace('-', "_"));
    let mut files =
        vec![(format!("{stem}.md"), text.into_bytes()), (verdicts.clone(), claims::json(&verdicts, &judged)?)];
    for chart in &charts {
        files.extend(series_chart(&run, chart)?.into_iter().map(|file| (file.name, file.contents)));
    }
    Ok(files)
}

/// What deviates from the paper, and which scenes stand for its own.
fn notes(experiment: &Experiment, rows: &Rows<'_>) -> String {
    let mut text = String::from("\n");
    for note in experiment.notes {
        let _ = writeln!(text, "- {note}");
    }
    let [measured, all] = rows.of_all(experiment);
    if measured < all {
        let _ = writeln!(
            text,
            "- {measured} of {all} rows of the table were measured on the scenes that stand for the paper's."
        );
    }
    for scene in &rows.scenes {
        let record = &scene.runs[0].scene;
        let of = inline(&record.name);
        let said = match experiment.stands_for(record) {
            Some(published) => format!("{of} stands for the paper's {published}"),
            None if record.scale.is_some_and(|scale| scale != 1.0) => {
                format!("{of} is scaled down and stands for none of the paper's scenes")
            }
            None => format!("{of} stands for none of the paper's scenes"),
        };
        let _ = writeln!(text, "- {said}.");
    }
    text
}
