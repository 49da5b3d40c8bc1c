//! Tracing on the device.

use bytemuck::{Pod, Zeroable};
use tracebench_api::wgpu::{BindingResource, Buffer};
use tracebench_api::{Counter, EndPoint, HitBuffer, MemoryEntry, PhaseClock, SharedLayout, TraceJob, TracerError};
use tracebench_kit::{
    DepthPyramid, PyramidLayout, RayCounts, Readable, Seen, SeenView, TouchedBits, ViewUniform, bind_arrays,
    bind_group_at, dispatch_rays, rays_within_rounds, uniform_buffer,
};
use tracebench_shaders::screen_dda::Trace;

use crate::description::DdaParameters;
use crate::structure::ScreenDdaStructure;

/// `Settings` of shaders/screen-dda/trace.wgsl.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct Settings {
    ray_count: u32,
    max_steps: u32,
    hit_point: u32,
    stride: f32,
    thickness: f32,
    start_bias: f32,
    rays_per_lane: u32,
    row_words: u32,
    image_words: u32,
    layers: u32,
    backs: u32,
    padding: u32,
}

/// Layouts of all that shaders share with this crate.
pub(crate) fn layouts() -> Vec<SharedLayout> {
    tracebench_api::layouts! {
        Settings {
            ray_count, max_steps, hit_point, stride, thickness, start_bias, rays_per_lane, row_words, image_words, layers, backs,
            padding,
        }
    }
}

/// What a variant that counts writes to: counts of every ray, and a bit a pixel.
#[derive(Clone, Copy)]
struct Counting<'a> {
    of_rays: &'a Buffer,
    touched: &'a Buffer,
}

impl ScreenDdaStructure {
    fn settings(&self, job: &TraceJob<'_>) -> Result<Settings, TracerError> {
        let parameters = DdaParameters::try_from(job.parameters)?;
        // A walk along the major axis, and the turn itself.
        let longest = self.view.size.into_iter().max().unwrap_or(1).div_ceil(parameters.stride) + 3;
        let samples = u64::from(longest.min(parameters.max_steps) + 1);
        let hi_z = self.images.pyramid.is_some();
        // Of a pyramid cells are asked, too: a ray goes up after a sample or a skip alone, and no oftener down than up.
        let turns = if hi_z { 2 * samples } else { samples };
        let over_layers = if hi_z || self.images.shape.images() > 1 { u64::from(self.images.shape.layers) } else { 0 };
        let copy = self.images.copy.as_ref();
        Ok(Settings {
            ray_count: job.rays.host.len() as u32,
            max_steps: parameters.max_steps,
            hit_point: parameters.hit_point as u32,
            stride: parameters.stride as f32,
            thickness: (parameters.thickness * self.diagonal) as f32,
            start_bias: parameters.start_bias as f32,
            rays_per_lane: rays_within_rounds(parameters.rays_per_lane, turns * (1 + over_layers)),
            row_words: copy.map_or(0, |copy| copy.row_words()),
            image_words: copy.map_or(0, |copy| copy.image_words()),
            layers: self.images.shape.layers,
            backs: u32::from(self.images.shape.backs),
            padding: 0,
        })
    }

    /// The uniforms of a trace.
    pub(crate) fn uniforms(&self) -> Vec<MemoryEntry> {
        let mut all = vec![("view", size_of::<ViewUniform>()), ("settings", size_of::<Settings>())];
        if self.images.pyramid.is_some() {
            all.push(("pyramid layout", size_of::<PyramidLayout>()));
        }
        all.into_iter().map(|(name, bytes)| MemoryEntry::whole(name, bytes as u64)).collect()
    }

    /// Records the trace.
    pub(crate) fn record(
        &self,
        job: &TraceJob<'_>,
        hits: &HitBuffer,
        counting: Option<[&Buffer; 2]>,
        clock: &mut PhaseClock<'_>,
    ) -> Result<(), TracerError> {
        let counting = counting.map(|[of_rays, touched]| Counting { of_rays, touched });
        match job.end {
            EndPoint::Hit => self.march(job, hits, counting, None, clock),
            EndPoint::Surface => {
                let count = job.rays.host.len();
                hits.surfaces_on_device(count)?;
                let (gpu, raster) = (&*self.pipelines.gpu, &self.pipelines.seen);
                let shape = &self.images.shape;
                let view = SeenView {
                    drawn_by: shape.drawn_by,
                    view: &self.view,
                    geometry: &self.geometry,
                    triangle_count: self.triangle_count,
                    target: &self.images.target,
                    layers: shape.layers,
                    separation: (shape.separation * self.diagonal) as f32,
                };
                let seen = raster.draw(gpu, view, count, clock)?;
                self.primitive_texture.replace(Some(seen.primitives.memory.clone()));
                self.march(job, hits, counting, Some(&seen), clock)?;
                raster.gather(gpu, &self.geometry, job.rays, hits, &seen, clock)
            }
        }
    }

    /// Records the march, by the counting variant where there is something to count into; `seen` is what rays see of triangles.
    fn march(
        &self,
        job: &TraceJob<'_>,
        hits: &HitBuffer,
        counting: Option<Counting<'_>>,
        seen: Option<&Seen>,
        clock: &mut PhaseClock<'_>,
    ) -> Result<(), TracerError> {
        let gpu = &self.pipelines.gpu;
        let images = &self.images;
        let (textures, deep) = (images.copy.is_none(), images.shape.images() > 1);
        let (hi_z, surfaces, counters) = (images.pyramid.is_some(), seen.is_some(), counting.is_some());
        let pipeline = self.pipelines.trace.of(gpu, Trace { textures, deep, hi_z, surfaces, counters })?;
        let view = uniform_buffer(gpu, "view", &ViewUniform::from(&self.view))?;
        let settings = self.settings(job)?;
        let settings_buffer = uniform_buffer(gpu, "settings", &settings)?;
        let layout = |pyramid: &DepthPyramid| uniform_buffer(gpu, "pyramid layout", &pyramid.shape().layout());
        let layout = images.pyramid.as_ref().map(layout).transpose()?;
        let mut resources = vec![
            (0, view.as_entire_binding()),
            (1, settings_buffer.as_entire_binding()),
            (3, job.rays.on_device()?.as_entire_binding()),
            (4, hits.on_device(job.rays.host.len())?.as_entire_binding()),
        ];
        if textures {
            let depths = if deep { &images.target.all } else { &images.target.eye_depth };
            resources.push((2, BindingResource::TextureView(depths)));
        }
        if let Some(Counting { of_rays, touched }) = counting {
            resources.extend([(5, of_rays.as_entire_binding()), (6, touched.as_entire_binding())]);
        }
        if let Some(Seen { primitives, triangles }) = seen {
            let primitives = if deep { &primitives.all } else { &primitives.view };
            resources.extend([(7, BindingResource::TextureView(primitives)), (8, triangles.as_entire_binding())]);
        }
        resources.extend(layout.as_ref().map(|layout| (9, layout.as_entire_binding())));
        let bindings = bind_group_at(gpu, &pipeline.get_bind_group_layout(0), &resources);
        let arrays: Vec<Readable> = images
            .copy
            .iter()
            .map(|copy| copy.array().clone())
            .chain(images.pyramid.iter().map(|pyramid| pyramid.array().clone()))
            .collect();
        let arrays = (!arrays.is_empty()).then(|| bind_arrays(gpu, &pipeline, &arrays));
        let bindings: Vec<_> = std::iter::once(&bindings).chain(&arrays).collect();
        clock.device_phase("march", |encoder| {
            dispatch_rays(encoder, &pipeline, &bindings, settings.ray_count, settings.rays_per_lane);
        })
    }

    /// Traces by the counting variant.
    pub(crate) fn count(&self, job: &TraceJob<'_>, hits: &HitBuffer) -> Result<Vec<Counter>, TracerError> {
        if self.images.pyramid.is_some() {
            return self.count_as(job, hits, ["depth_samples", "cells_visited"]);
        }
        self.count_as(job, hits, ["depth_samples"])
    }

    fn count_as<const N: usize>(
        &self,
        job: &TraceJob<'_>,
        hits: &HitBuffer,
        names: [&'static str; N],
    ) -> Result<Vec<Counter>, TracerError> {
        let gpu = &self.pipelines.gpu;
        let counts = RayCounts::<N>::new(gpu, "depth sample counts", job.rays.host.len())?;
        let [width, height] = self.view.size.map(u64::from);
        let touched = TouchedBits::new(gpu, "pixels touched", width * height, "--frame")?;
        let mut clock = PhaseClock::new(Some(gpu));
        self.record(job, hits, Some([counts.buffer(), touched.buffer()]), &mut clock)?;
        clock.finish()?;
        let mut counters = counts.counters(gpu, names)?;
        counters.push(Counter::of_set("pixels_touched", touched.count(gpu)?));
        Ok(counters)
    }
}
