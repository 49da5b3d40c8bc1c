//! Words of nodes and triangles in textures, from which the searches read them.

use tracebench_api::wgpu::{self, Extent3d, TexelCopyBufferInfo, TexelCopyBufferLayout, TextureUsages, TextureView};
use tracebench_api::{Gpu, Ledger, TracerError};

/// Texels a row are two to the power of it: `ROW_BITS` of shaders/bvh/search.wgsl. Every device can create textures of
/// that width.
pub const ROW_BITS: u32 = 11;

/// Bytes of a texel, four words.
const TEXEL_BYTES: u32 = 16;

/// Bytes of a row.
const ROW_BYTES: u32 = TEXEL_BYTES << ROW_BITS;

/// A texture of words, row by row.
#[derive(Clone, Debug)]
pub(crate) struct Texels {
    name: &'static str,
    view: TextureView,
    /// Bytes in use.
    used: u64,
    /// Bytes allocated, by the device's own report: drivers pad textures as they like.
    allocated: u64,
}

impl Texels {
    /// Writes into the texture that is there if it is large enough, else into a new one. `contents` are whole texels.
    ///
    /// # Errors
    /// [`TracerError::TooLarge`] beyond the device's limits, naming `turn_down` as the remedy.
    pub(crate) fn write(
        gpu: &Gpu,
        name: &'static str,
        contents: &[u8],
        there: Option<&Texels>,
        turn_down: &str,
    ) -> Result<Self, TracerError> {
        let texels = Self::room(gpu, name, contents.len() as u64, there, turn_down)?;
        let whole_rows = contents.len() / ROW_BYTES as usize;
        let (whole, rest) = contents.split_at(whole_rows * ROW_BYTES as usize);
        let rest_texels = rest.len() as u32 / TEXEL_BYTES;
        let parts = [(whole, 0, [1 << ROW_BITS, whole_rows as u32]), (rest, whole_rows as u32, [rest_texels, 1])];
        for (bytes, first_row, [width, height]) in parts.into_iter().filter(|(bytes, ..)| !bytes.is_empty()) {
            let origin = wgpu::Origin3d { x: 0, y: first_row, z: 0 };
            let target = wgpu::TexelCopyTextureInfo { origin, ..texels.view.texture().as_image_copy() };
            let size = Extent3d { width, height, depth_or_array_layers: 1 };
            gpu.queue.write_texture(target, bytes, layout(), size);
        }
        Ok(texels)
    }

    /// The texture that is there if it has room for so many bytes, else a new one.
    ///
    /// # Errors
    /// As [`Texels::write`].
    pub(crate) fn room(
        gpu: &Gpu,
        name: &'static str,
        used: u64,
        there: Option<&Texels>,
        turn_down: &str,
    ) -> Result<Self, TracerError> {
        Self::check(gpu, name, used as usize, turn_down)?;
        let (view, allocated) = match there.filter(|there| there.capacity() >= used) {
            Some(there) => (there.view.clone(), there.allocated),
            None => create(gpu, name, rows(used))?,
        };
        Ok(Self { name, view, used, allocated })
    }

    /// Records a copy of what is in use from a buffer of [`whole_rows`].
    pub(crate) fn record_copy(&self, encoder: &mut wgpu::CommandEncoder, from: &wgpu::Buffer) {
        let size = Extent3d { width: 1 << ROW_BITS, height: rows(self.used), depth_or_array_layers: 1 };
        let source = TexelCopyBufferInfo { buffer: from, layout: layout() };
        encoder.copy_buffer_to_texture(source, self.view.texture().as_image_copy(), size);
    }

    /// Checks that the device can hold that many bytes in one texture.
    ///
    /// # Errors
    /// [`TracerError::TooLarge`] if not.
    pub(crate) fn check(gpu: &Gpu, name: &str, bytes: usize, turn_down: &str) -> Result<(), TracerError> {
        let limit = u64::from(gpu.limits.max_texture_dimension_2d) * u64::from(ROW_BYTES);
        if bytes as u64 <= limit {
            return Ok(());
        }
        Err(TracerError::TooLarge {
            name: name.to_owned(),
            bytes: bytes as u64,
            limit,
            turn_down: turn_down.to_owned(),
        })
    }

    /// What is bound.
    pub(crate) fn view(&self) -> &TextureView {
        &self.view
    }

    /// Bytes in use.
    pub(crate) fn used(&self) -> u64 {
        self.used
    }

    /// Enters the texture.
    pub(crate) fn enter(&self, ledger: &mut Ledger) {
        ledger.keep(self.name, self.allocated, self.used);
    }

    /// Reads what is in use back.
    ///
    /// # Errors
    /// [`TracerError::Failed`] if the device fails.
    pub(crate) fn read(&self, gpu: &Gpu) -> Result<Vec<u8>, TracerError> {
        let texture = self.view.texture();
        let row_count = rows(self.used);
        let bytes = u64::from(row_count) * u64::from(ROW_BYTES);
        let usage = wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC;
        let copy = gpu.buffer(self.name, bytes, usage, "the scene's triangle count")?;
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        encoder.copy_texture_to_buffer(
            texture.as_image_copy(),
            TexelCopyBufferInfo { buffer: &copy, layout: layout() },
            Extent3d { height: row_count, ..texture.size() },
        );
        gpu.queue.submit([encoder.finish()]);
        let mut contents = gpu.read(&copy, bytes)?;
        contents.truncate(self.used as usize);
        Ok(contents)
    }

    /// Bytes that there is room for.
    fn capacity(&self) -> u64 {
        u64::from(self.view.texture().height()) * u64::from(ROW_BYTES)
    }
}

/// Bytes of the rows that hold so many.
pub(crate) fn whole_rows(bytes: u64) -> u64 {
    u64::from(rows(bytes)) * u64::from(ROW_BYTES)
}

/// Rows that hold so many bytes, one at least.
fn rows(bytes: u64) -> u32 {
    bytes.div_ceil(u64::from(ROW_BYTES)).max(1) as u32
}

fn layout() -> TexelCopyBufferLayout {
    TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(ROW_BYTES), rows_per_image: None }
}

/// A texture, and what it takes.
fn create(gpu: &Gpu, name: &str, height: u32) -> Result<(TextureView, u64), TracerError> {
    let before = gpu.allocations();
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some(name),
        size: Extent3d { width: 1 << ROW_BITS, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba32Uint,
        usage: TextureUsages::STORAGE_BINDING | TextureUsages::COPY_DST | TextureUsages::COPY_SRC,
        view_formats: &[],
    });
    gpu.check()?;
    let told = gpu.allocations().added_since(&before, name);
    let allocated = told.unwrap_or(u64::from(height) * u64::from(ROW_BYTES));
    Ok((texture.create_view(&Default::default()), allocated))
}
