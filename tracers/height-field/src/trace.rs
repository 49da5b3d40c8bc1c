//! Tracing on the device.

use bytemuck::{Pod, Zeroable};
use tracebench_api::wgpu::{BindingResource, Buffer};
use tracebench_api::{Counter, EndPoint, HitBuffer, MemoryEntry, PhaseClock, SharedLayout, TraceJob, TracerError};
use tracebench_kit::{
    CellDepths, PyramidLayout, RayCounts, Readable, Seen, SeenView, TouchedBits, ViewUniform, bind_arrays,
    bind_group_at, dispatch_rays, rays_within_rounds, uniform_buffer,
};
use tracebench_shaders::height_field::Trace;

use crate::description::HeightParameters;
use crate::structure::HeightFieldStructure;

/// `HeightSettings` of shaders/height-field/trace.wgsl.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct HeightSettings {
    ray_count: u32,
    refinement: u32,
    rays_per_lane: u32,
    row_words: u32,
    start_bias: f32,
    padding_a: u32,
    padding_b: u32,
    padding_c: u32,
}

/// Layouts of all that shaders share with this crate.
pub(crate) fn layouts() -> Vec<SharedLayout> {
    tracebench_api::layouts! {
        HeightSettings { ray_count, refinement, rays_per_lane, row_words, start_bias, padding_a, padding_b, padding_c }
    }
}

/// What a variant that counts writes to: two counts of every ray, and a bit a pixel and a cell.
struct Counting {
    of_rays: RayCounts<2>,
    touched: TouchedBits,
}

impl HeightFieldStructure {
    fn settings(&self, job: &TraceJob<'_>) -> Result<HeightSettings, TracerError> {
        let parameters = HeightParameters::try_from(job.parameters)?;
        // A ray crosses no more pixels than a frame has columns and rows, and goes no oftener down than up, but for the first time.
        let crossed: u64 = self.view.size.map(u64::from).iter().sum();
        let levels = u64::from(self.heights.pyramid.shape().layout().levels);
        let most_rounds = 2 * crossed + levels + u64::from(parameters.refinement);
        Ok(HeightSettings {
            ray_count: job.rays.host.len() as u32,
            refinement: parameters.refinement,
            rays_per_lane: rays_within_rounds(parameters.rays_per_lane, most_rounds),
            row_words: self.heights.copy.as_ref().map_or(0, |copy| copy.row_words()),
            start_bias: parameters.start_bias as f32,
            padding_a: 0,
            padding_b: 0,
            padding_c: 0,
        })
    }

    /// The uniforms of a trace.
    pub(crate) fn uniforms() -> Vec<MemoryEntry> {
        let all = [
            ("view", size_of::<ViewUniform>()),
            ("settings", size_of::<HeightSettings>()),
            ("pyramid layout", size_of::<PyramidLayout>()),
        ];
        all.map(|(name, bytes)| MemoryEntry::whole(name, bytes as u64)).to_vec()
    }

    /// Records the trace.
    pub(crate) fn record(
        &self,
        job: &TraceJob<'_>,
        hits: &HitBuffer,
        counting: Option<[&Buffer; 2]>,
        clock: &mut PhaseClock<'_>,
    ) -> Result<(), TracerError> {
        match job.end {
            EndPoint::Hit => self.search(job, hits, counting, None, clock),
            EndPoint::Surface => {
                let count = job.rays.host.len();
                hits.surfaces_on_device(count)?;
                let (gpu, raster) = (&*self.pipelines.gpu, &self.pipelines.seen);
                let view = SeenView {
                    drawn_by: self.drawn_by,
                    view: &self.view,
                    geometry: &self.geometry,
                    triangle_count: self.triangle_count,
                    target: &self.heights.target,
                    layers: 1,
                    separation: 0.0,
                };
                let seen = raster.draw(gpu, view, count, clock)?;
                self.primitive_texture.replace(Some(seen.primitives.memory.clone()));
                self.search(job, hits, counting, Some(&seen), clock)?;
                raster.gather(gpu, &self.geometry, job.rays, hits, &seen, clock)
            }
        }
    }

    /// Records the search, by the counting variant where there is something to count into; `seen` is what rays see of triangles.
    fn search(
        &self,
        job: &TraceJob<'_>,
        hits: &HitBuffer,
        counting: Option<[&Buffer; 2]>,
        seen: Option<&Seen>,
        clock: &mut PhaseClock<'_>,
    ) -> Result<(), TracerError> {
        let gpu = &self.pipelines.gpu;
        let heights = &self.heights;
        let (textures, min_max) = (heights.copy.is_none(), heights.pyramid.shape().depths == CellDepths::NearFar);
        let variant = Trace { textures, min_max, surfaces: seen.is_some(), counters: counting.is_some() };
        let pipeline = self.pipelines.trace.of(gpu, variant)?;
        let view = uniform_buffer(gpu, "view", &ViewUniform::from(&self.view))?;
        let settings = self.settings(job)?;
        let settings_buffer = uniform_buffer(gpu, "settings", &settings)?;
        let layout = uniform_buffer(gpu, "pyramid layout", &heights.pyramid.shape().layout())?;
        let mut resources = vec![
            (0, view.as_entire_binding()),
            (1, settings_buffer.as_entire_binding()),
            (3, job.rays.on_device()?.as_entire_binding()),
            (4, hits.on_device(job.rays.host.len())?.as_entire_binding()),
            (9, layout.as_entire_binding()),
        ];
        if textures {
            resources.push((2, BindingResource::TextureView(&heights.target.eye_depth)));
        }
        if let Some([of_rays, touched]) = counting {
            resources.extend([(5, of_rays.as_entire_binding()), (6, touched.as_entire_binding())]);
        }
        if let Some(Seen { primitives, triangles }) = seen {
            let primitives = BindingResource::TextureView(&primitives.view);
            resources.extend([(7, primitives), (8, triangles.as_entire_binding())]);
        }
        let bindings = bind_group_at(gpu, &pipeline.get_bind_group_layout(0), &resources);
        let arrays: Vec<Readable> =
            heights.copy.iter().map(|copy| copy.array()).chain([heights.pyramid.array()]).cloned().collect();
        let arrays = bind_arrays(gpu, &pipeline, &arrays);
        clock.device_phase("search", |encoder| {
            let bindings = [&bindings, &arrays];
            dispatch_rays(encoder, &pipeline, &bindings, settings.ray_count, settings.rays_per_lane);
        })
    }

    /// Traces by the counting variant.
    pub(crate) fn count(&self, job: &TraceJob<'_>, hits: &HitBuffer) -> Result<Vec<Counter>, TracerError> {
        let gpu = &self.pipelines.gpu;
        let [width, height] = self.view.size.map(u64::from);
        let cells = width * height + self.heights.pyramid.shape().cells();
        let counting = Counting {
            of_rays: RayCounts::new(gpu, "cell counts", job.rays.host.len())?,
            touched: TouchedBits::new(gpu, "cells touched", cells, "--frame")?,
        };
        let mut clock = PhaseClock::new(Some(gpu));
        self.record(job, hits, Some([counting.of_rays.buffer(), counting.touched.buffer()]), &mut clock)?;
        clock.finish()?;
        let mut counters = counting.of_rays.counters(gpu, ["cells_visited", "depth_samples"])?;
        counters.push(Counter::of_set("cells_touched", counting.touched.count(gpu)?));
        Ok(counters)
    }
}
