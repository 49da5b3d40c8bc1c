//! The structure of one scene.

use std::sync::Arc;

use tracebench_api::{
    Geometry, Ledger, MemoryEntry, MemoryReport, Parameters, SampledImage, TraceJob, TracerError, VoxelGrid,
};
use tracebench_kit::{
    BuildJob, DeviceStructure, DeviceTracer, MemoryAccess, ReadSlot, Readable, grow, record_copies,
    samplings_along_axes, voxel_grid,
};

use crate::build::{LEAF_BYTES, LEAVES, NODE_BYTES, NODES, Scene, TAKEN, Tree};
use crate::counts::{Counts, Taken};
use crate::description::{NO_REFIT, OctreeParameters};
use crate::kernels::Kernels;
use crate::layout::{HINT, Layout, OctreeSearch};

/// The tracer.
pub type VoxelOctree = DeviceTracer<OctreeStructure>;

/// A tree. Nothing of it hangs on the eye.
pub struct OctreeStructure {
    pub(crate) kernels: Arc<Kernels>,
    pub(crate) layout: Layout,
    pub(crate) scene: Scene,
    pub(crate) tree: Tree,
    /// Nodes and leaves as searches read them.
    pub(crate) arrays: [Readable; 2],
    /// Bytes that the last build needed beside.
    scratch_bytes: u64,
}

/// Nodes and leaves of a tree as searches read them, in the textures of `there` where these have room.
fn readable(
    kernels: &Kernels,
    memory_access: MemoryAccess,
    tree: &Tree,
    there: Option<&[Readable; 2]>,
) -> Result<[Readable; 2], TracerError> {
    let array = |slot, buffer, name, place: usize| {
        let there = there.map(|there| &there[place]);
        Readable::built(&kernels.gpu, memory_access, slot, buffer, buffer.size(), name, there, HINT)
    };
    Ok([
        array(ReadSlot::Pairs0, &tree.nodes, "nodes (texture)", 0)?,
        array(ReadSlot::Pairs1, &tree.leaves, "leaves (texture)", 1)?,
    ])
}

impl DeviceStructure for OctreeStructure {
    type Pipelines = Kernels;

    const NO_REFIT: &'static str = NO_REFIT;

    fn build(pipelines: &Arc<Kernels>, job: BuildJob<'_, '_, Self>) -> Result<Self, TracerError> {
        let BuildJob { geometry, viewpoint, parameters, before, clock } = job;
        let parameters = OctreeParameters::try_from(parameters)?;
        let layout = Layout::new(geometry, viewpoint, &parameters);
        let scene = Scene::of(pipelines, geometry)?;
        // Of another grid nothing is known; of moved triangles what there is may do.
        let tree = match before {
            Some(before) if layout.levels == before.layout.levels => before.tree.clone(),
            _ => Tree::new(pipelines, &layout, pipelines.tally(&layout, &scene)?)?,
        };
        let arrays = readable(pipelines, parameters.memory_access, &tree, before.map(|before| &before.arrays))?;
        let scratch_bytes = pipelines.build(&layout, &scene, &tree, clock)?;
        record_copies(&arrays, clock)?;
        Ok(Self { kernels: Arc::clone(pipelines), layout, scene, tree, arrays, scratch_bytes })
    }

    fn grow_on_overflow(&mut self) -> Result<bool, TracerError> {
        let taken = Taken::read(&self.kernels.gpu, &self.tree.taken)?;
        // Where one stage had no room, those behind it counted too few.
        if self.tree.room.hold(&taken.counts(self.layout.levels)?) {
            return Ok(false);
        }
        let needed = self.kernels.tally(&self.layout, &self.scene)?;
        let mut made = None;
        grow(&needed.list(), |counts| {
            made = Some(Tree::new(&self.kernels, &self.layout, Counts::from_list(counts))?);
            Ok(())
        })?;
        if let Some(tree) = made {
            self.arrays = readable(&self.kernels, self.arrays[0].memory_access(), &tree, Some(&self.arrays))?;
            self.tree = tree;
        }
        Ok(true)
    }

    fn memory(&self) -> MemoryReport {
        let mut ledger = Ledger::new();
        let levels = self.layout.levels;
        // Of a lost device nothing is known to be used.
        let taken = Taken::read(&self.kernels.gpu, &self.tree.taken);
        let used = |depths: std::ops::Range<u32>| {
            taken.as_ref().map_or(0, |taken| depths.map(|depth| u64::from(taken.of_depth(depth))).sum())
        };
        let Tree { nodes, leaves, taken: counts, .. } = &self.tree;
        ledger.keep(NODES, nodes.size(), (used(0..levels) * NODE_BYTES).min(nodes.size()));
        ledger.keep(LEAVES, leaves.size(), (used(levels..levels + 1) * LEAF_BYTES).min(leaves.size()));
        ledger.keep(TAKEN, counts.size(), counts.size());
        self.arrays.iter().for_each(|array| array.enter(&mut ledger));
        ledger.borrow_transient(self.scratch_bytes);
        // Leaves have all that hits and surfaces need.
        ledger.report(0)
    }

    fn trace_memory(&self, job: &TraceJob<'_>) -> Result<Vec<MemoryEntry>, TracerError> {
        OctreeParameters::try_from(job.parameters)?;
        Ok(vec![MemoryEntry::whole("search", size_of::<OctreeSearch>() as u64)])
    }

    fn samplings(&self, _parameters: &Parameters) -> Result<Vec<SampledImage>, TracerError> {
        // A voxel is a texel of the images along all three axes.
        Ok(samplings_along_axes(&self.layout.space))
    }

    fn voxels(&self, parameters: &Parameters) -> Result<Option<VoxelGrid>, TracerError> {
        OctreeParameters::try_from(parameters)?;
        Ok(Some(voxel_grid(&self.layout.space, None)))
    }

    fn validate(&self, geometry: &Geometry) -> Result<Vec<(&'static str, f64)>, TracerError> {
        self.validate_against(geometry)
    }
}
