//! What is drawn of a view: layers of eye depth, backs behind them, a copy and a pyramid for searches that ask for them.

use std::sync::Arc;

use tracebench_api::wgpu::CommandEncoder;
use tracebench_api::{Geometry, Gpu, Ledger, Parameters, PhaseClock, TracerError, View};
use tracebench_kit::{
    CellDepths, DepthCopy, DepthPyramid, DrawnBy, EyeDepthTarget, LayerTarget, NO_SURFACE, NearestLayers, NearestOf,
    NearestPass, NearestScene, Passing, PyramidBuilder, PyramidShape, Reads,
};

use crate::description::{DdaParameters, March, ThicknessFrom};

/// The pipelines of a build.
pub(crate) struct ImagePipelines {
    gpu: Arc<Gpu>,
    layers: NearestLayers,
    pyramids: PyramidBuilder,
}

/// What is to be drawn, as the build's parameters have it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ImageShape {
    pub size: [u32; 2],
    /// Layers of eye depth.
    pub layers: u32,
    /// Whether each has an image of the backs behind it, after all layers.
    pub backs: bool,
    /// Scene diagonals.
    pub separation: f64,
    pub hi_z: bool,
    pub reads: Reads,
    /// What draws.
    pub drawn_by: DrawnBy,
}

impl ImageShape {
    pub fn of(view: &View, parameters: &Parameters) -> Result<Self, TracerError> {
        let parameters = DdaParameters::try_from(parameters)?;
        Ok(Self {
            size: view.size,
            layers: parameters.layers,
            backs: parameters.thickness_from == ThicknessFrom::BackFaces,
            separation: parameters.layer_separation,
            hi_z: parameters.march == March::HiZ,
            reads: parameters.reads,
            drawn_by: parameters.build,
        })
    }

    /// Images of depths: the layers, and their backs.
    pub fn images(&self) -> u32 {
        if self.backs { 2 * self.layers } else { self.layers }
    }

    fn pyramid(&self) -> Option<PyramidShape> {
        let depths = CellDepths::NearFar;
        self.hi_z.then(|| PyramidShape { size: self.size, images: self.images(), covered_from: self.layers, depths })
    }
}

/// The images of one view.
pub(crate) struct Images {
    pub shape: ImageShape,
    pub target: EyeDepthTarget,
    /// The eye depths in a buffer, where the march reads one.
    pub copy: Option<DepthCopy>,
    pub pyramid: Option<DepthPyramid>,
}

impl Images {
    pub fn new(gpu: &Gpu, shape: ImageShape) -> Result<Self, TracerError> {
        let target = EyeDepthTarget::of_images(gpu, shape.size, shape.images())?;
        let by_buffer = shape.reads == Reads::Buffer;
        let copy = by_buffer.then(|| DepthCopy::new(gpu, shape.size, shape.images())).transpose()?;
        let pyramid = shape.pyramid().map(|pyramid| DepthPyramid::new(gpu, pyramid, shape.reads)).transpose()?;
        Ok(Self { shape, target, copy, pyramid })
    }

    /// Enters all, with what drawing so many triangles takes.
    pub fn enter(&self, triangle_count: u32, ledger: &mut Ledger) {
        self.target.enter(ledger);
        if let Some(copy) = &self.copy {
            copy.enter(ledger);
        }
        if let Some(pyramid) = &self.pyramid {
            pyramid.enter(ledger);
        }
        // While the images are drawn.
        let ImageShape { drawn_by, size, .. } = self.shape;
        let drawing = NearestLayers::memory(NearestOf::Depths, drawn_by, size, triangle_count, self.shape.images());
        let of_layers: u64 = drawing.iter().map(|entry| entry.allocated_bytes).sum();
        let of_pyramid = self.pyramid.as_ref().map_or(0, |pyramid| pyramid.shape().build_bytes());
        ledger.borrow_transient(of_layers + of_pyramid);
    }

    /// Reads the images back and holds them against one another; gives how many pixels of each are covered.
    pub fn validate(&self, gpu: &Gpu, view: &View, diagonal: f64) -> Result<Vec<usize>, TracerError> {
        let images = (0..self.shape.images()).map(|image| self.target.read_image(gpu, image));
        let images = images.collect::<Result<Vec<_>, _>>()?;
        check_images(&images, &self.shape, view, diagonal)?;
        if let Some(pyramid) = &self.pyramid {
            pyramid.validate(gpu, &images)?;
        }
        Ok(images.iter().map(|image| image.iter().filter(|depth| **depth != NO_SURFACE).count()).collect())
    }
}

/// Holds images of eye depths against near and far and against one another: each layer lies behind the one before, and each
/// image of backs behind its layer.
fn check_images(images: &[Vec<f32>], shape: &ImageShape, view: &View, diagonal: f64) -> Result<(), TracerError> {
    // Depth is computed in f32, so a surface at near or far may be stored a little beyond it.
    let (near, far) = (view.near * (1.0 - 1e-4), view.far * (1.0 + 1e-4));
    let outside = |depth: &&f32| **depth != NO_SURFACE && !(near..=far).contains(&f64::from(**depth));
    if let Some(depth) = images.iter().flatten().find(outside) {
        return Err(TracerError::Failed(format!("an eye depth of {depth} lies outside of {near} to {far}")));
    }
    let layers = shape.layers as usize;
    let separation = (shape.separation * diagonal) as f32;
    for (index, image) in images.iter().enumerate().skip(1) {
        let (before, least) = if index < layers { (index - 1, separation) } else { (index - layers, 0.0) };
        let pairs = images[before].iter().zip(image);
        let is_behind = |front: f32, depth: f32| depth == NO_SURFACE || depth > front + least;
        if let Some((front, depth)) = pairs.into_iter().find(|(front, depth)| !is_behind(**front, **depth)) {
            return Err(TracerError::Failed(format!(
                "image {index} has a depth of {depth}, and the layer before it one of {front}"
            )));
        }
    }
    Ok(())
}

impl ImagePipelines {
    pub fn new(gpu: &Arc<Gpu>) -> Result<Self, TracerError> {
        Ok(Self { layers: NearestLayers::of_depths(gpu)?, pyramids: PyramidBuilder::new(gpu)?, gpu: Arc::clone(gpu) })
    }

    /// Draws everything: the whole build.
    pub fn draw(
        &self,
        geometry: &Geometry,
        view: &View,
        images: &Images,
        clock: &mut PhaseClock<'_>,
    ) -> Result<(), TracerError> {
        let (gpu, device) = (&*self.gpu, geometry.on_device()?);
        let Images { shape, target, copy, pyramid } = images;
        let triangle_count = geometry.triangles.len() as u32;
        let scene = NearestScene { drawn_by: shape.drawn_by, view, geometry: device, triangle_count };
        let record = |encoder: &mut CommandEncoder, pass: &NearestPass, image: usize| {
            let layer = LayerTarget { image: &target.images[image], layer: image as u32, test: &target.test };
            self.layers.record(encoder, pass, layer);
        };
        let first = self.layers.prepare(gpu, scene, None)?;
        clock.device_phase("rasterize depth buffer", |encoder| record(encoder, &first, 0))?;
        let layers = shape.layers as usize;
        let separation = (shape.separation * geometry.diagonal()) as f32;
        let mut behind = |name: &str, begin: usize, end: usize, before: usize, passing: Passing| {
            let prepare =
                |image: usize| self.layers.prepare(gpu, scene, Some((&target.images[image - before], passing)));
            let passes =
                (begin..end).map(|image| Ok((prepare(image)?, image))).collect::<Result<Vec<_>, TracerError>>()?;
            if passes.is_empty() {
                return Ok(());
            }
            clock.device_phase(name, |encoder| {
                for (pass, image) in &passes {
                    record(encoder, pass, *image);
                }
            })
        };
        behind("rasterize deeper layers", 1, layers, 1, Passing::behind(separation))?;
        behind("rasterize back faces", layers, shape.images() as usize, layers, Passing::backs())?;
        if let Some(copy) = copy {
            clock.device_phase("copy to a buffer", |encoder| copy.record(encoder, target))?;
        }
        match pyramid {
            Some(pyramid) => self.pyramids.record(gpu, target, pyramid, clock),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tracebench_api::glam::DVec3;

    /// Negative control: of images that are right, a depth before near, one beyond far, a layer before the one before it, one nearer to
    /// it than the separation, one where there is nothing before it, and a back before its front are each noticed.
    #[test]
    fn wrong_images_are_noticed() {
        let view = View {
            eye: DVec3::ZERO,
            right: DVec3::X,
            up: DVec3::Y,
            forward: DVec3::NEG_Z,
            tan_half_width: 1.0,
            tan_half_height: 1.0,
            near: 0.1,
            far: 100.0,
            size: [3, 1],
        };
        let shape = ImageShape {
            size: [3, 1],
            layers: 2,
            backs: true,
            separation: 0.1,
            hi_z: false,
            reads: Reads::Buffer,
            drawn_by: DrawnBy::Raster,
        };
        let right = [
            vec![2.0, 3.0, NO_SURFACE],
            vec![4.5, NO_SURFACE, NO_SURFACE],
            vec![2.1, NO_SURFACE, NO_SURFACE],
            vec![4.6, NO_SURFACE, NO_SURFACE],
        ];
        let wrong = |image: usize, pixel: usize, depth: f32| {
            let mut images = right.clone();
            images[image][pixel] = depth;
            check_images(&images, &shape, &view, 20.0).is_err()
        };
        assert!(!wrong(0, 0, 2.0));
        let spoilt = [(0, 0, 0.05), (0, 0, 101.0), (1, 0, 1.5), (1, 0, 3.9), (1, 2, 5.0), (2, 0, 1.9), (3, 0, 4.4)];
        for (image, pixel, depth) in spoilt {
            assert!(wrong(image, pixel, depth), "{image} {pixel} {depth}");
        }
    }
}
