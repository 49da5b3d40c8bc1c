//! What is asked in one place, and what comes of it.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use serde_json::Value;
use tracebench_api::{Hit, Update, Viewpoint};
use tracebench_scenes::Scene;

use super::RunError;
use super::session::{PreparedRays, Session, Sight};
use crate::plan::{Plan, TracerRequest};
use crate::results::{RaceRecord, Sampling, SceneRecord, Skipped, TracerRun, ViewpointRecord};

/// A contender that is asked for.
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

/// How much is done for every contender.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Effort {
    /// How long sampling goes on.
    pub sampling: Sampling,
    /// Seed of the orders.
    pub seed: u64,
    /// Whether times are taken: else everything is done once.
    pub timed: bool,
    /// Whether structures are read back and checked.
    pub validated: bool,
    /// Whether traces are repeated by the counting variant.
    pub counted: bool,
    /// Whether answers that are none, and controls that fail, are data rather than the end.
    pub lenient: bool,
}

impl Effort {
    /// Everything, with times taken as a plan says.
    pub fn timed(plan: &Plan) -> Self {
        Self { sampling: plan.preset.sampling, seed: plan.seed, timed: true, ..Self::untimed() }
    }

    /// Everything once.
    pub fn untimed() -> Self {
        let sampling = Sampling::rounds(0);
        Self { sampling, seed: 0, timed: false, validated: true, counted: true, lenient: false }
    }
}

/// The frames of an animation; rays are traced at the last.
pub(crate) struct Film {
    /// Vertices by frame.
    pub positions: Vec<Vec<[f32; 3]>>,
    pub triangles: Vec<[u32; 3]>,
    pub materials: Vec<u32>,
    /// Where structures are built from at the first frame, if the eye moves from there to where it is at all others.
    pub built_from: Option<Viewpoint>,
    /// Counted passes over them.
    pub passes: u32,
}

impl Film {
    /// Frames of a scene.
    pub fn new(scene: &Scene, positions: Vec<Vec<[f32; 3]>>, built_from: Option<Viewpoint>, passes: u32) -> Self {
        let (triangles, materials) = (scene.mesh.triangles.clone(), scene.mesh.triangle_materials.clone());
        Self { positions, triangles, materials, built_from, passes }
    }
}

/// A place that is ready to be measured.
pub(crate) struct Placed {
    pub scene: SceneRecord,
    pub viewpoint: ViewpointRecord,
    /// The strength of the case that it is.
    pub strength: Option<f64>,
    pub session: Session,
    pub film: Option<Film>,
    /// What the study wants to know of it.
    pub told: Value,
}

/// Answers to a ray set.
pub(crate) struct Told {
    pub hits: Vec<Hit>,
    /// Through what they were found.
    pub sight: Sight,
}

/// What a study wants to know of the answers to a ray set that records do not tell: by request, `None` for one without.
pub(crate) type Hook<'a> = &'a dyn Fn(&Session, &PreparedRays, &[Option<Told>]) -> Result<Value, RunError>;

/// What is to be measured in one place.
pub(crate) struct Place<'a> {
    /// Its place in the plan, which names its files.
    pub index: usize,
    /// Hash of its scene, where it is known before: races in another one are not taken from the journal.
    pub scene_sha256: Option<&'a str>,
    /// Loads it, if it must be.
    pub prepare: &'a dyn Fn() -> Result<Placed, RunError>,
    /// The contenders.
    pub requests: &'a [Request],
    pub effort: Effort,
    pub hook: Option<Hook<'a>>,
}

/// Why a contender could not be measured.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Refusal {
    pub reason: String,
    /// The device is too small.
    pub too_large: bool,
    /// A limit of the device forbids it.
    #[serde(default)]
    pub unavailable: bool,
    /// It may have been for want of room beside others.
    pub for_room: bool,
}

/// What was measured in one place.
pub(crate) struct Measured {
    pub scene: SceneRecord,
    pub viewpoint: ViewpointRecord,
    pub controls: Vec<TracerRun>,
    /// By request, or why not.
    pub rows: Vec<Result<TracerRun, Refusal>>,
    pub anchors: Vec<TracerRun>,
    /// Rows name theirs by its place.
    pub races: Vec<RaceRecord>,
    /// Ray sets that were not made.
    pub skipped: Vec<Skipped>,
    /// What the study wanted to know of the place.
    pub told: Value,
    /// What it wanted to know of every ray set.
    pub hooked: Vec<Value>,
    /// What a control did wrong, where that is data.
    pub void: Option<String>,
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
