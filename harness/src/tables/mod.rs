//! Every table that `tracebench table` makes: of tracers at settings, of studies, of the papers' tables and figures, and of
//! their claims.

pub mod exact;

use std::path::PathBuf;

use crate::files::OutputFolder;
use crate::papers::{self, Experiment, PAPERS, Paper};
use crate::peers;
use crate::report::{self, Report, ReportError};
use crate::results::Record;

/// A table.
#[derive(Clone, Copy, Debug)]
pub enum Table {
    /// Tracers at settings, a row each.
    Settings(&'static peers::Table),
    /// Whether a tracer has any wrong ray.
    Exact,
    /// A paper's table or figure.
    Paper(&'static Paper, &'static Experiment),
    /// All that a paper claims, by runs of its tables.
    Claims(&'static Paper),
}

/// What is said of the option by which tables take tracers.
pub fn tracer_help() -> String {
    format!("Of table {} the tracers, as `run` takes them; {} if not given", exact::NAME, exact::tracer())
}

impl Table {
    /// Every table, those of papers last.
    pub fn all() -> impl Iterator<Item = Self> {
        let of = |paper: &&'static Paper| {
            let paper = *paper;
            let experiments = paper.experiments.iter().map(move |experiment| Self::Paper(paper, experiment));
            experiments.chain([Self::Claims(paper)])
        };
        peers::all().map(Self::Settings).chain([Self::Exact]).chain(PAPERS.iter().flat_map(of))
    }

    /// Finds a table by name.
    pub fn find(name: &str) -> Option<Self> {
        Self::all().find(|table| table.name() == name)
    }

    /// Its name, what it shows, and its ray sets.
    fn words(self) -> [&'static str; 3] {
        match self {
            Self::Settings(table) => [table.name, table.summary, table.rays],
            Self::Exact => [exact::NAME, exact::SUMMARY, "all"],
            Self::Paper(_, experiment) => [experiment.name, experiment.summary, experiment.rays],
            Self::Claims(paper) => [
                paper.claims_table,
                "all that the paper claims, with a verdict on every claim by the runs of its tables that --from names",
                "",
            ],
        }
    }

    /// Its stable name; files are named after it.
    pub fn name(self) -> &'static str {
        self.words()[0]
    }

    /// What it shows, in one line.
    pub fn summary(self) -> &'static str {
        self.words()[1]
    }

    /// Ray sets where nothing else is said, as `--rays` takes them.
    pub fn rays(self) -> &'static str {
        self.words()[2]
    }

    /// Whether a tracer of this name belongs into it.
    pub fn holds(self, tracer: &str) -> bool {
        match self {
            Self::Settings(table) => table.holds(tracer),
            Self::Exact => true,
            Self::Paper(_, experiment) => experiment.holds(tracer),
            Self::Claims(_) => false,
        }
    }

    /// It over a run.
    fn report(self, record: &Record) -> Result<Report, ReportError> {
        Ok(match self {
            Self::Settings(table) => report::peers::report(table, record),
            Self::Exact => {
                let page = exact::page(record, &format!("Table {}: {}", self.name(), self.summary()));
                Report::of_page(report::table_page(self.name()), page)
            }
            Self::Paper(paper, experiment) => papers::report(paper, experiment, record)?,
            Self::Claims(paper) => papers::claims_report(paper, std::slice::from_ref(record))?,
        })
    }
}

/// The table that a run was made for, as [`report::Tables`].
///
/// # Errors
/// If a chart cannot be drawn.
pub fn of_run(record: &Record) -> Result<Report, ReportError> {
    record.table.as_deref().and_then(Table::find).map_or_else(|| Ok(Report::default()), |table| table.report(record))
}

/// Writes a table over a run that was made for it, or for no table, and gives the paths.
///
/// # Errors
/// If a file cannot be written, or the run has nothing for the table, or is another one's.
pub fn write(table: Table, record: &Record, folder: &OutputFolder) -> Result<Vec<PathBuf>, ReportError> {
    let made = |reason: &str| ReportError::NotMade(format!("table {}", table.name()), reason.to_owned());
    let record = record.aligned();
    let record = &*papers::with_rows(&record);
    // Its rows are chosen, set and scaled for what it is of.
    if let Some(other) = record.table.as_deref().filter(|other| *other != table.name()) {
        return Err(made(&format!(
            "the record was made for table {other}, whose rows are others; make {other} of it, or measure {}",
            table.name()
        )));
    }
    if !record.rows.iter().any(|one| table.holds(&one.tracer.name)) {
        return Err(made("no tracer of this record belongs into it"));
    }
    let report = table.report(record)?;
    report::write_all(&report.contents()?, folder)
}

#[cfg(test)]
mod tests {
    use tempfile::TempDir;

    use super::*;
    use crate::report::fixture;

    /// Every table is found by its name, which no other has.
    #[test]
    fn names_are_unique() {
        let names: Vec<&str> = Table::all().map(Table::name).collect();
        for (index, name) in names.iter().enumerate() {
            assert!(!names[..index].contains(name), "{name} twice");
            assert_eq!(Table::find(name).unwrap().name(), *name);
        }
        assert!(
            names.contains(&"bvh")
                && names.contains(&"launch-settings")
                && names.contains(&"dirt-table1")
                && Table::find("no-such").is_none()
        );
    }

    /// A run has the files of the table that it was made for alone; a table over a run that was made for none is written all the same,
    /// unless none of its tracers belongs into it; over one for another table it is not, and both are named.
    #[test]
    fn tables_are_made_of_runs() {
        let record = fixture::typical();
        assert!(of_run(&record).unwrap().contents().unwrap().is_empty());
        let folder = TempDir::new().unwrap();
        let bvh = Table::find("bvh").unwrap();
        let folder = OutputFolder::open(folder.path()).unwrap();
        let paths = write(bvh, &record, &folder).unwrap();
        let made = of_run(&Record { table: Some("bvh".to_owned()), ..record.clone() }).unwrap().contents().unwrap();
        assert_eq!(paths.len(), made.len());
        for (path, (name, contents)) in paths.iter().zip(&made) {
            assert!(path.ends_with(name) && std::fs::read(path).unwrap() == *contents, "{name} differs");
        }
        let others = Record { rows: record.rows[1..].to_vec(), ..record };
        assert!(write(bvh, &others, &folder).unwrap_err().to_string().contains("no tracer"));
        let foreign = |name: &str, record: &Record| {
            let error = write(Table::find(name).unwrap(), record, &folder).unwrap_err().to_string();
            assert!(error.contains(&format!("table {name}: the record was made for table ")), "{error}");
            error
        };
        // Tracers of both belong into both.
        let figure = Record { table: Some("dirt-figure7".to_owned()), ..fixture::typical() };
        assert!(foreign("dirt-table1", &figure).contains("table dirt-figure7, "));
        assert!(foreign("bvh", &figure).contains("table dirt-figure7, "));
    }
}
