//! The pictures once more, recursively, in f64, from brute force: it shares with what it checks the random numbers and the stage alone.

use std::f64::consts::PI;

use glam::{DVec3, Vec3};
use tracebench_api::Viewpoint;

use super::super::shading::Numbers;
use super::{Effect, Kind, LinearImage, Model, SEED, SIZE, Stage};
use crate::rays::sampling::Stream;

pub(super) const SPP: u32 = 2;

#[derive(Clone, Copy)]
pub(super) struct Found {
    pub(super) t: f64,
    normal: DVec3,
    material: u32,
}

/// The nearest triangle by Möller and Trumbore's test.
pub(super) fn closest(model: &Model, origin: DVec3, direction: DVec3, t_max: f64) -> Option<Found> {
    let mut nearest: Option<Found> = None;
    for (corners, material) in model.triangles.iter().zip(&model.triangle_materials) {
        let [a, b, c] = corners.map(|corner| Vec3::from(model.positions[corner as usize]).as_dvec3());
        let (e, f) = (b - a, c - a);
        let p = direction.cross(f);
        let determinant = e.dot(p);
        let s = origin - a;
        let u = s.dot(p) / determinant;
        let q = s.cross(e);
        let v = direction.dot(q) / determinant;
        let t = f.dot(q) / determinant;
        let inside = u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t >= 0.0 && t <= t_max;
        if inside && nearest.is_none_or(|nearest| t < nearest.t) {
            nearest = Some(Found { t, normal: e.cross(f).normalize(), material: *material });
        }
    }
    nearest
}

struct Renderer<'a> {
    model: &'a Model,
    stage: &'a Stage,
    effect: Effect,
    forward: DVec3,
}

impl Renderer<'_> {
    fn offset(&self) -> f64 {
        1e-5 * self.stage.diagonal
    }

    fn direct(&self, point: DVec3, normal: DVec3, colour: DVec3) -> DVec3 {
        let way = self.stage.light - point;
        if way.dot(normal) <= 0.0 {
            return DVec3::ZERO;
        }
        let distance = way.length();
        let blocked = closest(self.model, point + normal * self.offset(), way / distance, distance).is_some();
        if blocked {
            return DVec3::ZERO;
        }
        colour / PI * self.stage.intensity * (way.dot(normal) / distance) / (distance * distance)
    }

    /// A point of the disk, lifted to the hemisphere.
    fn scattered(normal: DVec3, mut stream: Stream) -> DVec3 {
        let (x, y, _) = stream.disk();
        let helper = if normal.z.abs() < 0.619 { DVec3::Z } else { DVec3::X };
        let tangent = helper.cross(normal).normalize();
        tangent * x + normal.cross(tangent) * y + normal * (1.0 - x * x - y * y).sqrt()
    }

    fn light(&self, origin: DVec3, direction: DVec3, bounce: u32, numbers: Numbers) -> DVec3 {
        let stage = self.stage;
        let Some(found) = closest(self.model, origin, direction, f64::INFINITY) else {
            return match self.effect {
                Effect::Depth | Effect::Normals => DVec3::ZERO,
                Effect::Ao => DVec3::ONE,
                _ => stage.sky.as_dvec3(),
            };
        };
        let outside = found.normal.dot(direction) < 0.0;
        let normal = if outside { found.normal } else { -found.normal };
        let point = origin + direction * found.t;
        let above = point + normal * self.offset();
        let finish = stage.finishes[found.material as usize];
        let colour = finish.colour.as_dvec3();
        let follows = |most: u32, start: DVec3, direction: DVec3| {
            if bounce < most { colour * self.light(start, direction, bounce + 1, numbers) } else { DVec3::ZERO }
        };
        let kind = match self.effect {
            Effect::Mirror | Effect::Path => finish.kind,
            _ => Kind::Lambert,
        };
        match self.effect {
            Effect::Depth => {
                let depth = (direction * found.t).dot(self.forward);
                return DVec3::splat(stage.diagonal / (stage.diagonal + 2.0 * depth));
            }
            Effect::Normals => return normal * 0.5 + 0.5,
            Effect::Ao => {
                let direction = Self::scattered(normal, Numbers { bounce, ..numbers }.stream(2));
                let blocked = closest(self.model, above, direction, 0.1 * stage.diagonal).is_some();
                return DVec3::splat(if blocked { 0.0 } else { 1.0 });
            }
            Effect::Primary | Effect::Mirror | Effect::Diffuse | Effect::Path => {}
        }
        let mirrored = direction - 2.0 * direction.dot(normal) * normal;
        match (kind, self.effect) {
            (Kind::Mirror, _) => follows(4, above, mirrored),
            (Kind::Refracting(index), _) => {
                let ratio = if outside { 1.0 / index } else { index };
                let across = (direction - direction.dot(normal) * normal) * ratio;
                let left = 1.0 - across.length_squared();
                if left < 0.0 {
                    follows(4, above, mirrored)
                } else {
                    follows(4, point - normal * self.offset(), across - normal * left.sqrt())
                }
            }
            (Kind::Lambert, effect) => {
                let most = match effect {
                    Effect::Diffuse => 1,
                    Effect::Path => 4,
                    _ => 0,
                };
                let direct = self.direct(point, normal, colour);
                direct + follows(most, above, Self::scattered(normal, Numbers { bounce, ..numbers }.stream(1)))
            }
        }
    }
}

/// The mean of two samples a pixel.
pub(super) fn image(model: &Model, stage: &Stage, effect: Effect, viewpoint: &Viewpoint) -> LinearImage {
    let forward = viewpoint.forward.as_dvec3();
    let (up, half) = (viewpoint.up.as_dvec3(), (f64::from(viewpoint.vertical_fov) / 2.0).tan());
    let right = forward.cross(up);
    let renderer = Renderer { model, stage, effect, forward };
    let [width, height] = SIZE.map(f64::from);
    let pixel = |pixel: u32| -> [f32; 3] {
        let mut sum = DVec3::ZERO;
        for sample in 0..SPP {
            let numbers = Numbers { seed: SEED, pixel, sample, bounce: 0 };
            let mut stream = numbers.stream(0);
            let [x, y] = if sample == 0 { [0.5; 2] } else { [stream.unit(), stream.unit()] };
            let x = (f64::from(pixel % SIZE[0]) + x) / width * 2.0 - 1.0;
            let y = 1.0 - (f64::from(pixel / SIZE[0]) + y) / height * 2.0;
            let direction = forward + right * (x * half * width / height) + up * (y * half);
            sum += renderer.light(viewpoint.eye.as_dvec3(), direction.normalize(), 0, numbers);
        }
        (sum / f64::from(SPP)).as_vec3().into()
    };
    LinearImage { size: SIZE, pixels: (0..SIZE[0] * SIZE[1]).map(pixel).collect() }
}
