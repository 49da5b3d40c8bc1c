//! What a record says of frames: what moved, and for every tracer a row a frame.

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};
use tracebench_api::ClockKind;

use super::{SceneRecord, TracerRecord, ViewpointRecord};

/// The oracle with t rounded to f32: what its image differs in no exact tracer can avoid.
pub const ROUNDED_ORACLE: &str = "oracle-f32";

/// What `validate` calls the cost of a hierarchy by the surface area heuristic.
pub const SAH_COST: &str = "sah_cost";

records! {
    /// Frames of moving scenes.
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
        pub cut: Option<u32> = default,
        /// Whether every frame has the world rays of the first, judged from its eye.
        pub fixed_rays: bool = default,
        /// Effects, or ray sets.
        pub works: Vec<String>,
        /// Whether the works are effects.
        pub effects: bool,
        /// The scenes.
        pub scenes: Vec<MovingScene>,
        /// A tracer or a control in a scene with an effect, or with all ray sets, in the order of the plan; controls first.
        pub rows: Vec<FrameSeries>,
    }

    /// A scene that was followed.
    #[derive(Default)]
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
        pub notes: Vec<String> = default,
        /// By effect the pictures of the truth.
        pub pictures: BTreeMap<String, FramePictures> = default,
    }

    /// Files in `pictures/`, named after the beginning of their hash.
    #[derive(Eq)]
    pub struct FramePictures {
        /// All frames of the answer, side by side in rows of [`FramePictures::columns`], each above the picture of its error; of the truth without.
        pub sheet: String,
        /// Frames in a row of the sheet.
        pub columns: u32,
        /// The answer as an animated PNG.
        pub animation: String,
    }

    /// The frames of a tracer, or of a control, in a scene.
    pub struct FrameSeries {
        /// The scene's place in [`FramesRecord::scenes`].
        pub scene: u32,
        /// The tracer.
        pub tracer: TracerRecord,
        /// A hash of the sources that made it.
        pub fingerprint: Option<String> = default,
        /// Which machine it was measured on, where the record was merged.
        pub machine: u32 = default,
        /// Its interleaved set; none of controls.
        pub interleaved_set: Option<u32> = default,
        /// The clock of its traces: the host's.
        pub clock: Option<ClockKind> = default,
        /// Why its traces have no times, where their clock has failed its control.
        pub invalid: Option<String> = default,
        /// Of an exact tracer's images: whether none differs from the truth by more than rounding does ([`ImageRow::is_beyond`]), frames with stale
        /// structures aside.
        pub floor_holds: Option<bool> = default,
        /// By frame.
        pub frames: Vec<FrameRow>,
        /// By effect its pictures.
        pub pictures: BTreeMap<String, FramePictures> = default,
        /// Of fixed rays, by ray set, those that are answered rightly in some frames and wrongly in others.
        pub changing: BTreeMap<String, u64> = default,
    }

    /// A frame of a tracer.
    #[derive(Default)]
    pub struct FrameRow {
        /// What was done to its structure: `build`, `rebuild`, `refit` or `reuse`; empty of controls.
        pub update: String = default,
        /// What has moved since it was built and makes it stale: `geometry`, `viewpoint`.
        pub stale_by: Vec<String> = default,
        /// How long that took by the host's clock, with growth, milliseconds; 0 of a reuse.
        pub update_ms: Option<f64> = default,
        /// Whether memory had to grow.
        pub grown: bool = default,
        /// Cost of a hierarchy by the surface area heuristic, of methods that are refitted.
        pub sah_cost: Option<f64> = default,
        /// Allocated bytes of the structure.
        #[serde(default)]
        pub structure_bytes: u64,
        /// The most held at once while it was last built.
        #[serde(default)]
        pub build_peak_bytes: u64,
        /// Pairs of surface points seen in this frame and the last, and those of them whose answers turned from right to wrong or back.
        pub turned: Option<[u64; 2]> = default,
        /// By effect or ray set.
        pub works: BTreeMap<String, WorkRow>,
    }

    /// An effect, or a ray set, in a frame.
    #[derive(Default)]
    pub struct WorkRow {
        /// What was traced, the first wave first.
        pub waves: Vec<WaveRow>,
        /// The image beside the reference.
        pub image: Option<ImageRow> = default,
    }

    /// An image beside its reference, both as 8-bit sRGB in [0, 1].
    #[derive(Default)]
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
        pub beyond_by_wave: BTreeMap<String, u64> = default,
        /// Mean change of the error since the last frame, along the motion; none where nothing moves on: at the first frame and at a cut.
        pub flicker: Option<f64> = default,
    }

    /// Rays that were traced at once.
    #[derive(Default)]
    pub struct WaveRow {
        /// Its name.
        pub name: String,
        /// Its rays.
        pub rays: u64,
        /// How long they took by the host's clock, milliseconds; none of controls.
        pub trace_ms: Option<f64> = default,
        /// How many of its rays were judged: all of them, or every so manieth where paths go on from a tracer's own hits.
        pub judged: u64,
        /// How many of these are right under `hit_miss`, `tight` and `footprint`; three times the same of any-hit rays.
        pub right: [u64; 3],
        /// Of ray sets a hash of the rays, of the hits, and counts.
        pub answers: Option<AnswersRow> = default,
    }

    /// What is told of ray sets.
    #[derive(Default)]
    pub struct AnswersRow {
        /// Hash of the rays.
        pub rays_sha256: String,
        /// Hash of the hits.
        pub hits_sha256: String,
        /// Counts by a variant that is not timed.
        pub counters: BTreeMap<String, u64> = default,
        /// Of fixed rays: how many were judged in this frame and the last, and how many of these turned.
        pub turned: Option<[u64; 2]> = default,
    }
}

impl FrameSeries {
    /// Whether it is of a control.
    pub fn is_control(&self) -> bool {
        self.tracer.preset == "control"
    }

    /// Whether the sources that made it are those of this program.
    pub fn is_of_this_version(&self) -> bool {
        self.fingerprint.as_deref() == crate::machine::fingerprint(&self.tracer.name)
    }
}

impl FrameRow {
    /// Milliseconds of the update and of all waves of a work; none where one has no time.
    pub fn ms(&self, work: &str) -> Option<f64> {
        let waves: f64 = self.works.get(work)?.waves.iter().map(|wave| wave.trace_ms).sum::<Option<f64>>()?;
        Some(self.update_ms? + waves)
    }
}

impl ImageRow {
    /// Whether more pixels are beyond 1/255 than rounding explains: than twice those of [`ROUNDED_ORACLE`] in the same frame, and 0.02 % of all.
    pub fn is_beyond(&self, rounded: &Self, [width, height]: [u32; 2]) -> bool {
        self.beyond as f64 > 2.0 * rounded.beyond as f64 + 2e-4 * f64::from(width) * f64::from(height)
    }
}

impl FramesRecord {
    /// Which exact tracers differ from the truth by more than rounding does, if some do: `frames` fails with it.
    pub fn fault(&self) -> Option<String> {
        let told = |row: &FrameSeries| {
            let work = row.frames.iter().find_map(|row| row.works.keys().next()).map_or("", String::as_str);
            format!("{} with {work} in {}", row.tracer.label(), self.scenes[row.scene as usize].scene.name)
        };
        let beyond = self.rows.iter().filter(|row| row.floor_holds == Some(false)).map(told);
        let beyond = beyond.collect::<Vec<_>>().join("; ");
        let what = "images of exact tracers differ from the truth by more than rounding explains";
        (!beyond.is_empty()).then(|| format!("{what}: {beyond}"))
    }

    /// The files of its pictures, each once.
    pub fn picture_files(&self) -> BTreeSet<&str> {
        let of_scenes = self.scenes.iter().flat_map(|scene| scene.pictures.values());
        let all = of_scenes.chain(self.rows.iter().flat_map(|row| row.pictures.values()));
        all.flat_map(|pictures| [pictures.sheet.as_str(), &pictures.animation]).collect()
    }
}
