//! The tracer and its structure.

use std::sync::Arc;

use tracebench_api::{
    Counter, Geometry, Gpu, HitBuffer, ImageMarch, Layers, MarchSteps, MemoryEntry, MemoryReport, Parameters,
    PhaseClock, Projection, Sampling, Structure, TraceJob, TracerError, Update, Viewpoint,
};
use tracebench_kit::{
    BuildJob, CellDepths, DeviceStructure, DeviceTracer, DrawnView, ImagePipelines, ImageShape, Images,
    PipelinesOnDemand,
};
use tracebench_shaders::screen_dda::Trace;

use crate::description::{DdaParameters, HitPoint, March, NO_REFIT, ThicknessFrom};
use crate::trace::Settings;

/// The pipelines.
pub struct Pipelines {
    pub(crate) gpu: Arc<Gpu>,
    pub(crate) images: ImagePipelines,
    pub(crate) trace: PipelinesOnDemand<Trace>,
}

/// The tracer.
pub type ScreenDda = DeviceTracer<ScreenDdaStructure>;

/// The depth layers of one view.
pub struct ScreenDdaStructure {
    pub(crate) pipelines: Arc<Pipelines>,
    pub(crate) drawn: DrawnView,
}

impl DeviceStructure for ScreenDdaStructure {
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
        let (parameters, view) = (DdaParameters::try_from(parameters)?, viewpoint.frame_view());
        let shape = ImageShape {
            size: view.size,
            layers: parameters.layers,
            backs: parameters.thickness_from == ThicknessFrom::BackFaces,
            separation: parameters.layer_separation,
            pyramid: (parameters.march == March::HiZ).then_some(CellDepths::NearFar),
            reads: parameters.reads,
            drawn_by: parameters.build,
        };
        let before = before.map(|before| &before.drawn);
        let drawn = DrawnView::draw(&pipelines.images, shape, geometry, view, before, clock)?;
        Ok(Self { pipelines: Arc::clone(pipelines), drawn })
    }
}

impl Structure for ScreenDdaStructure {
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
        // Any hit is the same walk: its first hit is its nearest.
        self.record(&job, hits, None, clock)
    }

    fn trace_counted(&self, job: TraceJob<'_>, hits: &mut HitBuffer) -> Result<Vec<Counter>, TracerError> {
        self.count(&job, hits)
    }

    fn memory(&self) -> MemoryReport {
        self.drawn.memory()
    }

    fn trace_memory(&self, job: TraceJob<'_>) -> Result<Vec<MemoryEntry>, TracerError> {
        Ok(self.drawn.trace_memory(size_of::<Settings>(), &job))
    }

    fn samplings(&self, parameters: &Parameters) -> Result<Vec<Sampling>, TracerError> {
        let DdaParameters { stride, thickness, start_bias, hit_point, .. } = DdaParameters::try_from(parameters)?;
        let DrawnView { view, images, diagonal, .. } = &self.drawn;
        let shape = &images.shape;
        let march = Some(ImageMarch {
            steps: MarchSteps::Stride(f64::from(stride)),
            start_bias,
            thickness: thickness * diagonal,
            thickness_in_pixels: 0.0,
            to_back_faces: shape.backs,
            anywhere: hit_point == HitPoint::Step,
        });
        let layers = Layers::of(shape.layers, shape.separation * diagonal, true);
        Ok(vec![Sampling { march, ..Sampling::new(Projection::Perspective(*view), layers) }])
    }

    fn validate(&self, _geometry: &Geometry) -> Result<Vec<(&'static str, f64)>, TracerError> {
        let covered = self.drawn.validate(&self.pipelines.gpu)?;
        let Images { shape, pyramid, .. } = &self.drawn.images;
        let layers = shape.layers as usize;
        let pixels: u64 = shape.size.map(u64::from).iter().product();
        let mut told = vec![("pixels", pixels as f64), ("covered_pixels", covered[0] as f64)];
        let deeper = ["covered_pixels_of_layer_2", "covered_pixels_of_layer_3", "covered_pixels_of_layer_4"];
        told.extend(deeper.into_iter().zip(&covered[1..layers]).map(|(name, count)| (name, *count as f64)));
        if shape.backs {
            told.push(("pixels_with_back_faces", covered[layers] as f64));
        }
        if let Some(pyramid) = pyramid {
            told.push(("pyramid_cells", pyramid.shape().cells() as f64));
        }
        Ok(told)
    }
}
