//! What is asked in one place, and what comes of it.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use serde_json::Value;
use tracebench_api::{Hit, Update};
use tracebench_scenes::Scene;

use super::RunError;
use super::session::{PreparedRays, SamplingModel, Session};
use crate::plan::{Plan, TracerRequest};
use crate::results::{InterleavedSetRecord, Row, SampleSchedule, SceneRecord, Skipped, ViewpointRecord};

/// A configuration that is asked for.
pub(crate) struct Request {
    /// The tracer as it runs.
    pub tracer: TracerRequest,
    /// How it follows the place's film, if it does.
    pub follows: Option<Update>,
}

impl Request {
    /// A tracer that builds where it traces.
    pub fn of(tracer: &TracerRequest) -> Self {
        Self { tracer: tracer.clone(), follows: None }
    }

    /// Whether one structure serves both: they differ in parameters of the trace alone.
    pub fn shares_with(&self, other: &Self) -> bool {
        self.tracer.name() == other.tracer.name()
            && self.tracer.resolution == other.tracer.resolution
            && self.follows == other.follows
            && self.tracer.build_parameters().eq(other.tracer.build_parameters())
    }
}

/// How much is done for every configuration.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MeasureOptions {
    /// How long sampling goes on.
    pub sampling: SampleSchedule,
    /// Seed of the orders.
    pub seed: u64,
    /// Whether times are taken: else everything is done once.
    pub timed: bool,
    /// Whether builds are timed where traces are: else everything is built once.
    pub builds_timed: bool,
    /// Whether structures are read back and checked.
    pub validated: bool,
    /// Whether traces are repeated by the counting variant.
    pub counted: bool,
    /// Whether answers that are none, and controls that fail, are data rather than the end.
    pub lenient: bool,
}

impl MeasureOptions {
    /// Everything, with times taken as a plan says.
    pub fn timed(plan: &Plan) -> Self {
        Self { sampling: plan.preset.sampling, seed: plan.seed, timed: true, ..Self::untimed() }
    }

    /// Everything once.
    pub const fn untimed() -> Self {
        let sampling = SampleSchedule::rounds(0);
        Self { sampling, seed: 0, timed: false, builds_timed: true, validated: true, counted: true, lenient: false }
    }
}

/// The frames of an animation; rays are traced at the last.
pub(crate) struct AnimationFrames {
    /// Vertices by frame.
    pub positions: Vec<Vec<[f32; 3]>>,
    pub triangles: Vec<[u32; 3]>,
    pub materials: Vec<u32>,
    /// Counted passes over them.
    pub passes: u32,
}

impl AnimationFrames {
    /// Frames of a scene.
    pub fn new(scene: &Scene, positions: Vec<Vec<[f32; 3]>>, passes: u32) -> Self {
        let (triangles, materials) = (scene.mesh.triangles.clone(), scene.mesh.triangle_materials.clone());
        Self { positions, triangles, materials, passes }
    }
}

/// A place that is ready to be measured.
pub(crate) struct PreparedWorkload {
    pub scene: SceneRecord,
    pub viewpoint: ViewpointRecord,
    /// The difficulty level of the case that it is.
    pub difficulty_level: Option<f64>,
    pub session: Session,
    pub film: Option<AnimationFrames>,
    /// What the study wants to know of it.
    pub told: Value,
}

/// Answers to a ray set.
pub(crate) struct Observations {
    pub hits: Vec<Hit>,
    /// Through what they were found.
    pub sampling_model: SamplingModel,
}

/// What a study wants to know of the answers to a ray set that records do not tell: by request, `None` for one without.
pub(crate) type Hook<'a> = &'a dyn Fn(&Session, &PreparedRays, &[Option<Observations>]) -> Result<Value, RunError>;

/// What is to be measured in one place.
pub(crate) struct Workload<'a> {
    /// Its place in the plan, which names its files.
    pub index: usize,
    /// Hash of its scene, where it is known before: interleaved sets in another one are not taken from the journal.
    pub scene_sha256: Option<&'a str>,
    /// Loads it, if it must be.
    pub prepare: &'a dyn Fn() -> Result<PreparedWorkload, RunError>,
    /// The configurations.
    pub requests: &'a [Request],
    pub options: MeasureOptions,
    pub hook: Option<Hook<'a>>,
}

/// Why a configuration could not be measured.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Refusal {
    pub reason: String,
    /// The device is too small.
    pub too_large: bool,
    /// A limit of the device forbids it.
    #[serde(default)]
    pub unavailable: bool,
    /// The method does not serve what was asked.
    #[serde(default)]
    pub unserved: bool,
    /// It may have been for want of room beside others.
    pub for_room: bool,
}

/// What was measured in one place.
#[derive(Default)]
pub(crate) struct Measured {
    pub scene: SceneRecord,
    pub viewpoint: ViewpointRecord,
    pub controls: Vec<Row>,
    /// By request, or why not.
    pub rows: Vec<Result<Row, Refusal>>,
    pub anchors: Vec<Row>,
    /// Rows name theirs by its place.
    pub interleaved_sets: Vec<InterleavedSetRecord>,
    /// Ray sets that were not made.
    pub skipped: Vec<Skipped>,
    /// What the study wanted to know of the place.
    pub told: Value,
    /// What it wanted to know of every ray set.
    pub hooked: Vec<Value>,
    /// What a control did wrong, where that is data.
    pub invalid: Option<String>,
}

impl Measured {
    /// With what was said about ray sets otherwise than of the run as a whole.
    #[must_use]
    pub fn saying(mut self, ray_parameters: &BTreeMap<String, Value>) -> Self {
        let rows = self.rows.iter_mut().flatten().chain(&mut self.controls).chain(&mut self.anchors);
        let viewpoints = rows.map(|row| &mut row.viewpoint).chain([&mut self.viewpoint]);
        viewpoints.for_each(|viewpoint| viewpoint.ray_parameters.clone_from(ray_parameters));
        self
    }
}
