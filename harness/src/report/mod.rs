//! Writes `run.json` and everything that is derived from it: a summary, tables and charts.
//!
//! Every file is made whole in memory, written beside its place and renamed, so no file is ever half-written. The
//! derived files depend on nothing but the run: made again from the same `run.json` they are the same bytes.

mod cells;
mod chart;
mod compare;
mod error;
mod explain;
pub(crate) mod files;
#[cfg(test)]
pub(crate) mod fixture;
mod format;
mod group;
mod markdown;
mod metrics;
mod papers;
mod peers;
mod stability;
mod summary;
mod surfaces;
mod sweep;
mod tables;
mod terminal;
#[cfg(test)]
mod tests;
mod tune;
mod updates;
mod verdict;

use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

pub use compare::comparison_text;
pub use error::ReportError;
pub use explain::{explanation_page, write_explanation};
pub use papers::{claims_text, write_claims};
pub use stability::{STABILITY_TABLE, matrix as stability_matrix, write as write_stability};
pub use sweep::SWEEP_PAGE;
pub use terminal::run_table;
pub use tune::{TUNE_PAGE, tuning_overview, write_tuning, write_tuning_derived};
pub use updates::{write_updates, write_updates_table};

use crate::results::{Run, SCHEMA};
use crate::tables::Table;
use crate::tune::Tuning;
use crate::updates::Updates;

/// The file that holds everything.
pub const RUN_FILE: &str = "run.json";

/// Creates the folder if need be, writes `run.json`, then what is derived from it; gives the paths in that order.
///
/// # Errors
/// If the folder or a file cannot be written, or a chart cannot be drawn.
pub fn write_run(run: &Run, directory: &Path) -> Result<Vec<PathBuf>, ReportError> {
    files::create_directory(directory)?;
    let path = directory.join(RUN_FILE);
    // First, so that a failure in a chart costs the chart and not the measurements.
    files::write(&path, &files::json(RUN_FILE, run)?)?;
    let mut paths = vec![path];
    paths.extend(write_derived(run, directory)?);
    Ok(paths)
}

/// Writes what is derived from a run and gives the paths: `summary.md`, `traces.csv`, `wrong_rays.csv`, charts; of a
/// sweep also `sweep.md`, `sweep.csv` and its charts.
///
/// # Errors
/// If the folder or a file cannot be written, or a chart cannot be drawn.
pub fn write_derived(run: &Run, directory: &Path) -> Result<Vec<PathBuf>, ReportError> {
    files::create_directory(directory)?;
    let groups = group::groups(run);
    let mut paths = Vec::new();
    let mut write = |name: &str, contents: &[u8]| {
        let path = directory.join(name);
        files::write(&path, contents)?;
        paths.push(path);
        Ok::<(), ReportError>(())
    };
    let labelled = sweep::labelled(run);
    let shown = group::groups(&labelled);
    write("summary.md", summary::summary(&labelled, &shown).as_bytes())?;
    write("traces.csv", &tables::traces(run, &groups)?)?;
    write("wrong_rays.csv", &tables::wrong_rays(&groups)?)?;
    if let Some(table) = run.table.as_deref().and_then(Table::find) {
        for (name, contents) in table_files(table, run)? {
            write(&name, &contents)?;
        }
    }
    for file in chart::charts(&labelled, &shown)? {
        write(&file.name, &file.contents)?;
    }
    if let Some(record) = &run.sweep {
        let views = sweep::views(record, &groups);
        for (name, contents) in sweep::files(run, record, &views)? {
            write(&name, &contents)?;
        }
        for file in chart::sweep_charts(run, &views)? {
            write(&file.name, &file.contents)?;
        }
    }
    remove_stale_charts(directory, &paths, &chart::STEMS);
    Ok(paths)
}

/// Writes a table over a run, whatever the run was made for, and gives the paths.
///
/// # Errors
/// If the folder or a file cannot be written, or the run has no tracer of the table.
pub fn write_table(table: Table, run: &Run, directory: &Path) -> Result<Vec<PathBuf>, ReportError> {
    if !run.runs.iter().any(|one| table.holds(&one.tracer.name)) {
        let reason = "no tracer of this run belongs into it".to_owned();
        return Err(ReportError::Made { what: format!("table {}", table.name()), reason });
    }
    files::create_directory(directory)?;
    let write = |(name, contents): (String, Vec<u8>)| {
        let path = directory.join(name);
        files::write(&path, &contents).map(|()| path)
    };
    table_files(table, run)?.into_iter().map(write).collect()
}

fn table_files(table: Table, run: &Run) -> Result<Vec<(String, Vec<u8>)>, ReportError> {
    match table {
        Table::Peers(table) => peers::files(table, run),
        Table::Paper(experiment) => papers::files(experiment, run),
    }
}

/// Charts of scenes that only an older run in the same folder had would pass for this one's.
fn remove_stale_charts(directory: &Path, written: &[PathBuf], stems: &[&str]) {
    let entries = fs::read_dir(directory).into_iter().flatten().flatten();
    for path in entries.map(|entry| entry.path()).filter(|path| !written.contains(path)) {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let is_picture = [".svg", ".png"].iter().any(|ending| name.ends_with(ending));
        if is_picture && stems.iter().any(|stem| name.starts_with(stem)) {
            // One that cannot be removed is in nobody's way.
            let _ = fs::remove_file(&path);
        }
    }
}

/// Where the table of a folder stands.
pub fn table_page(name: &str, directory: &Path) -> PathBuf {
    directory.join(format!("{}.md", peers::stem(name)))
}

/// Reads a run back from its folder or from the file itself.
///
/// # Errors
/// If there is no such file, it is not a whole JSON document, or it follows another schema.
pub fn read_run(path: &Path) -> Result<Run, ReportError> {
    read(path, RUN_FILE, SCHEMA)
}

/// Reads what was measured of structures that follow animations back, from its folder or from the file itself.
///
/// # Errors
/// As [`read_run`].
pub fn read_updates(path: &Path) -> Result<Updates, ReportError> {
    read(path, updates::UPDATES_FILE, crate::updates::SCHEMA)
}

/// Reads a tuned parameter back, from its folder or from the file itself.
///
/// # Errors
/// As [`read_run`].
pub fn read_tuning(path: &Path) -> Result<Tuning, ReportError> {
    read(path, tune::TUNE_FILE, crate::tune::SCHEMA)
}

/// What a folder holds.
#[derive(Debug)]
pub enum Measured {
    /// A run.
    Run(Box<Run>),
    /// Structures that follow animations.
    Updates(Box<Updates>),
    /// A parameter, tuned.
    Tuning(Box<Tuning>),
}

/// Reads whichever of these there is: of a folder that holds several the first, of a file what its name says.
///
/// # Errors
/// As [`read_run`].
pub fn read_any(path: &Path) -> Result<Measured, ReportError> {
    let holds = |file: &str| {
        if path.is_dir() { path.join(file).exists() } else { path.file_name().is_some_and(|name| name == file) }
    };
    if !holds(RUN_FILE) && holds(updates::UPDATES_FILE) {
        return Ok(Measured::Updates(Box::new(read_updates(path)?)));
    }
    if !holds(RUN_FILE) && holds(tune::TUNE_FILE) {
        return Ok(Measured::Tuning(Box::new(read_tuning(path)?)));
    }
    Ok(Measured::Run(Box::new(read_run(path)?)))
}

fn read<T: serde::de::DeserializeOwned>(path: &Path, file: &'static str, wanted: u32) -> Result<T, ReportError> {
    let path = if path.is_dir() { path.join(file) } else { path.to_owned() };
    let text = fs::read(&path).map_err(|source| match source.kind() {
        ErrorKind::NotFound => ReportError::Missing { path: path.clone(), file },
        _ => ReportError::Read { path: path.clone(), source },
    })?;
    let value: serde_json::Value =
        serde_json::from_slice(&text).map_err(|source| ReportError::NotJson { path: path.clone(), file, source })?;
    // Before everything else is looked at: a file of another schema lacks fields, and that would be said instead.
    match value.get("schema") {
        Some(schema) if schema.as_u64() == Some(u64::from(wanted)) => {}
        Some(schema) => return Err(ReportError::Schema { path, found: schema.to_string(), wanted }),
        None => return Err(ReportError::NoSchema { path, file }),
    }
    serde_json::from_value(value).map_err(|source| ReportError::NotAsSaid { path, file, wanted, source })
}
