//! How a search is launched: rays that a lane answers one after the other (shaders/shared/lanes.wgsl).

use tracebench_api::wgpu::{BindGroup, Buffer, CommandEncoder, ComputePipeline};
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

/// Rounds after which Mesa's software driver ends the loops of eight lanes together, in all.
const MOST_ROUNDS: u64 = 65_535;

/// Rays that a lane answers of those asked for, where a ray takes no more than so many rounds of loops: no more than every driver gets
/// through, and one at least.
pub fn rays_within_rounds(asked: u32, most_rounds_of_ray: u64) -> u32 {
    u64::from(asked).min(MOST_ROUNDS / most_rounds_of_ray.max(1)).max(1) as u32
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

/// Records a dispatch of as many workgroups as a buffer says when it runs: three words.
pub fn dispatch_indirect(
    encoder: &mut CommandEncoder,
    pipeline: &ComputePipeline,
    bindings: &[&BindGroup],
    workgroups: &Buffer,
) {
    let mut pass = encoder.begin_compute_pass(&Default::default());
    pass.set_pipeline(pipeline);
    for (group, bindings) in (0..).zip(bindings) {
        pass.set_bind_group(group, *bindings, &[]);
    }
    pass.dispatch_workgroups_indirect(workgroups, 0);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Lanes take what is asked while all of their rays' rounds fit, then fewer, and one where not even one ray's do.
    #[test]
    fn lanes_take_what_drivers_get_through() {
        let rays = [0, 100, 2047, 2048, 4096, 65_535, 65_536, u64::MAX].map(|rounds| rays_within_rounds(32, rounds));
        assert_eq!(rays, [32, 32, 32, 31, 15, 1, 1, 1]);
        assert_eq!(rays_within_rounds(1, 10), 1);
    }
}
