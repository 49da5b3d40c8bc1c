//! Searching on the device.

use std::sync::Arc;

use tracebench_api::wgpu::Buffer;
use tracebench_api::{Counter, Gpu, HitBuffer, MemoryEntry, PhaseClock, Query, TraceJob, TraceTo, TracerError};
use tracebench_kit::{
    DevicePipelines, Gather, LANES_OF_WORKGROUP, MemoryAccess, PipelinesOnDemand, RayCounts, SurfaceGeometry,
    TouchedBits, bind_arrays, bind_group, dispatch_linear_groups, dispatch_rays, uniform_buffer, untimed,
};
use tracebench_shaders::bvh::{Binary, Cwbvh};

use super::description::NodeKind;
use super::resident::Resident;
pub(crate) use tracebench_shaders::bvh::SearchSettings;

/// Entries of a lane's private stack over CWBVH nodes: `PRIVATE_STACK` in shaders/bvh/cwbvh.wgsl. A search of a hierarchy
/// of that many levels at most fits; deeper ones are searched with stacks in device memory, a ray a lane: Mesa's software
/// driver ends a lane's loops after 65,535 rounds in all, which a few searches of such a hierarchy reach.
pub const WIDE_STACK: usize = 24;

/// The same over binary nodes, in shaders/bvh/binary.wgsl.
pub const BINARY_STACK: usize = 64;

/// Levels that a private stack serves.
pub(crate) fn private_stack(kind: NodeKind) -> usize {
    match kind {
        NodeKind::Wide => WIDE_STACK,
        NodeKind::Binary => BINARY_STACK,
    }
}

/// Bytes of a stack's entry.
pub(crate) fn stack_entry_bytes(kind: NodeKind) -> u64 {
    match kind {
        NodeKind::Wide => 8,
        NodeKind::Binary => 4,
    }
}

/// What each dispatch is told. Private stacks take one dispatch; stacks in device memory take as many as there are
/// rays for all of them, a ray a lane.
fn settings_of_dispatches(job: &TraceJob<'_>, searched: Searched<'_>) -> Vec<SearchSettings> {
    let Searched { resident, scale, rays_per_lane, .. } = searched;
    let all_rays = job.rays.host.len() as u32;
    let all = SearchSettings {
        first_ray: 0,
        ray_count: all_rays,
        rays_per_lane,
        any_hit: u32::from(job.rays.query == Query::Any),
        stack_entries: 0,
        scale,
        unscale: 1.0 / scale,
        max_t: (f64::from(f32::MAX) / 2.0 / f64::from(scale)).min(f64::from(f32::MAX)) as f32,
    };
    let Some((_, lanes)) = resident.stacks() else { return vec![all] };
    let of = |first_ray| SearchSettings {
        first_ray,
        ray_count: (all_rays - first_ray).min(lanes),
        rays_per_lane: 1,
        stack_entries: resident.depth as u32,
        ..all
    };
    (0..all_rays).step_by(lanes as usize).map(of).collect()
}

/// What the dispatches of a trace are told their settings by, and what gathering surfaces takes.
pub(crate) fn trace_memory(resident: &Resident, job: &TraceJob<'_>) -> Vec<MemoryEntry> {
    let dispatches = resident.stacks().map_or(1, |(_, lanes)| job.rays.host.len().div_ceil(lanes as usize));
    let mut parts = vec![MemoryEntry::whole(SETTINGS, size_of::<SearchSettings>() as u64); dispatches];
    parts.extend((job.trace_to == TraceTo::Surface).then(Gather::memory));
    parts
}

/// Label of a dispatch's uniform.
const SETTINGS: &str = "settings";

/// The buffers of a trace that counts.
pub struct Counting {
    counts: RayCounts,
    /// A bit a node.
    nodes: TouchedBits,
    /// A bit a slot of the leaves.
    references: TouchedBits,
}

impl Counting {
    fn new(gpu: &Gpu, resident: &Resident, rays: usize) -> Result<Self, TracerError> {
        Ok(Self {
            counts: RayCounts::new(gpu, &["nodes_visited", "triangle_tests", "search_rounds"], rays)?,
            nodes: TouchedBits::new(gpu, "nodes touched", resident.node_room(), "the scene's triangle count")?,
            references: TouchedBits::new(
                gpu,
                "references touched",
                resident.reference_count(),
                "the scene's triangle count",
            )?,
        })
    }
}

/// What is searched.
#[derive(Clone, Copy)]
pub(crate) struct Searched<'a> {
    /// The hierarchy.
    pub(crate) resident: &'a Resident,
    /// Where surfaces are gathered from.
    pub(crate) geometry: &'a SurfaceGeometry,
    /// From scene units to those of the hierarchy, a power of two.
    pub(crate) scale: f32,
    /// Rays that a lane answers one after the other, >= 1.
    pub(crate) rays_per_lane: u32,
}

/// The device with the pipelines, each made when it is first asked for.
pub struct Searches {
    pub(crate) gpu: Arc<Gpu>,
    gather: Gather,
    wide: PipelinesOnDemand,
    binary: PipelinesOnDemand,
}

impl DevicePipelines for Searches {
    // None yet.
    fn new(gpu: Arc<Gpu>) -> Result<Self, TracerError> {
        Ok(Self {
            gather: Gather::new(&gpu)?,
            wide: PipelinesOnDemand::new("trace"),
            binary: PipelinesOnDemand::new("trace"),
            gpu,
        })
    }
}

impl Searches {
    /// Records a trace; with something to count into by a counting variant. Surfaces are gathered after it.
    pub(crate) fn record(
        &self,
        searched: Searched<'_>,
        job: &TraceJob<'_>,
        hits: &HitBuffer,
        counting: Option<&Counting>,
        clock: &mut PhaseClock<'_>,
    ) -> Result<(), TracerError> {
        let Searched { resident, geometry, .. } = searched;
        let gpu = &*self.gpu;
        let (deep, counters) = (resident.stacks().is_some(), counting.is_some());
        let textures = resident.memory_access() == MemoryAccess::Texture;
        let pipeline = match resident.kind {
            NodeKind::Wide => self.wide.of(gpu, Cwbvh { textures, deep, counters })?,
            NodeKind::Binary => self.binary.of(gpu, Binary { textures, deep, counters })?,
        };
        let arrays = bind_arrays(gpu, &pipeline, resident.arrays());
        let mut dispatches = Vec::new();
        for settings in settings_of_dispatches(job, searched) {
            let uniform = uniform_buffer(gpu, SETTINGS, &settings)?;
            let mut resources = vec![
                uniform.as_entire_binding(),
                job.rays.on_device()?.as_entire_binding(),
                hits.on_device(job.rays.host.len())?.as_entire_binding(),
            ];
            let counting = counting.map(|all| [all.counts.buffer(), all.nodes.buffer(), all.references.buffer()]);
            let others = counting.into_iter().flatten().chain(resident.stacks().map(|(stacks, _)| stacks));
            resources.extend(others.map(Buffer::as_entire_binding));
            let bindings = bind_group(gpu, &pipeline.get_bind_group_layout(0), &resources);
            dispatches.push((bindings, settings));
        }
        clock.device_phase("traverse", |encoder| {
            for (bindings, settings) in &dispatches {
                let groups = [bindings, &arrays];
                match deep {
                    false => dispatch_rays(encoder, &pipeline, &groups, job.rays, settings.rays_per_lane),
                    true => {
                        dispatch_linear_groups(encoder, &pipeline, &groups, settings.ray_count, LANES_OF_WORKGROUP);
                    }
                }
            }
        })?;
        match job.trace_to {
            TraceTo::Hit => Ok(()),
            TraceTo::Surface => self.gather.record(gpu, geometry, job.rays, hits, None, clock),
        }
    }

    /// Traces by a counting variant.
    pub(crate) fn count(
        &self,
        searched: Searched<'_>,
        job: &TraceJob<'_>,
        hits: &HitBuffer,
    ) -> Result<Vec<Counter>, TracerError> {
        let gpu = &self.gpu;
        let counting = Counting::new(gpu, searched.resident, job.rays.host.len())?;
        untimed(gpu, |clock| self.record(searched, job, hits, Some(&counting), clock))?;
        let mut counters = counting.counts.counters(gpu)?;
        counters.push(Counter::of_set("nodes_touched", counting.nodes.count(gpu)?));
        counters.push(Counter::of_set("references_touched", counting.references.count(gpu)?));
        Ok(counters)
    }
}
