//! DIRT's Tables 1 and 2 and a part of its Figure 10 in one scene.
//!
//! For each the harness measures all rows interleaved, judges them and writes run.json, the table and its verdicts below target/;
//! then criterion samples the same work through the harness's clock. Rays start from half as many pixels along an edge as the
//! run preset has. Every scene, row and figure, at the preset's resolution: `tracebench table NAME`. `TRACEBENCH_PRESET` chooses
//! the run preset.

mod common;

use tracebench_harness::papers;
use tracebench_harness::plan::{Plan, RunPreset, SceneSource, TracerRequest, ViewRequest};
use tracebench_harness::rays::{RAY_SETS, default_parameters, ray_parameters};

/// The scene.
const SCENE: &str = "room";
/// Of the figure's values of B those that are left out here.
const LEFT_OUT: [i64; 3] = [16, 32, 40];

fn main() -> Result<(), common::Failure> {
    common::run("dirt_table1", |preset| plan("dirt-table1", preset))?;
    common::run("dirt_table2", |preset| plan("dirt-table2", preset))?;
    common::run("dirt_figure10", |preset| plan("dirt-figure10", preset))
}

fn plan(name: &str, preset: RunPreset) -> Result<Plan, common::Failure> {
    let experiment = papers::find(name).ok_or_else(|| format!("there is no table '{name}'"))?;
    let known = ray_parameters();
    let mut parameters = default_parameters();
    for setting in experiment.settings {
        let setting = setting.strip_prefix("rays.").and_then(|setting| setting.split_once('='));
        let (parameter, value) = setting.ok_or_else(|| format!("{name} has a setting that is none"))?;
        parameters.set(&known, parameter, value)?;
    }
    let is_there = |request: &TracerRequest| !LEFT_OUT.contains(&request.parameters.integer("buckets"));
    let wanted = |name: &str| experiment.rays.split(',').any(|rays| rays == name);
    Ok(Plan {
        scenes: vec![SceneSource::Catalogue(SCENE.to_owned())],
        tracers: experiment.requests().concat().into_iter().filter(is_there).collect(),
        ray_sets: RAY_SETS.iter().filter(|set| wanted(set.name)).copied().collect(),
        ray_parameters: parameters,
        preset: RunPreset { ray_image: preset.ray_image.map(|edge| edge.div_ceil(2)), ..preset },
        view: ViewRequest::Default,
        time_s: 0.0,
        seed: 1,
        end: tracebench_api::EndPoint::Hit,
        table: Some(experiment.name),
    })
}
