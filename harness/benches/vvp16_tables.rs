//! A part of VVP16's Tables 1 and 2 and Figures 7 to 9, 11 and 12 in one scene.
//!
//! For each the harness measures its rows interleaved, judges them and writes run.json, the table and its verdicts below target/;
//! then criterion samples the same work through the harness's clock. Resolutions are half the run preset's, triangles an eighth,
//! samples three, random rays two a pixel. Left out are the other scenes, second bounces, mirrored and refracted rays, more than four buckets, of the
//! storages in Figure 12 all but the plainest and the paper's own, a thickness, of views and layers all but one view and one layer,
//! and what the text states: `tracebench table NAME` has them. `TRACEBENCH_PRESET` chooses the run preset.

mod common;
#[path = "common/papers.rs"]
mod papers;

use tracebench_harness::papers::{Experiment, Step};
use tracebench_harness::plan::TracerRequest;

fn main() -> Result<(), common::Failure> {
    papers::run(&papers::Part { paper: "vvp16", rays: &["diffuse", "pixel-random"], step, row })
}

fn step(step: &Step) -> bool {
    (step.resolution, step.faces) == (1.0, 1.0)
}

fn row(experiment: &Experiment, request: &TracerRequest) -> bool {
    if request.name() != "fragment-abuffer" {
        return true;
    }
    let value = |name: &str| request.parameters.value(name).map(ToString::to_string).unwrap_or_default();
    match experiment.name {
        "vvp16-figure11" => value("thickness") == "0",
        "vvp16-figure12" => ["ll", "dllb"].contains(&&*value("storage")),
        "vvp16-views" => {
            let of_figures = request.changed.iter().any(|name| name == "layers");
            of_figures
                && [["seven", "all"], ["seven", "one"], ["frame", "all"]].contains(&[&value("views"), &value("layers")])
        }
        _ => value("buckets") == "4",
    }
}
