//! Builds and diffuse traces of the BVH peers in a closed room and in the open.
//!
//! First the harness measures every kind of structure in the table `bvh`, interleaved, judges them and writes run.json and the
//! table below target/; how the reference's build presets compare is left to `tracebench table bvh`, which takes longer. Then criterion samples the same work through the harness's clock. `TRACEBENCH_PRESET` chooses the run preset.

mod common;

use tracebench_api::EndPoint;
use tracebench_harness::peers::{self, Table};
use tracebench_harness::plan::{Plan, RunPreset, SceneSource, TracerRequest, ViewRequest};
use tracebench_harness::rays::{RAY_SETS, default_parameters};

fn main() -> Result<(), common::Failure> {
    common::run("bvh_peers", |preset| Ok(vec![plan(preset)?]))
}

fn plan(preset: RunPreset) -> Result<Plan, common::Failure> {
    let table = peers::find("bvh").ok_or("there is no table 'bvh'")?;
    Ok(Plan {
        scenes: ["room", "candy"].map(|name| SceneSource::Catalogue(name.to_owned())).to_vec(),
        tracers: table.contenders().into_iter().filter(|each| !is_swept(table, each)).collect(),
        ray_sets: RAY_SETS.iter().filter(|set| set.name == "diffuse").copied().collect(),
        ray_parameters: default_parameters(),
        preset,
        view: ViewRequest::Default,
        time_s: 0.0,
        seed: 1,
        end: EndPoint::Hit,
        table: Some(table.name),
    })
}

/// Whether a row is there for a value of the parameter that the table sweeps.
fn is_swept(table: &Table, request: &TracerRequest) -> bool {
    request.changed.iter().any(|name| table.swept == Some(name))
}
