//! Tracing on the device.

use tracebench_api::wgpu::ComputePipeline;
use tracebench_api::{Counter, HitBuffer, Query, TraceJob, TraceTo, TracerError};
use tracebench_kit::{
    Left, MemoryAccess, RayCounts, Search, SearchJob, SearchedRays, TouchedBits, bind_arrays, bind_group,
    bind_group_at, uniform_buffer, untimed, view_uniforms,
};
use tracebench_shaders::dirt::Trace;

use crate::description::{Accept, CentreRays, DirtParameters, March, Searched};
use crate::fetch::lost;
use crate::layout::{MAX_VIEWS, TraceSettings};
use crate::structure::DirtStructure;

/// The buffers of a trace that counts.
pub(crate) struct Counting {
    counts: RayCounts,
    /// A bit a node.
    touched: TouchedBits,
}

/// What is counted of every ray, in the order of shaders/dirt/trace.wgsl.
const COUNTERS: [&str; 4] = ["pyramid_steps", "buckets_opened", "triangle_tests", "views_entered"];

impl DirtStructure {
    fn search(&self, job: &TraceJob<'_>, parameters: &DirtParameters) -> TraceSettings {
        TraceSettings {
            ray_count: job.rays.host.len() as u32,
            view_count: self.layout.views.len() as u32,
            any_hit: u32::from(job.rays.query == Query::Any),
            by_distance: u32::from(parameters.accept == Accept::Distance),
            all_buckets: u32::from(parameters.searched == Searched::All),
            max_steps: parameters.max_steps,
            top_level: match parameters.march {
                March::HiZ => self.layout.levels() as u32 - 1,
                March::Tiles => 0,
            },
            rays_per_lane: parameters.rays_per_lane,
        }
    }
}

impl Search for DirtStructure {
    type Counting = Counting;

    fn record(&self, search: SearchJob<'_, '_, Counting>) -> Result<(), TracerError> {
        let SearchJob { job, hits, counting, clock } = search;
        let gpu = &*self.pipelines.gpu;
        let parameters = DirtParameters::try_from(job.parameters)?;
        if let Some(map) = self.shadow_map.as_ref().filter(|map| map.answers(job)) {
            return self.pipelines.look_up(map, job, parameters.shadow_bias, hits, clock);
        }
        let search = self.search(job, &parameters);
        let (centres, counters) = (parameters.centre_rays == CentreRays::Split, counting.is_some());
        let variant = match self.memory_access() {
            MemoryAccess::Buffer if self.buffers.is_split() => Trace::Split { centres, counters },
            memory_access => Trace::Plain { textures: memory_access == MemoryAccess::Texture, centres, counters },
        };
        let [grid, search_settings, views] = [
            uniform_buffer(gpu, "grid", &self.buffers.grid(&self.layout))?,
            uniform_buffer(gpu, "search", &search)?,
            uniform_buffer(gpu, "views", &view_uniforms::<MAX_VIEWS>(self.layout.uniforms()))?,
        ];
        let hits_on_device = hits.on_device(job.rays.host.len())?;
        let uniforms = [(0, &grid), (1, &search_settings), (3, &views)];
        let answered = [(7, job.rays.on_device()?), (8, hits_on_device)];
        let counted = counting.map(|counting| [(9, counting.counts.buffer()), (10, counting.touched.buffer())]);
        let all = uniforms.into_iter().chain(answered).chain(counted.into_iter().flatten());
        let mut resources: Vec<_> = all.map(|(binding, buffer)| (binding, buffer.as_entire_binding())).collect();
        let split = matches!(variant, Trace::Split { .. });
        if split {
            resources.extend([(4, self.buffers.bounds_of(0)), (5, self.buffers.heads_of(0))]);
            resources.push((6, self.buffers.nodes[0].as_entire_binding()));
        }
        let bind = |pipeline: &ComputePipeline, _| {
            let mut groups = vec![bind_group_at(gpu, &pipeline.get_bind_group_layout(0), &resources)];
            groups.push(bind_arrays(gpu, pipeline, &self.arrays));
            if split {
                groups.push(bind_group(gpu, &pipeline.get_bind_group_layout(2), &self.buffers.further_parts()));
            }
            groups
        };
        let per_lane = search.rays_per_lane;
        let rays = SearchedRays { rays: job.rays, per_lane, hits: hits_on_device, left: Left::CutOff };
        self.pipelines.trace.record(gpu, variant, rays, bind, clock)?;
        self.record_surfaces(job, parameters.fetch, hits, clock)
    }

    fn count(&self, job: &TraceJob<'_>, hits: &HitBuffer) -> Result<Vec<Counter>, TracerError> {
        let gpu = &*self.pipelines.gpu;
        let counting = Counting {
            counts: RayCounts::new(gpu, &COUNTERS, job.rays.host.len())?,
            touched: TouchedBits::new(gpu, "nodes touched", u64::from(self.buffers.node_capacity), "--size")?,
        };
        untimed(gpu, |clock| self.record(SearchJob { job, hits, counting: Some(&counting), clock }))?;
        // A set that the shadow map answers searches nothing: a texel a ray is looked at.
        let mut counters = counting.counts.counters(gpu)?;
        if self.shadow_map.as_ref().is_some_and(|map| map.answers(job)) {
            counters.push(Counter::of_set("shadow_map_texels", job.rays.host.len() as u64));
        }
        counters.push(Counter::of_set("references_touched", counting.touched.count(gpu)?));
        if job.trace_to == TraceTo::Surface {
            counters.push(Counter::of_set("fetches_lost", lost(&hits.read_surfaces(Some(gpu))?)));
        }
        Ok(counters)
    }
}
