//! Surfaces of methods that march over images of depth and whose hits name no triangle: the view is drawn once more with the
//! triangles' numbers, in the trace's own time, and normal and material are those of the triangle at the pixel of the hit.

use tracebench_api::wgpu::{Buffer, BufferUsages};
use tracebench_api::{Gpu, HitBuffer, MemoryEntry, PhaseClock, RayBuffer, TracerError, View};

use crate::{
    EyeDepthTarget, Gather, LayerTarget, NearestLayers, NearestOf, NearestScene, PrimitiveTexture, RasterBackend,
    SurfaceGeometry,
};

/// Name of the triangles that rays saw.
const SEEN: &str = "hit primitives";

/// The pipelines.
#[derive(Debug)]
pub struct VisibilityPass {
    layers: NearestLayers,
    gather: Gather,
}

/// What is drawn again: a view as its depths were drawn, layer behind layer.
#[derive(Clone, Copy, Debug)]
pub struct VisibilityView<'a> {
    /// What draws.
    pub raster_backend: RasterBackend,
    /// The view.
    pub view: &'a View,
    /// The scene as the structure has it.
    pub geometry: &'a SurfaceGeometry,
    /// Its triangles.
    pub triangle_count: u32,
    /// The depths: the first images are the layers.
    pub target: &'a EyeDepthTarget,
    /// Layers.
    pub layers: u32,
    /// By how much a layer lies behind the one before, scene units.
    pub separation: f32,
}

/// What a trace to surfaces holds: the triangles at the view's pixels, and room for the one that each ray saw.
#[derive(Debug)]
pub struct VisibilityBuffer {
    /// Layer by layer.
    pub primitives: PrimitiveTexture,
    /// One u32 a ray.
    pub triangles: Buffer,
}

impl VisibilityPass {
    /// Creates the pipelines.
    ///
    /// # Errors
    /// [`TracerError::Failed`] if the device refuses one.
    pub fn new(gpu: &Gpu) -> Result<Self, TracerError> {
        Ok(Self { layers: NearestLayers::of_primitives(gpu)?, gather: Gather::new(gpu)? })
    }

    /// Records the phase "rasterize primitives" and makes room for what so many rays see.
    ///
    /// # Errors
    /// [`TracerError::TooLarge`] if the device cannot bind the scene or the rays' triangles.
    pub fn draw(
        &self,
        gpu: &Gpu,
        seen: VisibilityView<'_>,
        rays: usize,
        clock: &mut PhaseClock<'_>,
    ) -> Result<VisibilityBuffer, TracerError> {
        let VisibilityView { raster_backend, view, geometry, triangle_count, target, layers, separation } = seen;
        let primitives = PrimitiveTexture::of_layers(gpu, view.size, layers)?;
        let scene = NearestScene { raster_backend, view, geometry: &geometry.device, triangle_count };
        let passes = (0..layers as usize).map(|layer| {
            let passed = layer.checked_sub(1).map(|before| (&target.images[before], crate::behind(separation)));
            self.layers.prepare(gpu, scene, passed)
        });
        let passes = passes.collect::<Result<Vec<_>, _>>()?;
        clock.device_phase("rasterize primitives", |encoder| {
            for ((layer, image), pass) in (0..).zip(&primitives.layers).zip(&passes) {
                self.layers.record(encoder, pass, LayerTarget { image, layer, test: &target.test });
            }
        })?;
        let bytes = Self::triangle_bytes(rays);
        gpu.check_storage_binding(SEEN, bytes, "--size")?;
        let triangles = gpu.buffer(SEEN, bytes, BufferUsages::STORAGE, "--size")?;
        Ok(VisibilityBuffer { primitives, triangles })
    }

    /// Records the phase "gather", after the search has written what every ray saw.
    ///
    /// # Errors
    /// As [`Gather::record`].
    pub fn gather(
        &self,
        gpu: &Gpu,
        geometry: &SurfaceGeometry,
        rays: &RayBuffer,
        hits: &HitBuffer,
        seen: &VisibilityBuffer,
        clock: &mut PhaseClock<'_>,
    ) -> Result<(), TracerError> {
        self.gather.record(gpu, geometry, rays, hits, Some(&seen.triangles), clock)
    }

    /// What a trace to surfaces takes beside the search; `last` is what the last texture of triangles took.
    pub fn memory(
        raster_backend: RasterBackend,
        size: [u32; 2],
        triangle_count: u32,
        layers: u32,
        rays: usize,
        last: Option<MemoryEntry>,
    ) -> Vec<MemoryEntry> {
        let mut parts = vec![
            last.unwrap_or_else(|| PrimitiveTexture::memory_of(size, layers)),
            MemoryEntry::whole(SEEN, Self::triangle_bytes(rays)),
            Gather::memory(),
        ];
        parts.extend(NearestLayers::memory(NearestOf::Primitives, raster_backend, size, triangle_count, layers));
        parts
    }

    fn triangle_bytes(rays: usize) -> u64 {
        rays.max(1) as u64 * 4
    }
}
