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
pub(crate) mod hangar;
mod math;
mod parts;
pub(crate) mod room;
mod shapes;
pub(crate) mod smithy;
pub(crate) mod solids;

/// The words that all scenes are written in.
mod prelude {
    pub(super) use super::builder::{Ends, MaterialId, MeshBuilder, matt, palette};
    pub(super) use super::math::*;
    pub(super) use super::parts::CORNERS;
    pub(super) use super::shapes::{knots, line, smooth_profile, steps, straight_profile};
    pub(super) use crate::scene::{Material, Mesh};
    pub(super) use glam::{DVec2, DVec3, dvec2, dvec3};
}
