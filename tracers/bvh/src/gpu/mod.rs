//! `bvh-gpu`: a hierarchy built on the host, traversed on the device.
//!
//! Phases: those of a build are by the host's clock, since a sample knows one clock. They are the steps
//! of `bvh-cpu`'s build, then laying out what the device takes, then the upload, from the first write until the device
//! has everything. A trace is timed on the device's clock alone.

pub(crate) mod description;
pub(crate) mod layout;
pub(crate) mod resident;
pub(crate) mod search;
#[cfg(test)]
pub(crate) mod tests;

use std::sync::Arc;

use obvhs::triangle::Triangle;
use tracebench_api::{
    Counter, Geometry, Gpu, HitBuffer, Ledger, MemoryEntry, MemoryReport, PhaseClock, TraceJob, TracerError,
};

use tracebench_kit::{BuildJob, DeviceStructure, DeviceTracer, MemoryAccess, Search, SearchJob, SurfaceGeometry};

use description::GpuParameters;
pub use description::description;
pub use search::{BINARY_STACK, WIDE_STACK};

use crate::input::{check_fits, gather, scale_for};
use layout::Tree;
use resident::Resident;
use search::{Counting, Searched, Searches};

/// The tracer.
pub type BvhGpu = DeviceTracer<BvhGpuStructure>;

/// A hierarchy on the device.
pub struct BvhGpuStructure {
    searches: Arc<Searches>,
    /// Factor from scene units to those of the hierarchy, a power of two.
    scale: f32,
    resident: Resident,
    geometry: SurfaceGeometry,
    triangle_count: usize,
    memory: MemoryReport,
    /// The hierarchy as it was fitted last; none before the first refit, which reads it back.
    fitted: Option<Tree>,
}

impl BvhGpuStructure {
    fn searched(&self, job: &TraceJob<'_>) -> Result<Searched<'_>, TracerError> {
        let GpuParameters { rays_per_lane, .. } = GpuParameters::try_from(job.parameters)?;
        Ok(Searched { resident: &self.resident, geometry: &self.geometry, scale: self.scale, rays_per_lane })
    }
}

/// Lays a hierarchy out and uploads it.
fn place(
    gpu: &Gpu,
    memory_access: MemoryAccess,
    tree: &Tree,
    triangles: &[Triangle],
    there: Option<&Resident>,
    ledger: &mut Ledger,
    clock: &mut PhaseClock<'_>,
) -> Result<Resident, TracerError> {
    let (depth, ordered) = clock.host_phase("order triangles", || (tree.depth(), tree.order(triangles)));
    ledger.borrow_transient(size_of_val(ordered.as_slice()) as u64);
    let depth = depth?;
    let upload = || Resident::upload(gpu, memory_access, tree, depth, &ordered, there);
    let resident = clock.host_phase("upload (until done)", upload)?;
    resident.enter(ledger);
    Ok(resident)
}

impl Search for BvhGpuStructure {
    type Counting = Counting;

    fn record(&self, search: SearchJob<'_, '_, Counting>) -> Result<(), TracerError> {
        let SearchJob { job, hits, counting, clock } = search;
        self.searches.record(self.searched(job)?, job, hits, counting, clock)
    }

    fn count(&self, job: &TraceJob<'_>, hits: &HitBuffer) -> Result<Vec<Counter>, TracerError> {
        self.searches.count(self.searched(job)?, job, hits)
    }
}

impl DeviceStructure for BvhGpuStructure {
    type Pipelines = Searches;

    fn build(searches: &Arc<Searches>, job: BuildJob<'_, '_, Self>) -> Result<Self, TracerError> {
        let BuildJob { geometry, parameters, before, clock, .. } = job;
        let parameters = &GpuParameters::try_from(parameters)?;
        let there = before.map(|before| &before.resident);
        // Rays and hits are on the device, and so must the scene be, though the build reads it in host memory.
        let surfaces = SurfaceGeometry::of(geometry)?;
        let scale = scale_for(geometry.diagonal());
        let triangles = gather(geometry, scale, clock);
        let mut ledger = Ledger::new();
        ledger.borrow_transient(size_of_val(triangles.as_slice()) as u64);
        let tree = Tree::build(&triangles, parameters, &mut ledger, clock);
        ledger.borrow_transient((tree.node_bytes().len() + size_of_val(tree.primitive_indices())) as u64);
        let resident = place(&searches.gpu, parameters.memory_access, &tree, &triangles, there, &mut ledger, clock)?;
        Ok(Self {
            searches: Arc::clone(searches),
            scale,
            resident,
            memory: ledger.report(0).with_surface_geometry(surfaces.bytes),
            geometry: surfaces,
            triangle_count: triangles.len(),
            fitted: None,
        })
    }

    // Boxes and triangles follow the vertices. Triangles that the build split keep several boxes, each now of the whole
    // triangle.
    fn refit(&mut self, geometry: &Geometry, clock: &mut PhaseClock<'_>) -> Result<(), TracerError> {
        check_fits(self.triangle_count, geometry)?;
        let gpu = Arc::clone(&self.searches.gpu);
        let surfaces = SurfaceGeometry::of(geometry)?;
        let mut tree = match self.fitted.take() {
            Some(tree) => tree,
            None => clock.host_phase("read the hierarchy back", || self.resident.read(&gpu))?.0,
        };
        let scale = scale_for(geometry.diagonal());
        let triangles = gather(geometry, scale, clock);
        clock.host_phase("refit boxes", || tree.refit(&triangles));
        let (memory_access, there) = (self.resident.memory_access(), Some(&self.resident));
        self.resident = place(&gpu, memory_access, &tree, &triangles, there, &mut Ledger::new(), clock)?;
        (self.scale, self.geometry) = (scale, surfaces);
        self.fitted = Some(tree);
        Ok(())
    }

    fn memory(&self) -> MemoryReport {
        let mut report = self.memory.clone();
        if let Some(tree) = &self.fitted {
            let bytes = (tree.node_bytes().len() + size_of_val(tree.primitive_indices())) as u64;
            let name = "host copy for refits".to_owned();
            report.structure.push(MemoryEntry { name, allocated_bytes: bytes, used_bytes: bytes });
            report.build_peak_bytes = report.build_peak_bytes.max(report.structure_bytes());
        }
        report
    }

    fn trace_memory(&self, job: &TraceJob<'_>) -> Result<Vec<MemoryEntry>, TracerError> {
        Ok(search::trace_memory(&self.resident, job))
    }

    fn validate(&self, _geometry: &Geometry) -> Result<Vec<(&'static str, f64)>, TracerError> {
        let (tree, ordered) = self.resident.read(&self.searches.gpu)?;
        tree.check(&ordered, self.triangle_count, self.fitted.is_some())?;
        self.resident.statistics(&tree, ordered.len())
    }
}
