//! `ploc-gpu`: a hierarchy that is built on the device from the scene's triangles, every time, and traversed there by the
//! searches of `bvh-gpu`.
//!
//! The build is PLOC++ (Benthin, Drabinski, Tessari, Dittebrandt, HPG 2022) over 30-bit Morton codes of the triangles'
//! boxes. H-PLOC (Benthin et al., HPG 2024) gives hierarchies of that quality in one launch and PLOC++ needs one kernel an
//! iteration, but both have workgroups that wait for others, or that go on with what another has just written: WGSL promises
//! neither that others make progress nor that their writes are seen within a dispatch, and has no subgroups without an
//! extension. So iterations are dispatches here, four kernels each; their number has a bound that
//! the host knows (`iterations`), so nothing is read back, and it bounds the depth, too. H-PLOC in rounds, a dispatch each, was
//! tried and saved too little: docs/bvh.md says what and why.
//!
//! `tree=lbvh` makes Karras's binary radix tree (HPG 2012) in the place of clusters, without the treelets (Karras, Aila, HPG
//! 2013) that would give it a quality like theirs. shaders/bvh/radix_tree.wgsl says how its boxes come about. Codes have 30 bits and
//! places 32, so it is no deeper than 62.
//!
//! The preset `published` searches 8 neighbours on each side in every iteration, H-PLOC's advice, beyond which hierarchies
//! hardly get better; `improved` searches 2 in the first two iterations, as obvhs's search depth threshold does.
//!
//! Compressed nodes are converted from the binary ones level by level. The conversion is a phase of the build and counted
//! with it. Which place a compressed node has may differ from build to build, as lanes ask for places in no order; what is
//! in it does not, nor do hits and counts.
//!
//! A hierarchy over thousands of equal triangles is balanced here, so private stacks serve it; whether there are such is read
//! back before the first trace, which then takes a ray a lane as `bvh-gpu` does for its deep hierarchies.
//!
//! Phases: build, refit and trace by the device's clock, every kernel within one. Bindings and uniforms are made before.

mod buffers;
mod description;
mod iterations;
mod kernels;
mod plan;
#[cfg(test)]
mod reference;
#[cfg(test)]
mod tests;

use std::cell::OnceCell;
use std::sync::Arc;

use tracebench_api::{
    Counter, Geometry, Gpu, HitBuffer, Ledger, MemoryEntry, MemoryReport, PhaseClock, TraceJob, TracerError,
};

use tracebench_kit::{BuildJob, DevicePipelines, DeviceStructure, DeviceTracer, Search, SearchJob, SurfaceGeometry};

use description::PlocParameters;
pub use description::description;

use crate::gpu::description::NodeKind;
use crate::gpu::layout::{DeviceTriangle, Tree};
use crate::gpu::resident::Resident;
use crate::gpu::search::{Counting, Searched, Searches, private_stack, trace_memory};
use crate::input::{check_fits, scale_for};
use buffers::WIDE_NODE_BYTES;
use kernels::{CROWDED, FINISHED, Kernels, LEVELS, TAKEN_SLOTS};
use plan::Plan;

/// The tracer.
pub type PlocGpu = DeviceTracer<PlocStructure>;

/// The pipelines of builds and of searches.
pub struct Pipelines {
    kernels: Kernels,
    searches: Searches,
}

/// A hierarchy on the device, with what it takes to build it again.
pub struct PlocStructure {
    pipelines: Arc<Pipelines>,
    plan: Plan,
    resident: Resident,
    geometry: SurfaceGeometry,
    /// Factor from scene units to those of the hierarchy, a power of two.
    scale: f32,
    /// Whether many triangles coincide; asked of the device once, before the first trace.
    crowded: OnceCell<bool>,
}

impl PlocStructure {
    fn searched(&self, job: &TraceJob<'_>) -> Result<Searched<'_>, TracerError> {
        let parameters = PlocParameters::try_from(job.parameters)?;
        let rays_per_lane = self.rays_per_lane(parameters.rays_per_lane)?;
        Ok(Searched { resident: &self.resident, geometry: &self.geometry, scale: self.scale, rays_per_lane })
    }

    /// How far the last build came, word by word; known once its clock has been finished.
    fn progress(&self) -> Result<Vec<u32>, TracerError> {
        let room = &self.plan.buffers.progress;
        Ok(bytemuck::pod_collect_to_vec(&self.pipelines.kernels.gpu.read(&room.buffer, room.used_bytes)?))
    }

    fn wide_nodes(&self) -> Result<u64, TracerError> {
        Ok(self.progress()?[LEVELS..].iter().map(|nodes| u64::from(*nodes)).sum())
    }

    /// Rays that a lane answers: one where hundreds of triangles coincide: a ray that meets one tests all, and Mesa's
    /// software driver ends a lane's loops after 65,535 rounds, which a few such rays reach.
    fn rays_per_lane(&self, asked: u32) -> Result<u32, TracerError> {
        let crowded = match self.crowded.get() {
            Some(crowded) => *crowded,
            None => {
                let crowded = self.progress()?[CROWDED] != 0;
                *self.crowded.get_or_init(|| crowded)
            }
        };
        Ok(if crowded { 1 } else { asked })
    }

    /// Reads the hierarchy back.
    fn read(&self) -> Result<(Tree, Vec<DeviceTriangle>), TracerError> {
        let node_bytes = match self.plan.kind {
            NodeKind::Wide => self.wide_nodes()? * WIDE_NODE_BYTES,
            NodeKind::Binary => self.plan.arrays[0].used(),
        };
        self.resident.read_first(&self.pipelines.kernels.gpu, node_bytes)
    }
}

impl DevicePipelines for Pipelines {
    fn new(gpu: Arc<Gpu>) -> Result<Self, TracerError> {
        Ok(Self { kernels: Kernels::new(Arc::clone(&gpu))?, searches: Searches::new(gpu)? })
    }
}

impl Search for PlocStructure {
    type Counting = Counting;

    fn record(&self, search: SearchJob<'_, '_, Counting>) -> Result<(), TracerError> {
        let SearchJob { job, hits, counting, clock } = search;
        self.pipelines.searches.record(self.searched(job)?, job, hits, counting, clock)
    }

    fn count(&self, job: &TraceJob<'_>, hits: &HitBuffer) -> Result<Vec<Counter>, TracerError> {
        self.pipelines.searches.count(self.searched(job)?, job, hits)
    }
}

impl DeviceStructure for PlocStructure {
    type Pipelines = Pipelines;

    fn build(pipelines: &Arc<Pipelines>, job: BuildJob<'_, '_, Self>) -> Result<Self, TracerError> {
        let BuildJob { geometry, parameters, before, clock, .. } = job;
        let kernels = &pipelines.kernels;
        let parameters = PlocParameters::try_from(parameters)?;
        let count = geometry.triangles.len() as u32;
        let plan = Plan::new(kernels, &parameters, count, before.map(|before| &before.plan))?;
        let kind = plan.kind;
        let scale = scale_for(geometry.diagonal());
        plan.build(kernels, geometry, scale, clock)?;
        // Neither kind of node has more levels than a private stack serves.
        let resident = Resident::of_arrays(kind, private_stack(kind), plan.arrays.clone());
        Ok(Self {
            pipelines: Arc::clone(pipelines),
            plan,
            resident,
            geometry: SurfaceGeometry::of(geometry)?,
            scale,
            crowded: OnceCell::new(),
        })
    }

    fn refit(&mut self, geometry: &Geometry, clock: &mut PhaseClock<'_>) -> Result<(), TracerError> {
        check_fits(self.plan.triangle_count as usize, geometry)?;
        let scale = scale_for(geometry.diagonal());
        self.plan.refit(&self.pipelines.kernels, geometry, scale, clock)?;
        (self.scale, self.geometry) = (scale, SurfaceGeometry::of(geometry)?);
        Ok(())
    }

    fn memory(&self) -> MemoryReport {
        let mut ledger = Ledger::new();
        // A device that fails says so at the next trace; until then all of the nodes' room counts as used.
        let room = self.plan.buffers.wide.as_ref().map_or(0, |wide| wide.used_bytes / WIDE_NODE_BYTES);
        self.resident.enter(&mut ledger);
        self.plan.buffers.enter(self.wide_nodes().unwrap_or(room).min(room), &self.plan.sort, &mut ledger);
        ledger.borrow_transient(self.plan.uniform_bytes());
        ledger.report(0).with_surface_geometry(self.geometry.bytes)
    }

    fn trace_memory(&self, job: &TraceJob<'_>) -> Result<Vec<MemoryEntry>, TracerError> {
        Ok(trace_memory(&self.resident, job))
    }

    fn validate(&self, _geometry: &Geometry) -> Result<Vec<(&'static str, f64)>, TracerError> {
        let (tree, ordered) = self.read()?;
        tree.check(&ordered, self.plan.triangle_count as usize, true)?;
        let mut statistics = self.resident.statistics(&tree, ordered.len())?;
        let progress = self.progress()?;
        // Iterations that began with fewer clusters than the one before.
        let counts = progress[..FINISHED].iter().chain(&progress[FINISHED..TAKEN_SLOTS]).filter(|count| **count > 0);
        let counts: Vec<u32> = counts.copied().collect();
        let iterations = counts.windows(2).filter(|pair| pair[1] < pair[0]).count();
        statistics.push(("cluster_iterations", iterations as f64));
        Ok(statistics)
    }
}
