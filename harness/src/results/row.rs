//! One tracer in one place: the row of every record, with its times and what the tracer answered to each ray set; and when two
//! rows are of the same thing, the one answer for every table, chart, verdict and comparison.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use tracebench_api::{ClockKind, MemoryEntry, PhaseSample, Query, TraceTo};

use super::{Judgement, SurfaceJudgement, gathered};

records! {
    /// One tracer on one scene from one viewpoint.
    pub struct Row {
        /// The scene.
        pub scene: SceneRecord,
        /// The viewpoint.
        pub viewpoint: ViewpointRecord,
        /// The tracer.
        pub tracer: TracerRecord,
        /// What it was made by: a hash of the sources of its tracer, of rays, truth and judge; none of rows of before there were any.
        pub fingerprint: Option<String> = default,
        /// How its structure was brought up to date, where it was not built.
        pub update_mode: Option<UpdateModeRecord> = default,
        /// The difficulty level of the case that its scene is, if it is one.
        pub difficulty_level: Option<f64> = default,
        /// In which turn of its place it was measured: configurations are interleaved within one.
        pub resident_batch: u32 = default,
        /// Which machine it was measured on, where the record was merged: its place among the provenance's.
        pub machine: u32 = default,
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

    /// How a structure was brought up to date. The row's `build` has the times of that.
    pub struct UpdateModeRecord {
        /// Name.
        pub name: String,
        /// Parameters that it sets, with their values.
        pub parameters: BTreeMap<String, serde_json::Value>,
    }

    /// A scene.
    #[derive(Default)]
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
    #[derive(Default)]
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
        pub ray_parameters: BTreeMap<String, serde_json::Value> = default,
    }

    /// A tracer with its parameters.
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

    /// One ray set traced.
    pub struct TraceRecord {
        /// Ray set.
        pub rays: String,
        /// Hash of the rays.
        pub rays_sha256: String,
        /// What was asked.
        pub query: Query,
        /// Number of rays.
        pub count: u64,
        /// How far it went.
        pub trace_to: TraceTo,
        /// Its times.
        #[serde(flatten)]
        pub times: Times,
        /// Million rays a second at the median; 0 where nothing was timed and where times are invalid.
        pub mrays_per_s: f64,
        /// Allocated bytes of all parts of `per_trace`.
        pub per_trace_bytes: u64,
        /// What a trace takes: rays, hits, surfaces, and the tracer's own buffers by the names of its paper. Empty in files of
        /// before it was told by parts.
        #[serde(default)]
        pub per_trace: Vec<MemoryEntry>,
        /// Hash of the judged hits.
        pub hits_sha256: String,
        /// Rays that were answered as by the first row of the same tracer in the interleaved set: both miss, or both hit at a t that `tight` takes
        /// for the same. None of that first row, and in files of before it was told.
        pub same_as_first: Option<u64> = default,
        /// Counts, from a variant that is not timed.
        pub counters: BTreeMap<String, CounterRecord>,
        /// How many rays ended with which status.
        pub statuses: BTreeMap<String, u64>,
        /// The judge's verdict on the last timed output.
        pub judgement: Judgement,
        /// The verdict on its surfaces, where it has any.
        pub surfaces: Option<SurfaceJudgement>,
        /// Times that a program which is no tracer of this suite tells of itself.
        pub self_reported: Option<SelfReported> = default,
    }

    /// Times that a program tells of itself: a column beside what was judged, never a verdict.
    #[derive(Default)]
    #[serde(deny_unknown_fields)]
    pub struct SelfReported {
        /// Building its structure, milliseconds.
        pub build_ms: Option<f64> = default,
        /// Tracing all rays, milliseconds.
        pub trace_ms: Option<f64> = default,
    }

    /// A count over a ray set.
    pub struct CounterRecord {
        /// Over all rays.
        pub total: u64,
        /// Mean per ray.
        pub per_ray: f64,
        /// The largest of any one ray.
        pub max_per_ray: Option<u64>,
    }

    /// Samples of one kind of work, and what is made of them; its fields stand among those of what was timed.
    pub struct Times {
        /// Which clock.
        pub clock: ClockKind,
        /// Every counted sample, in order.
        pub samples_ms: Vec<f64>,
        /// Their median.
        pub median_ms: f64,
        /// Order-statistic interval of the median.
        pub interval_ms: [f64; 2],
        /// Probability that the interval covers the median of the distribution.
        pub interval_coverage: f64,
        /// Phases in order.
        pub phases: Vec<PhaseRecord>,
        /// The same samples by the host's clock round the submission, their median; of work on the host nothing.
        pub submit_to_done_median_ms: Option<f64>,
        /// These samples. Empty in files of before they were kept.
        pub submit_to_done_samples_ms: Vec<f64> = default,
        /// Whether the device's timestamps cannot be true, so that `clock` is `submit_to_done` instead.
        pub timestamps_refused: bool,
        /// Samples that were taken again because memory sized from counts had been too small; theirs is the second time. None
        /// in files of before there were such structures.
        #[serde(default)]
        pub grown_samples: u64,
        /// The interleaved set that they were taken in: its place in the record's. None where nothing was timed, and in files of before
        /// interleaved sets were told of.
        pub interleaved_set: Option<u32> = default,
        /// Why they may not be believed, whatever else of the row may.
        pub invalid: Option<String> = default,
        /// By what they were multiplied to be as in the first resident batch ([`Record::aligned`](super::Record::aligned)); never kept.
        #[serde(skip)]
        pub anchor_scale: Option<f64>,
    }

    /// Times of the builds, or of the updates of a row that follows an animation.
    pub struct BuildRecord {
        /// The phases that the tracer marks, of first builds or of updates.
        #[serde(flatten)]
        pub times: Times,
        /// First builds, from the call until the device is idle, host clock. None of updates, and in files of before rules version 3.
        pub first: Option<Box<Times>> = default,
        /// Steady builds, each a rebuild in the memory of the first one before it, or updates; in the same scope by the same clock. None in
        /// files of before rules version 3.
        pub steady: Option<Box<Times>> = default,
        /// Creating pipelines and everything else that is made once, host clock; without the warm-up.
        pub setup_ms: f64,
    }

    /// A phase.
    pub struct PhaseRecord {
        /// Name.
        pub name: String,
        /// Median over the samples.
        pub median_ms: f64,
        /// Every counted sample, in order.
        pub samples_ms: Vec<f64>,
    }
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

/// The same scene seen from the same eye at the same time, whatever the resolutions.
pub fn same_pose(a: &Row, b: &Row) -> bool {
    a.scene.name == b.scene.name
        && a.scene.sha256 == b.scene.sha256
        && (a.viewpoint.eye, a.viewpoint.forward) == (b.viewpoint.eye, b.viewpoint.forward)
        && a.viewpoint.time_s == b.viewpoint.time_s
        && a.difficulty_level == b.difficulty_level
}

/// The same rays for the same names: [`same_pose`] with the same camera, ray image and words about the sets. Frame and faces shape
/// structures, not rays.
pub fn same_place(a: &Row, b: &Row) -> bool {
    same_pose(a, b)
        && a.viewpoint.name == b.viewpoint.name
        && a.viewpoint.up == b.viewpoint.up
        && a.viewpoint.vertical_fov_degrees == b.viewpoint.vertical_fov_degrees
        && a.viewpoint.ray_image == b.viewpoint.ray_image
        && a.viewpoint.ray_parameters == b.viewpoint.ray_parameters
}

/// The same work in two records: the same tracer with the same parameters over the same triangles from the same viewpoint,
/// brought there in the same way. Names of scenes and viewpoints, presets and labels are names and do not count.
pub fn same_work(a: &Row, b: &Row) -> bool {
    let unnamed = |viewpoint: &ViewpointRecord| ViewpointRecord { name: String::new(), ..viewpoint.clone() };
    a.scene.sha256 == b.scene.sha256
        && a.tracer.name == b.tracer.name
        && a.tracer.parameters == b.tracer.parameters
        && unnamed(&a.viewpoint) == unnamed(&b.viewpoint)
        && a.update_mode == b.update_mode
        && a.difficulty_level == b.difficulty_level
}

/// The same question: the same rays by name and content, asked for the same, to the same end.
pub fn same_rays(a: &TraceRecord, b: &TraceRecord) -> bool {
    a.rays == b.rays
        && a.rays_sha256 == b.rays_sha256
        && a.query == b.query
        && a.trace_to == b.trace_to
        && a.count == b.count
}

impl BuildRecord {
    /// What it takes to have the structure where there was none: the first build, of updates the update, and in files of before these
    /// were told the phases.
    pub fn first(&self) -> &Times {
        self.first.as_deref().unwrap_or_else(|| self.steady())
    }

    /// What it takes to have it once more: the steady build or the update, and in files of before these were told the phases.
    pub fn steady(&self) -> &Times {
        self.steady.as_deref().unwrap_or(&self.times)
    }

    /// All its times.
    pub fn all(&self) -> impl Iterator<Item = &Times> {
        [Some(&self.times), self.first.as_deref(), self.steady.as_deref()].into_iter().flatten()
    }

    /// All its times, to change.
    pub fn all_mut(&mut self) -> impl Iterator<Item = &mut Times> {
        [Some(&mut self.times), self.first.as_deref_mut(), self.steady.as_deref_mut()].into_iter().flatten()
    }
}

/// A time as records keep it, to whole nanoseconds: no clock here tells less, and digits beyond are a tenth of a record.
pub(crate) fn whole_ns(ms: f64) -> f64 {
    (ms * 1e6).round() / 1e6
}

impl PhaseRecord {
    /// Collects the phases of several samples of the same work, in order of first appearance. A phase that only some
    /// samples have, as the first refit after a build may, has as many samples as had it.
    pub fn collect(samples: &[Vec<PhaseSample>]) -> Vec<Self> {
        let phases = samples.iter().flat_map(|phases| {
            phases.iter().enumerate().map(move |(place, phase)| {
                // Of phases of the same name within a sample the first is told from the second.
                let before = phases[..place].iter().filter(|other| other.name == phase.name).count();
                ((&phase.name, before), whole_ns(phase.duration_ms))
            })
        });
        let record = |((name, _), samples_ms): ((&String, usize), Vec<f64>)| {
            let median_ms = crate::statistics::median(&samples_ms);
            Self { name: name.clone(), median_ms, samples_ms }
        };
        gathered(phases).into_iter().map(record).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Phases are collected by name and not by place: one that only the first sample has does not shift the others, and two
    /// of one name within a sample are distinguished.
    #[test]
    fn phases_that_come_and_go_are_kept_apart() {
        let sample = |phases: &[(&str, f64)]| {
            let phase = |&(name, duration_ms): &(&str, f64)| PhaseSample { name: name.to_owned(), duration_ms };
            phases.iter().map(phase).collect::<Vec<_>>()
        };
        let samples = [
            sample(&[("read back", 9.0), ("fit", 1.0), ("fit", 5.0)]),
            sample(&[("fit", 2.0), ("fit", 6.0)]),
            sample(&[("fit", 3.0), ("fit", 7.0), ("build", 4.0)]),
        ];
        let found: Vec<_> = PhaseRecord::collect(&samples)
            .into_iter()
            .map(|phase| (phase.name, phase.median_ms, phase.samples_ms))
            .collect();
        let expected = [
            ("read back", 9.0, vec![9.0]),
            ("fit", 2.0, vec![1.0, 2.0, 3.0]),
            ("fit", 6.0, vec![5.0, 6.0, 7.0]),
            ("build", 4.0, vec![4.0]),
        ];
        assert_eq!(found, expected.map(|(name, median, samples)| (name.to_owned(), median, samples)));
        assert!(PhaseRecord::collect(&[]).is_empty());
    }
}
