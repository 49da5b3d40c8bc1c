//! The buffers of a structure, kept from build to build.

use tracebench_api::{Gpu, Ledger, TracerError};
use tracebench_kit::{GrowableBuffer, MemoryAccess, RadixSortPlan};

use super::kernels::{LEVELS, RUN};
use crate::binary::BinaryNode;
use crate::gpu::WIDE_STACK;
use crate::gpu::description::NodeKind;
use crate::gpu::layout::DeviceTriangle;
use crate::gpu::resident::TRIANGLES;

pub(super) const HINT: &str = "the scene's triangle count";

/// Bytes of a compressed node.
pub(super) const WIDE_NODE_BYTES: u64 = 80;

/// Words of the buffer that tells how far a build is.
const PROGRESS_WORDS: u64 = (LEVELS + WIDE_STACK + 1) as u64;

/// Every buffer but those of the sort.
pub(super) struct BuildBuffers {
    pub(super) triangles: GrowableBuffer,
    /// Pairs of binary nodes: what is searched, or what compressed nodes are converted from.
    pub(super) binary: GrowableBuffer,
    pub(super) wide: Option<GrowableBuffer>,
    /// Clusters at the start of each iteration, slots taken, compressed nodes of each level.
    pub(super) progress: GrowableBuffer,
    /// Morton codes; while clusters are merged, the place of each one's nearest neighbour.
    pub(super) codes: GrowableBuffer,
    /// The triangle in each place along the curve.
    pub(super) order: GrowableBuffer,
    /// Clusters before an even and an odd iteration. A refit keeps the boxes of compressed nodes in the first.
    pub(super) clusters: [GrowableBuffer; 2],
    pub(super) tallies: GrowableBuffer,
}

impl BuildBuffers {
    /// Room for a build, in the buffers of `there` where these are large enough.
    pub(super) fn new(
        gpu: &Gpu,
        kind: NodeKind,
        memory_access: MemoryAccess,
        triangle_count: u32,
        there: Option<&BuildBuffers>,
    ) -> Result<Self, TracerError> {
        let count = u64::from(triangle_count);
        // What is searched has the name of what it is; what is only built with, or copied to what is searched, another one.
        let name = |searched: bool, plain, of_build| {
            if searched && memory_access == MemoryAccess::Buffer { plain } else { of_build }
        };
        let room = |name, bytes, there: Option<&GrowableBuffer>| GrowableBuffer::new(gpu, name, bytes, HINT, there);
        let node_bytes = size_of::<BinaryNode>() as u64;
        let pairs = count.max(2) - 1;
        // A node with a child that is a node has eight children, others have four triangles at least (but for the root):
        // with i of the first and l of the second, 8 i <= i + l - 1 + t where t triangles are leaves of the first.
        let wide_nodes = 2 * count / 7 + 2;
        let wide_name = name(true, NodeKind::Wide.name(), "CWBVH nodes (build)");
        let binary_name = name(kind == NodeKind::Binary, NodeKind::Binary.name(), "binary nodes (build)");
        let wide = || room(wide_name, wide_nodes * WIDE_NODE_BYTES, there.and_then(|r| r.wide.as_ref()));
        Ok(Self {
            triangles: room(
                name(true, TRIANGLES, "triangles in leaf order (build)"),
                count * size_of::<DeviceTriangle>() as u64,
                there.map(|r| &r.triangles),
            )?,
            binary: room(binary_name, pairs * 2 * node_bytes, there.map(|r| &r.binary))?,
            wide: (kind == NodeKind::Wide).then(wide).transpose()?,
            progress: room("progress of the build", PROGRESS_WORDS * 4, there.map(|r| &r.progress))?,
            codes: room("Morton codes, nearest neighbours (build)", count * 4, there.map(|r| &r.codes))?,
            order: room("triangles along the curve (build)", count * 4, there.map(|r| &r.order))?,
            clusters: [
                room("clusters (build)", count * node_bytes, there.map(|r| &r.clusters[0]))?,
                room("other clusters (build)", count * node_bytes, there.map(|r| &r.clusters[1]))?,
            ],
            tallies: room("tallies (build)", count.div_ceil(u64::from(RUN)) * 8, there.map(|r| &r.tallies))?,
        })
    }

    /// Enters every buffer; of the compressed nodes so many are in use.
    pub(super) fn enter(&self, wide_nodes: u64, sort: &RadixSortPlan, ledger: &mut Ledger) {
        if let Some(wide) = &self.wide {
            ledger.keep(wide.name, wide.buffer.size(), wide_nodes * WIDE_NODE_BYTES);
        }
        let [first, second] = &self.clusters;
        let others =
            [&self.triangles, &self.binary, &self.progress, &self.codes, &self.order, first, second, &self.tallies];
        others.into_iter().for_each(|room| room.enter(ledger));
        sort.enter(ledger);
    }
}
