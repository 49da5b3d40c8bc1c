//! The structure of one scene from one viewpoint.

use std::sync::Arc;

use tracebench_api::{
    Counter, Geometry, Gpu, HitBuffer, Layers, Ledger, MemoryEntry, MemoryReport, Parameters, PhaseClock, Projection,
    Sampling, Structure, TraceJob, Tracer, TracerError, Update, Viewpoint,
};

use crate::build::{Pipelines, build_bytes};
use crate::description::{NO_REFIT, QuadtreeParameters};
use crate::images::Images;
use crate::layout::Shape;

/// The tracer.
pub struct Quadtree {
    pipelines: Arc<Pipelines>,
}

/// The quad-trees of all layers of all views.
pub(crate) struct QuadtreeStructure {
    pub pipelines: Arc<Pipelines>,
    pub shape: Shape,
    pub images: Images,
    triangle_count: u32,
}

impl Quadtree {
    /// Creates the pipelines.
    ///
    /// # Errors
    /// [`TracerError::Failed`] if the device refuses one.
    pub fn new(gpu: Arc<Gpu>) -> Result<Self, TracerError> {
        Ok(Self { pipelines: Arc::new(Pipelines::new(gpu)?) })
    }

    pub(crate) fn build_structure(
        &self,
        geometry: &Geometry,
        viewpoint: &Viewpoint,
        parameters: &Parameters,
        clock: &mut PhaseClock<'_>,
    ) -> Result<QuadtreeStructure, TracerError> {
        let parameters = QuadtreeParameters::try_from(parameters)?;
        let shape = Shape::new(viewpoint, geometry.diagonal(), &parameters)?;
        let images = Images::new(&self.pipelines.gpu, &shape, parameters.reads, None)?;
        self.pipelines.fill(&shape, &images, geometry, clock)?;
        let triangle_count = geometry.triangles.len() as u32;
        Ok(QuadtreeStructure { pipelines: Arc::clone(&self.pipelines), shape, images, triangle_count })
    }
}

impl Tracer for Quadtree {
    fn build(
        &self,
        geometry: &Geometry,
        viewpoint: &Viewpoint,
        parameters: &Parameters,
        clock: &mut PhaseClock<'_>,
    ) -> Result<Box<dyn Structure>, TracerError> {
        Ok(Box::new(self.build_structure(geometry, viewpoint, parameters, clock)?))
    }
}

impl Structure for QuadtreeStructure {
    fn update(
        &mut self,
        update: Update,
        geometry: &Geometry,
        viewpoint: &Viewpoint,
        parameters: &Parameters,
        clock: &mut PhaseClock<'_>,
    ) -> Result<(), TracerError> {
        match update {
            Update::Rebuild => {
                let parameters = QuadtreeParameters::try_from(parameters)?;
                let shape = Shape::new(viewpoint, geometry.diagonal(), &parameters)?;
                // Images of the same size are drawn into what is there.
                let sizes = |shape: &Shape| (shape.size(), shape.images(), shape.thins(), shape.drawn_by);
                if sizes(&shape) == sizes(&self.shape) {
                    self.pipelines.fill(&shape, &self.images, geometry, clock)?;
                } else {
                    let gpu = &self.pipelines.gpu;
                    let images = Images::new(gpu, &shape, parameters.reads, Some(&self.images))?;
                    self.pipelines.fill(&shape, &images, geometry, clock)?;
                    self.images = images;
                }
                (self.shape, self.triangle_count) = (shape, geometry.triangles.len() as u32);
                Ok(())
            }
            Update::Refit => Err(TracerError::Unsupported(NO_REFIT.to_owned())),
            Update::Reuse => Ok(()),
        }
    }

    fn trace(&self, job: TraceJob<'_>, hits: &mut HitBuffer, clock: &mut PhaseClock<'_>) -> Result<(), TracerError> {
        self.record(&job, hits, None, clock)
    }

    fn trace_counted(&self, job: TraceJob<'_>, hits: &mut HitBuffer) -> Result<Vec<Counter>, TracerError> {
        self.count(&job, hits)
    }

    fn memory(&self) -> MemoryReport {
        let mut ledger = Ledger::new();
        self.images.enter(&mut ledger);
        ledger.borrow_transient(build_bytes(&self.shape, self.triangle_count));
        // Layers have all that hits and surfaces need.
        ledger.report(0)
    }

    fn trace_memory(&self, job: TraceJob<'_>) -> Result<Vec<MemoryEntry>, TracerError> {
        self.memory_of_trace(&job)
    }

    fn samplings(&self, _parameters: &Parameters) -> Result<Vec<Sampling>, TracerError> {
        let layers = Layers::of(self.shape.layers, self.shape.separation, !self.shape.culls);
        let of = |view: &tracebench_api::View| Sampling::new(Projection::Perspective(*view), layers);
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
