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
    /// Animation times, seconds: that of the build, then of every update. Rays are traced at the last.
    pub times_s: Vec<f64>,
}

/// How a row follows its scene. Its `build` has the times of the updates, in the order of passes and frames; its tracer is
/// told without what the way sets.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct WayRecord {
    /// Name; [`FRESH_BUILD`] for a build over the last frame.
    pub name: String,
    /// Parameters that the way sets, with their values.
    pub parameters: BTreeMap<String, serde_json::Value>,
}
