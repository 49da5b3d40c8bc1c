//! Tracing on the device.

use tracebench_api::wgpu::Buffer;
use tracebench_api::{Counter, EndPoint, HitBuffer, PhaseClock, Query, TraceJob, TracerError};
use tracebench_kit::{RayCounts, TouchedBits, ViewUniform, bind_group, dispatch_linear_groups, uniform_buffer};
use tracebench_shaders::dirt::Trace;

use crate::description::{Accept, CentreRays, DirtParameters, March, Searched};
use crate::fetch::lost;
use crate::layout::{MOST_VIEWS, TraceSettings};
use crate::structure::DirtStructure;

/// As `WORKGROUP_SIZE` in shaders/dirt/trace.wgsl.
const WORKGROUP_SIZE: u32 = 64;

/// The buffers of a trace that counts.
struct Counting {
    counts: RayCounts<4>,
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
            padding: 0,
        }
    }

    /// Records a trace, by the counting variant where there is something to count into.
    fn record(
        &self,
        job: &TraceJob<'_>,
        hits: &HitBuffer,
        counting: Option<&Counting>,
        clock: &mut PhaseClock<'_>,
    ) -> Result<(), TracerError> {
        let gpu = &*self.pipelines.gpu;
        let parameters = DirtParameters::try_from(job.parameters)?;
        let search = self.search(job, &parameters);
        let (centres, counters) = (parameters.centre_rays == CentreRays::Split, counting.is_some());
        let split = self.buffers.is_split();
        let pipeline = self.pipelines.trace(Trace { split, centres, counters })?;
        let (bounds, heads) = match split {
            false => (self.buffers.bounds.as_entire_binding(), self.buffers.heads.as_entire_binding()),
            true => (self.buffers.bounds_of(0), self.buffers.heads_of(0)),
        };
        let [grid, search_settings, views] = [
            uniform_buffer(gpu, "grid", &self.buffers.grid(&self.layout))?,
            uniform_buffer(gpu, "search", &search)?,
            uniform_buffer(gpu, "views", &ViewUniform::array::<MOST_VIEWS>(self.layout.uniforms()))?,
        ];
        let shared = [&grid, &search_settings, self.buffers.setup.vertices(), &views];
        let answered = [&self.buffers.nodes[0], job.rays.on_device()?, hits.on_device(job.rays.host.len())?];
        let counted = counting.map(|counting| [counting.counts.buffer(), counting.touched.buffer()]);
        let resources: Vec<_> = (shared.into_iter().map(Buffer::as_entire_binding))
            .chain([bounds, heads])
            .chain(answered.into_iter().chain(counted.into_iter().flatten()).map(Buffer::as_entire_binding))
            .collect();
        let mut bindings = vec![bind_group(gpu, &pipeline.get_bind_group_layout(0), &resources)];
        if split {
            bindings.push(bind_group(gpu, &pipeline.get_bind_group_layout(1), &self.buffers.further_parts()));
        }
        let bindings: Vec<_> = bindings.iter().collect();
        clock.device_phase("trace", |encoder| {
            dispatch_linear_groups(encoder, &pipeline, &bindings, search.ray_count, WORKGROUP_SIZE);
        })?;
        self.record_surfaces(job, parameters.fetch, hits, clock)
    }

    pub(crate) fn trace_hits(
        &self,
        job: &TraceJob<'_>,
        hits: &HitBuffer,
        clock: &mut PhaseClock<'_>,
    ) -> Result<(), TracerError> {
        self.record(job, hits, None, clock)
    }

    pub(crate) fn count(&self, job: &TraceJob<'_>, hits: &HitBuffer) -> Result<Vec<Counter>, TracerError> {
        let gpu = &*self.pipelines.gpu;
        let counting = Counting {
            counts: RayCounts::new(gpu, "counts", job.rays.host.len())?,
            touched: TouchedBits::new(gpu, "nodes touched", u64::from(self.buffers.node_capacity), "--size")?,
        };
        let mut clock = PhaseClock::new(Some(gpu));
        self.record(job, hits, Some(&counting), &mut clock)?;
        clock.finish()?;
        let mut counters = counting.counts.counters(gpu, COUNTERS)?;
        counters.push(Counter::of_set("references_touched", counting.touched.count(gpu)?));
        if job.end == EndPoint::Surface {
            counters.push(Counter::of_set("fetches_lost", lost(&hits.read_surfaces(Some(gpu))?)));
        }
        Ok(counters)
    }
}
