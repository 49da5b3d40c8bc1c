//! Tracing on the device.

use tracebench_api::wgpu::{Buffer, BufferUsages};
use tracebench_api::{Counter, EndPoint, HitBuffer, PhaseClock, Query, TraceJob, TracerError};
use tracebench_kit::{bind_group, dispatch_linear_groups};

use crate::build::{TraceKind, view_uniforms};
use crate::description::{Accept, CentreRays, DirtParameters, Searched};
use crate::fetch::lost;
use crate::layout::TraceSettings;
use crate::structure::DirtStructure;

/// As `WORKGROUP_SIZE` in shaders/dirt/trace.wgsl.
const WORKGROUP_SIZE: u32 = 64;

/// The buffers of a trace that counts.
struct Counting {
    /// Four counts a ray.
    counts: Buffer,
    /// A bit a node.
    touched: Buffer,
}

impl DirtStructure {
    fn search(&self, job: &TraceJob<'_>, parameters: &DirtParameters) -> TraceSettings {
        TraceSettings {
            ray_count: job.rays.host.len() as u32,
            view_count: self.layout.views.len() as u32,
            any_hit: u32::from(job.rays.query == Query::Any),
            by_distance: u32::from(parameters.accept == Accept::Distance),
            all_buckets: u32::from(parameters.searched == Searched::All),
            max_steps: parameters.max_steps,
            padding: [0; 2],
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
        let uniform = |name, contents: &[u8]| gpu.buffer_with(name, contents, BufferUsages::UNIFORM, "nothing");
        let parameters = DirtParameters::try_from(job.parameters)?;
        let search = self.search(job, &parameters);
        let grid = self.buffers.grid(&self.layout);
        let kind = match (parameters.centre_rays, self.buffers.is_split()) {
            (CentreRays::Split, _) => TraceKind::Centres,
            (_, true) => TraceKind::Split,
            _ => TraceKind::Whole,
        };
        let pipeline = self.pipelines.trace(kind, counting.is_some());
        let (bounds, heads) = match kind {
            TraceKind::Whole => (self.buffers.bounds.as_entire_binding(), self.buffers.heads.as_entire_binding()),
            TraceKind::Split | TraceKind::Centres => (self.buffers.bounds_of(0), self.buffers.heads_of(0)),
        };
        let [grid, search_settings, views] = [
            uniform("grid", bytemuck::bytes_of(&grid))?,
            uniform("search", bytemuck::bytes_of(&search))?,
            uniform("views", bytemuck::bytes_of(&view_uniforms(&self.layout)))?,
        ];
        let geometry = &self.geometry.surfaces.device;
        let shared = [&grid, &search_settings, &views, &geometry.positions, &geometry.indices];
        let answered = [&self.buffers.nodes[0], job.rays.on_device()?, hits.on_device(job.rays.host.len())?];
        let counted = counting.map(|counting| [&counting.counts, &counting.touched]);
        let resources: Vec<_> = (shared.into_iter().map(Buffer::as_entire_binding))
            .chain([bounds, heads])
            .chain(answered.into_iter().chain(counted.into_iter().flatten()).map(Buffer::as_entire_binding))
            .collect();
        let mut bindings = vec![bind_group(gpu, &pipeline.get_bind_group_layout(0), &resources)];
        if kind != TraceKind::Whole {
            bindings.push(bind_group(gpu, &pipeline.get_bind_group_layout(1), &self.buffers.further_parts()));
        }
        let bindings: Vec<_> = bindings.iter().collect();
        clock.device_phase("trace", |encoder| {
            dispatch_linear_groups(encoder, pipeline, &bindings, search.ray_count, WORKGROUP_SIZE);
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
        let rays = job.rays.host.len();
        let storage = |name, bytes: u64| {
            gpu.check_storage_binding(name, bytes, "--size")?;
            gpu.buffer(name, bytes, BufferUsages::STORAGE | BufferUsages::COPY_SRC, "--size")
        };
        let count_bytes = rays.max(1) as u64 * 16;
        let touched_bytes = u64::from(self.buffers.node_capacity).div_ceil(32).max(1) * 4;
        let counting =
            Counting { counts: storage("counts", count_bytes)?, touched: storage("nodes touched", touched_bytes)? };
        let mut clock = PhaseClock::new(Some(gpu));
        self.record(job, hits, Some(&counting), &mut clock)?;
        clock.finish()?;
        let counts: Vec<[u32; 4]> = bytemuck::pod_collect_to_vec(&gpu.read(&counting.counts, count_bytes)?);
        let touched: Vec<u32> = bytemuck::pod_collect_to_vec(&gpu.read(&counting.touched, touched_bytes)?);
        let of = |name, index: usize| Counter::of(name, counts[..rays].iter().map(|count| u64::from(count[index])));
        let touched = touched.iter().map(|word| u64::from(word.count_ones())).sum();
        let mut counters = vec![
            of("pyramid_steps", 0),
            of("buckets_opened", 1),
            of("triangle_tests", 2),
            of("views_entered", 3),
            Counter::of_set("references_touched", touched),
        ];
        if job.end == EndPoint::Surface {
            counters.push(Counter::of_set("fetches_lost", lost(&hits.read_surfaces(Some(gpu))?)));
        }
        Ok(counters)
    }
}
