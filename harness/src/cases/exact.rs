//! What is expected of analytic methods with a watertight triangle test that see every triangle and no view: no wrong ray.
//!
//! `bvh-gpu`; `lbvh-gpu`, which has its searches over hierarchies built on the device; and `ray-query`, whose triangle test is the
//! driver's own: Vulkan asks drivers for a watertight one (VK_KHR_ray_query, "Watertightness"), and Mesa's software driver
//! (25.0) has one. Another driver that does worse comes out as unexpected, which is what its column is for.

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
