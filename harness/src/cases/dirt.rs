//! What is expected of `dirt`: analytic hits on every triangle that touches a tile of six views, found bucket by bucket.

use super::expectation::{Column, Expectation, Rule};

/// Some rays stop at a hit that lies behind another one.
const fn stops_early(most_wrong: f64) -> Expectation {
    Expectation::Bounded { rule: Rule::Tight, most_wrong, reason: EARLY_STOP }
}

const EARLY_STOP: &str = "the search of a tile ends at the first bucket with a hit, though a triangle that reaches into \
                          several buckets may have been hit behind another one that a later bucket holds";

pub(super) const EXPECTATIONS: Column = &[
    ("edge-on", Expectation::Exact),
    ("wires", Expectation::Exact),
    ("leaves", stops_early(0.03)),
    ("close-sheets", Expectation::Exact),
    (
        "voxel-stack",
        Expectation::KnownFailure {
            rule: Rule::Tight,
            from: 4.0,
            below: 0.005,
            least_wrong: 0.04,
            reason: EARLY_STOP,
            source: "DIRT, section 4.2.1, Algorithm 1, line 18",
        },
    ),
    ("open-mesh", Expectation::Exact),
    ("huge-triangle", stops_early(0.02)),
    ("needles", Expectation::Exact),
    ("coplanar-copies", Expectation::Exact),
    ("eye-inside-object", Expectation::Exact),
    ("eye-on-surface", Expectation::Exact),
    ("plane-through-eye", Expectation::Exact),
    ("eye-at-vertex", Expectation::Exact),
    ("before-near", Expectation::Exact),
    ("cube-borders", Expectation::Exact),
    ("depth-range", Expectation::Exact),
    ("coarse-frame", Expectation::Exact),
    ("wide-frame", Expectation::Exact),
    ("surface-starts", Expectation::Exact),
    ("cell-borders", Expectation::Exact),
    (
        "face-cell-borders",
        Expectation::KnownFailure {
            rule: Rule::HitMiss,
            from: 0.0,
            below: 0.0,
            least_wrong: 0.02,
            reason: "a hit counts only where its own tile is the one that is searched: on a border rounding may place it in the \
                     neighbour when either is searched, and it is lost (pin-holes)",
            source: "DIRT, section 4.2.1, Algorithm 1, line 14",
        },
    ),
    ("through-view-centre", Expectation::Exact),
    ("flat-tile", Expectation::Exact),
    (
        "equal-triangles",
        Expectation::Bounded {
            rule: Rule::HitMiss,
            most_wrong: 0.02,
            reason: "thousands of triangles in every list that a ray passes: Mesa's software driver ends the loops of eight \
                     lanes together after 65,535 rounds in all, and rays that it cuts off are given up with status step_cap",
        },
    ),
    ("stacked-layers", Expectation::Exact),
    ("crowded-pixel", Expectation::Exact),
];
