//! Tracing on the device.

use tracebench_api::wgpu::{BindingResource, Buffer, ComputePipeline};
use tracebench_api::{Counter, HitBuffer, PhaseClock, TraceJob, TraceTo, TracerError};
use tracebench_kit::{
    Left, MemoryAccess, RayCounts, Search, SearchJob, SearchedRays, TraceCounts, bind_arrays, bind_group,
    bind_group_at, dispatch_rays, rays_within_rounds, uniform_buffer, untimed,
};
use tracebench_shaders::voxel_abuffer::{Trace, Voxels};

use crate::buffers::Lists;
use crate::description::{Depths, StartAlong, VoxelParameters};
use crate::layout::AXES;
use crate::search::{VoxelSearch, voxel_search};
use crate::structure::VoxelStructure;

/// What is counted of every ray, as `COUNTS` in shaders/voxel-abuffer/store.wgsl.
const COUNTERS: [&str; 6] =
    ["voxels_stepped", "voxels_opened", "searches", "depth_comparisons", "layers_tested", "starts_inside"];

/// Why voxels alone have no surfaces.
const NO_SURFACES: &str =
    "voxels alone have no normals and materials to give: choose voxel-abuffer.structure=two-level, or --trace-to hit";

impl VoxelStructure {
    fn search(
        &self,
        job: &TraceJob<'_>,
        parameters: &VoxelParameters,
        counting: Option<&TraceCounts>,
    ) -> Result<VoxelSearch, TracerError> {
        let mut search = voxel_search(&self.layout, job, parameters);
        search.touched_words = counting.map_or(0, |counting| counting.bit_words[0]);
        let Some(lists) = &self.buffers.lists else { return Ok(search) };
        search.half_nodes = lists.nodes.half_nodes;
        for (axis, placed) in self.arrays.placed(&self.buffers).into_iter().enumerate() {
            search.first_bits[axis] = lists.nodes.before(axis);
            search.first_nodes[axis] = placed.first_node;
            search.first_data[axis] = placed.first_data;
            search.first_further_data[axis] = placed.first_further_data;
        }
        Ok(search)
    }

    /// Whether a trace reads more of a layer than its depth and facing.
    fn reads_data(&self, trace_to: TraceTo, parameters: &VoxelParameters) -> bool {
        let lifted = parameters.start_along == StartAlong::Normal;
        trace_to == TraceTo::Surface || self.layout.planes || parameters.depths == Depths::Plane || lifted
    }

    /// The same through voxels alone.
    fn record_voxels(
        &self,
        job: &TraceJob<'_>,
        hits: &HitBuffer,
        counts: Option<&Buffer>,
        clock: &mut PhaseClock<'_>,
    ) -> Result<(), TracerError> {
        if job.trace_to == TraceTo::Surface {
            return Err(TracerError::Unsupported(NO_SURFACES.to_owned()));
        }
        let gpu = &*self.pipelines.gpu;
        let mut search = self.search(job, &VoxelParameters::try_from(job.parameters)?, None)?;
        // Through the grid along every axis, and the turn itself.
        let max_rounds = u64::from(3 * search.space.grid + 2);
        search.rays_per_lane = rays_within_rounds(search.rays_per_lane, max_rounds);
        let textures = self.arrays.memory_access() == MemoryAccess::Texture;
        let pipeline = self.pipelines.voxels.of(gpu, Voxels { textures, counters: counts.is_some() })?;
        let settings = uniform_buffer(gpu, "search", &search)?;
        let mut bound = vec![(0, &settings), (1, job.rays.on_device()?), (2, hits.on_device(job.rays.host.len())?)];
        bound.extend(counts.map(|counts| (4, counts)));
        let bound: Vec<_> = bound.into_iter().map(|(at, buffer)| (at, buffer.as_entire_binding())).collect();
        let own = bind_group_at(gpu, &pipeline.get_bind_group_layout(0), &bound);
        let arrays = bind_arrays(gpu, &pipeline, &self.arrays.bound(false));
        clock.device_phase("trace", |encoder| {
            dispatch_rays(encoder, &pipeline, &[&own, &arrays], job.rays, search.rays_per_lane);
        })
    }
}

impl Search for VoxelStructure {
    type Counting = TraceCounts;

    fn record(&self, search: SearchJob<'_, '_, TraceCounts>) -> Result<(), TracerError> {
        let SearchJob { job, hits, counting, clock } = search;
        let Some(lists) = &self.buffers.lists else { return self.record_voxels(job, hits, None, clock) };
        let pipelines = &*self.pipelines;
        let gpu = &*pipelines.gpu;
        let count = job.rays.host.len();
        let textures = self.arrays.memory_access() == MemoryAccess::Texture;
        let parameters = VoxelParameters::try_from(job.parameters)?;
        let (surfaces, counters) = (job.trace_to == TraceTo::Surface, counting.is_some());
        let reads_data = self.reads_data(job.trace_to, &parameters);
        let planes = parameters.depths == Depths::Plane;
        let lifted = parameters.start_along == StartAlong::Normal;
        let split = lists.nodes.is_by_axis() && !textures;
        let variant = match (self.layout.planes, split) {
            (true, true) => Trace::OrientedSplit { surfaces, counters },
            (true, false) => Trace::Oriented { textures, surfaces, counters },
            (false, true) => Trace::Split { planes, lifted, surfaces, counters },
            (false, false) => Trace::Plain { textures, planes, lifted, surfaces, counters },
        };
        let search = self.search(job, &parameters, counting)?;
        let settings = uniform_buffer(gpu, "search", &search)?;
        let hit_buffer = hits.on_device(count)?;
        let mut bound = vec![(0, &settings), (1, job.rays.on_device()?), (2, hit_buffer)];
        if surfaces {
            bound.push((3, hits.surfaces_on_device(count)?));
        }
        bound.extend(counting.map(|counting| (4, &counting.buffer)));
        let bound: Vec<_> = bound.into_iter().map(|(at, buffer)| (at, buffer.as_entire_binding())).collect();
        let bind = |pipeline: &ComputePipeline, _| {
            let mut groups = vec![bind_group_at(gpu, &pipeline.get_bind_group_layout(0), &bound)];
            groups.push(bind_arrays(gpu, pipeline, &self.arrays.bound(reads_data)));
            if split {
                groups.push(bind_group(gpu, &pipeline.get_bind_group_layout(2), &further_axes(lists, reads_data)));
            }
            groups
        };
        let per_lane = search.rays_per_lane;
        let rays = SearchedRays { rays: job.rays, per_lane, hits: hit_buffer, left: Left::CutOff };
        pipelines.trace.record(gpu, variant, rays, bind, clock)
    }

    fn count(&self, job: &TraceJob<'_>, hits: &HitBuffer) -> Result<Vec<Counter>, TracerError> {
        let gpu = &*self.pipelines.gpu;
        let count = job.rays.host.len();
        let Some(lists) = &self.buffers.lists else {
            let counts = RayCounts::new(gpu, &["voxels_stepped"], count)?;
            untimed(gpu, |clock| self.record_voxels(job, hits, Some(counts.buffer()), clock))?;
            return counts.counters(gpu);
        };
        // Of nodes and of their data.
        let things = [u64::from(lists.nodes.capacity()); 2];
        let counting = TraceCounts::new(gpu, things, &COUNTERS, count, "--size or voxel-abuffer.abuffer")?;
        untimed(gpu, |clock| self.record(SearchJob { job, hits, counting: Some(&counting), clock }))?;
        let reads_data = self.reads_data(job.trace_to, &VoxelParameters::try_from(job.parameters)?);
        let mut counters = counting.counters(gpu, ["fragments_touched", "payloads_touched"])?;
        counters.retain(|counter| reads_data || counter.name != "payloads_touched");
        // Planes tell nothing inside from outside.
        counters.retain(|counter| !self.layout.planes || counter.name != "starts_inside");
        Ok(counters)
    }
}

/// The buffers of all axes but the first's, for variants that bind each axis'; a second half that does not exist is replaced by the
/// first, which nothing asks it for.
fn further_axes(lists: &Lists, reads_data: bool) -> Vec<BindingResource<'_>> {
    let [nodes, _] = lists.nodes.buffers();
    let mut all: Vec<&Buffer> = nodes[1..].to_vec();
    if reads_data {
        let data = (0..AXES).flat_map(|axis| [false, true].map(|further| lists.nodes.data_buffer(axis, further)));
        all.extend(data.skip(1));
    }
    all.into_iter().map(Buffer::as_entire_binding).collect()
}
