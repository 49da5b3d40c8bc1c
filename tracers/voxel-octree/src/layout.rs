//! How fine a tree is, and what shaders are told.

use bytemuck::Zeroable;
use tracebench_api::{Geometry, Query, TraceJob, Viewpoint};
use tracebench_kit::{Fit, UnitSpace, unit_space};

use crate::counts::Counts;
use crate::description::{HitPlace, OctreeParameters};
pub(crate) use tracebench_shaders::voxel_octree::{OctreeBuild, OctreeLevel, OctreeSearch};

/// The most levels: keys of 30 bits have three for each.
pub(crate) const MAX_LEVELS: u32 = 10;

/// Voxels of an edge by texels of a face, at least, where no number of levels is said: 1024 at 512.
const VOXELS_OF_TEXEL: u32 = 2;

/// What takes less room of everything that a build makes.
pub(crate) const HINT: &str = "voxel-octree.levels (or --face-size, where that is 0)";

/// The grid whose voxels are leaves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Layout {
    /// The cube, in which the grid is.
    pub space: UnitSpace,
    /// Of the tree.
    pub levels: u32,
}

/// Levels where none are said: 10 at faces of 512.
fn auto_levels(face: u32) -> u32 {
    face.max(1)
        .saturating_mul(VOXELS_OF_TEXEL)
        .checked_next_power_of_two()
        .map_or(MAX_LEVELS, u32::ilog2)
        .min(MAX_LEVELS)
}

impl Layout {
    pub(crate) fn new(geometry: &Geometry, viewpoint: &Viewpoint, parameters: &OctreeParameters) -> Self {
        let levels = if parameters.levels == 0 { auto_levels(viewpoint.face) } else { parameters.levels };
        let edge = 1 << levels;
        Self { space: unit_space(geometry, Fit::Cube, edge, edge), levels }
    }

    /// Voxels of an edge.
    pub(crate) fn edge(&self) -> u32 {
        self.space.grid
    }

    /// What a build is told.
    pub(crate) fn build(&self, triangle_count: u32, capacities: &Counts) -> OctreeBuild {
        OctreeBuild {
            space: self.space,
            triangle_count,
            levels: self.levels,
            row_capacity: capacities.rows,
            fragment_capacity: capacities.fragments,
            leaf_capacity: capacities.leaves(self.levels),
            ..Zeroable::zeroed()
        }
    }

    /// What the stage is told that makes the nodes of a level.
    pub(crate) fn level(&self, depth: u32, capacities: &Counts) -> OctreeLevel {
        let of_leaves = depth + 1 == self.levels;
        OctreeLevel {
            depth,
            child_capacity: capacities.levels[depth as usize + 1],
            node_capacity: capacities.levels[depth as usize],
            first_child: if of_leaves { 0 } else { capacities.nodes_before(depth + 1) },
            first_node: capacities.nodes_before(depth),
            ..Zeroable::zeroed()
        }
    }

    /// What a trace is told.
    pub(crate) fn search(&self, job: &TraceJob<'_>, parameters: &OctreeParameters, rays_per_lane: u32) -> OctreeSearch {
        // Any hit is as good as the first, which the walk comes upon anyway.
        let closest = job.rays.query == Query::Closest;
        OctreeSearch {
            space: self.space,
            ray_count: job.rays.host.len() as u32,
            rays_per_lane,
            levels: self.levels,
            at_centre: u32::from(closest && parameters.hit == HitPlace::Centre),
            ..Zeroable::zeroed()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ten levels at faces of 512, one less at half of that, and never more than keys have bits for.
    #[test]
    fn levels_are_those_of_table_1() {
        assert_eq!([0, 1, 2, 16, 17, 256, 512, 4096, u32::MAX].map(auto_levels), [1, 1, 2, 5, 6, 9, 10, 10, 10]);
    }
}
