//! DIRT's Tables 1 to 3 and Figures 8 to 11 in one scene, of the figures a part.
//!
//! For each the harness measures all rows interleaved, judges them and writes run.json, the table and its verdicts below target/;
//! then criterion samples the same work through the harness's clock. Rays start from half as many pixels along an edge as the
//! run preset has. Every scene, row and figure, at the preset's resolution: `tracebench table NAME`. `TRACEBENCH_PRESET` chooses
//! the run preset.

mod common;

use tracebench_api::EndPoint;
use tracebench_harness::papers::{EXPERIMENTS, Experiment};
use tracebench_harness::plan::{Plan, RunPreset, SceneSource, TracerRequest, ViewRequest};
use tracebench_harness::rays::{RAY_SETS, default_parameters, ray_parameters};

/// The scene.
const SCENE: &str = "room";
/// Of the figure's values of B those that are left out here.
const LEFT_OUT: [i64; 3] = [16, 32, 40];
/// Steps above the run preset's own resolution are left out.
const MOST_RESOLUTION: f64 = 1.0;

fn main() -> Result<(), common::Failure> {
    for experiment in EXPERIMENTS.iter().filter(|experiment| !experiment.published.is_empty()) {
        common::run(&experiment.name.replace('-', "_"), |preset| plans(experiment, preset))?;
    }
    Ok(())
}

fn plans(experiment: &Experiment, preset: RunPreset) -> Result<Vec<Plan>, common::Failure> {
    let known = ray_parameters();
    let mut parameters = default_parameters();
    for setting in experiment.settings {
        let setting = setting.strip_prefix("rays.").and_then(|setting| setting.split_once('='));
        let (parameter, value) = setting.ok_or_else(|| format!("{} has a setting that is none", experiment.name))?;
        parameters.set(&known, parameter, value)?;
    }
    let wanted = |name: &str| experiment.rays.split(',').any(|rays| rays == name);
    let base = Plan {
        scenes: vec![SceneSource::Catalogue(SCENE.to_owned())],
        tracers: Vec::new(),
        ray_sets: RAY_SETS.iter().filter(|set| wanted(set.name)).copied().collect(),
        ray_parameters: parameters,
        preset: RunPreset { ray_image: preset.ray_image.map(|edge| edge.div_ceil(2)), ..preset },
        view: ViewRequest::Default,
        time_s: 0.0,
        seed: 1,
        end: EndPoint::Hit,
        table: Some(experiment.name),
    };
    let left_out =
        |request: &TracerRequest| request.name() == "dirt" && LEFT_OUT.contains(&request.parameters.integer("buckets"));
    let mut steps = experiment.requests();
    steps.iter_mut().for_each(|step| step.retain(|request| !left_out(request)));
    let plans = experiment.plans(&base, &steps)?;
    let resolutions = experiment.steps.iter().map(|step| step.resolution);
    Ok(plans.into_iter().zip(resolutions).filter(|(_, each)| *each <= MOST_RESOLUTION).map(|(plan, _)| plan).collect())
}
