//! The room of `voxel-octree`: every voxel that a triangle touches, and hits as precise as one.

use super::expectation::{fails, few};
use super::{Column, Expectation, Family, Registration, Remedy, Rule, Shrink, Touch};

pub(crate) const ROOM: Registration = Registration {
    expectations: EXPECTATIONS,
    ladder: LADDER,
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
const LADDER: &[Remedy] = &[
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

const AT_STARTS: Expectation = fails(Rule::HitMiss, LEFT, LEFT_SOURCE);

const EXPECTATIONS: Column = &[
    ("edge-on", AT_RIMS),
    ("wires", AT_RIMS),
    ("leaves", few(Rule::HitMiss, WIDER)),
    ("close-sheets", AT_STARTS),
    ("voxel-stack", WIDE),
    ("open-mesh", AT_RIMS),
    ("huge-triangle", WIDE),
    ("needles", AT_RIMS),
    // A fragment a triangle and voxel, before those of one voxel are one.
    ("coplanar-copies", Expectation::Refusable { from: 256.0, otherwise: &AT_RIMS }),
    (
        "eye-inside-object",
        few(
            Rule::HitMiss,
            "nothing is hidden from a tree of the whole scene; wrong are rays that pass a rim by less than a voxel",
        ),
    ),
    ("eye-on-surface", AT_STARTS),
    (
        "plane-through-eye",
        few(Rule::HitMiss, "no eye and no face sees the plane edge-on: it is in the voxels that it touches"),
    ),
    ("eye-at-vertex", AT_STARTS),
    ("before-near", WIDE),
    (
        "cube-borders",
        few(
            Rule::HitMiss,
            "there are no faces, and no borders between them; wrong are rays that pass a rim by less than a voxel",
        ),
    ),
    ("depth-range", WIDE),
    ("secondary-depth-ratio", AT_STARTS),
    ("coarse-frame", WIDE),
    ("wide-frame", WIDE),
    (
        "surface-starts",
        few(Rule::HitMiss, "a ray leaves the voxels of the surface that it starts on, from whatever height"),
    ),
    ("cell-borders", AT_RIMS),
    ("face-cell-borders", AT_RIMS),
    (
        "through-view-centre",
        few(Rule::HitMiss, "there are no views; wrong are rays that pass a rim by less than a voxel"),
    ),
    ("flat-tile", AT_RIMS),
    ("equal-triangles", Expectation::Refusable { from: 256.0, otherwise: &AT_RIMS }),
    ("stacked-layers", Expectation::Refusable { from: 256.0, otherwise: &AT_RIMS }),
    ("crowded-pixel", WIDE),
    (
        "thin-walls",
        few(
            Rule::HitMiss,
            "a wall fills the voxels that it touches, however thin it is, and no ray gets between two of them",
        ),
    ),
    ("long-scene", WIDE),
    ("behind-foreground", WIDE),
    ("towards-camera", few(Rule::HitMiss, "there are no views, towards which a ray could come")),
    ("foreground-in-cell", few(Rule::HitMiss, "there are no views, in which one thing would stand before another")),
    (
        "long-rays",
        few(
            Rule::HitMiss,
            "there are no views, and a walk over voxels ends where the scene does, not after so many steps",
        ),
    ),
];
