//! Frames along the camera's path: rays and truth of their own at every one.
//!
//! The camera goes evenly along the scene's path, from its begin to its end; in a scene without one straight from the viewpoint
//! that it is seen from to another one of it ([`crate::viewpoint::other`]). A scene that moves does so over the same frames. At
//! the first frame all build. At every later one a structure that was built over the first has been brought to it in each of the
//! ways [`PATH_UPDATE_MODES`], which is what is timed. What is reused although the change invalidates it is traced and judged like all
//! others, and its rows say so.

use glam::Vec3;
use tracebench_api::{Geometry, Invalidation, Update};
use tracebench_scenes::Scene;

use super::{Followed, PATH_UPDATE_MODES, Role, measure_roles, roles};
use crate::measure::{AnimationFrames, Context, RunError, choose_pose, records};
use crate::plan::{Plan, TracerRequest, ViewRequest};
use crate::results::{Record, SceneFollowed, Skipped};
use crate::truth::Truth;
use crate::viewpoint::Pose;

/// Measures the frames of one scene, the `place`-th of the plan; nothing is said of one that cannot be walked through or built.
///
/// # Errors
/// [`RunError`] as its variants say.
pub(super) fn measure(
    place: usize,
    plan: &Plan,
    scene: Scene,
    frames: u32,
    passes: u32,
    record: &mut Record,
    context: &Context<'_>,
) -> Result<Option<SceneFollowed>, RunError> {
    let Followed { scene, times_s, positions } = Followed::new(scene, frames)?;
    let at = |frame: usize| -> Result<Scene, RunError> {
        let mut there = scene.clone();
        there.set_time(times_s[frame])?;
        Ok(there)
    };
    let first = at(0)?;
    let geometry = Geometry::new(first.mesh.positions.clone(), first.mesh.triangles.clone(), None)?;
    let poses = match poses(&first, &geometry, frames) {
        Ok(poses) => poses,
        Err(error @ RunError::NoOtherView(..)) => {
            let (scene, reason) = (first.name, format!("it has no camera path, and {error}"));
            record.skipped.push(Skipped { tracer: None, scene, rays: None, reason });
            return Ok(None);
        }
        Err(error) => return Err(error),
    };
    let built_from = poses[0].viewpoint(&geometry, plan.preset.frame, plan.preset.face);
    let plan_at = |frame: usize, plan: &Plan| Plan {
        view: ViewRequest::Given(poses[frame].clone()),
        time_s: times_s[frame],
        ..plan.clone()
    };
    let index = place * positions.len();
    let mut followed = SceneFollowed {
        scene: first.name.clone(),
        scene_sha256: first.sha256.clone(),
        times_s: times_s.clone(),
        frame_scene_sha256: vec![first.sha256.clone()],
    };
    let begun = record.rows.len();
    let mut fresh = roles(plan, &followed.scene, &[None], record);
    fresh.iter_mut().for_each(|role| role.frame = Some(0));
    measure_roles(index, &plan_at(0, plan), first, None, &fresh, record, context)?;
    // Who cannot build has been told of.
    let has_built =
        |request: &TracerRequest| record.rows[begun..].iter().any(|row| row.tracer == records::request_record(request));
    let tracers: Vec<TracerRequest> = plan.tracers.iter().filter(|request| has_built(request)).cloned().collect();
    if tracers.is_empty() {
        return Ok(None);
    }
    let plan = Plan { tracers, ..plan.clone() };
    let update_modes: Vec<_> = PATH_UPDATE_MODES.iter().map(Some).collect();
    let going = roles(&plan, &followed.scene, &update_modes, record);
    for frame in 1..positions.len() {
        context.progress.say(&format!("frame {frame} of {frames}"));
        let there = at(frame)?;
        let moved = Moved {
            geometry: there.sha256 != followed.frame_scene_sha256[0],
            viewpoint: (poses[frame].eye, poses[frame].target) != (poses[0].eye, poses[0].target),
        };
        followed.frame_scene_sha256.push(there.sha256.clone());
        let roles: Vec<Role<'_>> = going
            .iter()
            .map(|role| Role { frame: Some(frame as u32), stale_by: moved.stale(role), ..role.clone() })
            .collect();
        let both = vec![positions[0].clone(), positions[frame].clone()];
        let film = AnimationFrames::new(&there, both, Some(built_from), passes);
        measure_roles(index + frame, &plan_at(frame, &plan), there, Some(film), &roles, record, context)?;
    }
    Ok(Some(followed))
}

/// What differs from the first frame.
struct Moved {
    geometry: bool,
    viewpoint: bool,
}

impl Moved {
    /// What makes a role's structure stale: only what is reused can be.
    fn stale(&self, role: &Role<'_>) -> Vec<String> {
        let reused = role.update_mode.is_some_and(|update_mode| update_mode.update == Update::Reuse);
        let invalid = role.request.registration.describe().invalidated_by;
        let changes = [
            (self.geometry, Invalidation::Geometry, "geometry"),
            (self.viewpoint, Invalidation::Viewpoint, "viewpoint"),
        ];
        let stale = changes.iter().filter(|(moved, change, _)| reused && *moved && invalid.contains(change));
        stale.map(|(.., name)| (*name).to_owned()).collect()
    }
}

/// The camera at every frame, by the rule in this module's documentation.
fn poses(scene: &Scene, geometry: &Geometry, frames: u32) -> Result<Vec<Pose>, RunError> {
    let shares = (0..=frames).map(|frame| f64::from(frame) / f64::from(frames));
    if let Some(path) = &scene.camera_path {
        return Ok(shares.map(|share| Pose::from(&path.at(share * path.duration_s()))).collect());
    }
    let truth = Truth::new(geometry, &scene.sha256);
    let choose = |request: &ViewRequest| choose_pose(request, &scene.name, &scene.cameras, &truth);
    let own = choose(&ViewRequest::Default)?;
    let other = choose(&ViewRequest::Other(Box::new(ViewRequest::Default)))?;
    let between = |share: f64| {
        let mix = |from: Vec3, to: Vec3| from.as_dvec3().lerp(to.as_dvec3(), share).as_vec3();
        let (eye, target) = (mix(own.eye, other.eye), mix(own.target, other.target));
        Pose { name: format!("{share} of the way from {} to {}", own.name, other.name), eye, target, ..own.clone() }
    };
    Ok(shares.map(between).collect())
}

#[cfg(test)]
mod tests;
