//! `table`.

use std::path::Path;

use super::arguments::TableArguments;
use super::output::print;
use super::run::{OutputFolder, Work, folder_of, say_skipped};
use super::{CliError, names};
use crate::peers::{Subject, Table};
use crate::progress::Progress;
use crate::report;
use crate::truth::Cache;
use crate::updates::{self, DEFAULT_FRAMES};

pub(super) fn table(arguments: &TableArguments, progress: &Progress) -> Result<(), CliError> {
    let table = names::table(&arguments.name)?;
    if table.subject == Subject::Still && arguments.frames.is_some() {
        return Err(CliError::Argument(format!("--frames: table {} is not over animations", table.name)));
    }
    if table.subject == Subject::Moving && arguments.work.common.time != 0.0 {
        return Err(CliError::Argument(format!("--time: table {} is over whole animations", table.name)));
    }
    if let Some(path) = &arguments.from {
        return again(table, path, arguments.work.out.as_deref());
    }
    let work = Work::prepare(&arguments.work, || arguments.matter(table), progress)?;
    match table.subject {
        Subject::Still => {
            work.measure(progress)?;
        }
        Subject::Moving => {
            let frames = arguments.frames.unwrap_or(DEFAULT_FRAMES);
            let found = updates::execute(table, &work.plan, frames, &work.device, &Cache::of_user(), progress)
                .inspect_err(|_| work.out.abandon())?;
            say_skipped(&found.skipped, progress);
            report::write_updates(&found, &work.out.path)?;
        }
    }
    show(table, &work.out.path)
}

/// Makes the table of what was measured before.
fn again(table: &Table, path: &Path, out: Option<&Path>) -> Result<(), CliError> {
    // Read before anything is written.
    let found = match table.subject {
        Subject::Still => report::Measured::Run(Box::new(report::read_run(path)?)),
        Subject::Moving => report::Measured::Updates(Box::new(report::read_updates(path)?)),
    };
    let folder = match out {
        Some(out) => OutputFolder::open(out)?.path,
        None => folder_of(path),
    };
    match found {
        report::Measured::Run(run) => report::write_table(table, &run, &folder)?,
        report::Measured::Updates(updates) => report::write_updates_table(&updates, &folder)?,
    };
    show(table, &folder)
}

/// The table itself, and where it stands.
fn show(table: &Table, folder: &Path) -> Result<(), CliError> {
    let path = report::table_page(table, folder);
    let text = std::fs::read_to_string(&path)
        .map_err(|error| CliError::Other(format!("cannot read {}: {error}", path.display())))?;
    print(&format!("{text}\n{}\n", path.display()))
}
