//! What searches are told.

use bytemuck::{Pod, Zeroable};
use tracebench_api::{Query, TraceJob};

use crate::description::{Crossing, InTexel, Inside, VoxelParameters};
use crate::layout::{Layout, UnitSpace};

/// `VoxelSearch` of shaders/voxel-abuffer/settings.wgsl.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct VoxelSearch {
    /// The cube.
    pub space: UnitSpace,
    /// Rays.
    pub ray_count: u32,
    /// Rays that a lane answers.
    pub rays_per_lane: u32,
    /// 0: a voxel's A-buffer is searched in every texel that the ray crosses, else at so many points.
    pub points: u32,
    /// Halvings between the last two points.
    pub binary_steps: u32,
    /// 0: inside is told by the parity of layers, 1: by their facings.
    pub nesting: u32,
    /// 0: a ray ends where its side is not that of its start, 1: not that at the entry.
    pub by_change: u32,
    /// Texels.
    pub start_bias: f32,
    /// Words from the heads of an axis to those of the next.
    pub head_stride: u32,
    /// Words of bits a node.
    pub touched_words: u32,
    /// Nodes that have their data in their axis' first half.
    pub half_nodes: u32,
    /// 0: of a texel the layers are asked that the ray passes there, 1: the side on which it leaves.
    pub at_exits: u32,
    /// 1: any hit will do, which traces through planes make use of.
    pub any_hit: u32,
    /// Of each axis: its first node.
    pub first_nodes: [u32; 4],
    /// That node's bit among those that are counted.
    pub first_bits: [u32; 4],
    /// Its first data.
    pub first_data: [u32; 4],
    /// The first of its second half.
    pub first_further_data: [u32; 4],
}

impl VoxelSearch {
    /// That of a job; where nodes lie is left open.
    pub(crate) fn of(layout: &Layout, job: &TraceJob<'_>, parameters: &VoxelParameters) -> Self {
        Self {
            space: layout.space,
            ray_count: job.rays.host.len() as u32,
            rays_per_lane: parameters.rays_per_lane,
            points: parameters.search.points(),
            // Where a surface is does not matter to rays that ask whether there is any (section 3.2).
            binary_steps: if job.rays.query == Query::Any { 0 } else { parameters.binary_steps },
            nesting: u32::from(parameters.inside == Inside::Nesting),
            by_change: u32::from(parameters.crossing == Crossing::Change),
            at_exits: u32::from(parameters.in_texel == InTexel::Exit),
            any_hit: u32::from(job.rays.query == Query::Any),
            start_bias: parameters.start_bias as f32,
            head_stride: layout.head_stride(),
            ..Self::zeroed()
        }
    }
}
