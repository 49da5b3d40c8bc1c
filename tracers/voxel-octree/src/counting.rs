//! What a trace that counts writes: bits of the nodes and leaves that were met, and numbers of every ray, in one buffer.

use tracebench_api::wgpu::Buffer;
use tracebench_api::{Counter, Gpu, TracerError};
use tracebench_kit::{bits_on, counters_of, storage_buffer};

/// As `COUNTS` in shaders/voxel-octree/trace.wgsl.
const COUNTERS: [&str; 2] = ["nodes_visited", "steps"];

/// The buffer of a trace that counts, all 0 at first.
pub(crate) struct Counting {
    pub buffer: Buffer,
    /// The bit of the first leaf, behind those of all nodes.
    pub first_leaf_bit: u32,
    /// Words of the bits of all.
    pub touched_words: u32,
    rays: usize,
}

impl Counting {
    pub(crate) fn new(gpu: &Gpu, nodes: u32, leaves: u32, rays: usize) -> Result<Self, TracerError> {
        let node_words = nodes.div_ceil(32);
        let touched_words = node_words + leaves.div_ceil(32);
        let words = u64::from(touched_words) + (rays.max(1) * COUNTERS.len()) as u64;
        let buffer = storage_buffer(gpu, "counts of rays", words * 4, "--size or voxel-octree.levels")?;
        Ok(Self { buffer, first_leaf_bit: node_words * 32, touched_words, rays })
    }

    /// What was counted.
    pub(crate) fn counters(&self, gpu: &Gpu) -> Result<Vec<Counter>, TracerError> {
        let words: Vec<u32> = bytemuck::pod_collect_to_vec(&gpu.read(&self.buffer, self.buffer.size())?);
        let (nodes, words) = words.split_at(self.first_leaf_bit as usize / 32);
        let (leaves, counts) = words.split_at(self.touched_words as usize - nodes.len());
        let counts: &[[u32; COUNTERS.len()]] = bytemuck::cast_slice(&counts[..self.rays * COUNTERS.len()]);
        let mut counters = counters_of(counts, COUNTERS);
        counters.push(Counter::of_set("nodes_touched", bits_on(nodes)));
        counters.push(Counter::of_set("leaves_touched", bits_on(leaves)));
        Ok(counters)
    }
}
