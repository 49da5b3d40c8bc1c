//! The registration of `height-field`: one depth a pixel from one view, all behind it solid.

use super::expectation::{OF_ONE_VIEW, fails, few, of_huge_triangles};
use super::table::{improved, published, switches};
use super::{Column, Family, Improved, Matters, Registration, Rule, Shrink, Table, Touch};

pub(crate) const REGISTRATION: Registration = Registration {
    expectations: &[EXPECTATIONS, OF_ONE_VIEW],
    improved: Some(Improved { otherwise: None, expectations: &[IMPROVED_EXPECTATIONS, EXPECTATIONS, OF_ONE_VIEW] }),
    ablation: Some(&ABLATION),
    tune: Some("start_bias"),
    matters: &[Matters { what: &["refinement"], by: "search", values: &["halvings"] }],
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

/// The published form, each switch alone, the improved form.
const ABLATION: Table = switches(
    "height-field-ablation",
    "the switches between the height field as published and its improved form: builds, traces, bytes, accuracy, counters",
    "stereo,diffuse",
    &[
        published(&[]),
        published(&[("search", "closed")]),
        published(&[("depth_clip", "on")]),
        improved(&[]),
        improved(&[("pyramid", "max")]),
    ],
);

const SOLID: &str = "all behind what the view shows is solid: a ray that passes behind it, or starts there, hits";
const SOLID_SOURCE: &str =
    "WKP15, section 5.1 and Figure 6: height fields prefer the foreground and leave disocclusions unresolved";
const STAIRS: &str = "without bilinear patches a pixel is a column with a level top: hits lie on stairs, a pixel wide";
const STAIRS_SOURCE: &str = "WKP15, section 5.1: staircases of pixels, where patches are switched off";
const HALVED: &str = "of an eye ray, whose way from near to far is one pixel, 24 halvings leave a part of sixteen million of far: beside what \
                      lies near that is much";
const HALVED_SOURCE: &str =
    "Tevs, Ihrke and Seidel 2008: a binary search ends the walk; WKP15, section 5.1, which measured it so";

const EDGE_ON: &str = "all behind what the view shows is solid: rays that pass behind the plate hit; and seen from its edge it covers few pixel \
                       centres or none, so that rays which cross it find nothing";
const STARTS: &str = "a ray that starts on a slanted surface starts behind its pixel's one depth as often as before it, and hits at its start";
const COLUMNS: &str =
    "on a border rounding decides between two columns: both have the wall as their top, but at its rim";
const OPENED: &str = "a cell that holds more than the ray's way is opened, down to the pixels, which hold that alone";
const NO_BUDGET: &str = "there is no budget of steps: cells without anything in the way are crossed at once";

const EXPECTATIONS: Column = &[
    ("edge-on", fails(Rule::HitMiss, EDGE_ON, SOLID_SOURCE)),
    ("close-sheets stacked-layers", fails(Rule::Tight, SOLID, SOLID_SOURCE)),
    ("eye-inside-object secondary-depth-ratio towards-camera", fails(Rule::Footprint, SOLID, SOLID_SOURCE)),
    ("behind-foreground", fails(Rule::HitMiss, SOLID, SOLID_SOURCE)),
    ("surface-starts", fails(Rule::HitMiss, STARTS, SOLID_SOURCE)),
    ("voxel-stack", fails(Rule::Tight, STAIRS, STAIRS_SOURCE)),
    ("huge-triangle", of_huge_triangles(&fails(Rule::Footprint, HALVED, HALVED_SOURCE))),
    ("depth-range", fails(Rule::Footprint, HALVED, HALVED_SOURCE)),
    ("cell-borders", few(Rule::HitMiss, COLUMNS)),
    ("thin-walls", few(Rule::HitMiss, "a wall is solid as far as the view reaches, however thin it is")),
    ("foreground-in-cell", few(Rule::HitMiss, OPENED)),
    ("long-rays", few(Rule::HitMiss, NO_BUDGET)),
    ("field-of-view", fails(Rule::HitMiss, SOLID, SOLID_SOURCE)),
];

const AT_ONCE: &str = "a hit is placed where the ray is as deep as the top of its pixel: nothing is halved";

/// Of the improved form, which does not halve.
const IMPROVED_EXPECTATIONS: Column = &[
    ("huge-triangle", of_huge_triangles(&few(Rule::Footprint, AT_ONCE))),
    ("depth-range", few(Rule::Footprint, AT_ONCE)),
];
