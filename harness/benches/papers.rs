//! A part of every paper's tables and figures in one scene; `cargo bench --bench papers -- NAME` takes one paper.
//!
//! For each table and figure the harness measures its rows interleaved, judges them and writes run.json, the table and its verdicts
//! below target/; then criterion samples the same work through the harness's clock. Resolutions are half the run preset's, triangles
//! an eighth, samples three, random rays two a pixel. Which ray sets, steps and rows are taken stands with the paper; what is left
//! out `tracebench table NAME` has. `TRACEBENCH_PRESET` chooses the run preset.

mod common;

use common::Failure;
use tracebench_api::EndPoint;
use tracebench_harness::papers::{Experiment, PAPERS, Paper, paper};
use tracebench_harness::plan::{Plan, RunPreset, SceneSource, ViewRequest};
use tracebench_harness::rays::{RAY_SETS, default_parameters, ray_parameters};
use tracebench_harness::results::Sampling;

/// The scene.
const SCENE: &str = "room";
/// Part of the run preset's triangles that the scene has: on a software adapter a draw takes as long as its triangles do.
const SCALE: f64 = 0.125;
/// Samples of every time in the harness's own measurement, at most.
const MOST_SAMPLES: u32 = 3;
/// Rays of sets that start several from a pixel.
const RAYS_A_PIXEL: &str = "2";

/// Runs every experiment that stands beside published tables: of the paper that the first argument names, else of all.
fn main() -> Result<(), Failure> {
    // To criterion the name is a filter, which all that is named after the paper passes.
    let named = std::env::args().nth(1).and_then(|name| paper(&name));
    for paper in PAPERS.iter().filter(|paper| named.is_none_or(|named| named.name == paper.name)) {
        for experiment in paper.experiments.iter().filter(|experiment| !experiment.published.is_empty()) {
            common::run(&experiment.name.replace('-', "_"), |preset| plans(paper, experiment, preset))?;
        }
    }
    Ok(())
}

fn plans(paper: &Paper, experiment: &Experiment, preset: RunPreset) -> Result<Vec<Plan>, Failure> {
    let part = &paper.part;
    let known = ray_parameters();
    let mut parameters = default_parameters();
    parameters.set(&known, "pixel_random_count", RAYS_A_PIXEL)?;
    for setting in experiment.settings {
        let setting = setting.strip_prefix("rays.").and_then(|setting| setting.split_once('='));
        let (parameter, value) = setting.ok_or_else(|| format!("{} has a setting that is none", experiment.name))?;
        parameters.set(&known, parameter, value)?;
    }
    let wanted = |name: &str| experiment.rays.split(',').any(|rays| rays == name) && part.rays.contains(&name);
    let half = |edge: u32| edge.div_ceil(2);
    let preset = paper.resolved(preset);
    let base = Plan {
        scenes: vec![SceneSource::Catalogue(SCENE.to_owned())],
        tracers: Vec::new(),
        ray_sets: RAY_SETS.iter().filter(|set| wanted(set.name)).copied().collect(),
        ray_parameters: parameters,
        preset: RunPreset {
            ray_image: preset.ray_image.map(half),
            frame: preset.frame.map(half),
            face: half(preset.face),
            sampling: Sampling::rounds(preset.sampling.least_rounds.min(MOST_SAMPLES)),
            scene_scale: preset.scene_scale * SCALE,
            ..preset
        },
        view: ViewRequest::Default,
        time_s: 0.0,
        seed: 1,
        end: EndPoint::Hit,
        table: Some(experiment.name),
    };
    let mut steps = experiment.requests();
    steps.iter_mut().for_each(|step| step.retain(|request| (part.row)(experiment, request)));
    let plans = experiment.plans(&base, &steps)?.into_iter().zip(experiment.steps);
    Ok(plans.filter(|(plan, step)| (part.step)(step) && !plan.tracers.is_empty()).map(|(plan, _)| plan).collect())
}
