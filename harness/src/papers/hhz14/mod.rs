//! Hu, Huang, Zhang, Yuan, Li: *Ray tracing via GPU rasterization*, The Visual Computer 30 (2014).

#[cfg(test)]
mod tests;

use std::sync::LazyLock;

use super::{Paper, embedded};

/// The paper.
pub(super) static PAPER: Paper = Paper {
    name: "hhz14",
    experiments: LazyLock::new(|| embedded(include_str!("experiments.json"))),
    few_rays: &["specular", "refraction", "visibility", "ao", "diffuse", "pixel-random"],
    pages: LazyLock::new(|| embedded(include_str!("pages.json"))),
    at_paper: None,
    published: include_str!("published.json"),
    claims_table: "hhz14-claims",
    claims: include_str!("claims.json"),
    told: LazyLock::new(|| embedded(include_str!("quantities.json"))),
    figures: &[],
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
