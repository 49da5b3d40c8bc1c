//! A hierarchy in the device's memory.

use tracebench_api::wgpu::{Buffer, BufferUsages};
use tracebench_api::{Gpu, Ledger, TracerError};

use super::layout::{DeviceTriangle, NodeKind, Tree};
use super::search::{WORKGROUP_SIZE, private_stack, stack_entry_bytes};

const TURN_DOWN: &str = "the scene's triangle count, or take a build without splits (--set bvh-gpu.build=medium)";

/// Bytes that stacks in device memory may take beyond one workgroup's.
const STACK_BYTES: u64 = 32 << 20;

/// Most lanes that have stacks in device memory.
const MOST_DEEP_LANES: u64 = 1 << 16;

/// A buffer, how many bytes of it are in use, and what it is called.
#[derive(Debug)]
struct Part {
    name: &'static str,
    buffer: Buffer,
    used: u64,
}

impl Part {
    /// Writes into the buffer that is there if it is large enough, else into a new one. The caller has checked that it can
    /// be bound.
    fn write(gpu: &Gpu, name: &'static str, contents: &[u8], there: Option<&Part>) -> Result<Self, TracerError> {
        let used = contents.len() as u64;
        if let Some(there) = there.filter(|there| there.buffer.size() >= used) {
            gpu.queue.write_buffer(&there.buffer, 0, contents);
            return Ok(Self { name, buffer: there.buffer.clone(), used });
        }
        let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC;
        Ok(Self { name, buffer: gpu.buffer_with(name, contents, usage, TURN_DOWN)?, used })
    }
}

/// Nodes, triangles in the order of the leaves and, for a hierarchy too deep for private stacks, stacks.
#[derive(Debug)]
pub(crate) struct Resident {
    pub(crate) kind: NodeKind,
    pub(crate) depth: usize,
    with_splits: bool,
    nodes: Part,
    triangles: Part,
    /// With the number of lanes that have one.
    stacks: Option<(Part, u32)>,
}

impl Resident {
    /// Uploads, into the buffers of `there` where these are large enough, and waits until the device has everything. What
    /// was there is as it was after an error that a size has caused.
    ///
    /// # Errors
    /// [`TracerError::TooLarge`] if a part cannot be bound.
    pub(crate) fn upload(
        gpu: &Gpu,
        tree: &Tree,
        depth: usize,
        ordered: &[DeviceTriangle],
        there: Option<&Resident>,
    ) -> Result<Self, TracerError> {
        let kind = tree.kind();
        let there = there.filter(|there| there.kind == kind);
        let ordered: &[u8] = bytemuck::cast_slice(ordered);
        gpu.check_storage_binding(kind.name(), tree.node_bytes().len() as u64, TURN_DOWN)?;
        gpu.check_storage_binding("triangles in leaf order", ordered.len() as u64, TURN_DOWN)?;
        let stacks = (depth > private_stack(kind)).then(|| stacks(gpu, kind, depth)).transpose()?;
        let uploaded = Self {
            kind,
            depth,
            with_splits: tree.with_splits(),
            nodes: Part::write(gpu, kind.name(), tree.node_bytes(), there.map(|there| &there.nodes))?,
            triangles: Part::write(gpu, "triangles in leaf order", ordered, there.map(|there| &there.triangles))?,
            stacks,
        };
        gpu.queue.submit([]);
        gpu.wait()?;
        Ok(uploaded)
    }

    pub(crate) fn nodes(&self) -> &Buffer {
        &self.nodes.buffer
    }

    pub(crate) fn triangles(&self) -> &Buffer {
        &self.triangles.buffer
    }

    /// Stacks in device memory, if the hierarchy needs them, and for how many lanes.
    pub(crate) fn stacks(&self) -> Option<(&Buffer, u32)> {
        self.stacks.as_ref().map(|(stacks, lanes)| (&stacks.buffer, *lanes))
    }

    /// Enters every buffer.
    pub(crate) fn enter(&self, ledger: &mut Ledger) {
        for part in [Some(&self.nodes), Some(&self.triangles), self.stacks.as_ref().map(|(stacks, _)| stacks)]
            .into_iter()
            .flatten()
        {
            ledger.keep(part.name, part.buffer.size(), part.used);
        }
    }

    /// Reads the hierarchy back.
    ///
    /// # Errors
    /// [`TracerError::Failed`] if the device fails.
    pub(crate) fn read(&self, gpu: &Gpu) -> Result<(Tree, Vec<DeviceTriangle>), TracerError> {
        let nodes = gpu.read(&self.nodes.buffer, self.nodes.used)?;
        let triangles: Vec<DeviceTriangle> =
            bytemuck::pod_collect_to_vec(&gpu.read(&self.triangles.buffer, self.triangles.used)?);
        Ok((Tree::from_device(self.kind, &nodes, &triangles, self.with_splits), triangles))
    }
}

/// Room for stacks of the hierarchy's depth, for a workgroup at least.
fn stacks(gpu: &Gpu, kind: NodeKind, depth: usize) -> Result<(Part, u32), TracerError> {
    let stack_bytes = depth as u64 * stack_entry_bytes(kind);
    let lanes = (STACK_BYTES / stack_bytes).clamp(1, MOST_DEEP_LANES).next_multiple_of(u64::from(WORKGROUP_SIZE));
    let bytes = lanes * stack_bytes;
    let turn_down = "the number of triangles that coincide, of which such deep hierarchies come";
    gpu.check_storage_binding("traversal stacks", bytes, turn_down)?;
    let buffer = gpu.buffer("traversal stacks", bytes, BufferUsages::STORAGE, turn_down)?;
    Ok((Part { name: "traversal stacks", buffer, used: bytes }, lanes as u32))
}
