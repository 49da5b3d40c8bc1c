//! What is expected of `lbvh-gpu`: that of `bvh-gpu`, whose searches it has, over hierarchies built on the device.

use super::expectation::{Column, Expectation};

pub(super) const EXPECTATIONS: Column = &[
    ("edge-on", Expectation::Exact),
    ("wires", Expectation::Exact),
    ("leaves", Expectation::Exact),
    ("close-sheets", Expectation::Exact),
    ("voxel-stack", Expectation::Exact),
    ("open-mesh", Expectation::Exact),
    ("huge-triangle", Expectation::Exact),
    ("needles", Expectation::Exact),
    ("coplanar-copies", Expectation::Exact),
    ("eye-inside-object", Expectation::Exact),
    ("eye-on-surface", Expectation::Exact),
    ("eye-at-vertex", Expectation::Exact),
    ("before-near", Expectation::Exact),
    ("cube-borders", Expectation::Exact),
    ("depth-range", Expectation::Exact),
    ("coarse-frame", Expectation::Exact),
    ("wide-frame", Expectation::Exact),
    ("surface-starts", Expectation::Exact),
    ("cell-borders", Expectation::Exact),
    ("through-view-centre", Expectation::Exact),
    ("flat-tile", Expectation::Exact),
    ("equal-triangles", Expectation::Exact),
    ("stacked-layers", Expectation::Exact),
    ("crowded-pixel", Expectation::Exact),
];
