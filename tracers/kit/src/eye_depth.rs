//! Images of linear eye depth of one view: the nearest surface at every pixel, and what lies behind it.

use tracebench_api::wgpu::{
    self, COPY_BYTES_PER_ROW_ALIGNMENT, TexelCopyBufferInfo, TexelCopyBufferLayout, TextureFormat, TextureUsages,
    TextureView,
};
use tracebench_api::{Gpu, Ledger, TracerError};

use crate::texture::{create_texture, create_texture_array, views_of};
use crate::{GrowableBuffer, MemoryAccess, ReadSlot, Readable};

/// The eye depth stored where no surface covers a pixel's centre: beyond every surface.
pub const NO_SURFACE: f32 = 1e30;

pub(crate) const DEPTH_FORMAT: TextureFormat = TextureFormat::R32Float;
const EYE_DEPTH: &str = "eye depth buffer";
const DEPTH_TEST: &str = "depth test buffer";
const DEPTH_COPY: &str = "eye depths in a buffer";

/// The textures of one view: one image of eye depths, or several of the same size.
#[derive(Clone, Debug)]
pub struct EyeDepthTarget {
    /// One f32 a pixel: linear eye depth at the pixel's centre, or [`NO_SURFACE`]. The first image.
    pub eye_depth: TextureView,
    /// Each image by itself.
    pub images: Vec<TextureView>,
    /// All of them as an array.
    pub all: TextureView,
    /// The depth test's own buffer, which holds nothing between passes.
    pub test: TextureView,
    /// Pixels of all images.
    pixels: u64,
    /// Pixels of one.
    image_pixels: u64,
    /// Bytes allocated for the eye depth and for the depth test.
    allocated: [u64; 2],
}

impl EyeDepthTarget {
    /// Creates the textures of one image.
    ///
    /// # Errors
    /// [`TracerError::Failed`] if an edge exceeds the device's limit.
    pub fn new(gpu: &Gpu, size: [u32; 2]) -> Result<Self, TracerError> {
        Self::of_images(gpu, size, 1)
    }

    /// Creates those of so many.
    ///
    /// # Errors
    /// As [`EyeDepthTarget::new`].
    pub fn of_images(gpu: &Gpu, size: [u32; 2], images: u32) -> Result<Self, TracerError> {
        let limit = gpu.limits.max_texture_dimension_2d;
        if let Some(edge) = size.into_iter().find(|edge| *edge > limit) {
            return Err(TracerError::Failed(format!(
                "the eye depth buffer has an edge of {edge} pixels, the device allows {limit}: turn down --frame-size"
            )));
        }
        let before = gpu.allocations();
        let copied = TextureUsages::COPY_SRC | TextureUsages::COPY_DST;
        let usage = TextureUsages::RENDER_ATTACHMENT | TextureUsages::TEXTURE_BINDING | copied;
        let depths = create_texture_array(gpu, EYE_DEPTH, size, images, DEPTH_FORMAT, usage);
        let test = create_texture(gpu, DEPTH_TEST, size, crate::DEPTH_TEST_FORMAT, TextureUsages::RENDER_ATTACHMENT);
        gpu.check()?;
        let image_pixels = u64::from(size[0]) * u64::from(size[1]);
        let pixels = image_pixels * u64::from(images);
        // Drivers pad textures as they like.
        let after = gpu.allocations();
        let allocated = |name, bytes| after.added_since(&before, name).unwrap_or(bytes);
        let (each, all) = views_of(&depths);
        Ok(Self {
            eye_depth: each[0].clone(),
            images: each,
            all,
            test: test.create_view(&Default::default()),
            pixels,
            image_pixels,
            allocated: [allocated(EYE_DEPTH, pixels * 4), allocated(DEPTH_TEST, image_pixels * 4)],
        })
    }

    /// Enters both textures. What is allocated is what the device's allocator says, and where it says nothing, what is
    /// used; the depth test's is kept so that the next build need not create it.
    pub fn enter(&self, ledger: &mut Ledger) {
        let used = [self.pixels * 4, self.image_pixels * 4];
        for ((name, allocated), used) in [EYE_DEPTH, DEPTH_TEST].into_iter().zip(self.allocated).zip(used) {
            ledger.keep(name, allocated, used);
        }
    }

    /// Reads the eye depths of the first image back, row by row from the top.
    ///
    /// # Errors
    /// [`TracerError::Failed`] if the device fails.
    pub fn read(&self, gpu: &Gpu) -> Result<Vec<f32>, TracerError> {
        self.read_image(gpu, 0)
    }

    /// Reads those of any image.
    ///
    /// # Errors
    /// As [`EyeDepthTarget::read`].
    pub fn read_image(&self, gpu: &Gpu, image: u32) -> Result<Vec<f32>, TracerError> {
        let texture = self.eye_depth.texture();
        let (width, height) = (texture.width(), texture.height());
        let row_bytes = row_bytes(width);
        let bytes = u64::from(row_bytes) * u64::from(height);
        let usage = wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC;
        let staging = gpu.buffer("eye depth read back", bytes, usage, "--frame-size")?;
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let origin = wgpu::Origin3d { z: image, ..Default::default() };
        encoder.copy_texture_to_buffer(
            wgpu::TexelCopyTextureInfo { origin, ..texture.as_image_copy() },
            TexelCopyBufferInfo {
                buffer: &staging,
                layout: TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row_bytes), rows_per_image: None },
            },
            wgpu::Extent3d { depth_or_array_layers: 1, ..texture.size() },
        );
        gpu.queue.submit([encoder.finish()]);
        let padded = gpu.read(&staging, bytes)?;
        let rows = padded.chunks_exact(row_bytes as usize);
        Ok(rows.flat_map(|row| bytemuck::pod_collect_to_vec::<u8, f32>(&row[..width as usize * 4])).collect())
    }
}

/// What to turn down where so many images are too large for a device.
pub(crate) fn hint(images: u32) -> &'static str {
    if images > 1 { "--frame-size, or the number of layers" } else { "--frame-size" }
}

/// Bytes of a row of a copy.
fn row_bytes(width: u32) -> u32 {
    (width * 4).next_multiple_of(COPY_BYTES_PER_ROW_ALIGNMENT)
}

/// A copy of all images of eye depths in a buffer, row by row, image after image: for searches that read buffers. Those that read
/// textures read the images themselves.
#[derive(Clone, Debug)]
pub struct DepthCopy {
    room: GrowableBuffer,
    array: Readable,
    row_bytes: u32,
    rows: u32,
}

impl DepthCopy {
    /// Room for so many images; searches read it as words 0.
    ///
    /// # Errors
    /// [`TracerError::TooLarge`] beyond the device's limits.
    pub fn new(gpu: &Gpu, [width, height]: [u32; 2], images: u32) -> Result<Self, TracerError> {
        let row_bytes = row_bytes(width);
        let bytes = u64::from(row_bytes) * u64::from(height) * u64::from(images);
        let hint = hint(images);
        let room = GrowableBuffer::new(gpu, DEPTH_COPY, bytes, hint, None)?;
        let array =
            Readable::built(gpu, MemoryAccess::Buffer, ReadSlot::Words0, &room.buffer, bytes, DEPTH_COPY, None, hint)?;
        Ok(Self { room, array, row_bytes, rows: height })
    }

    /// Records the copy.
    pub fn record(&self, encoder: &mut wgpu::CommandEncoder, target: &EyeDepthTarget) {
        let texture = target.eye_depth.texture();
        let layout =
            TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(self.row_bytes), rows_per_image: Some(self.rows) };
        let copy = TexelCopyBufferInfo { buffer: &self.room.buffer, layout };
        encoder.copy_texture_to_buffer(texture.as_image_copy(), copy, texture.size());
    }

    /// What searches read.
    pub fn array(&self) -> &Readable {
        &self.array
    }

    /// Words of a row.
    pub fn row_words(&self) -> u32 {
        self.row_bytes / 4
    }

    /// Words of an image.
    pub fn image_words(&self) -> u32 {
        self.row_words() * self.rows
    }

    /// Enters the buffer.
    pub fn enter(&self, ledger: &mut Ledger) {
        self.room.enter(ledger);
    }
}
