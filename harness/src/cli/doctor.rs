//! `doctor`.

use clap::{Arg, Args};
use serde_json::json;
use tracebench_api::{AdapterChoice, AdapterInfo, Gpu, TracerError};

use super::CliError;
use super::clock::{self, ClockArguments};
use super::output::{print, print_json};
use crate::machine::{self, Machine};
use crate::progress::Progress;
use crate::report::format::mib;

#[derive(Args)]
pub(super) struct DoctorArguments {
    /// As one JSON object.
    #[arg(long, conflicts_with = "clock")]
    json: bool,
    /// Try the clock: interleaved set a tracer against itself, and against itself with more to do, and count what is said.
    #[arg(long, requires = "tracer")]
    clock: bool,
    #[command(flatten)]
    of_clock: ClockArguments,
}

/// What `doctor` takes without `--clock`.
const WITHOUT_CLOCK: [&str; 6] = ["json", "clock", "adapter", "limits", "quiet", "until_stdin_ends"];

/// Ambiguous rays every option that is about the clock to `--clock`.
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
        return clock::clock(&arguments.of_clock, progress);
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
    let is_chosen = |of: &AdapterInfo| {
        let chosen = |gpu: &Gpu| (&gpu.listing.name, &gpu.listing.backend) == (&of.name, &of.backend);
        gpu.is_some_and(chosen)
    };
    let chosen = adapters.iter().position(is_chosen);
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
