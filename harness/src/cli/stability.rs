//! `stability`.

use std::fmt::Display;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use clap::Args;
use serde_json::json;

use super::arguments::DeviceArguments;
use super::output::{print, print_end};
use super::work::{Bench, Clock, OutputArguments, described, needs_device};
use super::{CliError, names, open_device};
use crate::files;
use crate::measure::records;
use crate::plan::TracerRequest;
use crate::progress::Progress;
use crate::report;
use crate::studies::stability;
use crate::studies::stability::{ExpectedShares, Stability};

#[derive(Args)]
pub(super) struct StabilityArguments {
    /// Tracers: NAME or NAME:PRESET with commas, or all.
    #[arg(long, default_value = "all")]
    tracer: String,
    /// Cases: names from `list cases` with commas, or all.
    #[arg(long, default_value = "all")]
    case: String,
    /// A parameter on top of the preset: tracer.parameter=value, as in `list tracers`. May be repeated. Verdicts are
    /// shown then but do not count.
    #[arg(long = "set", value_name = "T.P=V", allow_hyphen_values = true)]
    settings: Vec<String>,
    /// Measure nothing: put the shares of wrong rays of the records --from into FILE, as what is expected on adapters of their kind.
    #[arg(long, value_name = "FILE", requires = "from")]
    expect: Option<PathBuf>,
    /// A record of stability cases, for --expect. May be repeated; of two that measured the same the later counts.
    #[arg(long, value_name = "RUN", requires = "expect")]
    from: Vec<PathBuf>,
    #[command(flatten)]
    device: DeviceArguments,
    #[command(flatten)]
    output: OutputArguments,
}

pub(super) fn stability(arguments: &StabilityArguments, progress: &Progress) -> Result<(), CliError> {
    if let Some(path) = &arguments.expect {
        return expect(path, &arguments.from);
    }
    // Arguments are checked before any device or file is touched.
    let mut requests = names::tracers(&arguments.tracer, &arguments.settings)?;
    names::tracers_only(&arguments.settings)?;
    if arguments.settings.is_empty() {
        // Tracers that `all` has in several forms are expected something of in their own.
        requests.retain(|request| request.required || request.changed.is_empty());
    }
    let cases = names::cases(&arguments.case)?;
    let required = requests.iter().any(TracerRequest::must_have_device);
    let device = open_device(&arguments.device, needs_device(&requests), required)?;
    let bench = Bench::open(device, &arguments.output, Clock::Untimed, &mut requests, progress)?;
    let words = |request: &TracerRequest| records::request_record(request);
    let tracers: Vec<_> = requests.iter().map(words).collect();
    let names: Vec<&str> = cases.iter().map(|case| case.name).collect();
    let plan = described("stability", &[], json!({ "cases": names, "tracers": tracers }));
    let record = bench.measure(&plan, progress, |context| stability::run(&cases, &requests, context))?;
    let Some(found) = Stability::of(&record) else { return Ok(()) };
    let written = bench.out.path().join(report::STABILITY_TABLE);
    let surprises = found.surprises().len();
    let said = if surprises == 0 { "All as expected.".to_owned() } else { format!("{surprises} unexpected.") };
    print_end(&format!("{said}\n{}", report::stability_matrix(&found)), &written)?;
    outcome(&found)
}

/// Puts what records measured into a file of expected shares. What stands there of other adapters, tracers and cases stays.
fn expect(path: &Path, from: &[PathBuf]) -> Result<(), CliError> {
    let fail = |path: &Path, error: &dyn Display| CliError::Other(format!("{}: {error}", path.display()));
    let mut shares = match std::fs::read_to_string(path) {
        Ok(text) => ExpectedShares::parse(&text).map_err(|error| fail(path, &format!("left as it is: {error}")))?,
        Err(error) if error.kind() == ErrorKind::NotFound => ExpectedShares::default(),
        Err(error) => return Err(fail(path, &error)),
    };
    for record in from {
        shares.take(&report::read_run(record)?).map_err(|error| fail(record, &error))?;
    }
    // What is there was read as such a file: it is a document that grows.
    let write = if path.exists() { files::edit } else { files::write };
    write(path, shares.text().as_bytes()).map_err(|error| fail(path, &error))?;
    print(&format!("{}\n", path.display()))
}

/// Whether all came as expected, where that counts.
fn outcome(found: &Stability) -> Result<(), CliError> {
    let surprises = found.surprises();
    if surprises.is_empty() || !found.counts {
        return Ok(());
    }
    Err(CliError::Other(format!("{} unexpected: {}", surprises.len(), surprises.join("; "))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measure::{Context, Journal};
    use crate::studies::stability::Verdict;
    use crate::truth::Cache;

    /// Surprises in either direction and invalid cases end with 1 and name case and tracer, unless parameters were changed.
    #[test]
    fn surprises_are_errors() {
        let requests = names::tracers("bvh-cpu", &[]).unwrap();
        let device = Err(tracebench_api::TracerError::Unavailable("none is needed".to_owned()));
        let cases = names::cases("edge-on").unwrap();
        let (cache, quiet, journal) = (Cache::none(), Progress::new(true), Journal::none());
        let record = stability::run(&cases, &requests, &Context::new(&device, &cache, &quiet, &journal)).unwrap();
        let found = Stability::of(&record).unwrap();
        assert!(outcome(&found).is_ok());
        for verdict in [Verdict::UnexpectedFailure, Verdict::UnexpectedSuccess] {
            let mut changed = found.clone();
            changed.cases[0].cells[0].verdict = verdict;
            let error = outcome(&changed).unwrap_err();
            assert!(error.to_string().contains("edge-on, bvh-cpu: exact"), "{error}");
            assert_eq!(error.exit_code(), std::process::ExitCode::from(1));
            changed.counts = false;
            assert!(outcome(&changed).is_ok());
        }
        let mut invalid = found;
        invalid.cases[0].case.invalid = Some("the oracle erred".to_owned());
        assert!(outcome(&invalid).unwrap_err().to_string().contains("the oracle erred"));
        assert!(report::stability_matrix(&invalid).contains("edge-on (VOID)"));
    }
}
