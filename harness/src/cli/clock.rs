//! `doctor --clock`.

use std::ffi::OsString;
use std::io::Write as _;
use std::path::PathBuf;

use clap::Args;

use super::arguments::CommonArguments;
use super::output::print;
use super::work::{needs_device, wait_for_turn};
use super::{CliError, names, open_device};
use crate::files::{self, OutputFolder};
use crate::measure::{Context, Journal};
use crate::plan::{RUN_PRESETS, RunPreset, SAMPLING, TracerRequest};
use crate::progress::Progress;
use crate::results::{Provenance, SampleSchedule};
use crate::studies::clock::{self, ClockRecord, ClockTrial};
use crate::truth::Cache;

#[derive(Args)]
pub(super) struct ClockArguments {
    /// The tracer that is raced against itself, NAME or NAME:PRESET.
    #[arg(long)]
    tracer: Option<String>,
    /// Scene: a name from `list scenes`, or a path to a .gltf or .glb file.
    #[arg(long, default_value = "room")]
    scene: OsString,
    /// Ray set: a name from `list rays`.
    #[arg(long, default_value = "primary")]
    rays: String,
    /// Sets rays, resolutions and scene scale, not how long is sampled.
    #[arg(long, default_value = "quick", value_parser = RUN_PRESETS.map(|preset| preset.name))]
    preset: String,
    /// Interleaved sets, each of two that are the same and one that is slower.
    #[arg(long, value_name = "N", default_value_t = 20, value_parser = clap::value_parser!(u32).range(1..=1000))]
    interleaved_sets: u32,
    /// How much longer the slower one takes, percent: a multiple of 5.
    #[arg(long, value_name = "PERCENT", default_value_t = 15, value_parser = slowdown)]
    slowdown: u32,
    /// Threads of another job that comes and goes beside the interleaved sets.
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = clap::value_parser!(u32).range(0..=1024))]
    load: u32,
    /// In place of that, record the times of four that are the same and append them to a file, a line a round: KIND, the fixed kernel,
    /// then the four in the order in which they were sampled, milliseconds.
    #[arg(long, value_name = "FILE", requires = "kind")]
    record: Option<PathBuf>,
    /// What the recorded noise is called.
    #[arg(long, value_name = "NAME", requires = "record")]
    kind: Option<String>,
    /// In place of all that, measure warm-cache bias: trace rays of so many seeds in turn, each set once fresh and at once again.
    #[arg(long, value_name = "SEEDS", conflicts_with = "record", value_parser = clap::value_parser!(u64).range(2..=64))]
    fresh_rays: Option<u64>,
    /// Rounds of a recording, or of every interleaved set; that of `run` if not given.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=10_000))]
    samples: Option<u32>,
    /// Folder for `clock.json`, what came of it; nothing is written if not given.
    #[arg(long, value_name = "DIR", conflicts_with = "record")]
    out: Option<PathBuf>,
    #[command(flatten)]
    pub(super) common: CommonArguments,
}

fn slowdown(text: &str) -> Result<u32, String> {
    let found = text.parse().ok().filter(|percent: &u32| (5..=50).contains(percent) && percent.is_multiple_of(5));
    found.ok_or_else(|| "a multiple of 5 from 5 to 50".to_owned())
}

pub(super) fn clock(arguments: &ClockArguments, progress: &Progress) -> Result<(), CliError> {
    let tracers = names::tracers(arguments.tracer.as_deref().unwrap_or_default(), &arguments.common.settings)?;
    let [tracer] = tracers.as_slice() else {
        return Err(CliError::Argument("--tracer: clock measures one tracer against itself".to_owned()));
    };
    let ray_sets = names::ray_sets(&arguments.rays)?;
    if ray_sets.len() != 1 {
        return Err(CliError::Argument("--rays: clock traces one ray set".to_owned()));
    }
    let preset = RunPreset::named(&arguments.preset)
        .ok_or_else(|| CliError::Argument(format!("no preset '{}'", arguments.preset)))?;
    let preset = RunPreset { sampling: arguments.samples.map_or(SAMPLING, SampleSchedule::rounds), ..preset };
    let tracers = vec![TracerRequest { required: true, ..tracer.clone() }];
    let plan = arguments.common.plan_of(vec![names::scene(&arguments.scene)?], tracers, ray_sets, preset)?;
    let needed = needs_device(&plan.tracers);
    let device = open_device(&arguments.common.device, needed, needed)?;
    let out = arguments.out.as_deref().map(OutputFolder::open).transpose()?;
    out.as_ref().map_or(Ok(()), |out| out.check_all(|name| name == RECORD))?;
    let _turn = wait_for_turn();
    let provenance = Provenance::now(device.as_deref().ok());
    let (cache, journal) = (Cache::of_user(), Journal::none());
    let context = Context::new(&device, &cache, progress, &journal);
    let load = arguments.load as usize;
    if let (Some(path), Some(kind)) = (&arguments.record, &arguments.kind) {
        let fail = |error: std::io::Error| CliError::Other(format!("cannot write {}: {error}", path.display()));
        let mut file = std::fs::File::options().create(true).append(true).open(path).map_err(fail)?;
        let lines = clock::record(&plan, kind, load, &context)?;
        return file.write_all(lines.as_bytes()).map_err(fail);
    }
    let found = match arguments.fresh_rays {
        Some(seeds) => clock::repeats(&plan, seeds, &context)?,
        None => {
            let slowed = clock::REPEATS + (arguments.slowdown / 5) as usize;
            let tried = ClockTrial { interleaved_sets: arguments.interleaved_sets as usize, slowed, load };
            clock::execute(&plan, tried, &context)?
        }
    };
    let record = ClockRecord::new(provenance, &plan, found);
    if let Some(out) = out {
        out.write(RECORD, &files::json(RECORD, &record)?)?;
    }
    print(&record.text())
}

const RECORD: &str = "clock.json";
