//! Why rays are wrong: what an explanation adds to the rows of its steps, which know no ray from one step to the next.

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};
use tracebench_api::Query;

use super::{SceneRecord, TracerRecord, ViewpointRecord};

/// What is wrong on the last step because its search was given up, as the ray's status says: steps or a driver's limit of
/// loops.
pub const GIVEN_UP: &str = "step_cap";

/// What no step takes away, and the judge knows no cause of.
pub const UNEXPLAINED: &str = "unexplained";

/// The share of a set's rays that may stay unexplained where the judge tells what no step takes away.
pub const MAX_UNEXPLAINED: f64 = 0.02;

/// Every wrong ray of a tracer, explained.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ExplanationRecord {
    /// The tracer as it was asked for: the first step.
    pub tracer: TracerRecord,
    /// What each further step takes away.
    pub remedies: Vec<RemedyRecord>,
    /// Whether the judge tells the causes of what no step takes away: of a method that samples, which is never fine enough.
    #[serde(default)]
    pub judged: bool,
    /// The scenes.
    pub scenes: Vec<SceneExplained>,
}

/// A step.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct RemedyRecord {
    /// The cause that it takes away.
    pub cause: String,
    /// The tracer's parameter.
    pub parameter: String,
    /// Its value from this step on.
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
    /// Rungs that the device was too small for, `parameter=value`, which took nothing away, and why.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub left_out: BTreeMap<String, String>,
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
    pub ambiguous_rays: u64,
    /// Wrong rays on each step, the first as the tracer was asked for.
    pub wrong_by_remedy: Vec<u64>,
    /// Rays that are right on the first step and wrong on a later one: a remedy alone may do harm.
    pub wrong_on_the_way: u64,
    /// Rays that are wrong on the last step without a known cause though their search was not given up, whatever they were on the
    /// first.
    pub unexplained: u64,
    /// Of the rays that are wrong on the first step: class, then cause, then how many. What is wrong on the last step is
    /// `step_cap` where its search was given up there, else has the judge's cause if it is asked, or is `unexplained`.
    pub causes: BTreeMap<String, BTreeMap<String, u64>>,
}

impl Explained {
    /// Wrong rays of a cause, of every class.
    pub fn of_cause(&self, cause: &str) -> u64 {
        self.causes.values().filter_map(|causes| causes.get(cause)).sum()
    }

    /// Wrong rays on the last step: those that no step takes away, and those that a step has brought.
    pub fn left(&self) -> u64 {
        self.wrong_by_remedy.last().copied().unwrap_or(0)
    }
}

impl ExplanationRecord {
    fn sets(&self) -> impl Iterator<Item = (&SceneExplained, &Explained)> {
        self.scenes.iter().flat_map(|scene| scene.sets.iter().map(move |set| (scene, set)))
    }

    /// The causes in order: of the steps, of the judge, what is unexplained last.
    pub fn causes(&self) -> Vec<&str> {
        let of_steps = self.remedies.iter().map(|remedy| remedy.cause.as_str());
        let mut causes: Vec<&str> = of_steps.chain([GIVEN_UP]).collect();
        let found = self.sets().flat_map(|(_, set)| set.causes.values().flat_map(BTreeMap::keys));
        let of_judge: BTreeSet<&str> = found.map(String::as_str).filter(|cause| !causes.contains(cause)).collect();
        causes.extend(of_judge.into_iter().filter(|cause| *cause != UNEXPLAINED));
        causes.push(UNEXPLAINED);
        causes
    }

    /// Rays that are wrong on the last step without a known cause, of all scenes.
    pub fn unexplained(&self) -> u64 {
        self.sets().map(|(_, set)| set.unexplained).sum()
    }

    /// The sets, by scene, of which more than what may be is unexplained: a share where the judge tells causes, else any.
    pub fn left_open(&self) -> Vec<(&str, &Explained)> {
        let may = |set: &Explained| if self.judged { MAX_UNEXPLAINED * set.count as f64 } else { 0.0 };
        let open = self.sets().filter(|(_, set)| set.unexplained as f64 > may(set));
        open.map(|(scene, set)| (scene.scene.name.as_str(), set)).collect()
    }
}
