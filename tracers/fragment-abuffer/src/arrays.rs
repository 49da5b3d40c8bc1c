//! What searches read at unrelated places: the buffers of a build, or textures that it copies them to.

use tracebench_api::wgpu::Buffer;
use tracebench_api::{Gpu, Ledger, PhaseClock, TracerError};
use tracebench_kit::{MemoryAccess, ReadSlot, Readable, record_copies};

use crate::parts::{HINT, Part, Parts};

/// The arrays of words of shaders/fragment-abuffer. With textures all views are in one, however many buffers they were built in; with
/// buffers they are those of the first view, which are all where views have no buffers of their own.
#[derive(Debug)]
pub(crate) struct Arrays {
    pixels: Readable,
    ids: Readable,
    /// None without Hi-Z.
    pyramid: Option<Readable>,
    /// None where nodes have the data.
    data: Option<Readable>,
}

impl Arrays {
    /// Those of some parts, in the textures of `there` where these have room.
    ///
    /// # Errors
    /// [`TracerError::TooLarge`] beyond the device's limits.
    pub(crate) fn new(
        gpu: &Gpu,
        memory_access: MemoryAccess,
        parts: &Parts,
        there: Option<&Self>,
    ) -> Result<Self, TracerError> {
        let array = |slot, buffers: &[&Buffer], name, there| match memory_access {
            MemoryAccess::Buffer => {
                Readable::built(gpu, memory_access, slot, buffers[0], buffers[0].size(), name, there, HINT)
            }
            MemoryAccess::Texture => {
                let sized: Vec<_> = buffers.iter().map(|buffer| (*buffer, buffer.size())).collect();
                Readable::joined(gpu, slot, &sized, name, there, HINT)
            }
        };
        let of_parts = |buffer: fn(&Part) -> &Buffer| parts.parts.iter().map(buffer).collect::<Vec<_>>();
        let payloads: Vec<&Buffer> = parts.parts.iter().filter_map(|part| part.payloads.as_ref()).collect();
        let pyramid = parts.pyramid.as_ref().map(|pyramid| {
            let there = there.and_then(|there| there.pyramid.as_ref());
            array(ReadSlot::Words2, &[pyramid], "depth pyramid (texture)", there)
        });
        let data = (!payloads.is_empty()).then(|| {
            let there = there.and_then(|there| there.data.as_ref());
            array(ReadSlot::Words3, &payloads, "data buffer (texture)", there)
        });
        Ok(Self {
            pixels: array(
                ReadSlot::Words0,
                &of_parts(|part| &part.pixels),
                "pixels (texture)",
                there.map(|there| &there.pixels),
            )?,
            ids: array(
                ReadSlot::Words1,
                &of_parts(|part| &part.ids),
                "id buffer (texture)",
                there.map(|there| &there.ids),
            )?,
            pyramid: pyramid.transpose()?,
            data: data.transpose()?,
        })
    }

    /// How they are read.
    pub(crate) fn memory_access(&self) -> MemoryAccess {
        self.pixels.memory_access()
    }

    fn own(&self) -> impl Iterator<Item = &Readable> {
        [&self.pixels, &self.ids].into_iter().chain(&self.pyramid).chain(&self.data)
    }

    /// What a trace binds, to surfaces or to hits: every array that shaders ask for, one that there is in place of one that there is not.
    pub(crate) fn bound(&self, surfaces: bool) -> Vec<Readable> {
        let pyramid = self.pyramid.clone().unwrap_or_else(|| self.pixels.at(ReadSlot::Words2));
        let mut bound = vec![self.pixels.clone(), self.ids.clone(), pyramid];
        if surfaces {
            bound.push(self.data.clone().unwrap_or_else(|| self.ids.at(ReadSlot::Words3)));
        }
        bound
    }

    /// Records the copies of a build.
    pub(crate) fn record_copies(&self, clock: &mut PhaseClock<'_>) -> Result<(), TracerError> {
        record_copies(&self.own().cloned().collect::<Vec<_>>(), clock)
    }

    /// Enters the textures.
    pub(crate) fn enter(&self, ledger: &mut Ledger) {
        self.own().for_each(|array| array.enter(ledger));
    }
}
