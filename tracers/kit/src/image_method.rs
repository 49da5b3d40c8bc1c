//! Methods that march over the depths of one view: their structure and its searches.

use std::marker::PhantomData;
use std::sync::Arc;

use bytemuck::NoUninit;
use tracebench_api::{
    Counter, Geometry, Gpu, HitBuffer, MemoryEntry, MemoryReport, Parameters, SampledImage, TraceJob, TraceTo,
    TracerError, View,
};
use tracebench_shaders::Shader;

use crate::{
    BuildJob, DevicePipelines, DeviceStructure, ImagePipelines, ImageSearch, ImageShape, PipelinesOnDemand,
    RasterizedView, RayCounts, Search, SearchJob, TouchedBits, untimed,
};

/// What a method has of its own.
pub trait ImageMethod: 'static {
    /// Its shader's variants.
    type Variant: Into<Shader>;
    /// What a search is told.
    type Settings: NoUninit;

    /// Why there is no refit.
    const NO_REFIT: &'static str;
    /// The name of a search's phase.
    const PHASE: &'static str;

    /// What is drawn of a view.
    ///
    /// # Errors
    /// [`TracerError::Parameter`] for other parameters than the method's.
    fn shape(view: &View, parameters: &Parameters) -> Result<ImageShape, TracerError>;

    /// The variant that ends at surfaces or hits, and counts or does not.
    fn variant(drawn: &RasterizedView, surfaces: bool, counters: bool) -> Self::Variant;

    /// What a search is told, and the rays that a lane of it answers.
    ///
    /// # Errors
    /// As [`ImageMethod::shape`].
    fn settings(drawn: &RasterizedView, job: &TraceJob<'_>) -> Result<(Self::Settings, u32), TracerError>;

    /// The names of the numbers that are counted of every ray, in the order in which the shader has them.
    fn counters(drawn: &RasterizedView) -> &'static [&'static str];

    /// The name and number of things that each have a bit where a search counts.
    fn touched(drawn: &RasterizedView) -> (&'static str, u64);

    /// As [`Structure::samplings`](tracebench_api::Structure::samplings).
    ///
    /// # Errors
    /// As [`ImageMethod::shape`].
    fn samplings(drawn: &RasterizedView, parameters: &Parameters) -> Result<Vec<SampledImage>, TracerError>;

    /// What [`Structure::validate`](tracebench_api::Structure::validate) tells of images of which so many pixels are covered.
    fn statistics(drawn: &RasterizedView, covered: &[usize]) -> Vec<(&'static str, f64)>;
}

/// The pipelines of a method.
pub struct ImageMethodPipelines {
    gpu: Arc<Gpu>,
    images: ImagePipelines,
    trace: PipelinesOnDemand,
}

impl DevicePipelines for ImageMethodPipelines {
    fn new(gpu: Arc<Gpu>) -> Result<Self, TracerError> {
        Ok(Self { images: ImagePipelines::new(&gpu)?, trace: PipelinesOnDemand::new("trace"), gpu })
    }
}

/// The images of one view.
pub struct ImageStructure<M: ImageMethod> {
    pipelines: Arc<ImageMethodPipelines>,
    drawn: RasterizedView,
    method: PhantomData<M>,
}

impl<M: ImageMethod> DeviceStructure for ImageStructure<M> {
    type Pipelines = ImageMethodPipelines;

    const NO_REFIT: &'static str = M::NO_REFIT;

    fn build(pipelines: &Arc<Self::Pipelines>, job: BuildJob<'_, '_, Self>) -> Result<Self, TracerError> {
        let BuildJob { geometry, viewpoint, parameters, before, clock } = job;
        let view = viewpoint.frame_view();
        let shape = M::shape(&view, parameters)?;
        let before = before.map(|before| &before.drawn);
        let drawn = RasterizedView::draw(&pipelines.images, shape, geometry, view, before, clock)?;
        Ok(Self { pipelines: Arc::clone(pipelines), drawn, method: PhantomData })
    }

    fn memory(&self) -> MemoryReport {
        self.drawn.memory()
    }

    fn trace_memory(&self, job: &TraceJob<'_>) -> Result<Vec<MemoryEntry>, TracerError> {
        Ok(self.drawn.trace_memory(size_of::<M::Settings>(), job))
    }

    fn samplings(&self, parameters: &Parameters) -> Result<Vec<SampledImage>, TracerError> {
        M::samplings(&self.drawn, parameters)
    }

    fn validate(&self, _geometry: &Geometry) -> Result<Vec<(&'static str, f64)>, TracerError> {
        Ok(M::statistics(&self.drawn, &self.drawn.validate(&self.pipelines.gpu)?))
    }
}

impl<M: ImageMethod> Search for ImageStructure<M> {
    type Counting = (RayCounts, TouchedBits);

    fn record(&self, search: SearchJob<'_, '_, Self::Counting>) -> Result<(), TracerError> {
        let SearchJob { job, hits, counting, clock } = search;
        // Any hit is the same search: its first hit is its nearest.
        let ImageMethodPipelines { gpu, images, trace } = &*self.pipelines;
        let variant = M::variant(&self.drawn, job.trace_to == TraceTo::Surface, counting.is_some());
        let (settings, rays_per_lane) = M::settings(&self.drawn, job)?;
        let counting = counting.map(|(counts, touched)| [counts.buffer(), touched.buffer()]);
        let pipeline = trace.of(gpu, variant)?;
        let search = ImageSearch { name: M::PHASE, pipeline, settings, rays_per_lane, counting };
        self.drawn.trace(images, search, job, hits, clock)
    }

    fn count(&self, job: &TraceJob<'_>, hits: &HitBuffer) -> Result<Vec<Counter>, TracerError> {
        let gpu = &self.pipelines.gpu;
        let (name, things) = M::touched(&self.drawn);
        let counts = RayCounts::new(gpu, M::counters(&self.drawn), job.rays.host.len())?;
        let counting = (counts, TouchedBits::new(gpu, name, things, "--frame-size")?);
        untimed(gpu, |clock| self.record(SearchJob { job, hits, counting: Some(&counting), clock }))?;
        let mut counters = counting.0.counters(gpu)?;
        counters.push(Counter::of_set(name, counting.1.count(gpu)?));
        Ok(counters)
    }
}
