//! How a search is launched: rays that a lane answers one after the other (shaders/shared/lanes.wgsl).

use tracebench_api::wgpu::{BindGroup, Buffer, CommandEncoder, ComputePipeline};
use tracebench_api::{Gpu, Parameter, ParameterScope, PhaseClock, RayBuffer, TracerError};
use tracebench_shaders::Shader;

use crate::{PipelinesOnDemand, dispatch_linear_groups};

/// Lanes of a workgroup: `WORKGROUP_SIZE` of shaders/shared/lanes.wgsl.
pub const LANES_OF_WORKGROUP: u32 = 64;

/// Most rays that a lane answers one after the other.
pub const MAX_RAYS_PER_LANE: u32 = 256;

/// The parameter `rays_per_lane`, the same for every tracer that searches on the device.
pub fn rays_per_lane_parameter() -> Parameter<u32> {
    let effect = "rays that a lane answers one after the other, at the mean (persistent lanes), so that lanes with short searches need \
                  not wait for others: many suit incoherent rays and few cores, few suit coherent rays and many cores";
    Parameter::integer(ParameterScope::Trace, 1..=MAX_RAYS_PER_LANE, 1)
        .effect(effect)
        .unit("rays")
        .sweep([1, 2, 4, 8, 16, 32, 64])
}

/// Rounds after which Mesa's software driver ends the loops of eight lanes together, in all.
const MAX_ROUNDS: u64 = 65_535;

/// Rays that a lane answers of those asked for, where a ray takes no more than so many rounds of loops: no more than every driver gets
/// through, and one at least.
pub fn rays_within_rounds(asked: u32, max_rounds_of_ray: u64) -> u32 {
    u64::from(asked).min(MAX_ROUNDS / max_rounds_of_ray.max(1)).max(1) as u32
}

/// Records a dispatch that answers rays: all of them or, where only the device knows how many are asked, by the three words that its buffer
/// has for so many rays a lane (from 1 to [`MAX_RAYS_PER_LANE`]): workgroups of [`LANES_OF_WORKGROUP`] lanes, folded as all dispatches are.
pub fn dispatch_rays(
    encoder: &mut CommandEncoder,
    pipeline: &ComputePipeline,
    bindings: &[&BindGroup],
    rays: &RayBuffer,
    rays_per_lane: u32,
) {
    match rays.workgroups() {
        None => {
            let lanes = (rays.host.len() as u32).div_ceil(rays_per_lane);
            dispatch_linear_groups(encoder, pipeline, bindings, lanes, LANES_OF_WORKGROUP);
        }
        Some(workgroups) => {
            dispatch_indirect(encoder, pipeline, bindings, workgroups, 12 * u64::from(rays_per_lane - 1));
        }
    }
}

/// Records a dispatch of as many workgroups as three words at a byte of a buffer say when it runs.
pub fn dispatch_indirect(
    encoder: &mut CommandEncoder,
    pipeline: &ComputePipeline,
    bindings: &[&BindGroup],
    workgroups: &Buffer,
    offset: u64,
) {
    let mut pass = encoder.begin_compute_pass(&Default::default());
    pass.set_pipeline(pipeline);
    for (group, bindings) in (0..).zip(bindings) {
        pass.set_bind_group(group, *bindings, &[]);
    }
    pass.dispatch_workgroups_indirect(workgroups, offset);
}

/// Pipelines of a search that drivers may cut off (shaders/shared/lanes.wgsl): its entry points `trace`, whose lanes leave rays without an
/// answer, and `trace_unanswered`. Each is made when it is first asked for.
#[derive(Debug)]
pub struct SearchPipelines {
    first: PipelinesOnDemand,
    unanswered: PipelinesOnDemand,
}

/// Which rays the first dispatch of a search leaves.
#[derive(Clone, Copy, Debug)]
pub enum Left<'a> {
    /// Those that a driver cut off, where lanes answer several.
    CutOff,
    /// Others, too.
    Any,
    /// Others, too; it tells in three words how many workgroups are to answer them.
    Told(&'a Buffer),
}

/// What a search is to answer.
#[derive(Clone, Copy, Debug)]
pub struct SearchedRays<'a> {
    /// The rays.
    pub rays: &'a RayBuffer,
    /// Rays that a lane answers.
    pub per_lane: u32,
    /// Where their hits go.
    pub hits: &'a Buffer,
    /// Which the first dispatch leaves.
    pub left: Left<'a>,
}

impl Default for SearchPipelines {
    fn default() -> Self {
        Self { first: PipelinesOnDemand::new("trace"), unanswered: PipelinesOnDemand::new("trace_unanswered") }
    }
}

impl SearchPipelines {
    /// Records the phase "trace", which answers every ray; `bind` gives what a pipeline binds, and is told whether it is the first.
    ///
    /// # Errors
    /// [`TracerError::Unavailable`] if the device's limits forbid a pipeline, [`TracerError::Failed`] if it refuses one.
    pub fn record(
        &self,
        gpu: &Gpu,
        variant: impl Into<Shader>,
        rays: SearchedRays<'_>,
        bind: impl Fn(&ComputePipeline, bool) -> Vec<BindGroup>,
        clock: &mut PhaseClock<'_>,
    ) -> Result<(), TracerError> {
        let SearchedRays { rays, per_lane, hits, left } = rays;
        let shader = variant.into();
        let bound = |pipelines: &PipelinesOnDemand, is_first: bool| -> Result<_, TracerError> {
            let pipeline = pipelines.of(gpu, shader)?;
            let groups = bind(&pipeline, is_first);
            Ok((pipeline, groups))
        };
        let (first, first_groups) = bound(&self.first, true)?;
        let leaves = per_lane > 1 || !matches!(left, Left::CutOff);
        let second = leaves.then(|| bound(&self.unanswered, false)).transpose()?;
        clock.device_phase("trace", |encoder| {
            if second.is_some() {
                // No status is 0.
                encoder.clear_buffer(hits, 0, None);
            }
            dispatch_rays(encoder, &first, &first_groups.iter().collect::<Vec<_>>(), rays, per_lane);
            if let Some((second, groups)) = &second {
                let groups: Vec<_> = groups.iter().collect();
                match left {
                    Left::Told(workgroups) => dispatch_indirect(encoder, second, &groups, workgroups, 0),
                    Left::CutOff | Left::Any => dispatch_rays(encoder, second, &groups, rays, 1),
                }
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use tracebench_api::wgpu::BufferUsages;
    use tracebench_api::{AdapterChoice, Gpu};
    use tracebench_shaders::test::LANES_FUNCTIONS;

    use super::*;
    use crate::{bind_group, compute_pipeline};

    /// How often lanes take each ray up to a few behind the last, where they are launched as for so many rays a lane.
    fn times_taken(gpu: &Gpu, entry: &str, [first, count, rays_per_lane]: [u32; 3], launched: u32) -> Vec<u32> {
        let pipeline = compute_pipeline(gpu, LANES_FUNCTIONS, entry).unwrap();
        let asked = bytemuck::cast_slice(&[first, count, rays_per_lane]).to_vec();
        let asked = gpu.buffer_with("asked", &asked, BufferUsages::STORAGE, "nothing").unwrap();
        let bytes = u64::from(first + count + 600) * 4;
        let usages = BufferUsages::STORAGE | BufferUsages::COPY_SRC;
        let times = gpu.buffer("times", bytes, usages, "nothing").unwrap();
        let bindings = [asked.as_entire_binding(), times.as_entire_binding()];
        let bindings = bind_group(gpu, &pipeline.get_bind_group_layout(0), &bindings);
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        dispatch_linear_groups(&mut encoder, &pipeline, &[&bindings], count.div_ceil(launched), LANES_OF_WORKGROUP);
        gpu.queue.submit([encoder.finish()]);
        bytemuck::pod_collect_to_vec(&gpu.read(&times, bytes).unwrap())
    }

    /// Rays that are not taken once, and others that are taken.
    fn wrongly_taken(times: &[u32], [first, count, _]: [u32; 3]) -> usize {
        let is_asked = |ray: usize| (first..first + count).contains(&(ray as u32));
        times.iter().enumerate().filter(|(ray, times)| **times != u32::from(is_asked(*ray))).count()
    }

    /// Lanes take every ray once and no other, in turns and from blocks, whatever their number and where the first one is, also where
    /// workgroups fill more than one row.
    #[test]
    fn every_ray_is_taken_once() {
        let gpu = Gpu::open(&AdapterChoice::default()).unwrap();
        let counts = [1, 7, 8, 9, 63, 64, 65, 511, 512, 513, 2047, 2048, 2049, 20_000];
        let few = counts.iter().flat_map(|count| [1, 3, 32, 256].map(|lane| [count % 3 * 77, *count, lane]));
        for asked in few.chain([[5, 65_535 * 64 + 130, 1], [0, 65_536 * 64 + 1, 32]]) {
            for entry in ["take_turns", "take_from_blocks"] {
                let times = times_taken(&gpu, entry, asked, asked[2]);
                assert_eq!(wrongly_taken(&times, asked), 0, "{entry} {asked:?}");
            }
        }
        // Negative controls: lanes that are too few, and rays of which one was taken twice.
        let asked = [0, 4096, 3];
        assert!(wrongly_taken(&times_taken(&gpu, "take_from_blocks", asked, 6), asked) > 0);
        let mut times = times_taken(&gpu, "take_from_blocks", asked, 3);
        times[100] += 1;
        assert_eq!(wrongly_taken(&times, asked), 1);
    }

    /// Lanes take what is asked while all of their rays' rounds fit, then fewer, and one where not even one ray's do.
    #[test]
    fn lanes_take_what_drivers_get_through() {
        let rays = [0, 100, 2047, 2048, 4096, 65_535, 65_536, u64::MAX].map(|rounds| rays_within_rounds(32, rounds));
        assert_eq!(rays, [32, 32, 32, 31, 15, 1, 1, 1]);
        assert_eq!(rays_within_rounds(1, 10), 1);
    }
}
