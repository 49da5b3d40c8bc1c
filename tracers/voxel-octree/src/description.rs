//! The parameters of `voxel-octree`.

use tracebench_api::ParameterScope::{Build, Trace};
use tracebench_api::{Invalidation, Parameter, TracerDescription, choice, parameters};
use tracebench_kit::{MemoryAccess, memory_access_parameter, rays_per_lane_parameter};

use crate::layout::MAX_LEVELS;

choice! {
    /// How the node that holds the next voxel is found.
    pub(crate) enum Traversal { Restart = "restart", Stack = "stack" }
    /// Where a ray hits a voxel; in the order of the shader's codes.
    pub(crate) enum HitPlace { Entry = "entry", Centre = "centre" }
}

parameters! {
    /// What `voxel-octree` is told.
    pub(crate) struct OctreeParameters {
        /// levels of the tree, by which the grid has two to the power of it voxels an edge: each halves the error, and takes four times the
        /// memory; 0: two voxels a texel of a face at least, which is 10 (1024 an edge, as the peer of HHZ14's Table 1 has) at faces of 512
        levels: u32 = Parameter::integer(Build, 0..=MAX_LEVELS, 0).unit("levels").sweep([6, 7, 8, 9]),
        /// how the node that holds the next voxel is found: from the root every time, or from the deepest node that holds both, off a
        /// stack; the hits are the same
        traversal: Traversal = Parameter::choice(Trace, Traversal::Restart),
        /// where a ray hits a voxel: where it enters it, always too early, or where it is nearest to its centre, too early as often as too
        /// late
        hit: HitPlace = Parameter::choice(Trace, HitPlace::Entry),
        memory_access: MemoryAccess = memory_access_parameter(),
        rays_per_lane: u32 = rays_per_lane_parameter(),
    }
}

/// Why there is no refit.
pub(crate) const NO_REFIT: &str = "voxel-octree has no shape to keep: its voxels are made again or reused";

/// What `voxel-octree` is and takes.
pub fn description() -> TracerDescription {
    TracerDescription {
        name: "voxel-octree",
        citation: "Crassin, Neyret, Sainz, Green, Eisemann: Interactive indirect illumination using voxel cone tracing, Computer Graphics \
                   Forum 2011",
        summary: "a sparse voxel octree over every voxel that a triangle touches, walked exactly to its leaves",
        invalidated_by: &[Invalidation::Geometry, Invalidation::Resolution],
        ..TracerDescription::of_views(NO_REFIT, OctreeParameters::describe())
    }
}
