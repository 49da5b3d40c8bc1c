//! Widmer, Pająk, Schulz, Pulli, Kautz, Goesele, Luebke: *An Adaptive Acceleration Structure for Screen-space Ray Tracing*, HPG 2015.
//!
//! Papers that set themselves beside it take its rows from here.

mod charts;
mod experiments;
mod quantities;
mod sections;
#[cfg(test)]
mod tests;

use super::experiment::Values;
use super::{Experiment, ExperimentRow, Paper, Part, Resolutions, SceneRows, Step};
use crate::plan::TracerRequest;
use crate::results::Row;

/// The paper.
pub(super) const PAPER: Paper = Paper {
    name: "wkp15",
    experiments: experiments::EXPERIMENTS,
    part: Part { rays: &["primary", "stereo", "temporal", "lens", "glossy", "light-field"], step, row: in_part },
    at_paper: Some(Resolutions { image: [1600, 900], face: 1024 }),
    published: include_str!("published.json"),
    claims_table: "wkp15-claims",
    claims: include_str!("claims.json"),
    quantities: quantities::QUANTITIES,
    counts: &[
        ("nodes", "nodes of all levels"),
        ("plane_leaves", "leaves that are planes"),
        ("boxes", "boxes above them"),
        ("flagged_leaves", "leaves near a discontinuity"),
        ("covered_pixels", "covered pixels"),
        ("covered_pixels_layer_2", "of layer 2"),
        ("median_gamma_dist_in_pixels", "gamma_dist (pixel heights, median)"),
    ],
    // It tells bytes of a node alone.
    of_a_trace: &[],
    by_formula: |_| None,
};

/// Its tracer.
pub(super) const QUADTREE: &str = "quadtree";
/// Its peer that marches from pixel to pixel.
pub(super) const DDA: &str = "screen-dda";
/// Its peer over a pyramid of depth bounds.
const FIELD: &str = "height-field";
/// Its peer that draws the depths once more.
const MESH: &str = "mesh-warp";

/// What its tracer calls the samples beside a ray.
const SAMPLES_A_RAY: &str = "secondary_samples";

/// Its tracer with every combination of values.
pub(super) const fn quadtree(values: Values) -> ExperimentRow {
    ExperimentRow { tracer: QUADTREE, values }
}

/// The marching peer with every combination of values.
const fn dda(values: Values) -> ExperimentRow {
    ExperimentRow { tracer: DDA, values }
}

/// Its tracer's row with these values, and else those of its first row.
pub(super) fn row<'a>(scene: &SceneRows<'a>, values: &[(&str, &str)]) -> Option<&'a Row> {
    scene.like_first(QUADTREE, values)
}

/// A row of one layer and one of two, with these values.
fn one_and_two<'a>(scene: &SceneRows<'a>, tracer: &str, values: &[(&str, &str)]) -> Option<[&'a Row; 2]> {
    let [one, two] = ["1", "2"].map(|layers| scene.like_first(tracer, &[&[("layers", layers)], values].concat()));
    Some([one?, two?])
}

/// Of steps that are about a scale, a resolution or rays the bench takes the first.
fn step(step: &Step) -> bool {
    (step.resolution, step.scale) == (1.0, 1.0) && step.rays.iter().all(|said| experiments::FIRST.contains(said))
}

/// The bench leaves out more layers than two, most thresholds, and what the text states but for its first rows.
fn in_part(experiment: &Experiment, request: &TracerRequest) -> bool {
    let value = |name: &str| request.parameters.value(name).map(ToString::to_string).unwrap_or_default();
    let set = |name: &str| request.changed.iter().any(|changed| changed == name);
    match experiment.name {
        "wkp15-figure14" | "wkp15-figure15" => ["0", "3", "25"].contains(&&*value("gamma_norm")),
        "wkp15-text" => set("layers") && ["1", "2"].contains(&&*value("layers")),
        _ => true,
    }
}
