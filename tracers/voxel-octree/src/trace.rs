//! Tracing on the device.

use tracebench_api::{Counter, HitBuffer, TraceJob, TraceTo, TracerError};
use tracebench_kit::{
    MemoryAccess, Search, SearchJob, TraceCounts, bind_arrays, bind_group_at, dispatch_rays, rays_within_rounds,
    uniform_buffer, untimed,
};
use tracebench_shaders::voxel_octree::Trace;

use crate::description::{OctreeParameters, Traversal};
use crate::layout::Layout;
use crate::structure::OctreeStructure;

/// What is counted of every ray, as `COUNTS` in shaders/voxel-octree/trace.wgsl.
const COUNTERS: [&str; 2] = ["nodes_visited", "steps"];

/// Rounds of loops that a ray takes at most, and eight that run together: as many steps as there are voxels along all three axes, each with
/// the way down from the root. Off a stack ways down are shorter, but not those of all eight at once.
fn max_rounds(layout: &Layout) -> u64 {
    3 * u64::from(layout.edge()) * u64::from(layout.levels + 1)
}

impl Search for OctreeStructure {
    type Counting = TraceCounts;

    fn record(&self, search: SearchJob<'_, '_, TraceCounts>) -> Result<(), TracerError> {
        let SearchJob { job, hits, counting, clock } = search;
        let gpu = &*self.kernels.gpu;
        let parameters = OctreeParameters::try_from(job.parameters)?;
        let count = job.rays.host.len();
        let surfaces = job.trace_to == TraceTo::Surface;
        let variant = Trace {
            textures: self.arrays[0].memory_access() == MemoryAccess::Texture,
            stack: parameters.traversal == Traversal::Stack,
            surfaces,
            counters: counting.is_some(),
        };
        let rays_per_lane = rays_within_rounds(parameters.rays_per_lane, max_rounds(&self.layout));
        let mut search = self.layout.search(job, &parameters, rays_per_lane);
        if let Some(TraceCounts { bit_words: [nodes, leaves], .. }) = counting {
            (search.touched_words, search.first_leaf_bit) = (nodes + leaves, nodes * 32);
        }
        let settings = uniform_buffer(gpu, "search", &search)?;
        let mut bound = vec![(0, &settings), (1, job.rays.on_device()?), (2, hits.on_device(count)?)];
        if surfaces {
            bound.push((3, hits.surfaces_on_device(count)?));
        }
        bound.extend(counting.map(|counting| (4, &counting.buffer)));
        let bound: Vec<_> = bound.into_iter().map(|(at, buffer)| (at, buffer.as_entire_binding())).collect();
        let pipeline = self.kernels.trace.of(gpu, variant)?;
        let own = bind_group_at(gpu, &pipeline.get_bind_group_layout(0), &bound);
        let read = if surfaces { &self.arrays[..] } else { &self.arrays[..1] };
        let arrays = bind_arrays(gpu, &pipeline, read);
        clock.device_phase("trace", |encoder| {
            dispatch_rays(encoder, &pipeline, &[&own, &arrays], job.rays, search.rays_per_lane);
        })
    }

    fn count(&self, job: &TraceJob<'_>, hits: &HitBuffer) -> Result<Vec<Counter>, TracerError> {
        let gpu = &*self.kernels.gpu;
        let (room, levels) = (&self.tree.room, self.layout.levels);
        let things = [room.nodes_before(levels), room.leaves(levels)].map(u64::from);
        let counting = TraceCounts::new(gpu, things, &COUNTERS, job.rays.host.len(), "--size or voxel-octree.levels")?;
        untimed(gpu, |clock| self.record(SearchJob { job, hits, counting: Some(&counting), clock }))?;
        counting.counters(gpu, ["nodes_touched", "leaves_touched"])
    }
}
