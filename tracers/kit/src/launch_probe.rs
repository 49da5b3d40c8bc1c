//! What tells how searches should read and be launched on a device: kernels that do of a search what differs between drivers,
//! timed both ways (shaders/shared/launch_probe.wgsl).

use tracebench_api::wgpu::{BindGroup, Buffer, ComputePipeline};
use tracebench_api::{Gpu, PhaseClock, Timing, TracerError};
use tracebench_shaders::shared::LaunchProbe as Shader;

use crate::{
    LANES_OF_WORKGROUP, MemoryAccess, ReadSlot, Readable, bind_arrays, bind_group, compute_pipeline,
    dispatch_linear_groups, storage_buffer, uniform_buffer,
};
pub use tracebench_shaders::shared::ProbeSettings;

/// Rays that a persistent lane of the probe answers.
pub const MANY_RAYS: u32 = 32;

/// Counted rounds: each has every kernel once, in turn.
const ROUNDS: usize = 15;

/// Records that are gathered from: a mebibyte, more than what is nearest to a core.
const RECORDS: u32 = 1 << 16;

/// Reads of a lane.
const READS: u32 = 16;

/// Lanes and rays at first, about as many as a small ray set has, and at most, as a large one: with more, many rays a lane would leave
/// enough lanes for any device.
const LEAST: u32 = 1 << 14;
const MOST: u32 = 1 << 19;

/// A kernel that takes less is given more to do: a time is to stand out of what a dispatch costs, and one by a stamp that a driver
/// took too late is told from a true one only where the wait was longer than that ([`Timing::plausible`]).
const LONG_ENOUGH_MS: f64 = 2.0;

/// Times of the same work done each way, milliseconds, round by round.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ProbeTimes {
    /// Reads at unrelated places, from a buffer.
    pub gather_buffer_ms: Vec<f64>,
    /// The same from a texture.
    pub gather_texture_ms: Vec<f64>,
    /// Loops of different length, a ray a lane.
    pub one_ray_ms: Vec<f64>,
    /// The same with [`MANY_RAYS`] a lane.
    pub many_rays_ms: Vec<f64>,
}

/// A kernel with what it is bound to.
struct Kernel {
    pipeline: ComputePipeline,
    results: Buffer,
    arrays: BindGroup,
    rays_per_lane: u32,
}

impl Kernel {
    fn new(
        gpu: &Gpu,
        entry_point: &str,
        memory_access: MemoryAccess,
        rays_per_lane: u32,
        results: &Buffer,
    ) -> Result<Self, TracerError> {
        let pipeline = compute_pipeline(gpu, Shader { textures: memory_access == MemoryAccess::Texture }, entry_point)?;
        let contents = records();
        let contents = bytemuck::cast_slice(&contents);
        let records =
            Readable::written(gpu, memory_access, ReadSlot::Quads0, contents, "probe records", None, "nothing")?;
        let arrays = bind_arrays(gpu, &pipeline, &[records]);
        Ok(Self { pipeline, results: results.clone(), arrays, rays_per_lane })
    }

    /// Reads at unrelated places, a lane each.
    fn gather(gpu: &Gpu, memory_access: MemoryAccess, results: &Buffer) -> Result<Self, TracerError> {
        Self::new(gpu, "gather", memory_access, 1, results)
    }

    /// Loops of different length.
    fn search(gpu: &Gpu, rays_per_lane: u32, results: &Buffer) -> Result<Self, TracerError> {
        Self::new(gpu, "search", MemoryAccess::Buffer, rays_per_lane, results)
    }

    /// Runs it, in milliseconds.
    fn time(&self, gpu: &Gpu, count: u32) -> Result<f64, TracerError> {
        let rays_per_lane = self.rays_per_lane;
        let settings = ProbeSettings { count, rays_per_lane, last_record: RECORDS - 1, reads: READS };
        let settings = uniform_buffer(gpu, "probe settings", &settings)?;
        let resources = [settings.as_entire_binding(), self.results.as_entire_binding()];
        let own = bind_group(gpu, &self.pipeline.get_bind_group_layout(0), &resources);
        let mut clock = PhaseClock::new(Some(gpu));
        clock.device_phase("probe", |encoder| {
            let lanes = count.div_ceil(rays_per_lane);
            dispatch_linear_groups(encoder, &self.pipeline, &[&own, &self.arrays], lanes, LANES_OF_WORKGROUP);
        })?;
        let timing = clock.finish()?;
        let believed = Timing::plausible(std::slice::from_ref(&timing));
        Ok(if believed { timing } else { timing.by_submission() }.total_ms)
    }
}

/// Unrelated words.
fn records() -> Vec<u32> {
    let mut state = 1_u64;
    let mut word = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 32) as u32
    };
    (0..4 * RECORDS).map(|_| word()).collect()
}

fn results(gpu: &Gpu) -> Result<Buffer, TracerError> {
    storage_buffer(gpu, "probe results", u64::from(MOST) * 4, "nothing")
}

/// Times the probe's kernels on a device: a few tenths of a second on a slow one.
///
/// # Errors
/// [`TracerError`] if the device refuses or fails.
pub fn probe_launch(gpu: &Gpu) -> Result<ProbeTimes, TracerError> {
    let results = results(gpu)?;
    let gathers =
        [Kernel::gather(gpu, MemoryAccess::Buffer, &results)?, Kernel::gather(gpu, MemoryAccess::Texture, &results)?];
    let searches = [Kernel::search(gpu, 1, &results)?, Kernel::search(gpu, MANY_RAYS, &results)?];
    let (lanes, rays) = (enough(gpu, &gathers)?, enough(gpu, &searches)?);
    let mut times = ProbeTimes::default();
    for _ in 0..ROUNDS {
        times.gather_buffer_ms.push(gathers[0].time(gpu, lanes)?);
        times.gather_texture_ms.push(gathers[1].time(gpu, lanes)?);
        times.one_ray_ms.push(searches[0].time(gpu, rays)?);
        times.many_rays_ms.push(searches[1].time(gpu, rays)?);
    }
    Ok(times)
}

/// So many lanes or rays that either kernel takes long enough; each has run by then, which is its warm-up.
fn enough(gpu: &Gpu, kernels: &[Kernel; 2]) -> Result<u32, TracerError> {
    kernels.iter().try_for_each(|kernel| kernel.time(gpu, LEAST).map(drop))?;
    let mut count = LEAST;
    while count < MOST && kernels[0].time(gpu, count)?.min(kernels[1].time(gpu, count)?) < LONG_ENOUGH_MS {
        count *= 4;
    }
    Ok(count.min(MOST))
}

#[cfg(test)]
mod tests {
    use super::*;
    use tracebench_api::AdapterChoice;

    const COUNT: u32 = 3000;

    /// Proves that each kernel gives the same results both ways, those of the host, so that its times are of the same work, over a
    /// count that fills no workgroup; the results of one kernel are not the other's.
    #[test]
    fn both_ways_do_the_same_work() {
        let gpu = Gpu::open(&AdapterChoice::default()).unwrap();
        let results = results(&gpu).unwrap();
        let answers = |kernel: Kernel| -> Vec<u32> {
            kernel.time(&gpu, COUNT).unwrap();
            let read = bytemuck::pod_collect_to_vec(&gpu.read(&results, u64::from(COUNT) * 4).unwrap());
            let mut encoder = gpu.device.create_command_encoder(&Default::default());
            encoder.clear_buffer(&results, 0, None);
            gpu.queue.submit([encoder.finish()]);
            read
        };
        let records = records();
        let scatter = |value: u32| {
            let state = value.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
            let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
            (word >> 22) ^ word
        };
        let gathered = |lane: u32| {
            (0..READS).fold(scatter(lane), |at, _| {
                let [x, y, z, w] = std::array::from_fn(|word| records[4 * (at & (RECORDS - 1)) as usize + word]);
                (at >> 7) ^ x ^ y.wrapping_add(z) ^ w
            })
        };
        let expected: Vec<u32> = (0..COUNT).map(gathered).collect();
        for memory_access in [MemoryAccess::Buffer, MemoryAccess::Texture] {
            assert!(answers(Kernel::gather(&gpu, memory_access, &results).unwrap()) == expected, "{memory_access:?}");
        }
        let one = answers(Kernel::search(&gpu, 1, &results).unwrap());
        assert!(one.iter().all(|word| f32::from_bits(*word) > 0.0) && one != expected);
        assert_eq!(answers(Kernel::search(&gpu, MANY_RAYS, &results).unwrap()), one);
    }
}
