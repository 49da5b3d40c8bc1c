//! The room of `height-field`: one depth a pixel from one view, all behind it solid.

use super::expectation::{fails, few, of_huge_triangles, of_plates_along_rows};
use super::{Column, Expectation, Family, Registration, Rule, Shrink, Touch};

pub(crate) const ROOM: Registration = Registration {
    expectations: EXPECTATIONS,
    tune: Some("start_bias"),
    shrinks: &[Shrink { axis: "resolution", steps: &["1/2", "1/4", "1/8", "1/16"] }],
    touches: &[Touch {
        counter: "cells_touched",
        stored: "cells",
        parts: &["depth pyramid in a texture", "depth pyramid"],
    }],
    ..Registration::sampled(tracebench_height_field::description, Family::Image, |gpu| {
        Ok(Box::new(tracebench_height_field::HeightField::new(gpu?)?))
    })
};

/// Rays through the frame's own pixel centres find the depth that is stored there.
const AT_SAMPLES: Expectation = few(
    Rule::Footprint,
    "eye rays through pixel centres get the very depth that was sampled there; only where an edge runs through a centre does the \
     rasterizer's rounding of vertices decide otherwise",
);

const SOLID: &str = "all behind what the view shows is solid: a ray that passes behind it, or starts there, hits";
const SOLID_SOURCE: &str =
    "WKP15, section 5.1 and Figure 6: height fields prefer the foreground and leave disocclusions unresolved";
const BEFORE_NEAR: &str = "what is nearer than near is clipped away when depth is rasterized";
const NEAR_SOURCE: &str = "VVP16, section 3.2, which pulls its views back by near to cover what is clipped";
const BETWEEN: &str = "what covers no pixel's centre is not stored, and what covers one fills its pixel";
const SAMPLES_SOURCE: &str =
    "VVP16, section 4.2, limitations: what is stored is bounded by resolution and pixel samples";
const STAIRS: &str = "without bilinear patches a pixel is a column with a level top: hits lie on stairs, a pixel wide";
const STAIRS_SOURCE: &str = "WKP15, section 5.1: staircases of pixels, where patches are switched off";
const HALVED: &str = "of an eye ray, whose way from near to far is one pixel, 24 halvings leave a part of sixteen million of far: beside what \
                      lies near that is much";
const HALVED_SOURCE: &str =
    "Tevs, Ihrke and Seidel 2008: a binary search ends the walk; WKP15, section 5.1, which measured it so";

const EXPECTATIONS: Column = &[
    (
        "edge-on",
        fails(
            Rule::HitMiss,
            "all behind what the view shows is solid: rays that pass behind the plate hit; and seen from its edge it covers few pixel centres \
             or none, so that rays which cross it find nothing",
            SOLID_SOURCE,
        ),
    ),
    ("wires", fails(Rule::HitMiss, BETWEEN, SAMPLES_SOURCE)),
    ("leaves", fails(Rule::HitMiss, BETWEEN, SAMPLES_SOURCE)),
    ("close-sheets", fails(Rule::Tight, SOLID, SOLID_SOURCE)),
    ("voxel-stack", fails(Rule::Tight, STAIRS, STAIRS_SOURCE)),
    ("open-mesh", AT_SAMPLES),
    ("huge-triangle", of_huge_triangles(&fails(Rule::Footprint, HALVED, HALVED_SOURCE))),
    (
        "needles",
        few(
            Rule::Footprint,
            "needles that tile a plate leave no pixel centre uncovered, and neighbours have almost one depth",
        ),
    ),
    ("coplanar-copies", AT_SAMPLES),
    ("eye-inside-object", fails(Rule::Footprint, SOLID, SOLID_SOURCE)),
    ("eye-on-surface", fails(Rule::Footprint, BEFORE_NEAR, NEAR_SOURCE)),
    (
        "plane-through-eye",
        fails(
            Rule::Footprint,
            "rays from beside the view, onto a plane that is at last no more than a line in it",
            "VVP16, section 2, on surfaces outside of the primary view",
        ),
    ),
    ("eye-at-vertex", fails(Rule::Footprint, BEFORE_NEAR, NEAR_SOURCE)),
    ("before-near", fails(Rule::Footprint, BEFORE_NEAR, NEAR_SOURCE)),
    (
        "cube-borders",
        fails(
            Rule::HitMiss,
            "most of the directions between cube faces leave the one view that there is",
            "VVP16, section 2, on surfaces outside of the primary view",
        ),
    ),
    ("depth-range", fails(Rule::Footprint, HALVED, HALVED_SOURCE)),
    ("secondary-depth-ratio", fails(Rule::Footprint, SOLID, SOLID_SOURCE)),
    ("coarse-frame", fails(Rule::Footprint, BETWEEN, SAMPLES_SOURCE)),
    ("wide-frame", of_plates_along_rows(&AT_SAMPLES)),
    (
        "surface-starts",
        fails(
            Rule::HitMiss,
            "a ray that starts on a slanted surface starts behind its pixel's one depth as often as before it, and hits at its start",
            SOLID_SOURCE,
        ),
    ),
    (
        "cell-borders",
        few(
            Rule::HitMiss,
            "on a border rounding decides between two columns: both have the wall as their top, but at its rim",
        ),
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
    ("stacked-layers", fails(Rule::Tight, SOLID, SOLID_SOURCE)),
    ("crowded-pixel", fails(Rule::HitMiss, BETWEEN, SAMPLES_SOURCE)),
    ("thin-walls", few(Rule::HitMiss, "a wall is solid as far as the view reaches, however thin it is")),
    ("long-scene", AT_SAMPLES),
    ("behind-foreground", fails(Rule::HitMiss, SOLID, SOLID_SOURCE)),
    ("towards-camera", fails(Rule::Footprint, SOLID, SOLID_SOURCE)),
    (
        "foreground-in-cell",
        few(
            Rule::HitMiss,
            "a cell that holds more than the ray's way is opened, down to the pixels, which hold that alone",
        ),
    ),
    (
        "long-rays",
        few(Rule::HitMiss, "there is no budget of steps: cells without anything in the way are crossed at once"),
    ),
];
