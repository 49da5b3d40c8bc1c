//! `run.json`: everything that a run measured. Every other file is derived from it.
//!
//! docs/results.md describes each field; the schema number changes whenever a field changes its meaning or goes.

mod judgement;
mod provenance;

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use tracebench_api::{ClockKind, EndPoint, MemoryEntry, PhaseSample, Query};

pub use judgement::{
    AnyJudgement, ByRule, Causes, Classes, ClosestJudgement, Headline, Judgement, Occlusion, Percentiles,
    SurfaceJudgement, WrongRay,
};
pub use provenance::{Machine, Provenance};

use crate::sweep::SweepRecord;

/// The schema that this program writes and reads.
pub const SCHEMA: u32 = 2;

/// A whole run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Run {
    /// [`SCHEMA`].
    pub schema: u32,
    /// Where, by which program and when; its fields stand among these.
    #[serde(flatten)]
    pub provenance: Provenance,
    /// Seed of the ray sets.
    pub seed: u64,
    /// Run preset: smoke, quick or paper. Figures of a smoke run only show that things work.
    pub preset: String,
    /// The table that the run was made for, if it was made for one.
    #[serde(default)]
    pub table: Option<String>,
    /// The sweep that the run is, if it is one.
    #[serde(default)]
    pub sweep: Option<SweepRecord>,
    /// What was said about ray sets: every parameter's value. Empty in files of before there were any.
    #[serde(default)]
    pub ray_parameters: BTreeMap<String, serde_json::Value>,
    /// The controls, in the form of runs.
    pub controls: Vec<TracerRun>,
    /// The contenders.
    pub runs: Vec<TracerRun>,
    /// What did not run, and why.
    pub skipped: Vec<Skipped>,
}

/// Something that was asked for and did not run.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Skipped {
    /// Tracer, `None` if it concerns all.
    pub tracer: Option<String>,
    /// Scene.
    pub scene: String,
    /// Ray set, `None` if it concerns all.
    pub rays: Option<String>,
    /// Why.
    pub reason: String,
}

/// One tracer on one scene from one viewpoint.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TracerRun {
    /// The scene.
    pub scene: SceneRecord,
    /// The viewpoint.
    pub viewpoint: ViewpointRecord,
    /// The tracer.
    pub tracer: TracerRecord,
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

/// A scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
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
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
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
        let mut label = self.name.clone();
        if self.preset != "published" && self.preset != "control" {
            label = format!("{label}:{}", self.preset);
        }
        for name in &self.changed {
            if let Some(value) = self.parameters.get(name) {
                let text = value.as_str().map_or_else(|| value.to_string(), str::to_owned);
                label = format!("{label} {name}={text}");
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

/// Samples of one kind of work, and what is made of them; its fields stand among those of what was timed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
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
    /// Whether the device's timestamps cannot be true, so that `clock` is `submit_to_done` instead.
    pub timestamps_refused: bool,
    /// Samples that were taken again because memory sized from counts had been too small; theirs is the second time. None
    /// in files of before there were such structures.
    #[serde(default)]
    pub grown_samples: u64,
}

/// Times of the builds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BuildRecord {
    /// Its times.
    #[serde(flatten)]
    pub times: Times,
    /// Creating pipelines and everything else that is made once, host clock; without the warm-up.
    pub setup_ms: f64,
}

/// A phase.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PhaseRecord {
    /// Name.
    pub name: String,
    /// Median over the samples.
    pub median_ms: f64,
    /// Every counted sample, in order.
    pub samples_ms: Vec<f64>,
}

impl PhaseRecord {
    /// Collects the phases of several samples of the same work, in order of first appearance. A phase that only some
    /// samples have, as the first refit after a build may, has as many samples as had it.
    pub fn collect(samples: &[Vec<PhaseSample>]) -> Vec<Self> {
        let mut records: Vec<Self> = Vec::new();
        for phases in samples {
            // Of phases of the same name within a sample the first is told from the second.
            let mut seen = vec![false; records.len()];
            for phase in phases {
                let place = (0..seen.len()).find(|place| !seen[*place] && records[*place].name == phase.name);
                let place = place.unwrap_or_else(|| {
                    records.push(Self { name: phase.name.clone(), median_ms: 0.0, samples_ms: Vec::new() });
                    seen.push(false);
                    seen.len() - 1
                });
                seen[place] = true;
                records[place].samples_ms.push(phase.duration_ms);
            }
        }
        for record in &mut records {
            record.median_ms = crate::statistics::median(&record.samples_ms);
        }
        records
    }
}

/// One ray set traced.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
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
    pub end: EndPoint,
    /// Its times.
    #[serde(flatten)]
    pub times: Times,
    /// Million rays a second at the median.
    pub mrays_per_s: f64,
    /// Allocated bytes of all parts of `per_trace`.
    pub per_trace_bytes: u64,
    /// What a trace takes: rays, hits, surfaces, and the tracer's own buffers by the names of its paper. Empty in files of
    /// before it was told by parts.
    #[serde(default)]
    pub per_trace: Vec<MemoryEntry>,
    /// Hash of the judged hits.
    pub hits_sha256: String,
    /// Counts, from a variant that is not timed.
    pub counters: BTreeMap<String, CounterRecord>,
    /// How many rays ended with which status.
    pub statuses: BTreeMap<String, u64>,
    /// The judge's verdict on the last timed output.
    pub judgement: Judgement,
    /// The verdict on its surfaces, where it has any.
    #[serde(default)]
    pub surfaces: Option<SurfaceJudgement>,
}

/// A count over a ray set.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CounterRecord {
    /// Over all rays.
    pub total: u64,
    /// Mean per ray.
    pub per_ray: f64,
    /// The largest of any one ray.
    pub greatest_per_ray: Option<u64>,
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Phases are collected by name and not by place: one that only the first sample has does not shift the others, and two
    /// of one name within a sample are told apart.
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
