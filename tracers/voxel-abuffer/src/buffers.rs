//! What a build fills: the grid, the heads of lists, and nodes.

use std::num::NonZeroU64;

use tracebench_api::wgpu::{BindingResource, Buffer, BufferBinding};
use tracebench_api::{Gpu, Ledger, TracerError};
use tracebench_kit::{EmptyTarget, RasterBackend, storage_buffer};

use crate::layout::{AXES, AXIS_NAMES, Layout};
use crate::nodes::{HINT, Nodes};

const TURN_GRID_DOWN: &str = "voxel-abuffer.grid (or voxel-abuffer.abuffer and --face-size, where that is 0)";

const HEADS: &str = "heads";
const TAKEN: &str = "fragment counts";
const FRAGMENTS: &str = "fragments of voxels";
const TARGET: &str = "attachment of the axes' images";

/// What a build left in the counts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Taken {
    /// Fragments that were drawn, by axis.
    pub fragments: [u32; AXES],
    /// Lists that the driver did not let be ordered.
    pub unordered: u32,
    /// Layers that were left out as copies of others.
    pub copies: u32,
    /// Voxels with more fragments than their sums hold.
    pub crowded: u32,
}

/// Words of the counts, in the order of [`Taken`].
pub(crate) const TAKEN_WORDS: u64 = 6;

/// The A-buffers.
#[derive(Clone, Debug)]
pub(crate) struct Lists {
    pub heads: Buffer,
    pub taken: Buffer,
    pub nodes: Nodes,
    /// What averages are made of; none where fragments are planes.
    pub summed: Option<Summed>,
    head_stride: u32,
}

/// What averages are made of.
#[derive(Clone, Debug)]
pub(crate) struct Summed {
    /// Sums of normals, a component each.
    pub sums: [Buffer; AXES],
    /// Fragments of every voxel.
    pub fragments: Buffer,
}

/// All buffers.
#[derive(Clone, Debug)]
pub(crate) struct Buffers {
    /// None where there is no rasterizer.
    pub target: Option<EmptyTarget>,
    /// What searches read of the grid.
    pub cells: Buffer,
    /// None where there are voxels only.
    pub lists: Option<Lists>,
}

fn sum_name(axis: usize) -> String {
    format!("sums of normals, {}", AXIS_NAMES[axis])
}

impl Buffers {
    /// Buffers with room for so many nodes of every axis.
    ///
    /// # Errors
    /// [`TracerError::TooLarge`] beyond the device's limits.
    pub(crate) fn new(gpu: &Gpu, layout: &Layout, nodes: [u32; AXES]) -> Result<Self, TracerError> {
        check_sizes(gpu, layout)?;
        let cells = storage_buffer(gpu, cells_name(layout), u64::from(layout.cell_words()) * 4, TURN_GRID_DOWN)?;
        let lists = if layout.voxels_only { None } else { Some(Lists::new(gpu, layout, nodes)?) };
        let drawn = layout.raster_backend == RasterBackend::Raster;
        let target = drawn.then(|| EmptyTarget::new(gpu, TARGET, [layout.image(); 2])).transpose()?;
        Ok(Self { target, cells, lists })
    }

    /// What the last build left.
    pub(crate) fn taken(&self, gpu: &Gpu) -> Result<Taken, TracerError> {
        let Some(lists) = &self.lists else { return Ok(Taken::default()) };
        let read: Vec<u32> = bytemuck::pod_collect_to_vec(&gpu.read(&lists.taken, TAKEN_WORDS * 4)?);
        let [x, y, z, unordered, copies, crowded] = read[..] else {
            return Err(TracerError::Failed("the counts were not read whole".to_owned()));
        };
        Ok(Taken { fragments: [x, y, z], unordered, copies, crowded })
    }

    /// Enters every buffer; `taken` is what the last build left.
    pub(crate) fn enter(&self, layout: &Layout, taken: &Taken, ledger: &mut Ledger) {
        let mut keep = |name: &str, buffer: &Buffer| ledger.keep(name, buffer.size(), buffer.size());
        keep(cells_name(layout), &self.cells);
        if let Some(lists) = &self.lists {
            keep(HEADS, &lists.heads);
            keep(TAKEN, &lists.taken);
            if let Some(summed) = &lists.summed {
                keep(FRAGMENTS, &summed.fragments);
                for (axis, sum) in summed.sums.iter().enumerate() {
                    keep(&sum_name(axis), sum);
                }
            }
            lists.nodes.enter(taken.fragments, ledger);
        }
        if let Some(target) = &self.target {
            target.enter(ledger);
        }
    }
}

fn cells_name(layout: &Layout) -> &'static str {
    if layout.voxels_only { "occupied voxels" } else { "axes of voxels" }
}

/// That the device can draw an image of that edge, of which drivers would speak in words of their own, and bind what does not hang on the
/// scene: before nodes are counted, which takes long of what is too large.
pub(crate) fn check_sizes(gpu: &Gpu, layout: &Layout) -> Result<(), TracerError> {
    let (edge, limit) = (layout.image(), gpu.limits.max_texture_dimension_2d);
    if edge > limit {
        let (bytes, limit) = (u64::from(edge), u64::from(limit));
        return Err(TracerError::TooLarge { name: TARGET.to_owned(), bytes, limit, hint: HINT.to_owned() });
    }
    gpu.check_storage_binding(cells_name(layout), u64::from(layout.cell_words()) * 4, TURN_GRID_DOWN)?;
    if layout.voxels_only {
        return Ok(());
    }
    gpu.check_storage_binding(HEADS, head_bytes(layout), HINT)?;
    if layout.planes {
        return Ok(());
    }
    gpu.check_storage_binding(FRAGMENTS, u64::from(layout.voxels()) * 4, TURN_GRID_DOWN)
}

fn head_bytes(layout: &Layout) -> u64 {
    u64::from(layout.head_stride()) * 4 * AXES as u64
}

impl Lists {
    fn new(gpu: &Gpu, layout: &Layout, nodes: [u32; AXES]) -> Result<Self, TracerError> {
        let heads = storage_buffer(gpu, HEADS, head_bytes(layout), HINT)?;
        let grid = |name: &str| storage_buffer(gpu, name, u64::from(layout.voxels()) * 4, TURN_GRID_DOWN);
        let summed = || -> Result<Summed, TracerError> {
            let sums = [grid(&sum_name(0))?, grid(&sum_name(1))?, grid(&sum_name(2))?];
            Ok(Summed { sums, fragments: grid(FRAGMENTS)? })
        };
        Ok(Self {
            heads,
            taken: storage_buffer(gpu, TAKEN, TAKEN_WORDS * 4, "nothing")?,
            summed: (!layout.planes).then(summed).transpose()?,
            nodes: Nodes::new(gpu, layout.raster_backend, nodes)?,
            head_stride: layout.head_stride(),
        })
    }

    /// An axis' own of the heads.
    pub(crate) fn heads_of(&self, axis: usize) -> BindingResource<'_> {
        let bytes = u64::from(self.head_stride) * 4;
        let offset = bytes * axis as u64;
        BindingResource::Buffer(BufferBinding { buffer: &self.heads, offset, size: NonZeroU64::new(bytes) })
    }
}
