//! `table`.

use std::path::Path;

use serde_json::{Value, json};

use super::arguments::TableArguments;
use super::output::print;
use super::run::folder_of;
use super::work::{Clock, OutputFolder, Work, described};
use super::{CliError, names};
use crate::measure::{self, Context};
use crate::papers::Experiment;
use crate::progress::Progress;
use crate::report;
use crate::studies::updates::{self, DEFAULT_FRAMES};
use crate::tables::{self, Table};

pub(super) fn table(arguments: &TableArguments, progress: &Progress) -> Result<(), CliError> {
    let table = names::table(&arguments.name)?;
    let moving = table.is_moving();
    if !moving && arguments.frames.is_some() {
        return Err(CliError::Argument(format!("--frames: table {} is not over animations", table.name())));
    }
    if moving && arguments.work.common.time != 0.0 {
        return Err(CliError::Argument(format!("--time: table {} is over whole animations", table.name())));
    }
    if let Some(path) = &arguments.from {
        return again(table, path, arguments.work.output.out.as_deref());
    }
    let mut work = Work::prepare(&arguments.work, || arguments.matter(table), Clock::Timed, progress)?;
    match table {
        Table::Peers(table) if moving => {
            let frames = arguments.frames.unwrap_or(DEFAULT_FRAMES);
            let plan = described("table", std::slice::from_ref(&work.plan), json!({ "frames": frames }));
            let execute = |context: &Context<'_>| updates::execute(table, &work.plan, frames, context);
            work.bench.measure(&plan, progress, execute)?;
        }
        Table::Peers(_) | Table::Means => {
            work.measure("table", progress)?;
        }
        Table::Paper(_, experiment) => measure(experiment, arguments, &mut work, progress)?,
    }
    show(table, &work.bench.out.path)
}

/// Runs an experiment's steps into one run.
fn measure(
    experiment: &'static Experiment,
    arguments: &TableArguments,
    work: &mut Work<'_>,
    progress: &Progress,
) -> Result<(), CliError> {
    let settings = &arguments.work.common.settings;
    let own = experiment.settings.iter().map(|setting| (*setting).to_owned());
    // What the user says comes later and counts.
    work.plan.ray_parameters = names::ray_values(&own.chain(settings.iter().cloned()).collect::<Vec<_>>())?;
    let steps = names::steps(experiment, settings)?;
    let plans = experiment.plans(&work.plan, &steps).map_err(|error| CliError::Argument(error.to_string()));
    let mut plans = plans.inspect_err(|_| work.bench.out.abandon())?;
    plans.iter_mut().for_each(|plan| work.bench.give_means(&mut plan.tracers));
    let words = described("table", &plans, Value::Null);
    work.bench.measure(&words, progress, |context| measure::execute_all(&plans, context))?;
    Ok(())
}

/// Makes the table of what was measured before.
fn again(table: Table, path: &Path, out: Option<&Path>) -> Result<(), CliError> {
    let open = || match out {
        Some(out) => OutputFolder::open(out).map(|folder| folder.path),
        None => Ok(folder_of(path)),
    };
    // Read before anything is written.
    let run = report::read_run(path)?;
    let folder = open()?;
    tables::write(table, &run, &folder)?;
    show(table, &folder)
}

/// The table itself, and where it stands.
fn show(table: Table, folder: &Path) -> Result<(), CliError> {
    let path = report::table_page(table.name(), folder);
    let text = std::fs::read_to_string(&path)
        .map_err(|error| CliError::Other(format!("cannot read {}: {error}", path.display())))?;
    print(&format!("{text}\n{}\n", path.display()))
}
