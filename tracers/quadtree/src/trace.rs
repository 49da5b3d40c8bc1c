//! Tracing on the device.

use tracebench_api::wgpu::{Buffer, BufferUsages, ComputePipeline};
use tracebench_api::{Counter, HitBuffer, MemoryEntry, PhaseClock, Query, TraceJob, TraceTo, TracerError};
use tracebench_kit::{
    Left, MemoryAccess, Search, SearchJob, SearchedRays, TraceCounts, bind_arrays, bind_group_at, uniform_buffer,
    untimed,
};
use tracebench_shaders::quadtree::Trace;

use crate::description::{Inpainting, QuadtreeParameters, Traversal, WalkFrom};
use crate::layout::{Forest, MAX_VIEWS, TreeView};
use crate::structure::QuadtreeStructure;
pub(crate) use tracebench_shaders::quadtree::QuadtreeSettings;

/// Name of the secondary samples' weights, a number a ray.
const WEIGHTS: &str = "weights of secondary samples";

/// What is counted of every ray, as `COUNTS` in shaders/quadtree/trace.wgsl; the last where planes are joined alone.
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

/// Those that a structure of one layer has none of.
const OF_FURTHER_LAYERS: [&str; 2] = ["rays_asking_layer_2", "hits_behind_layer_1"];

impl QuadtreeStructure {
    /// The shader's code for where rays end at the last layer's occlusion volumes, 0 where they do not.
    fn inpaints(&self, parameters: &QuadtreeParameters) -> u32 {
        match parameters.inpainting {
            Inpainting::OneLayer if self.shape.layers > 1 => 0,
            Inpainting::Never => 0,
            Inpainting::OneLayer | Inpainting::Always => 1 + parameters.inpainted_at as u32,
        }
    }

    fn settings(
        &self,
        job: &TraceJob<'_>,
        parameters: &QuadtreeParameters,
        counting: Option<&TraceCounts>,
    ) -> QuadtreeSettings {
        QuadtreeSettings {
            ray_count: job.rays.host.len() as u32,
            rays_per_lane: parameters.rays_per_lane,
            view_count: self.shape.views.len() as u32,
            has_faces: u32::from(self.shape.has_faces),
            next_layer: parameters.next_layer as u32,
            any_hit: u32::from(job.rays.query == Query::Any),
            inpaints: self.inpaints(parameters),
            max_steps: parameters.max_steps,
            start_bias: parameters.start_bias as f32,
            occlusion_bias: parameters.occlusion_bias as f32,
            samples: parameters.secondary_samples,
            jitter: parameters.secondary_jitter as f32,
            inverse_sigma: (1.0 / parameters.secondary_sigma) as f32,
            touched_words: counting.map_or(0, |counting| counting.bit_words[0]),
            from_ancestor: u32::from(parameters.walk_from == WalkFrom::Ancestor),
            padding: 0,
        }
    }

    /// The same; gives the weights of the secondary samples, where there are any, which are complete when the clock has been
    /// finished.
    pub(crate) fn record_weighing(
        &self,
        job: &TraceJob<'_>,
        hits: &HitBuffer,
        counting: Option<&TraceCounts>,
        clock: &mut PhaseClock<'_>,
    ) -> Result<Option<Buffer>, TracerError> {
        let gpu = self.gpu();
        let count = job.rays.host.len();
        let parameters = QuadtreeParameters::try_from(job.parameters)?;
        let surfaces = job.trace_to == TraceTo::Surface;
        let variant = Trace {
            textures: self.images.memory_access() == MemoryAccess::Texture,
            stack: parameters.traversal == Traversal::Stack,
            surfaces,
            counters: counting.is_some(),
            secondary: parameters.secondary_samples > 0,
            joined: self.shape.is_joined,
        };
        let settings = self.settings(job, &parameters, counting);
        let forest = uniform_buffer(gpu, "forest", &self.shape.forest())?;
        let search = uniform_buffer(gpu, "search", &settings)?;
        let views = uniform_buffer(gpu, "views", &self.shape.tree_views())?;
        let weights = match variant.secondary {
            true => {
                let bytes = count.max(1) as u64 * 4;
                gpu.check_storage_binding(WEIGHTS, bytes, "--size")?;
                Some(gpu.buffer(WEIGHTS, bytes, BufferUsages::STORAGE | BufferUsages::COPY_SRC, "--size")?)
            }
            false => None,
        };
        let hit_buffer = hits.on_device(count)?;
        let mut bound = vec![(0, &forest), (1, &search), (2, &views), (3, job.rays.on_device()?), (4, hit_buffer)];
        if surfaces {
            bound.push((5, hits.surfaces_on_device(count)?));
        }
        bound.extend(counting.map(|counting| (6, &counting.buffer)));
        bound.extend(weights.as_ref().map(|weights| (7, weights)));
        let bound: Vec<_> = bound.into_iter().map(|(at, buffer)| (at, buffer.as_entire_binding())).collect();
        let bind = |pipeline: &ComputePipeline, _| {
            let own = bind_group_at(gpu, &pipeline.get_bind_group_layout(0), &bound);
            vec![own, bind_arrays(gpu, pipeline, self.images.bound(surfaces))]
        };
        let per_lane = settings.rays_per_lane;
        let rays = SearchedRays { rays: job.rays, per_lane, hits: hit_buffer, left: Left::CutOff };
        self.pipelines.traces.record(gpu, variant, rays, bind, clock)?;
        Ok(weights)
    }

    pub(crate) fn memory_of_trace(&self, job: &TraceJob<'_>) -> Result<Vec<MemoryEntry>, TracerError> {
        let parameters = QuadtreeParameters::try_from(job.parameters)?;
        let mut parts = vec![
            ("forest", size_of::<Forest>() as u64),
            ("search", size_of::<QuadtreeSettings>() as u64),
            ("views", (MAX_VIEWS * size_of::<TreeView>()) as u64),
        ];
        if parameters.secondary_samples > 0 {
            parts.push((WEIGHTS, job.rays.host.len().max(1) as u64 * 4));
        }
        Ok(parts.into_iter().map(|(name, bytes)| MemoryEntry::whole(name, bytes)).collect())
    }
}

impl Search for QuadtreeStructure {
    type Counting = TraceCounts;

    fn record(&self, search: SearchJob<'_, '_, TraceCounts>) -> Result<(), TracerError> {
        let SearchJob { job, hits, counting, clock } = search;
        self.record_weighing(job, hits, counting, clock).map(drop)
    }

    fn count(&self, job: &TraceJob<'_>, hits: &HitBuffer) -> Result<Vec<Counter>, TracerError> {
        let gpu = self.gpu();
        // Of nodes and, no more than these, of pixels.
        let things = [self.shape.level_offsets().1 * self.shape.images(); 2];
        let names = if self.shape.is_joined { &COUNTERS[..] } else { &COUNTERS[..COUNTERS.len() - 1] };
        let counting =
            TraceCounts::new(gpu, things, names, job.rays.host.len(), "--size, --face-size or --frame-size")?;
        untimed(gpu, |clock| self.record(SearchJob { job, hits, counting: Some(&counting), clock }))?;
        let mut counters = counting.counters(gpu, ["nodes_touched", "payloads_touched"])?;
        counters.retain(|counter| self.shape.layers > 1 || !OF_FURTHER_LAYERS.contains(&counter.name));
        counters.retain(|counter| job.trace_to == TraceTo::Surface || counter.name != "payloads_touched");
        Ok(counters)
    }
}
