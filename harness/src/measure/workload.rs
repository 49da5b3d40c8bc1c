//! What is asked in one place, and what comes of it.

use std::collections::BTreeMap;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use tracebench_api::Hit;

use super::RunError;
use super::session::{PreparedRays, SamplingModel, Session};
use crate::plan::{Plan, TracerRequest};
use crate::results::{InterleavedSetRecord, Row, SampleSchedule, SceneRecord, Skipped, ViewpointRecord};

/// How much is done for every configuration.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MeasureOptions {
    /// How long times are sampled; without it everything is done once.
    pub sampling: Option<SampleSchedule>,
    /// Seed of the orders.
    pub seed: u64,
    /// Whether builds are timed where traces are: else everything is built once.
    pub builds_timed: bool,
    /// Whether what is timed is not builds but refits to vertices that stand still: what a refit does is the same however far they moved.
    pub refitted: bool,
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
        let (sampling, builds_timed) = (Some(plan.preset.sampling), plan.builds_timed);
        Self { sampling, seed: plan.seed, builds_timed, ..Self::untimed() }
    }

    /// Everything once.
    pub const fn untimed() -> Self {
        let (builds_timed, validated, counted) = (true, true, true);
        Self { sampling: None, seed: 0, builds_timed, refitted: false, validated, counted, lenient: false }
    }
}

/// A place that is ready to be measured.
pub struct PreparedWorkload {
    /// The scene.
    pub scene: SceneRecord,
    /// The viewpoint.
    pub viewpoint: ViewpointRecord,
    /// The difficulty level of the case that it is.
    pub difficulty_level: Option<f64>,
    /// Its rays and truth.
    pub session: Session,
}

/// Answers to a ray set.
pub(crate) struct Observations {
    pub hits: Vec<Hit>,
    /// Through what they were found.
    pub sampling_model: SamplingModel,
}

/// What a study wants to know of the answers to a ray set that records do not tell: by request, `None` for one without.
pub(crate) type Hook<'a> = &'a dyn Fn(&Session, &PreparedRays, &[Option<Observations>]) -> Result<Value, RunError>;

/// Loads a place.
pub(crate) type Prepare<'a> = Box<dyn FnOnce() -> Result<PreparedWorkload, RunError> + 'a>;

/// What is to be measured in one place.
pub(crate) struct Workload<'a> {
    /// Its place in the plan, which names its files.
    pub index: usize,
    /// Hash of its scene, where it is known before: interleaved sets in another one are not taken from the journal.
    pub scene_sha256: Option<&'a str>,
    /// Loads it, if it must be.
    pub prepare: Prepare<'a>,
    /// The configurations.
    pub requests: &'a [TracerRequest],
    pub options: MeasureOptions,
    pub hook: Option<Hook<'a>>,
}

/// Why a configuration could not be measured.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
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
    /// What the study wanted to know of every ray set.
    pub hooked: Vec<Value>,
    /// What a control did wrong, where that is data.
    pub invalid: Option<String>,
}

/// What a [`Hook`] has found.
pub(crate) fn told(found: &impl Serialize) -> Result<Value, RunError> {
    serde_json::to_value(found).map_err(|error| RunError::Nothing(error.to_string()))
}

impl Measured {
    /// What the study's [`Hook`] found, of the ray sets of which it did.
    pub fn take_hooked<T: DeserializeOwned>(&mut self) -> Result<Vec<T>, RunError> {
        let hooked = std::mem::take(&mut self.hooked).into_iter().filter(|told| !told.is_null());
        let read = |told| serde_json::from_value(told).map_err(|error| RunError::Nothing(error.to_string()));
        hooked.map(read).collect()
    }

    /// With what was said about ray sets otherwise than of the run as a whole.
    #[must_use]
    pub fn saying(mut self, ray_parameters: &BTreeMap<String, Value>) -> Self {
        let rows = self.rows.iter_mut().flatten().chain(&mut self.controls).chain(&mut self.anchors);
        let viewpoints = rows.map(|row| &mut row.viewpoint).chain([&mut self.viewpoint]);
        viewpoints.for_each(|viewpoint| viewpoint.ray_parameters.clone_from(ray_parameters));
        self
    }
}
