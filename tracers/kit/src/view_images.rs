//! The depths of one view as the structure of methods that march over them: layers of eye depth, backs behind them, a copy and a pyramid
//! for searches that ask for them. Hits name no triangle: a trace to surfaces draws the view once more.

use std::cell::RefCell;
use std::sync::Arc;

use bytemuck::NoUninit;
use tracebench_api::wgpu::{BindingResource, Buffer, CommandEncoder, ComputePipeline};
use tracebench_api::{
    Geometry, Gpu, HitBuffer, Ledger, MemoryEntry, MemoryReport, PhaseClock, TraceJob, TraceTo, TracerError, View,
};

use crate::{
    CellDepths, DepthCopy, DepthPyramid, EyeDepthTarget, LayerTarget, MemoryAccess, NO_SURFACE, NearestLayers,
    NearestOf, NearestPass, NearestScene, Passing, PyramidBuilder, PyramidLayout, PyramidShape, RasterBackend,
    Readable, SurfaceGeometry, ViewUniform, VisibilityBuffer, VisibilityPass, VisibilityView, bind_arrays,
    bind_group_at, dispatch_rays, uniform_buffer, view_uniform,
};

/// The pipelines of builds, and of surfaces.
pub struct ImagePipelines {
    gpu: Arc<Gpu>,
    layers: NearestLayers,
    pyramids: PyramidBuilder,
    /// The triangles at the view's pixels.
    seen: VisibilityPass,
}

/// What is to be drawn, as a build's parameters have it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImageShape {
    /// Pixels along x and y.
    pub size: [u32; 2],
    /// Layers of eye depth.
    pub layers: u32,
    /// Whether each has an image of the backs behind it, after all layers.
    pub backs: bool,
    /// Of a layer from the one before at least, scene diagonals.
    pub separation: f64,
    /// What a pyramid keeps of a cell, if there is to be one.
    pub pyramid: Option<CellDepths>,
    /// What searches read from.
    pub memory_access: MemoryAccess,
    /// What draws.
    pub raster_backend: RasterBackend,
}

impl ImageShape {
    /// Images of depths: the layers, and their backs.
    pub fn images(&self) -> u32 {
        if self.backs { 2 * self.layers } else { self.layers }
    }

    fn pyramid(&self) -> Option<PyramidShape> {
        // Of a layer a pixel without a surface bounds its cells: nothing in it is solid.
        let of = |depths| PyramidShape { size: self.size, images: self.images(), covered_from: self.layers, depths };
        self.pyramid.map(of)
    }
}

/// The images of one view.
#[derive(Clone)]
pub struct Images {
    /// What they are.
    pub shape: ImageShape,
    target: EyeDepthTarget,
    /// The eye depths in a buffer, where searches read one.
    pub copy: Option<DepthCopy>,
    /// Over all images.
    pub pyramid: Option<DepthPyramid>,
}

impl Images {
    fn new(gpu: &Gpu, shape: ImageShape) -> Result<Self, TracerError> {
        let target = EyeDepthTarget::of_images(gpu, shape.size, shape.images())?;
        let by_buffer = shape.memory_access == MemoryAccess::Buffer;
        let copy = by_buffer.then(|| DepthCopy::new(gpu, shape.size, shape.images())).transpose()?;
        let pyramid =
            shape.pyramid().map(|pyramid| DepthPyramid::new(gpu, pyramid, shape.memory_access)).transpose()?;
        Ok(Self { shape, target, copy, pyramid })
    }

    /// Enters all, with what drawing so many triangles takes.
    fn enter(&self, triangle_count: u32, ledger: &mut Ledger) {
        self.target.enter(ledger);
        if let Some(copy) = &self.copy {
            copy.enter(ledger);
        }
        if let Some(pyramid) = &self.pyramid {
            pyramid.enter(ledger);
        }
        // While the images are drawn.
        let ImageShape { raster_backend, size, .. } = self.shape;
        let drawing =
            NearestLayers::memory(NearestOf::Depths, raster_backend, size, triangle_count, self.shape.images());
        let of_layers: u64 = drawing.iter().map(|entry| entry.allocated_bytes).sum();
        let of_pyramid = self.pyramid.as_ref().map_or(0, |pyramid| pyramid.shape().build_bytes());
        ledger.borrow_transient(of_layers + of_pyramid);
    }

    /// What a search reads from buffers or, of pyramids, as textures.
    fn arrays(&self) -> Vec<Readable> {
        let copy = self.copy.iter().map(|copy| copy.array());
        copy.chain(self.pyramid.iter().map(|pyramid| pyramid.array())).cloned().collect()
    }
}

/// A view as its images show it, with what of the scene surfaces need.
pub struct RasterizedView {
    /// The view.
    pub view: View,
    /// Its images.
    pub images: Images,
    /// Of the scene's bounds, scene units.
    pub diagonal: f64,
    geometry: SurfaceGeometry,
    triangle_count: u32,
    /// What the last texture of triangles took.
    primitive_texture: RefCell<Option<MemoryEntry>>,
}

/// A search over the images, by shaders with these bindings: 0 view, 1 settings, 2 depths in a texture, 3 rays, 4 hits, 5 and 6 what is
/// counted, 7 triangles at the pixels, 8 triangle of every ray, 9 layout of the pyramid.
pub struct ImageSearch<'a, Settings> {
    /// The phase's name.
    pub name: &'a str,
    /// The pipeline for what is asked and read.
    pub pipeline: ComputePipeline,
    /// The uniform.
    pub settings: Settings,
    /// Rays that a lane answers.
    pub rays_per_lane: u32,
    /// What a variant that counts writes to: numbers of every ray, and bits.
    pub counting: Option<[&'a Buffer; 2]>,
}

impl RasterizedView {
    /// Draws all of a build, into the images of before where there are some and the frame is as large.
    ///
    /// # Errors
    /// As [`Tracer::build`](tracebench_api::Tracer::build).
    pub fn draw(
        pipelines: &ImagePipelines,
        shape: ImageShape,
        geometry: &Geometry,
        view: View,
        before: Option<&Self>,
        clock: &mut PhaseClock<'_>,
    ) -> Result<Self, TracerError> {
        let surfaces = SurfaceGeometry::of(geometry)?;
        let images = match before {
            Some(before) if view.size == before.view.size => before.images.clone(),
            _ => Images::new(&pipelines.gpu, shape)?,
        };
        pipelines.draw(geometry, &view, &images, clock)?;
        Ok(Self {
            view,
            images,
            diagonal: geometry.diagonal(),
            geometry: surfaces,
            triangle_count: geometry.triangles.len() as u32,
            primitive_texture: before.map_or_else(RefCell::default, |before| before.primitive_texture.clone()),
        })
    }

    /// Pixels of an image.
    pub fn pixels(&self) -> u64 {
        self.images.shape.size.map(u64::from).iter().product()
    }

    /// What it holds.
    pub fn memory(&self) -> MemoryReport {
        let mut ledger = Ledger::new();
        self.images.enter(self.triangle_count, &mut ledger);
        ledger.report(0).with_surface_geometry(self.geometry.bytes)
    }

    /// What a trace takes by settings of so many bytes.
    pub fn trace_memory(&self, settings_bytes: usize, job: &TraceJob<'_>) -> Vec<MemoryEntry> {
        let mut uniforms = vec![("view", size_of::<ViewUniform>()), ("settings", settings_bytes)];
        uniforms.extend(self.images.pyramid.as_ref().map(|_| ("pyramid layout", size_of::<PyramidLayout>())));
        let whole = |(name, bytes)| MemoryEntry::whole(name, bytes as u64);
        let mut parts: Vec<_> = uniforms.into_iter().map(whole).collect();
        if job.trace_to == TraceTo::Surface {
            let last = self.primitive_texture.borrow().clone();
            let ImageShape { raster_backend, layers, .. } = self.images.shape;
            let (triangles, rays) = (self.triangle_count, job.rays.host.len());
            parts.extend(VisibilityPass::memory(raster_backend, self.view.size, triangles, layers, rays, last));
        }
        parts
    }

    /// Records a search, and round it what a trace to surfaces takes.
    ///
    /// # Errors
    /// As [`Structure::trace`](tracebench_api::Structure::trace).
    pub fn trace(
        &self,
        pipelines: &ImagePipelines,
        search: ImageSearch<'_, impl NoUninit>,
        job: &TraceJob<'_>,
        hits: &HitBuffer,
        clock: &mut PhaseClock<'_>,
    ) -> Result<(), TracerError> {
        let (gpu, count) = (&*pipelines.gpu, job.rays.host.len());
        if job.trace_to == TraceTo::Hit {
            return self.search(gpu, search, job, hits, None, clock);
        }
        hits.surfaces_on_device(count)?;
        let shape = &self.images.shape;
        let view = VisibilityView {
            raster_backend: shape.raster_backend,
            view: &self.view,
            geometry: &self.geometry,
            triangle_count: self.triangle_count,
            target: &self.images.target,
            layers: shape.layers,
            separation: (shape.separation * self.diagonal) as f32,
        };
        let seen = pipelines.seen.draw(gpu, view, count, clock)?;
        self.primitive_texture.replace(Some(seen.primitives.memory.clone()));
        self.search(gpu, search, job, hits, Some(&seen), clock)?;
        pipelines.seen.gather(gpu, &self.geometry, job.rays, hits, &seen, clock)
    }

    /// Records a search; `seen` is what rays see of triangles.
    fn search(
        &self,
        gpu: &Gpu,
        search: ImageSearch<'_, impl NoUninit>,
        job: &TraceJob<'_>,
        hits: &HitBuffer,
        seen: Option<&VisibilityBuffer>,
        clock: &mut PhaseClock<'_>,
    ) -> Result<(), TracerError> {
        let ImageSearch { name, pipeline, settings, rays_per_lane, counting } = search;
        let Images { target, copy, pyramid, .. } = &self.images;
        let view = uniform_buffer(gpu, "view", &view_uniform(&self.view))?;
        let settings = uniform_buffer(gpu, "settings", &settings)?;
        let layout = |pyramid: &DepthPyramid| uniform_buffer(gpu, "pyramid layout", &pyramid.shape().layout());
        let layout = pyramid.as_ref().map(layout).transpose()?;
        let mut resources = vec![
            (0, view.as_entire_binding()),
            (1, settings.as_entire_binding()),
            (3, job.rays.on_device()?.as_entire_binding()),
            (4, hits.on_device(job.rays.host.len())?.as_entire_binding()),
        ];
        if copy.is_none() {
            resources.push((2, BindingResource::TextureView(&target.all)));
        }
        if let Some([of_rays, touched]) = counting {
            resources.extend([(5, of_rays.as_entire_binding()), (6, touched.as_entire_binding())]);
        }
        if let Some(VisibilityBuffer { primitives, triangles }) = seen {
            resources.extend([(7, BindingResource::TextureView(&primitives.all)), (8, triangles.as_entire_binding())]);
        }
        resources.extend(layout.as_ref().map(|layout| (9, layout.as_entire_binding())));
        let bindings = bind_group_at(gpu, &pipeline.get_bind_group_layout(0), &resources);
        let arrays = self.images.arrays();
        let arrays = (!arrays.is_empty()).then(|| bind_arrays(gpu, &pipeline, &arrays));
        let bindings: Vec<_> = std::iter::once(&bindings).chain(&arrays).collect();
        clock.device_phase(name, |encoder| {
            dispatch_rays(encoder, &pipeline, &bindings, job.rays, rays_per_lane);
        })
    }

    /// Reads the images back and holds them against one another; gives how many pixels of each are covered.
    ///
    /// # Errors
    /// [`TracerError::Failed`] with what is wrong, or if the device fails.
    pub fn validate(&self, gpu: &Gpu) -> Result<Vec<usize>, TracerError> {
        let Images { shape, target, pyramid, .. } = &self.images;
        let images = (0..shape.images()).map(|image| target.read_image(gpu, image));
        let images = images.collect::<Result<Vec<_>, _>>()?;
        check_images(&images, shape, &self.view, self.diagonal)?;
        if let Some(pyramid) = pyramid {
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
    /// Creates the pipelines.
    ///
    /// # Errors
    /// [`TracerError::Failed`] if the device refuses one.
    pub fn new(gpu: &Arc<Gpu>) -> Result<Self, TracerError> {
        let (layers, pyramids) = (NearestLayers::of_depths(gpu)?, PyramidBuilder::new(gpu)?);
        Ok(Self { layers, pyramids, seen: VisibilityPass::new(gpu)?, gpu: Arc::clone(gpu) })
    }

    /// Draws everything: the whole build.
    fn draw(
        &self,
        geometry: &Geometry,
        view: &View,
        images: &Images,
        clock: &mut PhaseClock<'_>,
    ) -> Result<(), TracerError> {
        let (gpu, device) = (&*self.gpu, geometry.on_device()?);
        let Images { shape, target, copy, pyramid } = images;
        let triangle_count = geometry.triangles.len() as u32;
        let scene = NearestScene { raster_backend: shape.raster_backend, view, geometry: device, triangle_count };
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
        behind("rasterize deeper layers", 1, layers, 1, crate::behind(separation))?;
        behind("rasterize back faces", layers, shape.images() as usize, layers, crate::backs())?;
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
            pyramid: None,
            memory_access: MemoryAccess::Buffer,
            raster_backend: RasterBackend::Raster,
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
