//! Tracing on the device.

use tracebench_api::wgpu::{BindingResource, Buffer, ComputePipeline};
use tracebench_api::{Counter, HitBuffer, ImageMarch, MarchSteps, Ray, TraceJob, TraceTo, TracerError};
use tracebench_kit::{
    Left, MemoryAccess, Search, SearchJob, SearchedRays, TraceCounts, bind_arrays, bind_group, bind_group_at,
    uniform_buffer, untimed,
};
use tracebench_shaders::fragment_abuffer::Trace;

use crate::description::{Coverage, FragmentParameters, Fragments, March, Span, Switch, ThicknessUnit};
use crate::layout::MAX_VIEWS;
use crate::structure::FragmentStructure;
pub(crate) use tracebench_shaders::fragment_abuffer::MarchSettings;

/// What is counted of every ray, as `COUNTS` in shaders/fragment-abuffer/trace.wgsl.
const COUNTERS: [&str; 6] =
    ["pixels_visited", "pixels_opened", "fragments_tested", "views_entered", "views_tested", "lists_visited"];

/// Where in its steps a ray looks at the image: `jitter_of` of shaders/fragment-abuffer/march.wgsl.
fn jitter_of(ray: &Ray) -> f64 {
    let hash = [ray.origin, ray.direction].as_flattened().iter().fold(0_u32, |hash, word| {
        let state = (hash ^ word.to_bits()).wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        let mixed = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
        (mixed >> 22) ^ mixed
    });
    f64::from(hash >> 8) / f64::from(1 << 24)
}

impl FragmentParameters {
    /// How rays are traced over the images; none where samples are no depths at pixels' centres.
    pub(crate) fn image_march(&self, diagonal: f64) -> Option<ImageMarch> {
        let (looks_at, within_pixel): (fn(&Ray) -> f64, _) = match self.jitter {
            Switch::On => (jitter_of, self.span == Span::Pixel),
            Switch::Off => (|_| 0.5, self.span == Span::Pixel),
        };
        let steps = match self.march {
            March::Steps => MarchSteps::Equal { most: self.view_steps, looks_at, within_pixel },
            March::Pixels | March::HiZ => MarchSteps::EveryPixel,
        };
        let [thickness, thickness_in_pixels] = match self.thickness_in {
            ThicknessUnit::Diagonals => [self.thickness * diagonal, 0.0],
            ThicknessUnit::Pixels => [0.0, self.thickness],
        };
        let start_bias = self.start_bias;
        let march = ImageMarch {
            steps,
            start_bias,
            thickness,
            thickness_in_pixels,
            to_back_faces: false,
            from_before: false,
            anywhere: false,
        };
        (self.fragments == Fragments::Points && self.coverage == Coverage::Sample).then_some(march)
    }
}

impl FragmentStructure {
    fn search(
        &self,
        job: &TraceJob<'_>,
        parameters: &FragmentParameters,
        counting: Option<&TraceCounts>,
    ) -> MarchSettings {
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
            rays_per_lane: parameters.rays_per_lane,
            touched_words: counting.map_or(0, |counting| counting.bit_words[0]),
        }
    }

    /// The buffers of all views but the first, for variants that bind each view's; places of views that do not exist are taken by
    /// one that does.
    fn further_views(&self, surfaces: bool) -> Vec<BindingResource<'_>> {
        let parts = (1..MAX_VIEWS).map(|view| self.parts.of_view(view));
        let data = parts.clone().filter(|_| surfaces).map(|part| part.data());
        let all = parts.clone().map(|part| &part.pixels).chain(parts.map(|part| &part.ids)).chain(data);
        all.map(Buffer::as_entire_binding).collect()
    }
}

impl Search for FragmentStructure {
    type Counting = TraceCounts;

    fn record(&self, search: SearchJob<'_, '_, TraceCounts>) -> Result<(), TracerError> {
        let SearchJob { job, hits, counting, clock } = search;
        // Any hit is the same march: its first hit is its nearest.
        let pipelines = &*self.pipelines;
        let gpu = &*pipelines.gpu;
        let (parts, count) = (&self.parts, job.rays.host.len());
        let (contiguous, planes) = (self.layout.kind.is_contiguous(), self.layout.planes);
        let textures = self.arrays.memory_access() == MemoryAccess::Texture;
        let (surfaces, counters) = (job.trace_to == TraceTo::Surface, counting.is_some());
        let split = parts.is_by_view() && !textures;
        let variant = match split {
            true => Trace::Split { contiguous, planes, surfaces, counters },
            false => Trace::Plain { textures, contiguous, planes, surfaces, counters },
        };
        let search = self.search(job, &FragmentParameters::try_from(job.parameters)?, counting);
        let first = parts.of_view(0);
        let [storage, settings, views] = [
            uniform_buffer(gpu, "storage", &self.layout.storage(first.pixel_count, first.capacity))?,
            uniform_buffer(gpu, "search", &search)?,
            uniform_buffer(gpu, "views", &self.layout.traced(&parts.placed()))?,
        ];
        let hit_buffer = hits.on_device(count)?;
        let mut bound = vec![(0, &storage), (1, &settings), (2, &views), (3, job.rays.on_device()?), (4, hit_buffer)];
        if surfaces {
            bound.push((5, hits.surfaces_on_device(count)?));
        }
        bound.extend(counting.map(|counting| (6, &counting.buffer)));
        let bound: Vec<_> = bound.into_iter().map(|(at, buffer)| (at, buffer.as_entire_binding())).collect();
        let bind = |pipeline: &ComputePipeline, _| {
            let mut groups = vec![bind_group_at(gpu, &pipeline.get_bind_group_layout(0), &bound)];
            groups.push(bind_arrays(gpu, pipeline, &self.arrays.bound(surfaces)));
            if split {
                groups.push(bind_group(gpu, &pipeline.get_bind_group_layout(2), &self.further_views(surfaces)));
            }
            groups
        };
        let per_lane = search.rays_per_lane;
        let rays = SearchedRays { rays: job.rays, per_lane, hits: hit_buffer, left: Left::CutOff };
        pipelines.traces.record(gpu, variant, rays, bind, clock)
    }

    fn count(&self, job: &TraceJob<'_>, hits: &HitBuffer) -> Result<Vec<Counter>, TracerError> {
        let gpu = &*self.pipelines.gpu;
        // Of nodes and of their data.
        let things = [self.parts.capacity(); 2];
        let counting =
            TraceCounts::new(gpu, things, &COUNTERS, job.rays.host.len(), "--size, --face-size or --frame-size")?;
        untimed(gpu, |clock| self.record(SearchJob { job, hits, counting: Some(&counting), clock }))?;
        let mut counters = counting.counters(gpu, ["fragments_touched", "payloads_touched"])?;
        counters.retain(|counter| job.trace_to == TraceTo::Surface || counter.name != "payloads_touched");
        Ok(counters)
    }
}
