//! What studies add to the rows of a record: sweeps and tunings, Pareto fronts, needs, searches for the worst poses, explanations. What
//! follows from rows and sections, such as values that would be chosen, fronts, operating points and how far structures may shrink, is
//! derived.

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};
use tracebench_api::Query;

use super::{Accuracy, OCCLUSION, Record, Row, Rule, SceneRecord, TraceRecord, TracerRecord, ViewpointRecord, config};

records! {
    /// A sweep.
    pub struct SweepRecord {
        /// The tracer.
        pub tracer: String,
        /// Whether all values of the parameters were combined, rather than one changed at a time.
        pub grid: bool,
        /// What was swept.
        pub axes: Vec<AxisRecord>,
        /// What was asked for, each once. The first one has every axis at the tracer's own value.
        pub points: Vec<PointRecord>,
    }

    /// A parameter that was swept, or `resolution`.
    #[derive(Eq)]
    pub struct AxisRecord {
        /// Name.
        pub name: String,
        /// Unit; empty for names and pure numbers.
        pub unit: String,
        /// What it does, in one line.
        pub effect: String,
        /// The tracer's own value: the preset's, or what `--set` says.
        pub own: String,
        /// Every value in order, the own one among them.
        pub values: Vec<String>,
    }

    /// A point.
    pub struct PointRecord {
        /// The value on every axis, by its name.
        pub values: BTreeMap<String, String>,
        /// Every parameter of the tracer.
        pub parameters: BTreeMap<String, serde_json::Value>,
        /// Width and height of the viewpoint's frame, pixels.
        pub frame: [u32; 2],
        /// Edge of the viewpoint's cube faces, pixels.
        pub face: u32,
        /// Scenes in which it could not be measured, with the reason.
        pub skipped: BTreeMap<String, String>,
    }

    /// A parameter of a tracer, tuned.
    pub struct TuningRecord {
        /// The tracer with its default values.
        pub tracer: TracerRecord,
        /// The rule by which values are chosen; of any-hit sets it is balanced accuracy, whatever stands here.
        pub rule: Rule,
        /// The scenes.
        pub scenes: Vec<TunedScene>,
    }

    /// One scene.
    pub struct TunedScene {
        /// The scene.
        pub scene: SceneRecord,
        /// The own viewpoint, then another, if there is one.
        pub viewpoints: Vec<ViewpointRecord>,
    }
}

/// Whether a row has these parameters and resolutions.
fn is_at(row: &Row, parameters: &BTreeMap<String, serde_json::Value>, frame: [u32; 2], face: u32) -> bool {
    row.tracer.parameters == *parameters && (row.viewpoint.frame, row.viewpoint.face) == (frame, face)
}

impl PointRecord {
    /// Whether a run is this point's.
    pub fn is_of(&self, row: &Row) -> bool {
        is_at(row, &self.parameters, self.frame, self.face)
    }

    /// What it has on the axes as `name=value`, without those where it has the tracer's own.
    pub fn label(&self, axes: &[AxisRecord]) -> String {
        let value = |axis: &AxisRecord| self.values.get(&axis.name).filter(|value| **value != axis.own).cloned();
        let parts = axes.iter().filter_map(|axis| Some(format!("{}={}", axis.name, value(axis)?)));
        parts.collect::<Vec<_>>().join(" ")
    }
}

impl SweepRecord {
    /// The point with a value on one axis, and with `others` on some further ones; the tracer's own value on the rest.
    pub fn point(&self, axis: &str, value: &str, others: &[(&str, &str)]) -> Option<&PointRecord> {
        let wanted = |each: &AxisRecord| {
            let other = others.iter().find(|(name, _)| *name == each.name).map(|(_, value)| *value);
            if each.name == axis { value.to_owned() } else { other.unwrap_or(&each.own).to_owned() }
        };
        self.points.iter().find(|point| {
            self.axes.iter().all(|each| point.values.get(&each.name).is_some_and(|value| *value == wanted(each)))
        })
    }
}

/// What a scene seen from one of its viewpoints is called where a point is skipped.
pub fn place_name(scene: &SceneRecord, viewpoint: &ViewpointRecord, view: usize) -> String {
    if view == 0 { scene.name.clone() } else { format!("{} from {}", scene.name, viewpoint.name) }
}

/// The way of rows that were refitted to vertices that stand still, for what a refit takes.
pub const STILL_REFIT: &str = "refit, standing still";

records! {
    /// Points of several tracers, for fronts.
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
    #[derive(Default)]
    pub struct FrontScene {
        /// The scene.
        pub scene: SceneRecord,
        /// The viewpoint from which all points were measured; points are chosen by what they do here.
        pub viewpoint: ViewpointRecord,
        /// Where the chosen ones were measured again.
        pub held_out: Option<HeldOutRecord>,
        /// Why they were not.
        pub held_out_skipped: Option<String> = default,
        /// Further ray images, from which chosen points were traced for what a ray takes beside what a trace does.
        pub ray_images: Vec<[u32; 2]>,
        /// What points on fronts answer, by ray set; none in older records.
        pub pictures: Vec<SetPictures> = default,
    }

    /// Pictures of a ray set: names of files in [`PICTURES_FOLDER`], each named by its hash.
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

    /// Where points were measured that were chosen elsewhere.
    pub struct HeldOutRecord {
        /// Seed of the ray sets there.
        pub seed: u64,
        /// The viewpoint.
        pub viewpoint: ViewpointRecord,
    }
}

/// The folder beside a record that holds its pictures.
pub const PICTURES_FOLDER: &str = "pictures";

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
        let points = self.pictures.iter().flat_map(|set| &set.points);
        let of_points = points.flat_map(|of| [Some(&of.answer), Some(&of.class), of.error.as_ref()]).flatten();
        self.pictures.iter().map(|set| &set.truth).chain(of_points).map(String::as_str).collect()
    }
}

impl FrontPoint {
    /// Whether a row is this point's: it may follow something, or be seen from anywhere.
    pub fn is_of(&self, row: &Row) -> bool {
        row.tracer.name == self.tracer && is_at(row, &self.parameters, self.frame, self.face)
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

records! {
    /// Structures shrunk until answers get worse.
    pub struct NeedRecord {
        /// A structure is too small when the upper end of the interval of newly wrong less newly right rays is beyond this share.
        pub max_lost_share: f64,
        /// By the second measure also when its traces take more times as long than this.
        pub max_slowdown: f64,
        /// A curve a scene, viewpoint and tracer.
        pub curves: Vec<NeedCurve>,
    }

    /// A tracer in one place.
    pub struct NeedCurve {
        /// The scene.
        pub scene: String,
        /// Its hash.
        pub scene_sha256: String,
        /// The viewpoint.
        pub viewpoint: String,
        /// Which of the scene's viewpoints that is: 0 for the own one, 1 for another.
        pub view: u32,
        /// The tracer.
        pub tracer: String,
        /// Its preset.
        pub preset: String,
        /// The rule by which closest hits are right or wrong: `tight` of analytic methods, `footprint` of those that sample.
        pub rule: Rule,
        /// Its structures, first as it was asked for, then every step of every axis, then several axes at once.
        pub points: Vec<NeedPoint>,
    }

    /// A structure, shrunk or not.
    pub struct NeedPoint {
        /// What is shrunk, by axis: nothing of the first point, one axis of a step.
        pub shrunk: BTreeMap<String, String>,
        /// Every parameter of the tracer.
        pub parameters: BTreeMap<String, serde_json::Value>,
        /// Width and height of the viewpoint's frame, pixels.
        pub frame: [u32; 2],
        /// Edge of the viewpoint's cube faces, pixels.
        pub face: u32,
        /// Why it could not be measured.
        pub skipped: Option<String> = default,
        /// By ray set: how its answers differ from those of the first point.
        pub changed: BTreeMap<String, ChangedRays>,
    }
}

/// The same rays answered by two structures.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct ChangedRays {
    /// Rays without ambiguous rays.
    pub rays: u64,
    /// Rays that the first structure answers rightly and this one wrongly.
    pub newly_wrong: u64,
    /// Rays that the first structure answers wrongly and this one rightly.
    pub newly_right: u64,
}

/// Values by axis, as `name=value`.
pub fn values_label(values: &BTreeMap<String, String>) -> String {
    values.iter().map(|(name, value)| format!("{name}={value}")).collect::<Vec<_>>().join(" ")
}

impl NeedPoint {
    /// Whether a row is this point's, in whatever place.
    pub fn is_of(&self, row: &Row) -> bool {
        is_at(row, &self.parameters, self.frame, self.face)
    }

    /// What is shrunk, as `name=value`.
    pub fn label(&self) -> String {
        values_label(&self.shrunk)
    }
}

impl NeedCurve {
    /// Whether a row was measured in this place of this tracer.
    pub fn holds(&self, row: &Row) -> bool {
        row.scene.name == self.scene
            && row.scene.sha256 == self.scene_sha256
            && row.viewpoint.name == self.viewpoint
            && (row.tracer.name == self.tracer && row.tracer.preset == self.preset)
    }
}

records! {
    /// The worst that searches found.
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
    }

    /// A pose with what its trial gave; what fresh rays gave is in the row of its viewpoint.
    #[derive(Default)]
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
        pub picture: Option<String> = default,
        /// Of a pose that was found its wrong rays made small.
        pub shrunk: Option<ShrunkRecord> = default,
    }

    /// Few rays in few triangles that are wrong for the same cause.
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

/// What is wrong on the last step because its search was given up, as the ray's status says: steps or a driver's limit of
/// loops.
pub const GIVEN_UP: &str = "step_cap";

/// What no step takes away, and the judge knows no cause of.
pub const UNEXPLAINED: &str = "unexplained";

/// The share of a set's rays that may stay unexplained where the judge tells what no step takes away.
pub const MAX_UNEXPLAINED: f64 = 0.02;

records! {
    /// Every wrong ray of a tracer, explained.
    pub struct ExplanationRecord {
        /// The tracer as it was asked for: the first step.
        pub tracer: TracerRecord,
        /// What each further step takes away.
        pub remedies: Vec<RemedyRecord>,
        /// Whether the judge tells the causes of what no step takes away: of a method that samples, which is never fine enough.
        #[serde(default)]
        pub judged: bool,
        /// The scenes.
        pub scenes: Vec<SceneExplained>,
    }

    /// A step.
    #[derive(Eq)]
    pub struct RemedyRecord {
        /// The cause that it takes away.
        pub cause: String,
        /// The tracer's parameter.
        pub parameter: String,
        /// Its value from this step on.
        pub value: String,
        /// Where the cause comes from.
        pub source: String,
    }

    /// A scene.
    pub struct SceneExplained {
        /// The scene.
        pub scene: SceneRecord,
        /// The viewpoint.
        pub viewpoint: ViewpointRecord,
        /// Rungs that the device was too small for, `parameter=value`, which took nothing away, and why.
        pub left_out: BTreeMap<String, String> = default,
        /// Its ray sets.
        pub sets: Vec<Explained>,
    }

    /// A ray set under the rule `tight`.
    #[derive(Eq)]
    pub struct Explained {
        /// Ray set.
        pub rays: String,
        /// Hash of the rays.
        pub rays_sha256: String,
        /// What was asked.
        pub query: Query,
        /// Number of rays.
        pub count: u64,
        /// Rays whose truth hangs on rounding: in no other count.
        pub ambiguous_rays: u64,
        /// Wrong rays on each step, the first as the tracer was asked for.
        pub wrong_by_remedy: Vec<u64>,
        /// Rays that are right on the first step and wrong on a later one: a remedy alone may do harm.
        pub wrong_on_the_way: u64,
        /// Rays that are wrong on the last step without a known cause though their search was not given up, whatever they were on the
        /// first.
        pub unexplained: u64,
        /// Of the rays that are wrong on the first step: class, then cause, then how many. What is wrong on the last step is
        /// `step_cap` where its search was given up there, else has the judge's cause if it is asked, or is `unexplained`.
        pub causes: BTreeMap<String, BTreeMap<String, u64>>,
    }
}

impl Explained {
    /// Wrong rays of a cause, of every class.
    pub fn of_cause(&self, cause: &str) -> u64 {
        self.causes.values().filter_map(|causes| causes.get(cause)).sum()
    }

    /// Wrong rays on the last step: those that no step takes away, and those that a step has brought.
    pub fn left(&self) -> u64 {
        self.wrong_by_remedy.last().copied().unwrap_or(0)
    }
}

impl ExplanationRecord {
    fn sets(&self) -> impl Iterator<Item = (&SceneExplained, &Explained)> {
        self.scenes.iter().flat_map(|scene| scene.sets.iter().map(move |set| (scene, set)))
    }

    /// The causes in order: of the steps, of the judge, what is unexplained last.
    pub fn causes(&self) -> Vec<&str> {
        let of_steps = self.remedies.iter().map(|remedy| remedy.cause.as_str());
        let mut causes: Vec<&str> = of_steps.chain([GIVEN_UP]).collect();
        let found = self.sets().flat_map(|(_, set)| set.causes.values().flat_map(BTreeMap::keys));
        let of_judge: BTreeSet<&str> = found.map(String::as_str).filter(|cause| !causes.contains(cause)).collect();
        causes.extend(of_judge.into_iter().filter(|cause| *cause != UNEXPLAINED));
        causes.push(UNEXPLAINED);
        causes
    }

    /// Rays that are wrong on the last step without a known cause, of all scenes.
    pub fn unexplained(&self) -> u64 {
        self.sets().map(|(_, set)| set.unexplained).sum()
    }

    /// The sets, by scene, of which more than what may be is unexplained: a share where the judge tells causes, else any.
    pub fn left_open(&self) -> Vec<(&str, &Explained)> {
        let may = |set: &Explained| if self.judged { MAX_UNEXPLAINED * set.count as f64 } else { 0.0 };
        let open = self.sets().filter(|(_, set)| set.unexplained as f64 > may(set));
        open.map(|(scene, set)| (scene.scene.name.as_str(), set)).collect()
    }
}
