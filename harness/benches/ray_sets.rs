//! Ray sets x tracers on `room`.
//!
//! First the harness measures all contenders interleaved, judges them and writes run.json, tables and charts below
//! target/. Then criterion samples the same work through the harness's clock. `TRACEBENCH_PRESET` chooses the run preset.

mod common;

use tracebench_api::{EndPoint, Preset};
use tracebench_harness::plan::{Plan, RunPreset, SceneSource, TracerRequest, ViewRequest};
use tracebench_harness::rays::{RAY_SETS, default_parameters};
use tracebench_harness::registry::TRACERS;

fn main() -> Result<(), common::Failure> {
    common::run("ray_sets", |preset| Ok(vec![plan(preset)?]))
}

fn plan(preset: RunPreset) -> Result<Plan, common::Failure> {
    Ok(Plan {
        scenes: vec![SceneSource::Catalogue("room".to_owned())],
        tracers: TRACERS.iter().map(|each| TracerRequest::of(each, Preset::Published)).collect(),
        ray_sets: RAY_SETS.to_vec(),
        ray_parameters: default_parameters(),
        preset,
        view: ViewRequest::Default,
        time_s: 0.0,
        seed: 1,
        end: EndPoint::Hit,
        table: None,
    })
}
