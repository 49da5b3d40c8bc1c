//! A hierarchy in the device's memory.

use tracebench_api::wgpu::{Buffer, BufferUsages, TextureView};
use tracebench_api::{Gpu, Ledger, TracerError};

use super::description::NodeKind;
use super::layout::{DeviceTriangle, Tree};
use super::search::{WORKGROUP_SIZE, private_stack, stack_entry_bytes};
use super::texels::Texels;

const TURN_DOWN: &str = "the scene's triangle count, or take a build without splits (--set bvh-gpu.build=medium)";

pub(crate) const TRIANGLES: &str = "triangles in leaf order";

const STACKS: &str = "traversal stacks";

/// Bytes that stacks in device memory may take beyond one workgroup's.
const STACK_BYTES: u64 = 32 << 20;

/// Most lanes that have stacks in device memory.
const MOST_DEEP_LANES: u64 = 1 << 16;

/// Nodes, triangles in the order of the leaves and, for a hierarchy too deep for private stacks, stacks.
#[derive(Debug)]
pub(crate) struct Resident {
    pub(crate) kind: NodeKind,
    pub(crate) depth: usize,
    with_splits: bool,
    nodes: Texels,
    triangles: Texels,
    /// With the number of lanes that have one.
    stacks: Option<(Buffer, u32)>,
}

impl Resident {
    /// Takes over what kernels fill: nodes of no more than `depth` levels, which private stacks must serve, and triangles
    /// in the order of the leaves.
    pub(crate) fn of_texels(kind: NodeKind, depth: usize, nodes: Texels, triangles: Texels) -> Self {
        Self { kind, depth, with_splits: false, nodes, triangles, stacks: None }
    }

    /// Uploads, into the textures of `there` where these are large enough, and waits until the device has everything. What
    /// was there is as it was after an error that a size has caused.
    ///
    /// # Errors
    /// [`TracerError::TooLarge`] if the device cannot hold a part.
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
        Texels::check(gpu, kind.name(), tree.node_bytes().len(), TURN_DOWN)?;
        Texels::check(gpu, TRIANGLES, ordered.len(), TURN_DOWN)?;
        let stacks = (depth > private_stack(kind)).then(|| stacks(gpu, kind, depth)).transpose()?;
        let uploaded = Self {
            kind,
            depth,
            with_splits: tree.with_splits(),
            nodes: Texels::write(gpu, kind.name(), tree.node_bytes(), there.map(|there| &there.nodes), TURN_DOWN)?,
            triangles: Texels::write(gpu, TRIANGLES, ordered, there.map(|there| &there.triangles), TURN_DOWN)?,
            stacks,
        };
        gpu.queue.submit([]);
        gpu.wait()?;
        Ok(uploaded)
    }

    pub(crate) fn nodes(&self) -> &TextureView {
        self.nodes.view()
    }

    pub(crate) fn triangles(&self) -> &TextureView {
        self.triangles.view()
    }

    /// Nodes that there is room for.
    pub(crate) fn node_room(&self) -> u64 {
        self.nodes.used() / self.kind.node_bytes()
    }

    /// Slots of the leaves.
    pub(crate) fn reference_count(&self) -> u64 {
        self.triangles.used() / size_of::<DeviceTriangle>() as u64
    }

    /// Stacks in device memory, if the hierarchy needs them, and for how many lanes.
    pub(crate) fn stacks(&self) -> Option<(&Buffer, u32)> {
        self.stacks.as_ref().map(|(stacks, lanes)| (stacks, *lanes))
    }

    /// Enters every texture and buffer.
    pub(crate) fn enter(&self, ledger: &mut Ledger) {
        self.nodes.enter(ledger);
        self.triangles.enter(ledger);
        if let Some((stacks, _)) = &self.stacks {
            ledger.keep(STACKS, stacks.size(), stacks.size());
        }
    }

    /// Reads the hierarchy back.
    ///
    /// # Errors
    /// [`TracerError::Failed`] if the device fails.
    pub(crate) fn read(&self, gpu: &Gpu) -> Result<(Tree, Vec<DeviceTriangle>), TracerError> {
        self.read_first(gpu, self.nodes.used())
    }

    /// Reads a hierarchy back of whose nodes no more than the first `node_bytes` are in use.
    ///
    /// # Errors
    /// [`TracerError::Failed`] if the device fails.
    pub(crate) fn read_first(&self, gpu: &Gpu, node_bytes: u64) -> Result<(Tree, Vec<DeviceTriangle>), TracerError> {
        let mut nodes = self.nodes.read(gpu)?;
        nodes.truncate(node_bytes as usize);
        let triangles: Vec<DeviceTriangle> = bytemuck::pod_collect_to_vec(&self.triangles.read(gpu)?);
        Ok((Tree::from_device(self.kind, &nodes, &triangles, self.with_splits), triangles))
    }
}

/// Room for stacks of the hierarchy's depth, for a workgroup at least.
fn stacks(gpu: &Gpu, kind: NodeKind, depth: usize) -> Result<(Buffer, u32), TracerError> {
    let stack_bytes = depth as u64 * stack_entry_bytes(kind);
    let lanes = (STACK_BYTES / stack_bytes).clamp(1, MOST_DEEP_LANES).next_multiple_of(u64::from(WORKGROUP_SIZE));
    let bytes = lanes * stack_bytes;
    let turn_down = "the number of triangles that coincide, of which such deep hierarchies come";
    gpu.check_storage_binding(STACKS, bytes, turn_down)?;
    Ok((gpu.buffer(STACKS, bytes, BufferUsages::STORAGE, turn_down)?, lanes as u32))
}
