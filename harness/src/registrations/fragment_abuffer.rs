//! The registration of `fragment-abuffer`: fragments at pixels' centres, every layer, seven views, no thickness; improved, fragments that
//! are planes, in every pixel that a triangle touches.

use super::expectation::{
    BETWEEN, FROM_EYE, SAMPLES_SOURCE, TILED, fails, few, of_huge_triangles, of_plates_along_rows,
};
use super::table::{Values, improved, published, switches};
use super::{Column, Expectation, Family, Improved, Matters, Registration, Remedy, Rule, Shrink, Table, Touch};

pub(crate) const REGISTRATION: Registration = Registration {
    expectations: &[EXPECTATIONS],
    improved: Some(Improved { otherwise: Some(BEYOND_EDGES), expectations: &[IMPROVED_EXPECTATIONS] }),
    ablation: Some(&ABLATION),
    remedies: REMEDIES,
    tune: Some("thickness"),
    excluded_from_fronts: &["decoupled", "thickness_in", "binary_search_above"],
    shrinks: &[
        Shrink { axis: "resolution", steps: &["1/2", "1/4", "1/8", "1/16"] },
        Shrink { axis: "buckets", steps: &["16", "12", "8", "4", "2", "1"] },
        Shrink { axis: "layers", steps: &["all", "one"] },
        Shrink { axis: "views", steps: &["seven", "six", "frame"] },
    ],
    matters: &[
        Matters { what: &["buckets", "skip_buckets"], by: "storage", values: &["llb", "dllb"] },
        Matters { what: &["view_steps", "jitter", "span"], by: "march", values: &["steps"] },
        Matters { what: &["thickness"], by: "fragments", values: &["points"] },
        Matters { what: &["outline"], by: "fragments", values: &["planes"] },
        Matters { what: &["max_steps"], by: "march", values: &["pixels", "hi-z"] },
    ],
    touches: &[
        Touch { counter: "fragments_touched", stored: "fragments", parts: &["id buffer (texture)", "id buffer"] },
        Touch { counter: "payloads_touched", stored: "fragments", parts: &["data buffer (texture)", "data buffer"] },
    ],
    ..Registration::sampled(tracebench_fragment_abuffer::description, Family::Image, |gpu| {
        Ok(Box::new(tracebench_fragment_abuffer::FragmentAbuffer::new(gpu?)?))
    })
};

/// Rays through the frame's own pixel centres find the very depth that is stored there.
const AT_SAMPLES: Expectation = few(
    Rule::Footprint,
    "eye rays through the centres of the camera's pixels get the very depth that was sampled there; only where an edge runs through a \
     centre does the rasterizer's rounding decide otherwise",
);

const SLIPPED: &str = "at thickness 0 a ray that crosses a slanted surface passes between two of its fragments, the more often the more \
                       slanted it is; a surface along the line of sight has none";
const SLIPPED_SOURCE: &str =
    "VVP16, section 4.2, limitations: rays pass between fragments of sparsely sampled triangles";
const BEFORE_NEAR: &str = "what is nearer than near lies in the faces alone, whose centres are pulled back: seen from there at a grazing \
                           angle, it lets rays through between fragments";
const NEAR_START: &str = "a ray that starts in a view leaves out the first pixel of its way, so as not to find the surface that it starts \
                          on, and with it what lies as near";
const NEAR_START_SOURCE: &str =
    "McGuire and Mara 2014, listing 1, whose walk begins a part of a stride off; VVP16 does not say";
const ALL_KEPT: &str = "the shell hides nothing, as all layers are kept: what is left is between samples";
const NO_GAP: &str = "no direction is without a face; rays along the borders cross the sphere where faces see it most slanted and pass between \
                      fragments there";
const LINEAR: &str = "depths stand in 32-bit floats, linear from the eye: no ratio is too large for them; what is left is at the plates' rims and \
                      near a ray's start";
const STARTS: &str =
    "near its start a ray runs along the surface that it starts on, and meets fragments of it a pixel on";
const STARTS_SOURCE: &str =
    "VVP16, section 4.2, limitations; it does not say how rays leave the surface that they start on";
const EITHER: &str = "either pixel at a border shows the wall, but at its rim, and near a ray's start";
const CAMERA: &str = "the camera's view answers: the wall is seen, its rim by a pixel more or less";
const FEW_STEPS: &str =
    "near the centre of a view a ray crosses its image at once: few steps, and a hit by the depth of one of them";
const BOTH_SIDES: &str = "both sides of a wall are kept, however near to each other: a ray slips through only where it passes between fragments of \
                          both";
const NO_THICKNESS: &str = "a fragment has no thickness: what a ray passes behind it does not meet, however near";
const HALF_A_PIXEL: &str = "a hit lies at its fragment's depth, half a pixel off on a surface that is slanted by half";
const BESIDE: &str = "what stands beside a ray's way lies at other pixels than those that its steps look at";
const APART: &str = "a hundred steps a view lie farther apart than the post is wide, and a step looks at one pixel";
const APART_SOURCE: &str = "VVP16, section 3.4 and Figure 10, on the number of steps";

/// Layers are all kept, but those that a ray starts between.
const LAYERS: Expectation = fails(
    Rule::Footprint,
    "rays that start between layers take one for another once these lie nearer to each other than samples do",
    SAMPLES_SOURCE,
);

const EXPECTATIONS: Column = &[
    ("edge-on plane-through-eye", fails(Rule::HitMiss, SLIPPED, SLIPPED_SOURCE)),
    ("voxel-stack", fails(Rule::Footprint, SLIPPED, SLIPPED_SOURCE)),
    ("wires leaves crowded-pixel", fails(Rule::HitMiss, BETWEEN, SAMPLES_SOURCE)),
    ("coarse-frame half-resolution", fails(Rule::Footprint, BETWEEN, SAMPLES_SOURCE)),
    ("close-sheets", fails(Rule::HitMiss, NEAR_START, NEAR_START_SOURCE)),
    ("open-mesh depth-range flat-tile long-scene", AT_SAMPLES),
    ("huge-triangle", of_huge_triangles(&AT_SAMPLES)),
    ("wide-frame", of_plates_along_rows(&AT_SAMPLES)),
    ("needles", few(Rule::Footprint, TILED)),
    // As many layers at every pixel are more than what WebGPU's limits let one binding hold.
    ("coplanar-copies", Expectation::Refusable { from: 256.0, otherwise: &AT_SAMPLES }),
    ("equal-triangles", Expectation::Refusable { from: 1024.0, otherwise: &AT_SAMPLES }),
    ("stacked-layers", Expectation::Refusable { from: 2048.0, otherwise: &LAYERS }),
    ("eye-inside-object", few(Rule::Footprint, ALL_KEPT)),
    ("eye-on-surface eye-at-vertex before-near", fails(Rule::Footprint, BEFORE_NEAR, SLIPPED_SOURCE)),
    ("cube-borders", few(Rule::HitMiss, NO_GAP)),
    ("secondary-depth-ratio", few(Rule::Footprint, LINEAR)),
    ("surface-starts", fails(Rule::HitMiss, STARTS, STARTS_SOURCE)),
    ("cell-borders", few(Rule::HitMiss, EITHER)),
    ("face-cell-borders", few(Rule::HitMiss, CAMERA)),
    ("through-view-centre", few(Rule::HitMiss, FEW_STEPS)),
    ("thin-walls", few(Rule::HitMiss, BOTH_SIDES)),
    ("behind-foreground", few(Rule::HitMiss, NO_THICKNESS)),
    ("towards-camera away-from-camera field-of-view", few(Rule::Footprint, HALF_A_PIXEL)),
    ("foreground-in-cell", few(Rule::HitMiss, BESIDE)),
    ("long-rays", fails(Rule::HitMiss, APART, APART_SOURCE)),
    ("off-origin", few(Rule::Footprint, FROM_EYE)),
];

/// A plane ends with its part of a pixel, not with its triangle.
const BEYOND_EDGES: Expectation = few(
    Rule::Footprint,
    "a ray meets the plane of a triangle wherever it fills its pixel: at edges, where the triangle ends within a thirtieth of the pixel, the \
     hit may be the plane's alone",
);

const AT_RIMS: &str =
    "rims are as many as surfaces, and at each a plane reaches beyond its triangle by a part of a pixel";
const COARSE: &str =
    "a part of a pixel is the smallest thing that there is: what the plane fills of it is wider than the triangle";
const IN_FACES: &str =
    "what is nearer than near lies in the faces alone, which see it at a grazing angle, and coarsely";

/// What is expected of planes in every pixel that a triangle touches.
const IMPROVED_EXPECTATIONS: Column = &[
    ("leaves voxel-stack long-scene cube-borders wide-frame", few(Rule::Footprint, AT_RIMS)),
    ("crowded-pixel eye-at-vertex coarse-frame half-resolution", fails(Rule::Footprint, COARSE, SAMPLES_SOURCE)),
    ("before-near", few(Rule::Footprint, IN_FACES)),
    ("coplanar-copies", Expectation::Refusable { from: 256.0, otherwise: &BEYOND_EDGES }),
    ("equal-triangles", Expectation::Refusable { from: 1024.0, otherwise: &BEYOND_EDGES }),
    ("stacked-layers", Expectation::Refusable { from: 2048.0, otherwise: &BEYOND_EDGES }),
];

/// Planes that fill their pixels.
const PLANES: Values = &[("fragments", "planes")];
const TOUCHED: Values = &[("coverage", "conservative")];
const TOUCHED_PLANES: Values = &[("fragments", "planes"), ("coverage", "conservative")];

/// Each of the two switches that change what is stored alone, and both; then the improved form, and its switches taken back one by one.
const ABLATION: Table = switches(
    "fragment-abuffer-ablation",
    "the switches between the fragment A-buffer as published and its improved form: builds, traces, bytes, fragments, accuracy, \
              counters",
    "primary,specular,diffuse",
    &[
        published(&[]),
        published(&[("march", "hi-z")]),
        published(&[("march", "hi-z"), ("start_bias", "0")]),
        published(PLANES),
        published(TOUCHED),
        published(TOUCHED_PLANES),
        published(&[("fragments", "planes"), ("coverage", "conservative"), ("outline", "masked")]),
        improved(&[("fragments", "points"), ("coverage", "sample")]),
        improved(&[("fragments", "points")]),
        improved(&[("coverage", "sample")]),
        improved(&[("outline", "filled")]),
        improved(&[]),
        improved(&[("storage", "ll")]),
        improved(&[("storage", "dllb")]),
        improved(&[("decoupled", "on")]),
        improved(&[("march", "pixels")]),
        improved(&[("march", "steps")]),
        improved(&[("skip_bounds", "off")]),
        improved(&[("skip_lists", "off")]),
        improved(&[("start_bias", "1")]),
        improved(&[("build", "raster")]),
    ],
);

const REMEDIES: &[Remedy] = &[
    Remedy {
        cause: "pixels_left_out",
        parameter: "march",
        value: "hi-z",
        source: "VVP16, section 3.4 and Figure 10: a fixed number of steps leaves pixels out, each step looks at one",
    },
    Remedy {
        cause: "first_pixel_left_out",
        parameter: "start_bias",
        value: "0",
        source: "McGuire and Mara 2014, listing 1, whose walk begins a part of a stride off; VVP16 does not say",
    },
    Remedy {
        cause: "passed_between_fragments",
        parameter: "fragments",
        value: "planes",
        source: "VVP16, section 4.2, limitations: rays pass between fragments of sparsely sampled triangles",
    },
    Remedy {
        cause: "coverage_by_sample",
        parameter: "coverage",
        value: "conservative",
        source: "VVP16, section 4.2, limitations: what is stored is bounded by resolution and pixel samples",
    },
    Remedy {
        cause: "filled_pixels",
        parameter: "outline",
        value: "masked",
        source: "VVP16, section 4.2, limitations: a fragment stands for all of its pixel",
    },
];
