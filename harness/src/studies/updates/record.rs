//! `updates.json`: everything that was measured of structures which follow an animation. docs/results.md describes it.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::results::{
    MemoryRecord, Provenance, SceneRecord, Skipped, Times, TraceRecord, TracerRecord, TracerRun, ViewpointRecord,
};

/// The schema that this program writes and reads.
pub const SCHEMA: u32 = 1;

/// The way of a row that is built over the last frame alone, which others are set against.
pub const FRESH_BUILD: &str = "fresh build";

/// A whole measurement.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Updates {
    /// [`SCHEMA`].
    pub schema: u32,
    /// The table that it was made for.
    pub table: String,
    /// Where, by which program and when; its fields stand among these.
    #[serde(flatten)]
    pub provenance: Provenance,
    /// Seed of the ray sets.
    pub seed: u64,
    /// Run preset.
    pub preset: String,
    /// What was said about ray sets: every parameter's value.
    pub ray_parameters: BTreeMap<String, serde_json::Value>,
    /// Updates in one pass over an animation, one a frame.
    pub frames: u32,
    /// Counted passes; one before them warms up.
    pub passes: u32,
    /// The scenes.
    pub scenes: Vec<SceneUpdates>,
    /// What did not run, and why.
    pub skipped: Vec<Skipped>,
}

/// One scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SceneUpdates {
    /// The scene at the last frame.
    pub scene: SceneRecord,
    /// The viewpoint at the last frame.
    pub viewpoint: ViewpointRecord,
    /// Animation times, seconds: that of the build, then of every update.
    pub times_s: Vec<f64>,
    /// The controls on the rays of the last frame.
    pub controls: Vec<TracerRun>,
    /// Tracers with their ways.
    pub rows: Vec<UpdateRow>,
}

/// One tracer that follows a scene in one way.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct UpdateRow {
    /// The tracer, without what the way sets.
    pub tracer: TracerRecord,
    /// How it follows: "fresh build" for a build over the last frame.
    pub way: String,
    /// Parameters that the way sets, with their values.
    pub way_parameters: BTreeMap<String, serde_json::Value>,
    /// Times of the updates, in the order of passes and frames; of a fresh build those of builds.
    pub update: Times,
    /// Memory at the last frame.
    pub memory: MemoryRecord,
    /// What the structure says of itself at the last frame.
    pub structure_statistics: BTreeMap<String, f64>,
    /// Traces of the last frame's rays.
    pub traces: Vec<TraceRecord>,
}
