//! A paper's table or figure measured here: `table_NAME.md` and `verdicts_NAME.json`, with charts.

mod claims;
mod figures;
mod measured;
mod published;
#[cfg(test)]
mod tests;

use std::fmt::Write as _;

pub use claims::{claims_text, write_claims};

use super::chart::series::series_chart;
use super::markdown::inline;
use super::{ReportError, peers, summary};
use crate::papers::{self, DataError, Experiment, Rows};
use crate::results::Run;

fn broken(error: &DataError) -> ReportError {
    ReportError::Made { what: "the page".to_owned(), reason: error.to_string() }
}

/// The files of an experiment: name and contents.
pub(super) fn files(experiment: &Experiment, run: &Run) -> Result<Vec<(String, Vec<u8>)>, ReportError> {
    let mut run = run.clone();
    run.runs.retain(|one| experiment.holds(&one.tracer.name));
    let rows = Rows::of(&run);
    let tables = papers::tables().map_err(|error| broken(&error))?;
    let paper = papers::paper(experiment.paper).map_err(|error| broken(&error))?;
    let all = papers::claims().map_err(|error| broken(&error))?;
    let own = all.iter().filter(|claim| claim.table() == Some(experiment.name));
    let judged: Vec<_> = own.map(|claim| papers::judge(claim, experiment.name, &rows)).collect();
    let charts = figures::charts(experiment, &rows);
    let mut text = summary::head(&run, &format!("Table {}: {}", experiment.name, experiment.summary));
    text += &notes(experiment, &rows);
    if let Some(paper) = paper {
        let beside: Vec<_> = tables.iter().filter(|table| experiment.published.contains(&table.id.as_str())).collect();
        text += &published::section(&paper, &beside);
    }
    text += &measured::sections(experiment, &rows, &tables);
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
    for scene in &rows.scenes {
        let of = &scene.runs[0].scene.name;
        let said = match experiment.stands_for(of) {
            Some(published) => format!("{} stands for the paper's {published}", inline(of)),
            None => format!("{} stands for none of the paper's scenes", inline(of)),
        };
        let _ = writeln!(text, "- {said}.");
    }
    text
}
