//! What tracers on the device have alike: pipelines that are made once, and structures that are rebuilt in the memory of the ones before.

use std::sync::Arc;

use tracebench_api::{Geometry, Gpu, Parameters, PhaseClock, Structure, Tracer, TracerError, Update, Viewpoint};

/// What a build is given.
#[derive(Clone, Copy)]
pub struct BuildJob<'a> {
    /// The scene.
    pub geometry: &'a Geometry,
    /// Where it is seen from.
    pub viewpoint: &'a Viewpoint,
    /// The tracer's parameters.
    pub parameters: &'a Parameters,
}

/// A structure on the device that is built anew in the memory of the one before, and has no shape that could be fitted to moved vertices.
pub trait DeviceStructure: Structure + Sized + 'static {
    /// What is made once for all structures of a tracer.
    type Pipelines;

    /// Why there is no refit.
    const NO_REFIT: &'static str;

    /// Makes the pipelines, or those that every structure needs.
    ///
    /// # Errors
    /// [`TracerError::Unavailable`] if the device's limits forbid it, [`TracerError::Failed`] if it refuses one.
    fn pipelines(gpu: Arc<Gpu>) -> Result<Self::Pipelines, TracerError>;

    /// Builds, in the memory of the structure before, which has the same parameters, where there is one and its memory serves.
    ///
    /// # Errors
    /// As [`Tracer::build`].
    fn build(
        pipelines: &Arc<Self::Pipelines>,
        job: BuildJob<'_>,
        before: Option<&Self>,
        clock: &mut PhaseClock<'_>,
    ) -> Result<Self, TracerError>;

    /// As [`Structure::update`], by the pipelines that the structure was built by.
    ///
    /// # Errors
    /// As [`Structure::update`].
    fn follow(
        &mut self,
        pipelines: &Arc<Self::Pipelines>,
        update: Update,
        job: BuildJob<'_>,
        clock: &mut PhaseClock<'_>,
    ) -> Result<(), TracerError> {
        match update {
            Update::Rebuild => *self = Self::build(pipelines, job, Some(self), clock)?,
            Update::Refit => return Err(TracerError::Unsupported(Self::NO_REFIT.to_owned())),
            Update::Reuse => {}
        }
        Ok(())
    }
}

/// The tracer of a method with one kind of structure.
pub struct DeviceTracer<S: DeviceStructure> {
    pipelines: Arc<S::Pipelines>,
}

impl<S: DeviceStructure> DeviceTracer<S> {
    /// Makes the pipelines, or those that every structure needs.
    ///
    /// # Errors
    /// As [`DeviceStructure::pipelines`].
    pub fn new(gpu: Arc<Gpu>) -> Result<Self, TracerError> {
        Ok(Self { pipelines: Arc::new(S::pipelines(gpu)?) })
    }

    /// As [`Tracer::build`].
    ///
    /// # Errors
    /// As [`Tracer::build`].
    pub fn build_structure(
        &self,
        geometry: &Geometry,
        viewpoint: &Viewpoint,
        parameters: &Parameters,
        clock: &mut PhaseClock<'_>,
    ) -> Result<S, TracerError> {
        S::build(&self.pipelines, BuildJob { geometry, viewpoint, parameters }, None, clock)
    }
}

impl<S: DeviceStructure> Tracer for DeviceTracer<S> {
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
