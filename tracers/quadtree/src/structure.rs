//! The structure of one scene from one viewpoint.

use std::sync::Arc;

use tracebench_api::{
    Geometry, Gpu, Layers, Ledger, MemoryEntry, MemoryReport, Parameters, Projection, SampledImage, TraceJob,
    TracerError,
};
use tracebench_kit::{BuildJob, DeviceStructure, DeviceTracer};

use crate::build::{Pipelines, build_bytes};
use crate::description::{NO_REFIT, QuadtreeParameters};
use crate::images::Images;
use crate::layout::Shape;

/// The tracer.
pub type Quadtree = DeviceTracer<QuadtreeStructure>;

/// The quad-trees of all layers of all views.
pub struct QuadtreeStructure {
    pub(crate) pipelines: Arc<Pipelines>,
    pub(crate) shape: Shape,
    pub(crate) images: Images,
    triangle_count: u32,
}

impl DeviceStructure for QuadtreeStructure {
    type Pipelines = Pipelines;

    const NO_REFIT: &'static str = NO_REFIT;

    fn build(pipelines: &Arc<Pipelines>, job: BuildJob<'_, '_, Self>) -> Result<Self, TracerError> {
        let BuildJob { geometry, viewpoint, parameters, before, clock } = job;
        let parameters = QuadtreeParameters::try_from(parameters)?;
        let shape = Shape::new(viewpoint, geometry.diagonal(), &parameters)?;
        // Images of the same size are drawn into what is there.
        let sizes = |shape: &Shape| (shape.size(), shape.images(), shape.thins(), shape.raster_backend);
        let images = match before {
            Some(before) if sizes(&shape) == sizes(&before.shape) => before.images.clone(),
            _ => Images::new(&pipelines.gpu, &shape, parameters.memory_access, before.map(|before| &before.images))?,
        };
        pipelines.fill(&shape, &images, geometry, clock)?;
        let triangle_count = geometry.triangles.len() as u32;
        Ok(Self { pipelines: Arc::clone(pipelines), shape, images, triangle_count })
    }

    fn memory(&self) -> MemoryReport {
        let mut ledger = Ledger::new();
        self.images.enter(&mut ledger);
        ledger.borrow_transient(build_bytes(&self.shape, self.triangle_count));
        // Layers have all that hits and surfaces need.
        ledger.report(0)
    }

    fn trace_memory(&self, job: &TraceJob<'_>) -> Result<Vec<MemoryEntry>, TracerError> {
        self.memory_of_trace(job)
    }

    fn samplings(&self, _parameters: &Parameters) -> Result<Vec<SampledImage>, TracerError> {
        let layers = Layers::of(self.shape.layers, self.shape.separation, !self.shape.culls);
        let of = |view: &tracebench_api::View| SampledImage::new(Projection::Perspective(*view), layers);
        Ok(self.shape.views.iter().map(of).collect())
    }

    fn validate(&self, geometry: &Geometry) -> Result<Vec<(&'static str, f64)>, TracerError> {
        self.check(geometry)
    }
}

impl QuadtreeStructure {
    pub(crate) fn gpu(&self) -> &Gpu {
        &self.pipelines.gpu
    }
}
