//! What searches are told.

use bytemuck::Zeroable;
use tracebench_api::{Query, TraceJob};

use crate::description::{Crossing, InTexel, VoxelParameters};
use crate::layout::Layout;
pub(crate) use tracebench_shaders::voxel_abuffer::VoxelSearch;

/// That of a job; where nodes lie is left open.
pub(crate) fn voxel_search(layout: &Layout, job: &TraceJob<'_>, parameters: &VoxelParameters) -> VoxelSearch {
    VoxelSearch {
        space: layout.space,
        ray_count: job.rays.host.len() as u32,
        rays_per_lane: parameters.rays_per_lane,
        points: parameters.search.points(),
        // Where a surface is does not matter to rays that ask whether there is any (section 3.2).
        binary_steps: if job.rays.query == Query::Any { 0 } else { parameters.binary_steps },
        nesting: u32::from(layout.nesting),
        by_change: u32::from(parameters.crossing == Crossing::Change),
        at_exits: u32::from(parameters.in_texel == InTexel::Exit),
        any_hit: u32::from(job.rays.query == Query::Any),
        start_bias: parameters.start_bias as f32,
        head_stride: layout.head_stride(),
        ..Zeroable::zeroed()
    }
}
