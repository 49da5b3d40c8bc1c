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

#[cfg(test)]
pub(crate) use math::Random;

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
    let key = |(second, &(eye, target)): (usize, &_)| CameraKey { time_s: second as f64, eye, target };
    CameraPath { keys: poses.iter().enumerate().map(key).collect(), vertical_fov_radians: VERTICAL_FOV_RADIANS }
}

/// 60 degrees.
const VERTICAL_FOV_RADIANS: f32 = std::f32::consts::FRAC_PI_3;

/// How finely curved and large surfaces are divided.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Detail {
    /// Factor on the divisions in either direction of a surface.
    factor: f64,
}

impl Detail {
    /// Divisions for `scale` times the triangles.
    pub(crate) fn new(scale: f64) -> Self {
        Self { factor: scale.sqrt() }
    }

    /// `base` divisions at scale 1, never fewer than `least`.
    pub(crate) fn divide(self, base: usize, least: usize) -> usize {
        let scaled = libm::round(base as f64 * self.factor);
        (scaled as usize).max(least)
    }

    /// Divisions around something round: at least a triangular prism.
    pub(crate) fn around(self, base: usize) -> usize {
        self.divide(base, 3)
    }

    /// Divisions along something: at least one.
    pub(crate) fn along(self, base: usize) -> usize {
        self.divide(base, 1)
    }

    /// Divisions along several sides.
    pub(crate) fn sides<const N: usize>(self, base: [usize; N]) -> [usize; N] {
        base.map(|base| self.along(base))
    }

    /// Divisions around something round and along it.
    pub(crate) fn tube(self, around: usize, along: usize) -> [usize; 2] {
        [self.around(around), self.along(along)]
    }

    /// Divisions around something round that is bent: along it never fewer than `least`.
    pub(crate) fn bend(self, around: usize, [along, least]: [usize; 2]) -> [usize; 2] {
        [self.around(around), self.divide(along, least)]
    }

    /// Divisions around the tube of a ring and around the ring.
    pub(crate) fn ring(self, tube: usize, around: usize) -> [usize; 2] {
        [self.around(tube), self.around(around)]
    }
}
