//! What tracers on the device have alike: pipelines that are made once, structures that are rebuilt in the memory of the ones before, and
//! searches with a variant that counts.

use std::ops::{Deref, DerefMut};
use std::sync::Arc;

use tracebench_api::{
    Counter, Geometry, Gpu, HitBuffer, MemoryEntry, MemoryReport, Parameters, PhaseClock, SampledImage, Structure,
    TraceJob, Tracer, TracerError, Update, Viewpoint, VoxelGrid,
};

/// What a build is given.
pub struct BuildJob<'a, 'c, S> {
    /// The scene.
    pub geometry: &'a Geometry,
    /// Where it is seen from.
    pub viewpoint: &'a Viewpoint,
    /// The tracer's parameters.
    pub parameters: &'a Parameters,
    /// The structure before, if there is one; it has the same parameters.
    pub before: Option<&'a S>,
    /// Where phases are marked.
    pub clock: &'a mut PhaseClock<'c>,
}

/// What a search is given.
pub struct SearchJob<'a, 'c, Counting> {
    /// What is traced.
    pub job: &'a TraceJob<'a>,
    /// Where answers go.
    pub hits: &'a HitBuffer,
    /// What a variant that counts writes to; none where nothing is counted.
    pub counting: Option<&'a Counting>,
    /// Where phases are marked.
    pub clock: &'a mut PhaseClock<'c>,
}

/// How a structure is searched.
pub trait Search {
    /// What a variant that counts writes to.
    type Counting;

    /// Records a trace, by the variant that counts where there is something to count into.
    ///
    /// # Errors
    /// As [`Structure::trace`].
    fn record(&self, search: SearchJob<'_, '_, Self::Counting>) -> Result<(), TracerError>;

    /// As [`Structure::trace_counted`].
    ///
    /// # Errors
    /// As [`Structure::trace_counted`].
    fn count(&self, job: &TraceJob<'_>, hits: &HitBuffer) -> Result<Vec<Counter>, TracerError>;
}

/// What is made once for all structures of a tracer.
pub trait DevicePipelines: Sized {
    /// Makes the pipelines, or those that every structure needs.
    ///
    /// # Errors
    /// [`TracerError::Unavailable`] if the device forbids it, [`TracerError::Failed`] if it refuses one.
    fn new(gpu: Arc<Gpu>) -> Result<Self, TracerError>;
}

/// A structure on the device that is built anew in the memory of the one before. What is not told here is as in [`Structure`].
pub trait DeviceStructure: Search + Sized + 'static {
    /// What is made once for all structures of a tracer.
    type Pipelines: DevicePipelines;

    /// Why there is no refit, where there is none.
    const NO_REFIT: &'static str = "";

    /// Builds, in the memory of the structure before where there is one and its memory serves.
    ///
    /// # Errors
    /// As [`Tracer::build`].
    fn build(pipelines: &Arc<Self::Pipelines>, job: BuildJob<'_, '_, Self>) -> Result<Self, TracerError>;

    /// Fits the structure to moved vertices of the same triangles.
    ///
    /// # Errors
    /// [`TracerError::Unsupported`] without a shape that could be kept; others as [`Structure::update`].
    fn refit(&mut self, _geometry: &Geometry, _clock: &mut PhaseClock<'_>) -> Result<(), TracerError> {
        Err(TracerError::Unsupported(Self::NO_REFIT.to_owned()))
    }

    /// As [`Structure::grow_on_overflow`].
    ///
    /// # Errors
    /// As [`Structure::grow_on_overflow`].
    fn grow_on_overflow(&mut self) -> Result<bool, TracerError> {
        Ok(false)
    }

    /// As [`Structure::memory`].
    fn memory(&self) -> MemoryReport;

    /// As [`Structure::trace_memory`].
    ///
    /// # Errors
    /// As [`Structure::trace_memory`].
    fn trace_memory(&self, job: &TraceJob<'_>) -> Result<Vec<MemoryEntry>, TracerError>;

    /// As [`Structure::samplings`].
    ///
    /// # Errors
    /// As [`Structure::samplings`].
    fn samplings(&self, _parameters: &Parameters) -> Result<Vec<SampledImage>, TracerError> {
        Ok(Vec::new())
    }

    /// As [`Structure::voxels`].
    ///
    /// # Errors
    /// As [`Structure::voxels`].
    fn voxels(&self, _parameters: &Parameters) -> Result<Option<VoxelGrid>, TracerError> {
        Ok(None)
    }

    /// As [`Structure::validate`].
    ///
    /// # Errors
    /// As [`Structure::validate`].
    fn validate(&self, geometry: &Geometry) -> Result<Vec<(&'static str, f64)>, TracerError>;
}

/// A structure with the pipelines that it was built by.
pub struct Built<S: DeviceStructure> {
    pipelines: Arc<S::Pipelines>,
    structure: S,
}

impl<S: DeviceStructure> Built<S> {
    /// As [`Tracer::build`].
    ///
    /// # Errors
    /// As [`Tracer::build`].
    pub fn new(pipelines: &Arc<S::Pipelines>, job: BuildJob<'_, '_, S>) -> Result<Self, TracerError> {
        Ok(Self { structure: S::build(pipelines, job)?, pipelines: Arc::clone(pipelines) })
    }
}

impl<S: DeviceStructure> Deref for Built<S> {
    type Target = S;

    fn deref(&self) -> &S {
        &self.structure
    }
}

impl<S: DeviceStructure> DerefMut for Built<S> {
    fn deref_mut(&mut self) -> &mut S {
        &mut self.structure
    }
}

impl<S: DeviceStructure> Structure for Built<S> {
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
                let before = Some(&self.structure);
                self.structure =
                    S::build(&self.pipelines, BuildJob { geometry, viewpoint, parameters, before, clock })?;
            }
            Update::Refit => self.structure.refit(geometry, clock)?,
            Update::Reuse => {}
        }
        Ok(())
    }

    fn grow_on_overflow(&mut self) -> Result<bool, TracerError> {
        self.structure.grow_on_overflow()
    }

    fn trace(&self, job: TraceJob<'_>, hits: &mut HitBuffer, clock: &mut PhaseClock<'_>) -> Result<(), TracerError> {
        self.structure.record(SearchJob { job: &job, hits, counting: None, clock })
    }

    fn trace_counted(&self, job: TraceJob<'_>, hits: &mut HitBuffer) -> Result<Vec<Counter>, TracerError> {
        self.structure.count(&job, hits)
    }

    fn memory(&self) -> MemoryReport {
        self.structure.memory()
    }

    fn trace_memory(&self, job: TraceJob<'_>) -> Result<Vec<MemoryEntry>, TracerError> {
        self.structure.trace_memory(&job)
    }

    fn samplings(&self, parameters: &Parameters) -> Result<Vec<SampledImage>, TracerError> {
        self.structure.samplings(parameters)
    }

    fn voxels(&self, parameters: &Parameters) -> Result<Option<VoxelGrid>, TracerError> {
        self.structure.voxels(parameters)
    }

    fn validate(&self, geometry: &Geometry) -> Result<Vec<(&'static str, f64)>, TracerError> {
        self.structure.validate(geometry)
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
    /// As [`DevicePipelines::new`].
    pub fn new(gpu: Arc<Gpu>) -> Result<Self, TracerError> {
        Ok(Self { pipelines: Arc::new(S::Pipelines::new(gpu)?) })
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
    ) -> Result<Built<S>, TracerError> {
        Built::new(&self.pipelines, BuildJob { geometry, viewpoint, parameters, before: None, clock })
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
