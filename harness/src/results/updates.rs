//! What a record says of structures that follow animations: the section, and what stands with each row.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

/// The way of a row that is built over the last frame alone, which others are set against.
pub const FRESH_BUILD: &str = "fresh build";

/// What rows that follow animations have in common.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct UpdatesRecord {
    /// Updates in one pass over an animation, one a frame.
    pub frames: u32,
    /// Counted passes; one before them warms up.
    pub passes: u32,
    /// The scenes that were followed.
    pub scenes: Vec<SceneFollowed>,
}

/// A scene that was followed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SceneFollowed {
    /// Its name.
    pub scene: String,
    /// Its hash.
    pub scene_sha256: String,
    /// Animation times, seconds: that of the build, then of every update. Rays are traced at the last, or at every one.
    pub times_s: Vec<f64>,
    /// Where the camera moves: the scene's hash at every frame, each of which has rays of its own. Empty where it stands still.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub frame_scene_sha256: Vec<String>,
}

/// How a row follows its scene. Its `build` has the times of the updates, in the order of passes and frames; its tracer is
/// told without what the way sets.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct UpdateModeRecord {
    /// Name; [`FRESH_BUILD`] for a build over the last frame.
    pub name: String,
    /// Parameters that the way sets, with their values.
    pub parameters: BTreeMap<String, serde_json::Value>,
    /// The frame at which it traces, where rays are traced at every one; that of the build is 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frame_index: Option<u32>,
    /// What has moved since the build and makes a structure that is reused stale (`geometry`, `viewpoint`): it is shown, and not
    /// valid.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub stale_by: Vec<String>,
}
