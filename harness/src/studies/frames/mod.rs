//! Moving scenes: structures follow the animation and the camera's path, and every frame is traced and judged; with effects it is
//! rendered from each tracer's own answers, beside what the truth gives by the same random numbers.

mod camera;
mod images;
mod points;
mod watch;

use clap::{Args, ValueEnum};
use itertools::Itertools as _;
use serde::{Deserialize, Serialize};
use tracebench_api::{Preset, Query, Update};

use crate::measure::{self, Context, MovingFrames, RunError, records};
use crate::plan::{Plan, TracerRequest, within};
use crate::registry::{Family, Registration};
use crate::render::Effect;
use crate::results::{FrameSeries, FramesRecord, InterleavedSetRecord, MovingScene, Record, Skipped};
use tracebench_scenes::Scene;
use watch::Watch;

/// Most frames.
pub const MAX_FRAMES: u32 = 240;

/// What moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Moves {
    /// The scene alone, seen from where it is seen at first.
    Geometry,
    /// The camera alone.
    Camera,
    /// Both; in a scene that stands still the camera alone.
    Both,
}

/// How structures are brought up to date.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Updates {
    /// Reused where nothing that changed invalidates them, refitted where the method can while the SAH cost is below 1.5 times that of the last
    /// build, else rebuilt.
    Auto,
    /// Rebuilt in every frame.
    Rebuild,
    /// Refitted in every frame; methods that cannot are left out.
    Refit,
    /// Never touched; marked where they are stale.
    Reuse,
}

/// Whose hits paths go on from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum PathsOf {
    /// The tracer's own.
    Own,
    /// The truth's, so that rays are the same for all.
    Truth,
}

/// What is asked for beside a plan, whose ray sets are traced in place of effects where there are none of these.
#[derive(Clone, Debug, Args, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FramesRequest {
    /// Effects to render, with commas: depth, normals, primary (direct light), ao, mirror, diffuse (one bounce), path; primary if neither
    /// these nor ray sets are given.
    #[arg(long = "effect", value_name = "E,...", value_delimiter = ',', conflicts_with = "rays", value_parser = effect)]
    pub effects: Vec<Effect>,
    /// Frames; 1 is a picture.
    #[arg(long, value_name = "N", default_value_t = 12, value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_FRAMES)))]
    pub frames: u32,
    /// Frames a second, of the animation and of the camera's path.
    #[arg(long, value_name = "F", default_value_t = 24.0,
          value_parser = within(1e-3..=1e6, "a number of frames a second from 0.001 to 1000000"))]
    pub fps: f64,
    /// Samples a pixel.
    #[arg(long, value_name = "N", default_value_t = 4, conflicts_with = "rays", value_parser = clap::value_parser!(u32).range(1..=256))]
    pub spp: u32,
    /// What moves.
    #[arg(long = "move", value_enum, default_value_t = Moves::Both)]
    #[serde(rename = "move")]
    pub moves: Moves,
    /// How structures are brought up to date in every frame.
    #[arg(long, value_enum, default_value_t = Updates::Auto)]
    pub update: Updates,
    /// Whose hits the paths of an effect go on from. On own ones one of eight rays behind the first wave is judged, else all.
    #[arg(long, value_enum, default_value_t = PathsOf::Own, conflicts_with = "rays")]
    pub paths: PathsOf,
    /// The camera jumps to another viewpoint in this frame, counted from 0, and stays there.
    #[arg(long, value_name = "FRAME", value_parser = clap::value_parser!(u32).range(1..))]
    pub cut: Option<u32>,
    /// Trace the rays of the first frame in every frame, judged from its eye: only the viewpoints of structures change.
    #[arg(long, requires = "rays")]
    pub fixed_rays: bool,
}

fn effect(name: &str) -> Result<Effect, String> {
    let found = Effect::ALL.into_iter().find(|effect| effect.name() == name);
    found.ok_or_else(|| format!("no effect '{name}'; there are: {}", Effect::ALL.map(Effect::name).join(", ")))
}

/// A word of a choice, as the command line has it.
fn word(choice: impl ValueEnum) -> String {
    choice.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned())
}

impl FramesRequest {
    /// What is measured and kept as one, since every frame follows from the one before: each effect, or all ray sets.
    fn parts(&self) -> Vec<Self> {
        let of = |effect: &Effect| Self { effects: vec![*effect], ..self.clone() };
        if self.effects.is_empty() { vec![self.clone()] } else { self.effects.iter().map(of).collect() }
    }

    /// Of a part the effect, if it is of one.
    fn effect(&self) -> Option<Effect> {
        self.effects.first().copied()
    }

    /// How structures are always brought up to date, if it is always in one way.
    fn always(&self) -> Option<Update> {
        match self.update {
            Updates::Auto => None,
            Updates::Rebuild => Some(Update::Rebuild),
            Updates::Refit => Some(Update::Refit),
            Updates::Reuse => Some(Update::Reuse),
        }
    }

    /// Why a tracer cannot follow as it is asked, or cannot render an effect.
    fn unserved(&self, tracer: &TracerRequest, effect: Option<Effect>) -> Option<String> {
        let description = tracer.registration.describe();
        match (effect, self.always()) {
            (Some(effect), _) if !description.ends.contains(&effect.end()) => {
                Some(format!("{} ends at surfaces, and the method does not trace so far", effect.name()))
            }
            (Some(effect), _) if effect.asks_any() && !description.queries.contains(&Query::Any) => {
                Some(format!("{} asks for any hit, which the method does not answer", effect.name()))
            }
            (None, Some(update)) => description.serves(update).err().map(|error| error.to_string()),
            _ => None,
        }
    }

    /// That every effect is served by a tracer.
    ///
    /// # Errors
    /// Which is not, with the reasons.
    pub fn check(&self, tracers: &[TracerRequest]) -> Result<(), String> {
        for effect in &self.effects {
            let why: Vec<Option<String>> = tracers.iter().map(|tracer| self.unserved(tracer, Some(*effect))).collect();
            if why.iter().all(Option::is_some) {
                let why = why.into_iter().flatten().sorted().dedup().join("; ");
                return Err(format!("effect {}: no tracer of --tracer serves it ({why})", effect.name()));
            }
        }
        Ok(())
    }

    /// The section of a record without scenes.
    fn section(&self, plan: &Plan) -> FramesRecord {
        FramesRecord {
            frames: self.frames,
            fps: self.fps,
            size: plan.preset.ray_image,
            spp: self.spp,
            moves: word(self.moves),
            update: word(self.update),
            paths: word(self.paths),
            cut: self.cut,
            fixed_rays: self.fixed_rays,
            works: match self.effects.is_empty() {
                true => plan.ray_sets.iter().map(|set| set.name.to_owned()).collect(),
                false => self.effects.iter().map(|effect| effect.name().to_owned()).collect(),
            },
            effects: !self.effects.is_empty(),
            scenes: Vec::new(),
            rows: Vec::new(),
        }
    }
}

/// Whether an image may differ from the truth's by rounding alone: that of a hierarchy, however it is set, and of another method with analytic
/// hits in its improved form.
pub(crate) fn is_exact(registration: &Registration, is_improved: bool) -> bool {
    registration.is_analytic() && (registration.family == Family::Bvh || is_improved)
}

fn is_exact_as_asked(request: &TracerRequest) -> bool {
    is_exact(&request.registration, request.preset == Preset::Improved && request.changed.is_empty())
}

/// A part, measured in a scene.
#[derive(Serialize, Deserialize)]
struct SceneMeasured {
    scene: MovingScene,
    rows: Vec<FrameSeries>,
    skipped: Vec<Skipped>,
    interleaved_set: Option<InterleavedSetRecord>,
}

/// Measures every scene of a plan.
///
/// # Errors
/// [`RunError`] as its variants say; what has ended of scenes is kept.
pub fn execute(plan: &Plan, request: &FramesRequest, context: &Context<'_>) -> Result<Record, RunError> {
    let mut record = measure::begin(std::slice::from_ref(plan), context);
    let mut section = request.section(plan);
    for (index, scene) in measure::load_at(plan, None, context.progress)?.into_iter().enumerate() {
        if !context.takes(index) {
            continue;
        }
        let place = section.scenes.len();
        for part in request.parts() {
            let kept = format!("{index:03}-frames-{}", part.effect().map_or("rays", Effect::name));
            let measured = match context.kept(&kept, || scene_measured(plan, &part, scene.clone(), context)) {
                Err(error @ RunError::NoOtherView(..)) => Err(format!("it has no camera path, and {error}")),
                Err(RunError::Nothing(reason)) => Err(reason),
                measured => Ok(measured?),
            };
            match measured {
                Ok(measured) => add(&mut record, &mut section, place, measured),
                Err(reason) => {
                    record.skipped.push(Skipped { tracer: None, scene: scene.name.clone(), rays: None, reason });
                }
            }
        }
    }
    // What is said of a scene is said in each of its parts.
    record.skipped = std::mem::take(&mut record.skipped).into_iter().unique().collect();
    let has_answered = |row: &FrameSeries| !row.is_control() && row.frames.iter().any(|frame| !frame.works.is_empty());
    let is_empty = !section.rows.iter().any(has_answered);
    record.frames = Some(section);
    if is_empty && context.shard.is_none() { Err(measure::nothing(&record)) } else { Ok(record) }
}

/// Adds a part of the scene of a place.
fn add(record: &mut Record, section: &mut FramesRecord, place: usize, measured: SceneMeasured) {
    let (scene, set) = (place as u32, record.interleaved_sets.len() as u32);
    record.interleaved_sets.extend(measured.interleaved_set);
    record.skipped.extend(measured.skipped);
    match section.scenes.get_mut(place) {
        Some(known) => known.pictures.extend(measured.scene.pictures),
        None => section.scenes.push(measured.scene),
    }
    let placed = |row: FrameSeries| FrameSeries { scene, interleaved_set: row.interleaved_set.map(|_| set), ..row };
    section.rows.extend(measured.rows.into_iter().map(placed));
}

fn scene_measured(
    plan: &Plan,
    request: &FramesRequest,
    mut scene: Scene,
    context: &Context<'_>,
) -> Result<SceneMeasured, RunError> {
    let is_still = scene.animation.is_none();
    if is_still && request.moves == Moves::Geometry {
        return Err(RunError::Nothing(format!(
            "scene {} has no animation, so nothing moves by --move geometry: leave it out, or take --move camera",
            scene.name
        )));
    }
    let begin_s = plan.time_s;
    let time_s = |frame: u32| match request.moves {
        Moves::Camera => begin_s,
        Moves::Geometry | Moves::Both => begin_s + f64::from(frame) / request.fps,
    };
    let times_s: Vec<f64> = (0..request.frames).map(time_s).collect();
    scene.drop_zero_area(&times_s)?;
    scene.set_time(times_s[0])?;
    let way = camera::way(plan, request, &scene)?;
    context.progress.say(&format!(
        "scene {}: {} triangles; camera: {}",
        scene.name,
        scene.mesh.triangles.len(),
        way.said
    ));
    let mut film = MovingFrames { scene, times_s, poses: way.poses };
    let mut watch = Watch::new(plan, request, &film, way.said, context)?;
    let followers = watch.tracers.clone();
    let followed = measure::follow(&mut film, &followers, request.always(), plan, &mut watch, context)?;
    let (labels, scene) = (followers.iter().map(|request| records::request_record(request).label()), film.scene.name);
    for (tracer, refusal) in labels.zip(&followed.refused) {
        let (tracer, scene) = (Some(tracer), scene.clone());
        let skipped = |reason: String| Skipped { tracer, scene, rays: None, reason };
        watch.skipped.extend(refusal.as_ref().map(|of| skipped(of.reason.clone())));
    }
    watch.finish(followed)
}

#[cfg(test)]
mod tests;
