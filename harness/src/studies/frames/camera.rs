//! Where the camera is in every frame.
//!
//! It goes along the scene's path (the catalogue's, or that of a camera that a file animates) in its own time, and stands at its end; in a
//! scene without a path, or from a viewpoint that is given, it goes straight from there to the next viewpoint that
//! [`crate::viewpoint::other`] finds, evenly over all frames. From a cut on it stands at the viewpoint that this rule finds beside the
//! first.

use glam::Vec3;
use tracebench_api::Geometry;
use tracebench_scenes::Scene;

use super::{FramesRequest, Moves};
use crate::measure::{RunError, choose_pose};
use crate::plan::{Plan, ViewRequest};
use crate::truth::Truth;
use crate::viewpoint::Pose;

/// The camera's way.
pub(super) struct Way {
    /// By frame.
    pub poses: Vec<Pose>,
    /// Where it comes from, in words.
    pub said: String,
}

/// The way by the rule in this module's documentation, through a scene at the time of its first frame.
pub(super) fn way(plan: &Plan, request: &FramesRequest, scene: &Scene) -> Result<Way, RunError> {
    let mesh = &scene.mesh;
    let geometry = Geometry::new(mesh.positions.clone(), mesh.triangles.clone(), None)?;
    let truth = Truth::new(&geometry, &scene.sha256);
    let choose = |view: &ViewRequest| choose_pose(view, &scene.name, &scene.cameras, &truth);
    let frames = 0..request.frames;
    let path = scene.camera_path.as_ref().filter(|_| plan.view == ViewRequest::Default);
    let mut way = match (request.moves, path) {
        (Moves::Geometry, _) => {
            let pose = choose(&plan.view)?;
            Way { said: format!("stands at {}", pose.name), poses: vec![pose; request.frames as usize] }
        }
        (_, Some(path)) => {
            let at = |frame: u32| Pose::from(&path.at(plan.time_s + f64::from(frame) / request.fps));
            Way { poses: frames.map(at).collect(), said: "along the scene's path".to_owned() }
        }
        (_, None) => {
            let own = choose(&plan.view)?;
            let other = choose(&ViewRequest::Other(Box::new(plan.view.clone())))?;
            let last = request.frames.saturating_sub(1).max(1);
            let at = |frame: u32| between(&own, &other, f64::from(frame) / f64::from(last));
            let said = format!(
                "there is no path: straight from {} to {}, by the rule that finds another viewpoint",
                own.name, other.name
            );
            Way { poses: frames.map(at).collect(), said }
        }
    };
    if let Some(cut) = request.cut {
        let second = choose(&ViewRequest::Other(Box::new(ViewRequest::Given(way.poses[0].clone()))))?;
        way.said += &format!("; from frame {cut} on at {}", second.name);
        way.poses[cut as usize..].fill(second);
    }
    Ok(way)
}

/// So much of the way from one pose to another.
fn between(own: &Pose, other: &Pose, share: f64) -> Pose {
    let mix = |from: Vec3, to: Vec3| from.as_dvec3().lerp(to.as_dvec3(), share).as_vec3();
    let (eye, target) = (mix(own.eye, other.eye), mix(own.target, other.target));
    Pose { name: format!("{share} of the way from {} to {}", own.name, other.name), eye, target, ..own.clone() }
}
