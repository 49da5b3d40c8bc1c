//! What decides HHZ14's claims.
//!
//! The paper does not say where a ray that starts on a surface begins to look. So accuracies have a second reading, in which no ray is
//! wrong for its start ([`by_start`]).

pub(super) mod octree;
mod scenes;
mod search;
mod tables;
mod voxels;

use crate::papers::Quantity;
use crate::papers::rows::{counted, footprint};
use crate::results::{Judgement, TraceRecord};

/// All of them.
pub(super) const QUANTITIES: &[&[Quantity]] =
    &[octree::QUANTITIES, search::QUANTITIES, tables::QUANTITIES, voxels::QUANTITIES, scenes::QUANTITIES];

/// What its tracer counts of voxels that a ray goes through.
const VOXELS: &str = "voxels_stepped";
/// What its tracer counts of points whose depth a search compares with those of a texel's layers.
const COMPARISONS: &str = "depth_comparisons";

/// Rays that are wrong for their start: they leave out what is near it, or take the wrong side of the surface that they start on.
fn by_start(trace: &TraceRecord) -> u64 {
    let causes = match &trace.judgement {
        Judgement::Closest(closest) => closest.causes.get("footprint"),
        Judgement::Any(any) => any.causes.get("occlusion"),
    };
    ["near_start", "wrong_side_at_start"].iter().filter_map(|cause| causes?.get(*cause)).sum()
}

/// Footprint agreement, were no ray wrong for its start.
fn footprint_but_starts(trace: &TraceRecord) -> Option<f64> {
    let [rays, wrong] = counted(trace, |_| Some(by_start(trace)))?;
    Some(footprint(trace)? + wrong as f64 / rays as f64)
}
