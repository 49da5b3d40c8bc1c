//! What a trace that counts writes: bits of the nodes and data that were read, and numbers of every ray, in one buffer.

use tracebench_api::wgpu::Buffer;
use tracebench_api::{Counter, Gpu, TracerError};
use tracebench_kit::{bits_on, counters_of, storage_buffer};

/// As `COUNTS` in shaders/voxel-abuffer/store.wgsl.
const COUNTERS: [&str; 6] =
    ["voxels_stepped", "voxels_opened", "searches", "depth_comparisons", "layers_tested", "starts_inside"];

/// The buffer of a trace that counts, all 0 at first: one, since WebGPU grants eight in a stage.
pub(crate) struct Counting {
    pub buffer: Buffer,
    /// Words of the bits of all nodes; those of data are as many.
    pub touched_words: u32,
    rays: usize,
}

impl Counting {
    pub(crate) fn new(gpu: &Gpu, nodes: u32, rays: usize) -> Result<Self, TracerError> {
        let touched_words = nodes.div_ceil(32).max(1);
        let words = 2 * u64::from(touched_words) + (rays.max(1) * COUNTERS.len()) as u64;
        let buffer = storage_buffer(gpu, "counts", words * 4, "--size or voxel-abuffer.abuffer")?;
        Ok(Self { buffer, touched_words, rays })
    }

    /// What was counted, by a trace that reads data or one that does not, and that tells inside from outside or does not.
    pub(crate) fn counters(&self, gpu: &Gpu, reads_data: bool, has_inside: bool) -> Result<Vec<Counter>, TracerError> {
        let words: Vec<u32> = bytemuck::pod_collect_to_vec(&gpu.read(&self.buffer, self.buffer.size())?);
        let (nodes, words) = words.split_at(self.touched_words as usize);
        let (data, counts) = words.split_at(self.touched_words as usize);
        let counts: &[[u32; COUNTERS.len()]] = bytemuck::cast_slice(&counts[..self.rays * COUNTERS.len()]);
        let mut counters = counters_of(counts, COUNTERS);
        counters.retain(|counter| has_inside || counter.name != "starts_inside");
        counters.push(Counter::of_set("fragments_touched", bits_on(nodes)));
        if reads_data {
            counters.push(Counter::of_set("payloads_touched", bits_on(data)));
        }
        Ok(counters)
    }
}
