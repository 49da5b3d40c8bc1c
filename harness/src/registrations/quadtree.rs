//! The registration of `quadtree`: two depth layers of the frame, each pixel a small plane, merged by thresholds in the unit cube.

use super::expectation::{
    ASIDE, BETWEEN, FROM_EYE, LEAVE_VIEW, NEAR_SOURCE, NO_BORDERS, fails, few, of_huge_triangles, of_plates_along_rows,
};
use super::table::{Values, improved, published, switches};
use super::{Column, Expectation, Family, Improved, Registration, Remedy, Rule, Shrink, Table, Touch};

pub(crate) const REGISTRATION: Registration = Registration {
    expectations: &[EXPECTATIONS],
    improved: Some(Improved { otherwise: None, expectations: &[IMPROVED_EXPECTATIONS, EXPECTATIONS] }),
    ablation: Some(&ABLATION),
    remedies: REMEDIES,
    sweep: &["gamma_norm", "gamma_dist", "layers"],
    tune: Some("gamma_dist"),
    excluded_from_fronts: &["gamma_dist_in", "secondary_samples", "secondary_jitter", "secondary_sigma"],
    shrinks: &[
        Shrink { axis: "resolution", steps: &["1/2", "1/4", "1/8", "1/16"] },
        Shrink { axis: "layers", steps: &["4", "3", "2", "1"] },
    ],
    touches: &[Touch {
        counter: "nodes_touched",
        stored: "nodes",
        parts: &["quad-tree nodes (texture)", "quad-tree nodes"],
    }],
    ..Registration::sampled(tracebench_quadtree::description, Family::Image, |gpu| {
        Ok(Box::new(tracebench_quadtree::Quadtree::new(gpu?)?))
    })
};

/// Rays through the frame's own pixel centres find the depth that is stored there, as far as thresholds leave it.
const AT_SAMPLES: Expectation = few(
    Rule::Footprint,
    "eye rays through pixel centres get the plane that stands for the depth that was sampled there; only where an edge runs through a \
     centre does the rasterizer's rounding decide otherwise",
);

const BEHIND: &str = "two layers: what lies behind the second surface is not stored";
const BEFORE_NEAR: &str = "what is nearer than near is clipped away when layers are drawn";
const MERGED: &str = "near is a thousandth of the diagonal, so that 1e-5 of the unit cube is a hundredth of the diagonal at a diagonal's distance: \
                      there planes stand for others as far away as that";
const MERGED_SOURCE: &str =
    "WKP15, section 3.3 and section 6: thresholds in normalized device coordinates; near and far are not stated";
const LAYERS_SOURCE: &str = "WKP15, section 4.1: what lies in the occlusion volume of the last layer is not known";
const NEAR_START: &str = "a ray begins to look a pixel's height away from its start, so as not to meet the surface that it starts on: beyond what \
                          lies nearer";
const NEAR_START_SOURCE: &str = "WKP15, section 4, which says nothing of rays that start on a surface";
const SAMPLES_SOURCE: &str = "WKP15, section 3.2: each pixel is a small plane";
const ASIDE_SOURCE: &str = "WKP15, section 5.4: what is outside of the view needs a cube map";

const EDGE_ON: &str =
    "a surface along the line of sight covers few pixel centres or none, so rays that cross it find nothing";
const CROWDED: &str = "of a crowd of small triangles at all angles two layers are stored, and those seen from their edges cover few pixels, all \
                       of them near a discontinuity: rays pass between their planes";
const BOTH_SIDES: &str = "of what the eye looks out of both sides are layers; wrong are rays at rims";
const FOLLOWED: &str =
    "rays begin a pixel away from their start, and small planes follow the surface that they start on";
const EITHER: &str = "either pixel at a border shows the wall, but at its rim";
const SINGLE: &str = "planes are met wherever the ray's image is a single pixel, but at rims";
const NEAR_SIDE: &str = "what hides a wall's far side is its near one, which is hit";
const ASKED: &str =
    "a ray that passes behind a plane, however near, lies in its occlusion volume, and the next layer is asked";
const FROM_BEHIND: &str =
    "small planes are met at their own place, also from behind, where a ray comes out of their volume";
const OPENED: &str = "a box that holds more than the ray's way is opened, down to the pixels, which hold that alone";
const SKIPPED: &str = "what a ray passes over is skipped by nodes as large as 512 pixels: its budget of steps lasts";

const EXPECTATIONS: Column = &[
    ("edge-on", fails(Rule::HitMiss, EDGE_ON, SAMPLES_SOURCE)),
    ("wires leaves crowded-pixel", fails(Rule::HitMiss, BETWEEN, SAMPLES_SOURCE)),
    ("coarse-frame half-resolution", fails(Rule::Footprint, BETWEEN, SAMPLES_SOURCE)),
    ("close-sheets", fails(Rule::Footprint, NEAR_START, NEAR_START_SOURCE)),
    ("voxel-stack", fails(Rule::Footprint, CROWDED, LAYERS_SOURCE)),
    ("stacked-layers", fails(Rule::Footprint, BEHIND, LAYERS_SOURCE)),
    ("open-mesh needles coplanar-copies equal-triangles long-scene field-of-view", AT_SAMPLES),
    ("huge-triangle", of_huge_triangles(&AT_SAMPLES)),
    ("eye-inside-object", few(Rule::Footprint, BOTH_SIDES)),
    ("eye-on-surface eye-at-vertex before-near", fails(Rule::Footprint, BEFORE_NEAR, NEAR_SOURCE)),
    ("plane-through-eye", fails(Rule::Footprint, ASIDE, ASIDE_SOURCE)),
    ("cube-borders", fails(Rule::HitMiss, LEAVE_VIEW, ASIDE_SOURCE)),
    ("depth-range secondary-depth-ratio", fails(Rule::Footprint, MERGED, MERGED_SOURCE)),
    ("wide-frame", of_plates_along_rows(&few(Rule::Footprint, MERGED))),
    ("flat-tile", few(Rule::Footprint, MERGED)),
    ("surface-starts", few(Rule::HitMiss, FOLLOWED)),
    ("cell-borders", few(Rule::HitMiss, EITHER)),
    ("face-cell-borders", few(Rule::HitMiss, NO_BORDERS)),
    ("through-view-centre away-from-camera", few(Rule::HitMiss, SINGLE)),
    ("thin-walls", few(Rule::HitMiss, NEAR_SIDE)),
    ("behind-foreground", few(Rule::HitMiss, ASKED)),
    ("towards-camera", few(Rule::Footprint, FROM_BEHIND)),
    ("foreground-in-cell", few(Rule::HitMiss, OPENED)),
    ("long-rays", few(Rule::HitMiss, SKIPPED)),
    ("off-origin", few(Rule::Footprint, FROM_EYE)),
];

const CLOSE: &str = "what lies nearer to a start than a tenth of a pixel's height is not looked at, and what is a quarter behind a plane is not told \
                     from it";
const CROWDED_FOUR: &str = "of a crowd of small triangles at all angles four layers are stored, and those seen from their edges cover few pixels, \
                            all of them near a discontinuity: rays pass between their planes";
const BEHIND_FOUR: &str = "four layers: what lies behind the fourth surface is not stored";
const IN_PIXELS_AT_ALL_DEPTHS: &str = "thresholds are in heights of a pixel at every depth: a plane stands for what a ray cannot tell from it, and only \
                                       what ends between pixels' centres is beside it";
const ALONG_ROWS: Expectation = few(Rule::Footprint, IN_PIXELS_AT_ALL_DEPTHS);
const AT_RIMS: &str = "planes are met at their own place; wrong are rays at rims, by a pixel more or less";
const OF_TRIANGLES: &str = "small planes by the triangles' normals lie on the surface that a ray starts on";
const OPENED_BOX: &str = "a box that holds more than the ray's way is opened, down to the pixels";
const LARGE_NODES: &str = "what a ray passes over is skipped by large nodes: its budget of steps lasts";

/// Of the improved form: four layers, thresholds in heights of a pixel at every depth, planes that end at each other, and starts close by.
const IMPROVED_EXPECTATIONS: Column = &[
    ("close-sheets", fails(Rule::Footprint, CLOSE, NEAR_START_SOURCE)),
    ("voxel-stack", fails(Rule::Footprint, CROWDED_FOUR, LAYERS_SOURCE)),
    ("stacked-layers", fails(Rule::Footprint, BEHIND_FOUR, LAYERS_SOURCE)),
    ("eye-inside-object towards-camera", few(Rule::Footprint, AT_RIMS)),
    ("cell-borders face-cell-borders through-view-centre", few(Rule::HitMiss, AT_RIMS)),
    ("depth-range secondary-depth-ratio flat-tile", few(Rule::Footprint, IN_PIXELS_AT_ALL_DEPTHS)),
    ("wide-frame", of_plates_along_rows(&ALONG_ROWS)),
    ("surface-starts", few(Rule::HitMiss, OF_TRIANGLES)),
    ("behind-foreground", few(Rule::HitMiss, "what passes behind a plane asks the next layer")),
    ("foreground-in-cell", few(Rule::HitMiss, OPENED_BOX)),
    ("long-rays", few(Rule::HitMiss, LARGE_NODES)),
];

/// From row to row one thing more: normals of triangles, thresholds in pixels, the flag from smaller steps, planes that end at each other.
const BY_TRIANGLES: Values = &[("normals", "geometry")];
const IN_PIXELS: Values = &[("normals", "geometry"), ("gamma_dist", "0.25"), ("gamma_dist_in", "pixels")];
const FLAGGED: Values =
    &[("normals", "geometry"), ("gamma_dist", "0.25"), ("gamma_dist_in", "pixels"), ("discontinuity", "0.5")];
const JOINED: Values = &[
    ("normals", "geometry"),
    ("gamma_dist", "0.25"),
    ("gamma_dist_in", "pixels"),
    ("discontinuity", "0.5"),
    ("patches", "joined"),
];

/// One switch after the other; then the improved form, and single switches of it taken back or turned.
const ABLATION: Table = switches(
    "quadtree-ablation",
    "the switches between the quad-tree as published and its improved form: builds, traces, bytes, accuracy, counters",
    "stereo,diffuse",
    &[
        published(&[]),
        published(BY_TRIANGLES),
        published(IN_PIXELS),
        published(FLAGGED),
        published(JOINED),
        improved(&[("layers", "1")]),
        improved(&[("layers", "1"), ("inpainted_at", "volume")]),
        improved(&[("layers", "2")]),
        improved(&[("layers", "3")]),
        improved(&[]),
        improved(&[("patches", "squares")]),
        improved(&[("walk_from", "root")]),
        improved(&[("capture", "peeling"), ("minimum_separation", "0.01")]),
        improved(&[("normals", "depth")]),
        improved(&[("gamma_dist_in", "cube"), ("gamma_dist", "1e-5")]),
        improved(&[("gamma_norm", "0"), ("gamma_dist", "0")]),
        improved(&[("discontinuity", "2")]),
        improved(&[("start_bias", "0")]),
        improved(&[("start_bias", "1")]),
        improved(&[("occlusion_bias", "1")]),
        improved(&[("dilated", "none")]),
        improved(&[("next_layer", "always")]),
    ],
);

const REMEDIES: &[Remedy] = &[
    Remedy {
        cause: "outside_of_the_view",
        parameter: "views",
        value: "six",
        source: "WKP15, section 5.4: reflections come from outside of the view; six faces show every direction",
    },
    Remedy {
        cause: "further_layers",
        parameter: "layers",
        value: "4",
        source: "WKP15, section 4.1: what lies in the occlusion volume of the last layer is not known",
    },
    Remedy {
        cause: "merged_by_distance",
        parameter: "gamma_dist",
        value: "0",
        source: "WKP15, section 3.3: a plane stands for others within a distance",
    },
    Remedy {
        cause: "normals_from_depth",
        parameter: "normals",
        value: "geometry",
        source: "WKP15, sections 3.2 and 6: more precise normals close cracks",
    },
    Remedy {
        cause: "planes_over_edges",
        parameter: "patches",
        value: "joined",
        source: "WKP15, section 3.2: each pixel is a small plane, also where an edge crosses it and a surface goes on along another",
    },
    Remedy {
        cause: "left_out_at_the_start",
        parameter: "start_bias",
        value: "0.1",
        source: "WKP15, section 4, says nothing of rays that start on surfaces: a pixel of their way is left out",
    },
    Remedy {
        cause: "close_behind_a_plane",
        parameter: "occlusion_bias",
        value: "0.25",
        source: "WKP15, section 4.1, does not say how far behind a plane hidden space begins: a ray that is nearer passes or hits",
    },
];
