//! The room of `screen-dda`: one depth a pixel, sampled at pixel centres, from one view.

use super::expectation::{fails, few, of_huge_triangles, of_plates_along_rows};
use super::{Column, Expectation, Family, Registration, Rule, Shrink, Touch};

pub(crate) const ROOM: Registration = Registration {
    expectations: EXPECTATIONS,
    tune: Some("thickness"),
    shrinks: &[
        Shrink { axis: "resolution", steps: &["1/2", "1/4", "1/8", "1/16"] },
        Shrink { axis: "layers", steps: &["4", "3", "2", "1"] },
    ],
    touches: &[Touch { counter: "pixels_touched", stored: "pixels", parts: &["eye depth buffer"] }],
    ..Registration::sampled(tracebench_screen_dda::description, Family::Image, |gpu| {
        Ok(Box::new(tracebench_screen_dda::ScreenDda::new(gpu?)?))
    })
};

/// Rays through the frame's own pixel centres find the depth that is stored there.
const AT_SAMPLES: Expectation = few(
    Rule::Footprint,
    "eye rays through pixel centres get the very depth that was sampled there; only where an edge runs \
             through a centre does the rasterizer's rounding of vertices decide otherwise",
);

const BEHIND: &str = "one depth a pixel: what lies behind the first surface is not stored, and rays that start behind \
                      one meet its assumed thickness or nothing";
const BEFORE_NEAR: &str = "what is nearer than near is clipped away when depth is rasterized";
const BETWEEN: &str = "what covers no pixel's centre is not stored, and what covers one fills its pixel";
const STEP: &str = "a hit is placed at the position of the step, up to half a pixel of the ray's image away, and \
                    within a thickness that every surface is taken to have";
const STEP_SOURCE: &str = "McGuire and Mara 2014, listing 1; DIRT, section 5.1, on thickness";
const LAYERS_SOURCE: &str = "DIRT, section 2, on single depth layers; VVP16, section 2, Figure 2";
const SAMPLES_SOURCE: &str =
    "VVP16, section 4.2, limitations: what is stored is bounded by resolution and pixel samples";

const EXPECTATIONS: Column = &[
    (
        "edge-on",
        fails(
            Rule::HitMiss,
            "a surface along the line of sight covers few pixel centres or none, so rays that cross it find nothing",
            "VVP16, section 4.2, limitations: geometry parallel to the view direction is not captured",
        ),
    ),
    ("wires", fails(Rule::HitMiss, BETWEEN, SAMPLES_SOURCE)),
    ("leaves", fails(Rule::HitMiss, BETWEEN, SAMPLES_SOURCE)),
    ("close-sheets", fails(Rule::Footprint, BEHIND, LAYERS_SOURCE)),
    ("voxel-stack", fails(Rule::Tight, STEP, STEP_SOURCE)),
    ("open-mesh", AT_SAMPLES),
    ("huge-triangle", of_huge_triangles(&AT_SAMPLES)),
    (
        "needles",
        few(
            Rule::Footprint,
            "needles that tile a plate leave no pixel centre uncovered, and neighbours have almost one depth",
        ),
    ),
    ("coplanar-copies", AT_SAMPLES),
    ("eye-inside-object", fails(Rule::Footprint, BEHIND, LAYERS_SOURCE)),
    (
        "eye-on-surface",
        fails(
            Rule::Footprint,
            BEFORE_NEAR,
            "VVP16, section 3.2, which pulls its views back by near to cover what is clipped",
        ),
    ),
    (
        "plane-through-eye",
        fails(
            Rule::Footprint,
            "rays from beside the view, onto a plane that is at last no more than a line in it",
            "VVP16, section 2, on surfaces outside of the primary view",
        ),
    ),
    (
        "eye-at-vertex",
        fails(
            Rule::Footprint,
            BEFORE_NEAR,
            "VVP16, section 3.2, which pulls its views back by near to cover what is clipped",
        ),
    ),
    (
        "before-near",
        fails(
            Rule::Footprint,
            BEFORE_NEAR,
            "VVP16, section 3.2, which pulls its views back by near to cover what is clipped",
        ),
    ),
    (
        "cube-borders",
        fails(
            Rule::HitMiss,
            "most of the directions between cube faces leave the one view that there is",
            "VVP16, section 2, on surfaces outside of the primary view",
        ),
    ),
    ("depth-range", AT_SAMPLES),
    (
        "secondary-depth-ratio",
        fails(
            Rule::Footprint,
            "thickness is a share of the diagonal, and what starts at a thousandth of it starts within the thickness of the surface that it \
             leaves: nearly all rays are said to hit that",
            "DIRT, section 5.1, on thickness",
        ),
    ),
    ("coarse-frame", fails(Rule::Footprint, BETWEEN, SAMPLES_SOURCE)),
    ("wide-frame", of_plates_along_rows(&AT_SAMPLES)),
    (
        "surface-starts",
        fails(
            Rule::HitMiss,
            "the surface that a ray starts on lies within a pixel and within the assumed thickness of the start: it \
             is hit again",
            "McGuire and Mara 2014, listing 1, whose walk begins a part of a stride off; DIRT, section 5.1, on thickness",
        ),
    ),
    (
        "cell-borders",
        few(Rule::HitMiss, "on a border the walk samples one of the two pixels: both show the wall, but at its rim"),
    ),
    (
        "face-cell-borders",
        few(Rule::HitMiss, "no borders of its own frame: the wall is seen, its rim by a pixel more or less"),
    ),
    (
        "through-view-centre",
        few(
            Rule::HitMiss,
            "the closer a ray passes by the eye the shorter its image, at last one pixel, whose depth it hits",
        ),
    ),
    ("flat-tile", AT_SAMPLES),
    ("equal-triangles", AT_SAMPLES),
    ("stacked-layers", fails(Rule::Footprint, BEHIND, LAYERS_SOURCE)),
    ("crowded-pixel", fails(Rule::HitMiss, BETWEEN, SAMPLES_SOURCE)),
    ("thin-walls", few(Rule::HitMiss, "a wall is as thick as every surface is taken to be, whatever it is")),
    ("long-scene", AT_SAMPLES),
    (
        "behind-foreground",
        fails(
            Rule::HitMiss,
            "a ray that passes behind a surface by less than the thickness that every surface is taken to have is said to hit it",
            STEP_SOURCE,
        ),
    ),
    (
        "towards-camera",
        fails(
            Rule::Footprint,
            "a ray that comes from behind meets the thickness first that every surface is taken to have, and the shorter its image, the farther \
             apart in depth are its samples, a pixel from each other",
            STEP_SOURCE,
        ),
    ),
    (
        "foreground-in-cell",
        few(Rule::HitMiss, "samples lie on the ray's own pixels, which do not show what stands beside them"),
    ),
    (
        "long-rays",
        fails(
            Rule::HitMiss,
            "a ray that crosses more pixels than its budget of samples, 4096 here, is given up",
            "WKP15, section 5.1, on the steps that a march is held to",
        ),
    ),
];
