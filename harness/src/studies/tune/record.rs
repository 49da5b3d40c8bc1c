//! `tune.json`: everything that was judged of a tracer over the values of one parameter, from two viewpoints of every scene,
//! and the values that would have been chosen. docs/tuning.md describes it.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use tracebench_api::Query;

use crate::judge::Rule;
use crate::results::{Judgement, Provenance, SceneRecord, Skipped, TracerRecord, TracerRun, ViewpointRecord};
use crate::studies::sweep::AxisRecord;

/// The schema that this program writes and reads.
pub const SCHEMA: u32 = 1;

/// A parameter of a tracer, tuned.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Tuning {
    /// [`SCHEMA`].
    pub schema: u32,
    /// Where, by which program and when.
    #[serde(flatten)]
    pub provenance: Provenance,
    /// Seed of the ray sets.
    pub seed: u64,
    /// Run preset.
    pub preset: String,
    /// What was said about ray sets: every parameter's value.
    pub ray_parameters: BTreeMap<String, serde_json::Value>,
    /// The tracer with its default values.
    pub tracer: TracerRecord,
    /// The parameter; `own` is its default, the value of the tracer's preset.
    pub axis: AxisRecord,
    /// The rule by which values are chosen; of any-hit sets it is balanced accuracy, whatever stands here.
    pub rule: Rule,
    /// The scenes.
    pub scenes: Vec<SceneTuned>,
    /// What did not run, and why.
    pub skipped: Vec<Skipped>,
}

/// One scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SceneTuned {
    /// The scene.
    pub scene: SceneRecord,
    /// The own viewpoint, then another, if there is one.
    pub views: Vec<ViewTuned>,
}

/// One viewpoint.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ViewTuned {
    /// The viewpoint.
    pub viewpoint: ViewpointRecord,
    /// Its ray sets.
    pub sets: Vec<SetTuned>,
    /// The controls on the same rays.
    pub controls: Vec<TracerRun>,
}

/// One ray set: every value traced the same rays.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SetTuned {
    /// Ray set.
    pub rays: String,
    /// Hash of the rays.
    pub rays_sha256: String,
    /// What was asked.
    pub query: Query,
    /// Number of rays.
    pub count: u64,
    /// The parameter's values, in order.
    pub values: Vec<ValueTuned>,
    /// The values that would have been chosen, each judged on these rays, in the order of [`Label::ALL`].
    pub choices: Vec<Choice>,
}

/// One value of the parameter.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ValueTuned {
    /// The value.
    pub value: String,
    /// What was judged; `None` where it could not be measured.
    pub judged: Option<Judged>,
    /// Why it could not.
    pub skipped: Option<String>,
}

/// What a value answered.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Judged {
    /// Hash of the judged hits.
    pub hits_sha256: String,
    /// How many rays ended with which status.
    pub statuses: BTreeMap<String, u64>,
    /// The verdict, without the list of wrong rays.
    pub judgement: Judgement,
}

/// How a value was come by: which rays have seen it beforehand.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Label {
    /// The value of the tracer's preset: no rays.
    Default,
    /// The best on the judged rays themselves: what no user has.
    TunedHere,
    /// The best from the scene's other viewpoint.
    TunedElsewhere,
    /// The best on average over the other scenes' own viewpoints.
    TunedOnOtherScenes,
}

impl Label {
    /// Every label.
    pub const ALL: [Self; 4] = [Self::Default, Self::TunedHere, Self::TunedElsewhere, Self::TunedOnOtherScenes];

    /// Its name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Default => "default",
            Self::TunedHere => "tuned here",
            Self::TunedElsewhere => "tuned elsewhere",
            Self::TunedOnOtherScenes => "tuned on the other scenes",
        }
    }
}

/// A value that would have been chosen.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Choice {
    /// How.
    pub label: Label,
    /// The value; `None` where there was nothing to choose by.
    pub value: Option<String>,
    /// Its share of right answers on these rays by the rule; `None` if it was not measured or every ray is a tie.
    pub score: Option<f64>,
    /// What it loses on these rays to the values come by otherwise: their score less its own.
    pub lost_to: BTreeMap<Label, f64>,
}

impl SetTuned {
    /// What was judged of a value.
    pub fn judged(&self, value: &str) -> Option<&Judged> {
        self.values.iter().find(|each| each.value == value)?.judged.as_ref()
    }

    /// The choice of a label.
    pub fn choice(&self, label: Label) -> Option<&Choice> {
        self.choices.iter().find(|choice| choice.label == label)
    }
}
