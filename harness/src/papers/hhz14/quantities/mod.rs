//! What decides HHZ14's claims.

pub(super) mod octree;
mod scenes;
mod search;
mod voxels;

use crate::papers::Quantity;

/// All of them.
pub(super) const QUANTITIES: &[&[Quantity]] =
    &[octree::QUANTITIES, search::QUANTITIES, voxels::QUANTITIES, scenes::QUANTITIES];

/// What its tracer counts of voxels that a ray goes through.
const VOXELS: &str = "voxels_stepped";
/// What its tracer counts of points whose depth a search compares with those of a texel's layers.
const COMPARISONS: &str = "depth_comparisons";
