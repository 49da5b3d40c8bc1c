//! What a record says of frames: what moved, and for every tracer a row a frame.

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};
use tracebench_api::ClockKind;

use super::{SceneRecord, TracerRecord, ViewpointRecord, is_default};

/// The oracle with t rounded to f32: what its image differs in no exact tracer can avoid.
pub const ROUNDED_ORACLE: &str = "oracle-f32";

/// What `validate` calls the cost of a hierarchy by the surface area heuristic.
pub const SAH_COST: &str = "sah_cost";

/// Frames of moving scenes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FramesRecord {
    /// Frames of every scene.
    pub frames: u32,
    /// Frames a second.
    pub fps: f64,
    /// Width and height of images and of the image that rays start from, pixels.
    pub size: [u32; 2],
    /// Samples a pixel; 1 of ray sets.
    pub spp: u32,
    /// What moves: `geometry`, `camera` or `both`.
    pub moves: String,
    /// How structures are brought up to date: `auto`, `rebuild`, `refit` or `reuse`.
    pub update: String,
    /// Whose hits paths go on from: `own` or `truth`.
    pub paths: String,
    /// The frame from which on the camera is at the second pose.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cut: Option<u32>,
    /// Whether every frame has the world rays of the first, judged from its eye.
    #[serde(default, skip_serializing_if = "is_default")]
    pub fixed_rays: bool,
    /// Effects, or ray sets.
    pub works: Vec<String>,
    /// Whether the works are effects.
    pub effects: bool,
    /// The scenes.
    pub scenes: Vec<MovingScene>,
    /// A tracer or a control in a scene, in the order of the plan; controls first.
    pub rows: Vec<FrameSeries>,
}

/// A scene that was followed.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MovingScene {
    /// It at the first frame.
    pub scene: SceneRecord,
    /// Where the camera's way comes from.
    pub path: String,
    /// By frame its hash.
    pub scene_sha256: Vec<String>,
    /// By frame the viewpoint, with the animation time.
    pub viewpoints: Vec<ViewpointRecord>,
    /// Surface points with fixed directions that flicker is told by.
    pub points: u64,
    /// What of the materials is ignored.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub notes: Vec<String>,
    /// By effect the pictures of the truth.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub pictures: BTreeMap<String, FramePictures>,
}

/// Files in `pictures/`, named after the beginning of their hash.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct FramePictures {
    /// All frames of the answer, side by side in rows of [`FramePictures::columns`], each above the picture of its error; of the truth without.
    pub sheet: String,
    /// Frames in a row of the sheet.
    pub columns: u32,
    /// The answer as an animated PNG.
    pub animation: String,
}

/// The frames of a tracer, or of a control, in a scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FrameSeries {
    /// The scene's place in [`FramesRecord::scenes`].
    pub scene: u32,
    /// The tracer.
    pub tracer: TracerRecord,
    /// A hash of the sources that made it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fingerprint: Option<String>,
    /// Which machine it was measured on, where the record was merged.
    #[serde(default, skip_serializing_if = "is_default")]
    pub machine: u32,
    /// Its interleaved set; none of controls.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub interleaved_set: Option<u32>,
    /// The clock of its traces.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub clock: Option<ClockKind>,
    /// By frame.
    pub frames: Vec<FrameRow>,
    /// By effect its pictures.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub pictures: BTreeMap<String, FramePictures>,
    /// Of fixed rays, by ray set, those that are answered rightly in some frames and wrongly in others.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub changing: BTreeMap<String, u64>,
}

/// A frame of a tracer.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FrameRow {
    /// What was done to its structure: `build`, `rebuild`, `refit` or `reuse`; empty of controls.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub update: String,
    /// What has moved since it was built and makes it stale: `geometry`, `viewpoint`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub stale_by: Vec<String>,
    /// How long that took by the host's clock, with growth, milliseconds; 0 of a reuse.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub update_ms: Option<f64>,
    /// Whether memory had to grow.
    #[serde(default, skip_serializing_if = "is_default")]
    pub grown: bool,
    /// Cost of a hierarchy by the surface area heuristic, of methods that are refitted.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sah_cost: Option<f64>,
    /// Allocated bytes of the structure.
    #[serde(default)]
    pub structure_bytes: u64,
    /// The most held at once while it was last built.
    #[serde(default)]
    pub build_peak_bytes: u64,
    /// Pairs of surface points seen in this frame and the last, and those of them whose answers turned from right to wrong or back.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub turned: Option<[u64; 2]>,
    /// By effect or ray set.
    pub works: BTreeMap<String, WorkRow>,
}

/// An effect, or a ray set, in a frame.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct WorkRow {
    /// What was traced, the first wave first.
    pub waves: Vec<WaveRow>,
    /// The image beside the reference.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub image: Option<ImageRow>,
}

/// An image beside its reference, both as 8-bit sRGB in [0, 1].
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ImageRow {
    /// Mean squared error over pixels and channels.
    pub mse: f64,
    /// Peak signal-to-noise ratio, dB; none where they are equal.
    pub psnr_db: Option<f64>,
    /// Structural similarity of luma as image-compare has it: windows of 8x8 pixels side by side, sums for variances; 1 is equal.
    pub ssim: f64,
    /// Mean FLIP: 0 is equal, 1 the most. None of depth and normals.
    pub flip: Option<f64>,
    /// Pixels with a channel that is off by more than 1/255.
    pub beyond: u64,
    /// These by the first wave whose answers differ, `none` where no answer does.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub beyond_by_wave: BTreeMap<String, u64>,
    /// Mean change of the error since the last frame, along the motion; none where nothing moves on: at the first frame and at a cut.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub flicker: Option<f64>,
}

/// Rays that were traced at once.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct WaveRow {
    /// Its name.
    pub name: String,
    /// Its rays.
    pub rays: u64,
    /// How long they took, milliseconds; none of controls.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub trace_ms: Option<f64>,
    /// How many of its rays were judged: all of them, or every so manieth where paths go on from a tracer's own hits.
    pub judged: u64,
    /// How many of these are right under `hit_miss`, `tight` and `footprint`; three times the same of any-hit rays.
    pub right: [u64; 3],
    /// Of ray sets a hash of the rays, of the hits, and counts.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub answers: Option<AnswersRow>,
}

/// What is told of ray sets.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct AnswersRow {
    /// Hash of the rays.
    pub rays_sha256: String,
    /// Hash of the hits.
    pub hits_sha256: String,
    /// Counts by a variant that is not timed.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub counters: BTreeMap<String, u64>,
    /// Of fixed rays: how many were judged in this frame and the last, and how many of these turned.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub turned: Option<[u64; 2]>,
}

impl FrameSeries {
    /// Whether it is of a control.
    pub fn is_control(&self) -> bool {
        self.tracer.preset == "control"
    }
}

impl FrameRow {
    /// Milliseconds of the update and of all waves of a work; none where one has no time.
    pub fn ms(&self, work: &str) -> Option<f64> {
        let waves: f64 = self.works.get(work)?.waves.iter().map(|wave| wave.trace_ms).sum::<Option<f64>>()?;
        Some(self.update_ms? + waves)
    }
}

impl FramesRecord {
    /// The files of its pictures, each once.
    pub fn picture_files(&self) -> BTreeSet<&str> {
        let of_scenes = self.scenes.iter().flat_map(|scene| scene.pictures.values());
        let all = of_scenes.chain(self.rows.iter().flat_map(|row| row.pictures.values()));
        all.flat_map(|pictures| [pictures.sheet.as_str(), &pictures.animation]).collect()
    }
}
