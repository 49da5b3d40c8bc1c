//! Writes `run.json` and everything that is derived from it: a summary, tables and charts.
//!
//! Every file is made whole in memory, written beside its place and renamed, so no file is ever half-written. The
//! derived files depend on nothing but the run: made again from the same `run.json` they are the same bytes.

mod chart;
mod error;
pub(crate) mod files;
#[cfg(test)]
mod fixture;
mod format;
mod group;
mod markdown;
mod metrics;
mod stability;
mod summary;
mod tables;
#[cfg(test)]
mod tests;
mod verdict;

use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

pub use error::ReportError;
pub use stability::{STABILITY_TABLE, matrix as stability_matrix, write as write_stability};

use crate::results::{Run, SCHEMA};

/// The file that holds everything.
pub const RUN_FILE: &str = "run.json";

/// Creates the folder if need be, writes `run.json`, then what is derived from it; gives the paths in that order.
///
/// # Errors
/// If the folder or a file cannot be written, or a chart cannot be drawn.
pub fn write_run(run: &Run, directory: &Path) -> Result<Vec<PathBuf>, ReportError> {
    files::create_directory(directory)?;
    let path = directory.join(RUN_FILE);
    let mut json = serde_json::to_vec_pretty(run)
        .map_err(|error| ReportError::Made { what: RUN_FILE.to_owned(), reason: error.to_string() })?;
    json.push(b'\n');
    // First, so that a failure in a chart costs the chart and not the measurements.
    files::write(&path, &json)?;
    let mut paths = vec![path];
    paths.extend(write_derived(run, directory)?);
    Ok(paths)
}

/// Writes what is derived from a run and gives the paths: `summary.md`, `traces.csv`, `wrong_rays.csv`, charts.
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
    write("summary.md", summary::summary(run, &groups).as_bytes())?;
    write("traces.csv", &tables::traces(run, &groups)?)?;
    write("wrong_rays.csv", &tables::wrong_rays(&groups)?)?;
    for file in chart::charts(run, &groups)? {
        write(&file.name, &file.contents)?;
    }
    remove_stale_charts(directory, &paths);
    Ok(paths)
}

/// Charts of scenes that only an older run in the same folder had would pass for this one's.
fn remove_stale_charts(directory: &Path, written: &[PathBuf]) {
    let entries = fs::read_dir(directory).into_iter().flatten().flatten();
    for path in entries.map(|entry| entry.path()).filter(|path| !written.contains(path)) {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let is_picture = [".svg", ".png"].iter().any(|ending| name.ends_with(ending));
        if is_picture && chart::STEMS.iter().any(|stem| name.starts_with(stem)) {
            // One that cannot be removed is in nobody's way.
            let _ = fs::remove_file(&path);
        }
    }
}

/// Reads a run back from its folder or from the file itself.
///
/// # Errors
/// If there is no such file, it is not a whole JSON document, or it follows another schema.
pub fn read_run(path: &Path) -> Result<Run, ReportError> {
    let path = if path.is_dir() { path.join(RUN_FILE) } else { path.to_owned() };
    let text = fs::read(&path).map_err(|source| match source.kind() {
        ErrorKind::NotFound => ReportError::Missing { path: path.clone() },
        _ => ReportError::Read { path: path.clone(), source },
    })?;
    let value: serde_json::Value =
        serde_json::from_slice(&text).map_err(|source| ReportError::NotJson { path: path.clone(), source })?;
    // Before everything else is looked at: a file of another schema lacks fields, and that would be said instead.
    match value.get("schema") {
        Some(schema) if schema.as_u64() == Some(u64::from(SCHEMA)) => {}
        Some(schema) => return Err(ReportError::Schema { path, found: schema.to_string() }),
        None => return Err(ReportError::NoSchema { path }),
    }
    serde_json::from_value(value).map_err(|source| ReportError::NotARun { path, source })
}
