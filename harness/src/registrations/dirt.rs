//! The registration of `dirt`: analytic hits on every triangle that touches a tile of six views, found bucket by bucket; improved, by a
//! tree in every tile.

use super::expectation::{fails, few};
use super::table::{Values, improved, published, switches};
use super::{Column, Expectation, Family, Improved, Matters, Registration, Remedy, Rule, Shrink, Table, Touch};

pub(crate) const REGISTRATION: Registration = Registration {
    expectations: &[EXPECTATIONS],
    improved: Some(Improved { otherwise: Some(Expectation::Exact), expectations: &[IMPROVED_EXPECTATIONS] }),
    ablation: Some(&ABLATION),
    remedies: REMEDIES,
    sweep: &["tile_size", "face_tiles", "buckets", "slices", "resolution", "coverage", "clip"],
    excluded_from_fronts: &["near", "direct_visibility", "shadow_map", "shadow_bias", "fetch"],
    shrinks: &[
        Shrink { axis: "resolution", steps: &["1/2", "1/4", "1/8", "1/16"] },
        Shrink { axis: "buckets", steps: &["16", "12", "8", "4", "2", "1"] },
        Shrink { axis: "tile_size", steps: &["1", "2", "4", "8"] },
        Shrink { axis: "face_tiles", steps: &["64", "32", "16", "8", "4", "2", "1"] },
        Shrink { axis: "slices", steps: &["64", "32", "16", "8", "4", "2", "1"] },
    ],
    matters: MATTERS,
    touches: &[Touch {
        counter: "references_touched",
        stored: "references",
        parts: &["nodes (texture)", "id buffer: nodes", "references (texture)", "references"],
    }],
    ..Registration::analytic(tracebench_dirt::description, Family::Image, |gpu| {
        Ok(Box::new(tracebench_dirt::Dirt::new(gpu?)?))
    })
};

const LISTS_IN_TILES: &[&str] = &["packed", "sliced", "trees"];

const MATTERS: &[Matters] = &[
    Matters {
        what: &[
            "resolution",
            "tile_size",
            "buckets",
            "views",
            "centre",
            "coverage",
            "clip",
            "accept",
            "searched",
            "build",
        ],
        by: "lists",
        values: &["linked"],
    },
    Matters { what: &["face_tiles", "slices", "spacing"], by: "lists", values: LISTS_IN_TILES },
    Matters { what: &["order"], by: "lists", values: &["trees"] },
];

const EARLY_STOP: &str = "the search of a tile ends at the first bucket with a hit, though a triangle that reaches into \
                          several buckets may have been hit behind another one that a later bucket holds";

/// Of rays that pass long lists a driver may cut some off.
const CUT_OFF: Expectation = few(
    Rule::HitMiss,
    "thousands of triangles in every list that a ray passes: Mesa's software driver ends the loops of eight lanes together after \
             65,535 rounds in all, and rays that it cuts off are given up with status step_cap",
);

const EXPECTATIONS: Column = &[
    ("leaves huge-triangle", few(Rule::Tight, EARLY_STOP)),
    ("voxel-stack", fails(Rule::Tight, EARLY_STOP, "DIRT, section 4.2.1, Algorithm 1, line 18")),
    (
        "face-cell-borders",
        fails(
            Rule::HitMiss,
            "a hit counts only where its own tile is the one that is searched: on a border rounding may place it in the \
                     neighbour when either is searched, and it is lost (pin-holes)",
            "DIRT, section 4.2.1, Algorithm 1, line 14",
        ),
    ),
    // Lists of so many copies are longer than what WebGPU's limits let one binding hold.
    ("coplanar-copies", Expectation::Refusable { from: 256.0, otherwise: &Expectation::Exact }),
    ("equal-triangles", Expectation::Refusable { from: 1024.0, otherwise: &CUT_OFF }),
];

/// Exact, but where a device holds no lists of so many copies.
const IMPROVED_EXPECTATIONS: Column = &[
    ("coplanar-copies", Expectation::Refusable { from: 256.0, otherwise: &Expectation::Exact }),
    ("equal-triangles", Expectation::Refusable { from: 1024.0, otherwise: &Expectation::Exact }),
];

/// From row to row one thing more: hits by their distance, no near plane, rays split near the eye, drawn in compute.
const BY_DISTANCE: Values = &[("accept", "distance"), ("searched", "all")];
const NO_NEAR: Values = &[("accept", "distance"), ("searched", "all"), ("centre", "eye"), ("near", "none")];
const SPLIT: Values =
    &[("accept", "distance"), ("searched", "all"), ("centre", "eye"), ("near", "none"), ("centre_rays", "split")];

const IN_COMPUTE: Values = &[
    ("accept", "distance"),
    ("searched", "all"),
    ("centre", "eye"),
    ("near", "none"),
    ("centre_rays", "split"),
    ("build", "compute"),
];

/// One switch after the other; then the improved form, and single switches of it taken back or turned.
const ABLATION: Table = switches(
    "dirt-ablation",
    "the switches between DIRT as published and its improved form: builds, traces, bytes, accuracy, counters",
    "primary,specular,diffuse",
    &[
        published(&[]),
        published(BY_DISTANCE),
        published(NO_NEAR),
        published(SPLIT),
        published(IN_COMPUTE),
        improved(&[("lists", "packed"), ("slices", "1")]),
        improved(&[("lists", "packed")]),
        improved(&[("lists", "sliced")]),
        improved(&[("order", "stored")]),
        improved(&[]),
        improved(&[("face_tiles", "16")]),
        improved(&[("face_tiles", "64")]),
        improved(&[("face_tiles", "128")]),
        improved(&[("slices", "1")]),
        improved(&[("spacing", "near_far")]),
        improved(&[("march", "tiles")]),
        improved(&[("centre_rays", "whole")]),
    ],
);

const REMEDIES: &[Remedy] = &[
    Remedy {
        cause: "outside_of_the_views",
        parameter: "views",
        value: "six",
        source: "DIRT, section 5.2, Figure 9: one view skips what lies outside of it",
    },
    Remedy {
        cause: "coverage_by_sample",
        parameter: "coverage",
        value: "conservative",
        source: "DIRT, sections 4.1 and 4.2.4: without conservative coverage what lies between samples is not stored",
    },
    Remedy {
        cause: "early_bucket_stop",
        parameter: "searched",
        value: "all",
        source: "DIRT, section 4.2.1, Algorithm 1, line 18: the search of a tile ends at the first bucket with a hit",
    },
    Remedy {
        cause: "pixel_acceptance",
        parameter: "accept",
        value: "distance",
        source: "DIRT, section 4.2.1, Algorithm 1, line 14: a hit counts only where its tile is the one searched",
    },
    Remedy {
        cause: "projection_noise_at_centre",
        parameter: "centre_rays",
        value: "split",
        source: "f32: near a view's centre the image of a ray is noise",
    },
    Remedy {
        cause: "near_plane",
        parameter: "near",
        value: "none",
        source: "DIRT, section 4.1: views are perspective, so nothing before their near planes is stored",
    },
];
