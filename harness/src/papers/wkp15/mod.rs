//! Widmer, Pająk, Schulz, Pulli, Kautz, Goesele, Luebke: *An Adaptive Acceleration Structure for Screen-space Ray Tracing*, HPG 2015.

#[cfg(test)]
mod tests;

use std::sync::LazyLock;

use super::{Paper, Resolutions, embedded};

/// The paper.
pub(super) static PAPER: Paper = Paper {
    name: "wkp15",
    experiments: LazyLock::new(|| embedded(include_str!("experiments.json"))),
    few_rays: &["primary", "stereo", "temporal", "lens", "glossy", "light-field"],
    pages: LazyLock::new(|| embedded(include_str!("pages.json"))),
    at_paper: Some(Resolutions { image: [1600, 900], face: 1024 }),
    published: include_str!("published.json"),
    claims_table: "wkp15-claims",
    claims: include_str!("claims.json"),
    told: LazyLock::new(|| embedded(include_str!("quantities.json"))),
    figures: &[],
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
