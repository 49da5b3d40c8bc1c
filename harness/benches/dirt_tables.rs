//! A part of DIRT's Tables 1 to 3 and Figures 8 to 11 in one scene.
//!
//! For each the harness measures its rows interleaved, judges them and writes run.json, the table and its verdicts below target/;
//! then criterion samples the same work through the harness's clock. Resolutions are half the run preset's, triangles an
//! eighth, samples three. Left out are the other scenes, specular, glossy and primary rays, bvh-gpu, resolutions of a figure but
//! one, and of Table 3 and Figure 10 most tile sizes and B: `tracebench table NAME` has them. `TRACEBENCH_PRESET` chooses the run
//! preset.

mod common;
#[path = "common/papers.rs"]
mod papers;

use tracebench_harness::papers::{Experiment, Step};
use tracebench_harness::plan::TracerRequest;

fn main() -> Result<(), common::Failure> {
    papers::run(&papers::Part { paper: "dirt", rays: &["visibility", "diffuse"], step, row })
}

fn step(step: &Step) -> bool {
    step.resolution == 1.0
}

fn row(experiment: &Experiment, request: &TracerRequest) -> bool {
    if request.name() != "dirt" {
        return request.name() != "bvh-gpu";
    }
    let value = |name: &str| request.parameters.value(name).map(ToString::to_string).unwrap_or_default();
    let buckets = value("buckets");
    let edge = ["1", "4"].contains(&&*value("tile_size"));
    match experiment.name {
        "dirt-table3" => edge && buckets == "4",
        "dirt-figure10" => edge && ["8", "24"].contains(&&*buckets),
        _ => true,
    }
}
