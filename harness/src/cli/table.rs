//! `table`.

use std::path::Path;

use super::arguments::TableArguments;
use super::output::print;
use super::run::{OutputFolder, Work, folder_of, say_skipped};
use super::{CliError, names};
use crate::papers::Experiment;
use crate::peers::{self, Subject};
use crate::progress::Progress;
use crate::studies::updates::{self, DEFAULT_FRAMES};
use crate::tables::{self, Table};
use crate::truth::Cache;
use crate::{measure, report};

pub(super) fn table(arguments: &TableArguments, progress: &Progress) -> Result<(), CliError> {
    let table = names::table(&arguments.name)?;
    let moving = matches!(table, Table::Peers(peers::Table { subject: Subject::Moving, .. }));
    if !moving && arguments.frames.is_some() {
        return Err(CliError::Argument(format!("--frames: table {} is not over animations", table.name())));
    }
    if moving && arguments.work.common.time != 0.0 {
        return Err(CliError::Argument(format!("--time: table {} is over whole animations", table.name())));
    }
    if let Some(path) = &arguments.from {
        return again(table, moving, path, arguments.work.out.as_deref());
    }
    let mut work = Work::prepare(&arguments.work, || arguments.matter(table), progress)?;
    match table {
        Table::Peers(table) if moving => {
            let frames = arguments.frames.unwrap_or(DEFAULT_FRAMES);
            let found = updates::execute(table, &work.plan, frames, &work.device, &Cache::of_user(), progress)
                .inspect_err(|_| work.out.abandon())?;
            say_skipped(&found.skipped, progress);
            report::write_updates(&found, &work.out.path)?;
        }
        Table::Peers(_) => {
            work.measure(progress)?;
        }
        Table::Paper(_, experiment) => measure(experiment, arguments, &mut work, progress)?,
    }
    show(table, &work.out.path)
}

/// Runs an experiment's steps into one run.
fn measure(
    experiment: &'static Experiment,
    arguments: &TableArguments,
    work: &mut Work,
    progress: &Progress,
) -> Result<(), CliError> {
    let settings = &arguments.work.common.settings;
    let own = experiment.settings.iter().map(|setting| (*setting).to_owned());
    // What the user says comes later and counts.
    work.plan.ray_parameters = names::ray_values(&own.chain(settings.iter().cloned()).collect::<Vec<_>>())?;
    let steps = names::steps(experiment, settings)?;
    let plans = experiment.plans(&work.plan, &steps).map_err(|error| CliError::Argument(error.to_string()));
    let run = plans
        .and_then(|plans| Ok(measure::execute_all(&plans, &work.device, &Cache::of_user(), progress)?))
        .inspect_err(|_| work.out.abandon())?;
    say_skipped(&run.skipped, progress);
    report::write_run(&run, &work.out.path, tables::of_run)?;
    Ok(())
}

/// Makes the table of what was measured before.
fn again(table: Table, moving: bool, path: &Path, out: Option<&Path>) -> Result<(), CliError> {
    let open = || match out {
        Some(out) => OutputFolder::open(out).map(|folder| folder.path),
        None => Ok(folder_of(path)),
    };
    // Read before anything is written.
    let folder = if moving {
        let updates = report::read_updates(path)?;
        let folder = open()?;
        report::write_updates_table(&updates, &folder)?;
        folder
    } else {
        let run = report::read_run(path)?;
        let folder = open()?;
        tables::write(table, &run, &folder)?;
        folder
    };
    show(table, &folder)
}

/// The table itself, and where it stands.
fn show(table: Table, folder: &Path) -> Result<(), CliError> {
    let path = report::table_page(table.name(), folder);
    let text = std::fs::read_to_string(&path)
        .map_err(|error| CliError::Other(format!("cannot read {}: {error}", path.display())))?;
    print(&format!("{text}\n{}\n", path.display()))
}
