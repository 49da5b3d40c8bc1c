//! Tracing on the device.

use bytemuck::{Pod, Zeroable};
use tracebench_api::wgpu::{BindingResource, Buffer};
use tracebench_api::{Counter, EndPoint, HitBuffer, PhaseClock, TraceJob, TracerError};
use tracebench_kit::{RayCounts, TouchedBits, bind_group, bind_group_at, dispatch_linear_groups, uniform_buffer};
use tracebench_shaders::fragment_abuffer::Trace;

use crate::build::WORKGROUP_SIZE;
use crate::description::{FragmentParameters, Span, Switch, ThicknessUnit};
use crate::layout::MOST_VIEWS;
use crate::structure::FragmentStructure;

/// As `COUNTS` in shaders/fragment-abuffer/trace.wgsl.
const COUNTERS: [&str; 6] =
    ["pixels_visited", "pixels_opened", "fragments_tested", "views_entered", "views_tested", "lists_visited"];

/// `MarchSettings` of shaders/fragment-abuffer/store.wgsl.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct MarchSettings {
    /// Rays.
    pub ray_count: u32,
    /// Views.
    pub view_count: u32,
    /// 0: a number of steps a view, 1: every pixel, 2: up and down the pyramid.
    pub march: u32,
    /// Steps a view.
    pub steps: u32,
    /// Steps after which a ray is given up.
    pub max_steps: u32,
    /// 1: steps look at their middle.
    pub centred: u32,
    /// 1: a step asks for depths within its pixel alone.
    pub span_by_pixel: u32,
    /// Fragments beyond which a piece of the s-buffer is searched by halving.
    pub binary_search_above: u32,
    /// Scene units; below 0 before a fragment's depth, not behind it.
    pub thickness: f32,
    /// Widths of a pixel; so, too.
    pub thickness_in_pixels: f32,
    /// Pixels along the major axis.
    pub start_bias: f32,
    /// 1: pixels whose depth bounds the ray misses are skipped.
    pub skip_bounds: u32,
    /// 1: buckets that the ray does not meet are skipped.
    pub skip_buckets: u32,
    /// 1: lists are left where their fragments lie beyond the ray.
    pub skip_lists: u32,
    /// Nothing.
    pub padding_a: u32,
    /// Nothing.
    pub padding_b: u32,
}

/// The buffers of a trace that counts.
pub(crate) struct Counting {
    counts: RayCounts<6>,
    touched: TouchedBits,
    payloads_touched: TouchedBits,
}

impl FragmentStructure {
    fn search(&self, job: &TraceJob<'_>, parameters: &FragmentParameters) -> MarchSettings {
        let by_pixels = parameters.thickness_in == ThicknessUnit::Pixels;
        let thickness = parameters.thickness;
        MarchSettings {
            ray_count: job.rays.host.len() as u32,
            view_count: self.layout.views.len() as u32,
            march: parameters.march as u32,
            steps: parameters.view_steps,
            max_steps: parameters.max_steps,
            centred: u32::from(parameters.jitter == Switch::Off),
            span_by_pixel: u32::from(parameters.span == Span::Pixel),
            binary_search_above: parameters.binary_search_above,
            thickness: if by_pixels { 0.0 } else { (thickness * self.diagonal) as f32 },
            thickness_in_pixels: if by_pixels { thickness as f32 } else { 0.0 },
            start_bias: parameters.start_bias as f32,
            skip_bounds: u32::from(parameters.skip_bounds == Switch::On),
            skip_buckets: u32::from(parameters.skip_buckets == Switch::On),
            skip_lists: u32::from(parameters.skip_lists == Switch::On),
            padding_a: 0,
            padding_b: 0,
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
        let pipelines = &*self.pipelines;
        let gpu = &*pipelines.gpu;
        let (parts, count) = (&self.parts, job.rays.host.len());
        let variant = Trace {
            contiguous: self.layout.kind.is_contiguous(),
            split: parts.is_by_view(),
            surfaces: job.end == EndPoint::Surface,
            counters: counting.is_some(),
        };
        let pipeline = pipelines.traces.of(gpu, variant)?;
        let search = self.search(job, &FragmentParameters::try_from(job.parameters)?);
        let first = parts.of_view(0);
        let [storage, settings, views] = [
            uniform_buffer(gpu, "storage", &self.layout.storage(first.pixel_count, first.capacity))?,
            uniform_buffer(gpu, "search", &search)?,
            uniform_buffer(gpu, "views", &self.layout.traced(&parts.placed()))?,
        ];
        let pyramid = parts.pyramid.as_ref().unwrap_or(&first.pixels);
        let mut bound = vec![
            (0, &storage),
            (1, &settings),
            (2, &views),
            (3, job.rays.on_device()?),
            (4, hits.on_device(count)?),
            (5, &first.pixels),
            (6, &first.ids),
            (7, pyramid),
        ];
        if variant.surfaces {
            bound.extend([(8, first.data()), (9, hits.surfaces_on_device(count)?)]);
        }
        if let Some(counting) = counting {
            bound.extend([(10, counting.counts.buffer()), (11, counting.touched.buffer())]);
            bound.extend(variant.surfaces.then(|| (12, counting.payloads_touched.buffer())));
        }
        let numbered: Vec<_> = bound.into_iter().map(|(at, buffer)| (at, buffer.as_entire_binding())).collect();
        let mut bindings = vec![bind_group_at(gpu, &pipeline.get_bind_group_layout(0), &numbered)];
        if variant.split {
            let further = self.further_views(variant.surfaces);
            bindings.push(bind_group(gpu, &pipeline.get_bind_group_layout(1), &further));
        }
        let bindings: Vec<_> = bindings.iter().collect();
        clock.device_phase("trace", |encoder| {
            dispatch_linear_groups(encoder, &pipeline, &bindings, search.ray_count, WORKGROUP_SIZE);
        })
    }

    /// The buffers of all views but the first, for variants that bind each view's; places of views that do not exist are taken by
    /// one that does.
    fn further_views(&self, surfaces: bool) -> Vec<BindingResource<'_>> {
        let parts = (1..MOST_VIEWS).map(|view| self.parts.of_view(view));
        let data = parts.clone().filter(|_| surfaces).map(|part| part.data());
        let all = parts.clone().map(|part| &part.pixels).chain(parts.map(|part| &part.ids)).chain(data);
        all.map(Buffer::as_entire_binding).collect()
    }

    pub(crate) fn count(&self, job: &TraceJob<'_>, hits: &HitBuffer) -> Result<Vec<Counter>, TracerError> {
        let gpu = &*self.pipelines.gpu;
        let nodes = self.parts.capacity();
        let touched = |name| TouchedBits::new(gpu, name, nodes, "--face or --frame");
        let counting = Counting {
            counts: RayCounts::new(gpu, "counts", job.rays.host.len())?,
            touched: touched("fragments touched")?,
            payloads_touched: touched("payloads touched")?,
        };
        let mut clock = PhaseClock::new(Some(gpu));
        self.record(job, hits, Some(&counting), &mut clock)?;
        clock.finish()?;
        let mut counters = counting.counts.counters(gpu, COUNTERS)?;
        counters.push(Counter::of_set("fragments_touched", counting.touched.count(gpu)?));
        if job.end == EndPoint::Surface {
            counters.push(Counter::of_set("payloads_touched", counting.payloads_touched.count(gpu)?));
        }
        Ok(counters)
    }
}
