//! Depth layers (WKP15, section 3.1): the passes that catch them and name their triangles.

use tracebench_api::wgpu::{BindGroup, Buffer, ComputePipeline};
use tracebench_api::{Geometry, Gpu, PhaseClock, TracerError};
use tracebench_kit::{
    Canvas, ComputeRaster, RasterBackend, RasterImage, RasterWork, TrianglePass, TrianglePipelines, bind_group_at,
    compute_pipeline, dispatch_linear, uniform_buffer, view_uniform,
};
use tracebench_shaders::quadtree::{LAYERS, THIN};

use crate::build::WORKGROUP_SIZE;
use crate::description::Capture;
use crate::images::Images;
use crate::layout::Shape;
pub(crate) use tracebench_shaders::quadtree::{LayerPass, ThinPass};

/// What a pass does; codes as in shaders/quadtree/layers.wgsl.
#[derive(Clone, Copy)]
enum Stage {
    /// All slots by cascaded minima.
    Catch = 0,
    /// One layer behind the one before.
    Peel = 1,
    /// The triangles of all layers.
    Name = 2,
}

/// The pipelines.
pub(crate) struct LayerPipelines {
    raster: ComputeRaster,
    draw: TrianglePipelines,
    thin: ComputePipeline,
}

/// One step of a view's capture.
enum Step<'a> {
    /// The view's caught depths are cleared.
    Clear,
    /// All triangles are drawn.
    Draw(TrianglePass<'a>),
    /// Layers are chosen from what was caught.
    Thin(BindGroup),
}

/// What the capture binds: made before the phases, which only record.
pub(crate) struct Capturing<'a> {
    work: &'a [RasterWork],
    catch: Vec<Step<'a>>,
    name: Vec<Step<'a>>,
}

impl LayerPipelines {
    pub(crate) fn new(gpu: &Gpu) -> Result<Self, TracerError> {
        let draw = TrianglePipelines::new();
        draw.raster(gpu, LAYERS)?;
        Ok(Self { raster: ComputeRaster::new(gpu), draw, thin: compute_pipeline(gpu, THIN, "thin")? })
    }

    /// The triangles of every view dealt out, where there is no rasterizer.
    pub(crate) fn deal_out(
        &self,
        gpu: &Gpu,
        shape: &Shape,
        geometry: &Geometry,
    ) -> Result<Vec<RasterWork>, TracerError> {
        let images = shape.views.iter().map(RasterImage::of_view);
        let triangles = geometry.triangles.len() as u32;
        self.raster.prepare_all(gpu, shape.raster_backend, images, geometry.on_device()?, triangles)
    }

    /// Prepares the capture of every view.
    pub(crate) fn prepare<'a>(
        &self,
        gpu: &Gpu,
        shape: &Shape,
        images: &'a Images,
        geometry: &Geometry,
        work: &'a [RasterWork],
    ) -> Result<Capturing<'a>, TracerError> {
        let device = geometry.on_device()?;
        for (name, buffer) in [("vertex positions", &device.positions), ("vertex indices", &device.indices)] {
            gpu.check_storage_binding(name, buffer.size(), "the scene's triangle count")?;
        }
        let mut capturing = Capturing { work, catch: Vec::new(), name: Vec::new() };
        let vertices = geometry.triangles.len() as u32 * 3;
        let (pixels, separation) = (shape.pixels() as u32, shape.separation as f32);
        for (number, view) in shape.views.iter().enumerate() {
            let first = number as u32 * shape.layers * pixels;
            let draw = |stage: Stage, layer: u32, slots: u32, first: u32, codes: &Buffer| {
                let pass = LayerPass {
                    view: view_uniform(view),
                    stage: stage as u32,
                    layer,
                    slots,
                    culls: u32::from(shape.culls),
                    pixels,
                    width: view.size[0],
                    first,
                    separation,
                };
                let pass = uniform_buffer(gpu, "drawn layers", &pass)?;
                let buffers = [&pass, &device.positions, &device.indices, codes, &images.names.buffer];
                let resources: Vec<_> = (0..).zip(buffers.map(Buffer::as_entire_binding)).collect();
                let canvas = Canvas::of(work.get(number), images.target.as_ref(), vertices)?;
                Ok::<_, TracerError>(Step::Draw(self.draw.pass(gpu, LAYERS, &resources, canvas)?))
            };
            let codes = &images.codes.buffer;
            match (shape.capture, &images.caught) {
                (Capture::KBuffer, None) => {
                    capturing.catch.push(draw(Stage::Catch, 0, shape.layers, first, codes)?);
                }
                (Capture::KBuffer, Some(caught)) => {
                    capturing.catch.push(Step::Clear);
                    capturing.catch.push(draw(Stage::Catch, 0, shape.slots(), 0, &caught.buffer)?);
                    let thinned = ThinPass {
                        pixels,
                        slots: shape.slots(),
                        layers: shape.layers,
                        first,
                        separation,
                        padding_a: 0,
                        padding_b: 0,
                        padding_c: 0,
                    };
                    let thinned = uniform_buffer(gpu, "thinned layers", &thinned)?;
                    let resources = [&thinned, &caught.buffer, codes].map(Buffer::as_entire_binding);
                    let resources: Vec<_> = (0..).zip(resources).collect();
                    let bindings = bind_group_at(gpu, &self.thin.get_bind_group_layout(0), &resources);
                    capturing.catch.push(Step::Thin(bindings));
                }
                (Capture::Peeling, _) => {
                    for layer in 0..shape.layers {
                        capturing.catch.push(draw(Stage::Peel, layer, shape.layers, first, codes)?);
                    }
                }
            }
            capturing.name.push(draw(Stage::Name, 0, shape.layers, first, codes)?);
        }
        Ok(capturing)
    }

    /// Records the phases "draw layers" and "name triangles".
    pub(crate) fn record(
        &self,
        shape: &Shape,
        images: &Images,
        capturing: &Capturing<'_>,
        clock: &mut PhaseClock<'_>,
    ) -> Result<(), TracerError> {
        RasterWork::record_all(capturing.work, clock)?;
        let phases = [("draw layers", &capturing.catch, true), ("name triangles", &capturing.name, false)];
        for (name, steps, is_first) in phases {
            clock.device_phase(name, |encoder| {
                if is_first {
                    encoder.clear_buffer(&images.codes.buffer, 0, None);
                    encoder.clear_buffer(&images.names.buffer, 0, None);
                }
                for step in steps {
                    match step {
                        Step::Clear => {
                            if let Some(caught) = &images.caught {
                                encoder.clear_buffer(&caught.buffer, 0, None);
                            }
                        }
                        Step::Draw(pass) => pass.record(encoder),
                        Step::Thin(bindings) => {
                            dispatch_linear(encoder, &self.thin, bindings, shape.pixels() as u32, WORKGROUP_SIZE);
                        }
                    }
                }
            })?;
        }
        Ok(())
    }
}

/// Bytes of the uniforms of a capture, and of what deals triangles out, which are kept until it is done.
pub(crate) fn capture_bytes(shape: &Shape, triangles: u32) -> u64 {
    let passes = if shape.capture == Capture::Peeling { shape.layers as usize } else { 1 } + 1;
    let thinned = if shape.thins() { size_of::<ThinPass>() } else { 0 };
    let dealt = if shape.raster_backend == RasterBackend::Compute { RasterWork::bytes(triangles, false) } else { 0 };
    shape.views.len() as u64 * ((passes * size_of::<LayerPass>() + thinned) as u64 + dealt)
}
