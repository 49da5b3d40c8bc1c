//! `report`, `compare` and `merge`: the verbs over records.

use std::collections::BTreeSet;
use std::io::Read as _;
use std::path::{Path, PathBuf};

use clap::Args;

use super::output::{print, print_text, print_written};
use super::work::refuse_others;
use super::{CliError, fail, fail_for, refuse};
use crate::compare::{self, Comparison, DEFAULT_THRESHOLD};
use crate::files::OutputFolder;
use crate::measure::Journal;
use crate::plan::within;
use crate::progress::Progress;
use crate::report::{self as reports, MAX_BYTES, Makers, ReportError};
use crate::results::{Record, merge};
use crate::{papers, tables};

#[derive(Args)]
pub(super) struct ReportArguments {
    /// Records: run.json files, plain or compressed by xz, of whatever verb, or the folders that hold them.
    #[arg(required = true, value_name = "RECORD")]
    paths: Vec<PathBuf>,
    /// Write one page of all records here, which needs no other file: which to choose, fronts, tables, claims, causes. Nothing else is made
    /// then.
    #[arg(long, value_name = "FILE")]
    html: Option<PathBuf>,
    /// Write the rows of all records here as one table, for notebooks: comma-separated values, units in the column names. Nothing else is
    /// made then.
    #[arg(long, value_name = "FILE", conflicts_with = "html")]
    csv: Option<PathBuf>,
    /// Write nothing: say of each folder what speaks against handing it in (RULES.md), and what to do.
    #[arg(long, conflicts_with_all = ["html", "csv"])]
    check: bool,
}

pub(super) fn report(arguments: &ReportArguments, progress: &Progress) -> Result<(), CliError> {
    if arguments.check {
        return check(&arguments.paths, progress);
    }
    if let Some(file) = &arguments.csv {
        let (folder, name) = OutputFolder::of_file(file)?;
        folder.check(&name)?;
        let table = reports::flat_table(&arguments.paths, |path| progress.say(path))?;
        folder.write(&name, &table)?;
        return print(&format!("{}\n", file.display()));
    }
    let Some(file) = &arguments.html else {
        for path in &arguments.paths {
            let record = reports::read_run(path)?;
            let folder = OutputFolder::open(&folder_of(path))?;
            refuse_others(folder.path(), std::iter::once(path))?;
            print_written(&reports::write_derived(&record, &folder, tables::of_run)?)?;
        }
        return Ok(());
    };
    let (folder, name) = OutputFolder::of_file(file)?;
    write_page(file, (&folder, &name), &arguments.paths, Vec::new(), progress)
}

const MAKERS: Makers = (tables::of_run, papers::claims_of);

/// Writes one page of all records, with what is missing beside them.
pub(super) fn write_page(
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
            let path = path.display();
            progress.say(&format!("left out: {name} beside {path} is not the picture that its record names"));
        }
        records.push((path.display().to_string(), record));
    }
    if records.is_empty() {
        return refuse("claims alone are no record: give those of the tables, too");
    }
    let by: BTreeSet<u32> = records.iter().map(|(_, record)| record.provenance.rules_version).collect();
    if by.len() > 1 {
        let by = by.iter().map(u32::to_string).collect::<Vec<_>>().join(", ");
        missing.push(format!("records of one version of the rules: these are of {by}, and are not to be compared"));
    }
    let page = reports::html_page(&records, &missing, MAKERS, &command(file, paths), MAX_BYTES)?;
    folder.write(name, page.html.as_bytes())?;
    for what in page.dropped {
        progress.say(&format!("left out for want of room: {what}"));
    }
    progress.say(&file.display().to_string());
    Ok(())
}

/// Writes the page of a record that was just measured into its folder.
pub(super) fn beside(record: &Record, folder: &OutputFolder) -> Result<(), CliError> {
    let path = folder.path().to_owned();
    let records = [(path.display().to_string(), record.clone())];
    let command = command(&path.join(reports::PAGE_FILE), &[path]);
    let page = reports::html_page(&records, &[], MAKERS, &command, MAX_BYTES)?;
    folder.write(reports::PAGE_FILE, page.html.as_bytes())?;
    Ok(())
}

/// Whoever takes `--html` for a switch names a record there: it is not written over, nor is anything else that is no page.
fn spares(file: &Path) -> Result<(), CliError> {
    let Ok(mut there) = std::fs::File::open(file) else { return Ok(()) };
    let mut begin = [0; 15];
    let read = there.read(&mut begin).unwrap_or(0);
    if read == 0 || begin[..read].eq_ignore_ascii_case(b"<!DOCTYPE html>") {
        return Ok(());
    }
    refuse(format!(
        "--html {}: that is there and no HTML page; name the page to be written first, then the records: report --html page.html DIR...",
        file.display()
    ))
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

/// Says of folders that they are as RULES.md asks, or fails with what is not.
fn check(folders: &[PathBuf], progress: &Progress) -> Result<(), CliError> {
    let user = ["USER", "LOGNAME", "USERNAME"].iter().find_map(|name| std::env::var(name).ok());
    // Whoever works as root, or in a container, has a name that is a word of records.
    let user = user.filter(|user| user.len() > 2 && user != "root");
    let mut faults = String::new();
    for path in folders {
        let folder = if path.is_file() { Path::new(".").join(folder_of(path)) } else { path.clone() };
        progress.say(&format!("checking {}", folder.display()));
        for fault in reports::check(&folder, tables::of_run, super::parses, user.as_deref())? {
            faults += &format!("\nerror: {}: {fault}", folder.display());
        }
    }
    match faults.strip_prefix("\nerror: ") {
        None => print("as RULES.md asks: commit, preset, controls, command, list, derived files, no path or user\n"),
        Some(faults) => fail(faults),
    }
}

/// The folder that a file is in, or that is one.
pub(super) fn folder_of(path: &Path) -> PathBuf {
    if path.is_dir() { path.to_owned() } else { path.parent().map(Path::to_path_buf).unwrap_or_default() }
}

#[derive(Args)]
pub(super) struct CompareArguments {
    /// The run that is compared with: a run.json, or the folder that holds it.
    a: PathBuf,
    /// The run that is compared.
    b: PathBuf,
    /// As one JSON object.
    #[arg(long)]
    json: bool,
    /// How much longer the slower must take to count, percent, beside being beyond noise.
    #[arg(long, value_name = "PERCENT", default_value_t = DEFAULT_THRESHOLD * 100.0,
          value_parser = within(0.0..=1000.0, "a number of percent from 0 to 1000"),
          allow_hyphen_values = true)]
    threshold: f64,
    /// End with status 1 if something got slower or less accurate beyond noise, or if the runs have nothing in common.
    #[arg(long)]
    fail_on_regression: bool,
}

pub(super) fn compare(arguments: &CompareArguments) -> Result<(), CliError> {
    let (a, b) = (reports::read_run(&arguments.a)?, reports::read_run(&arguments.b)?);
    let name = |path: &PathBuf| path.display().to_string();
    let (a, b) = ((name(&arguments.a), a), (name(&arguments.b), b));
    for (path, run) in [&a, &b] {
        sound_times(run).map_err(|what| CliError::Other(format!("{path}: {what}")))?;
    }
    let [by_a, by_b] = [&a.1, &b.1].map(|record| record.provenance.rules_version);
    if by_a != by_b {
        let (a, b) = (&a.0, &b.0);
        return fail(format!(
            "{a} was measured by version {by_a} of the rules, {b} by version {by_b}: measure both by one"
        ));
    }
    let found = compare::compare((&a.0, &a.1), (&b.0, &b.1), arguments.threshold / 100.0);
    if arguments.json {
        let json = serde_json::to_string_pretty(&found).map_err(|error| CliError::Other(error.to_string()))?;
        print(&(json + "\n"))?;
    } else {
        print_text(&reports::comparison_text(&found))?;
    }
    if arguments.fail_on_regression { outcome(&found) } else { Ok(()) }
}

/// That every row of a record that takes times has some: a row without would pass unseen.
fn sound_times(record: &Record) -> Result<(), String> {
    if record.is_untimed() {
        return Ok(());
    }
    for one in &record.rows {
        let of_build = one.build.all().map(|times| ("its build".to_owned(), times));
        let of_traces = one.traces.iter().map(|trace| (trace.rays.clone(), &trace.times));
        let mut all = of_build.chain(of_traces);
        if let Some((what, _)) = all.find(|(_, times)| times.samples_ms.is_empty() || times.samples_ms.contains(&0.0)) {
            let (tracer, scene) = (one.tracer.label(), &one.scene.name);
            return Err(format!("{tracer} on {scene}, {what}: there are no times, or some of nothing; run it again"));
        }
    }
    Ok(())
}

/// Whether nothing got worse, which nothing in common cannot show.
fn outcome(found: &Comparison) -> Result<(), CliError> {
    if found.is_empty() {
        return fail("nothing stands in both runs, so nothing was compared");
    }
    let regressions = found.regressions();
    fail_for(&regressions, "; ", |all| format!("{} got worse: {all}", regressions.len()))
}

#[derive(Args)]
pub(super) struct MergeArguments {
    /// Every shard of one plan: run.json files, or the folders that hold them.
    #[arg(required = true)]
    shards: Vec<PathBuf>,
    /// Folder for the joined record and what derives from it.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
}

pub(super) fn merge_shards(arguments: &MergeArguments) -> Result<(), CliError> {
    let place = |path: &Path| std::fs::canonicalize(folder_of(path)).ok();
    if arguments.shards.iter().any(|shard| place(shard).is_some() && place(shard) == place(&arguments.out)) {
        return refuse("--out: it is one of the shards, which would be overwritten");
    }
    let read = |path: &PathBuf| Ok((path.display().to_string(), reports::read_run(path)?));
    let shards = arguments.shards.iter().map(read).collect::<Result<Vec<_>, CliError>>()?;
    let whole = merge(shards).map_err(CliError::Other)?;
    if whole.rows.is_empty() && whole.frames.as_ref().is_none_or(|frames| frames.rows.is_empty()) {
        return fail("nothing was measured in any shard");
    }
    let folder = OutputFolder::open(&arguments.out)?;
    folder.check_all(reports::may_be_written)?;
    let is_same = match reports::read_run(folder.path()) {
        Ok(record) => {
            record.provenance.shard.is_none() && record.provenance.plan_sha256 == whole.provenance.plan_sha256
        }
        Err(ReportError::Missing(..)) => !Journal::is_in(folder.path()),
        Err(_) => false,
    };
    if !is_same {
        return refuse(format!("{} holds another record: choose another folder with --out", arguments.out.display()));
    }
    let written = reports::write_run(&whole, &folder, tables::of_run)?;
    reports::take_pictures(&whole, &arguments.shards, &folder)?;
    beside(&whole, &folder)?;
    print_written(&written)
}
