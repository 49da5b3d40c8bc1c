//! Tracing a packed structure on the device.

use tracebench_api::wgpu::{Buffer, BufferUsages, ComputePipeline};
use tracebench_api::{Counter, Gpu, HitBuffer, MemoryEntry, Query, TraceJob, TraceTo, TracerError};
use tracebench_kit::{
    Left, MemoryAccess, RayCounts, Search, SearchJob, SearchedRays, TouchedBits, bind_arrays, bind_group_at,
    uniform_buffer, untimed,
};
use tracebench_shaders::dirt::PackedTrace;

use super::PackedStructure;
use super::layout::{PackedGrid, PackedSearch};
use crate::description::{CentreRays, DirtParameters, Lists, March, Order};

/// The buffers of a trace that counts.
pub(crate) struct Counting {
    counts: RayCounts,
    /// A bit a reference.
    touched: TouchedBits,
}

/// Rounds of a search in which a ray had something to do, which only trees are searched by.
const ROUNDS: &str = "search_rounds";

/// What is counted of every ray, in the order of `Work` in shaders/dirt/packed_ray.wgsl.
const COUNTERS: [&str; 5] = ["pyramid_steps", "nodes_visited", "triangle_tests", "views_entered", ROUNDS];

/// What a trace takes while it runs, by name and bytes.
const LEFT: (&str, usize) = ("workgroups that answer what is left", 12);

fn left_buffer(gpu: &Gpu) -> Result<Buffer, TracerError> {
    gpu.buffer_with(LEFT.0, &[0; LEFT.1], BufferUsages::STORAGE | BufferUsages::INDIRECT, "nothing")
}

/// What a trace takes while it runs.
pub(super) fn memory() -> Vec<MemoryEntry> {
    let parts = [("packed grid", size_of::<PackedGrid>()), ("search", size_of::<PackedSearch>()), LEFT];
    parts.map(|(name, bytes)| MemoryEntry::whole(name, bytes as u64)).to_vec()
}

impl PackedStructure {
    fn search(&self, job: &TraceJob<'_>, parameters: &DirtParameters) -> PackedSearch {
        PackedSearch {
            ray_count: job.rays.host.len() as u32,
            any_hit: u32::from(job.rays.query == Query::Any),
            max_steps: parameters.max_steps,
            top_level: match parameters.march {
                March::HiZ => self.layout.levels() as u32 - 1,
                March::Tiles => 0,
            },
            rays_per_lane: parameters.rays_per_lane,
            split: u32::from(parameters.centre_rays == CentreRays::Split),
            nearest_first: u32::from(parameters.order == Order::Nearest),
            padding: 0,
        }
    }

    fn variant(&self, counters: bool) -> PackedTrace {
        let textures = self.arrays[0].memory_access() == MemoryAccess::Texture;
        match self.layout.lists {
            Lists::Trees => PackedTrace::Trees { textures, counters },
            Lists::Slices => PackedTrace::Slices { textures, counters },
            Lists::Packed | Lists::Linked => PackedTrace::Plain { textures, counters },
        }
    }
}

impl Search for PackedStructure {
    type Counting = Counting;

    fn record(&self, search: SearchJob<'_, '_, Counting>) -> Result<(), TracerError> {
        let SearchJob { job, hits, counting, clock } = search;
        let gpu = &*self.pipelines.gpu;
        let parameters = DirtParameters::try_from(job.parameters)?;
        if let Some(map) = self.shadow_map.as_ref().filter(|map| map.answers(job)) {
            return self.pipelines.look_up(map, job, parameters.shadow_bias, hits, clock);
        }
        let search = self.search(job, &parameters);
        let variant = self.variant(counting.is_some());
        let grid = uniform_buffer(gpu, "packed grid", &self.buffers.grid(&self.layout))?;
        let settings = uniform_buffer(gpu, "search", &search)?;
        let hits_on_device = hits.on_device(job.rays.host.len())?;
        let bound = [(0, &grid), (1, &settings), (7, job.rays.on_device()?), (8, hits_on_device)];
        let counted = counting.map(|counting| [(9, counting.counts.buffer()), (10, counting.touched.buffer())]);
        let resources: Vec<_> = bound
            .into_iter()
            .chain(counted.into_iter().flatten())
            .map(|(binding, buffer)| (binding, buffer.as_entire_binding()))
            .collect();
        // Where it does not count the first dispatch tells what it leaves: among others the rays that pass the eye.
        let left = left_buffer(gpu)?;
        let bind = |pipeline: &ComputePipeline, is_first: bool| {
            let told = (is_first && counting.is_none()).then(|| (11, left.as_entire_binding()));
            let resources: Vec<_> = resources.iter().cloned().chain(told).collect();
            let own = bind_group_at(gpu, &pipeline.get_bind_group_layout(0), &resources);
            vec![own, bind_arrays(gpu, pipeline, &self.arrays)]
        };
        let per_lane = search.rays_per_lane;
        let left = if counting.is_none() { Left::Told(&left) } else { Left::Any };
        let rays = SearchedRays { rays: job.rays, per_lane, hits: hits_on_device, left };
        self.pipelines.packed.trace.record(gpu, variant, rays, bind, clock)?;
        match job.trace_to {
            TraceTo::Hit => Ok(()),
            TraceTo::Surface => {
                self.pipelines.gather()?.record(gpu, &self.geometry.surfaces, job.rays, hits, None, clock)
            }
        }
    }

    fn count(&self, job: &TraceJob<'_>, hits: &HitBuffer) -> Result<Vec<Counter>, TracerError> {
        let gpu = &*self.pipelines.gpu;
        let counting = Counting {
            counts: RayCounts::new(gpu, &COUNTERS, job.rays.host.len())?,
            touched: TouchedBits::new(gpu, "references touched", u64::from(self.buffers.capacities[0]), "--size")?,
        };
        untimed(gpu, |clock| self.record(SearchJob { job, hits, counting: Some(&counting), clock }))?;
        // A set that the shadow map answers searches nothing: a texel a ray is looked at.
        let mut counters = counting.counts.counters(gpu)?;
        counters.retain(|counter| counter.name != ROUNDS || self.layout.lists == Lists::Trees);
        if self.shadow_map.as_ref().is_some_and(|map| map.answers(job)) {
            counters.push(Counter::of_set("shadow_map_texels", job.rays.host.len() as u64));
        }
        counters.push(Counter::of_set("references_touched", counting.touched.count(gpu)?));
        Ok(counters)
    }
}
