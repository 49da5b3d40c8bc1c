//! What is expected of `bvh-cpu`: an analytic method in f32 that sees every triangle and no view.

use super::expectation::{Column, Expectation, Rule};

const EDGES: Expectation = Expectation::KnownFailure {
    rule: Rule::HitMiss,
    from: 8.0,
    below: 0.01,
    least_wrong: 0.03,
    reason: "the f32 triangle test is not watertight: of rays onto an edge that two triangles share some pass between \
             them",
    source: "Woop, Benthin and Wald 2013, on why edge tests must be watertight",
};

pub(super) const EXPECTATIONS: Column = &[
    ("edge-on", Expectation::Exact),
    ("wires", Expectation::Exact),
    ("leaves", Expectation::Exact),
    ("close-sheets", Expectation::Exact),
    ("voxel-stack", Expectation::Exact),
    ("open-mesh", Expectation::Exact),
    ("huge-triangle", Expectation::Exact),
    ("needles", EDGES),
    ("coplanar-copies", Expectation::Exact),
    ("eye-inside-object", Expectation::Exact),
    ("eye-on-surface", Expectation::Exact),
    ("plane-through-eye", Expectation::Exact),
    ("eye-at-vertex", Expectation::Exact),
    ("before-near", Expectation::Exact),
    ("cube-borders", Expectation::Exact),
    ("depth-range", Expectation::Exact),
    ("coarse-frame", Expectation::Exact),
    ("wide-frame", Expectation::Exact),
    ("surface-starts", Expectation::Exact),
    ("cell-borders", Expectation::Exact),
    ("face-cell-borders", Expectation::Exact),
    ("through-view-centre", Expectation::Exact),
    ("flat-tile", Expectation::Exact),
    ("equal-triangles", Expectation::Exact),
    ("stacked-layers", Expectation::Exact),
    ("crowded-pixel", Expectation::Exact),
];
