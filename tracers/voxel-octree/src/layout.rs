//! How fine a tree is, and what shaders are told.

use bytemuck::{Pod, Zeroable};
use tracebench_api::{Geometry, Query, SharedLayout, TraceJob, Viewpoint};
use tracebench_kit::{Fit, UnitSpace};

use crate::counts::Counts;
use crate::description::{HitPlace, OctreeParameters};

/// The most levels: keys of 30 bits have three for each.
pub(crate) const MOST_LEVELS: u32 = 10;

/// Voxels of an edge by texels of a face, at least, where no number of levels is said: 1024 at 512.
const VOXELS_OF_TEXEL: u32 = 2;

/// What takes less room of everything that a build makes.
pub(crate) const TURN_DOWN: &str = "voxel-octree.levels (or --face, where that is 0)";

/// `OctreeBuild` of shaders/voxel-octree/settings.wgsl.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct OctreeBuild {
    /// The cube.
    pub space: UnitSpace,
    /// Triangles.
    pub triangle_count: u32,
    /// Of the tree.
    pub levels: u32,
    /// Rows that there is room for.
    pub row_capacity: u32,
    /// Fragments that there is room for.
    pub fragment_capacity: u32,
    /// Leaves that there is room for.
    pub leaf_capacity: u32,
    /// Nothing.
    pub padding_a: u32,
    /// Nothing.
    pub padding_b: u32,
    /// Nothing.
    pub padding_c: u32,
}

/// `OctreeLevel` of shaders/voxel-octree/levels.wgsl.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct OctreeLevel {
    /// Of the level: the root's is 0.
    pub depth: u32,
    /// Children that there is room for.
    pub child_capacity: u32,
    /// Nodes of the level that there is room for.
    pub node_capacity: u32,
    /// Where the children begin among all nodes; leaves among all leaves.
    pub first_child: u32,
    /// Where the level's nodes begin.
    pub first_node: u32,
    /// Nothing.
    pub padding_a: u32,
    /// Nothing.
    pub padding_b: u32,
    /// Nothing.
    pub padding_c: u32,
}

/// `OctreeSearch` of shaders/voxel-octree/trace.wgsl.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct OctreeSearch {
    /// The cube.
    pub space: UnitSpace,
    /// Rays.
    pub ray_count: u32,
    /// Rays that a lane answers.
    pub rays_per_lane: u32,
    /// Of the tree.
    pub levels: u32,
    /// 0: a ray hits a voxel where it enters it, 1: where it is nearest to its centre.
    pub at_centre: u32,
    /// Words of bits before the numbers of every ray.
    pub touched_words: u32,
    /// The bit of the first leaf.
    pub first_leaf_bit: u32,
    /// Nothing.
    pub padding_a: u32,
    /// Nothing.
    pub padding_b: u32,
}

/// Layouts of all that shaders share with this crate.
pub(crate) fn layouts() -> Vec<SharedLayout> {
    tracebench_api::layouts! {
        OctreeBuild {
            space, triangle_count, levels, row_capacity, fragment_capacity, leaf_capacity, padding_a, padding_b, padding_c,
        }
        OctreeLevel {
            depth, child_capacity, node_capacity, first_child, first_node, padding_a, padding_b, padding_c,
        }
        OctreeSearch {
            space, ray_count, rays_per_lane, levels, at_centre, touched_words, first_leaf_bit, padding_a, padding_b,
        }
    }
}

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
        .map_or(MOST_LEVELS, u32::ilog2)
        .min(MOST_LEVELS)
}

impl Layout {
    pub(crate) fn new(geometry: &Geometry, viewpoint: &Viewpoint, parameters: &OctreeParameters) -> Self {
        let levels = if parameters.levels == 0 { auto_levels(viewpoint.face) } else { parameters.levels };
        let edge = 1 << levels;
        Self { space: UnitSpace::of(geometry, Fit::Cube, edge, edge), levels }
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
