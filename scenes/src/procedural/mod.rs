//! Procedural scenes: the same bit for bit on every machine.
//!
//! Only additions, multiplications, divisions and square roots, which IEEE 754 defines exactly, and `libm`'s portable
//! functions are used; positions are computed in f64 and rounded to f32 once. Random choices come from a seeded
//! generator that is part of this crate.

mod builder;
mod math;
pub(crate) mod room;
mod shapes;

use crate::scene::{Camera, Mesh};

/// What the builder of a procedural scene hands over.
pub(crate) struct Built {
    pub(crate) mesh: Mesh,
    pub(crate) cameras: Vec<Camera>,
}

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
}
