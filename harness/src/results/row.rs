//! One tracer in one place: the row of every record.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use tracebench_api::MemoryEntry;

use super::{BuildRecord, TraceRecord, is_default};

/// One tracer on one scene from one viewpoint.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// The scene.
    pub scene: SceneRecord,
    /// The viewpoint.
    pub viewpoint: ViewpointRecord,
    /// The tracer.
    pub tracer: TracerRecord,
    /// What it was made by: a hash of the sources of its tracer, of rays, truth and judge; none of rows of before there were any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fingerprint: Option<String>,
    /// How its structure was brought up to date, where it was not built.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub update_mode: Option<UpdateModeRecord>,
    /// The difficulty level of the case that its scene is, if it is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub difficulty_level: Option<f64>,
    /// In which turn of its place it was measured: configurations are interleaved within one.
    #[serde(default, skip_serializing_if = "is_default")]
    pub resident_batch: u32,
    /// Which machine it was measured on, where the record was merged: its place among the provenance's.
    #[serde(default, skip_serializing_if = "is_default")]
    pub machine: u32,
    /// Its memory.
    pub memory: MemoryRecord,
    /// What its structure says of itself when it is validated, by name. Empty in files of before it was asked.
    #[serde(default)]
    pub structure_statistics: BTreeMap<String, f64>,
    /// Its build.
    pub build: BuildRecord,
    /// Its traces, one a ray set.
    pub traces: Vec<TraceRecord>,
}

impl Row {
    /// Whether the sources that made it are those of this program: only then its times are this program's.
    pub fn is_of_this_version(&self) -> bool {
        self.fingerprint.as_deref() == crate::machine::fingerprint(&self.tracer.name)
    }

    /// The row where its interleaved sets stand behind so many others.
    #[must_use]
    pub fn with_races_after(mut self, others: u32) -> Self {
        let traces = self.traces.iter_mut().map(|trace| &mut trace.times);
        for times in traces.chain(self.build.all_mut()) {
            times.interleaved_set = times.interleaved_set.map(|interleaved_set| interleaved_set + others);
        }
        self
    }
}

/// How a structure was brought up to date. The row's `build` has the times of that.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct UpdateModeRecord {
    /// Name.
    pub name: String,
    /// Parameters that it sets, with their values.
    pub parameters: BTreeMap<String, serde_json::Value>,
}

/// A scene.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SceneRecord {
    /// Catalogue name or file stem.
    pub name: String,
    /// Hash of positions, triangles and materials.
    pub sha256: String,
    /// Number of triangles.
    pub triangles: u64,
    /// Diagonal of the bounds, scene units.
    pub diagonal: f64,
    /// Scale factor of a procedural scene.
    pub scale: Option<f64>,
    /// Triangles of exactly zero area in the file, dropped.
    pub zero_area_triangles_dropped: u64,
    /// Triangles with the same corners as an earlier one, kept.
    pub duplicate_triangles_kept: u64,
    /// What the import ignored.
    pub warnings: Vec<String>,
}

/// A viewpoint.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ViewpointRecord {
    /// Name, or how it was found.
    pub name: String,
    /// The eye.
    pub eye: [f32; 3],
    /// Unit direction of view.
    pub forward: [f32; 3],
    /// Unit vector up in the image.
    pub up: [f32; 3],
    /// Whole vertical field of view, degrees.
    pub vertical_fov_degrees: f32,
    /// Near distance, eye depth in scene units.
    pub near: f32,
    /// Far distance.
    pub far: f32,
    /// Width and height of the frame from which structures take theirs, pixels.
    pub frame: [u32; 2],
    /// Edge of a cube face, pixels.
    pub face: u32,
    /// Width and height of the image from whose pixels rays start.
    pub ray_image: [u32; 2],
    /// Animation time, seconds.
    pub time_s: f64,
    /// What was said about its ray sets otherwise than of the run as a whole.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub ray_parameters: BTreeMap<String, serde_json::Value>,
}

impl ViewpointRecord {
    /// What was said about its ray sets otherwise than of the run as a whole, each after a comma.
    pub fn ray_overrides(&self) -> String {
        self.ray_parameters.iter().map(|(name, value)| format!(", {name} = {}", said(value))).collect()
    }
}

/// A tracer with its preset unless it is the published one.
pub(crate) fn config(name: &str, preset: &str) -> String {
    if ["published", "control"].contains(&preset) { name.to_owned() } else { format!("{name}:{preset}") }
}

/// A parameter's value as the command line takes it.
pub(crate) fn said(value: &serde_json::Value) -> String {
    value.as_str().map_or_else(|| value.to_string(), str::to_owned)
}

/// A tracer with its parameters.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TracerRecord {
    /// Name.
    pub name: String,
    /// Preset that the parameters start from; "control" for controls.
    pub preset: String,
    /// Every parameter's value.
    pub parameters: BTreeMap<String, serde_json::Value>,
    /// Parameters that `--set` changed.
    pub changed: Vec<String>,
    /// `host` or `device`.
    pub residency: String,
}

impl TracerRecord {
    /// Name with the preset unless it is the published one, and changed parameters: the label in tables and charts.
    pub fn label(&self) -> String {
        let mut label = config(&self.name, &self.preset);
        for name in &self.changed {
            if let Some(value) = self.parameters.get(name) {
                label = format!("{label} {name}={}", said(value));
            }
        }
        label
    }
}

/// Memory of a structure.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct MemoryRecord {
    /// Its parts.
    pub structure: Vec<MemoryEntry>,
    /// Allocated bytes of all parts.
    pub structure_bytes: u64,
    /// Geometry that must stay resident to trace.
    pub geometry_bytes: u64,
    /// The most held at once while building, without the scene's geometry.
    pub build_peak_bytes: u64,
}
