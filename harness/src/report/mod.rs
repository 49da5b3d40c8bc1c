//! Writes `run.json` and everything that is derived from it: pages, tables and charts.
//!
//! Every file is made whole in memory, written beside its place and renamed, so no file is ever half-written. The
//! derived files depend on nothing but the run: made again from the same `run.json` they are the same bytes.

pub(crate) mod ablation;
pub(crate) mod cells;
pub(crate) mod chart;
pub(crate) mod columns;
mod compare;
mod distances;
mod error;
mod explain;
#[cfg(test)]
pub(crate) mod fixture;
pub(crate) mod format;
pub(crate) mod group;
mod html;
pub(crate) mod kept;
pub(crate) mod markdown;
pub(crate) mod means;
pub(crate) mod metrics;
mod need;
mod pareto;
pub(crate) mod peers;
pub(crate) mod sheet;
mod stability;
pub(crate) mod summary;
mod surfaces;
mod sweep;
mod tables;
mod terminal;
#[cfg(test)]
mod tests;
mod tune;
mod updates;
mod verdict;

use std::collections::BTreeSet;
use std::fs;
use std::io::{ErrorKind, Read as _};
use std::path::{Path, PathBuf};

use flate2::read::MultiGzDecoder;

pub use compare::comparison_text;
pub use error::ReportError;
pub use explain::{EXPLAIN_PAGE, explanation_page};
pub use html::{Claims, MOST_BYTES, Makers, Page, page as html_page, quoted};
pub use need::NEED_PAGE;
pub use pareto::PARETO_PAGE;
pub use stability::{STABILITY_TABLE, matrix as stability_matrix};
pub use sweep::SWEEP_PAGE;
pub use terminal::run_table;
pub use tune::{TUNE_PAGE, tuning_overview};

use crate::files;
use crate::results::{FrontScene, PICTURES_FOLDER, Run, SCHEMA};
use crate::studies::stability::Stability;
use crate::studies::tune::Tuning;
use kept::Kept;

/// The file that holds everything.
pub const RUN_FILE: &str = "run.json";

/// The page of a run in full.
const SUMMARY: &str = "summary.md";

/// Makes the files of the table that a run was made for, name and contents; none of one that was made for none. Tables know
/// reports, reports know no table.
pub type Tables = fn(&Run) -> Result<Contents, ReportError>;

/// Files: name and contents.
pub type Contents = Vec<(String, Vec<u8>)>;

/// Creates the folder if need be, writes `run.json`, then what is derived from it; gives the paths in that order.
///
/// # Errors
/// If the folder or a file cannot be written, or a chart cannot be drawn.
pub fn write_run(run: &Run, directory: &Path, tables: Tables) -> Result<Vec<PathBuf>, ReportError> {
    files::create_directory(directory)?;
    let path = directory.join(RUN_FILE);
    // First, so that a failure in a chart costs the chart and not the measurements.
    files::write(&path, &files::json(RUN_FILE, run)?)?;
    // An older record, compressed, would pass for this one's.
    let _ = fs::remove_file(directory.join(format!("{RUN_FILE}.gz")));
    remove_stale_pictures(run, directory);
    let mut paths = vec![path];
    paths.extend(write_derived(run, directory, tables)?);
    Ok(paths)
}

/// Takes the pictures that a record names from beside other records, as far as they are there and what they are called.
///
/// # Errors
/// If the folder or a file cannot be written.
pub fn take_pictures(run: &Run, from: &[PathBuf], directory: &Path) -> Result<(), ReportError> {
    let into = directory.join(PICTURES_FOLDER);
    for name in run.pareto.iter().flat_map(|record| &record.scenes).flat_map(FrontScene::picture_files) {
        let found = from.iter().find_map(|record| match kept::picture(record, name) {
            Kept::Picture(bytes) => Some(bytes),
            _ => None,
        });
        if let Some(bytes) = found {
            files::create_directory(&into)?;
            files::write(&into.join(name), &bytes)?;
        }
    }
    Ok(())
}

/// Removes pictures that an older record of the folder has left.
fn remove_stale_pictures(run: &Run, directory: &Path) {
    let kept: BTreeSet<&str> =
        run.pareto.iter().flat_map(|record| &record.scenes).flat_map(FrontScene::picture_files).collect();
    for entry in fs::read_dir(directory.join(PICTURES_FOLDER)).into_iter().flatten().flatten() {
        if entry.file_name().to_str().is_some_and(|name| !kept.contains(name)) {
            let _ = fs::remove_file(entry.path());
        }
    }
    // Gone if it is empty.
    let _ = fs::remove_dir(directory.join(PICTURES_FOLDER));
}

/// Writes what is derived from a record and gives the paths: the pages, tables and charts of what was asked.
///
/// # Errors
/// If the folder or a file cannot be written, or a chart cannot be drawn.
pub fn write_derived(run: &Run, directory: &Path, tables: Tables) -> Result<Vec<PathBuf>, ReportError> {
    let (contents, stems) = derived(&run.aligned(), tables)?;
    let paths = write_all(contents, directory)?;
    remove_stale_charts(directory, &paths, stems);
    Ok(paths)
}

/// Writes files into a folder, and gives their paths.
pub(crate) fn write_all(contents: Contents, directory: &Path) -> Result<Vec<PathBuf>, ReportError> {
    files::create_directory(directory)?;
    let write = |(name, contents): (String, Vec<u8>)| {
        let path = directory.join(name);
        files::write(&path, &contents)?;
        Ok(path)
    };
    contents.into_iter().map(write).collect()
}

/// The files that derive from a record, by name, and what the names of its charts begin with.
fn derived(run: &Run, tables: Tables) -> Result<(Contents, &'static [&'static str]), ReportError> {
    if let Some(tuning) = Tuning::of(run) {
        return Ok((tune::files(&tuning)?, &[tune::STEM]));
    }
    if let Some(updates) = &run.updates {
        return Ok((updates::files(run, updates)?, &[]));
    }
    if let Some(stability) = Stability::of(run) {
        let mut contents = vec![(STABILITY_TABLE.to_owned(), stability::page(&stability).into_bytes())];
        contents.extend(chart::strength_charts(&stability)?.into_iter().map(|file| (file.name, file.contents)));
        return Ok((contents, &[]));
    }
    if let Some(record) = &run.pareto {
        return Ok(([pareto::files(run, record)?, traces(run)?].concat(), &[pareto::STEM]));
    }
    if let Some(record) = &run.need {
        return Ok(([need::files(run, record)?, traces(run)?].concat(), &[need::STEM]));
    }
    if let Some(found) = &run.explanation {
        let page = explanation_page(run, found);
        return Ok((vec![(EXPLAIN_PAGE.to_owned(), page.into_bytes())], &[]));
    }
    Ok((of_run(run, tables)?, &chart::STEMS))
}

/// Every trace, and every wrong ray that was kept.
fn traces(run: &Run) -> Result<Contents, ReportError> {
    let groups = group::groups(run);
    Ok(vec![
        ("traces.csv".to_owned(), tables::traces(run, &groups)?),
        ("wrong_rays.csv".to_owned(), tables::wrong_rays(&groups)?),
    ])
}

/// The files of a plain run: `summary.md`, `traces.csv`, `wrong_rays.csv`, charts; of one that was made for a table the table;
/// of a sweep also `sweep.md`, `sweep.csv` and its charts.
fn of_run(run: &Run, of_table: Tables) -> Result<Contents, ReportError> {
    let groups = group::groups(run);
    let labelled = sweep::labelled(run);
    let shown = group::groups(&labelled);
    let mut contents = vec![
        (SUMMARY.to_owned(), summary::summary(&labelled, &shown).into_bytes()),
        ("traces.csv".to_owned(), tables::traces(run, &groups)?),
        ("wrong_rays.csv".to_owned(), tables::wrong_rays(&groups)?),
    ];
    contents.extend(of_table(run)?);
    contents.extend(chart::charts(&labelled, &shown)?.into_iter().map(|file| (file.name, file.contents)));
    if let Some(record) = &run.sweep {
        let views = sweep::views(record, &groups);
        contents.extend(sweep::files(run, record, &views)?);
        contents.extend(chart::sweep_charts(run, &views)?.into_iter().map(|file| (file.name, file.contents)));
    }
    Ok(contents)
}

/// The table of a record that follows animations: names and contents.
///
/// # Errors
/// If the record follows none.
pub(crate) fn of_updates(run: &Run) -> Result<Contents, ReportError> {
    let none = || ReportError::Made {
        what: "a table over animations".to_owned(),
        reason: "the run follows no animation".to_owned(),
    };
    updates::files(run, run.updates.as_ref().ok_or_else(none)?)
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

/// Reads a record back from its folder or from the file itself, plain or compressed by gzip.
///
/// # Errors
/// If there is no such file, it is not a whole JSON document, or it follows another schema.
pub fn read_run(path: &Path) -> Result<Run, ReportError> {
    read(path, RUN_FILE, SCHEMA)
}

fn read(path: &Path, file: &'static str, wanted: u32) -> Result<Run, ReportError> {
    let path = if path.is_dir() { in_folder(path, file) } else { path.to_owned() };
    let fail = |source: std::io::Error| match source.kind() {
        ErrorKind::NotFound => ReportError::Missing { path: path.clone(), file },
        _ => ReportError::Read { path: path.clone(), source },
    };
    let mut text = fs::read(&path).map_err(fail)?;
    if text.starts_with(&GZIP) {
        let mut plain = Vec::new();
        let unpacked = MultiGzDecoder::new(&text[..]).read_to_end(&mut plain);
        unpacked.map_err(|source| ReportError::Packed { path: path.clone(), source })?;
        text = plain;
    }
    let value: serde_json::Value =
        serde_json::from_slice(&text).map_err(|source| ReportError::NotJson { path: path.clone(), file, source })?;
    // Before everything else is looked at: a file of another schema lacks fields, and that would be said instead.
    match value.get("schema") {
        Some(schema) if schema.as_u64() == Some(u64::from(wanted)) => {}
        Some(schema) => return Err(ReportError::Schema { path, found: schema.to_string(), wanted }),
        None => return Err(ReportError::NoSchema { path, file }),
    }
    let run: Run = serde_json::from_value(value).map_err(|source| ReportError::NotAsSaid {
        path: path.clone(),
        file,
        wanted,
        source,
    })?;
    match run.fault() {
        None => Ok(run),
        Some(reason) => Err(ReportError::Unmeasured { path, reason }),
    }
}

/// What a compressed file begins with (RFC 1952).
const GZIP: [u8; 2] = [0x1f, 0x8b];

/// The file of a folder, or the same compressed where that alone is there.
fn in_folder(folder: &Path, file: &str) -> PathBuf {
    let (plain, packed) = (folder.join(file), folder.join(format!("{file}.gz")));
    if !plain.exists() && packed.exists() { packed } else { plain }
}
