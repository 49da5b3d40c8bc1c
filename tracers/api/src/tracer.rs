//! What a contender implements.

use serde::Serialize;

use crate::{
    Geometry, HitBuffer, MemoryEntry, MemoryReport, ParameterDescription, Parameters, PhaseClock, Query, RayBuffer,
    SampledImage, TraceTo, TracerError, Viewpoint, VoxelGrid, named,
};

/// Where a tracer's triangles, rays and hits live.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Residency {
    /// Host memory; runs without an adapter.
    Host,
    /// Device memory.
    Device,
}

/// A change after which a structure must be built anew.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Invalidation {
    /// The triangles moved or changed.
    Geometry,
    /// The eye moved or turned.
    Viewpoint,
    /// The frame's or the faces' resolution changed.
    Resolution,
}

/// A tracer as data.
#[derive(Clone, Debug, Serialize)]
pub struct TracerDescription {
    /// Stable name.
    pub name: &'static str,
    /// The work that describes the method.
    pub citation: &'static str,
    /// What it is, in one line.
    pub summary: &'static str,
    /// Where it runs.
    pub residency: Residency,
    /// What invalidates a structure.
    pub invalidated_by: &'static [Invalidation],
    /// Whether its hits name the triangle.
    pub names_primitives: bool,
    /// The ends that it traces to.
    pub ends: &'static [TraceTo],
    /// The queries that it answers.
    pub queries: &'static [Query],
    /// Why its structures cannot be fitted to moved vertices ([`Update::Refit`]); none where they can.
    pub no_refit: Option<&'static str>,
    /// Its parameters.
    pub parameters: Vec<ParameterDescription>,
}

impl TracerDescription {
    /// What most on the device have in common: hits name triangles, every query is answered to either end, structures hang on the
    /// geometry alone and can be refitted. Name, citation and summary are to be filled in.
    pub fn on_device(parameters: Vec<ParameterDescription>) -> Self {
        Self {
            name: "",
            citation: "",
            summary: "",
            residency: Residency::Device,
            invalidated_by: &[Invalidation::Geometry],
            names_primitives: true,
            ends: &TraceTo::ALL,
            queries: &Query::ALL,
            no_refit: None,
            parameters,
        }
    }

    /// What those on the device that hold images of views have in common: hits name no triangle, structures hang on the view and its
    /// resolution, too, and are not refitted, for a reason. Name, citation and summary are to be filled in.
    pub fn of_views(no_refit: &'static str, parameters: Vec<ParameterDescription>) -> Self {
        Self {
            invalidated_by: &[Invalidation::Geometry, Invalidation::Viewpoint, Invalidation::Resolution],
            names_primitives: false,
            no_refit: Some(no_refit),
            ..Self::on_device(parameters)
        }
    }

    /// That a structure follows changes in a way: what [`Structure::update`] says of the way itself, before there is one.
    ///
    /// # Errors
    /// [`TracerError::Unsupported`] for a refit where the method has none.
    pub fn serves(&self, update: Update) -> Result<(), TracerError> {
        match (update, self.no_refit) {
            (Update::Refit, Some(reason)) => Err(TracerError::Unsupported(reason.to_owned())),
            (Update::Rebuild | Update::Refit | Update::Reuse, _) => Ok(()),
        }
    }
}

/// One trace of one ray set.
#[derive(Clone, Copy)]
pub struct TraceJob<'a> {
    /// The rays, with the query.
    pub rays: &'a RayBuffer,
    /// How far to go.
    pub trace_to: TraceTo,
    /// The tracer's parameters; those of the build scope are the ones that the structure was built with.
    pub parameters: &'a Parameters,
}

/// A count over a ray set.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Counter {
    /// What was counted, in plural ("nodes_visited").
    pub name: &'static str,
    /// Over all rays.
    pub total: u64,
    /// The largest of any one ray; none for what is counted of the set as a whole.
    pub max_per_ray: Option<u64>,
}

impl Counter {
    /// Sums up counts of single rays.
    pub fn of(name: &'static str, per_ray: impl IntoIterator<Item = u64>) -> Self {
        let (total, greatest) =
            per_ray.into_iter().fold((0, 0), |(total, most), count| (total + count, u64::max(most, count)));
        Self { name, total, max_per_ray: Some(greatest) }
    }

    /// A count of the set as a whole, such as what of the structure any ray touched.
    pub fn of_set(name: &'static str, total: u64) -> Self {
        Self { name, total, max_per_ray: None }
    }
}

/// A method with its pipelines created. Several structures may be built from one tracer and live side by side.
pub trait Tracer {
    /// Builds the structure, from triangles resident (in host or device memory, as the description says) to
    /// traceable. Pipelines exist before; the work in scope is marked on the clock and is complete only when the clock
    /// has been finished. The whole call is timed, too. Nothing that earlier builds have found of a scene is used: what a
    /// structure needs is counted every time, and what it has room for is its own.
    ///
    /// # Errors
    /// [`TracerError`] as its variants say; nothing is dropped in silence.
    fn build(
        &self,
        geometry: &Geometry,
        viewpoint: &Viewpoint,
        parameters: &Parameters,
        clock: &mut PhaseClock<'_>,
    ) -> Result<Box<dyn Structure>, TracerError>;
}

named! {
    /// How a structure follows a scene that moved or an eye that did.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
    #[serde(rename_all = "snake_case")]
    pub enum Update {
        /// Built anew, in the memory that it has where that serves: the hits are those of a fresh build.
        Rebuild = "rebuild",
        /// Its shape kept and fitted to moved vertices of the same triangles: the hits are right, if slower to find.
        Refit = "refit",
        /// Kept as it is. Where the change invalidates it ([`TracerDescription::invalidated_by`]) its hits are those of before:
        /// stale.
        Reuse = "reuse",
    }
}

/// What a tracer built for one scene and one viewpoint.
pub trait Structure {
    /// Follows a change of geometry, viewpoint or both. The same scope as [`Tracer::build`]: from triangles resident to
    /// traceable, complete only when the clock has been finished. `parameters` are those of the build. After an error the
    /// structure is as it was.
    ///
    /// # Errors
    /// [`TracerError::Unsupported`] for a refit where the method has none ([`TracerDescription::no_refit`]),
    /// [`TracerError::Failed`] for a refit to other triangles, others as [`Tracer::build`].
    fn update(
        &mut self,
        update: Update,
        geometry: &Geometry,
        viewpoint: &Viewpoint,
        parameters: &Parameters,
        clock: &mut PhaseClock<'_>,
    ) -> Result<(), TracerError>;

    /// Whether the last build or update ran out of room. There is room for it now, and a rebuild fits: until then rays
    /// may be answered wrongly. For structures that are sized from counts.
    ///
    /// # Errors
    /// [`TracerError::TooLarge`] if the device cannot hold what is needed.
    fn grow_on_overflow(&mut self) -> Result<bool, TracerError> {
        Ok(false)
    }

    /// Answers every ray of the job into `hits`, which has room for surfaces where the job ends there; complete only when
    /// the clock has been finished.
    ///
    /// # Errors
    /// [`TracerError::Unsupported`] for a query or end that the method does not serve ([`TracerDescription::queries`],
    /// [`TracerDescription::ends`]), others as they say.
    fn trace(&self, job: TraceJob<'_>, hits: &mut HitBuffer, clock: &mut PhaseClock<'_>) -> Result<(), TracerError>;

    /// The same as [`Structure::trace`], by a variant that counts; never timed. Gives the same hits.
    ///
    /// # Errors
    /// As [`Structure::trace`].
    fn trace_counted(&self, job: TraceJob<'_>, hits: &mut HitBuffer) -> Result<Vec<Counter>, TracerError>;

    /// What the structure holds.
    fn memory(&self) -> MemoryReport;

    /// A trace's own buffers and textures, beside rays, hits and surfaces: what the job takes while it runs, each by its
    /// name. Of textures, which drivers pad as they like, what the last such job took.
    ///
    /// # Errors
    /// [`TracerError::Parameter`] for a job with other parameters than the tracer's.
    fn trace_memory(&self, job: TraceJob<'_>) -> Result<Vec<MemoryEntry>, TracerError> {
        let _ = job;
        Ok(Vec::new())
    }

    /// The images that the structure sees the scene through, and how a trace with these parameters goes over them; empty for one
    /// that holds the scene itself. Of images that show the same, rays go by the first.
    ///
    /// # Errors
    /// [`TracerError::Parameter`] for other parameters than the tracer's.
    fn samplings(&self, parameters: &Parameters) -> Result<Vec<SampledImage>, TracerError> {
        let _ = parameters;
        Ok(Vec::new())
    }

    /// The voxels that the structure knows the scene by, and how a trace with these parameters looks into them; none for methods
    /// without.
    ///
    /// # Errors
    /// [`TracerError::Parameter`] for other parameters than the tracer's.
    fn voxels(&self, parameters: &Parameters) -> Result<Option<VoxelGrid>, TracerError> {
        let _ = parameters;
        Ok(None)
    }

    /// Reads the structure back and checks it against the scene; gives printable statistics. `geometry` is what it was last
    /// built over, rebuilt over or fitted to: after [`Update::Reuse`] over a moved scene that is the scene before.
    ///
    /// # Errors
    /// [`TracerError::Failed`] with what is inconsistent.
    fn validate(&self, geometry: &Geometry) -> Result<Vec<(&'static str, f64)>, TracerError>;
}
