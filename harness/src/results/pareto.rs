//! What a record says of Pareto fronts: which points every tracer was given, and where chosen ones were measured again. Fronts,
//! operating points and break-even counts are derived from the rows.

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};
use tracebench_api::Query;

use super::{Row, SceneRecord, ViewpointRecord, config, values_label};

/// The way of rows that were refitted to vertices that stand still, for what a refit takes.
pub const STILL_REFIT: &str = "refit, standing still";

/// Points of several tracers, for fronts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ParetoRecord {
    /// The most points that a tracer was given, those of its presets together.
    pub max_points: u32,
    /// Rays a pixel of the ray image of which the time of a frame is told.
    pub rays_per_pixel: Vec<f64>,
    /// Every point, by tracer, in the order in which the tracer was given it.
    pub points: Vec<FrontPoint>,
    /// The scenes.
    pub scenes: Vec<FrontScene>,
}

/// A point.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FrontPoint {
    /// The tracer.
    pub tracer: String,
    /// The preset that it starts from.
    pub preset: String,
    /// Its place among its tracer's points, from 0.
    pub order: u32,
    /// What it has otherwise than the tracer as it was asked for, by parameter; `resolution` as a multiple.
    pub values: BTreeMap<String, String>,
    /// Every parameter of the tracer.
    pub parameters: BTreeMap<String, serde_json::Value>,
    /// Width and height of the viewpoint's frame, pixels.
    pub frame: [u32; 2],
    /// Edge of the viewpoint's cube faces, pixels.
    pub face: u32,
    /// Places where it could not be measured, with the reason.
    pub skipped: BTreeMap<String, String>,
}

/// A scene.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FrontScene {
    /// The scene.
    pub scene: SceneRecord,
    /// The viewpoint from which all points were measured; points are chosen by what they do here.
    pub viewpoint: ViewpointRecord,
    /// Where the chosen ones were measured again.
    pub held_out: Option<HeldOutRecord>,
    /// Why they were not.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub held_out_skipped: Option<String>,
    /// Further ray images, from which chosen points were traced for what a ray takes beside what a trace does.
    pub ray_images: Vec<[u32; 2]>,
    /// What points on fronts answer, by ray set; none in older records.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub pictures: Vec<SetPictures>,
}

/// The folder beside a record that holds its pictures.
pub const PICTURES_FOLDER: &str = "pictures";

/// Pictures of a ray set: names of files in [`PICTURES_FOLDER`], each named by its hash.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SetPictures {
    /// The ray set.
    pub rays: String,
    /// What is asked of its rays.
    pub query: Query,
    /// Width and height, those of the ray image.
    pub size: [u32; 2],
    /// Distances along rays, scene units, from which white is nearest and dark farthest; not of any-hit sets.
    pub distances: Option<[f64; 2]>,
    /// Where the scale of errors of `t` ends, scene units; not of any-hit sets.
    pub max_error: Option<f64>,
    /// What is right.
    pub truth: String,
    /// By point.
    pub points: Vec<PointPictures>,
}

/// Pictures of a point's answers.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct PointPictures {
    /// Its place among the record's points.
    pub point: usize,
    /// What it answered.
    pub answer: String,
    /// Every ray's class.
    pub class: String,
    /// By how much `t` is off; not of any-hit sets.
    pub error: Option<String>,
}

impl FrontScene {
    /// The files of its pictures, each once.
    pub fn picture_files(&self) -> BTreeSet<&str> {
        let mut files = BTreeSet::new();
        for set in &self.pictures {
            files.insert(set.truth.as_str());
            for PointPictures { answer, class, error, .. } in &set.points {
                files.extend([answer.as_str(), class]);
                files.extend(error.as_deref());
            }
        }
        files
    }
}

/// Where points were measured that were chosen elsewhere.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct HeldOutRecord {
    /// Seed of the ray sets there.
    pub seed: u64,
    /// The viewpoint.
    pub viewpoint: ViewpointRecord,
}

impl FrontPoint {
    /// Whether a row is this point's: it may follow something, or be seen from anywhere.
    pub fn is_of(&self, row: &Row) -> bool {
        row.tracer.name == self.tracer
            && row.tracer.parameters == self.parameters
            && (row.viewpoint.frame, row.viewpoint.face) == (self.frame, self.face)
    }

    /// The tracer with its preset unless it is the published one.
    pub fn config(&self) -> String {
        config(&self.tracer, &self.preset)
    }

    /// Tracer, preset and what it has otherwise than that, as `name=value`.
    pub fn label(&self) -> String {
        format!("{} {}", self.config(), values_label(&self.values)).trim_end().to_owned()
    }
}
