//! A search for the pose, the animation time and the scale at which a tracer is wrong the most, beside as many random ones. What was found
//! is measured anew on fresh rays, by the same code as every run, and made small.

mod poses;
mod search;
mod shrink;
#[cfg(test)]
mod tests;

use std::time::{Duration, Instant};

use itertools::Itertools as _;
use serde_json::Value;
use tracebench_api::Viewpoint;

use crate::exchange::{self, ExchangeError, Manifest};
use crate::files::OutputFolder;
use crate::judge::Rule;
use crate::measure::session::{PreparedRays, Session};
use crate::measure::{self, Context, MeasureOptions, Observations, RunError, records};
use crate::plan::{Plan, RunPreset, TracerRequest, ViewRequest};
use crate::rays::RaySet;
use crate::render::painted::Canvas;
use crate::results::{AttackRecord, PoseRecord, Record, SearchRecord, ShrunkRecord, Skipped};
use crate::studies::pareto::pictures::keep;
use poses::Poses;
use search::{Trial, Trials, climbs};
use shrink::{Shrinker, Shrunk};

/// Width and height of the image of a trial where nothing else is said: 2,048 pixels.
pub const TRIAL_IMAGE: [u32; 2] = [64, 32];

/// How much finer along each edge the image is by whose rays a pose is measured anew.
pub const FINER: u32 = 4;

/// Poses of a search that are measured anew, the worst of different climbs, and how rows call them.
const FOUND: usize = NAMES.len();
const NAMES: [&str; 3] = ["worst found", "worst found, 2nd", "worst found, 3rd"];

/// The folder beside the record for what was made small.
pub(crate) const FOLDER: &str = "attack";

/// What the names of journals of trials end with.
const TRIALS: &str = "-trials";

/// What is searched for, and how long.
#[derive(Clone, Copy, Debug)]
pub struct AttackOptions {
    /// The rule by which rays are wrong; any-hit rays have none.
    pub rule: Rule,
    /// Poses that are tried, and as many random ones.
    pub trials: u32,
    /// The time of all searches within which new trials begin.
    pub budget: Option<Duration>,
    /// Whether only the worst pose is measured anew, without a picture, and nothing is made small.
    pub is_brief: bool,
}

/// Why a search ended without a pose.
enum Stopped {
    /// Everything ends.
    Run(RunError),
    /// This search alone: whether the tracer is to blame, and the reason.
    Skipped(bool, String),
}

impl<E: Into<RunError>> From<E> for Stopped {
    fn from(error: E) -> Self {
        Self::Run(error.into())
    }
}

/// What is looked at while fresh answers are there: a picture, and what was made small.
type Looked = (Option<String>, Option<ShrunkRecord>);

const OPTIONS: MeasureOptions = MeasureOptions { validated: false, counted: false, ..MeasureOptions::untimed() };

/// Searches in every scene of the plan for every tracer and ray set.
///
/// # Errors
/// [`RunError`] as its variants say; trials that ended are in the journal.
pub fn execute(plan: &Plan, options: &AttackOptions, context: &Context<'_>) -> Result<Record, RunError> {
    let mut record = measure::begin(std::slice::from_ref(plan), context);
    let (rule, trial_image) = (options.rule, plan.preset.ray_image);
    let mut attack = AttackRecord { rule, trial_image, viewpoints: Vec::new(), searches: Vec::new() };
    let begun = Instant::now();
    // Places have the same numbers whatever comes of the searches before.
    let per_scene = 1 + plan.tracers.len() * plan.ray_sets.len() * (FOUND + 1);
    for (number, source) in plan.scenes.iter().enumerate().filter(|(number, _)| context.takes(*number)) {
        let poses = Poses::new(plan, source, context)?;
        let first = number * per_scene;
        let requests: Vec<TracerRequest> = plan.tracers.iter().map(request).collect();
        let scene = poses.scene(&poses::Candidate::default())?;
        let own = measure::measure_scene(first, &fresh(plan), scene, &requests, OPTIONS, None, context)?;
        attack.viewpoints.push([source.name().to_owned(), own.viewpoint.name.clone()]);
        measure::add_or_skip(&mut record, own, &requests);
        for (place, (tracer, set)) in plan.tracers.iter().cartesian_product(&plan.ray_sets).enumerate() {
            let label = records::request_record(tracer).label();
            let search = Search { plan, options, context, poses: &poses, tracer, set, label: &label };
            match search.run(first + 1 + place * (FOUND + 1), begun, &mut record) {
                Ok(found) => attack.searches.push(found),
                Err(Stopped::Skipped(by_tracer, reason)) => record.skipped.push(Skipped {
                    tracer: by_tracer.then_some(label),
                    scene: source.name().to_owned(),
                    rays: Some(set.name.to_owned()),
                    reason,
                }),
                Err(Stopped::Run(error)) => return Err(error),
            }
        }
    }
    if attack.searches.is_empty() && context.shard.is_none() {
        return Err(measure::nothing(&record));
    }
    record.attack = Some(attack);
    Ok(record)
}

/// Who cannot answer from one pose is skipped there.
fn request(tracer: &TracerRequest) -> TracerRequest {
    TracerRequest { required: false, ..tracer.clone() }
}

/// The plan with more rays, of another seed than that of the trials.
fn fresh(plan: &Plan) -> Plan {
    let ray_image = plan.preset.ray_image.map(|edge| edge * FINER);
    Plan { preset: RunPreset { ray_image, ..plan.preset }, seed: plan.seed.wrapping_add(1), ..plan.clone() }
}

/// One search.
struct Search<'a> {
    plan: &'a Plan,
    options: &'a AttackOptions,
    context: &'a Context<'a>,
    poses: &'a Poses<'a>,
    tracer: &'a TracerRequest,
    set: &'a RaySet,
    label: &'a str,
}

impl Search<'_> {
    /// Searches, and measures what was found anew into a record. Its places have numbers from `first` on.
    fn run(&self, first: usize, begun: Instant, record: &mut Record) -> Result<SearchRecord, Stopped> {
        let Trials { searched, random, .. } = self.trials(&format!("{first:03}{TRIALS}"), begun)?;
        let Some(random_worst) = random.iter().copied().reduce(Trial::worse) else {
            return Err(Stopped::Skipped(false, "the budget was over before a trial began".to_owned()));
        };
        let mut found: Vec<Trial> = climbs(&searched).into_iter().unique_by(|trial| trial.candidate.view()).collect();
        found.sort_by(|one, other| other.compare(one));
        found.truncate(if self.options.is_brief { 1 } else { FOUND });
        let mut poses = Vec::new();
        for (place, (name, trial)) in NAMES.into_iter().zip(found).enumerate() {
            poses.push(self.anew(first + place, name, (&trial, &searched), record)?);
        }
        let random_pose = self.anew(first + FOUND, "worst random", (&random_worst, &random), record)?;
        Ok(SearchRecord {
            scene: self.poses.name().to_owned(),
            tracer: records::request_record(self.tracer),
            rays: self.set.name.to_owned(),
            trials: searched.len() as u64,
            trials_sha256: crate::hash::sha256_of(&serde_json::to_vec(&(&searched, &random)).unwrap_or_default()),
            found: poses,
            random: random_pose,
        })
    }

    /// All trials: those of the journal, and further ones, each of which is kept before the next begins.
    fn trials(&self, name: &str, begun: Instant) -> Result<Trials, Stopped> {
        let AttackOptions { trials: wanted, budget, .. } = *self.options;
        let mut trials: Trials = self.context.journal.read(name)?.unwrap_or_default();
        let mut config = self.context.config(self.tracer).map_err(|error| Stopped::Skipped(true, error.to_string()))?;
        let what = format!("attack {}, {}", self.label, self.set.name);
        let bar = self.context.progress.bar(&what, 2 * u64::from(wanted));
        while !trials.is_done {
            let count = trials.searched.len();
            if trials.random.len() < count {
                trials.random.push(self.random(&mut config, trials.random.len())?);
            } else if count >= wanted as usize {
                trials.is_done = true;
            } else if budget.is_some_and(|budget| begun.elapsed() >= budget) {
                self.context.journal.stay(TRIALS);
                break;
            } else {
                trials.searched.push(self.next(&mut config, &trials.searched)?);
            }
            bar.set_position((count + trials.random.len()) as u64);
            self.context.journal.keep(name, &trials)?;
        }
        Ok(trials)
    }

    /// Measures the pose of one of some trials on fresh rays; paints them, and makes those of a pose that was found small.
    fn anew(
        &self,
        index: usize,
        name: &str,
        (trial, all): (&Trial, &[Trial]),
        record: &mut Record,
    ) -> Result<PoseRecord, Stopped> {
        let scene = self.poses.scene(&trial.candidate)?;
        let mesh = scene.mesh.clone();
        let number = all.iter().position(|one| one == trial).unwrap_or_default() as u64;
        let (viewpoint, Trial { wrong, judged, .. }) = (name.to_owned(), *trial);
        let pose_record = PoseRecord { viewpoint, trial: number, wrong, judged, ..self.poses.record(&trial.candidate) };
        let pose = trial.candidate.pose(name).map_err(|error| RunError::Nothing(error.to_string()))?;
        let plan = Plan {
            view: ViewRequest::Given(pose),
            ray_sets: vec![*self.set],
            ..self.poses.plan(&trial.candidate, &fresh(self.plan))
        };
        let (is_found, size) = (NAMES.contains(&name), plan.preset.ray_image);
        let look = |session: &Session, rays: &PreparedRays, told: &[Option<Observations>]| -> Result<Value, RunError> {
            let (Some(Some(told)), false) = (told.first(), self.options.is_brief) else { return Ok(Value::Null) };
            let classes = session.classes(self.label, rays, self.options.rule, &told.hits)?;
            let painted = Canvas { size, pixels: &rays.pixels }.classes(&classes);
            let picture = self.context.journal.results().map(|results| keep(&painted, results)).transpose()?;
            let config = self.context.config(self.tracer)?;
            let (rule, progress) = (self.options.rule, self.context.progress);
            let shrinker = Shrinker { session, set: *self.set, rule, config, mesh: &mesh, progress };
            let small = if is_found { shrinker.shrink(rays, told)? } else { None };
            let shrunk = small.map(|small| self.written(&small, session, &pose_record)).transpose()?.flatten();
            measure::told(&(picture, shrunk))
        };
        let request = [request(self.tracer)];
        let mut found = measure::measure_scene(index, &plan, scene, &request, OPTIONS, Some(&look), self.context)?;
        let (picture, shrunk): Looked = found.take_hooked()?.pop().unwrap_or_default();
        measure::add_or_skip(record, found, &request);
        Ok(PoseRecord { picture, shrunk, ..pose_record })
    }

    /// Writes what was made small beside the record, and says how it is traced; nothing where nothing is written.
    fn written(&self, small: &Shrunk, session: &Session, pose: &PoseRecord) -> Result<Option<ShrunkRecord>, RunError> {
        let Some(results) = self.context.journal.results() else { return Ok(None) };
        let safe = |letter: char| if letter.is_ascii_alphanumeric() || letter == '-' { letter } else { '_' };
        let of = [self.poses.name(), self.label, self.set.name, &pose.trial.to_string()];
        let name: String = of.join("_").chars().map(safe).collect();
        let below = format!("{FOLDER}/{name}");
        let folder = OutputFolder::open(&results.path().join(&below)).map_err(ExchangeError::from)?;
        let scene = exchange::write_scene(&folder, &small.mesh, &name)?;
        let Viewpoint { frame: [width, height], face, .. } = session.viewpoint;
        let (known, rays) = ((small.rays.as_slice(), small.answers.as_slice()), small.rays.len() as u64);
        let viewpoint = records::viewpoint_of(&pose.viewpoint, &session.viewpoint, [width, height], pose.time_s);
        let scene = records::scene_record(&scene);
        let triangles = scene.triangles - shrink::MARKERS;
        let set = Manifest::new(self.set.name, self.set.query, known, scene, Some(viewpoint), self.plan.seed);
        exchange::write(&folder, "", &set, known, &[])?;
        let launch = self.context.launch.as_ref().map(|of| (&of.launch.memory_access, of.launch.rays_per_lane));
        let launch = launch.map_or_else(String::new, |(access, rays)| format!(" --launch {access},{rays}"));
        let command = format!(
            "tracebench run --scene {below}/{} --rays file:{below} --tracer {} --view {} --frame-size {width}x{height} --face-size {face} \
             --samples 1{launch}",
            exchange::SCENE_FILE,
            self.tracer.argument(),
            pose.view
        );
        Ok(Some(ShrunkRecord { cause: small.cause.clone(), rays, triangles, markers: shrink::MARKERS, command }))
    }
}
