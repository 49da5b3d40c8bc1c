//! The tracer and its structure.

use bytemuck::Zeroable;
use tracebench_api::{
    ImageMarch, Layers, MarchSteps, Parameters, Projection, SampledImage, TraceJob, TracerError, View,
};
use tracebench_kit::{
    CellDepths, DeviceTracer, ImageMethod, ImageShape, ImageStructure, RasterizedView, rays_within_rounds,
};
use tracebench_shaders::height_field::{HeightSettings, Trace};

use crate::description::{HeightParameters, NO_REFIT, Pyramid, Search, Switch};

/// The tracer.
pub type HeightField = DeviceTracer<ImageStructure<HeightMethod>>;

/// The depth buffer of one view with its pyramid.
pub struct HeightMethod;

/// Pixels, and cells of the pyramid.
fn cells(drawn: &RasterizedView) -> u64 {
    drawn.pixels() + drawn.images.pyramid.as_ref().map_or(0, |pyramid| pyramid.shape().cells())
}

impl ImageMethod for HeightMethod {
    type Variant = Trace;
    type Settings = HeightSettings;

    const NO_REFIT: &'static str = NO_REFIT;
    const PHASE: &'static str = "search";

    fn shape(view: &View, parameters: &Parameters) -> Result<ImageShape, TracerError> {
        let HeightParameters { pyramid, memory_access, build: raster_backend, .. } =
            HeightParameters::try_from(parameters)?;
        let pyramid = Some(match pyramid {
            Pyramid::MinMax => CellDepths::NearFar,
            Pyramid::Max => CellDepths::Near,
        });
        Ok(ImageShape {
            size: view.size,
            layers: 1,
            backs: false,
            separation: 0.0,
            pyramid,
            memory_access,
            raster_backend,
        })
    }

    fn variant(drawn: &RasterizedView, surfaces: bool, counters: bool) -> Trace {
        let min_max = drawn.images.shape.pyramid == Some(CellDepths::NearFar);
        Trace { textures: drawn.images.copy.is_none(), min_max, surfaces, counters }
    }

    fn settings(drawn: &RasterizedView, job: &TraceJob<'_>) -> Result<(HeightSettings, u32), TracerError> {
        let parameters = HeightParameters::try_from(job.parameters)?;
        let images = &drawn.images;
        // A ray crosses no more pixels than a frame has columns and rows, and goes no oftener down than up, but for the first time.
        let crossed: u64 = images.shape.size.map(u64::from).iter().sum();
        let levels = images.pyramid.as_ref().map_or(1, |pyramid| u64::from(pyramid.shape().layout().levels));
        let max_rounds = 2 * crossed + levels + u64::from(parameters.refinement);
        let rays_per_lane = rays_within_rounds(parameters.rays_per_lane, max_rounds);
        let settings = HeightSettings {
            ray_count: job.rays.host.len() as u32,
            refinement: parameters.refinement,
            rays_per_lane,
            row_words: images.copy.as_ref().map_or(0, |copy| copy.row_words()),
            start_bias: parameters.start_bias as f32,
            closed: u32::from(parameters.search == Search::Closed),
            depth_clip: u32::from(parameters.depth_clip == Switch::On),
            ..Zeroable::zeroed()
        };
        Ok((settings, rays_per_lane))
    }

    fn counters(_drawn: &RasterizedView) -> &'static [&'static str] {
        &["cells_visited", "depth_samples"]
    }

    fn touched(drawn: &RasterizedView) -> (&'static str, u64) {
        ("cells_touched", cells(drawn))
    }

    fn samplings(drawn: &RasterizedView, parameters: &Parameters) -> Result<Vec<SampledImage>, TracerError> {
        let HeightParameters { start_bias, refinement, search, .. } = HeightParameters::try_from(parameters)?;
        let march = Some(ImageMarch {
            steps: MarchSteps::EveryPixel,
            start_bias,
            // All behind a sample is solid.
            thickness: f64::INFINITY,
            thickness_in_pixels: 0.0,
            to_back_faces: false,
            from_before: false,
            // Few halvings leave it open where in its pixel a hit is.
            anywhere: search == Search::Halvings && refinement < 16,
        });
        Ok(vec![SampledImage { march, ..SampledImage::new(Projection::Perspective(drawn.view), Layers::Nearest) }])
    }

    fn statistics(drawn: &RasterizedView, covered: &[usize]) -> Vec<(&'static str, f64)> {
        let counts = [("pixels", drawn.pixels()), ("covered_pixels", covered[0] as u64), ("cells", cells(drawn))];
        counts.map(|(name, count)| (name, count as f64)).to_vec()
    }
}
