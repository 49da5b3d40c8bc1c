//! What searches read at unrelated places: the buffers of a build, or textures that it copies them to.

use tracebench_api::wgpu::Buffer;
use tracebench_api::{Gpu, Ledger, PhaseClock, TracerError};
use tracebench_kit::{MemoryAccess, ReadSlot, Readable, record_copies};

use crate::buffers::Buffers;
use crate::layout::AXES;
use crate::nodes::{HINT, Placed};

/// The arrays of shaders/voxel-abuffer. With textures those of all axes are in one, however many buffers they were built in; with
/// buffers they are those of the first axis, which are all where axes have no buffers of their own.
#[derive(Debug)]
pub(crate) struct Arrays {
    cells: Readable,
    /// Heads, nodes and data; none where there are voxels only.
    lists: Option<[Readable; 3]>,
}

impl Arrays {
    /// Those of some buffers, in the textures of `there` where these have room.
    ///
    /// # Errors
    /// [`TracerError::TooLarge`] beyond the device's limits.
    pub(crate) fn new(
        gpu: &Gpu,
        memory_access: MemoryAccess,
        buffers: &Buffers,
        there: Option<&Self>,
    ) -> Result<Self, TracerError> {
        let array = |slot, buffers: &[&Buffer], name, there: Option<&Readable>| match memory_access {
            MemoryAccess::Buffer => {
                Readable::built(gpu, memory_access, slot, buffers[0], buffers[0].size(), name, there, HINT)
            }
            MemoryAccess::Texture => {
                let sized: Vec<_> = buffers.iter().map(|buffer| (*buffer, buffer.size())).collect();
                Readable::joined(gpu, slot, &sized, name, there, HINT)
            }
        };
        let own = |index: usize| there.and_then(|there| there.lists.as_ref()).map(|lists| &lists[index]);
        let lists = match &buffers.lists {
            None => None,
            Some(lists) => {
                let [nodes, data] = lists.nodes.buffers();
                Some([
                    array(ReadSlot::Words0, &[&lists.heads], "heads (texture)", own(0))?,
                    array(ReadSlot::Pairs0, &nodes, "nodes (texture)", own(1))?,
                    array(ReadSlot::Quads0, &data, "data (texture)", own(2))?,
                ])
            }
        };
        let cells = array(ReadSlot::Words1, &[&buffers.cells], "voxels (texture)", there.map(|there| &there.cells))?;
        Ok(Self { cells, lists })
    }

    /// How they are read.
    pub(crate) fn memory_access(&self) -> MemoryAccess {
        self.cells.memory_access()
    }

    /// Where every axis' nodes and data begin in them.
    pub(crate) fn placed(&self, buffers: &Buffers) -> [Placed; AXES] {
        let Some(lists) = &buffers.lists else { return Default::default() };
        let first = (self.memory_access() == MemoryAccess::Texture).then(|| {
            let [nodes, data] = lists.nodes.buffers();
            let first =
                |slot: ReadSlot, buffers: Vec<&Buffer>| slot.first_records(buffers.iter().map(|each| each.size()));
            [first(ReadSlot::Pairs0, nodes), first(ReadSlot::Quads0, data)]
        });
        lists.nodes.placed(first)
    }

    fn own(&self) -> Vec<Readable> {
        std::iter::once(&self.cells).chain(self.lists.iter().flatten()).cloned().collect()
    }

    /// What a trace binds that reads data, or one that does not.
    pub(crate) fn bound(&self, reads_data: bool) -> Vec<Readable> {
        let mut bound = self.own();
        if !reads_data && self.lists.is_some() {
            bound.pop();
        }
        bound
    }

    /// Records the copies of a build.
    pub(crate) fn record_copies(&self, clock: &mut PhaseClock<'_>) -> Result<(), TracerError> {
        record_copies(&self.own(), clock)
    }

    /// Enters the textures.
    pub(crate) fn enter(&self, ledger: &mut Ledger) {
        self.own().iter().for_each(|array| array.enter(ledger));
    }
}
