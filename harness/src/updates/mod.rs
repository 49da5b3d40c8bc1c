//! Structures that follow animations: how long each way of following takes, and what quality it leaves.
//!
//! Every tracer and way has a structure of its own, built over the first frame; then all follow frame by frame, in turn. At
//! the last frame they trace the same rays beside fresh builds over it, by the same runner, judge and controls as a run.

mod record;

use std::sync::Arc;

use glam::Vec3;
use tracebench_api::{Geometry, Gpu, TracerError, Update};
use tracebench_scenes::Scene;

pub use record::{FRESH_BUILD, SCHEMA, SceneUpdates, UpdateRow, Updates};

use crate::peers::Table;
use crate::plan::{Plan, TracerRequest};
use crate::progress::Progress;
use crate::records;
use crate::registry::Device;
use crate::results::{Provenance, Skipped, TracerRecord, TracerRun};
use crate::runner::{self, Entry, LoadedScene, RunError};
use crate::session::Contender;
use crate::truth::Cache;

/// An animation whose vertices all end within so many scene diagonals of where they began comes back to its start.
const RETURNED_DIAGONALS: f64 = 1e-3;

/// Frames where nothing else is said.
pub const DEFAULT_FRAMES: u32 = 8;

/// A way to follow an animation, as data.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Way {
    /// Its name in tables.
    pub name: &'static str,
    /// What is asked for at every frame.
    pub update: Update,
    /// A parameter that it needs, with its value: tracers that do not have it do not go this way.
    pub setting: Option<(&'static str, &'static str)>,
}

/// Every way.
pub const WAYS: &[Way] = &[
    Way { name: "rebuild", update: Update::Rebuild, setting: None },
    Way { name: "refit", update: Update::Refit, setting: None },
    // At 8 frames the last two are refits after a rebuild.
    Way { name: "refit, rebuild every 3", update: Update::Refit, setting: Some(("rebuild_every", "3")) },
];

impl Way {
    /// The tracer as it goes this way, if it can.
    fn taken_by(&self, request: &TracerRequest) -> Option<TracerRequest> {
        let mut request = request.clone();
        match self.setting {
            None => Some(request),
            Some((name, value)) => request.set(name, value).is_ok().then_some(request),
        }
    }
}

/// Measures every scene of a plan that moves.
///
/// # Errors
/// [`RunError`] as its variants say.
pub fn execute(
    table: &Table,
    plan: &Plan,
    frames: u32,
    device: &Device,
    cache: &Cache,
    progress: &Progress,
) -> Result<Updates, RunError> {
    let gpu = device.as_ref().ok();
    let needs_adapter = plan.tracers.iter().any(|request| request.registration.needs_device());
    let passes = (plan.preset.samples as u32).div_ceil(frames);
    let mut updates = Updates {
        schema: SCHEMA,
        table: table.name.to_owned(),
        provenance: Provenance::now(gpu.filter(|_| needs_adapter).map(|gpu| gpu.listing.clone())),
        seed: plan.seed,
        preset: plan.preset.name.to_owned(),
        ray_parameters: records::json_values(&plan.ray_parameters),
        frames,
        passes,
        scenes: Vec::new(),
        skipped: Vec::new(),
    };
    for scene in runner::load(plan, progress)? {
        if scene.animation.is_none() {
            let reason = "it does not move".to_owned();
            updates.skipped.push(Skipped { tracer: None, scene: scene.name, rays: None, reason });
            continue;
        }
        let film = Film::new(scene, frames)?;
        measure_scene(plan, film, device, cache, progress, &mut updates)?;
    }
    if updates.scenes.iter().all(|scene| scene.rows.is_empty()) {
        let reason = |skipped: &Skipped| format!("{}: {}", skipped.scene, skipped.reason);
        return Err(RunError::Nothing(updates.skipped.iter().map(reason).collect::<Vec<_>>().join("; ")));
    }
    Ok(updates)
}

/// A scene at its last frame, with the vertices of every frame before.
struct Film {
    scene: Scene,
    times_s: Vec<f64>,
    positions: Vec<Vec<[f32; 3]>>,
}

impl Film {
    /// Frames evenly over the animation, the first at its begin and the last at its end; of one that comes back to where it
    /// began at its middle, where it is farthest from that: at its end a structure of the first frame would fit again.
    fn new(mut scene: Scene, frames: u32) -> Result<Self, RunError> {
        let duration_s = scene.animation.as_ref().map_or(0.0, |animation| animation.duration_s);
        scene.set_time(0.0)?;
        let first = scene.mesh.positions.clone();
        scene.set_time(duration_s)?;
        let returns = farthest(&first, &scene.mesh.positions) <= RETURNED_DIAGONALS * scene.diagonal();
        let end_s = if returns { duration_s / 2.0 } else { duration_s };
        let times_s: Vec<f64> = (0..=frames).map(|frame| end_s * f64::from(frame) / f64::from(frames)).collect();
        let mut positions = Vec::new();
        for time_s in &times_s {
            scene.set_time(*time_s)?;
            positions.push(scene.mesh.positions.clone());
        }
        Ok(Self { scene, times_s, positions })
    }
}

/// The farthest that any vertex has moved, scene units.
fn farthest(from: &[[f32; 3]], to: &[[f32; 3]]) -> f64 {
    let moved = |(a, b): (&[f32; 3], &[f32; 3])| f64::from(Vec3::from(*a).distance(Vec3::from(*b)));
    from.iter().zip(to).map(moved).fold(0.0, f64::max)
}

/// What follows: an entry of the race with its way.
struct Follower {
    /// As it stands in the table, without what the way sets.
    request: TracerRequest,
    way: Way,
    entry: Entry,
}

fn measure_scene(
    plan: &Plan,
    film: Film,
    device: &Device,
    cache: &Cache,
    progress: &Progress,
    updates: &mut Updates,
) -> Result<(), RunError> {
    let Film { scene, times_s, positions } = film;
    let plan = &Plan { time_s: scene.time_s, ..plan.clone() };
    let (triangles, materials) = (scene.mesh.triangles.clone(), scene.mesh.triangle_materials.clone());
    let LoadedScene { record: scene, pose, session } = runner::prepare(plan, scene, device, cache, progress)?;
    updates.skipped.extend(session.skipped.iter().cloned());
    let skip = |request: &TracerRequest, way: &str, error: &TracerError| Skipped {
        tracer: Some(format!("{} ({way})", request.name())),
        scene: scene.name.clone(),
        rays: None,
        reason: error.to_string(),
    };
    let create = |request: &TracerRequest| {
        let description = (request.registration.describe)();
        let contender =
            Contender::create(description, request.parameters.clone(), || request.registration.create(device))?;
        Ok::<Entry, TracerError>(Entry::new(contender, Some(request.clone()), None))
    };
    let mut entries: Vec<Entry> =
        session.controls().into_iter().map(|(control, contender)| Entry::new(contender, None, Some(control))).collect();
    // The way and the request of every entry; controls have none.
    let mut roles: Vec<(&str, Option<TracerRequest>)> = vec![(FRESH_BUILD, None); entries.len()];
    let mut followers = Vec::new();
    for request in &plan.tracers {
        match create(request) {
            Ok(entry) => entries.push(entry),
            Err(error) => {
                updates.skipped.push(skip(request, "every way", &error));
                continue;
            }
        }
        roles.push((FRESH_BUILD, Some(request.clone())));
        for way in WAYS {
            let Some(going) = way.taken_by(request) else { continue };
            let served = (request.registration.describe)().serves(way.update);
            match served.and_then(|()| create(&going)) {
                Ok(entry) => followers.push(Follower { request: request.clone(), way: *way, entry }),
                Err(error) => updates.skipped.push(skip(request, way.name, &error)),
            }
        }
    }
    let moving =
        Moving { positions: &positions, triangles, materials, gpu: session.gpu_handle(), passes: updates.passes };
    moving.follow(&mut followers, session.viewpoint(), progress)?;
    let samples = plan.preset.samples;
    runner::sample_builds(&session, &mut entries, samples, progress);
    for follower in followers {
        roles.push((follower.way.name, Some(follower.request)));
        entries.push(follower.entry);
    }
    runner::validate(session.geometry(), &mut entries, progress);
    for rays in &session.rays {
        runner::sample_traces(&session, rays, &mut entries, samples, progress)?;
    }
    let viewpoint = records::viewpoint_record(plan, &pose, &session);
    let (mut controls, mut rows) = (Vec::new(), Vec::new());
    for (entry, (way, request)) in entries.into_iter().zip(roles) {
        match (&entry.failure, request) {
            (Some(error), Some(request)) => updates.skipped.push(skip(&request, way, error)),
            (Some(error), None) => {
                let tracer = entry.contender.description.name.to_owned();
                return Err(RunError::Tracer { tracer, error: error.clone() });
            }
            (None, None) => controls.push(runner::tracer_run(entry, &scene, &viewpoint)?),
            (None, Some(request)) => rows.push(row(runner::tracer_run(entry, &scene, &viewpoint)?, way, &request)),
        }
    }
    // A tracer's ways stand together.
    let place = |row: &UpdateRow| plan.tracers.iter().position(|request| is_of(&row.tracer, request));
    rows.sort_by_key(place);
    updates.scenes.push(SceneUpdates { scene, viewpoint, times_s, controls, rows });
    Ok(())
}

/// Whether a record is that of a request.
fn is_of(tracer: &TracerRecord, request: &TracerRequest) -> bool {
    tracer.name == request.name()
        && tracer.preset == request.preset.name()
        && tracer.parameters == records::json_values(&request.parameters)
}

/// What was measured of a tracer that was asked for as `request` and went a way.
fn row(run: TracerRun, way: &str, request: &TracerRequest) -> UpdateRow {
    let parameters = records::json_values(&request.parameters);
    let mut way_parameters = run.tracer.parameters.clone();
    way_parameters.retain(|name, value| parameters.get(name) != Some(value));
    UpdateRow {
        tracer: TracerRecord { parameters, changed: request.changed.clone(), ..run.tracer },
        way: way.to_owned(),
        way_parameters,
        update: run.build.times,
        memory: run.memory,
        structure_statistics: run.structure_statistics,
        traces: run.traces,
    }
}

/// The frames that are followed.
struct Moving<'a> {
    positions: &'a [Vec<[f32; 3]>],
    triangles: Vec<[u32; 3]>,
    materials: Vec<u32>,
    gpu: Option<Arc<Gpu>>,
    passes: u32,
}

impl Moving<'_> {
    /// One pass to warm up, then the counted ones; every pass begins with fresh builds over the first frame, outside of the
    /// times.
    fn follow(
        self,
        followers: &mut [Follower],
        viewpoint: &tracebench_api::Viewpoint,
        progress: &Progress,
    ) -> Result<(), RunError> {
        let gpu = self.gpu.as_deref();
        let mut geometry = Geometry::with_materials(self.positions[0].clone(), self.triangles, self.materials, gpu)?;
        let steps = self.positions.len() as u64 * followers.len() as u64;
        let bar = progress.bar("updates", steps * (u64::from(self.passes) + 1));
        for pass in 0..=self.passes {
            for (frame, positions) in self.positions.iter().enumerate() {
                geometry = geometry.moved_to(positions.clone(), gpu)?;
                for follower in followers.iter_mut() {
                    let update = follower.way.update;
                    let timing = follower.entry.attempt(|entry| match frame {
                        0 => entry.contender.build(&geometry, viewpoint, gpu),
                        _ => entry.contender.update(update, &geometry, viewpoint, gpu),
                    });
                    if let Some(timing) = timing.filter(|_| pass > 0 && frame > 0) {
                        follower.entry.builds.push(timing);
                    }
                    bar.inc(1);
                }
            }
        }
        Ok(())
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
        for (index, way) in WAYS.iter().enumerate() {
            assert!(WAYS[..index].iter().all(|other| other.name != way.name) && way.name != FRESH_BUILD);
            for registration in TRACERS {
                let request = TracerRequest::of(registration, Preset::Published);
                let parameters = (registration.describe)().parameters;
                let can = way.setting.is_none_or(|(name, _)| parameters.iter().any(|each| each.name == name));
                assert_eq!(way.taken_by(&request).is_some(), can, "{} of {}", way.name, request.name());
            }
        }
        let request = TracerRequest::of(&TRACERS[0], Preset::Published);
        let build = Way { name: "other", update: Update::Refit, setting: Some(("build", "fastest")) };
        let fastest = Value::Choice("fastest".to_owned());
        assert_eq!(build.taken_by(&request).unwrap().parameters.value("build"), Some(&fastest));
        let wrong = Way { setting: Some(("build", "no such")), ..build };
        assert!(wrong.taken_by(&request).is_none());
    }

    /// Frames cover the animation from begin to end, or to its middle where it comes back, and each has the vertices of its
    /// time; at the last one something has moved.
    #[test]
    fn films_cover_the_animation() {
        let mut returning = 0;
        for entry in tracebench_scenes::catalogue().iter().filter(|entry| entry.animation_s.is_some()) {
            let made = || tracebench_scenes::procedural(entry.name, 0.01).unwrap();
            let film = Film::new(made(), 4).unwrap();
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
