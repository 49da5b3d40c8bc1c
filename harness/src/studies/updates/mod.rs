//! Structures that follow animations, and the camera's path: how long each way of following takes, and what it leaves.
//!
//! Over an animation every tracer and way has a structure of its own, built over the first frame; then all follow frame by frame, in
//! turn. At the last frame they trace the same rays beside fresh builds over it, by the same measure, judge and controls as a run.
//! Along the camera's path (`walk`) they trace at every frame.

mod totals;
mod walk;

use glam::Vec3;
use tracebench_api::Update;
use tracebench_scenes::Scene;

use crate::measure::{self, AnimationFrames, Context, MeasureOptions, Request, RunError, records};
use crate::peers::{Subject, Table};
use crate::plan::{Plan, TracerRequest};
use crate::results::{FRESH_BUILD, Record, Row, SceneFollowed, Skipped, TracerRecord, UpdateModeRecord, UpdatesRecord};

pub use totals::{Total, Walker, walkers};

/// An animation whose vertices all end within so many scene diagonals of where they began comes back to its start.
const RETURNED_DIAGONALS: f64 = 1e-3;

/// Frames where nothing else is said.
pub const DEFAULT_FRAMES: u32 = 8;

/// A way to follow an animation, as data.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct UpdateMode {
    /// Its name in tables.
    pub name: &'static str,
    /// What is asked for at every frame.
    pub update: Update,
    /// A parameter that it needs, with its value: tracers that do not have it do not go this way.
    pub setting: Option<(&'static str, &'static str)>,
}

const REBUILD: UpdateMode = UpdateMode { name: "rebuild", update: Update::Rebuild, setting: None };
const REFIT: UpdateMode = UpdateMode { name: "refit", update: Update::Refit, setting: None };

/// Every way to follow an animation.
pub const UPDATE_MODES: &[UpdateMode] = &[
    REBUILD,
    REFIT,
    // At 8 frames the last two are refits after a rebuild.
    UpdateMode { name: "refit, rebuild every 3", update: Update::Refit, setting: Some(("rebuild_every", "3")) },
];

/// Every way to another frame of the camera's path. What comes of each depends on the first frame and this one alone, whatever lies
/// between them.
pub const PATH_UPDATE_MODES: &[UpdateMode] =
    &[UpdateMode { name: "reuse", update: Update::Reuse, setting: None }, REFIT, REBUILD];

impl UpdateMode {
    /// The tracer as it goes this way, if it can.
    fn taken_by(&self, request: &TracerRequest) -> Option<TracerRequest> {
        let mut request = request.clone();
        match self.setting {
            None => Some(request),
            Some((name, value)) => request.set(name, value).is_ok().then_some(request),
        }
    }
}

/// Measures every scene of a plan that moves, or that the camera moves through.
///
/// # Errors
/// [`RunError`] as its variants say.
pub fn execute(table: &Table, plan: &Plan, frames: u32, context: &Context<'_>) -> Result<Record, RunError> {
    let mut record = measure::begin(std::slice::from_ref(plan), context);
    record.table = Some(table.name.to_owned());
    let frame_scene_sha256 = table.subject == Subject::Walked;
    let samples = plan.preset.sampling.min_rounds;
    // Every frame of a film is counted, of a walk one frame at a time.
    let passes = if frame_scene_sha256 { samples } else { samples.div_ceil(frames) };
    let update_modes: Vec<_> = std::iter::once(None).chain(UPDATE_MODES.iter().map(Some)).collect();
    let mut updates = UpdatesRecord { frames, passes, scenes: Vec::new() };
    for (index, scene) in measure::load_at(plan, None, context.progress)?.into_iter().enumerate() {
        if !context.takes(index) {
            continue;
        }
        if frame_scene_sha256 {
            updates.scenes.extend(walk::measure(index, plan, scene, frames, passes, &mut record, context)?);
            continue;
        }
        if scene.animation.is_none() {
            let reason = "it does not move".to_owned();
            record.skipped.push(Skipped { tracer: None, scene: scene.name, rays: None, reason });
            continue;
        }
        let film = Followed::new(scene, frames)?;
        updates.scenes.push(film.record());
        let Followed { scene, positions, .. } = film;
        let plan = Plan { time_s: scene.time_s, ..plan.clone() };
        let roles = roles(&plan, &scene.name, &update_modes, &mut record);
        let film = AnimationFrames::new(&scene, positions, None, passes);
        measure_roles(index, &plan, scene, Some(film), &roles, &mut record, context)?;
    }
    if record.rows.is_empty() && context.shard.is_none() {
        let reason = |skipped: &Skipped| format!("{}: {}", skipped.scene, skipped.reason);
        return Err(RunError::Nothing(record.skipped.iter().map(reason).collect::<Vec<_>>().join("; ")));
    }
    record.updates = Some(updates);
    Ok(record)
}

/// A scene at its last frame, with the vertices of every frame before.
struct Followed {
    scene: Scene,
    times_s: Vec<f64>,
    positions: Vec<Vec<[f32; 3]>>,
}

impl Followed {
    /// Frames evenly over the animation, the first at its begin and the last at its end; of one that comes back to where it
    /// began at its middle, where it is farthest from that: at its end a structure of the first frame would fit again.
    fn new(mut scene: Scene, frames: u32) -> Result<Self, RunError> {
        let duration_s = scene.animation.as_ref().map_or(0.0, |animation| animation.duration_s);
        scene.drop_zero_area(&[0.0, duration_s])?;
        let first = scene.mesh.positions.clone();
        scene.set_time(duration_s)?;
        let returns = farthest(&first, &scene.mesh.positions) <= RETURNED_DIAGONALS * scene.diagonal();
        let end_s = if returns { duration_s / 2.0 } else { duration_s };
        let times_s: Vec<f64> = (0..=frames).map(|frame| end_s * f64::from(frame) / f64::from(frames)).collect();
        scene.drop_zero_area(&times_s)?;
        let mut positions = Vec::new();
        for time_s in &times_s {
            scene.set_time(*time_s)?;
            positions.push(scene.mesh.positions.clone());
        }
        Ok(Self { scene, times_s, positions })
    }

    fn record(&self) -> SceneFollowed {
        let (scene, scene_sha256) = (self.scene.name.clone(), self.scene.sha256.clone());
        SceneFollowed { scene, scene_sha256, times_s: self.times_s.clone(), frame_scene_sha256: Vec::new() }
    }
}

/// The farthest that any vertex has moved, scene units.
fn farthest(from: &[[f32; 3]], to: &[[f32; 3]]) -> f64 {
    let moved = |(a, b): (&[f32; 3], &[f32; 3])| f64::from(Vec3::from(*a).distance(Vec3::from(*b)));
    from.iter().zip(to).map(moved).fold(0.0, f64::max)
}

/// A tracer as it is in the table, and the way that it goes.
#[derive(Clone)]
struct Role<'a> {
    /// Without what the way sets.
    request: &'a TracerRequest,
    /// None for a build over the frame that is traced.
    update_mode: Option<&'static UpdateMode>,
    /// The frame, where rays are traced at every one.
    frame: Option<u32>,
    /// What makes its structure stale there.
    stale_by: Vec<String>,
}

impl Role<'_> {
    fn update_mode(&self) -> &'static str {
        self.update_mode.map_or(FRESH_BUILD, |update_mode| update_mode.name)
    }

    /// The way, and the frame where there are several.
    fn said(&self) -> String {
        self.frame
            .map_or_else(|| self.update_mode().to_owned(), |frame| format!("{}, frame {frame}", self.update_mode()))
    }

    /// What is asked for, if the tracer can go the way. Not being able to measure one is no error.
    fn asked(&self) -> Option<Request> {
        let going = self
            .update_mode
            .map_or_else(|| Some(self.request.clone()), |update_mode| update_mode.taken_by(self.request))?;
        let tracer = TracerRequest { required: false, ..going };
        Some(Request { tracer, follows: self.update_mode.map(|update_mode| update_mode.update) })
    }
}

/// Every tracer of a plan with the ways that it can go; in the run, what their methods do not have. `None` is a fresh build.
fn roles<'a>(
    plan: &'a Plan,
    scene: &str,
    update_modes: &[Option<&'static UpdateMode>],
    record: &mut Record,
) -> Vec<Role<'a>> {
    let mut roles = Vec::new();
    // A tracer's ways stand together.
    for request in &plan.tracers {
        for update_mode in update_modes.iter().copied() {
            let role = Role { request, update_mode, frame: None, stale_by: Vec::new() };
            let Some(asked) = role.asked() else { continue };
            let served = asked.follows.map_or(Ok(()), |update| request.registration.describe().serves(update));
            match served {
                Ok(()) => roles.push(role),
                Err(error) => {
                    let tracer = Some(format!("{} ({})", request.name(), role.update_mode()));
                    let reason = error.to_string();
                    record.skipped.push(Skipped { tracer, scene: scene.to_owned(), rays: None, reason });
                }
            }
        }
    }
    roles
}

/// Measures roles in a scene, which is the last frame of the film, if there is one.
fn measure_roles(
    index: usize,
    plan: &Plan,
    scene: Scene,
    film: Option<AnimationFrames>,
    roles: &[Role<'_>],
    record: &mut Record,
    context: &Context<'_>,
) -> Result<(), RunError> {
    let asked = roles.iter().filter_map(|role| Some((role, role.asked()?)));
    let (roles, requests): (Vec<&Role<'_>>, Vec<Request>) = asked.unzip();
    let options = MeasureOptions::timed(plan);
    let mut found = measure::measure_scene(index, plan, (scene, film), &requests, options, None, context)?;
    for (row, role) in found.rows.iter_mut().zip(roles.iter().copied()) {
        if let Ok(row) = row {
            *row = row_of(row.clone(), role);
        }
    }
    for (place, refused) in measure::add(record, found) {
        measure::refuse(record, roles[place].request.name(), Some(&roles[place].said()), refused);
    }
    Ok(())
}

/// What was measured of a tracer that was asked for otherwise than it went.
fn row_of(row: Row, role: &Role<'_>) -> Row {
    let parameters = records::json_values(&role.request.parameters);
    let mut update_mode = UpdateModeRecord {
        name: role.update_mode().to_owned(),
        parameters: row.tracer.parameters.clone(),
        frame_index: role.frame,
        stale_by: role.stale_by.clone(),
    };
    update_mode.parameters.retain(|name, value| parameters.get(name) != Some(value));
    Row {
        update_mode: Some(update_mode),
        tracer: TracerRecord { parameters, changed: role.request.changed.clone(), ..row.tracer },
        ..row
    }
}

#[cfg(test)]
mod tests {
    use tracebench_api::{Preset, Value};

    use super::*;
    use crate::registry::TRACERS;

    /// Ways have names of their own, a setting is taken where the tracer has the parameter and only there, and what is not
    /// set stays.
    #[test]
    fn ways_are_taken_by_those_who_can() {
        for (index, update_mode) in UPDATE_MODES.iter().enumerate() {
            assert!(
                UPDATE_MODES[..index].iter().all(|other| other.name != update_mode.name)
                    && update_mode.name != FRESH_BUILD
            );
            for registration in TRACERS {
                let request = TracerRequest::of(registration, Preset::Published);
                let parameters = registration.describe().parameters;
                let can = update_mode.setting.is_none_or(|(name, _)| parameters.iter().any(|each| each.name == name));
                assert_eq!(update_mode.taken_by(&request).is_some(), can, "{} of {}", update_mode.name, request.name());
            }
        }
        let request = TracerRequest::of(&TRACERS[0], Preset::Published);
        let build = UpdateMode { name: "other", update: Update::Refit, setting: Some(("build", "fastest")) };
        let fastest = Value::Choice("fastest".to_owned());
        assert_eq!(build.taken_by(&request).unwrap().parameters.value("build"), Some(&fastest));
        let wrong = UpdateMode { setting: Some(("build", "no such")), ..build };
        assert!(wrong.taken_by(&request).is_none());
    }

    /// Frames cover the animation from begin to end, or to its middle where it comes back, and each has the vertices of its
    /// time; at the last one something has moved.
    #[test]
    fn films_cover_the_animation() {
        let mut returning = 0;
        for entry in tracebench_scenes::catalogue().iter().filter(|entry| entry.animation_s.is_some()) {
            let made = || tracebench_scenes::procedural(entry.name, 0.01).unwrap();
            let film = Followed::new(made(), 4).unwrap();
            let mut fresh = made();
            let duration_s = entry.animation_s.unwrap();
            fresh.set_time(duration_s).unwrap();
            let returns = farthest(&film.positions[0], &fresh.mesh.positions) < 1e-3 * fresh.diagonal();
            returning += usize::from(returns);
            let end_s = if returns { duration_s / 2.0 } else { duration_s };
            assert_eq!(film.times_s, [0.0, 0.25, 0.5, 0.75, 1.0].map(|share| share * end_s), "{}", entry.name);
            for (time_s, positions) in film.times_s.iter().zip(&film.positions) {
                fresh.set_time(*time_s).unwrap();
                assert!(fresh.mesh.positions == *positions);
            }
            assert_eq!(film.scene.sha256, fresh.sha256);
            let moved = farthest(&film.positions[0], &film.positions[4]);
            assert!(moved > 0.01 * fresh.diagonal(), "{}: {moved}", entry.name);
        }
        // Both kinds are there.
        assert!(returning > 0 && returning < 4, "{returning}");
    }
}
