//! `compare`.

use std::path::PathBuf;

use clap::Args;

use super::CliError;
use super::arguments::within;
use super::output::{print, print_text};
use crate::compare::{self, Comparison, DEFAULT_THRESHOLD};
use crate::report;
use crate::results::Record;

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
    let (a, b) = (report::read_run(&arguments.a)?, report::read_run(&arguments.b)?);
    let name = |path: &PathBuf| path.display().to_string();
    let (a, b) = ((name(&arguments.a), a), (name(&arguments.b), b));
    for (path, run) in [&a, &b] {
        sound_times(run).map_err(|what| CliError::Other(format!("{path}: {what}")))?;
    }
    let [by_a, by_b] = [&a.1, &b.1].map(|record| record.provenance.rules_version);
    if by_a != by_b {
        return Err(CliError::Other(format!(
            "{} was measured by version {by_a} of the rules, {} by version {by_b}: measure both by one",
            a.0, b.0
        )));
    }
    let found = compare::compare((&a.0, &a.1), (&b.0, &b.1), arguments.threshold / 100.0);
    if arguments.json {
        let json = serde_json::to_string_pretty(&found).map_err(|error| CliError::Other(error.to_string()))?;
        print(&(json + "\n"))?;
    } else {
        print_text(&report::comparison_text(&found))?;
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
        for (what, times) in of_build.chain(of_traces) {
            if times.samples_ms.is_empty() || times.samples_ms.contains(&0.0) {
                return Err(format!(
                    "{} on {}, {what}: there are no times, or some of nothing; run it again",
                    one.tracer.label(),
                    one.scene.name
                ));
            }
        }
    }
    Ok(())
}

/// Whether nothing got worse, which nothing in common cannot show.
fn outcome(found: &Comparison) -> Result<(), CliError> {
    let regressions = found.regressions();
    if found.is_empty() {
        return Err(CliError::Other("nothing stands in both runs, so nothing was compared".to_owned()));
    }
    match regressions.len() {
        0 => Ok(()),
        count => Err(CliError::Other(format!("{count} got worse: {}", regressions.join("; ")))),
    }
}
