//! What a build needs beside the tree, and gives back when it is done.

use tracebench_api::wgpu::Buffer;
use tracebench_api::{Gpu, Ledger, TracerError};
use tracebench_kit::{PrefixSumPlan, RadixSortPlan, storage_buffer, uniform_buffer};

use crate::counts::Counts;
use crate::kernels::Kernels;
use crate::layout::{HINT, Layout};

/// The buffers, for so many of each thing.
pub(crate) struct Scratch {
    pub settings: Buffer,
    pub row_starts: Buffer,
    pub fragment_starts: Buffer,
    pub keys: Buffer,
    pub primitives: Buffer,
    /// Of fragments, and then of the children of every level.
    pub ranks: Buffer,
    pub leaf_keys: Buffer,
    pub leaf_firsts: Buffer,
    /// Sums of leaves' normals along z; those along x and y are in the leaves.
    pub sums_z: Buffer,
    /// Keys of the lowest nodes; the levels above take turns with the leaves'.
    pub node_keys: Buffer,
    /// The uniforms of the levels, the root's first.
    pub levels: Vec<Buffer>,
    pub row_sums: PrefixSumPlan,
    pub fragment_sums: PrefixSumPlan,
    pub leaf_sums: PrefixSumPlan,
    /// By level, as the uniforms.
    pub node_sums: Vec<PrefixSumPlan>,
    pub sort: RadixSortPlan,
}

/// A buffer of words.
fn words(gpu: &Gpu, name: &str, count: u64) -> Result<Buffer, TracerError> {
    storage_buffer(gpu, name, count * 4, HINT)
}

impl Scratch {
    /// Room for so many.
    ///
    /// # Errors
    /// [`TracerError::TooLarge`] beyond the device's limits, which says what to turn down.
    pub(crate) fn new(kernels: &Kernels, layout: &Layout, triangles: u32, room: &Counts) -> Result<Self, TracerError> {
        let gpu = &*kernels.gpu;
        let [rows, fragments, leaves] = [room.rows, room.fragments, room.leaves(layout.levels)];
        let lowest = room.levels[layout.levels as usize - 1];
        let row_starts = words(gpu, "rows of triangles", u64::from(triangles) + 1)?;
        let fragment_starts = words(gpu, "fragments of rows", u64::from(rows) + 1)?;
        let keys = words(gpu, "keys of fragments", u64::from(fragments))?;
        let primitives = words(gpu, "triangles of fragments", u64::from(fragments))?;
        let ranks = words(gpu, "ranks", u64::from(fragments.max(leaves)) + 1)?;
        let sums = |buffer: &Buffer, count: u32| kernels.prefix_sum.plan(gpu, buffer, count, None);
        let level = |depth: u32| uniform_buffer(gpu, "level", &layout.level(depth, room));
        let node_sums = |depth: u32| sums(&ranks, room.levels[depth as usize + 1] + 1);
        Ok(Self {
            settings: uniform_buffer(gpu, "octree build", &layout.build(triangles, room))?,
            leaf_keys: words(gpu, "keys of leaves", u64::from(leaves))?,
            leaf_firsts: words(gpu, "first fragments of leaves", u64::from(leaves) + 1)?,
            sums_z: words(gpu, "sums of normals", u64::from(leaves))?,
            node_keys: words(gpu, "keys of nodes", u64::from(lowest))?,
            levels: (0..layout.levels).map(level).collect::<Result<_, _>>()?,
            row_sums: sums(&row_starts, triangles + 1)?,
            fragment_sums: sums(&fragment_starts, rows + 1)?,
            leaf_sums: sums(&ranks, fragments + 1)?,
            node_sums: (0..layout.levels).map(node_sums).collect::<Result<_, _>>()?,
            sort: kernels.sort.plan(gpu, &keys, &primitives, fragments, 3 * layout.levels + 1, None)?,
            row_starts,
            fragment_starts,
            keys,
            primitives,
            ranks,
        })
    }

    /// Its bytes.
    pub(crate) fn bytes(&self) -> u64 {
        let own = [
            &self.settings,
            &self.row_starts,
            &self.fragment_starts,
            &self.keys,
            &self.primitives,
            &self.ranks,
            &self.leaf_keys,
            &self.leaf_firsts,
            &self.sums_z,
            &self.node_keys,
        ];
        let own: u64 = own.into_iter().chain(&self.levels).map(Buffer::size).sum();
        let mut plans = Ledger::new();
        self.sort.enter(&mut plans);
        let sums = [&self.row_sums, &self.fragment_sums, &self.leaf_sums];
        sums.into_iter().chain(&self.node_sums).for_each(|plan| plan.enter(&mut plans));
        own + plans.report(0).structure_bytes()
    }
}
