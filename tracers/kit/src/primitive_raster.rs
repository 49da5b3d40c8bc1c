//! The nearest triangle at every pixel of one view, by the hardware rasterizer.

use tracebench_api::wgpu::{self, BindGroup, TextureFormat, TextureUsages, TextureView};
use tracebench_api::{DeviceGeometry, Gpu, MemoryEntry, TracerError, View};
use tracebench_shaders::shared::NearestRaster as Variant;

use crate::nearest_raster::NearestRaster;
use crate::texture::{create_texture_array, views_of};

pub(crate) const PRIMITIVE_FORMAT: TextureFormat = TextureFormat::R32Uint;

const TEXTURE: &str = "primitive id texture";

/// The pipeline that rasterizes triangles' numbers.
#[derive(Debug)]
pub struct PrimitiveRaster {
    raster: NearestRaster,
}

/// One u32 a pixel: the nearest triangle at the pixel's centre, or [`tracebench_api::NO_PRIMITIVE`]; of one layer, or of several.
#[derive(Clone, Debug)]
pub struct PrimitiveTexture {
    /// The first layer.
    pub view: TextureView,
    /// Each layer by itself.
    pub layers: Vec<TextureView>,
    /// All of them as an array.
    pub all: TextureView,
    /// What it takes: as the device's allocator says, or by its pixels where that says nothing.
    pub memory: MemoryEntry,
}

impl PrimitiveTexture {
    /// What a texture takes by its pixels.
    pub fn memory_of([width, height]: [u32; 2], layers: u32) -> MemoryEntry {
        MemoryEntry::whole(TEXTURE, u64::from(width) * u64::from(height) * u64::from(layers) * 4)
    }

    /// Creates the texture of one layer.
    ///
    /// # Errors
    /// [`TracerError::Failed`] if the device refuses it.
    pub fn new(gpu: &Gpu, size: [u32; 2]) -> Result<Self, TracerError> {
        Self::of_layers(gpu, size, 1)
    }

    /// Creates that of so many.
    ///
    /// # Errors
    /// As [`PrimitiveTexture::new`].
    pub fn of_layers(gpu: &Gpu, size: [u32; 2], layers: u32) -> Result<Self, TracerError> {
        let before = gpu.allocations();
        let usage = TextureUsages::RENDER_ATTACHMENT | TextureUsages::TEXTURE_BINDING;
        let texture = create_texture_array(gpu, TEXTURE, size, layers, PRIMITIVE_FORMAT, usage);
        gpu.check()?;
        let mut memory = Self::memory_of(size, layers);
        memory.allocated_bytes = gpu.allocations().added_since(&before, TEXTURE).unwrap_or(memory.used_bytes);
        let (each, all) = views_of(&texture);
        Ok(Self { view: each[0].clone(), layers: each, all, memory })
    }
}

impl PrimitiveRaster {
    /// Creates the pipeline.
    ///
    /// # Errors
    /// [`TracerError::Failed`] if the device refuses it.
    pub fn new(gpu: &Gpu) -> Result<Self, TracerError> {
        Ok(Self { raster: NearestRaster::new(gpu, Variant { primitives: true, behind: false }, PRIMITIVE_FORMAT)? })
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
        self.raster.bind(gpu, view, geometry, None)
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
