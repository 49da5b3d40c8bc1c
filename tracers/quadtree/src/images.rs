//! The structure's buffers.

use tracebench_api::wgpu::Buffer;
use tracebench_api::{Gpu, Ledger, PhaseClock, TracerError};
use tracebench_kit::{EmptyTarget, GrowableBuffer, MemoryAccess, RasterBackend, ReadSlot, Readable, record_copies};

use crate::layout::Shape;

/// What ledgers call them, after WKP15, sections 3.1 and 3.4.
const CODES: &str = "depth layers";
const CAUGHT: &str = "depths caught by the k-buffer";
const NAMES: &str = "triangles of the layers";
const PAYLOADS: [&str; 2] = ["normals and materials of layers 1 and 3", "normals and materials of layers 2 and 4"];
const NODES: &str = "quad-tree nodes";
const TARGET: &str = "attachment of the layers";
const COPIES: [&str; 3] = [
    "quad-tree nodes (texture)",
    "normals and materials of layers 1 and 3 (texture)",
    "normals and materials of layers 2 and 4 (texture)",
];

/// Bytes of a node (Figure 3).
pub(crate) const NODE_BYTES: u64 = 8;
/// Bytes of a pixel's normal and material.
const PAYLOAD_BYTES: u64 = 16;

/// All that a build fills.
#[derive(Clone)]
pub(crate) struct Images {
    /// Complemented bits of eye depths, a word a pixel a layer; 0 for nothing.
    pub codes: GrowableBuffer,
    /// The same of a view, a word a pixel a slot, where layers are chosen from more depths.
    pub caught: Option<GrowableBuffer>,
    /// Complemented triangles, a word a pixel a layer; 0 for none.
    pub names: GrowableBuffer,
    /// Of layers 1 and 3, and of 2 and 4: one binding does not hold those of faces.
    pub payloads: [GrowableBuffer; 2],
    pub nodes: GrowableBuffer,
    /// None where there is no rasterizer.
    pub target: Option<EmptyTarget>,
    /// Nodes and both payloads as searches read them.
    arrays: [Readable; 3],
}

impl Images {
    /// Buffers for a shape, those of `there` where they have room and the images are as large.
    pub(crate) fn new(
        gpu: &Gpu,
        shape: &Shape,
        memory_access: MemoryAccess,
        there: Option<&Self>,
    ) -> Result<Self, TracerError> {
        let edge = gpu.limits.max_texture_dimension_2d;
        if let Some(too_large) = shape.size().into_iter().find(|size| *size > edge) {
            return Err(TracerError::Failed(format!(
                "the depth layers have an edge of {too_large} pixels, the device allows {edge}: turn down {}",
                shape.smaller_by()
            )));
        }
        let down = shape.hint();
        let room =
            |name, bytes: u64, there: Option<&GrowableBuffer>| GrowableBuffer::new(gpu, name, bytes, down, there);
        let (pixels, views) = (shape.pixels(), shape.views.len() as u64);
        let all = pixels * shape.images();
        let payload = |which: usize| {
            let layers = (u64::from(shape.layers) + 1 - which as u64) / 2;
            // What is bound is never without a record.
            let bytes = (pixels * views * layers).max(1) * PAYLOAD_BYTES;
            room(PAYLOADS[which], bytes, there.map(|there| &there.payloads[which]))
        };
        let codes = room(CODES, all * 4, there.map(|there| &there.codes))?;
        let names = room(NAMES, all * 4, there.map(|there| &there.names))?;
        let caught = match shape.thins() {
            true => {
                let bytes = pixels * u64::from(shape.slots()) * 4;
                Some(room(CAUGHT, bytes, there.and_then(|there| there.caught.as_ref()))?)
            }
            false => None,
        };
        let payloads = [payload(0)?, payload(1)?];
        let nodes =
            room(NODES, shape.level_offsets().1 * shape.images() * NODE_BYTES, there.map(|there| &there.nodes))?;
        let slots = [ReadSlot::Pairs0, ReadSlot::Quads0, ReadSlot::Quads1];
        let array = |place: usize, room: &GrowableBuffer| {
            let there = there.map(|there| &there.arrays[place]);
            Readable::built(gpu, memory_access, slots[place], &room.buffer, room.used_bytes, COPIES[place], there, down)
        };
        let arrays = [array(0, &nodes)?, array(1, &payloads[0])?, array(2, &payloads[1])?];
        let drawn = shape.raster_backend == RasterBackend::Raster;
        let target = drawn.then(|| EmptyTarget::new(gpu, TARGET, shape.size())).transpose()?;
        Ok(Self { codes, caught, names, payloads, nodes, target, arrays })
    }

    /// How searches read them.
    pub(crate) fn memory_access(&self) -> MemoryAccess {
        self.arrays[0].memory_access()
    }

    /// What a trace binds, to surfaces or to hits.
    pub(crate) fn bound(&self, surfaces: bool) -> &[Readable] {
        if surfaces { &self.arrays } else { &self.arrays[..1] }
    }

    /// Records the copies of a build.
    pub(crate) fn record_copies(&self, clock: &mut PhaseClock<'_>) -> Result<(), TracerError> {
        record_copies(&self.arrays, clock)
    }

    /// Reads the words of a buffer that are in use.
    pub(crate) fn read(gpu: &Gpu, room: &GrowableBuffer) -> Result<Vec<u32>, TracerError> {
        Ok(bytemuck::pod_collect_to_vec(&gpu.read(&room.buffer, room.used_bytes)?))
    }

    fn buffers(&self) -> impl Iterator<Item = &GrowableBuffer> {
        [&self.codes, &self.names, &self.nodes].into_iter().chain(&self.caught).chain(&self.payloads)
    }

    /// Enters every part.
    pub(crate) fn enter(&self, ledger: &mut Ledger) {
        self.buffers().for_each(|room| room.enter(ledger));
        self.arrays.iter().for_each(|array| array.enter(ledger));
        if let Some(target) = &self.target {
            target.enter(ledger);
        }
    }

    /// The buffers that hold normals and materials.
    pub(crate) fn payload_buffers(&self) -> [&Buffer; 2] {
        self.payloads.each_ref().map(|room| &room.buffer)
    }
}
