//! Hu, Huang, Zhang, Yuan, Li: *Ray tracing via GPU rasterization*, The Visual Computer 30 (2014).

mod experiments;
mod quantities;
mod sections;
#[cfg(test)]
mod tests;

use super::experiment::Values;
use super::{Experiment, ExperimentRow, Paper, Part, SceneRows};
use crate::plan::TracerRequest;
use crate::results::Row;

/// The paper.
pub(super) const PAPER: Paper = Paper {
    name: "hhz14",
    experiments: experiments::EXPERIMENTS,
    part: Part { rays: &["specular", "refraction", "visibility", "ao", "diffuse", SAMPLES], step: |_| true, row: part },
    at_paper: None,
    published: include_str!("published.json"),
    claims_table: "hhz14-claims",
    claims: include_str!("claims.json"),
    quantities: quantities::QUANTITIES,
    counts: &[
        ("fragments", "fragments"),
        ("average_layers", "layers of a covered pixel"),
        ("maximum_layers", "most layers"),
        ("covered_texels", "covered texels"),
        ("occupied_voxels", "occupied voxels"),
        ("cancelled_voxels", "voxels whose normals cancel"),
        ("nodes", "nodes"),
        ("leaves", "leaves"),
    ],
    // It tells no bytes.
    of_a_trace: &[],
    by_formula: |_| None,
};

/// Its tracer.
pub(super) const ABUFFER: &str = "voxel-abuffer";
/// The peer of its Table 1.
const OCTREE: &str = "voxel-octree";

/// Methods over the depth image of a view.
const DEPTH_IMAGES: [&str; 2] = ["screen-dda", "height-field"];
/// Rays of which a pixel has several.
const SAMPLES: &str = "pixel-random";

/// Its tracer with every combination of values.
const fn abuffer(values: Values) -> ExperimentRow {
    ExperimentRow { tracer: ABUFFER, values }
}

/// Its peer with every combination of values.
const fn octree(values: Values) -> ExperimentRow {
    ExperimentRow { tracer: OCTREE, values }
}

/// Its tracer's row with these values, and else those of its first row.
fn row<'a>(scene: &SceneRows<'a>, values: &[(&str, &str)]) -> Option<&'a Row> {
    scene.like_first(ABUFFER, values)
}

/// The bench takes Table 1 by buffers and a ray a lane, one walk of the octree, and one grid of voxels alone.
fn part(experiment: &Experiment, request: &TracerRequest) -> bool {
    let value = |name: &str| request.parameters.value(name).map(ToString::to_string).unwrap_or_default();
    match experiment.name {
        "hhz14-table1" => {
            [value("memory_access"), value("rays_per_lane")] == ["buffer", "1"]
                && (request.name() != OCTREE || value("traversal") == "stack")
        }
        "hhz14-figure9" => value("abuffer") == "0" && ["0", "128"].contains(&&*value("grid")),
        _ => true,
    }
}
