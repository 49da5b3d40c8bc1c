//! Writes `run.json` and everything that is derived from it: pages, tables and charts.
//!
//! Every file is made whole in memory, written beside its place and renamed, so no file is ever half-written. The
//! derived files depend on nothing but the run: made again from the same `run.json` they are the same bytes.

mod attack;
mod beside;
mod calibration;
pub(crate) mod cells;
pub(crate) mod chart;
mod check;
mod compare;
pub(crate) mod document;
mod error;
mod explain;
#[cfg(test)]
pub(crate) mod fixture;
pub(crate) mod format;
mod frames;
pub(crate) mod group;
mod html;
pub(crate) mod kept;
pub(crate) mod markdown;
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
mod verdict;

use std::collections::BTreeSet;
use std::fs;
use std::io::{BufRead as _, BufReader, ErrorKind, Read as _};
use std::path::{Path, PathBuf};

use liblzma::bufread::XzDecoder;
use serde::Deserialize;

pub use chart::without_images;
pub use check::check;
pub use compare::comparison_text;
pub use error::ReportError;
pub use html::{Claims, MAX_BYTES, Makers, Page, page as html_page, quoted};
pub use stability::matrix as stability_matrix;
pub use tables::flat_table;
pub use terminal::run_table;

use crate::files::{self, OutputFolder};
use crate::results::{PICTURES_FOLDER, Record, SCHEMA};
use crate::studies::attack::FOLDER as ATTACK_FOLDER;
use document::Document;
use sheet::{Sheet, Table};
use tables::rows;

/// The file that holds everything.
pub const RUN_FILE: &str = "run.json";

/// The page of a record in the folder where that is.
pub const PAGE_FILE: &str = "report.html";

/// The same compressed by xz.
const PACKED: &str = "run.json.xz";

/// The page of a run in full.
const SUMMARY: &str = "summary.md";

/// Of a run of several scenes where every tracer is best, and where worst.
const SCENES: &str = "scenes.md";

/// What is made of a record, each part with its name; charts have theirs in documents.
#[derive(Debug, Default)]
pub struct Report {
    /// Documents.
    pub(crate) pages: Vec<(String, Document)>,
    /// Tables for other programs.
    pub(crate) tables: Vec<(String, Table)>,
    /// Other files.
    pub(crate) data: Contents,
}

impl Report {
    /// A page.
    pub(crate) fn of_page(name: impl Into<String>, page: Document) -> Self {
        Self { pages: vec![(name.into(), page)], ..Self::default() }
    }

    /// With what another has, of which tables take the place of those of the same name.
    pub(crate) fn and(mut self, other: Self) -> Self {
        self.tables.retain(|(name, _)| other.tables.iter().all(|(own, _)| own != name));
        self.pages.extend(other.pages);
        self.tables.extend(other.tables);
        self.data.extend(other.data);
        self
    }

    /// As files, each written by the one writer of its format.
    ///
    /// # Errors
    /// If two columns of a table have the same name, or a chart cannot be drawn.
    pub(crate) fn contents(&self) -> Result<Contents, ReportError> {
        let pages = self.pages.iter().map(|(name, page)| Ok((name.clone(), page.markdown().into_bytes())));
        let tables = self.tables.iter().map(|(name, table)| Ok((name.clone(), table.csv(name)?)));
        let mut contents = pages.chain(tables).collect::<Result<Contents, ReportError>>()?;
        contents.extend(self.data.iter().cloned());
        contents.extend(chart::files(self.pages.iter().flat_map(|(_, page)| page.charts()))?);
        Ok(contents)
    }
}

/// Makes the table that a run was made for; nothing of one that was made for none. Tables know reports, reports know no table.
pub type Tables = fn(&Record) -> Result<Report, ReportError>;

/// Where pages of records are in a page of several.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Section {
    /// Fronts, which have sections of their own.
    Fronts,
    Need,
    /// A table of peers or of a paper.
    Table,
    Matrix,
    /// Other studies.
    Study,
    Run,
}

/// A study as far as reports know it.
pub(crate) struct Study {
    /// The verb that measures it.
    pub verb: &'static str,
    pub section: Section,
    /// What the names of its charts begin with.
    stems: &'static [&'static str],
    /// Whether a record is of it.
    is_of: fn(&Record) -> bool,
    /// What is made of such a record; of rows that are of no further study what [`of_run`] makes.
    report: Option<Maker>,
}

/// Makes what derives from a record of a study.
type Maker = fn(&Record) -> Option<Report>;

/// Every study, a line each. The first that a record is of makes what derives from it.
const STUDIES: &[Study] = &[
    study("sweep", Section::Study, &[sweep::STEM], |record| record.tuning.is_some(), Some(sweep::untimed)),
    study("stability", Section::Matrix, &[], |record| record.cases.is_some(), Some(stability::report)),
    study("pareto", Section::Fronts, &[pareto::STEM], |record| record.pareto.is_some(), Some(pareto::report)),
    study("need", Section::Need, &[need::STEM], |record| record.need.is_some(), Some(need::report)),
    study("frames", Section::Study, &[frames::STEM], |record| record.frames.is_some(), Some(frames::report)),
    study("attack", Section::Study, &[], |record| record.attack.is_some(), Some(attack::report)),
    study("explain", Section::Study, &[], |record| record.explanation.is_some(), Some(explain::report)),
    study("judge", Section::Run, &chart::STEMS, |record| record.judged.is_some(), None),
    study("sweep", Section::Study, &chart::STEMS, |record| record.sweep.is_some(), None),
    study("table", Section::Table, &chart::STEMS, |record| record.table.is_some(), None),
    study("run", Section::Run, &chart::STEMS, |_| true, None),
];

const fn study(
    verb: &'static str,
    section: Section,
    stems: &'static [&'static str],
    is_of: fn(&Record) -> bool,
    report: Option<Maker>,
) -> Study {
    Study { verb, section, stems, is_of, report }
}

impl Study {
    /// The study of a record.
    pub(crate) fn of(record: &Record) -> &'static Self {
        STUDIES.iter().find(|study| (study.is_of)(record)).unwrap_or(&STUDIES[STUDIES.len() - 1])
    }

    /// What derives from its record.
    pub(crate) fn report(&self, record: &Record, tables: Tables) -> Result<Report, ReportError> {
        match self.report {
            Some(report) => Ok(report(record).unwrap_or_default().and(tables(record)?)),
            None => of_run(record, tables),
        }
    }
}

/// Files: name and contents.
pub type Contents = Vec<(String, Vec<u8>)>;

/// What the names of derived files begin with, up to a dot or an underscore.
const BEGINNINGS: &str = "agreement_over_tolerance attack break_even claims error_vs explain figure frames need operating_points pareto rows stability \
                          summary sweep table verdicts wrong_rays";

/// Whether a verb that measures may write a file of this name, or a folder, right into its folder of results.
pub fn may_be_written(name: &str) -> bool {
    let begins = |begin: &str| name.strip_prefix(begin).is_some_and(|rest: &str| rest.starts_with(['.', '_']));
    let ends = [".md", ".csv", ".json", ".svg", ".png"].iter().any(|end| name.ends_with(end));
    ends && BEGINNINGS.split_whitespace().any(begins)
        || [RUN_FILE, PACKED, PICTURES_FOLDER, PAGE_FILE, "interleaved_sets", ATTACK_FOLDER].contains(&name)
}

/// Writes `run.json`, then what is derived from it; gives the paths in that order.
///
/// # Errors
/// If a file cannot be written, or a chart cannot be drawn.
pub fn write_run(record: &Record, folder: &OutputFolder, tables: Tables) -> Result<Vec<PathBuf>, ReportError> {
    // First, so that a failure in a chart costs the chart and not the measurements.
    let mut paths = vec![folder.write(RUN_FILE, &files::json(RUN_FILE, record)?)?];
    // An older record, compressed, would pass for this one's.
    folder.remove(PACKED);
    let kept: BTreeSet<String> = kept::picture_files(record).map(|name| format!("{PICTURES_FOLDER}/{name}")).collect();
    let pictures = folder.listed().into_iter().filter(|name| name.starts_with(PICTURES_FOLDER));
    pictures.filter(|name| !kept.contains(name)).for_each(|name| folder.remove(&name));
    paths.extend(write_derived(record, folder, tables)?);
    Ok(paths)
}

/// Takes the pictures that a record names from beside other records, as far as they are there and what they are called.
///
/// # Errors
/// If a file cannot be written.
pub fn take_pictures(record: &Record, from: &[PathBuf], folder: &OutputFolder) -> Result<(), ReportError> {
    for name in kept::picture_files(record) {
        if let Some(bytes) = from.iter().find_map(|path| kept::picture(path, name)) {
            folder.write(&format!("{PICTURES_FOLDER}/{name}"), &bytes)?;
        }
    }
    Ok(())
}

/// Writes what is derived from a record and gives the paths: the pages, tables and charts of what was asked.
///
/// # Errors
/// If a file cannot be written, or a chart cannot be drawn.
pub fn write_derived(record: &Record, folder: &OutputFolder, tables: Tables) -> Result<Vec<PathBuf>, ReportError> {
    let contents = contents(record, tables)?;
    let (study, paths) = (Study::of(record), write_all(&contents, folder)?);
    // Charts of scenes that only an older run in the same folder had would pass for this one's.
    for name in folder.listed().iter().filter(|name| contents.iter().all(|(written, _)| written != *name)) {
        let is_picture = [".svg", ".png"].iter().any(|ending| name.ends_with(ending));
        if is_picture && study.stems.iter().any(|stem| name.starts_with(stem)) {
            folder.remove(name);
        }
    }
    Ok(paths)
}

/// What is derived from a record: names and contents of the files that [`write_derived`] writes.
///
/// # Errors
/// If a chart cannot be drawn.
pub fn contents(record: &Record, tables: Tables) -> Result<Contents, ReportError> {
    let record = &*record.aligned();
    Study::of(record).report(record, tables)?.contents()
}

/// Writes files into a folder, and gives their paths.
pub(crate) fn write_all(contents: &Contents, folder: &OutputFolder) -> Result<Vec<PathBuf>, ReportError> {
    Ok(folder.write_all(contents.iter().map(|(name, contents)| (name.as_str(), contents.as_slice())))?)
}

/// What is made of a plain run: summary, traces and charts; of one that was made for a table or a sweep that, too.
fn of_run(record: &Record, of_table: Tables) -> Result<Report, ReportError> {
    let labelled = sweep::labelled(record);
    let (groups, shown) = (group::groups(record), group::groups(&labelled));
    let scenes = beside::over_scenes(&labelled, &shown).map(|page| (SCENES.to_owned(), page));
    let summary = Report {
        pages: scenes.into_iter().chain([(SUMMARY.to_owned(), summary::summary(&labelled, &shown))]).collect(),
        ..rows(record, &groups, Sheet::new(), |_| None::<()>)
    };
    let sweep = record.sweep.as_ref().map(|section| sweep::report(record, section, &groups)).unwrap_or_default();
    Ok(summary.and(of_table(record)?).and(sweep))
}

/// The page of a table.
pub fn table_page(name: &str) -> String {
    format!("table_{}.md", name.replace('-', "_"))
}

/// The most bytes of a record's JSON that are read, packed or not: fifteen times those of the largest record that is known.
pub const MAX_RECORD_BYTES: u64 = 512 << 20;

/// Reads a record back from its folder or from the file itself, plain or compressed by xz.
///
/// # Errors
/// If there is no such file, it is not a whole JSON document, it follows another schema, or it can be of no run.
pub fn read_run(path: &Path) -> Result<Record, ReportError> {
    let (file, path) = (RUN_FILE, record_file(path));
    let text = unpacked(&path)?;
    // Before everything else is looked at: a file of another schema lacks fields, and that would be said instead.
    let head: Result<Head, _> = serde_json::from_slice(&text);
    match head.map(|head| head.schema) {
        Ok(Some(schema)) if schema.as_u64() == Some(u64::from(SCHEMA)) => {}
        Ok(Some(schema)) => return Err(ReportError::Schema(path, schema.to_string(), SCHEMA)),
        Err(source) if !source.is_data() => return Err(ReportError::NotJson(path, file, source)),
        _ => return Err(ReportError::NoSchema(path, file)),
    }
    Record::read(&text).map_err(|reason| ReportError::Unmeasured(path, reason))
}

/// What is read of a record first.
#[derive(Deserialize)]
struct Head {
    schema: Option<serde_json::Value>,
}

/// The bytes of a file, unpacked where xz packed it.
///
/// # Errors
/// If it cannot be read, or has more than [`MAX_RECORD_BYTES`].
pub fn unpacked(path: &Path) -> Result<Vec<u8>, ReportError> {
    let fail = |source: std::io::Error| match source.kind() {
        ErrorKind::NotFound => ReportError::Missing(path.to_owned(), RUN_FILE),
        _ => ReportError::Read(path.to_owned(), source),
    };
    let mut file = BufReader::new(fs::File::open(path).map_err(fail)?);
    let mut bytes = Vec::new();
    if file.fill_buf().map_err(fail)?.starts_with(&XZ) {
        let unpacked = XzDecoder::new_multi_decoder(file).take(MAX_RECORD_BYTES + 1).read_to_end(&mut bytes);
        unpacked.map_err(|source| ReportError::Packed(path.to_owned(), source))?;
    } else {
        file.take(MAX_RECORD_BYTES + 1).read_to_end(&mut bytes).map_err(fail)?;
    }
    if bytes.len() as u64 > MAX_RECORD_BYTES {
        return Err(ReportError::TooLarge(path.to_owned(), MAX_RECORD_BYTES));
    }
    Ok(bytes)
}

/// What a compressed file begins with (the .xz file format, 2.1.1.1).
const XZ: [u8; 6] = *b"\xfd7zXZ\0";

/// The file of a record that is given by it or by its folder; the compressed one where that alone is there.
pub fn record_file(path: &Path) -> PathBuf {
    let (plain, packed) = (path.join(RUN_FILE), path.join(PACKED));
    match path.is_dir() {
        true if !plain.exists() && packed.exists() => packed,
        true => plain,
        false => path.to_owned(),
    }
}
