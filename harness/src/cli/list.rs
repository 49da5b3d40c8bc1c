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

/// As JSON, and in words.
type Listed = (fn() -> Vec<Value>, fn() -> String);

pub(super) fn list(arguments: &ListArguments) -> Result<(), CliError> {
    let (items, text): Listed = match arguments.what {
        Kind::Tracers => (tracers, || TRACERS.iter().map(|each| tracer_text(&each.describe())).collect()),
        Kind::Scenes => (scenes, scenes_text),
        Kind::Rays => (rays, rays_text),
        Kind::Cases => (cases, || CASES.iter().map(case_text).collect()),
        Kind::Tables => (tables, || Table::all().map(table_text).collect()),
    };
    if arguments.json { print_json(&Value::Array(items())) } else { print(&text()) }
}

fn tracers() -> Vec<Value> {
    let item = |registration: &crate::registry::Registration| {
        let mut item = serde_json::to_value(registration.describe()).unwrap_or_default();
        item["presets"] = json!(Preset::ALL.map(Preset::name));
        item
    };
    TRACERS.iter().map(item).collect()
}

fn tracer_text(description: &TracerDescription) -> String {
    let parameter = |parameter: &ParameterDescription| {
        let (value, range) = value_and_range(parameter);
        let ParameterDescription { name, improved, effect, .. } = parameter;
        format!("  {}.{name} = {value} ({range}; improved {improved}): {effect}\n", description.name)
    };
    let head = format!("{:<12} {}\n{:12} {}\n", description.name, description.summary, "", description.citation);
    head + &description.parameters.iter().map(parameter).collect::<String>()
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

/// Names of a scene's cameras. They do not depend on its scale, so the smallest serves.
fn camera_names(scene: &str) -> Vec<String> {
    let made = tracebench_scenes::procedural(scene, tracebench_scenes::SCALE_MIN);
    made.map(|scene| scene.cameras.into_iter().map(|camera| camera.name).collect()).unwrap_or_default()
}

fn scenes() -> Vec<Value> {
    let item = |entry: &CatalogueEntry| {
        json!({
            "name": entry.name,
            "description": entry.description,
            "triangles_at_scale_1": entry.triangles_at_scale_1,
            "closed": entry.closed,
            "watertight": entry.watertight,
            "animation_s": entry.animation_s,
            "viewpoints": camera_names(entry.name),
        })
    };
    tracebench_scenes::catalogue().iter().map(item).collect()
}

fn scenes_text() -> String {
    let entry = |entry: &CatalogueEntry| {
        let CatalogueEntry { name, description, triangles_at_scale_1, .. } = entry;
        let viewpoints = camera_names(name).join(", ");
        let moves = entry.animation_s.map_or_else(String::new, |seconds| format!(", moves for {seconds} s"));
        let head = format!("{name:<10} {description} ({triangles_at_scale_1} triangles{moves})\n");
        format!("{head}{:10} viewpoints: {viewpoints}\n", "")
    };
    let entries: String = tracebench_scenes::catalogue().iter().map(entry).collect();
    entries + "Any .gltf or .glb file is a scene too, by its path.\n"
}

/// The parameters of a ray set, `order` first, which every set has.
fn parameters_of(set: &RaySet) -> Vec<ParameterDescription> {
    let mut known = ray_parameters();
    known.retain(|each| each.name == "order" || set.parameters.contains(&each.name));
    known
}

fn rays_text() -> String {
    let sets = RAY_SETS.iter().chain([&HOSTILE]).map(|set| {
        let query = if set.query == Query::Any { " (any hit)" } else { "" };
        format!("{:<12} {}{query}\n", set.name, set.summary)
    });
    let parameters = ray_parameters();
    let parameters = parameters.iter().map(|parameter| {
        let (value, range) = value_and_range(parameter);
        format!("  rays.{} = {value} ({range}): {}\n", parameter.name, parameter.effect)
    });
    sets.chain(parameters).collect()
}

fn rays() -> Vec<Value> {
    let item = |set: &RaySet| {
        let parameter = |each: &ParameterDescription| {
            let ParameterDescription { name, unit, domain, published, effect, .. } = each;
            json!({ "name": name, "unit": unit, "domain": domain, "default": published, "effect": effect })
        };
        let parameters: Vec<Value> = parameters_of(set).iter().map(parameter).collect();
        json!({ "name": set.name, "query": set.query, "summary": set.summary, "parameters": parameters })
    };
    RAY_SETS.iter().chain([&HOSTILE]).map(item).collect()
}

fn cases() -> Vec<Value> {
    let item = |case: &Case| {
        let turned = &case.difficulty_parameter;
        let turned = json!({ "name": turned.name, "unit": turned.unit, "values": turned.values });
        json!({ "name": case.name, "summary": case.summary, "difficulty_parameter": turned })
    };
    CASES.iter().map(item).collect()
}

fn case_text(case: &Case) -> String {
    let Case { name, summary, difficulty_parameter, .. } = case;
    let values = difficulty_parameter.values.iter().join(", ");
    let label = crate::cases::label(difficulty_parameter.name, difficulty_parameter.unit);
    format!("{name:<20} {summary}\n{:20} {label}: {values}\n", "")
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

fn tables() -> Vec<Value> {
    let item = |table: Table| {
        let rays: Vec<&str> = table.rays().split(',').filter(|name| !name.is_empty()).collect();
        let mut item = json!({
            "name": table.name(), "summary": table.summary(), "rays": rays, "tracers": rows(table),
        });
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
        item
    };
    Table::all().map(item).collect()
}

fn table_text(table: Table) -> String {
    let (name, rays) = (table.name(), if table.rays().is_empty() { "none" } else { table.rays() });
    let rows = match rows(table) {
        rows if rows.is_empty() => String::new(),
        rows => format!("{:14} rows: {}; rays: {rays}\n", "", rows.join(", ")),
    };
    format!("{name:<14} {}\n{rows}", table.summary())
}
