//! The registration of `screen-dda`: one depth a pixel, sampled at pixel centres, from one view.

use super::expectation::{OF_ONE_VIEW, fails, few};
use super::table::{Values, improved, published, switches};
use super::{Column, Family, Improved, Matters, Registration, Rule, Shrink, Table, Touch};

pub(crate) const REGISTRATION: Registration = Registration {
    expectations: &[EXPECTATIONS, OF_ONE_VIEW],
    improved: Some(Improved { otherwise: None, expectations: &[IMPROVED_EXPECTATIONS, EXPECTATIONS, OF_ONE_VIEW] }),
    ablation: Some(&ABLATION),
    tune: Some("thickness"),
    excluded_from_fronts: &["thickness_in"],
    matters: &[
        Matters { what: &["stride"], by: "march", values: &["pixels", "hi-z"] },
        Matters { what: &["depth_clip", "from_behind"], by: "march", values: &["cells"] },
    ],
    shrinks: &[
        Shrink { axis: "resolution", steps: &["1/2", "1/4", "1/8", "1/16"] },
        Shrink { axis: "layers", steps: &["4", "3", "2", "1"] },
    ],
    touches: &[Touch { counter: "pixels_touched", stored: "pixels", parts: &["eye depth buffer"] }],
    ..Registration::sampled(tracebench_screen_dda::description, Family::Image, |gpu| {
        Ok(Box::new(tracebench_screen_dda::ScreenDda::new(gpu?)?))
    })
};

const RELATIVE: Values = &[("thickness_in", "depth"), ("thickness", "0.02")];
const ABSOLUTE: Values = &[("thickness_in", "diagonals"), ("thickness", "0.005")];

/// Each switch alone; then the improved form, and its switches taken back one by one.
const ABLATION: Table = switches(
    "screen-dda-ablation",
    "the switches between screen-dda as published and as engines have it: builds, traces, bytes, accuracy, counters",
    "stereo,diffuse",
    &[
        published(&[]),
        published(&[("march", "hi-z")]),
        published(&[("march", "cells")]),
        published(&[("march", "cells"), ("depth_clip", "on")]),
        published(&[("hit_point", "depth")]),
        published(RELATIVE),
        published(&[("march", "cells"), ("from_behind", "pass")]),
        improved(&[]),
        improved(&[("march", "pixels")]),
        improved(&[("march", "hi-z")]),
        improved(&[("depth_clip", "off")]),
        improved(&[("hit_point", "step")]),
        improved(ABSOLUTE),
        improved(&[("from_behind", "hit")]),
        improved(&[("layers", "2")]),
    ],
);

const BEHIND: &str = "one depth a pixel: what lies behind the first surface is not stored, and rays that start behind \
                      one meet its assumed thickness or nothing";
const STEP: &str = "a hit is placed at the position of the step, up to half a pixel of the ray's image away, and \
                    within a thickness that every surface is taken to have";
const STEP_SOURCE: &str = "McGuire and Mara 2014, listing 1; DIRT, section 5.1, on thickness";
const LAYERS_SOURCE: &str = "DIRT, section 2, on single depth layers; VVP16, section 2, Figure 2";
const EDGE_ON: &str =
    "a surface along the line of sight covers few pixel centres or none, so rays that cross it find nothing";
const EDGE_ON_SOURCE: &str = "VVP16, section 4.2, limitations: geometry parallel to the view direction is not captured";
const WITHIN: &str = "thickness is a share of the diagonal, and what starts at a thousandth of it starts within the thickness of the surface \
                      that it leaves: nearly all rays are said to hit that";
const STARTS: &str = "the surface that a ray starts on lies within a pixel and within the assumed thickness of the start: it is hit again";
const STARTS_SOURCE: &str =
    "McGuire and Mara 2014, listing 1, whose walk begins a part of a stride off; DIRT, section 5.1, on thickness";
const BORDERS: &str = "on a border the walk samples one of the two pixels: both show the wall, but at its rim";
const BY_LESS: &str = "a ray that passes behind a surface by less than the thickness that every surface is taken to have is said to hit it";
const FROM_BEHIND: &str = "a ray that comes from behind meets the thickness first that every surface is taken to have, and the shorter its image, \
                           the farther apart in depth are its samples, a pixel from each other";
const BESIDE: &str = "samples lie on the ray's own pixels, which do not show what stands beside them";
const BUDGET: &str = "a ray that crosses more pixels than its budget of samples, 4096 here, is given up";
const BUDGET_SOURCE: &str = "WKP15, section 5.1, on the steps that a march is held to";

const STRETCHED: &str = "a hit is placed at a step, and the closer a ray runs to the view's axis the farther apart in depth are steps, a pixel from \
                         each other";
const AS_MANY: &str = "a ray's way has as many pixels, whatever angle the view spans";

const EXPECTATIONS: Column = &[
    ("edge-on", fails(Rule::HitMiss, EDGE_ON, EDGE_ON_SOURCE)),
    ("close-sheets eye-inside-object stacked-layers", fails(Rule::Footprint, BEHIND, LAYERS_SOURCE)),
    ("voxel-stack", fails(Rule::Tight, STEP, STEP_SOURCE)),
    ("secondary-depth-ratio", fails(Rule::Footprint, WITHIN, "DIRT, section 5.1, on thickness")),
    ("surface-starts", fails(Rule::HitMiss, STARTS, STARTS_SOURCE)),
    ("cell-borders", few(Rule::HitMiss, BORDERS)),
    ("thin-walls", few(Rule::HitMiss, "a wall is as thick as every surface is taken to be, whatever it is")),
    ("behind-foreground", fails(Rule::HitMiss, BY_LESS, STEP_SOURCE)),
    ("towards-camera", fails(Rule::Footprint, FROM_BEHIND, STEP_SOURCE)),
    ("foreground-in-cell", few(Rule::HitMiss, BESIDE)),
    ("long-rays", fails(Rule::HitMiss, BUDGET, BUDGET_SOURCE)),
    ("away-from-camera", fails(Rule::Footprint, STRETCHED, STEP_SOURCE)),
    ("field-of-view", few(Rule::HitMiss, AS_MANY)),
];

const PASSES: &str = "a ray must come to a surface from before: one that starts behind what its own pixel shows, or comes out from behind it, passes, \
                      also the surface of which a pixel has one depth for all of its slant";
const OF_DEPTH: &str =
    "thickness is a share of the depth: what starts a thousandth of the diagonal off is told from what it leaves";
const IN_CELLS: &str = "its budget of steps is of cells, and cells without anything in the way are crossed at once";

const AT_DEPTH: &str = "a hit is placed at the depth that its pixel shows, however far apart steps are";

/// Of the improved form: cells in the place of samples, thickness by depth, no hits from behind.
const IMPROVED_EXPECTATIONS: Column = &[
    ("edge-on behind-foreground", fails(Rule::HitMiss, PASSES, LAYERS_SOURCE)),
    ("secondary-depth-ratio", few(Rule::Footprint, OF_DEPTH)),
    ("long-rays", few(Rule::HitMiss, IN_CELLS)),
    ("away-from-camera", few(Rule::Footprint, AT_DEPTH)),
];
