//! The registration of `voxel-abuffer`: layers at texels' centres along three axes of the scene's bounds, inside told from outside;
//! improved, planes that are clipped to texels, each a part of the surface itself.

use super::expectation::{fails, few};
use super::table::{Values, improved, published, switches};
use super::{Column, Expectation, Family, Improved, Matters, Registration, Remedy, Rule, Shrink, Table, Touch};

pub(crate) const REGISTRATION: Registration = Registration {
    expectations: &[EXPECTATIONS],
    improved: Some(Improved { otherwise: Some(OF_PLANES), expectations: &[IMPROVED_EXPECTATIONS] }),
    ablation: Some(&ABLATION),
    remedies: REMEDIES,
    sweep: &["abuffer", "grid"],
    tune: Some("start_bias"),
    shrinks: &[
        Shrink { axis: "resolution", steps: &["1/2", "1/4", "1/8", "1/16"] },
        Shrink { axis: "grid", steps: &["64", "48", "32", "24", "16", "8"] },
    ],
    matters: &[Matters {
        what: &[
            "average",
            "average_from",
            "cancelled_below",
            "search",
            "in_texel",
            "depths",
            "binary_steps",
            "inside",
            "crossing",
            "start_along",
        ],
        by: "fragments",
        values: &["points"],
    }],
    touches: &[
        Touch { counter: "fragments_touched", stored: "fragments", parts: &["nodes (texture)", "nodes"] },
        Touch { counter: "payloads_touched", stored: "fragments", parts: &["data (texture)", "data"] },
    ],
    ..Registration::sampled(tracebench_voxel_abuffer::description, Family::Image, |gpu| {
        Ok(Box::new(tracebench_voxel_abuffer::VoxelAbuffer::new(gpu?)?))
    })
};

const OPEN: &str = "nothing is inside of an open surface, but layers say so of all that lies behind it, each image of another part: rays end \
                    where they leave that, beside the surface and before others";
const OPEN_SOURCE: &str = "HHZ14, section 6: watertight objects are required for tracing rays accurately";
const COARSE: &str = "a texel is a part of the scene's bounds, whatever of them is seen: what is small beside the whole, or near the eye, is \
                      told by few texels and voxels, or by none";
const COARSE_SOURCE: &str =
    "HHZ14, section 6: large and complex scenes need large grids and A-buffers; small objects may be missed in those";
const NEAR_START: &str = "a ray leaves out the first two texels of its way, so as not to meet the surface that it starts on, and with them \
                          what lies as near";
const NEAR_START_SOURCE: &str =
    "HHZ14, section 3.2, which says nothing of rays that start on surfaces; texels follow from section 3.1";
const BETWEEN: &str =
    "what covers no texel's centre in any of three images is not stored, and what covers one fills its texel";

/// Plates that cover many texels, with rims.
const PLATES: Expectation = few(
    Rule::HitMiss,
    "no axis is without an image that shows the surface from before; what is left is a texel more or less at the rims of open plates",
);

const FROM_BEFORE: &str =
    "three projections show every surface from before in one of them (section 3.1), and the average normal chooses it";
const TILED: &str = "needles that tile a plate leave no texel's centre uncovered, and neighbours have one depth";
const NO_EYE: &str = "images do not hang on the eye: a plane that holds it is seen like others; what is left is at the ground's rim, which is open";
const SAME_PART: &str = "however close a ray starts, it leaves out the same part of its way; at a grazing angle it is still within the steps that \
                         layers as deep as at their texels' centres make of a slanted floor";
const HOLES: &str = "there are no views; what is left is at the holes of the sphere, which is open";
const BOTH_SEEN: &str = "the layers that a ray passes within a texel are both seen, however near to each other; any hit leaks where the ray comes \
                         from one texel to the next within the wall's steps";
const IN_ONE_AS_IN_ALL: &str =
    "a ray is before a layer or behind it in one image as in all: what it passes near it does not meet";
const OPEN_PLATE: &str = "there are no views; what is left is a texel more or less at the rims of an open plate";
const NO_VIEWS: &str = "there are no views, in which one thing would stand before another";
const NO_LONG_WAY: &str =
    "no way is long in images of the whole scene; hits are as precise as a texel, which here is wider than a pixel";

const EXPECTATIONS: Column = &[
    ("edge-on", few(Rule::Footprint, FROM_BEFORE)),
    ("wires", fails(Rule::HitMiss, BETWEEN, COARSE_SOURCE)),
    ("leaves voxel-stack cube-borders crowded-pixel field-of-view", fails(Rule::HitMiss, OPEN, OPEN_SOURCE)),
    ("open-mesh", fails(Rule::Footprint, OPEN, OPEN_SOURCE)),
    ("close-sheets eye-on-surface before-near", fails(Rule::HitMiss, NEAR_START, NEAR_START_SOURCE)),
    ("huge-triangle eye-at-vertex depth-range secondary-depth-ratio", fails(Rule::HitMiss, COARSE, COARSE_SOURCE)),
    // The images have two and a half texels by a pixel of the faces, and these go with the frame.
    ("coarse-frame wide-frame half-resolution", fails(Rule::HitMiss, COARSE, COARSE_SOURCE)),
    ("eye-inside-object long-scene", fails(Rule::Footprint, COARSE, COARSE_SOURCE)),
    ("needles", few(Rule::Footprint, TILED)),
    // As many layers at every texel are more than what one binding, or WebGPU's limits, hold.
    ("coplanar-copies", Expectation::Refusable { from: 16.0, otherwise: &PLATES }),
    ("equal-triangles", Expectation::Refusable { from: 256.0, otherwise: &PLATES }),
    ("stacked-layers", Expectation::Refusable { from: 32.0, otherwise: &PLATES }),
    ("plane-through-eye", few(Rule::Footprint, NO_EYE)),
    ("surface-starts", few(Rule::HitMiss, SAME_PART)),
    ("cell-borders face-cell-borders flat-tile off-origin", PLATES),
    ("through-view-centre", few(Rule::HitMiss, HOLES)),
    ("thin-walls", few(Rule::HitMiss, BOTH_SEEN)),
    ("behind-foreground", few(Rule::HitMiss, IN_ONE_AS_IN_ALL)),
    ("towards-camera away-from-camera", few(Rule::HitMiss, OPEN_PLATE)),
    ("foreground-in-cell", few(Rule::HitMiss, NO_VIEWS)),
    ("long-rays", few(Rule::HitMiss, NO_LONG_WAY)),
];

/// What planes get wrong.
const OF_PLANES: Expectation = few(
    Rule::Footprint,
    "a fragment is the surface itself within its texel; what is left is its outline, an octagon there, at the rims of open meshes",
);

const TINY: &str = "what is smaller than a texel is an octagon of the texel's own fineness, so that its outline is off by a part of it";

const IMPROVED_EXPECTATIONS: Column = &[
    ("leaves wide-frame", few(Rule::Footprint, TINY)),
    ("huge-triangle eye-at-vertex before-near depth-range", fails(Rule::Footprint, COARSE, COARSE_SOURCE)),
    ("secondary-depth-ratio coarse-frame crowded-pixel half-resolution", fails(Rule::Footprint, COARSE, COARSE_SOURCE)),
    ("coplanar-copies", Expectation::Refusable { from: 16.0, otherwise: &OF_PLANES }),
    ("equal-triangles stacked-layers", Expectation::Refusable { from: 256.0, otherwise: &OF_PLANES }),
    // By a scale an axis thin walls of a long scene face along it, and cover its whole images.
    ("long-scene", Expectation::Refusable { from: 50.0, otherwise: &OF_PLANES }),
];

/// The best that is known of points.
const BEST_POINTS: Values = &[("fit", "box"), ("average", "lines"), ("depths", "plane"), ("start_bias", "1")];

/// The same where starts are lifted off their surface.
const LIFTED_POINTS: Values =
    &[("fit", "box"), ("average", "lines"), ("depths", "plane"), ("start_bias", "1"), ("start_along", "normal")];

/// From row to row one thing more; then the improved form, and single switches of it turned.
const ABLATION: Table = switches(
    "voxel-abuffer-ablation",
    "the switches between HHZ14 as published and its improved form: builds, traces, bytes, accuracy, counters",
    "primary,specular,diffuse",
    &[
        published(&[]),
        published(&[("fit", "box")]),
        published(&[("fit", "box"), ("average", "lines"), ("depths", "plane")]),
        published(BEST_POINTS),
        published(&[("start_along", "normal")]),
        published(LIFTED_POINTS),
        published(&[("fragments", "planes")]),
        published(&[("fragments", "planes"), ("start_bias", "0")]),
        improved(&[]),
        improved(&[("build", "compute")]),
        improved(&[("abuffer", "320")]),
        improved(&[("abuffer", "160")]),
        improved(&[("grid", "32")]),
        improved(&[("grid", "128")]),
    ],
);

const REMEDIES: &[Remedy] = &[
    Remedy {
        cause: "one_scale_for_all_axes",
        parameter: "fit",
        value: "box",
        source: "HHZ14, section 3.1, says nothing of the bounds: a cube wastes texels of long and flat scenes",
    },
    Remedy {
        cause: "opposite_normals_cancel",
        parameter: "average",
        value: "lines",
        source: "HHZ14, section 3.1: normals are averaged, and opposite ones choose no image",
    },
    Remedy {
        cause: "steps_of_layers",
        parameter: "depths",
        value: "plane",
        source: "HHZ14, section 3.2: depths of the texel's list are compared, which are those at its centre",
    },
    Remedy {
        cause: "few_halvings",
        parameter: "binary_steps",
        value: "24",
        source: "HHZ14, section 3.2: a binary search of some steps places the hit",
    },
    Remedy {
        cause: "sides_told_by_layers",
        parameter: "fragments",
        value: "planes",
        source: "HHZ14, section 6: watertight objects are required for tracing rays accurately, and layers are samples of these",
    },
    Remedy {
        cause: "left_out_at_the_start",
        parameter: "start_bias",
        value: "0",
        source: "HHZ14, section 3.2, says nothing of rays that start on surfaces: two texels of their way are left out",
    },
    Remedy {
        cause: "coarse_images",
        parameter: "abuffer",
        value: "1280",
        source: "HHZ14, section 5: images of 1280 square, with voxels by their rule; smaller frames ask for smaller ones",
    },
];
