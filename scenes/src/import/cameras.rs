//! Perspective cameras of the scene, in the order of its nodes.

use std::collections::HashMap;

use glam::{DMat4, DVec3};
use gltf::json::Root;

use super::nodes::Placed;
use super::rig::Rig;
use crate::scene::{Camera, CameraKey, CameraPath};

/// Keys a second of a path.
const KEYS_PER_S: f64 = 120.0;

/// Most numbers that all keys of a path are computed from.
const MAX_PATH_WORK: usize = 4_000_000;

/// Every camera that can be looked through; a word in `warnings` for every other one. `worlds` has the transform of each
/// placed node to world space.
pub(super) fn collect(root: &Root, placed: &[Placed], worlds: &[DMat4], warnings: &mut Vec<String>) -> Vec<Camera> {
    let mut cameras: Vec<Camera> = Vec::new();
    let mut names = Names::default();
    for (place, world) in placed.iter().zip(worlds) {
        let Some(node) = root.nodes.get(place.node) else {
            continue;
        };
        let Some(camera) = node.camera.and_then(|index| root.get(index)) else {
            continue;
        };
        let name = camera
            .name
            .clone()
            .or_else(|| node.name.clone())
            .filter(|name| !name.trim().is_empty())
            .unwrap_or_else(|| format!("camera-{}", cameras.len()));
        let Some(perspective) = &camera.perspective else {
            warnings.push(format!(
                "camera '{name}' is skipped: it is orthographic, and only perspective cameras are supported"
            ));
            continue;
        };
        let name = names.unique(name);
        match aim(world, perspective.yfov) {
            Some((eye, target, up)) => {
                cameras.push(Camera { name, eye, target, up, vertical_fov_radians: perspective.yfov });
            }
            None => {
                warnings.push(format!("camera '{name}' is skipped: its transform or its field of view is degenerate"));
            }
        }
    }
    cameras
}

/// The way of the first camera that the animation moves, as 120 keys a second (fewer where it is long and the nodes are many); none
/// where none moves. A word in `warnings` for one that cannot be looked through all along.
pub(super) fn path(root: &Root, rig: &Rig, warnings: &mut Vec<String>) -> Option<CameraPath> {
    let duration_s = rig.duration_s();
    let yfov = |place: &Placed| {
        let camera = root.nodes.get(place.node)?.camera.and_then(|index| root.get(index))?;
        Some(camera.perspective.as_ref()?.yfov)
    };
    let mut moving = rig.placed.iter().zip(rig.moving_nodes()).enumerate().filter(|(_, (_, moves))| *moves);
    let (place, yfov) =
        moving.find_map(|(index, (place, _))| Some((index, yfov(place)?))).filter(|_| duration_s > 0.0)?;
    let most = (MAX_PATH_WORK / rig.size().max(1)).max(1);
    let steps = ((duration_s * KEYS_PER_S).ceil() as usize).clamp(1, most);
    let key = |step: usize| {
        let time_s = duration_s * step as f64 / steps as f64;
        let (eye, target, up) = aim(&rig.pose(time_s).worlds[place], yfov)?;
        Some(CameraKey { time_s, eye, target, up })
    };
    let keys: Option<Vec<CameraKey>> = (0..=steps).map(key).collect();
    if keys.is_none() {
        warnings.push("the camera that moves is degenerate on its way: the path is ignored".to_owned());
    }
    Some(CameraPath { keys: keys?, vertical_fov_radians: yfov })
}

/// Eye, target and up of a camera that looks along its node's -Z; scale and shear are taken out.
fn aim(world: &DMat4, yfov: f32) -> Option<([f32; 3], [f32; 3], [f32; 3])> {
    if !(yfov > 0.0 && yfov < std::f32::consts::PI) {
        return None;
    }
    let eye = world.w_axis.truncate();
    let forward = -world.z_axis.truncate().try_normalize()?;
    let upward = world.y_axis.truncate().try_normalize()?;
    let up = upward - forward * upward.dot(forward);
    if up.length() < 1e-6 {
        return None;
    }
    let up = up.try_normalize()?;
    // Far from the origin one unit ahead would drown in f32 rounding.
    let ahead = (eye.abs().max_element() / 16.0).max(1.0);
    let target = eye + forward * ahead;
    let in_range = |point: DVec3| point.abs().max_element() <= super::MAX_COORDINATE;
    if !(eye.is_finite() && in_range(eye) && in_range(target)) {
        return None;
    }
    Some((eye.as_vec3().to_array(), target.as_vec3().to_array(), up.as_vec3().to_array()))
}

/// Names that are taken, and for each the number with which the search for a free one goes on: many nodes may hold one
/// camera, and searching from the start for each would take the cube of their number.
#[derive(Default)]
struct Names(HashMap<String, u32>);

impl Names {
    /// `name`, or with the first free number from 2 on behind it.
    fn unique(&mut self, name: String) -> String {
        let Some(&next) = self.0.get(&name) else {
            self.0.insert(name.clone(), 2);
            return name;
        };
        let mut number = next;
        let mut candidate = format!("{name}-{number}");
        while self.0.contains_key(&candidate) {
            number += 1;
            candidate = format!("{name}-{number}");
        }
        self.0.insert(name, number + 1);
        self.0.insert(candidate.clone(), 2);
        candidate
    }
}
