//! What a record says of needs: how structures were shrunk, and what that did to the same rays, one by one. How far they may shrink
//! is derived.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::{Row, Rule};

/// Structures shrunk until answers get worse.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct NeedRecord {
    /// A structure is too small when the upper end of the interval of newly wrong less newly right rays is beyond this share.
    pub max_lost_share: f64,
    /// By the second measure also when its traces take more times as long than this.
    pub max_slowdown: f64,
    /// A curve a scene, viewpoint and tracer.
    pub curves: Vec<NeedCurve>,
}

/// A tracer in one place.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct NeedCurve {
    /// The scene.
    pub scene: String,
    /// Its hash.
    pub scene_sha256: String,
    /// The viewpoint.
    pub viewpoint: String,
    /// Which of the scene's viewpoints that is: 0 for the own one, 1 for another.
    pub view: u32,
    /// The tracer.
    pub tracer: String,
    /// Its preset.
    pub preset: String,
    /// The rule by which closest hits are right or wrong: `tight` of analytic methods, `footprint` of those that sample.
    pub rule: Rule,
    /// Its structures, first as it was asked for, then every step of every axis, then several axes at once.
    pub points: Vec<NeedPoint>,
}

/// A structure, shrunk or not.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct NeedPoint {
    /// What is shrunk, by axis: nothing of the first point, one axis of a step.
    pub shrunk: BTreeMap<String, String>,
    /// Every parameter of the tracer.
    pub parameters: BTreeMap<String, serde_json::Value>,
    /// Width and height of the viewpoint's frame, pixels.
    pub frame: [u32; 2],
    /// Edge of the viewpoint's cube faces, pixels.
    pub face: u32,
    /// Why it could not be measured.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub skipped: Option<String>,
    /// By ray set: how its answers differ from those of the first point.
    pub changed: BTreeMap<String, ChangedRays>,
}

/// The same rays answered by two structures.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct ChangedRays {
    /// Rays without ambiguous rays.
    pub rays: u64,
    /// Rays that the first structure answers rightly and this one wrongly.
    pub newly_wrong: u64,
    /// Rays that the first structure answers wrongly and this one rightly.
    pub newly_right: u64,
}

/// Values by axis, as `name=value`.
pub fn values_label(values: &BTreeMap<String, String>) -> String {
    values.iter().map(|(name, value)| format!("{name}={value}")).collect::<Vec<_>>().join(" ")
}

impl NeedPoint {
    /// Whether a row is this point's, in whatever place.
    pub fn is_of(&self, row: &Row) -> bool {
        row.tracer.parameters == self.parameters && (row.viewpoint.frame, row.viewpoint.face) == (self.frame, self.face)
    }

    /// What is shrunk, as `name=value`.
    pub fn label(&self) -> String {
        values_label(&self.shrunk)
    }
}

impl NeedCurve {
    /// Whether a row was measured in this place of this tracer.
    pub fn holds(&self, row: &Row) -> bool {
        row.scene.name == self.scene
            && row.scene.sha256 == self.scene_sha256
            && row.viewpoint.name == self.viewpoint
            && (row.tracer.name == self.tracer && row.tracer.preset == self.preset)
    }
}
