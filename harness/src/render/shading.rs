//! What light one answer gives, and which rays go on from it.

use std::f64::consts::PI;

use glam::{DVec3, Vec3};
use tracebench_api::Ray;

use super::{Answer, Effect, Finish, Kind, Stage};
use crate::rays::sampling::{Stream, reflect, refract};
use crate::rays::{AO_LENGTH_DIAGONALS, leave, towards};
use crate::truth::Ray64;

/// What follows from an answer to a closest-hit ray. Light is as the ray carries it: its path's share is not in it.
#[derive(Default)]
pub(super) struct Step {
    /// Light that is seen at once.
    pub(super) light: Vec3,
    /// A shadow ray, and the light that is seen if nothing stops it.
    pub(super) shadow: Option<(Ray, Vec3)>,
    /// The next ray, and the share of its light that goes on.
    pub(super) next: Option<(Ray, Vec3)>,
}

/// Where the random numbers of one place of one path come from.
#[derive(Clone, Copy)]
pub(super) struct Numbers {
    pub(super) seed: u64,
    /// Below 2^28.
    pub(super) pixel: u32,
    /// Below 2^16.
    pub(super) sample: u32,
    /// The eye's is 0.
    pub(super) bounce: u32,
}

/// Tags below are those of ray sets.
const FIRST_TAG: u64 = 64;
/// Dimensions of a bounce.
pub(super) const IN_PIXEL: u64 = 0;
const DIFFUSE: u64 = 1;
const OCCLUSION: u64 = 2;
const DIMENSIONS: u64 = 4;

impl Numbers {
    pub(super) fn stream(self, dimension: u64) -> Stream {
        let tag = FIRST_TAG + u64::from(self.bounce) * DIMENSIONS + dimension;
        Stream::new(self.seed, tag, u64::from(self.pixel) << 16 | u64::from(self.sample))
    }
}

/// Below this the axis that directions are turned about is z, else x. No normal of a scene that is built along axes or diagonals is
/// near, so that rounding turns no direction about.
const SWITCH: f64 = 0.619;

/// A unit vector with density cos(angle to `normal`) / pi.
pub(super) fn cosine(stream: &mut Stream, normal: DVec3) -> DVec3 {
    let (x, y, radius2) = stream.disk();
    let axis = if normal.z.abs() < SWITCH { DVec3::Z } else { DVec3::X };
    let across = axis.cross(normal).normalize();
    (across * x + normal.cross(across) * y + normal * (1.0 - radius2).sqrt()).normalize()
}

impl Stage {
    fn finish(&self, material: u32) -> Finish {
        // A material that does not exist is black.
        let none = Finish { kind: Kind::Lambert, colour: Vec3::ZERO };
        self.finishes.get(material as usize).copied().unwrap_or(none)
    }

    /// What an answer to a ray of a bounce gives. `forward` is the eye's direction.
    pub(super) fn step(&self, effect: Effect, ray: &Ray64, answer: &Answer, forward: DVec3, numbers: Numbers) -> Step {
        let light = |light| Step { light, ..Step::default() };
        let (position, normal, material) = match *answer {
            Answer::Hit { t, .. } | Answer::Lost { t } if effect == Effect::Depth => {
                let depth = (t * ray.direction.dot(forward)).max(0.0);
                return light(Vec3::splat((1.0 / (1.0 + 2.0 * depth / self.diagonal)) as f32));
            }
            Answer::Miss => {
                return light(match effect {
                    Effect::Depth | Effect::Normals => Vec3::ZERO,
                    Effect::Ao => Vec3::ONE,
                    _ => self.sky,
                });
            }
            Answer::Hit { position, normal, material, .. } if normal != DVec3::ZERO => (position, normal, material),
            Answer::Hit { .. } | Answer::Lost { .. } | Answer::Occluded => return Step::default(),
        };
        let front = normal.dot(ray.direction) <= 0.0;
        let normal = if front { normal } else { -normal };
        let leaves = |direction| leave(position, normal, direction, self.diagonal);
        let Finish { mut kind, colour } = self.finish(material);
        match effect {
            Effect::Normals => return light(((normal + 1.0) / 2.0).as_vec3()),
            Effect::Ao => {
                let ray = leaves(cosine(&mut numbers.stream(OCCLUSION), normal));
                let t_max = (AO_LENGTH_DIAGONALS * self.diagonal) as f32;
                return Step { shadow: Some((Ray { t_max, ..ray }, Vec3::ONE)), ..Step::default() };
            }
            Effect::Mirror if self.mirror_first && numbers.bounce == 0 => kind = Kind::Mirror,
            Effect::Mirror | Effect::Path => {}
            _ => kind = Kind::Lambert,
        }
        let goes_on = numbers.bounce < effect.bounces();
        let onwards = |direction| goes_on.then(|| (leaves(direction), colour));
        let mirrored = reflect(ray.direction, normal);
        match kind {
            Kind::Mirror => Step { next: onwards(mirrored), ..Step::default() },
            Kind::Refracting(index) => {
                let bent = refract(ray.direction, normal, if front { index } else { 1.0 / index });
                Step { next: onwards(bent.unwrap_or(mirrored)), ..Step::default() }
            }
            Kind::Lambert => {
                let way = self.light - position;
                let cosine_over_square = normal.dot(way) / way.length().powi(3);
                let lit = colour * (self.intensity / PI * cosine_over_square) as f32;
                let shadow = towards(position, normal, self.light, self.diagonal).map(|ray| (ray, lit.max(Vec3::ZERO)));
                let next = match effect {
                    Effect::Mirror => None,
                    _ => onwards(cosine(&mut numbers.stream(DIFFUSE), normal)),
                };
                Step { light: Vec3::ZERO, shadow, next }
            }
        }
    }
}
