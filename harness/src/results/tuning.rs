//! What a tuning adds to its sweep: by which rule values are chosen, and from where each scene was seen. The values that would
//! have been chosen are derived from the rows.

use serde::{Deserialize, Serialize};

use super::{Rule, SceneRecord, TracerRecord, ViewpointRecord};

/// A parameter of a tracer, tuned.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TuningRecord {
    /// The tracer with its default values.
    pub tracer: TracerRecord,
    /// The rule by which values are chosen; of any-hit sets it is balanced accuracy, whatever stands here.
    pub rule: Rule,
    /// The scenes.
    pub scenes: Vec<TunedScene>,
}

/// One scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TunedScene {
    /// The scene.
    pub scene: SceneRecord,
    /// The own viewpoint, then another, if there is one.
    pub viewpoints: Vec<ViewpointRecord>,
}

/// What a scene seen from one of its viewpoints is called where a point is skipped.
pub fn place_name(scene: &SceneRecord, viewpoint: &ViewpointRecord, view: usize) -> String {
    if view == 0 { scene.name.clone() } else { format!("{} from {}", scene.name, viewpoint.name) }
}
