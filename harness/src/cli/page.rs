//! `report --html`.

use std::collections::BTreeSet;
use std::io::Read as _;
use std::path::{Path, PathBuf};

use super::CliError;
use crate::files::OutputFolder;
use crate::progress::Progress;
use crate::report::{self as reports, MAX_BYTES, Makers};
use crate::results::Record;
use crate::{papers, tables};

const MAKERS: Makers = Makers { tables: tables::of_run, claims: papers::claims_of };

/// Writes one page of all records, with what is missing beside them.
pub(super) fn write(
    file: &Path,
    (folder, name): (&OutputFolder, &str),
    paths: &[PathBuf],
    mut missing: Vec<String>,
    progress: &Progress,
) -> Result<(), CliError> {
    spares(file)?;
    folder.check(name)?;
    let mut records: Vec<(String, Record)> = Vec::new();
    for path in paths {
        if let Some(name) = claims_alone(path) {
            progress.say(&format!("{}: {name} is judged again by the records of its tables", path.display()));
            continue;
        }
        let record = reports::read_run(path)?;
        for name in reports::kept::others(path, &record) {
            progress
                .say(&format!("left out: {name} beside {} is not the picture that its record names", path.display()));
        }
        records.push((path.display().to_string(), record));
    }
    if records.is_empty() {
        return Err(CliError::Argument("claims alone are no record: give those of the tables, too".to_owned()));
    }
    let by: BTreeSet<u32> = records.iter().map(|(_, record)| record.provenance.rules_version).collect();
    if by.len() > 1 {
        let by = by.iter().map(u32::to_string).collect::<Vec<_>>().join(", ");
        missing.push(format!("records of one version of the rules: these are of {by}, and are not to be compared"));
    }
    for what in made(&records, &missing, &command(file, paths), (folder, name))? {
        progress.say(&format!("left out for want of room: {what}"));
    }
    progress.say(&file.display().to_string());
    Ok(())
}

/// Writes the page of a record that was just measured into its folder.
pub(super) fn beside(record: &Record, folder: &OutputFolder) -> Result<(), CliError> {
    let path = folder.path().to_owned();
    let records = [(path.display().to_string(), record.clone())];
    made(&records, &[], &command(&path.join(reports::PAGE_FILE), &[path]), (folder, reports::PAGE_FILE)).map(drop)
}

/// Writes a page, and gives what had no room.
fn made(
    records: &[(String, Record)],
    missing: &[String],
    command: &str,
    (folder, name): (&OutputFolder, &str),
) -> Result<Vec<String>, CliError> {
    let page = reports::html_page(records, missing, MAKERS, command, MAX_BYTES)?;
    folder.write(name, page.html.as_bytes())?;
    Ok(page.dropped)
}

/// Whoever takes `--html` for a switch names a record there: it is not written over, nor is anything else that is no page.
fn spares(file: &Path) -> Result<(), CliError> {
    let Ok(mut there) = std::fs::File::open(file) else { return Ok(()) };
    let mut begin = [0; 15];
    let read = there.read(&mut begin).unwrap_or(0);
    if read == 0 || begin[..read].eq_ignore_ascii_case(b"<!DOCTYPE html>") {
        return Ok(());
    }
    Err(CliError::Argument(format!(
        "--html {}: that is there and no HTML page; name the page to be written first, then the records: report --html page.html DIR...",
        file.display()
    )))
}

/// The claims that a folder holds and no record: what a table of claims writes.
fn claims_alone(folder: &Path) -> Option<String> {
    let holds = |name: &str| folder.join(name).exists();
    if holds(reports::RUN_FILE) || holds(&format!("{}.xz", reports::RUN_FILE)) {
        return None;
    }
    let names = papers::PAPERS.iter().map(|paper| format!("claims_{}.json", paper.name));
    names.into_iter().find(|name| holds(name))
}

/// The command line that makes the page again. Of a way from the root it has the last name: a page says nothing of where a machine keeps
/// what.
fn command(file: &Path, paths: &[PathBuf]) -> String {
    let shown =
        |path: &Path| path.file_name().filter(|_| path.is_absolute()).map_or(path, Path::new).display().to_string();
    let all = std::iter::once(file).chain(paths.iter().map(PathBuf::as_path));
    let quoted: Vec<String> = all.map(|path| reports::quoted(&shown(path))).collect();
    format!("tracebench report --html {}", quoted.join(" "))
}
