//! How rays are handed over from one search to another on the device.

use std::sync::Arc;

use tracebench_api::wgpu::{BindGroup, Buffer, BufferUsages, ComputePipeline};
use tracebench_api::{
    Gpu, Hit, HitBuffer, MemoryEntry, PhaseClock, Ray, RayBuffer, Residency, Surface, TraceJob, TraceTo, TracerError,
    View,
};
use tracebench_kit::{
    LANES_OF_WORKGROUP, MAX_RAYS_PER_LANE, PipelinesOnDemand, PrefixSum, ViewUniform, bind_group_at, compute_pipeline,
    dispatch_linear, uniform_buffer, view_uniform,
};
use tracebench_shaders::hybrid::{Handover as Variant, HandoverSettings};

use crate::description::{Dispatch, HybridParameters};

const SETTINGS: &str = "handover";
const FRAME: &str = "frame of the viewpoint";
const PLACES: &str = "places of rays";
const CHOSEN: &str = "rays handed over";
const WORKGROUPS: &str = "workgroups of rays handed over";
const HINT: &str = "--size";
const WORKGROUP_BYTES: u64 = MAX_RAYS_PER_LANE as u64 * 12;

/// The pipelines.
pub(crate) struct Handover {
    pub(crate) gpu: Arc<Gpu>,
    sums: PrefixSum,
    mark: ComputePipeline,
    choose: ComputePipeline,
    join: PipelinesOnDemand,
}

/// Rays that were handed over, with room for their answers.
pub(crate) struct HandedOver {
    pub(crate) rays: RayBuffer,
    pub(crate) hits: HitBuffer,
    settings: Buffer,
    /// How many rays before each were handed over.
    places: Buffer,
}

/// Most that a trace of so many rays holds beside what the parts hold, by name.
pub(crate) fn memory(trace_to: TraceTo, rays: usize) -> Vec<MemoryEntry> {
    let records = |bytes: usize| (rays.max(1) * bytes) as u64;
    let mut parts = vec![
        (SETTINGS, size_of::<HandoverSettings>() as u64),
        (FRAME, size_of::<ViewUniform>() as u64),
        (PLACES, 4 * (rays as u64 + 1)),
        (CHOSEN, records(size_of::<Ray>())),
        (WORKGROUPS, WORKGROUP_BYTES),
        ("the hit buffer", records(size_of::<Hit>())),
    ];
    parts.extend((trace_to == TraceTo::Surface).then(|| ("shading buffer", records(size_of::<Surface>()))));
    let parts = parts.into_iter().map(|(name, bytes)| MemoryEntry::whole(name, bytes));
    parts.chain(PrefixSum::memory(rays as u32 + 1)).collect()
}

impl Handover {
    pub(crate) fn new(gpu: Arc<Gpu>) -> Result<Self, TracerError> {
        let pipeline = |entry| compute_pipeline(&gpu, Variant { surfaces: false }, entry);
        Ok(Self {
            sums: PrefixSum::new(&gpu)?,
            mark: pipeline("mark")?,
            choose: pipeline("choose")?,
            join: PipelinesOnDemand::new("join"),
            gpu,
        })
    }

    fn bind(&self, pipeline: &ComputePipeline, buffers: &[(u32, &Buffer)]) -> BindGroup {
        let resources: Vec<_> = buffers.iter().map(|(at, buffer)| (*at, buffer.as_entire_binding())).collect();
        bind_group_at(&self.gpu, &pipeline.get_bind_group_layout(0), &resources)
    }

    /// Records the phase "hand over": the rays whose hits are not trusted, in their order.
    pub(crate) fn record(
        &self,
        frame: &View,
        told: &HybridParameters,
        job: &TraceJob<'_>,
        hits: &HitBuffer,
        clock: &mut PhaseClock<'_>,
    ) -> Result<HandedOver, TracerError> {
        let (gpu, count) = (&*self.gpu, job.rays.host.len());
        let ray_count = count as u32;
        let settings = HandoverSettings {
            ray_count,
            trusted: told.trust.statuses(),
            border: told.border_pixels as f32,
            padding: 0,
        };
        let settings = uniform_buffer(gpu, SETTINGS, &settings)?;
        let frame = uniform_buffer(gpu, FRAME, &view_uniform(frame))?;
        let storage = BufferUsages::STORAGE;
        let places = gpu.buffer(PLACES, 4 * (u64::from(ray_count) + 1), storage | BufferUsages::COPY_SRC, HINT)?;
        let chosen = gpu.buffer(CHOSEN, (count.max(1) * size_of::<Ray>()) as u64, storage, HINT)?;
        let workgroups = gpu.buffer(WORKGROUPS, WORKGROUP_BYTES, storage | BufferUsages::INDIRECT, "nothing")?;
        let rays = job.rays.on_device()?;
        let plan = self.sums.plan(gpu, &places, ray_count + 1, None)?;
        let marked = [(0, &settings), (1, &frame), (2, rays), (3, hits.on_device(count)?), (4, &places)];
        let mark = self.bind(&self.mark, &marked);
        let placed = [(0, &settings), (2, rays), (4, &places), (5, &chosen), (6, &workgroups)];
        let choose = self.bind(&self.choose, &placed);
        let others = HitBuffer::tracing_to(job.trace_to, count, Residency::Device, Some(gpu))?;
        clock.device_phase("hand over", |encoder| {
            dispatch_linear(encoder, &self.mark, &mark, ray_count + 1, LANES_OF_WORKGROUP);
            self.sums.record(encoder, &plan);
            dispatch_linear(encoder, &self.choose, &choose, ray_count.max(MAX_RAYS_PER_LANE), LANES_OF_WORKGROUP);
        })?;
        let rays = job.rays.chosen(chosen, (told.dispatch == Dispatch::Indirect).then_some(workgroups));
        Ok(HandedOver { rays, hits: others, settings, places })
    }

    /// Records the phase "join": answers to the rays that were handed over, in the place of the first ones.
    pub(crate) fn join(
        &self,
        handed: &HandedOver,
        trace_to: TraceTo,
        hits: &HitBuffer,
        clock: &mut PhaseClock<'_>,
    ) -> Result<(), TracerError> {
        let count = handed.rays.host.len();
        let surfaces = trace_to == TraceTo::Surface;
        let pipeline = self.join.of(&self.gpu, Variant { surfaces })?;
        let others = &handed.hits;
        let mut bound = vec![
            (0, &handed.settings),
            (3, hits.on_device(count)?),
            (4, &handed.places),
            (7, others.on_device(count)?),
        ];
        if surfaces {
            bound.extend([(8, hits.surfaces_on_device(count)?), (9, others.surfaces_on_device(count)?)]);
        }
        let bindings = self.bind(&pipeline, &bound);
        clock.device_phase("join", |encoder| {
            dispatch_linear(encoder, &pipeline, &bindings, count as u32, LANES_OF_WORKGROUP);
        })
    }

    /// How many rays were handed over, once that is done.
    pub(crate) fn count(&self, handed: &HandedOver) -> Result<u64, TracerError> {
        let places: Vec<u32> = bytemuck::pod_collect_to_vec(&self.gpu.read(&handed.places, handed.places.size())?);
        Ok(places.last().copied().unwrap_or(0).into())
    }
}
