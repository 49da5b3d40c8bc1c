//! The optional direct visibility pass of the build (section 4.1.3): the surface at every pixel of the camera's frame, which is
//! where paths begin.
//!
//! Deviation: the paper writes the shading buffer from the fragment stage behind a spin lock a pixel, as WGSL cannot (nothing
//! orders the writes of two fragments). Here a depth attachment keeps the nearest triangle of every pixel, and a compute pass
//! makes the surfaces of these.

use tracebench_api::wgpu::{BindingResource, Buffer, BufferUsages, ComputePipeline, TextureUsages, TextureView};
use tracebench_api::{Gpu, Ledger, MemoryEntry, PhaseClock, Surface, TracerError, View, Viewpoint};
use tracebench_kit::{
    DEPTH_TEST_FORMAT, LayerTarget, NearestLayers, NearestOf, NearestScene, PrimitiveTexture, ViewUniform, bind_group,
    compute_pipeline, create_texture, dispatch_linear, view_uniform,
};
use tracebench_shaders::dirt::VISIBILITY;

use crate::description::{DirectVisibility, DirtParameters};
use crate::pipelines::Pipelines;
use crate::structure::Resident;

/// As `WORKGROUP_SIZE` in shaders/dirt/visibility.wgsl.
const WORKGROUP_SIZE: u32 = 64;

const SHADING: &str = "shading buffer: direct visibility";
const DEPTH: &str = "direct visibility: depth test";
const VIEW: &str = "resolved view";

/// The pipelines.
pub(crate) struct Visibility {
    primitives: NearestLayers,
    resolve: ComputePipeline,
}

/// What the camera's frame shows.
#[derive(Clone)]
pub(crate) struct Frame {
    view: View,
    primitives: PrimitiveTexture,
    depth: TextureView,
    depth_memory: MemoryEntry,
    /// A surface a pixel, row by row from the top.
    shading: Buffer,
    /// Bytes held while it is drawn.
    drawing_bytes: u64,
}

impl Frame {
    /// Room for a frame.
    fn new(gpu: &Gpu, view: &View) -> Result<Self, TracerError> {
        let limit = gpu.limits.max_texture_dimension_2d;
        if let Some(edge) = view.size.into_iter().find(|edge| *edge > limit) {
            return Err(TracerError::TooLarge {
                name: "the edge of the direct visibility's frame".to_owned(),
                bytes: u64::from(edge),
                limit: u64::from(limit),
                hint: "--frame-size, or set dirt.direct_visibility=off".to_owned(),
            });
        }
        let pixels: u64 = view.size.map(u64::from).iter().product();
        let bytes = pixels * size_of::<Surface>() as u64;
        let hint = "--frame-size, or set dirt.direct_visibility=off";
        gpu.check_storage_binding(SHADING, bytes, hint)?;
        let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC | BufferUsages::COPY_DST;
        let shading = gpu.buffer(SHADING, bytes, usage, hint)?;
        let primitives = PrimitiveTexture::new(gpu, view.size)?;
        let before = gpu.allocations();
        let depth = create_texture(gpu, DEPTH, view.size, DEPTH_TEST_FORMAT, TextureUsages::RENDER_ATTACHMENT);
        gpu.check()?;
        let mut depth_memory = MemoryEntry::whole(DEPTH, pixels * 4);
        depth_memory.allocated_bytes = gpu.allocations().added_since(&before, DEPTH).unwrap_or(pixels * 4);
        let depth = depth.create_view(&Default::default());
        Ok(Self { view: *view, primitives, depth, depth_memory, shading, drawing_bytes: 0 })
    }

    /// Enters what is kept, and what is held while it is drawn.
    pub(crate) fn enter(&self, ledger: &mut Ledger) {
        for part in [&self.primitives.memory, &self.depth_memory] {
            ledger.keep(&part.name, part.allocated_bytes, part.used_bytes);
        }
        ledger.keep(SHADING, self.shading.size(), self.shading.size());
        ledger.borrow_transient(self.drawing_bytes + size_of::<ViewUniform>() as u64);
    }

    /// The surfaces, row by row from the top.
    #[cfg(test)]
    pub(crate) fn read(&self, gpu: &Gpu) -> Result<Vec<Surface>, TracerError> {
        Ok(bytemuck::pod_collect_to_vec(&gpu.read(&self.shading, self.shading.size())?))
    }
}

impl Visibility {
    pub(crate) fn new(gpu: &Gpu) -> Result<Self, TracerError> {
        Ok(Self {
            primitives: NearestLayers::of_primitives(gpu)?,
            resolve: compute_pipeline(gpu, VISIBILITY, "resolve")?,
        })
    }

    /// Records the phase "direct visibility", into the frame that is there where its size serves.
    pub(crate) fn record(
        &self,
        gpu: &Gpu,
        scene: NearestScene<'_>,
        there: Option<&Frame>,
        clock: &mut PhaseClock<'_>,
    ) -> Result<Frame, TracerError> {
        let NearestScene { raster_backend, view, geometry: device, triangle_count } = scene;
        let drawing = NearestLayers::memory(NearestOf::Primitives, raster_backend, view.size, triangle_count, 1);
        let drawing_bytes = drawing.iter().map(|entry| entry.allocated_bytes).sum();
        let frame = match there.filter(|there| there.view.size == view.size) {
            Some(there) => Frame { view: *view, drawing_bytes, ..there.clone() },
            None => Frame { drawing_bytes, ..Frame::new(gpu, view)? },
        };
        gpu.check_storage_binding("triangle materials", device.materials.size(), "the scene's triangle count")?;
        let drawn = self.primitives.prepare(gpu, scene, None)?;
        let uniform = view_uniform(view);
        let uniform = gpu.buffer_with(VIEW, bytemuck::bytes_of(&uniform), BufferUsages::UNIFORM, "nothing")?;
        let resources = [
            uniform.as_entire_binding(),
            device.positions.as_entire_binding(),
            device.indices.as_entire_binding(),
            device.materials.as_entire_binding(),
            BindingResource::TextureView(&frame.primitives.view),
            frame.shading.as_entire_binding(),
        ];
        let resolved = bind_group(gpu, &self.resolve.get_bind_group_layout(0), &resources);
        let pixels = view.size[0] * view.size[1];
        clock.device_phase("direct visibility", |encoder| {
            let layer = LayerTarget { image: &frame.primitives.view, layer: 0, test: &frame.depth };
            self.primitives.record(encoder, &drawn, layer);
            dispatch_linear(encoder, &self.resolve, &resolved, pixels, WORKGROUP_SIZE);
        })?;
        Ok(frame)
    }
}

impl Pipelines {
    /// Records direct visibility, if the parameters ask for it.
    pub(crate) fn show(
        &self,
        viewpoint: &Viewpoint,
        parameters: &DirtParameters,
        scene: &Resident,
        there: Option<&Frame>,
        clock: &mut PhaseClock<'_>,
    ) -> Result<Option<Frame>, TracerError> {
        if parameters.direct_visibility == DirectVisibility::Off {
            return Ok(None);
        }
        let (view, raster_backend) = (viewpoint.frame_view(), parameters.build);
        let (geometry, triangle_count) = (&scene.surfaces.device, scene.triangle_count);
        let drawn = NearestScene { raster_backend, view: &view, geometry, triangle_count };
        self.visibility()?.record(&self.gpu, drawn, there, clock).map(Some)
    }
}
