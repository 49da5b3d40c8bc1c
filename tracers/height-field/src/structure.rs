//! The tracer and its structure.

use std::sync::Arc;

use tracebench_api::{
    Counter, Geometry, Gpu, HitBuffer, ImageMarch, Layers, MarchSteps, MemoryEntry, MemoryReport, Parameters,
    PhaseClock, Projection, Sampling, Structure, TraceJob, TracerError, Update, Viewpoint,
};
use tracebench_kit::{
    BuildJob, CellDepths, DeviceStructure, DeviceTracer, DrawnView, ImagePipelines, ImageShape, PipelinesOnDemand,
};
use tracebench_shaders::height_field::Trace;

use crate::description::{HeightParameters, NO_REFIT, Pyramid};
use crate::trace::HeightSettings;

/// The pipelines.
pub struct Pipelines {
    pub(crate) gpu: Arc<Gpu>,
    pub(crate) images: ImagePipelines,
    pub(crate) trace: PipelinesOnDemand<Trace>,
}

/// The tracer.
pub type HeightField = DeviceTracer<HeightFieldStructure>;

/// The depth buffer of one view with its pyramid.
pub struct HeightFieldStructure {
    pub(crate) pipelines: Arc<Pipelines>,
    pub(crate) drawn: DrawnView,
}

impl DeviceStructure for HeightFieldStructure {
    type Pipelines = Pipelines;

    const NO_REFIT: &'static str = NO_REFIT;

    fn pipelines(gpu: Arc<Gpu>) -> Result<Pipelines, TracerError> {
        Ok(Pipelines { images: ImagePipelines::new(&gpu)?, trace: PipelinesOnDemand::new("trace"), gpu })
    }

    fn build(
        pipelines: &Arc<Pipelines>,
        BuildJob { geometry, viewpoint, parameters }: BuildJob<'_>,
        before: Option<&Self>,
        clock: &mut PhaseClock<'_>,
    ) -> Result<Self, TracerError> {
        let HeightParameters { pyramid, reads, build: drawn_by, .. } = HeightParameters::try_from(parameters)?;
        let pyramid = Some(match pyramid {
            Pyramid::MinMax => CellDepths::NearFar,
            Pyramid::Max => CellDepths::Near,
        });
        let view = viewpoint.frame_view();
        let shape = ImageShape { size: view.size, layers: 1, backs: false, separation: 0.0, pyramid, reads, drawn_by };
        let before = before.map(|before| &before.drawn);
        let drawn = DrawnView::draw(&pipelines.images, shape, geometry, view, before, clock)?;
        Ok(Self { pipelines: Arc::clone(pipelines), drawn })
    }
}

impl Structure for HeightFieldStructure {
    fn update(
        &mut self,
        update: Update,
        geometry: &Geometry,
        viewpoint: &Viewpoint,
        parameters: &Parameters,
        clock: &mut PhaseClock<'_>,
    ) -> Result<(), TracerError> {
        let job = BuildJob { geometry, viewpoint, parameters };
        self.follow(&Arc::clone(&self.pipelines), update, job, clock)
    }

    fn trace(&self, job: TraceJob<'_>, hits: &mut HitBuffer, clock: &mut PhaseClock<'_>) -> Result<(), TracerError> {
        // Any hit is the same search: its first hit is its nearest.
        self.record(&job, hits, None, clock)
    }

    fn trace_counted(&self, job: TraceJob<'_>, hits: &mut HitBuffer) -> Result<Vec<Counter>, TracerError> {
        self.count(&job, hits)
    }

    fn memory(&self) -> MemoryReport {
        self.drawn.memory()
    }

    fn trace_memory(&self, job: TraceJob<'_>) -> Result<Vec<MemoryEntry>, TracerError> {
        Ok(self.drawn.trace_memory(size_of::<HeightSettings>(), &job))
    }

    fn samplings(&self, parameters: &Parameters) -> Result<Vec<Sampling>, TracerError> {
        let HeightParameters { start_bias, refinement, .. } = HeightParameters::try_from(parameters)?;
        let march = Some(ImageMarch {
            steps: MarchSteps::EveryPixel,
            start_bias,
            // All behind a sample is solid.
            thickness: f64::INFINITY,
            thickness_in_pixels: 0.0,
            to_back_faces: false,
            // Few halvings leave it open where in its pixel a hit is.
            anywhere: refinement < 16,
        });
        Ok(vec![Sampling { march, ..Sampling::new(Projection::Perspective(self.drawn.view), Layers::Nearest) }])
    }

    fn validate(&self, _geometry: &Geometry) -> Result<Vec<(&'static str, f64)>, TracerError> {
        let covered = self.drawn.validate(&self.pipelines.gpu)?;
        let pixels: u64 = self.drawn.view.size.map(u64::from).iter().product();
        let statistics = [("pixels", pixels), ("covered_pixels", covered[0] as u64), ("cells", self.cells())];
        Ok(statistics.map(|(name, count)| (name, count as f64)).to_vec())
    }
}
