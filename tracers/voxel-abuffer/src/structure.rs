//! The structure of one scene.

use std::sync::Arc;

use tracebench_api::{
    Geometry, Ledger, MemoryEntry, MemoryReport, Parameters, SampledImage, TraceJob, TracerError, VoxelGrid,
};
use tracebench_kit::{BuildJob, DeviceStructure, DeviceTracer, grow};

use crate::arrays::Arrays;
use crate::buffers::{Buffers, Taken};
use crate::build::{Pipelines, build_bytes};
use crate::description::{NO_REFIT, VoxelParameters};
use crate::layout::{AXES, Layout};
use crate::nodes::Nodes;
use crate::search::VoxelSearch;

/// The tracer.
pub type VoxelAbuffer = DeviceTracer<VoxelStructure>;

/// Grid and A-buffers. Nothing of them hangs on the eye.
pub struct VoxelStructure {
    pub(crate) pipelines: Arc<Pipelines>,
    pub(crate) layout: Layout,
    pub(crate) buffers: Buffers,
    pub(crate) arrays: Arrays,
    triangle_count: u32,
}

impl DeviceStructure for VoxelStructure {
    type Pipelines = Pipelines;

    const NO_REFIT: &'static str = NO_REFIT;

    fn build(pipelines: &Arc<Pipelines>, job: BuildJob<'_, '_, Self>) -> Result<Self, TracerError> {
        let BuildJob { geometry, viewpoint, parameters, before, clock } = job;
        let gpu = &*pipelines.gpu;
        let parameters = VoxelParameters::try_from(parameters)?;
        let layout = Layout::new(geometry, viewpoint, &parameters);
        let sizes = |layout: &Layout| {
            (layout.voxels_only, layout.planes, layout.image(), layout.space.grid, layout.raster_backend)
        };
        let nodes_before = |before: &Self| before.buffers.lists.as_ref().map(|lists| lists.nodes.capacities);
        let buffers = match before {
            Some(before) if sizes(&layout) == sizes(&before.layout) => before.buffers.clone(),
            Some(before) => Buffers::new(gpu, &layout, nodes_before(before).unwrap_or_default())?,
            None if layout.voxels_only => Buffers::new(gpu, &layout, [0; AXES])?,
            None => Buffers::new(gpu, &layout, pipelines.tally(&layout, geometry)?)?,
        };
        let arrays = Arrays::new(gpu, parameters.memory_access, &buffers, before.map(|before| &before.arrays))?;
        pipelines.build(&layout, &buffers, geometry, clock)?;
        arrays.record_copies(clock)?;
        let triangle_count = geometry.triangles.len() as u32;
        Ok(Self { pipelines: Arc::clone(pipelines), layout, buffers, arrays, triangle_count })
    }

    fn grow_on_overflow(&mut self) -> Result<bool, TracerError> {
        let gpu = &*self.pipelines.gpu;
        let taken = self.buffers.taken(gpu)?;
        let Some(lists) = &mut self.buffers.lists else { return Ok(false) };
        let fits = taken.fragments.iter().zip(&lists.nodes.capacities).all(|(count, capacity)| count <= capacity);
        if fits {
            return check(&taken).map(|()| false);
        }
        let (memory_access, raster_backend) = (self.arrays.memory_access(), self.layout.raster_backend);
        let there = lists.nodes.capacities;
        grow(&taken.fragments, |counts| {
            // An axis that fits keeps what it has.
            lists.nodes = Nodes::new(gpu, raster_backend, std::array::from_fn(|axis| counts[axis].max(there[axis])))?;
            Ok(())
        })?;
        self.arrays = Arrays::new(gpu, memory_access, &self.buffers, Some(&self.arrays))?;
        Ok(true)
    }

    fn memory(&self) -> MemoryReport {
        let mut ledger = Ledger::new();
        // Of a lost device nothing is known to be used.
        let taken = self.buffers.taken(&self.pipelines.gpu).unwrap_or_default();
        self.buffers.enter(&self.layout, &taken, &mut ledger);
        self.arrays.enter(&mut ledger);
        ledger.borrow_transient(build_bytes(&self.layout, self.triangle_count));
        // Fragments have all that hits and surfaces need.
        ledger.report(0)
    }

    fn trace_memory(&self, job: &TraceJob<'_>) -> Result<Vec<MemoryEntry>, TracerError> {
        VoxelParameters::try_from(job.parameters)?;
        Ok(vec![MemoryEntry::whole("search", size_of::<VoxelSearch>() as u64)])
    }

    fn samplings(&self, _parameters: &Parameters) -> Result<Vec<SampledImage>, TracerError> {
        Ok(self.layout.samplings())
    }

    fn voxels(&self, parameters: &Parameters) -> Result<Option<VoxelGrid>, TracerError> {
        let parameters = VoxelParameters::try_from(parameters)?;
        // Planes are met, whatever voxel they lie in: what is lost or added is told by the images alone.
        Ok((!self.layout.planes).then(|| self.layout.voxel_grid(&parameters)))
    }

    fn validate(&self, geometry: &Geometry) -> Result<Vec<(&'static str, f64)>, TracerError> {
        self.validate_against(geometry)
    }
}

/// Whether the driver let every list be ordered, and the grid's sums hold.
pub(crate) fn check(taken: &Taken) -> Result<(), TracerError> {
    if taken.unordered > 0 {
        return Err(TracerError::Failed(format!(
            "{} lists have more layers than this driver's limit of loops lets be ordered: nothing of voxel-abuffer makes them shorter; take \
             a scene with fewer surfaces behind one another, or another --adapter",
            taken.unordered
        )));
    }
    if taken.crowded > 0 {
        return Err(TracerError::Failed(format!(
            "{} voxels have more fragments than the sums of their normals hold: turn up voxel-abuffer.grid, or turn down \
             voxel-abuffer.abuffer",
            taken.crowded
        )));
    }
    Ok(())
}
