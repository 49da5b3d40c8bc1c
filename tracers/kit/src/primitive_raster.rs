//! The nearest triangle at every pixel of one view, by the hardware rasterizer.

use tracebench_api::wgpu::{self, BindGroup, TextureFormat, TextureUsages, TextureView};
use tracebench_api::{DeviceGeometry, Gpu, MemoryEntry, TracerError, View};
use tracebench_shaders::shared::NearestRaster as Variant;

use crate::nearest_raster::NearestRaster;

const FORMAT: TextureFormat = TextureFormat::R32Uint;

const TEXTURE: &str = "primitive id texture";

/// The pipeline that rasterizes triangles' numbers.
#[derive(Debug)]
pub struct PrimitiveRaster {
    raster: NearestRaster,
}

/// One u32 a pixel: the nearest triangle at the pixel's centre, or [`tracebench_api::NO_PRIMITIVE`].
#[derive(Clone, Debug)]
pub struct PrimitiveTexture {
    /// The texture.
    pub view: TextureView,
    /// What it takes: as the device's allocator says, or by its pixels where that says nothing.
    pub memory: MemoryEntry,
}

impl PrimitiveTexture {
    /// What a texture takes by its pixels.
    pub fn memory_of([width, height]: [u32; 2]) -> MemoryEntry {
        MemoryEntry::whole(TEXTURE, u64::from(width) * u64::from(height) * 4)
    }

    /// Creates the texture.
    ///
    /// # Errors
    /// [`TracerError::Failed`] if the device refuses it.
    pub fn new(gpu: &Gpu, size: [u32; 2]) -> Result<Self, TracerError> {
        let before = gpu.allocations();
        let usage = TextureUsages::RENDER_ATTACHMENT | TextureUsages::TEXTURE_BINDING;
        let texture = create_texture(gpu, TEXTURE, size, FORMAT, usage);
        gpu.check()?;
        let mut memory = Self::memory_of(size);
        memory.allocated_bytes = gpu.allocations().added_since(&before, TEXTURE).unwrap_or(memory.used_bytes);
        Ok(Self { view: texture.create_view(&Default::default()), memory })
    }
}

/// A texture of one level and one layer.
pub fn create_texture(
    gpu: &Gpu,
    name: &str,
    [width, height]: [u32; 2],
    format: TextureFormat,
    usage: TextureUsages,
) -> wgpu::Texture {
    gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some(name),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage,
        view_formats: &[],
    })
}

impl PrimitiveRaster {
    /// Creates the pipeline.
    ///
    /// # Errors
    /// [`TracerError::Failed`] if the device refuses it.
    pub fn new(gpu: &Gpu) -> Result<Self, TracerError> {
        Ok(Self { raster: NearestRaster::new(gpu, Variant { primitives: true }, FORMAT)? })
    }

    /// What drawing takes while it runs, beside the texture.
    pub fn memory() -> MemoryEntry {
        let (name, bytes) = NearestRaster::UNIFORM;
        MemoryEntry::whole(name, bytes)
    }

    /// Prepares one view.
    ///
    /// # Errors
    /// [`TracerError::TooLarge`] if the device cannot bind the scene.
    pub fn bind(&self, gpu: &Gpu, view: &View, geometry: &DeviceGeometry) -> Result<BindGroup, TracerError> {
        self.raster.bind(gpu, view, geometry)
    }

    /// Records the pass that draws all triangles, with a depth test in a texture of the same size.
    pub fn record(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        bindings: &BindGroup,
        triangle_count: u32,
        target: &TextureView,
        depth_test: &TextureView,
    ) {
        let nothing = f64::from(tracebench_api::NO_PRIMITIVE);
        self.raster.record(encoder, bindings, triangle_count, nothing, [target, depth_test]);
    }
}
