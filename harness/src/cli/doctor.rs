//! `doctor`.

use clap::{Arg, Args};
use serde_json::json;
use tracebench_api::{AdapterChoice, AdapterListing, Gpu, TracerError};

use super::CliError;
use super::clock::{self, ClockArguments};
use super::output::{print, print_json};
use crate::machine;
use crate::progress::Progress;
use crate::report::format::mib;

#[derive(Args)]
pub(super) struct DoctorArguments {
    /// As one JSON object.
    #[arg(long, conflicts_with = "clock")]
    json: bool,
    /// Try the clock: race a tracer against itself, and against itself with more to do, and count what is said.
    #[arg(long, requires = "tracer")]
    clock: bool,
    #[command(flatten)]
    of_clock: ClockArguments,
}

/// What `doctor` takes without `--clock`.
const WITHOUT_CLOCK: [&str; 6] = ["json", "clock", "adapter", "limits", "quiet", "until_stdin_ends"];

/// Ties every option that is about the clock to `--clock`.
pub(super) fn options(option: Arg) -> Arg {
    let is_free = WITHOUT_CLOCK.iter().any(|name| option.get_id() == name);
    if is_free { option } else { option.requires("clock") }
}

/// Something that this machine lacks.
struct Lack {
    what: &'static str,
    todo: String,
}

/// What the adapter that a run would take lacks, if there is one.
fn lacks(adapters: &[AdapterListing], opened: &Result<Gpu, TracerError>) -> Vec<Lack> {
    let gpu = match opened {
        Ok(gpu) => gpu,
        Err(error) => return vec![Lack { what: "a device; tracers of the host run without", todo: error.to_string() }],
    };
    let hardware = adapters.iter().position(|adapter| adapter.kind != "software");
    let named = |number: usize| format!("name one that is none: --adapter {number}");
    let install = || "install the Vulkan driver of this machine's GPU, if it has one".to_owned();
    let lacks = [
        (
            gpu.is_software(),
            "hardware: times by a software adapter say little of it",
            hardware.map_or_else(install, named),
        ),
        (
            !gpu.listing.timestamps,
            "timestamps: device work is timed by the host's clock",
            "nothing: accuracy is the same".to_owned(),
        ),
        (
            !gpu.has_ray_queries(),
            "ray queries: a tracer that needs them is skipped",
            "install a driver that has them (Mesa 25 on software), and leave --limits out".to_owned(),
        ),
    ];
    lacks.into_iter().filter(|(lacks, ..)| *lacks).map(|(_, what, todo)| Lack { what, todo }).collect()
}

pub(super) fn doctor(arguments: &DoctorArguments, progress: &Progress) -> Result<(), CliError> {
    let DoctorArguments { json, clock, of_clock } = arguments;
    if *clock {
        return clock::clock(of_clock, progress);
    }
    let device = &of_clock.common.device;
    // A backend that does not exist is an error here too, not an empty list.
    let choice = AdapterChoice::from_environment(device.adapter.as_deref(), device.limits)?;
    let adapters = tracebench_api::list_adapters();
    let opened = Gpu::open(&choice);
    let same = |adapter: &AdapterListing, of: &AdapterListing| {
        (&adapter.name, &adapter.backend, &adapter.driver) == (&of.name, &of.backend, &of.driver)
    };
    let gpu = opened.as_ref().ok();
    let taken = gpu.and_then(|gpu| adapters.iter().position(|adapter| same(adapter, &gpu.listing)));
    let lacks = lacks(&adapters, &opened);
    let machine = machine::this_machine(None);
    if *json {
        let numbered = |(number, adapter): (usize, &AdapterListing)| {
            let mut adapter = json!(adapter);
            adapter["number"] = json!(number);
            adapter
        };
        let machine::Machine { cpu, threads, memory_bytes, os, rustc, .. } = machine;
        let lack = |lack: &Lack| json!({ "what": lack.what, "do": lack.todo });
        return print_json(&json!({
            "cpu": cpu, "threads": threads, "memory_bytes": memory_bytes, "os": os, "rustc": rustc, "commit": machine::COMMIT,
            "adapters": adapters.iter().enumerate().map(numbered).collect::<Vec<_>>(), "taken": taken,
            "opened": gpu.map(|gpu| &gpu.listing), "missing": lacks.iter().map(lack).collect::<Vec<_>>(),
        }));
    }
    let memory = machine.memory_bytes.map_or_else(String::new, |bytes| format!(", {} MiB of memory", mib(bytes)));
    let mut text = format!("{}, {} threads{memory}, {}\n", machine.cpu, machine.threads, machine.os);
    for (number, adapter) in adapters.iter().enumerate() {
        let AdapterListing { name, kind, backend, driver, driver_version, .. } = adapter;
        text += &format!("{number}: {name} ({kind}, {backend}, driver {driver} {driver_version})\n");
    }
    if let Some(gpu) = gpu {
        let listing = &gpu.listing;
        let number = taken.map_or_else(|| listing.name.clone(), |number| number.to_string());
        text += &format!(
            "taken: {number}; buffers of {} MiB, bindings of {} MiB, {} storage buffers a stage, textures of {} texels along an edge\n",
            mib(listing.max_buffer_bytes),
            mib(listing.max_storage_binding_bytes),
            listing.max_storage_buffers_per_stage,
            listing.max_texture_edge,
        );
    }
    for Lack { what, todo } in &lacks {
        text += &format!("missing: {what}\n  to do: {todo}\n");
    }
    print(&text)
}
