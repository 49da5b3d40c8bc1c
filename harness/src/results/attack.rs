//! Where tracers are wrong the most: what a search for such poses adds to the rows from these poses.

use serde::{Deserialize, Serialize};
use tracebench_api::Query;

use super::{Accuracy, OCCLUSION, Record, Rule, TraceRecord, TracerRecord};

/// The worst that searches found.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AttackRecord {
    /// The rule by which rays are wrong.
    pub rule: Rule,
    /// Width and height of the image from whose pixels a trial's rays start.
    pub trial_image: [u32; 2],
    /// By scene the name of its own viewpoint, of which every tracer has a row, too.
    pub viewpoints: Vec<[String; 2]>,
    /// A search a scene, tracer and ray set.
    pub searches: Vec<SearchRecord>,
}

/// A search.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SearchRecord {
    /// The scene.
    pub scene: String,
    /// The tracer.
    pub tracer: TracerRecord,
    /// The ray set.
    pub rays: String,
    /// Poses that were tried, and as many random ones.
    pub trials: u64,
    /// Hash of all trials in their order.
    pub trials_sha256: String,
    /// The worst poses that were found, the worst first: of different climbs.
    pub found: Vec<PoseRecord>,
    /// The worst of the random ones.
    pub random: PoseRecord,
    /// The worst pose's wrong rays made small.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shrunk: Option<ShrunkRecord>,
}

/// A pose with what its trial gave; what fresh rays gave is in the row of its viewpoint.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PoseRecord {
    /// Name of the viewpoint in its row.
    pub viewpoint: String,
    /// The pose as `--view` takes it.
    pub view: String,
    /// Animation time, seconds.
    pub time_s: f64,
    /// Scale of the procedural scene.
    pub scale: Option<f64>,
    /// Number of the trial, from 0.
    pub trial: u64,
    /// Rays of the trial that were wrong.
    pub wrong: u64,
    /// Rays of the trial that could be.
    pub judged: u64,
    /// The classes of its fresh rays as a picture: a file beside the record.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub picture: Option<String>,
}

/// Few rays in few triangles that are wrong for the same cause.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ShrunkRecord {
    /// The cause: that of most wrong rays from the pose.
    pub cause: String,
    /// Rays that are left.
    pub rays: u64,
    /// Triangles that are left.
    pub triangles: u64,
    /// Triangles beside them that keep the bounds.
    pub markers: u64,
    /// The command that traces them, from the folder of the record.
    pub command: String,
}

impl SearchRecord {
    /// The trace of its rays in the row of a viewpoint.
    pub fn trace<'r>(&self, record: &'r Record, viewpoint: &str) -> Option<&'r TraceRecord> {
        let own = (&self.tracer, self.scene.as_str(), viewpoint);
        let rows = record.rows.iter().filter(|row| (&row.tracer, &*row.scene.name, &*row.viewpoint.name) == own);
        rows.flat_map(|row| &row.traces).find(|trace| trace.rays == self.rays)
    }
}

impl AttackRecord {
    /// The name of the viewpoint of a scene that every tracer has a row of.
    pub fn viewpoint_of(&self, scene: &str) -> &str {
        self.viewpoints.iter().find(|[name, _]| name == scene).map_or("", |[_, viewpoint]| viewpoint)
    }

    /// The pictures that it names.
    pub fn picture_files(&self) -> impl Iterator<Item = &str> {
        let poses = self.searches.iter().flat_map(|search| search.found.iter().chain([&search.random]));
        poses.filter_map(|pose| pose.picture.as_deref())
    }

    /// How often answers are right by the rule; of any-hit rays, which have no rule, the balanced accuracy.
    pub fn accuracy(&self, trace: &TraceRecord) -> Option<Accuracy> {
        let all = trace.judgement.accuracies(trace.count - trace.judgement.left_out());
        let place = if trace.query == Query::Any { 0 } else { self.rule as usize };
        all.get(place).copied()
    }

    /// The causes of wrong answers by the rule; of `hit_miss`, which has none of its own, those by `tight`.
    pub fn causes(&self, trace: &TraceRecord) -> Vec<(String, u64)> {
        let rule = match (trace.query, self.rule) {
            (Query::Any, _) => OCCLUSION,
            (_, Rule::HitMiss) => Rule::Tight.name(),
            (_, rule) => rule.name(),
        };
        let found = trace.judgement.causes().get(rule).into_iter().flatten();
        let mut causes: Vec<(String, u64)> = found.map(|(cause, rays)| (cause.clone(), *rays)).collect();
        causes.sort_by_key(|(_, rays)| std::cmp::Reverse(*rays));
        causes
    }
}
