//! Tracing on the device.

use bytemuck::{Pod, Zeroable};
use tracebench_api::wgpu::Buffer;
use tracebench_api::{Counter, EndPoint, HitBuffer, PhaseClock, SharedLayout, TraceJob, TracerError};
use tracebench_kit::{CellDepths, ImageSearch, RayCounts, TouchedBits, rays_within_rounds, untimed};
use tracebench_shaders::height_field::Trace;

use crate::description::HeightParameters;
use crate::structure::HeightFieldStructure;

/// `HeightSettings` of shaders/height-field/trace.wgsl.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct HeightSettings {
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

impl HeightFieldStructure {
    fn settings(&self, job: &TraceJob<'_>) -> Result<HeightSettings, TracerError> {
        let parameters = HeightParameters::try_from(job.parameters)?;
        let images = &self.drawn.images;
        // A ray crosses no more pixels than a frame has columns and rows, and goes no oftener down than up, but for the first time.
        let crossed: u64 = images.shape.size.map(u64::from).iter().sum();
        let levels = images.pyramid.as_ref().map_or(1, |pyramid| u64::from(pyramid.shape().layout().levels));
        let most_rounds = 2 * crossed + levels + u64::from(parameters.refinement);
        Ok(HeightSettings {
            ray_count: job.rays.host.len() as u32,
            refinement: parameters.refinement,
            rays_per_lane: rays_within_rounds(parameters.rays_per_lane, most_rounds),
            row_words: images.copy.as_ref().map_or(0, |copy| copy.row_words()),
            start_bias: parameters.start_bias as f32,
            padding_a: 0,
            padding_b: 0,
            padding_c: 0,
        })
    }

    /// Records the trace, by the counting variant where there is something to count into.
    pub(crate) fn record(
        &self,
        job: &TraceJob<'_>,
        hits: &HitBuffer,
        counting: Option<[&Buffer; 2]>,
        clock: &mut PhaseClock<'_>,
    ) -> Result<(), TracerError> {
        let (pipelines, images) = (&*self.pipelines, &self.drawn.images);
        let (textures, min_max) = (images.copy.is_none(), images.shape.pyramid == Some(CellDepths::NearFar));
        let (surfaces, counters) = (job.end == EndPoint::Surface, counting.is_some());
        let pipeline = pipelines.trace.of(&pipelines.gpu, Trace { textures, min_max, surfaces, counters })?;
        let settings = self.settings(job)?;
        let rays_per_lane = settings.rays_per_lane;
        let search = ImageSearch { name: "search", pipeline, settings, rays_per_lane, counting };
        self.drawn.trace(&pipelines.images, search, job, hits, clock)
    }

    /// Traces by the counting variant.
    pub(crate) fn count(&self, job: &TraceJob<'_>, hits: &HitBuffer) -> Result<Vec<Counter>, TracerError> {
        let gpu = &self.pipelines.gpu;
        let counts = RayCounts::new(gpu, "cell counts", job.rays.host.len())?;
        let touched = TouchedBits::new(gpu, "cells touched", self.cells(), "--frame")?;
        untimed(gpu, |clock| self.record(job, hits, Some([counts.buffer(), touched.buffer()]), clock))?;
        let mut counters = counts.counters(gpu, ["cells_visited", "depth_samples"])?;
        counters.push(Counter::of_set("cells_touched", touched.count(gpu)?));
        Ok(counters)
    }

    /// Pixels, and cells of the pyramid.
    pub(crate) fn cells(&self) -> u64 {
        let images = &self.drawn.images;
        let pixels: u64 = images.shape.size.map(u64::from).iter().product();
        pixels + images.pyramid.as_ref().map_or(0, |pyramid| pyramid.shape().cells())
    }
}
