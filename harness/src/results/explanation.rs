//! Why rays are wrong: what an explanation adds to the rows of its rungs, which know no ray from one rung to the next.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use tracebench_api::Query;

use super::{SceneRecord, TracerRecord, ViewpointRecord};

/// What is wrong on the last rung because its search was given up, as the ray's status says: steps or a driver's limit of
/// loops.
pub const GIVEN_UP: &str = "step_cap";

/// What no rung takes away.
pub const UNEXPLAINED: &str = "unexplained";

/// Every wrong ray of a tracer, explained.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ExplanationRecord {
    /// The tracer as it was asked for: the first rung.
    pub tracer: TracerRecord,
    /// What each further rung takes away.
    pub ladder: Vec<RemedyRecord>,
    /// The scenes.
    pub scenes: Vec<SceneExplained>,
}

/// A rung.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
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
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SceneExplained {
    /// The scene.
    pub scene: SceneRecord,
    /// The viewpoint.
    pub viewpoint: ViewpointRecord,
    /// Its ray sets.
    pub sets: Vec<Explained>,
}

/// A ray set under the rule `tight`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
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

impl ExplanationRecord {
    /// The causes in order, what is unexplained last.
    pub fn causes(&self) -> Vec<&str> {
        self.ladder.iter().map(|rung| rung.cause.as_str()).chain([GIVEN_UP, UNEXPLAINED]).collect()
    }

    /// Rays that are wrong on the last rung and were not given up, of all scenes.
    pub fn unexplained(&self) -> u64 {
        self.scenes.iter().flat_map(|scene| &scene.sets).map(|set| set.unexplained).sum()
    }
}
