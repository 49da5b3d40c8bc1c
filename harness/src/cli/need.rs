//! `need`.

use std::ffi::OsString;

use clap::Args;
use serde_json::Value;

use super::arguments::{Selection, WorkArguments};
use super::work::{Clock, Work};
use super::{CliError, names};
use crate::measure::Context;
use crate::progress::Progress;
use crate::report;
use crate::studies::need;

#[derive(Args)]
pub(super) struct NeedArguments {
    /// Scenes: names from `list scenes`, or paths to .gltf or .glb files; several with commas. `all`: every listed one.
    #[arg(long, default_value = "room")]
    scene: OsString,
    /// Tracers: NAME or NAME:PRESET with commas, or all. Methods with nothing to shrink stand there with what they store and touch.
    #[arg(long, default_value = "all")]
    tracer: String,
    /// Ray sets: names from `list rays` with commas, file:DIR for a folder of rays, or all.
    #[arg(long, default_value = "diffuse,ao")]
    rays: String,
    #[command(flatten)]
    work: WorkArguments,
}

impl NeedArguments {
    fn selection(&self) -> Result<Selection, CliError> {
        let tracers = names::tracers(&self.tracer, &self.work.common.settings);
        Ok(Selection { between_samples: true, ..Selection::of(&self.scene, tracers, &self.rays)? })
    }
}

pub(super) fn need(arguments: &NeedArguments, progress: &Progress) -> Result<(), CliError> {
    let work = Work::prepare(&arguments.work, || arguments.selection(), Clock::Timed, progress)?;
    let execute = |context: &Context<'_>| need::execute(&work.plan, context);
    work.study("need", Value::Null, report::NEED_PAGE, progress, execute).map(drop)
}
