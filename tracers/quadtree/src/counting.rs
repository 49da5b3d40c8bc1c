//! What a trace that counts writes: bits of the nodes and pixels that were read, and numbers of every ray, in one buffer.

use tracebench_api::wgpu::Buffer;
use tracebench_api::{Counter, Gpu, TracerError};
use tracebench_kit::{bits_on, counters_of, storage_buffer};

/// As `COUNTS` in shaders/quadtree/trace.wgsl.
const COUNTERS: [&str; 8] = [
    "nodes_visited",
    "plane_tests",
    "box_tests",
    "layers_asked",
    "views_entered",
    "rays_asking_layer_2",
    "hits_behind_layer_1",
    "neighbours_read",
];

/// How many of them there are where planes are not joined.
const OF_SQUARES: usize = 7;

/// Those that a structure of one layer has none of.
const OF_FURTHER_LAYERS: [&str; 2] = ["rays_asking_layer_2", "hits_behind_layer_1"];

/// The buffer of a trace that counts, all 0 at first.
pub(crate) struct Counting {
    pub buffer: Buffer,
    /// Words of the bits of all nodes; there are as many for pixels.
    pub touched_words: u32,
    rays: usize,
    is_joined: bool,
}

/// Numbers of every ray.
fn counted(is_joined: bool) -> usize {
    if is_joined { COUNTERS.len() } else { OF_SQUARES }
}

impl Counting {
    pub(crate) fn new(gpu: &Gpu, nodes: u64, rays: usize, is_joined: bool) -> Result<Self, TracerError> {
        let touched_words = nodes.div_ceil(32).max(1);
        let words = 2 * touched_words + (rays.max(1) * counted(is_joined)) as u64;
        let buffer = storage_buffer(gpu, "counts", words * 4, "--size, --face or --frame")?;
        Ok(Self { buffer, touched_words: touched_words as u32, rays, is_joined })
    }

    /// What was counted, by a trace to surfaces or to hits, of a structure of so many layers.
    pub(crate) fn counters(&self, gpu: &Gpu, surfaces: bool, layers: u32) -> Result<Vec<Counter>, TracerError> {
        let words: Vec<u32> = bytemuck::pod_collect_to_vec(&gpu.read(&self.buffer, self.buffer.size())?);
        let (nodes, words) = words.split_at(self.touched_words as usize);
        let (pixels, counts) = words.split_at(self.touched_words as usize);
        let counts = &counts[..self.rays * counted(self.is_joined)];
        let mut counters = match self.is_joined {
            true => counters_of(bytemuck::cast_slice(counts), COUNTERS),
            false => counters_of::<OF_SQUARES>(bytemuck::cast_slice(counts), std::array::from_fn(|at| COUNTERS[at])),
        };
        counters.retain(|counter| layers > 1 || !OF_FURTHER_LAYERS.contains(&counter.name));
        counters.push(Counter::of_set("nodes_touched", bits_on(nodes)));
        if surfaces {
            counters.push(Counter::of_set("payloads_touched", bits_on(pixels)));
        }
        Ok(counters)
    }
}
