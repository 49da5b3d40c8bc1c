//! The registration of `voxel-octree`: every voxel that a triangle touches, and hits as precise as one.

use super::expectation::{fails, few};
use super::{Column, Expectation, Family, Registration, Remedy, Rule, Shrink, Touch};

pub(crate) const REGISTRATION: Registration = Registration {
    expectations: &[EXPECTATIONS],
    remedies: REMEDIES,
    sweep: &["levels"],
    shrinks: &[Shrink { axis: "levels", steps: &["9", "8", "7", "6", "5", "4"] }],
    touches: &[
        Touch { counter: "nodes_touched", stored: "nodes", parts: &["nodes (texture)", "nodes"] },
        Touch { counter: "leaves_touched", stored: "leaves", parts: &["leaves (texture)", "leaves"] },
    ],
    ..Registration::sampled(tracebench_voxel_octree::description, Family::Image, |gpu| {
        Ok(Box::new(tracebench_voxel_octree::VoxelOctree::new(gpu?)?))
    })
};

/// A voxel's extent, from its entry to its centre and then all of it.
const REMEDIES: &[Remedy] = &[
    Remedy {
        cause: "entry_of_a_voxel",
        parameter: "hit",
        value: "centre",
        source: "a ray is in a voxel before it is at its surface, by half of the voxel on average",
    },
    Remedy {
        cause: "extent_of_a_voxel",
        parameter: "levels",
        value: "10",
        source: "HHZ14, section 5.2: the precision of a ten-level octree is that of a grid of 1024 cubed",
    },
];

// Where a ray ends in a voxel is never right; what is stated is whether it ends at a surface.
const TOUCHED: &str = "every voxel is stored that a triangle touches, however thin it is and however it is seen; wrong are rays that pass a rim by \
                       less than a voxel";
const WIDER: &str = "surfaces are as wide as the voxels that they touch, and voxels are a share of the scene: what is little larger than a \
                     voxel is hit beside it";
const WIDER_SOURCE: &str = "HHZ14, section 5.2: voxels represent a scene as precisely as their resolution allows";
const LEFT: &str = "a ray leaves the voxels that hold its start, and whatever else lies in them or in those that join them on its way: as \
                    large as a voxel is in this scene";
const LEFT_SOURCE: &str =
    "no source says how rays leave the voxels that they start in; HHZ14, section 5.2, traces them to leaves";

const AT_RIMS: Expectation = few(Rule::HitMiss, TOUCHED);

const WIDE: Expectation = fails(Rule::HitMiss, WIDER, WIDER_SOURCE);

const WHOLE_SCENE: &str =
    "nothing is hidden from a tree of the whole scene; wrong are rays that pass a rim by less than a voxel";
const NO_FACES: &str =
    "there are no faces, and no borders between them; wrong are rays that pass a rim by less than a voxel";
const NO_EDGE_ON: &str = "no eye and no face sees the plane edge-on: it is in the voxels that it touches";
const STARTS: &str = "a ray leaves the voxels of the surface that it starts on, from whatever height";
const NO_VIEWS: &str = "there are no views; wrong are rays that pass a rim by less than a voxel";
const FILLED: &str = "a wall fills the voxels that it touches, however thin it is, and no ray gets between two of them";
const NO_BEFORE: &str = "there are no views, in which one thing would stand before another";
const NO_BUDGET: &str = "there are no views, and a walk over voxels ends where the scene does, not after so many steps";

const EXPECTATIONS: Column = &[
    ("edge-on wires open-mesh needles cell-borders face-cell-borders flat-tile off-origin", AT_RIMS),
    ("voxel-stack huge-triangle before-near depth-range coarse-frame wide-frame crowded-pixel", WIDE),
    ("long-scene behind-foreground half-resolution field-of-view", WIDE),
    ("leaves", few(Rule::HitMiss, WIDER)),
    ("close-sheets eye-on-surface eye-at-vertex secondary-depth-ratio", fails(Rule::HitMiss, LEFT, LEFT_SOURCE)),
    // A fragment a triangle and voxel, before those of one voxel are one.
    ("coplanar-copies equal-triangles stacked-layers", Expectation::Refusable { from: 256.0, otherwise: &AT_RIMS }),
    ("eye-inside-object", few(Rule::HitMiss, WHOLE_SCENE)),
    ("plane-through-eye", few(Rule::HitMiss, NO_EDGE_ON)),
    ("cube-borders", few(Rule::HitMiss, NO_FACES)),
    ("surface-starts", few(Rule::HitMiss, STARTS)),
    ("through-view-centre away-from-camera", few(Rule::HitMiss, NO_VIEWS)),
    ("thin-walls", few(Rule::HitMiss, FILLED)),
    ("towards-camera", few(Rule::HitMiss, "there are no views, towards which a ray could come")),
    ("foreground-in-cell", few(Rule::HitMiss, NO_BEFORE)),
    ("long-rays", few(Rule::HitMiss, NO_BUDGET)),
];
