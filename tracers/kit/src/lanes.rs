//! How a search is launched: rays that a lane answers one after the other (shaders/shared/lanes.wgsl).

use tracebench_api::wgpu::{BindGroup, CommandEncoder, ComputePipeline};
use tracebench_api::{Parameter, ParameterScope};

use crate::dispatch_linear_groups;

/// Lanes of a workgroup: `WORKGROUP_SIZE` of shaders/shared/lanes.wgsl.
pub const LANES_OF_WORKGROUP: u32 = 64;

/// The parameter `rays_per_lane`, the same for every tracer that searches on the device.
pub fn rays_per_lane_parameter() -> Parameter<u32> {
    let effect = "rays that a lane answers one after the other (persistent lanes), so that lanes with short searches need not \
                  wait for others: many suit incoherent rays and few cores, few suit coherent rays and many cores";
    Parameter::integer(ParameterScope::Trace, 1..=256, 1, effect).unit("rays").sweep([1, 2, 4, 8, 16, 32, 64])
}

/// Records a dispatch that answers so many rays.
pub fn dispatch_rays(
    encoder: &mut CommandEncoder,
    pipeline: &ComputePipeline,
    bindings: &[&BindGroup],
    ray_count: u32,
    rays_per_lane: u32,
) {
    dispatch_linear_groups(encoder, pipeline, bindings, ray_count.div_ceil(rays_per_lane), LANES_OF_WORKGROUP);
}
