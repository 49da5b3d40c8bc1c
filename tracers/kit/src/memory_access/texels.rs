//! Textures of records.

use tracebench_api::wgpu::{
    self, Buffer, Extent3d, TexelCopyBufferInfo, TexelCopyBufferLayout, TextureUsages, TextureView,
};
use tracebench_api::{Gpu, Ledger, TracerError};

use super::{ROW_BYTES, ReadSlot};

/// Records in a texture, row by row.
#[derive(Clone, Debug)]
pub(super) struct Texels {
    name: &'static str,
    slot: ReadSlot,
    pub view: TextureView,
    /// Bytes in use.
    used: u64,
    /// Bytes allocated, by the device's own report: drivers pad textures as they like.
    allocated: u64,
}

impl Texels {
    /// The texture that is there if it has room for so many bytes, else a new one. `used` are whole records of the slot.
    ///
    /// # Errors
    /// [`TracerError::TooLarge`] beyond the device's limits, naming `hint` as the remedy.
    pub fn room(
        gpu: &Gpu,
        name: &'static str,
        slot: ReadSlot,
        used: u64,
        there: Option<&Texels>,
        hint: &str,
    ) -> Result<Self, TracerError> {
        Self::check(gpu, name, used, hint)?;
        let fits = |there: &&Texels| (there.name, there.slot) == (name, slot) && there.capacity() >= used;
        let (view, allocated) = match there.filter(fits) {
            Some(there) => (there.view.clone(), there.allocated),
            None => create(gpu, name, slot, rows(used))?,
        };
        Ok(Self { name, slot, view, used, allocated })
    }

    /// Writes records from the host, into the texture that is there if it is large enough.
    ///
    /// # Errors
    /// As [`Texels::room`].
    pub fn write(
        gpu: &Gpu,
        name: &'static str,
        slot: ReadSlot,
        contents: &[u8],
        there: Option<&Texels>,
        hint: &str,
    ) -> Result<Self, TracerError> {
        let texels = Self::room(gpu, name, slot, contents.len() as u64, there, hint)?;
        for Part { first_byte, first_row, size } in slot.parts(contents.len() as u64) {
            let origin = wgpu::Origin3d { x: 0, y: first_row, z: 0 };
            let target = wgpu::TexelCopyTextureInfo { origin, ..texels.view.texture().as_image_copy() };
            gpu.queue.write_texture(target, &contents[first_byte as usize..], layout(0), size);
        }
        Ok(texels)
    }

    /// Records a copy of so many bytes of each of some buffers of usage `COPY_SRC`, each from a row of its own on.
    pub fn record_copies(&self, encoder: &mut wgpu::CommandEncoder, sources: &[(Buffer, u64)]) {
        let mut begin = 0;
        for (from, bytes) in sources {
            for Part { first_byte, first_row, size } in self.slot.parts(*bytes) {
                let origin = wgpu::Origin3d { x: 0, y: begin + first_row, z: 0 };
                let source = TexelCopyBufferInfo { buffer: from, layout: layout(first_byte) };
                let target = wgpu::TexelCopyTextureInfo { origin, ..self.view.texture().as_image_copy() };
                encoder.copy_buffer_to_texture(source, target, size);
            }
            begin += rows(*bytes);
        }
    }

    /// Checks that the device can hold that many bytes in one texture.
    ///
    /// # Errors
    /// [`TracerError::TooLarge`] if not.
    pub fn check(gpu: &Gpu, name: &str, bytes: u64, hint: &str) -> Result<(), TracerError> {
        let limit = u64::from(gpu.limits.max_texture_dimension_2d) * u64::from(ROW_BYTES);
        if bytes <= limit {
            return Ok(());
        }
        let hint = format!("{hint}, or read it from a buffer (memory_access=buffer)");
        Err(TracerError::TooLarge { name: name.to_owned(), bytes, limit, hint })
    }

    /// Bytes in use.
    pub fn used(&self) -> u64 {
        self.used
    }

    /// Enters the texture.
    pub fn enter(&self, ledger: &mut Ledger) {
        ledger.keep(self.name, self.allocated, self.used);
    }

    /// Reads what is in use back.
    ///
    /// # Errors
    /// [`TracerError::Failed`] if the device fails.
    pub fn read(&self, gpu: &Gpu) -> Result<Vec<u8>, TracerError> {
        let texture = self.view.texture();
        let row_count = rows(self.used);
        let bytes = u64::from(row_count) * u64::from(ROW_BYTES);
        let usage = wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC;
        let copy = gpu.buffer(self.name, bytes, usage, "the scene's triangle count")?;
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        encoder.copy_texture_to_buffer(
            texture.as_image_copy(),
            TexelCopyBufferInfo { buffer: &copy, layout: layout(0) },
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

impl ReadSlot {
    /// Whole rows of so many bytes, and what is left of one.
    fn parts(self, bytes: u64) -> impl Iterator<Item = Part> {
        let whole_rows = (bytes / u64::from(ROW_BYTES)) as u32;
        let rest_records = (bytes % u64::from(ROW_BYTES)) as u32 / self.record_bytes();
        let part = |first_row: u32, width: u32, height: u32| Part {
            first_byte: u64::from(first_row) * u64::from(ROW_BYTES),
            first_row,
            size: Extent3d { width, height, depth_or_array_layers: 1 },
        };
        let parts = [part(0, self.width(), whole_rows), part(whole_rows, rest_records, 1)];
        parts.into_iter().filter(|part| part.size.width > 0 && part.size.height > 0)
    }
}

/// A rectangle of a texture that a run of bytes fills.
struct Part {
    first_byte: u64,
    first_row: u32,
    size: Extent3d,
}

/// Rows that hold so many bytes, one at least.
pub(super) fn rows(bytes: u64) -> u32 {
    bytes.div_ceil(u64::from(ROW_BYTES)).max(1) as u32
}

fn layout(offset: u64) -> TexelCopyBufferLayout {
    TexelCopyBufferLayout { offset, bytes_per_row: Some(ROW_BYTES), rows_per_image: None }
}

/// A texture, and what it takes.
fn create(gpu: &Gpu, name: &str, slot: ReadSlot, height: u32) -> Result<(TextureView, u64), TracerError> {
    let before = gpu.allocations();
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some(name),
        size: Extent3d { width: slot.width(), height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: slot.format(),
        usage: TextureUsages::STORAGE_BINDING | TextureUsages::COPY_DST | TextureUsages::COPY_SRC,
        view_formats: &[],
    });
    gpu.check()?;
    let told = gpu.allocations().added_since(&before, name);
    let allocated = told.unwrap_or(u64::from(height) * u64::from(ROW_BYTES));
    Ok((texture.create_view(&Default::default()), allocated))
}
