//! Procedural scenes: the same bit for bit on every machine.
//!
//! Only additions, multiplications, divisions and square roots, which IEEE 754 defines exactly, and `libm`'s portable
//! functions are used; positions are computed in f64 and rounded to f32 once. Random choices come from a seeded
//! generator that is part of this crate.

pub(crate) mod atrium;
mod builder;
pub(crate) mod candy;
pub(crate) mod cloth;
pub(crate) mod foliage;
mod furnish;
pub(crate) mod hangar;
mod math;
mod parts;
pub(crate) mod room;
mod shapes;
pub(crate) mod smithy;
pub(crate) mod solids;

use crate::scene::{Camera, CameraKey, CameraPath, Mesh};

/// What the builder of a procedural scene hands over.
pub(crate) struct Built {
    pub(crate) mesh: Mesh,
    pub(crate) cameras: Vec<Camera>,
    pub(crate) path: CameraPath,
}

/// A camera's name, its eye and what it looks at.
pub(crate) type NamedPose = (&'static str, [f32; 3], [f32; 3]);

/// Upright cameras with 60 degrees of vertical field of view.
pub(crate) fn cameras(poses: &[NamedPose]) -> Vec<Camera> {
    poses
        .iter()
        .map(|&(name, eye, target)| Camera {
            name: name.to_owned(),
            eye,
            target,
            up: [0.0, 1.0, 0.0],
            vertical_fov_radians: VERTICAL_FOV_RADIANS,
        })
        .collect()
}

/// A path with a pose (eye and target) each second.
pub(crate) fn path(poses: &[([f32; 3], [f32; 3])]) -> CameraPath {
    let key =
        |(second, &(eye, target)): (usize, &_)| CameraKey { time_s: second as f64, eye, target, up: [0.0, 1.0, 0.0] };
    CameraPath { keys: poses.iter().enumerate().map(key).collect(), vertical_fov_radians: VERTICAL_FOV_RADIANS }
}

/// 60 degrees.
const VERTICAL_FOV_RADIANS: f32 = std::f32::consts::FRAC_PI_3;
