//! Tracing on the device.

use bytemuck::{Pod, Zeroable};
use tracebench_api::wgpu::{BindGroup, Buffer, BufferUsages};
use tracebench_api::{Counter, EndPoint, HitBuffer, MemoryEntry, PhaseClock, Query, TraceJob, TracerError};
use tracebench_kit::{Reads, bind_arrays, bind_group_at, dispatch_rays, uniform_buffer};
use tracebench_shaders::quadtree::Trace;

use crate::counting::Counting;
use crate::description::{Inpainting, QuadtreeParameters, Traversal};
use crate::layout::{Forest, MOST_VIEWS, TreeView};
use crate::structure::QuadtreeStructure;

/// Name of the secondary samples' weights, a number a ray.
const WEIGHTS: &str = "weights of secondary samples";

/// `QuadtreeSettings` of shaders/quadtree/store.wgsl.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct QuadtreeSettings {
    /// Rays.
    pub ray_count: u32,
    /// Rays that a lane answers.
    pub rays_per_lane: u32,
    /// 1: of rays alone that have no answer yet.
    pub unanswered_only: u32,
    /// Views.
    pub view_count: u32,
    /// 1: they are faces.
    pub has_faces: u32,
    /// When the next layer is asked.
    pub next_layer: u32,
    /// 1: any hit will do.
    pub any_hit: u32,
    /// 1: rays end at the last layer's occlusion volumes.
    pub inpaints: u32,
    /// Nodes after which a ray is given up.
    pub max_steps: u32,
    /// Pixel heights.
    pub start_bias: f32,
    /// Pixel heights.
    pub occlusion_bias: f32,
    /// Samples beside every ray.
    pub samples: u32,
    /// Pixels.
    pub jitter: f32,
    /// Of z in the unit cube.
    pub inverse_sigma: f32,
    /// Words of bits a node.
    pub touched_words: u32,
    /// Nothing.
    pub padding: u32,
}

impl QuadtreeStructure {
    /// Whether rays end at the last layer's occlusion volumes.
    fn inpaints(&self, parameters: &QuadtreeParameters) -> bool {
        match parameters.inpainting {
            Inpainting::OneLayer => self.shape.layers == 1,
            Inpainting::Never => false,
            Inpainting::Always => true,
        }
    }

    fn settings(
        &self,
        job: &TraceJob<'_>,
        parameters: &QuadtreeParameters,
        counting: Option<&Counting>,
    ) -> QuadtreeSettings {
        QuadtreeSettings {
            ray_count: job.rays.host.len() as u32,
            rays_per_lane: parameters.rays_per_lane,
            unanswered_only: 0,
            view_count: self.shape.views.len() as u32,
            has_faces: u32::from(self.shape.has_faces),
            next_layer: parameters.next_layer as u32,
            any_hit: u32::from(job.rays.query == Query::Any),
            inpaints: u32::from(self.inpaints(parameters)),
            max_steps: parameters.max_steps,
            start_bias: parameters.start_bias as f32,
            occlusion_bias: parameters.occlusion_bias as f32,
            samples: parameters.secondary_samples,
            jitter: parameters.secondary_jitter as f32,
            inverse_sigma: (1.0 / parameters.secondary_sigma) as f32,
            touched_words: counting.map_or(0, |counting| counting.touched_words),
            padding: 0,
        }
    }

    /// Records a trace, by the counting variant where there is something to count into.
    pub(crate) fn record(
        &self,
        job: &TraceJob<'_>,
        hits: &HitBuffer,
        counting: Option<&Counting>,
        clock: &mut PhaseClock<'_>,
    ) -> Result<(), TracerError> {
        self.record_weighing(job, hits, counting, clock).map(drop)
    }

    /// The same; gives the weights of the secondary samples, where there are any, which are complete when the clock has been
    /// finished.
    pub(crate) fn record_weighing(
        &self,
        job: &TraceJob<'_>,
        hits: &HitBuffer,
        counting: Option<&Counting>,
        clock: &mut PhaseClock<'_>,
    ) -> Result<Option<Buffer>, TracerError> {
        let gpu = self.gpu();
        let count = job.rays.host.len();
        let parameters = QuadtreeParameters::try_from(job.parameters)?;
        let surfaces = job.end == EndPoint::Surface;
        let variant = Trace {
            textures: self.images.reads() == Reads::Texture,
            stack: parameters.traversal == Traversal::Stack,
            surfaces,
            counters: counting.is_some(),
            secondary: parameters.secondary_samples > 0,
            joined: self.shape.is_joined,
        };
        let pipeline = self.pipelines.traces.of(gpu, variant)?;
        let settings = self.settings(job, &parameters, counting);
        let forest = uniform_buffer(gpu, "forest", &self.shape.forest())?;
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
        let mut bound = vec![(0, &forest), (2, &views), (3, job.rays.on_device()?), (4, hit_buffer)];
        if surfaces {
            bound.push((5, hits.surfaces_on_device(count)?));
        }
        bound.extend(counting.map(|counting| (6, &counting.buffer)));
        bound.extend(weights.as_ref().map(|weights| (7, weights)));
        let bind = |settings: &QuadtreeSettings| -> Result<BindGroup, TracerError> {
            let settings = uniform_buffer(gpu, "search", settings)?;
            let numbered = bound.iter().copied().chain([(1, &settings)]);
            let numbered: Vec<_> = numbered.map(|(at, buffer)| (at, buffer.as_entire_binding())).collect();
            Ok(bind_group_at(gpu, &pipeline.get_bind_group_layout(0), &numbered))
        };
        let mut searches = vec![(bind(&settings)?, settings.rays_per_lane)];
        // A driver that ends loops after some rounds may leave lanes' last rays without an answer.
        let may_leave_rays = settings.rays_per_lane > 1;
        if may_leave_rays {
            searches.push((bind(&QuadtreeSettings { rays_per_lane: 1, unanswered_only: 1, ..settings })?, 1));
        }
        let arrays = bind_arrays(gpu, &pipeline, self.images.bound(surfaces));
        clock.device_phase("trace", |encoder| {
            if may_leave_rays {
                encoder.clear_buffer(hit_buffer, 0, None);
            }
            for (own, rays_per_lane) in &searches {
                dispatch_rays(encoder, &pipeline, &[own, &arrays], settings.ray_count, *rays_per_lane);
            }
        })?;
        Ok(weights)
    }

    pub(crate) fn count(&self, job: &TraceJob<'_>, hits: &HitBuffer) -> Result<Vec<Counter>, TracerError> {
        let gpu = self.gpu();
        let nodes = self.shape.level_offsets().1 * self.shape.images();
        let counting = Counting::new(gpu, nodes, job.rays.host.len(), self.shape.is_joined)?;
        let mut clock = PhaseClock::new(Some(gpu));
        self.record(job, hits, Some(&counting), &mut clock)?;
        clock.finish()?;
        counting.counters(gpu, job.end == EndPoint::Surface, self.shape.layers)
    }

    pub(crate) fn memory_of_trace(&self, job: &TraceJob<'_>) -> Result<Vec<MemoryEntry>, TracerError> {
        let parameters = QuadtreeParameters::try_from(job.parameters)?;
        // One more for the rays that lanes of several leave.
        let searches = if parameters.rays_per_lane > 1 { 2 } else { 1 };
        let mut parts = vec![
            ("forest", size_of::<Forest>() as u64),
            ("search", searches * size_of::<QuadtreeSettings>() as u64),
            ("views", (MOST_VIEWS * size_of::<TreeView>()) as u64),
        ];
        if parameters.secondary_samples > 0 {
            parts.push((WEIGHTS, job.rays.host.len().max(1) as u64 * 4));
        }
        Ok(parts.into_iter().map(|(name, bytes)| MemoryEntry::whole(name, bytes)).collect())
    }
}
