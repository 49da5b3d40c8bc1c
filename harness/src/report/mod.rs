//! Writes `run.json` and everything that is derived from it: pages, tables and charts.
//!
//! Every file is made whole in memory, written beside its place and renamed, so no file is ever half-written. The
//! derived files depend on nothing but the run: made again from the same `run.json` they are the same bytes.

pub(crate) mod cells;
pub(crate) mod chart;
pub(crate) mod columns;
mod compare;
mod distances;
mod error;
pub mod exact;
mod explain;
#[cfg(test)]
pub(crate) mod fixture;
pub(crate) mod format;
pub(crate) mod group;
mod html;
pub(crate) mod kept;
pub(crate) mod markdown;
mod means;
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
use std::io::{BufRead as _, BufReader, ErrorKind, Read as _};
use std::path::{Path, PathBuf};

use flate2::bufread::MultiGzDecoder;
use serde::Deserialize;

pub use chart::without_images;
pub use compare::comparison_text;
pub use error::ReportError;
pub use explain::EXPLAIN_PAGE;
pub use html::{Claims, MOST_BYTES, Makers, Page, page as html_page, quoted};
pub use need::NEED_PAGE;
pub use pareto::PARETO_PAGE;
pub use stability::{STABILITY_TABLE, matrix as stability_matrix};
pub use sweep::SWEEP_PAGE;
pub use terminal::run_table;
pub use tune::TUNE_PAGE;

use crate::files::{self, OutputFolder};
use crate::results::{FrontScene, PICTURES_FOLDER, Run, SCHEMA};
use crate::studies::stability::Stability;
use crate::studies::tune::Tuning;
use kept::Kept;

/// The file that holds everything.
pub const RUN_FILE: &str = "run.json";

/// The same compressed by gzip.
const PACKED: &str = "run.json.gz";

/// The page of a run in full.
const SUMMARY: &str = "summary.md";

/// Makes the files of the table that a run was made for, name and contents; none of one that was made for none. Tables know
/// reports, reports know no table.
pub type Tables = fn(&Run) -> Result<Contents, ReportError>;

/// Files: name and contents.
pub type Contents = Vec<(String, Vec<u8>)>;

/// What the names of derived files begin with, up to a dot or an underscore.
const BEGINNINGS: &str = "agreement_over_tolerance break_even claims error_vs explain figure need operating_points pareto stability \
                          summary sweep table traces tune verdicts wrong_rays";

/// Whether a verb that measures may write a file of this name, or a folder, right into its folder of results.
pub fn may_be_written(name: &str) -> bool {
    let begins = |begin: &str| name.strip_prefix(begin).is_some_and(|rest: &str| rest.starts_with(['.', '_']));
    let ends = [".md", ".csv", ".json", ".svg", ".png"].iter().any(|end| name.ends_with(end));
    ends && BEGINNINGS.split_whitespace().any(begins) || [RUN_FILE, PACKED, PICTURES_FOLDER, "races"].contains(&name)
}

/// Writes `run.json`, then what is derived from it; gives the paths in that order.
///
/// # Errors
/// If a file cannot be written, or a chart cannot be drawn.
pub fn write_run(run: &Run, folder: &OutputFolder, tables: Tables) -> Result<Vec<PathBuf>, ReportError> {
    // First, so that a failure in a chart costs the chart and not the measurements.
    let mut paths = vec![folder.write(RUN_FILE, &files::json(RUN_FILE, run)?)?];
    // An older record, compressed, would pass for this one's.
    folder.remove(PACKED);
    let kept: BTreeSet<String> = picture_files(run).map(|name| format!("{PICTURES_FOLDER}/{name}")).collect();
    let pictures = folder.listed().into_iter().filter(|name| name.starts_with(PICTURES_FOLDER));
    pictures.filter(|name| !kept.contains(name)).for_each(|name| folder.remove(&name));
    paths.extend(write_derived(run, folder, tables)?);
    Ok(paths)
}

/// Takes the pictures that a record names from beside other records, as far as they are there and what they are called.
///
/// # Errors
/// If a file cannot be written.
pub fn take_pictures(run: &Run, from: &[PathBuf], folder: &OutputFolder) -> Result<(), ReportError> {
    for name in picture_files(run) {
        let found = from.iter().find_map(|record| match kept::picture(record, name) {
            Kept::Picture(bytes) => Some(bytes),
            _ => None,
        });
        if let Some(bytes) = found {
            folder.write(&format!("{PICTURES_FOLDER}/{name}"), &bytes)?;
        }
    }
    Ok(())
}

/// The pictures that a record names.
fn picture_files(run: &Run) -> impl Iterator<Item = &str> {
    run.pareto.iter().flat_map(|record| &record.scenes).flat_map(FrontScene::picture_files)
}

/// Writes what is derived from a record and gives the paths: the pages, tables and charts of what was asked.
///
/// # Errors
/// If a file cannot be written, or a chart cannot be drawn.
pub fn write_derived(run: &Run, folder: &OutputFolder, tables: Tables) -> Result<Vec<PathBuf>, ReportError> {
    let (contents, stems) = derived(&run.aligned(), tables)?;
    let paths = write_all(&contents, folder)?;
    // Charts of scenes that only an older run in the same folder had would pass for this one's.
    for name in folder.listed().iter().filter(|name| contents.iter().all(|(written, _)| written != *name)) {
        let is_picture = [".svg", ".png"].iter().any(|ending| name.ends_with(ending));
        if is_picture && stems.iter().any(|stem| name.starts_with(stem)) {
            folder.remove(name);
        }
    }
    Ok(paths)
}

/// What is derived from a record: names and contents of the files that [`write_derived`] writes.
///
/// # Errors
/// If a chart cannot be drawn.
pub fn contents(run: &Run, tables: Tables) -> Result<Contents, ReportError> {
    Ok(derived(&run.aligned(), tables)?.0)
}

/// Writes files into a folder, and gives their paths.
pub(crate) fn write_all(contents: &Contents, folder: &OutputFolder) -> Result<Vec<PathBuf>, ReportError> {
    Ok(folder.write_all(contents.iter().map(|(name, contents)| (name.as_str(), contents.as_slice())))?)
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
        let page = explain::explanation_page(run, found);
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

/// Where the table of a folder stands.
pub fn table_page(name: &str, directory: &Path) -> PathBuf {
    directory.join(format!("{}.md", peers::stem(name)))
}

/// The most bytes of a record's JSON that are read, packed or not: fifteen times those of the largest record that is known.
pub const MOST_RECORD_BYTES: u64 = 512 << 20;

/// Reads a record back from its folder or from the file itself, plain or compressed by gzip.
///
/// # Errors
/// If there is no such file, it is not a whole JSON document, it follows another schema, or it can be of no run.
pub fn read_run(path: &Path) -> Result<Run, ReportError> {
    let (file, path) = (RUN_FILE, record_file(path));
    let text = unpacked(&path)?;
    // Before everything else is looked at: a file of another schema lacks fields, and that would be said instead.
    let head: Result<Head, _> = serde_json::from_slice(&text);
    match head.map(|head| head.schema) {
        Ok(Some(schema)) if schema.as_u64() == Some(u64::from(SCHEMA)) => {}
        Ok(Some(schema)) => return Err(ReportError::Schema { path, found: schema.to_string(), wanted: SCHEMA }),
        Err(source) if !source.is_data() => return Err(ReportError::NotJson { path, file, source }),
        _ => return Err(ReportError::NoSchema { path, file }),
    }
    Run::read(&text).map_err(|reason| ReportError::Unmeasured { path, reason })
}

/// What is read of a record first.
#[derive(Deserialize)]
struct Head {
    schema: Option<serde_json::Value>,
}

/// The bytes of a file, unpacked where it is compressed, of which there may be no more than [`MOST_RECORD_BYTES`].
fn unpacked(path: &Path) -> Result<Vec<u8>, ReportError> {
    let fail = |source: std::io::Error| match source.kind() {
        ErrorKind::NotFound => ReportError::Missing { path: path.to_owned(), file: RUN_FILE },
        _ => ReportError::Read { path: path.to_owned(), source },
    };
    let mut file = BufReader::new(fs::File::open(path).map_err(fail)?);
    let mut bytes = Vec::new();
    if file.fill_buf().map_err(fail)?.starts_with(&GZIP) {
        let unpacked = MultiGzDecoder::new(file).take(MOST_RECORD_BYTES + 1).read_to_end(&mut bytes);
        unpacked.map_err(|source| ReportError::Packed { path: path.to_owned(), source })?;
    } else {
        file.take(MOST_RECORD_BYTES + 1).read_to_end(&mut bytes).map_err(fail)?;
    }
    if bytes.len() as u64 > MOST_RECORD_BYTES {
        return Err(ReportError::TooLarge { path: path.to_owned(), most_bytes: MOST_RECORD_BYTES });
    }
    Ok(bytes)
}

/// What a compressed file begins with (RFC 1952).
const GZIP: [u8; 2] = [0x1f, 0x8b];

/// The file of a record that is given by it or by its folder; the compressed one where that alone is there.
pub fn record_file(path: &Path) -> PathBuf {
    let (plain, packed) = (path.join(RUN_FILE), path.join(PACKED));
    match path.is_dir() {
        true if !plain.exists() && packed.exists() => packed,
        true => plain,
        false => path.to_owned(),
    }
}
