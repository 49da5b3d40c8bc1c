//! `explain.json`: wrong rays by class and cause.

use std::collections::BTreeMap;

use serde::Serialize;
use tracebench_api::Query;

use super::{GIVEN_UP, UNEXPLAINED};
use crate::contenders::Remedy;
use crate::plan::{Plan, TracerRequest};
use crate::records;
use crate::registry::Device;
use crate::results::{Provenance, SceneRecord, Skipped, TracerRecord, ViewpointRecord};

/// The schema that this program writes.
pub const SCHEMA: u32 = 1;

/// Every wrong ray of a tracer, explained.
#[derive(Clone, Debug, Serialize)]
pub struct Explanation {
    /// [`SCHEMA`].
    pub schema: u32,
    /// Where, by which program and when; its fields stand among these.
    #[serde(flatten)]
    pub provenance: Provenance,
    /// Seed of the ray sets.
    pub seed: u64,
    /// Run preset.
    pub preset: String,
    /// The tracer as it was asked for: the first rung.
    pub tracer: TracerRecord,
    /// What each further rung takes away.
    pub ladder: Vec<RemedyRecord>,
    /// The scenes.
    pub scenes: Vec<SceneExplained>,
    /// Ray sets that were not made, and why.
    pub skipped: Vec<Skipped>,
}

/// A rung.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct RemedyRecord {
    /// The cause that it takes away.
    pub cause: String,
    /// The tracer's parameter.
    pub parameter: String,
    /// Its value from this rung on.
    pub value: String,
    /// Where the cause comes from.
    pub source: String,
}

/// A scene.
#[derive(Clone, Debug, Serialize)]
pub struct SceneExplained {
    /// The scene.
    pub scene: SceneRecord,
    /// The viewpoint.
    pub viewpoint: ViewpointRecord,
    /// Its ray sets.
    pub sets: Vec<Explained>,
}

/// A ray set under the rule `tight`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Explained {
    /// Ray set.
    pub rays: String,
    /// Hash of the rays.
    pub rays_sha256: String,
    /// What was asked.
    pub query: Query,
    /// Number of rays.
    pub count: u64,
    /// Rays whose truth hangs on rounding: in no other count.
    pub ties: u64,
    /// Wrong rays on each rung, the first as the tracer was asked for.
    pub wrong_by_rung: Vec<u64>,
    /// Rays that are right on the first rung and wrong on a later one: a remedy alone may do harm.
    pub wrong_on_the_way: u64,
    /// Rays that are wrong on the last rung though their search was not given up, whatever they were on the first.
    pub unexplained: u64,
    /// Of the rays that are wrong on the first rung: class, then cause, then how many. What is wrong on the last rung is
    /// `step_cap` where its search was given up there, else `unexplained`.
    pub causes: BTreeMap<String, BTreeMap<String, u64>>,
}

impl Explained {
    /// Wrong rays of a cause, of every class.
    pub fn of_cause(&self, cause: &str) -> u64 {
        self.causes.values().filter_map(|causes| causes.get(cause)).sum()
    }

    /// Wrong rays on the last rung: those that no rung takes away, and those that a rung has brought.
    pub fn left(&self) -> u64 {
        self.wrong_by_rung.last().copied().unwrap_or(0)
    }
}

impl Explanation {
    pub(super) fn begin(plan: &Plan, request: &TracerRequest, ladder: &[Remedy], device: &Device) -> Self {
        let rung = |remedy: &Remedy| RemedyRecord {
            cause: remedy.cause.to_owned(),
            parameter: remedy.parameter.to_owned(),
            value: remedy.value.to_owned(),
            source: remedy.source.to_owned(),
        };
        Self {
            schema: SCHEMA,
            provenance: Provenance::now(device.as_ref().ok().map(|gpu| gpu.listing.clone())),
            seed: plan.seed,
            preset: plan.preset.name.to_owned(),
            tracer: records::request_record(request),
            ladder: ladder.iter().map(rung).collect(),
            scenes: Vec::new(),
            skipped: Vec::new(),
        }
    }

    /// The causes in order, what is unexplained last.
    pub fn causes(&self) -> Vec<&str> {
        self.ladder.iter().map(|rung| rung.cause.as_str()).chain([GIVEN_UP, UNEXPLAINED]).collect()
    }

    /// Rays that are wrong on the last rung and were not given up, of all scenes.
    pub fn unexplained(&self) -> u64 {
        self.scenes.iter().flat_map(|scene| &scene.sets).map(|set| set.unexplained).sum()
    }
}
