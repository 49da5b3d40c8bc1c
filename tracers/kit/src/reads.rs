//! How a search reads a structure: arrays in buffers, or copies of them in textures (shaders/shared/reads.wgsl).

use tracebench_api::wgpu::{
    self, BindGroup, BindingResource, Buffer, ComputePipeline, Extent3d, TexelCopyBufferInfo, TexelCopyBufferLayout,
    TextureFormat, TextureUsages, TextureView,
};
use tracebench_api::{Gpu, Ledger, Parameter, ParameterScope, PhaseClock, TracerError, choice};

use crate::{bind_group_at, storage_buffer};

choice! {
    /// How a search reads a structure.
    pub enum Reads { Buffer = "buffer", Texture = "texture" }
}

/// The parameter `reads`, the same for every tracer that searches on the device.
pub fn reads_parameter() -> Parameter<Reads> {
    let effect = "what the search reads the structure from: buffers, or textures that the build fills or copies it to: more \
                  memory and longer builds, for drivers that gather from textures faster";
    Parameter::choice(ParameterScope::Build, Reads::Buffer, effect)
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

const ROW_BYTES: u32 = 1 << ROW_BITS;

/// Records in a texture, row by row.
#[derive(Clone, Debug)]
struct Texels {
    name: &'static str,
    slot: ReadSlot,
    view: TextureView,
    /// Bytes in use.
    used: u64,
    /// Bytes allocated, by the device's own report: drivers pad textures as they like.
    allocated: u64,
}

impl Texels {
    /// The texture that is there if it has room for so many bytes, else a new one. `used` are whole records of the slot.
    ///
    /// # Errors
    /// [`TracerError::TooLarge`] beyond the device's limits, naming `turn_down` as the remedy.
    fn room(
        gpu: &Gpu,
        name: &'static str,
        slot: ReadSlot,
        used: u64,
        there: Option<&Texels>,
        turn_down: &str,
    ) -> Result<Self, TracerError> {
        Self::check(gpu, name, used, turn_down)?;
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
    fn write(
        gpu: &Gpu,
        name: &'static str,
        slot: ReadSlot,
        contents: &[u8],
        there: Option<&Texels>,
        turn_down: &str,
    ) -> Result<Self, TracerError> {
        let texels = Self::room(gpu, name, slot, contents.len() as u64, there, turn_down)?;
        for Part { first_byte, first_row, size } in slot.parts(contents.len() as u64) {
            let origin = wgpu::Origin3d { x: 0, y: first_row, z: 0 };
            let target = wgpu::TexelCopyTextureInfo { origin, ..texels.view.texture().as_image_copy() };
            gpu.queue.write_texture(target, &contents[first_byte as usize..], layout(0), size);
        }
        Ok(texels)
    }

    /// Records a copy of so many bytes of each of some buffers of usage `COPY_SRC`, each from a row of its own on.
    fn record_copies(&self, encoder: &mut wgpu::CommandEncoder, sources: &[(Buffer, u64)]) {
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
    fn check(gpu: &Gpu, name: &str, bytes: u64, turn_down: &str) -> Result<(), TracerError> {
        let limit = u64::from(gpu.limits.max_texture_dimension_2d) * u64::from(ROW_BYTES);
        if bytes <= limit {
            return Ok(());
        }
        let turn_down = format!("{turn_down}, or read it from a buffer (reads=buffer)");
        Err(TracerError::TooLarge { name: name.to_owned(), bytes, limit, turn_down })
    }

    /// Bytes in use.
    fn used(&self) -> u64 {
        self.used
    }

    /// Enters the texture.
    fn enter(&self, ledger: &mut Ledger) {
        ledger.keep(self.name, self.allocated, self.used);
    }

    /// Reads what is in use back.
    ///
    /// # Errors
    /// [`TracerError::Failed`] if the device fails.
    fn read(&self, gpu: &Gpu) -> Result<Vec<u8>, TracerError> {
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

/// A rectangle of a texture that a run of bytes fills.
struct Part {
    first_byte: u64,
    first_row: u32,
    size: Extent3d,
}

/// Rows that hold so many bytes, one at least.
fn rows(bytes: u64) -> u32 {
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
    /// [`TracerError::TooLarge`] beyond the device's limits, naming `turn_down` as the remedy.
    #[expect(clippy::too_many_arguments, reason = "each says another thing of the one array")]
    pub fn built(
        gpu: &Gpu,
        reads: Reads,
        slot: ReadSlot,
        buffer: &Buffer,
        bytes: u64,
        copy_name: &'static str,
        there: Option<&Self>,
        turn_down: &str,
    ) -> Result<Self, TracerError> {
        match reads {
            Reads::Buffer => {
                Self::check(gpu, reads, copy_name, buffer.size(), turn_down)?;
                Ok(Self { slot, held: Held::Built { buffer: buffer.clone(), used: bytes } })
            }
            Reads::Texture => Self::joined(gpu, slot, &[(buffer, bytes)], copy_name, there, turn_down),
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
        turn_down: &str,
    ) -> Result<Self, TracerError> {
        let last = buffers.last().map_or(0, |(_, bytes)| *bytes);
        let rows_before: u64 = buffers.iter().rev().skip(1).map(|(_, bytes)| u64::from(rows(*bytes))).sum();
        let bytes = rows_before * u64::from(ROW_BYTES) + last;
        let texels = Texels::room(gpu, copy_name, slot, bytes, there.and_then(Self::texels), turn_down)?;
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
        reads: Reads,
        slot: ReadSlot,
        contents: &[u8],
        name: &'static str,
        there: Option<&Self>,
        turn_down: &str,
    ) -> Result<Self, TracerError> {
        let used = contents.len() as u64;
        let held = match reads {
            Reads::Buffer => {
                Self::check(gpu, reads, name, used, turn_down)?;
                let fits = |there: &&Buffer| there.size() >= used;
                let buffer = match there.and_then(Self::written_buffer).filter(fits) {
                    Some(there) => there.clone(),
                    None => storage_buffer(gpu, name, used, turn_down)?,
                };
                gpu.queue.write_buffer(&buffer, 0, contents);
                Held::Written { name, buffer, used }
            }
            Reads::Texture => {
                let texels = Texels::write(gpu, name, slot, contents, there.and_then(Self::texels), turn_down)?;
                Held::Texture { texels, from: Vec::new() }
            }
        };
        Ok(Self { slot, held })
    }

    /// Checks that the device can hold and bind that many bytes.
    ///
    /// # Errors
    /// As [`Readable::built`].
    pub fn check(gpu: &Gpu, reads: Reads, name: &str, bytes: u64, turn_down: &str) -> Result<(), TracerError> {
        match reads {
            Reads::Buffer => gpu.check_storage_binding(name, bytes, turn_down),
            Reads::Texture => Texels::check(gpu, name, bytes, turn_down),
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
    pub fn reads(&self) -> Reads {
        if self.texels().is_some() { Reads::Texture } else { Reads::Buffer }
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{compute_pipeline, dispatch_linear_groups};
    use tracebench_api::AdapterChoice;
    use tracebench_shaders::test::ReadsFunctions;

    const SLOTS: [ReadSlot; 3] = [ReadSlot::Quads1, ReadSlot::Pairs1, ReadSlot::Words3];

    /// What the shader finds at every record of three arrays, written by the host or left by a build.
    fn found(gpu: &Gpu, reads: Reads, count: usize, built: bool) -> Vec<[u32; 8]> {
        let pipeline = compute_pipeline(gpu, ReadsFunctions { textures: reads == Reads::Texture }, "look_up").unwrap();
        let array = |slot: ReadSlot| {
            let words: Vec<u32> =
                (0..count as u32 * slot.record_bytes() / 4).map(|word| word * 3 + slot as u32).collect();
            let contents: &[u8] = bytemuck::cast_slice(&words);
            if !built {
                return Readable::written(gpu, reads, slot, contents, "written", None, "nothing").unwrap();
            }
            let buffer = storage_buffer(gpu, "built", contents.len() as u64, "nothing").unwrap();
            gpu.queue.write_buffer(&buffer, 0, contents);
            Readable::built(gpu, reads, slot, &buffer, contents.len() as u64, "copied", None, "nothing").unwrap()
        };
        let arrays = SLOTS.map(array);
        let mut clock = PhaseClock::new(Some(gpu));
        record_copies(&arrays, &mut clock).unwrap();
        // A clock without phases has nothing to finish.
        assert_eq!(clock.finish().is_ok(), built && reads == Reads::Texture);
        let results = storage_buffer(gpu, "found", count as u64 * 32, "nothing").unwrap();
        let own = crate::bind_group(gpu, &pipeline.get_bind_group_layout(0), &[results.as_entire_binding()]);
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let bound = bind_arrays(gpu, &pipeline, &arrays);
        dispatch_linear_groups(&mut encoder, &pipeline, &[&own, &bound], count as u32, 64);
        gpu.queue.submit([encoder.finish()]);
        bytemuck::pod_collect_to_vec(&gpu.read(&results, results.size()).unwrap())
    }

    /// Proves that records of every size are read where they are, from buffers and textures, written and copied, of less than a row,
    /// of whole rows and of some more: rows of quads, pairs and words end at 2048, 4096 and 8192.
    #[test]
    fn records_are_read_where_they_are() {
        let gpu = Gpu::open(&AdapterChoice::default()).unwrap();
        for count in [1, 2048, 2049, 4097, 8192, 16_391] {
            let of = |record: u32, words: u32, slot: ReadSlot, word: u32| (record * words + word) * 3 + slot as u32;
            let expected = |record: u32| {
                let [quads, pairs, words] = SLOTS;
                let quad: [u32; 4] = std::array::from_fn(|word| of(record, 4, quads, word as u32));
                let pair = [of(record, 2, pairs, 0), of(record, 2, pairs, 1)];
                [quad[0], quad[1], quad[2], quad[3], pair[0], pair[1], of(record, 1, words, 0), 0]
            };
            let expected: Vec<[u32; 8]> = (0..count as u32).map(expected).collect();
            for reads in [Reads::Buffer, Reads::Texture] {
                for built in [false, true] {
                    assert!(found(&gpu, reads, count, built) == expected, "{reads:?} {count} {built}");
                }
            }
        }
    }

    /// Proves that each of several buffers in one texture is where its first record is said to be, whether it ends within a row or with
    /// it; the array is the same in another slot.
    #[test]
    fn buffers_are_joined_by_rows() {
        let gpu = Gpu::open(&AdapterChoice::default()).unwrap();
        let contents = [5_usize, 8192, 8193, 3]
            .map(|count| -> Vec<u32> { (0..count as u32).map(|word| word * 7 + count as u32).collect() });
        let buffers = contents.each_ref().map(|words| {
            let buffer = storage_buffer(&gpu, "built", words.len() as u64 * 4, "nothing").unwrap();
            gpu.queue.write_buffer(&buffer, 0, bytemuck::cast_slice(words));
            buffer
        });
        let sources = buffers.each_ref().map(|buffer| (buffer, buffer.size()));
        let joined = Readable::joined(&gpu, ReadSlot::Words0, &sources, "joined", None, "nothing").unwrap();
        let mut clock = PhaseClock::new(Some(&gpu));
        record_copies(std::slice::from_ref(&joined), &mut clock).unwrap();
        clock.finish().unwrap();
        let first = ReadSlot::Words0.first_records(sources.map(|(_, bytes)| bytes));
        assert_eq!(first, [0, 8192, 2 * 8192, 4 * 8192]);
        for array in [&joined, &joined.at(ReadSlot::Words3)] {
            let read: Vec<u32> = bytemuck::pod_collect_to_vec(&array.read(&gpu).unwrap());
            assert_eq!(read.len(), 4 * 8192 + 3);
            for (first, words) in first.iter().zip(&contents) {
                assert_eq!(&read[*first as usize..][..words.len()], words);
            }
        }
    }

    /// Proves that a texture is kept where it has room, that a larger one takes its place, and that what is used is told.
    #[test]
    fn textures_are_kept_where_they_have_room() {
        let gpu = Gpu::open(&AdapterChoice::default()).unwrap();
        let write = |bytes: usize, there: Option<&Readable>| {
            let contents = vec![7; bytes];
            Readable::written(&gpu, Reads::Texture, ReadSlot::Words0, &contents, "words", there, "nothing").unwrap()
        };
        let view = |array: &Readable| array.texels().unwrap().view.clone();
        let first = write(100_000, None);
        let smaller = write(400, Some(&first));
        assert!(view(&smaller) == view(&first) && smaller.used() == 400);
        assert_eq!(smaller.read(&gpu).unwrap(), vec![7; 400]);
        let larger = write(200_000, Some(&first));
        assert!(view(&larger) != view(&first) && larger.used() == 200_000);
        // Another name is another array.
        let other =
            Readable::written(&gpu, Reads::Texture, ReadSlot::Words1, &[7; 4], "words", Some(&first), "nothing");
        assert!(view(&other.unwrap()) != view(&first));
    }
}
