//! A hierarchy in the device's memory.

use tracebench_api::wgpu::{Buffer, BufferUsages};
use tracebench_api::{Gpu, Ledger, TracerError};
use tracebench_kit::{LANES_OF_WORKGROUP, MemoryAccess, ReadSlot, Readable};

use super::description::NodeKind;
use super::layout::{DeviceTriangle, Tree};
use super::search::{private_stack, stack_entry_bytes};

const HINT: &str = "the scene's triangle count, or take a build without splits (--set bvh-gpu.build=medium)";

pub(crate) const TRIANGLES: &str = "triangles in leaf order";

/// Where the searches of shaders/bvh read nodes.
pub(crate) const NODES_SLOT: ReadSlot = ReadSlot::Quads0;

/// Where they read triangles.
pub(crate) const TRIANGLES_SLOT: ReadSlot = ReadSlot::Quads1;

const STACKS: &str = "traversal stacks";

/// Bytes that stacks in device memory may take beyond one workgroup's.
const STACK_BYTES: u64 = 32 << 20;

/// Most lanes that have stacks in device memory.
const MAX_DEEP_LANES: u64 = 1 << 16;

/// Nodes, triangles in the order of the leaves and, for a hierarchy too deep for private stacks, stacks.
#[derive(Debug)]
pub(crate) struct Resident {
    pub(crate) kind: NodeKind,
    pub(crate) depth: usize,
    with_splits: bool,
    /// Nodes and triangles.
    arrays: [Readable; 2],
    /// With the number of lanes that have one.
    stacks: Option<(Buffer, u32)>,
}

impl Resident {
    /// Takes over what kernels fill: nodes of no more than `depth` levels, which private stacks must serve, and triangles
    /// in the order of the leaves.
    pub(crate) fn of_arrays(kind: NodeKind, depth: usize, arrays: [Readable; 2]) -> Self {
        Self { kind, depth, with_splits: false, arrays, stacks: None }
    }

    /// Uploads, into the buffers or textures of `there` where these are large enough, and waits until the device has everything. What
    /// was there is as it was after an error that a size has caused.
    ///
    /// # Errors
    /// [`TracerError::TooLarge`] if the device cannot hold a part.
    pub(crate) fn upload(
        gpu: &Gpu,
        memory_access: MemoryAccess,
        tree: &Tree,
        depth: usize,
        ordered: &[DeviceTriangle],
        there: Option<&Resident>,
    ) -> Result<Self, TracerError> {
        let kind = tree.kind();
        let there = there.filter(|there| there.kind == kind);
        let ordered: &[u8] = bytemuck::cast_slice(ordered);
        for (name, bytes) in [(kind.name(), tree.node_bytes().len()), (TRIANGLES, ordered.len())] {
            Readable::check(gpu, memory_access, name, bytes as u64, HINT)?;
        }
        let stacks = (depth > private_stack(kind)).then(|| stacks(gpu, kind, depth)).transpose()?;
        let array = |slot: ReadSlot, name, contents: &[u8]| {
            let there = there.map(|there| &there.arrays[slot as usize]);
            Readable::written(gpu, memory_access, slot, contents, name, there, HINT)
        };
        let nodes = array(NODES_SLOT, kind.name(), tree.node_bytes())?;
        let arrays = [nodes, array(TRIANGLES_SLOT, TRIANGLES, ordered)?];
        let uploaded = Self { kind, depth, with_splits: tree.with_splits(), arrays, stacks };
        gpu.queue.submit([]);
        gpu.wait()?;
        Ok(uploaded)
    }

    /// What a search reads.
    pub(crate) fn arrays(&self) -> &[Readable] {
        &self.arrays
    }

    /// How a search reads it.
    pub(crate) fn memory_access(&self) -> MemoryAccess {
        self.arrays[0].memory_access()
    }

    /// Nodes that there is room for.
    pub(crate) fn node_room(&self) -> u64 {
        self.arrays[0].used() / self.kind.node_bytes()
    }

    /// Slots of the leaves.
    pub(crate) fn reference_count(&self) -> u64 {
        self.arrays[1].used() / size_of::<DeviceTriangle>() as u64
    }

    /// Stacks in device memory, if the hierarchy needs them, and for how many lanes.
    pub(crate) fn stacks(&self) -> Option<(&Buffer, u32)> {
        self.stacks.as_ref().map(|(stacks, lanes)| (stacks, *lanes))
    }

    /// Enters every texture and buffer but those that a build fills.
    pub(crate) fn enter(&self, ledger: &mut Ledger) {
        self.arrays.iter().for_each(|array| array.enter(ledger));
        if let Some((stacks, _)) = &self.stacks {
            ledger.keep(STACKS, stacks.size(), stacks.size());
        }
    }

    /// What is to be said of the hierarchy as it was read back.
    ///
    /// # Errors
    /// [`TracerError::Failed`] if it has more levels than stacks are for.
    pub(crate) fn statistics(&self, tree: &Tree, references: usize) -> Result<Vec<(&'static str, f64)>, TracerError> {
        let depth = tree.depth()?;
        if depth > self.depth {
            return Err(TracerError::Failed(format!("{depth} levels, stacks are for {}", self.depth)));
        }
        Ok(vec![
            ("nodes", tree.node_count() as f64),
            ("depth", depth as f64),
            ("references", references as f64),
            ("sah_cost", tree.sah_cost()),
        ])
    }

    /// Reads the hierarchy back.
    ///
    /// # Errors
    /// [`TracerError::Failed`] if the device fails.
    pub(crate) fn read(&self, gpu: &Gpu) -> Result<(Tree, Vec<DeviceTriangle>), TracerError> {
        self.read_first(gpu, self.arrays[0].used())
    }

    /// Reads a hierarchy back of whose nodes no more than the first `node_bytes` are in use.
    ///
    /// # Errors
    /// [`TracerError::Failed`] if the device fails.
    pub(crate) fn read_first(&self, gpu: &Gpu, node_bytes: u64) -> Result<(Tree, Vec<DeviceTriangle>), TracerError> {
        let [nodes, triangles] = &self.arrays;
        let mut nodes = nodes.read(gpu)?;
        nodes.truncate(node_bytes as usize);
        let triangles: Vec<DeviceTriangle> = bytemuck::pod_collect_to_vec(&triangles.read(gpu)?);
        Ok((Tree::from_device(self.kind, &nodes, &triangles, self.with_splits), triangles))
    }
}

/// Room for stacks of the hierarchy's depth, for a workgroup at least.
fn stacks(gpu: &Gpu, kind: NodeKind, depth: usize) -> Result<(Buffer, u32), TracerError> {
    let stack_bytes = depth as u64 * stack_entry_bytes(kind);
    let lanes = (STACK_BYTES / stack_bytes).clamp(1, MAX_DEEP_LANES).next_multiple_of(u64::from(LANES_OF_WORKGROUP));
    let bytes = lanes * stack_bytes;
    let hint = "the number of triangles that coincide, of which such deep hierarchies come";
    gpu.check_storage_binding(STACKS, bytes, hint)?;
    Ok((gpu.buffer(STACKS, bytes, BufferUsages::STORAGE, hint)?, lanes as u32))
}
