//! `adapters` and `list`.

use clap::{Args, ValueEnum};
use serde_json::{Value, json};
use tracebench_api::{Domain, Preset};

use super::CliError;
use crate::progress::Progress;
use crate::rays::RAY_SETS;
use crate::registry::TRACERS;

#[derive(Args)]
pub(super) struct AdapterArguments {
    /// As a JSON array of objects.
    #[arg(long)]
    json: bool,
}

#[derive(Args)]
pub(super) struct ListArguments {
    /// What to list.
    #[arg(value_enum)]
    what: Kind,
    /// As a JSON array of objects, each with a name.
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, ValueEnum)]
enum Kind {
    Tracers,
    Scenes,
    Rays,
}

fn print_json(value: &Value) {
    println!("{value:#}");
}

pub(super) fn adapters(arguments: &AdapterArguments, progress: &Progress) -> Result<(), CliError> {
    let adapters = tracebench_api::list_adapters();
    if arguments.json {
        let value = serde_json::to_value(&adapters).map_err(|error| CliError::Other(error.to_string()))?;
        print_json(&value);
        return Ok(());
    }
    if adapters.is_empty() {
        progress.say("no graphics adapter was found; setup.sh installs a software one on Debian and Ubuntu");
    }
    for (number, adapter) in adapters.iter().enumerate() {
        println!(
            "{number}: {} ({}, {}, driver {} {})",
            adapter.name, adapter.kind, adapter.backend, adapter.driver, adapter.driver_version
        );
    }
    Ok(())
}

pub(super) fn list(arguments: &ListArguments) -> Result<(), CliError> {
    let items = match arguments.what {
        Kind::Tracers => tracers(),
        Kind::Scenes => scenes(),
        Kind::Rays => rays(),
    };
    if arguments.json {
        print_json(&Value::Array(items));
        return Ok(());
    }
    match arguments.what {
        Kind::Tracers => print_tracers(),
        Kind::Scenes => print_scenes(),
        Kind::Rays => {
            for set in RAY_SETS {
                println!("{:<10} {}", set.name, set.summary);
            }
        }
    }
    Ok(())
}

fn tracers() -> Vec<Value> {
    let item = |registration: &crate::registry::Registration| {
        let mut item = serde_json::to_value((registration.describe)()).unwrap_or_default();
        item["presets"] = json!(Preset::ALL.map(Preset::name));
        item
    };
    TRACERS.iter().map(item).collect()
}

fn print_tracers() {
    for registration in TRACERS {
        let description = (registration.describe)();
        println!("{:<12} {}\n{:12} {}", description.name, description.summary, "", description.citation);
        for parameter in &description.parameters {
            let range = match parameter.domain {
                Domain::Integer { least, greatest } => format!("{least} to {greatest}"),
                Domain::Real { least, greatest } => format!("{least} to {greatest}"),
                Domain::Choice(names) => names.join(", "),
            };
            let unit = if parameter.unit.is_empty() { String::new() } else { format!(" {}", parameter.unit) };
            println!(
                "  {}.{} = {}{unit} ({range}; improved {}): {}",
                description.name, parameter.name, parameter.published, parameter.improved, parameter.effect
            );
        }
    }
}

/// Names of a scene's cameras. They do not depend on its scale, so the smallest serves.
fn camera_names(scene: &str) -> Vec<String> {
    let made = tracebench_scenes::procedural(scene, tracebench_scenes::SCALE_MIN);
    made.map(|scene| scene.cameras.into_iter().map(|camera| camera.name).collect()).unwrap_or_default()
}

fn scenes() -> Vec<Value> {
    let item = |entry: &tracebench_scenes::CatalogueEntry| {
        json!({
            "name": entry.name,
            "description": entry.description,
            "triangles_at_scale_1": entry.triangles_at_scale_1,
            "closed": entry.closed,
            "viewpoints": camera_names(entry.name),
        })
    };
    tracebench_scenes::catalogue().iter().map(item).collect()
}

fn print_scenes() {
    for entry in tracebench_scenes::catalogue() {
        println!("{:<10} {} ({} triangles)", entry.name, entry.description, entry.triangles_at_scale_1);
        println!("{:10} viewpoints: {}", "", camera_names(entry.name).join(", "));
    }
    println!("Any .gltf or .glb file is a scene too, by its path.");
}

fn rays() -> Vec<Value> {
    RAY_SETS.iter().map(|set| json!({ "name": set.name, "query": set.query, "summary": set.summary })).collect()
}
