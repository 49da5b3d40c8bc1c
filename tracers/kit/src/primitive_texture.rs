//! Images of triangles' numbers of one view: the nearest at every pixel, and those behind it.

use tracebench_api::wgpu::{TextureFormat, TextureUsages, TextureView};
use tracebench_api::{Gpu, MemoryEntry, TracerError};

use crate::texture::{create_texture_array, views_of};

pub(crate) const PRIMITIVE_FORMAT: TextureFormat = TextureFormat::R32Uint;

const TEXTURE: &str = "primitive id texture";

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
        let usage = TextureUsages::RENDER_ATTACHMENT | TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_DST;
        let texture = create_texture_array(gpu, TEXTURE, size, layers, PRIMITIVE_FORMAT, usage);
        gpu.check()?;
        let mut memory = Self::memory_of(size, layers);
        memory.allocated_bytes = gpu.allocations().added_since(&before, TEXTURE).unwrap_or(memory.used_bytes);
        let (each, all) = views_of(&texture);
        Ok(Self { view: each[0].clone(), layers: each, all, memory })
    }
}
