//! `doctor`, and `doctor --clock`.

use std::ffi::OsString;
use std::io::Write as _;
use std::path::PathBuf;

use clap::{Arg, Args};
use serde_json::json;
use tracebench_api::{AdapterChoice, AdapterInfo, Gpu, TracerError};

use super::arguments::{CommonArguments, Selection};
use super::output::{print, print_json};
use super::work::wait_for_turn;
use super::{CliError, names, open_device, refuse};
use crate::files::{self, OutputFolder};
use crate::machine::{self, Machine};
use crate::measure::{Context, Journal};
use crate::plan::{RUN_PRESETS, RunPreset, SAMPLING};
use crate::progress::Progress;
use crate::report::format::mib;
use crate::results::{Provenance, SampleSchedule};
use crate::studies::clock::{self, ClockRecord, ClockTrial};
use crate::truth::Cache;

#[derive(Args)]
pub(super) struct DoctorArguments {
    /// As one JSON object.
    #[arg(long, conflicts_with = "clock")]
    json: bool,
    /// Try the clock: time a tracer beside itself, and beside itself with more to do, and count what is said.
    #[arg(long, requires = "tracer")]
    clock: bool,
    #[command(flatten)]
    of_clock: ClockArguments,
}

/// What `doctor` takes without `--clock`.
const WITHOUT_CLOCK: [&str; 6] = ["json", "clock", "adapter", "limits", "quiet", "until_stdin_ends"];

/// Binds every option that is about the clock to `--clock`.
pub(super) fn options(option: Arg) -> Arg {
    let is_free = WITHOUT_CLOCK.iter().any(|name| option.get_id() == name);
    if is_free { option } else { option.requires("clock") }
}

/// What this machine lacks, each with what to do, by the device that a run would take.
fn missing(adapters: &[AdapterInfo], opened: &Result<Gpu, TracerError>) -> Vec<[String; 2]> {
    let gpu = match opened {
        Ok(gpu) => gpu,
        Err(error) => return vec![["a device; tracers of the host run without".to_owned(), error.to_string()]],
    };
    let hardware = adapters.iter().position(|adapter| adapter.kind != "software");
    let hardware = hardware.map_or_else(
        || "install the Vulkan driver of this machine's GPU, if it has one".to_owned(),
        |number| format!("name one that is none: --adapter {number}"),
    );
    let queries = "install a driver that has them (Mesa 25 on software), and leave --limits out";
    let lacks = [
        (gpu.is_software(), "hardware: times by a software adapter say little of it", &*hardware),
        (
            !gpu.listing.timestamps,
            "timestamps: device work is timed by the host's clock",
            "nothing: accuracy is the same",
        ),
        (!gpu.has_ray_queries(), "ray queries: a tracer that needs them is skipped", queries),
    ];
    lacks.into_iter().filter(|(lacks, ..)| *lacks).map(|(_, what, todo)| [what, todo].map(str::to_owned)).collect()
}

pub(super) fn doctor(arguments: &DoctorArguments, progress: &Progress) -> Result<(), CliError> {
    if arguments.clock {
        return clock(&arguments.of_clock, progress);
    }
    let device = &arguments.of_clock.common.device;
    // A backend that does not exist is an error here too, not an empty list.
    let choice = AdapterChoice::from_environment(device.adapter.as_deref(), device.limits)?;
    let adapters = tracebench_api::list_adapters();
    let opened = Gpu::open(&choice);
    let missing = missing(&adapters, &opened);
    let gpu = opened.as_ref().ok();
    // Without what a probe would have to find out.
    let machine = Machine { adapter: gpu.map(|gpu| gpu.listing.clone()), ..machine::this_machine(None) };
    let own = gpu.map(|gpu| (&gpu.listing.name, &gpu.listing.backend));
    let chosen = adapters.iter().position(|of| own == Some((&of.name, &of.backend)));
    if arguments.json {
        let missing: Vec<_> = missing.iter().map(|[what, todo]| json!({ "what": what, "do": todo })).collect();
        return print_json(&json!({
            "machine": machine, "commit": machine::COMMIT, "adapters": adapters, "chosen": chosen, "missing": missing,
        }));
    }
    let memory = machine.memory_bytes.map_or_else(String::new, |bytes| format!(", {} MiB of memory", mib(bytes)));
    let mut text = format!("{}, {} threads{memory}, {}\n", machine.cpu, machine.threads, machine.os);
    for (number, adapter) in adapters.iter().enumerate() {
        let AdapterInfo { name, kind, backend, driver, driver_version, .. } = adapter;
        text += &format!("{number}: {name} ({kind}, {backend}, driver {driver} {driver_version})\n");
    }
    if let (Some(number), Some(adapter)) = (chosen, &machine.adapter) {
        text += &format!(
            "chosen: {number}; buffers of {} MiB, bindings of {} MiB, {} storage buffers a stage, textures of {} texels along an edge\n",
            mib(adapter.max_buffer_bytes),
            mib(adapter.max_storage_binding_bytes),
            adapter.max_storage_buffers_per_stage,
            adapter.max_texture_edge,
        );
    }
    text.extend(missing.iter().map(|[what, todo]| format!("missing: {what}\n  to do: {todo}\n")));
    print(&text)
}

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
    common: CommonArguments,
}

fn slowdown(text: &str) -> Result<u32, String> {
    let found = text.parse().ok().filter(|percent: &u32| (5..=50).contains(percent) && percent.is_multiple_of(5));
    found.ok_or_else(|| "a multiple of 5 from 5 to 50".to_owned())
}

fn clock(arguments: &ClockArguments, progress: &Progress) -> Result<(), CliError> {
    let (list, refused) = (arguments.tracer.as_deref(), "--tracer: clock measures one tracer against itself");
    let tracer = names::one_tracer(list.unwrap_or_default(), &arguments.common.settings, refused)?;
    let ray_sets = names::ray_sets(&arguments.rays)?;
    if ray_sets.len() != 1 {
        return refuse("--rays: clock traces one ray set");
    }
    let preset = RunPreset::named(&arguments.preset)
        .ok_or_else(|| CliError::Argument(format!("no preset '{}'", arguments.preset)))?;
    let preset = RunPreset { sampling: arguments.samples.map_or(SAMPLING, SampleSchedule::rounds), ..preset };
    let scenes = vec![names::scene(&arguments.scene)?];
    let selection = Selection { scenes, tracers: vec![tracer], ray_sets, ..Selection::default() };
    let plan = arguments.common.plan_of(selection, preset)?;
    let device = open_device(&arguments.common.device, &plan.tracers)?;
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
