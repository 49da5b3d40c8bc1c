//! Tracing on the device.

use bytemuck::{Pod, Zeroable};
use tracebench_api::wgpu::Buffer;
use tracebench_api::{Counter, EndPoint, HitBuffer, PhaseClock, SharedLayout, TraceJob, TracerError};
use tracebench_kit::{DrawnView, ImageSearch, Images, RayCounts, TouchedBits, rays_within_rounds, untimed};
use tracebench_shaders::screen_dda::Trace;

use crate::description::DdaParameters;
use crate::structure::ScreenDdaStructure;

/// `Settings` of shaders/screen-dda/trace.wgsl.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct Settings {
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

impl ScreenDdaStructure {
    fn settings(&self, job: &TraceJob<'_>) -> Result<Settings, TracerError> {
        let parameters = DdaParameters::try_from(job.parameters)?;
        let DrawnView { view, images, diagonal, .. } = &self.drawn;
        // A walk along the major axis, and the turn itself.
        let longest = view.size.into_iter().max().unwrap_or(1).div_ceil(parameters.stride) + 3;
        let samples = u64::from(longest.min(parameters.max_steps) + 1);
        let hi_z = images.pyramid.is_some();
        // Of a pyramid cells are asked, too: a ray goes up after a sample or a skip alone, and no oftener down than up.
        let turns = if hi_z { 2 * samples } else { samples };
        let over_layers = if hi_z || images.shape.images() > 1 { u64::from(images.shape.layers) } else { 0 };
        let copy = images.copy.as_ref();
        Ok(Settings {
            ray_count: job.rays.host.len() as u32,
            max_steps: parameters.max_steps,
            hit_point: parameters.hit_point as u32,
            stride: parameters.stride as f32,
            thickness: (parameters.thickness * diagonal) as f32,
            start_bias: parameters.start_bias as f32,
            rays_per_lane: rays_within_rounds(parameters.rays_per_lane, turns * (1 + over_layers)),
            row_words: copy.map_or(0, |copy| copy.row_words()),
            image_words: copy.map_or(0, |copy| copy.image_words()),
            layers: images.shape.layers,
            backs: u32::from(images.shape.backs),
            padding: 0,
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
        let pipelines = &*self.pipelines;
        let Images { shape, copy, pyramid, .. } = &self.drawn.images;
        let (textures, deep, hi_z) = (copy.is_none(), shape.images() > 1, pyramid.is_some());
        let (surfaces, counters) = (job.end == EndPoint::Surface, counting.is_some());
        let pipeline = pipelines.trace.of(&pipelines.gpu, Trace { textures, deep, hi_z, surfaces, counters })?;
        let settings = self.settings(job)?;
        let rays_per_lane = settings.rays_per_lane;
        let search = ImageSearch { name: "march", pipeline, settings, rays_per_lane, counting };
        self.drawn.trace(&pipelines.images, search, job, hits, clock)
    }

    /// Traces by the counting variant.
    pub(crate) fn count(&self, job: &TraceJob<'_>, hits: &HitBuffer) -> Result<Vec<Counter>, TracerError> {
        if self.drawn.images.pyramid.is_some() {
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
        let [width, height] = self.drawn.view.size.map(u64::from);
        let touched = TouchedBits::new(gpu, "pixels touched", width * height, "--frame")?;
        untimed(gpu, |clock| self.record(job, hits, Some([counts.buffer(), touched.buffer()]), clock))?;
        let mut counters = counts.counters(gpu, names)?;
        counters.push(Counter::of_set("pixels_touched", touched.count(gpu)?));
        Ok(counters)
    }
}
