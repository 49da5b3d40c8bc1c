//! `list`.

use clap::{Args, ValueEnum};
use itertools::Itertools as _;
use serde_json::{Value, json};
use tracebench_api::{Domain, ParameterDescription, Preset, Query, TracerDescription};
use tracebench_scenes::CatalogueEntry;

use super::CliError;
use super::output::{print, print_json};
use crate::cases::{CASES, Case};
use crate::plan::TracerRequest;
use crate::rays::{HOSTILE, RAY_SETS, RaySet, ray_parameters};
use crate::registry::TRACERS;
use crate::tables::{Table, exact};

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
    Cases,
    Tables,
}

/// What is listed: each as JSON and in words, and what words end with.
type Listed = (Vec<(Value, String)>, String);

pub(super) fn list(arguments: &ListArguments) -> Result<(), CliError> {
    let (items, end): Listed = match arguments.what {
        Kind::Tracers => (TRACERS.iter().map(|each| tracer(&each.describe())).collect(), String::new()),
        Kind::Scenes => scenes(),
        Kind::Rays => rays(),
        Kind::Cases => (CASES.iter().map(case).collect(), String::new()),
        Kind::Tables => (Table::all().map(table).collect(), String::new()),
    };
    let (values, texts): (Vec<Value>, String) = items.into_iter().unzip();
    if arguments.json { print_json(&Value::Array(values)) } else { print(&(texts + &end)) }
}

fn tracer(description: &TracerDescription) -> (Value, String) {
    let mut item = serde_json::to_value(description).unwrap_or_default();
    item["presets"] = json!(Preset::ALL.map(Preset::name));
    let parameter = |parameter: &ParameterDescription| {
        let (value, range) = value_and_range(parameter);
        let ParameterDescription { name, improved, effect, .. } = parameter;
        format!("  {}.{name} = {value} ({range}; improved {improved}): {effect}\n", description.name)
    };
    let head = format!("{:<12} {}\n{:12} {}\n", description.name, description.summary, "", description.citation);
    (item, head + &description.parameters.iter().map(parameter).collect::<String>())
}

/// A parameter's published value with its unit, and what it may be.
fn value_and_range(parameter: &ParameterDescription) -> (String, String) {
    let range = match parameter.domain {
        Domain::Integer { least, greatest } => format!("{least} to {greatest}"),
        Domain::Real { least, greatest } => format!("{least} to {greatest}"),
        Domain::Choice(names) => names.join(", "),
    };
    let unit = if parameter.unit.is_empty() { String::new() } else { format!(" {}", parameter.unit) };
    (format!("{}{unit}", parameter.published), range)
}

fn scenes() -> Listed {
    let item = |entry: &CatalogueEntry| {
        let CatalogueEntry { name, description, triangles_at_scale_1, closed, watertight, animation_s, .. } = entry;
        // Cameras do not depend on a scene's scale, so the smallest serves.
        let made = tracebench_scenes::procedural(name, tracebench_scenes::SCALE_MIN);
        let cameras = made.map(|scene| scene.cameras).unwrap_or_default();
        let viewpoints: Vec<String> = cameras.into_iter().map(|camera| camera.name).collect();
        let moves = animation_s.map_or_else(String::new, |seconds| format!(", moves for {seconds} s"));
        let head = format!("{name:<10} {description} ({triangles_at_scale_1} triangles{moves})\n");
        let text = format!("{head}{:10} viewpoints: {}\n", "", viewpoints.join(", "));
        let value = json!({
            "name": name, "description": description, "triangles_at_scale_1": triangles_at_scale_1, "closed": closed,
            "watertight": watertight, "animation_s": animation_s, "viewpoints": viewpoints,
        });
        (value, text)
    };
    let end = "Any .gltf or .glb file is a scene too, by its path.\n";
    (tracebench_scenes::catalogue().iter().map(item).collect(), end.to_owned())
}

fn rays() -> Listed {
    let known = ray_parameters();
    let item = |set: &RaySet| {
        let RaySet { name, query, summary, .. } = set;
        let parameter = |each: &ParameterDescription| {
            let ParameterDescription { name, unit, domain, published, effect, .. } = each;
            json!({ "name": name, "unit": unit, "domain": domain, "default": published, "effect": effect })
        };
        // `order` first, which every set has.
        let own = known.iter().filter(|each| each.name == "order" || set.parameters.contains(&each.name));
        let parameters: Vec<Value> = own.map(parameter).collect();
        let any = if *query == Query::Any { " (any hit)" } else { "" };
        let value = json!({ "name": name, "query": query, "summary": summary, "parameters": parameters });
        (value, format!("{name:<12} {summary}{any}\n"))
    };
    let parameter = |parameter: &ParameterDescription| {
        let (value, range) = value_and_range(parameter);
        format!("  rays.{} = {value} ({range}): {}\n", parameter.name, parameter.effect)
    };
    (RAY_SETS.iter().chain([&HOSTILE]).map(item).collect(), known.iter().map(parameter).collect())
}

fn case(case: &Case) -> (Value, String) {
    let Case { name, summary, difficulty_parameter: turned, .. } = case;
    let label = crate::cases::label(&turned.name, &turned.unit);
    let text = format!("{name:<20} {summary}\n{:20} {label}: {}\n", "", turned.values.iter().join(", "));
    (json!({ "name": name, "summary": summary, "difficulty_parameter": turned }), text)
}

/// Labels of a table's rows, as `--tracer` takes them; each once, however many steps have it.
fn rows(table: Table) -> Vec<String> {
    let requests = match table {
        Table::Settings(peers) => peers.configs(),
        Table::Paper(_, experiment) => experiment.requests().concat(),
        Table::Claims(_) => Vec::new(),
        Table::Exact => return vec![exact::tracer()],
    };
    requests.iter().map(TracerRequest::argument).unique().collect()
}

fn table(table: Table) -> (Value, String) {
    let (name, summary, rows) = (table.name(), table.summary(), rows(table));
    let rays: Vec<&str> = table.rays().split(',').filter(|name| !name.is_empty()).collect();
    let mut item = json!({ "name": name, "summary": summary, "rays": rays, "tracers": rows });
    match table {
        Table::Settings(peers) if peers.reference().is_empty() => {}
        Table::Settings(peers) => item["reference"] = json!(peers.reference()),
        Table::Exact => {}
        Table::Claims(paper) => item["paper"] = json!(paper.name),
        Table::Paper(paper, experiment) => {
            item["paper"] = json!(paper.name);
            item["scenes"] = experiment.scenes.iter().map(|each| json!(each.scene)).collect();
            item["resolutions"] = experiment.steps.iter().map(|step| json!(step.resolution)).collect();
        }
    }
    let rays = if table.rays().is_empty() { "none" } else { table.rays() };
    let told = match rows.is_empty() {
        true => String::new(),
        false => format!("{:14} rows: {}; rays: {rays}\n", "", rows.join(", ")),
    };
    (item, format!("{name:<14} {summary}\n{told}"))
}
