//! The tracer and its structure.

use bytemuck::Zeroable;
use tracebench_api::{
    ImageMarch, Layers, MarchSteps, Parameters, Projection, SampledImage, TraceJob, TracerError, View,
};
use tracebench_kit::{
    CellDepths, DeviceTracer, ImageMethod, ImageShape, ImageStructure, Images, RasterizedView, rays_within_rounds,
};
use tracebench_shaders::screen_dda::{Settings, Trace};

use crate::description::{DdaParameters, FromBehind, HitPoint, March, NO_REFIT, Switch, ThicknessFrom, ThicknessUnit};

/// The tracer.
pub type ScreenDda = DeviceTracer<ImageStructure<DdaMethod>>;

/// The depth layers of one view.
pub struct DdaMethod;

/// Whether rays go over cells and every pixel.
fn by_cells(drawn: &RasterizedView) -> bool {
    drawn.images.shape.pyramid == Some(CellDepths::WithPixels)
}

/// Thickness in scene units, and as a share of depth.
fn thickness(parameters: &DdaParameters, diagonal: f64) -> [f64; 2] {
    match parameters.thickness_in {
        ThicknessUnit::Diagonals => [parameters.thickness * diagonal, 0.0],
        ThicknessUnit::Depth => [0.0, parameters.thickness],
    }
}

impl ImageMethod for DdaMethod {
    type Variant = Trace;
    type Settings = Settings;

    const NO_REFIT: &'static str = NO_REFIT;
    const PHASE: &'static str = "march";

    fn shape(view: &View, parameters: &Parameters) -> Result<ImageShape, TracerError> {
        let parameters = DdaParameters::try_from(parameters)?;
        Ok(ImageShape {
            size: view.size,
            layers: parameters.layers,
            backs: parameters.thickness_from == ThicknessFrom::BackFaces,
            separation: parameters.layer_separation,
            pyramid: match parameters.march {
                March::Pixels => None,
                March::HiZ => Some(CellDepths::NearFar),
                March::Cells => Some(CellDepths::WithPixels),
            },
            memory_access: parameters.memory_access,
            raster_backend: parameters.build,
        })
    }

    fn variant(drawn: &RasterizedView, surfaces: bool, counters: bool) -> Trace {
        let Images { shape, copy, pyramid, .. } = &drawn.images;
        let (textures, deep) = (copy.is_none(), shape.images() > 1);
        match pyramid {
            None => Trace::Plain { textures, deep, surfaces, counters },
            Some(_) => Trace::HiZ { textures, deep, surfaces, counters, cells: by_cells(drawn) },
        }
    }

    fn settings(drawn: &RasterizedView, job: &TraceJob<'_>) -> Result<(Settings, u32), TracerError> {
        let parameters = DdaParameters::try_from(job.parameters)?;
        let RasterizedView { view, images, diagonal, .. } = drawn;
        // A walk along the major axis, and the turn itself; by cells one along both axes, and down once.
        let longest = match by_cells(drawn) {
            true => view.size[0] + view.size[1] + u32::BITS,
            false => view.size.into_iter().max().unwrap_or(1).div_ceil(parameters.stride) + 3,
        };
        let samples = u64::from(longest.min(parameters.max_steps) + 1);
        let hi_z = images.pyramid.is_some();
        // Of a pyramid cells are asked, too: a ray goes up after a sample or a skip alone, and no oftener down than up.
        let turns = if hi_z { 2 * samples } else { samples };
        let over_layers = if hi_z || images.shape.images() > 1 { u64::from(images.shape.layers) } else { 0 };
        let copy = images.copy.as_ref();
        let rays_per_lane = rays_within_rounds(parameters.rays_per_lane, turns * (1 + over_layers));
        let [thickness, thickness_per_depth] = thickness(&parameters, *diagonal).map(|thick| thick as f32);
        let settings = Settings {
            ray_count: job.rays.host.len() as u32,
            max_steps: parameters.max_steps,
            hit_point: parameters.hit_point as u32,
            stride: parameters.stride as f32,
            thickness,
            thickness_per_depth,
            start_bias: parameters.start_bias as f32,
            rays_per_lane,
            row_words: copy.map_or(0, |copy| copy.row_words()),
            image_words: copy.map_or(0, |copy| copy.image_words()),
            layers: images.shape.layers,
            backs: u32::from(images.shape.backs),
            front_alone: u32::from(parameters.from_behind == FromBehind::Pass),
            depth_clip: u32::from(parameters.depth_clip == Switch::On),
            ..Zeroable::zeroed()
        };
        Ok((settings, rays_per_lane))
    }

    fn counters(drawn: &RasterizedView) -> &'static [&'static str] {
        let all = &["depth_samples", "cells_visited"];
        if drawn.images.pyramid.is_some() { all } else { &all[..1] }
    }

    fn touched(drawn: &RasterizedView) -> (&'static str, u64) {
        ("pixels_touched", drawn.pixels())
    }

    fn samplings(drawn: &RasterizedView, parameters: &Parameters) -> Result<Vec<SampledImage>, TracerError> {
        let parameters = DdaParameters::try_from(parameters)?;
        let RasterizedView { view, images, diagonal, .. } = drawn;
        let (shape, projection) = (&images.shape, Projection::Perspective(*view));
        let [thickness, thickness_per_depth] = thickness(&parameters, *diagonal);
        let march = Some(ImageMarch {
            steps: match by_cells(drawn) {
                true => MarchSteps::EveryPixel,
                false => MarchSteps::Stride(f64::from(parameters.stride)),
            },
            start_bias: parameters.start_bias,
            thickness,
            // A pixel is as wide as it is deep.
            thickness_in_pixels: thickness_per_depth / projection.pixel_at(1.0).max_element(),
            to_back_faces: shape.backs,
            from_before: by_cells(drawn) && parameters.from_behind == FromBehind::Pass,
            anywhere: parameters.hit_point == HitPoint::Step,
        });
        let layers = Layers::of(shape.layers, shape.separation * diagonal, true);
        Ok(vec![SampledImage { march, ..SampledImage::new(projection, layers) }])
    }

    fn statistics(drawn: &RasterizedView, covered: &[usize]) -> Vec<(&'static str, f64)> {
        let Images { shape, pyramid, .. } = &drawn.images;
        let layers = shape.layers as usize;
        let mut told = vec![("pixels", drawn.pixels() as f64), ("covered_pixels", covered[0] as f64)];
        let deeper = ["covered_pixels_of_layer_2", "covered_pixels_of_layer_3", "covered_pixels_of_layer_4"];
        told.extend(deeper.into_iter().zip(&covered[1..layers]).map(|(name, count)| (name, *count as f64)));
        if shape.backs {
            told.push(("pixels_with_back_faces", covered[layers] as f64));
        }
        if let Some(pyramid) = pyramid {
            told.push(("pyramid_cells", pyramid.shape().cells() as f64));
        }
        told
    }
}
