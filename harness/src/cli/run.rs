//! `run` and `report`.

use std::path::{Path, PathBuf};

use clap::Args;

use super::CliError;
use super::arguments::RunArguments;
use super::output::{print, print_end, print_written};
use super::work::{Clock, Work, all_measured, refuse_others};
use crate::files::OutputFolder;
use crate::progress::Progress;
use crate::{report as reports, tables};

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

pub(super) fn run(arguments: &RunArguments, progress: &Progress) -> Result<(), CliError> {
    let work = Work::prepare(&arguments.work, || arguments.selection(), Clock::Timed, progress)?;
    let record = work.measure("run", progress)?;
    print_end(&reports::run_table(&record), &work.bench.out.path().join("summary.md"))?;
    all_measured(&work.plan, &record)
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
    super::page::write(file, (&folder, &name), &arguments.paths, Vec::new(), progress)
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
        Some(faults) => Err(CliError::Other(faults.to_owned())),
    }
}

/// The folder that a file is in, or that is one.
pub(super) fn folder_of(path: &Path) -> PathBuf {
    if path.is_dir() { path.to_owned() } else { path.parent().map(Path::to_path_buf).unwrap_or_default() }
}
