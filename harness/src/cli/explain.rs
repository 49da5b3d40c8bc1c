//! `explain`.

use std::ffi::OsString;

use clap::Args;
use serde_json::Value;

use super::arguments::{Selection, WorkArguments};
use super::output::print_page;
use super::work::{Clock, Work, described};
use super::{CliError, names};
use crate::measure::Context;
use crate::plan::TracerRequest;
use crate::progress::Progress;
use crate::registry::{self, Registration, TRACERS};
use crate::report;
use crate::studies::explain;

#[derive(Args)]
pub(super) struct ExplainArguments {
    /// Scenes: names from `list scenes`, or paths to .gltf or .glb files; several with commas. `all`: every listed one.
    #[arg(long, default_value = "all")]
    scene: OsString,
    /// The tracer, NAME or NAME:PRESET: one whose weaknesses can be taken away.
    #[arg(long, default_value = registry::first(explainable).map(Registration::name))]
    tracer: String,
    /// Ray sets: names from `list rays` with commas, file:DIR for a folder of rays, or all.
    #[arg(long, default_value = "all")]
    rays: String,
    #[command(flatten)]
    work: WorkArguments,
}

fn explainable(tracer: &Registration) -> bool {
    !tracer.remedies.is_empty()
}

impl ExplainArguments {
    fn request(&self) -> Result<TracerRequest, CliError> {
        let tracers = names::tracers(&self.tracer, &self.work.common.settings)?;
        match tracers.as_slice() {
            [one] => Ok(TracerRequest { required: true, ..one.clone() }),
            _ => Err(CliError::Argument("explain takes one tracer".to_owned())),
        }
    }

    fn selection(&self) -> Result<Selection, CliError> {
        Selection::of(&self.scene, self.request().map(|request| vec![request]), &self.rays)
    }
}

pub(super) fn explain(arguments: &ExplainArguments, progress: &Progress) -> Result<(), CliError> {
    let request = arguments.request()?;
    let remedies = &request.registration.remedies;
    if remedies.is_empty() {
        let known: Vec<_> = TRACERS.iter().filter(|each| explainable(each)).map(Registration::name).collect();
        return Err(CliError::Argument(format!(
            "--tracer: {} has no remedy sequence; there is one of: {}",
            request.name(),
            known.join(", ")
        )));
    }
    if arguments.work.says_how_long() {
        return Err(CliError::Argument(
            "--samples, --ratio-precision, --time-limit: explain takes no times".to_owned(),
        ));
    }
    let work = Work::prepare(&arguments.work, || arguments.selection(), Clock::Untimed, progress)?;
    // By the means that it has here.
    let request = &work.plan.tracers[0];
    let plan = described("explain", std::slice::from_ref(&work.plan), Value::Null);
    let execute = |context: &Context<'_>| explain::execute(&work.plan, request, remedies, context);
    let record = work.bench.measure(&plan, progress, execute)?;
    let Some(found) = &record.explanation else { return Ok(()) };
    let page = work.bench.out.path().join(report::EXPLAIN_PAGE);
    print_page(&page, Some("## By scene"))?;
    let open: Vec<String> = found
        .left_open()
        .into_iter()
        .map(|(scene, set)| format!("{} of {} {} in {scene}", set.unexplained, set.count, set.rays))
        .collect();
    match open.is_empty() {
        true => Ok(()),
        false => Err(CliError::Other(format!(
            "rays are wrong on the last step and no known cause explains them: {}",
            open.join(", ")
        ))),
    }
}
