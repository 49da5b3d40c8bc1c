//! The buffers of a packed structure, kept from build to build.

use tracebench_api::wgpu::Buffer;
use tracebench_api::{Gpu, Ledger, TracerError};
use tracebench_kit::{
    GrowableBuffer, MemoryAccess, PrefixSum, PrefixSumPlan, RadixSort, RadixSortPlan, ReadSlot, Readable, grow,
};

use super::layout::{FACES, FIRST_NEAR, PackedGrid, PackedLayout};
use crate::description::Lists;

/// What is turned down where they are too large.
pub(super) const HINT: &str = "dirt.face_tiles or the scene's triangle count";

/// As in shaders/dirt/part_trees.wgsl: more parts in a tile are not built.
pub(super) const MAX_PARTS: u32 = 2_097_152;

/// Bytes of a node, of a list.
const NODE_BYTES: u64 = 48;
const LIST_BYTES: u64 = 4;

const QUADS: &str = "tiles and triangles";
const MASKS: &str = "masks of depth slices";
const REFERENCES: &str = "references";
const NODES: &str = "tree nodes";
const LISTS: &str = "lists";

/// Every buffer.
#[derive(Clone)]
pub(super) struct BuildBuffers {
    pub triangle_count: u32,
    /// Tiles, then corners of triangles.
    pub quads: GrowableBuffer,
    /// Masks of the pyramid's cells, then the range of depths of every tile.
    pub masks: GrowableBuffer,
    pub counts: GrowableBuffer,
    pub plans: GrowableBuffer,
    pub node_counts: GrowableBuffer,
    /// Parts and nodes that the last build needed, and parts that had no place.
    pub totals: GrowableBuffer,
    /// What is found on the way, triangles near the eye, references.
    pub words: GrowableBuffer,
    pub keys: GrowableBuffer,
    pub parts: GrowableBuffer,
    pub places: GrowableBuffer,
    /// Nodes, or where lists begin.
    pub nodes: GrowableBuffer,
    pub count_sums: PrefixSumPlan,
    pub node_sums: PrefixSumPlan,
    pub sort: RadixSortPlan,
    /// Parts and nodes that there is room for.
    pub capacities: [u32; 2],
}

/// The kernels that plans are made with.
pub(super) struct Sorting<'a> {
    pub sums: &'a PrefixSum,
    pub sort: &'a RadixSort,
}

impl BuildBuffers {
    /// Room for so many parts and nodes, in the buffers of `there` where these are large enough.
    pub(super) fn new(
        gpu: &Gpu,
        sorting: &Sorting<'_>,
        layout: &PackedLayout,
        triangle_count: u32,
        capacities: [u32; 2],
        there: Option<&Self>,
    ) -> Result<Self, TracerError> {
        let capacities = capacities.map(|count| count.max(1));
        let [triangles, tiles] = [triangle_count, layout.tile_count()].map(u64::from);
        let [part_count, node_count] = capacities.map(u64::from);
        let room = |name, bytes, there: Option<&GrowableBuffer>| GrowableBuffer::new(gpu, name, bytes, HINT, there);
        let quads = room(QUADS, (tiles + 3 * triangles) * 16, there.map(|there| &there.quads))?;
        let cells = u64::from(FACES * layout.cells());
        let masks = room(MASKS, (cells + tiles) * 8, there.map(|there| &there.masks))?;
        let counts = room("counts of parts (build)", (triangles + 1) * 4, there.map(|there| &there.counts))?;
        let plans = room("plans of triangles (build)", triangles * 32, there.map(|there| &there.plans))?;
        let node_counts = room("counts of nodes (build)", (tiles + 1) * 4, there.map(|there| &there.node_counts))?;
        let totals = room("totals (build)", 16, there.map(|there| &there.totals))?;
        let word_count = u64::from(FIRST_NEAR) + triangles + part_count;
        let words = room(REFERENCES, word_count * 4, there.map(|there| &there.words))?;
        let keys = room("keys of parts (build)", part_count * 4, there.map(|there| &there.keys))?;
        let parts = room("parts (build)", part_count * 16, there.map(|there| &there.parts))?;
        let places = room("order of parts (build)", part_count * 4, there.map(|there| &there.places))?;
        let nodes = match layout.lists {
            Lists::Slices => room(LISTS, node_count * LIST_BYTES, there.map(|there| &there.nodes))?,
            Lists::Linked | Lists::Packed | Lists::Trees => {
                room(NODES, node_count * NODE_BYTES, there.map(|there| &there.nodes))?
            }
        };
        let Sorting { sums, sort } = sorting;
        let (count_sums, node_sums) = (there.map(|there| &there.count_sums), there.map(|there| &there.node_sums));
        let count_sums = sums.numbered_plan(gpu, 1, &counts.buffer, triangle_count + 1, count_sums)?;
        let node_sums = sums.numbered_plan(gpu, 2, &node_counts.buffer, layout.tile_count() + 1, node_sums)?;
        let bits = layout.key_bits();
        let sorted = there.map(|there| &there.sort);
        let sort = sort.plan(gpu, &keys.buffer, &places.buffer, capacities[0], bits, sorted)?;
        Ok(Self {
            triangle_count,
            quads,
            masks,
            counts,
            plans,
            node_counts,
            totals,
            words,
            keys,
            parts,
            places,
            nodes,
            count_sums,
            node_sums,
            sort,
            capacities,
        })
    }

    /// The same with room for so many parts and nodes, and a quarter more where it can.
    pub(super) fn grown(
        &self,
        gpu: &Gpu,
        sorting: &Sorting<'_>,
        layout: &PackedLayout,
        needed: [u32; 2],
    ) -> Result<Self, TracerError> {
        let mut grown = None;
        grow(&needed, |capacities| {
            let capacities = [capacities[0], capacities[1]];
            grown = Some(Self::new(gpu, sorting, layout, self.triangle_count, capacities, Some(self))?);
            Ok(())
        })?;
        grown.ok_or_else(|| TracerError::Failed("no room was made".to_owned()))
    }

    /// Parts and nodes that the last build needed.
    ///
    /// # Errors
    /// [`TracerError::Failed`] if parts had no place, or a tile more of them than trees are built of.
    pub(super) fn needed(&self, gpu: &Gpu) -> Result<[u32; 2], TracerError> {
        let read = gpu.read(&self.totals.buffer, 12)?;
        let [parts, nodes, misplaced] = bytemuck::pod_collect_to_vec::<u8, [u32; 3]>(&read)[0];
        if misplaced > 0 {
            let what = match misplaced > MAX_PARTS {
                true => format!("a tile has {misplaced} parts: turn dirt.face_tiles up"),
                false => format!("{misplaced} parts had no place of their own: choose other dirt.face_tiles"),
            };
            return Err(TracerError::Failed(what));
        }
        Ok([parts, nodes])
    }

    /// The uniform of the shaders.
    pub(super) fn grid(&self, layout: &PackedLayout) -> PackedGrid {
        layout.grid(self.triangle_count, self.capacities)
    }

    /// What a search reads at unrelated places, in buffers or in textures that serve if `there` are those of the last build.
    pub(super) fn arrays(
        &self,
        gpu: &Gpu,
        layout: &PackedLayout,
        memory_access: MemoryAccess,
        there: &[Readable],
    ) -> Result<Vec<Readable>, TracerError> {
        let built = |index: usize, slot, buffer: &Buffer, copy_name| {
            Readable::built(gpu, memory_access, slot, buffer, buffer.size(), copy_name, there.get(index), HINT)
        };
        let mut arrays = vec![
            built(0, ReadSlot::Quads1, &self.quads.buffer, "tiles and triangles (texture)")?,
            built(1, ReadSlot::Pairs0, &self.masks.buffer, "masks of depth slices (texture)")?,
            built(2, ReadSlot::Words0, &self.words.buffer, "references (texture)")?,
        ];
        match layout.lists {
            Lists::Trees => arrays.push(built(3, ReadSlot::Quads0, &self.nodes.buffer, "tree nodes (texture)")?),
            Lists::Slices => arrays.push(built(3, ReadSlot::Words1, &self.nodes.buffer, "lists (texture)")?),
            Lists::Packed | Lists::Linked => {}
        }
        Ok(arrays)
    }

    /// Enters every buffer; so many parts and nodes are in use.
    pub(super) fn enter(&self, layout: &PackedLayout, [parts, nodes]: [u32; 2], ledger: &mut Ledger) {
        for room in [&self.quads, &self.masks, &self.counts, &self.plans, &self.node_counts, &self.totals] {
            room.enter(ledger);
        }
        let node_bytes = if layout.lists == Lists::Slices { LIST_BYTES } else { NODE_BYTES };
        let head = u64::from(FIRST_NEAR + self.triangle_count) * 4;
        for (room, bytes) in [
            (&self.words, head + u64::from(parts) * 4),
            (&self.keys, u64::from(parts) * 4),
            (&self.parts, u64::from(parts) * 16),
            (&self.places, u64::from(parts) * 4),
            (&self.nodes, u64::from(nodes) * node_bytes),
        ] {
            ledger.keep(room.name, room.buffer.size(), bytes.min(room.buffer.size()));
        }
        self.count_sums.enter(ledger);
        self.node_sums.enter(ledger);
        self.sort.enter(ledger);
    }
}
