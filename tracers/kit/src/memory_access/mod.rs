//! How a search reads a structure: arrays in buffers, or copies of them in textures (shaders/shared/reads.wgsl).

use tracebench_api::wgpu::{BindGroup, BindingResource, Buffer, ComputePipeline, TextureFormat};
use tracebench_api::{Gpu, Ledger, Parameter, ParameterScope, PhaseClock, TracerError, choice};

use self::texels::{Texels, rows};
use crate::{bind_group_at, storage_buffer};

#[cfg(test)]
mod tests;
mod texels;

choice! {
    /// How a search reads a structure.
    pub enum MemoryAccess { Buffer = "buffer", Texture = "texture" }
}

/// The parameter `memory_access`, the same for every tracer that searches on the device.
pub fn memory_access_parameter() -> Parameter<MemoryAccess> {
    let effect = "what the search reads the structure from: buffers, or textures that the build fills or copies it to: more \
                  memory and longer builds, for drivers that gather from textures faster";
    Parameter::choice(ParameterScope::Build, MemoryAccess::Buffer).effect(effect)
}

/// Bytes of a row are two to the power of it, as in shaders/shared/reads.wgsl. Every device can create textures of that
/// width and of so many rows that they hold more than what it is sure to bind of a buffer.
pub const ROW_BITS: u32 = 15;

/// The group that the arrays are bound in.
pub const READS_GROUP: u32 = 1;

/// The arrays of shaders/shared/reads.wgsl, in the order of their bindings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ReadSlot {
    /// `quad_0`: records of four words.
    Quads0,
    /// `quad_1`.
    Quads1,
    /// `pair_0`: records of two words.
    Pairs0,
    /// `pair_1`.
    Pairs1,
    /// `word_0`: single words.
    Words0,
    /// `word_1`.
    Words1,
    /// `word_2`.
    Words2,
    /// `word_3`.
    Words3,
}

impl ReadSlot {
    fn format(self) -> TextureFormat {
        match self {
            Self::Quads0 | Self::Quads1 => TextureFormat::Rgba32Uint,
            Self::Pairs0 | Self::Pairs1 => TextureFormat::Rg32Uint,
            Self::Words0 | Self::Words1 | Self::Words2 | Self::Words3 => TextureFormat::R32Uint,
        }
    }

    /// Bytes of a record.
    fn record_bytes(self) -> u32 {
        match self.format() {
            TextureFormat::Rgba32Uint => 16,
            TextureFormat::Rg32Uint => 8,
            _ => 4,
        }
    }

    /// Records of a row.
    fn width(self) -> u32 {
        ROW_BYTES / self.record_bytes()
    }

    /// The first record of each of several buffers of so many bytes in a texture that [`Readable::joined`] makes of them.
    pub fn first_records(self, bytes: impl IntoIterator<Item = u64>) -> Vec<u32> {
        let mut next_row = 0;
        let first = |bytes| {
            let row = next_row;
            next_row += rows(bytes);
            row * self.width()
        };
        bytes.into_iter().map(first).collect()
    }
}

const ROW_BYTES: u32 = 1 << ROW_BITS;

/// An array that a search reads, in a buffer or in a texture.
#[derive(Clone, Debug)]
pub struct Readable {
    slot: ReadSlot,
    held: Held,
}

#[derive(Clone, Debug)]
enum Held {
    /// The buffer that a build fills, which the tracer enters into its ledger itself.
    Built { buffer: Buffer, used: u64 },
    /// A buffer that the host has written.
    Written { name: &'static str, buffer: Buffer, used: u64 },
    /// A texture, with the buffers that it is copied from if builds fill some, and the bytes of each.
    Texture { texels: Texels, from: Vec<(Buffer, u64)> },
}

impl Readable {
    /// The first `bytes` (whole records of the slot) of a buffer that builds fill, of usages `STORAGE` and `COPY_SRC`: itself, or a
    /// texture of the name `copy_name` that [`record_copies`] copies it to, that of `there` where it is large enough.
    ///
    /// # Errors
    /// [`TracerError::TooLarge`] beyond the device's limits, naming `hint` as the remedy.
    #[expect(clippy::too_many_arguments, reason = "each says another thing of the one array")]
    pub fn built(
        gpu: &Gpu,
        memory_access: MemoryAccess,
        slot: ReadSlot,
        buffer: &Buffer,
        bytes: u64,
        copy_name: &'static str,
        there: Option<&Self>,
        hint: &str,
    ) -> Result<Self, TracerError> {
        match memory_access {
            MemoryAccess::Buffer => {
                Self::check(gpu, memory_access, copy_name, buffer.size(), hint)?;
                Ok(Self { slot, held: Held::Built { buffer: buffer.clone(), used: bytes } })
            }
            MemoryAccess::Texture => Self::joined(gpu, slot, &[(buffer, bytes)], copy_name, there, hint),
        }
    }

    /// As [`Readable::built`], several buffers in one texture, which holds more than a binding of a buffer does:
    /// [`ReadSlot::first_records`] tells where in it each begins.
    ///
    /// # Errors
    /// As [`Readable::built`].
    pub fn joined(
        gpu: &Gpu,
        slot: ReadSlot,
        buffers: &[(&Buffer, u64)],
        copy_name: &'static str,
        there: Option<&Self>,
        hint: &str,
    ) -> Result<Self, TracerError> {
        let last = buffers.last().map_or(0, |(_, bytes)| *bytes);
        let rows_before: u64 = buffers.iter().rev().skip(1).map(|(_, bytes)| u64::from(rows(*bytes))).sum();
        let bytes = rows_before * u64::from(ROW_BYTES) + last;
        let texels = Texels::room(gpu, copy_name, slot, bytes, there.and_then(Self::texels), hint)?;
        let from = buffers.iter().map(|(buffer, bytes)| ((*buffer).clone(), *bytes)).collect();
        Ok(Self { slot, held: Held::Texture { texels, from } })
    }

    /// The same array in another slot, of records of the same size: for a shader that asks for more arrays than there are.
    pub fn at(&self, slot: ReadSlot) -> Self {
        assert_eq!(slot.record_bytes(), self.slot.record_bytes(), "records of slots differ");
        Self { slot, held: self.held.clone() }
    }

    /// Whole records of the slot, written by the host to a buffer or texture of this name: into that of `there` where it is large
    /// enough.
    ///
    /// # Errors
    /// As [`Readable::built`].
    pub fn written(
        gpu: &Gpu,
        memory_access: MemoryAccess,
        slot: ReadSlot,
        contents: &[u8],
        name: &'static str,
        there: Option<&Self>,
        hint: &str,
    ) -> Result<Self, TracerError> {
        let used = contents.len() as u64;
        let held = match memory_access {
            MemoryAccess::Buffer => {
                Self::check(gpu, memory_access, name, used, hint)?;
                let fits = |there: &&Buffer| there.size() >= used;
                let buffer = match there.and_then(Self::written_buffer).filter(fits) {
                    Some(there) => there.clone(),
                    None => storage_buffer(gpu, name, used, hint)?,
                };
                gpu.queue.write_buffer(&buffer, 0, contents);
                Held::Written { name, buffer, used }
            }
            MemoryAccess::Texture => {
                let texels = Texels::write(gpu, name, slot, contents, there.and_then(Self::texels), hint)?;
                Held::Texture { texels, from: Vec::new() }
            }
        };
        Ok(Self { slot, held })
    }

    /// Checks that the device can hold and bind that many bytes.
    ///
    /// # Errors
    /// As [`Readable::built`].
    pub fn check(
        gpu: &Gpu,
        memory_access: MemoryAccess,
        name: &str,
        bytes: u64,
        hint: &str,
    ) -> Result<(), TracerError> {
        match memory_access {
            MemoryAccess::Buffer => gpu.check_storage_binding(name, bytes, hint),
            MemoryAccess::Texture => Texels::check(gpu, name, bytes, hint),
        }
    }

    fn texels(&self) -> Option<&Texels> {
        if let Held::Texture { texels, .. } = &self.held { Some(texels) } else { None }
    }

    fn written_buffer(&self) -> Option<&Buffer> {
        if let Held::Written { buffer, .. } = &self.held { Some(buffer) } else { None }
    }

    fn binding(&self) -> BindingResource<'_> {
        match &self.held {
            Held::Built { buffer, .. } | Held::Written { buffer, .. } => buffer.as_entire_binding(),
            Held::Texture { texels, .. } => BindingResource::TextureView(&texels.view),
        }
    }

    /// How it is read.
    pub fn memory_access(&self) -> MemoryAccess {
        if self.texels().is_some() { MemoryAccess::Texture } else { MemoryAccess::Buffer }
    }

    /// Bytes that are read.
    pub fn used(&self) -> u64 {
        match &self.held {
            Held::Built { used, .. } | Held::Written { used, .. } => *used,
            Held::Texture { texels, .. } => texels.used(),
        }
    }

    /// Enters what it takes beside the buffer that a build fills.
    pub fn enter(&self, ledger: &mut Ledger) {
        match &self.held {
            Held::Built { .. } => {}
            Held::Written { name, buffer, used } => ledger.keep(name, buffer.size(), *used),
            Held::Texture { texels, .. } => texels.enter(ledger),
        }
    }

    /// Reads it back.
    ///
    /// # Errors
    /// [`TracerError::Failed`] if the device fails.
    pub fn read(&self, gpu: &Gpu) -> Result<Vec<u8>, TracerError> {
        match &self.held {
            Held::Built { buffer, used } | Held::Written { buffer, used, .. } => gpu.read(buffer, *used),
            Held::Texture { texels, .. } => texels.read(gpu),
        }
    }
}

/// Records the phase "copy to textures" of a build for the arrays that are copied; nothing where there are none.
///
/// # Errors
/// As [`PhaseClock::device_phase`].
pub fn record_copies(arrays: &[Readable], clock: &mut PhaseClock<'_>) -> Result<(), TracerError> {
    let copies: Vec<_> = arrays
        .iter()
        .filter_map(|array| match &array.held {
            Held::Texture { texels, from } if !from.is_empty() => Some((texels, from)),
            _ => None,
        })
        .collect();
    if copies.is_empty() {
        return Ok(());
    }
    clock.device_phase("copy to textures", |encoder| {
        copies.into_iter().for_each(|(texels, from)| texels.record_copies(encoder, from));
    })
}

/// Binds arrays for a search: the group [`READS_GROUP`] of its pipeline.
pub fn bind_arrays(gpu: &Gpu, pipeline: &ComputePipeline, arrays: &[Readable]) -> BindGroup {
    let resources: Vec<_> = arrays.iter().map(|array| (array.slot as u32, array.binding())).collect();
    bind_group_at(gpu, &pipeline.get_bind_group_layout(READS_GROUP), &resources)
}
