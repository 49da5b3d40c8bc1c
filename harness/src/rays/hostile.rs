//! Rays at which tests of triangles, boxes and pixels break, a pixel's kind by its number: of every kind some are ambiguous, and some have one
//! answer all the same.

use glam::{DVec3, Vec3};
use rayon::prelude::*;
use tracebench_api::Ray;

use super::order::TILE;
use super::sampling::Stream;
use super::{Pixel, RayScene, unbounded};
use crate::truth::Ray64;

/// Tag of the streams.
const TAG: u64 = 13;

/// A number that f32 holds with fewer digits than others, which many devices take for 0.
const DENORMAL: f32 = 1e-40;

/// The longest way that a distant origin lies off, in powers of ten of the scene's diagonal.
const FAR_DECADES: f64 = 5.0;

/// How far from an edge, or beyond an origin on a surface, rays stay that have one answer, in scene diagonals.
const BESIDE_DIAGONALS: f64 = 1e-3;

pub(super) type Make = fn(&Kind<'_>, &mut Stream, bool) -> Ray;

/// Every kind of hostile ray: its name, and what makes one. Of most kinds each second ray is the `milder` one.
pub(super) const KINDS: [(&str, Make); 11] = [
    ("through vertices", |of, stream, _| of.towards(stream, 0.0)),
    ("through edges", |of, stream, _| of.towards(stream, 0.4)),
    ("along edges", |of, stream, milder| of.along_edge(stream, milder)),
    ("along axes", |of, stream, _| unbounded(of.inside(stream), axis(stream))),
    ("through borders of tiles", |of, stream, _| of.through_tile_border(stream)),
    ("through borders of faces", |of, stream, milder| of.through_face_border(stream, milder)),
    ("with -0.0", |of, stream, milder| of.with_zeros(-0.0, stream, milder)),
    ("with denormals", |of, stream, milder| of.with_zeros(DENORMAL, stream, milder)),
    ("of no length", |of, stream, milder| of.of_no_length(stream, milder)),
    ("from far away", |of, stream, _| of.far_ray(stream)),
    ("from surfaces", |of, stream, milder| of.ray_of_surface(stream, milder)),
];

/// One a pixel.
pub(super) fn hostile(scene: &RayScene<'_>) -> Vec<(Pixel, Ray)> {
    let geometry = scene.truth.geometry();
    let (low, high) = (geometry.bounds_min.as_dvec3(), geometry.bounds_max.as_dvec3());
    let of = Kind { scene, low, size: high - low };
    let ray = |pixel: Pixel| {
        let kinds = KINDS.len() as Pixel;
        let (_, make) = KINDS[(pixel % kinds) as usize];
        let mut stream = Stream::new(scene.seed, TAG, u64::from(pixel));
        (pixel, make(&of, &mut stream, pixel / kinds % 2 == 1))
    };
    (0..scene.image[0] * scene.image[1]).into_par_iter().map(ray).collect()
}

/// What a ray is made from.
pub(super) struct Kind<'a> {
    scene: &'a RayScene<'a>,
    low: DVec3,
    size: DVec3,
}

/// The axis of a coordinate system into either direction.
fn axis(stream: &mut Stream) -> DVec3 {
    let sign = if stream.unit() < 0.5 { -1.0 } else { 1.0 };
    DVec3::AXES[(stream.unit() * 3.0) as usize] * sign
}

impl Kind<'_> {
    fn diagonal(&self) -> f64 {
        self.scene.truth.diagonal()
    }

    fn inside(&self, stream: &mut Stream) -> DVec3 {
        self.low + self.size * DVec3::new(stream.unit(), stream.unit(), stream.unit())
    }

    /// The corners of any triangle, begun at any of them.
    fn corners(&self, stream: &mut Stream) -> [DVec3; 3] {
        let geometry = self.scene.truth.geometry();
        let triangle = (stream.unit() * geometry.triangles.len() as f64) as u32;
        let mut corners = geometry.corners(triangle).map(Vec3::as_dvec3);
        corners.rotate_left((stream.unit() * 3.0) as usize);
        corners
    }

    /// From anywhere in the bounds to a point of an edge; `share` 0 is its first vertex.
    fn towards(&self, stream: &mut Stream, share: f64) -> Ray {
        let (origin, [from, to, _]) = (self.inside(stream), self.corners(stream));
        unbounded(origin, (from.lerp(to, share) - origin.as_vec3().as_dvec3()).normalize_or(DVec3::X))
    }

    /// Along an edge from before its beginning; or beside it.
    fn along_edge(&self, stream: &mut Stream, milder: bool) -> Ray {
        let [from, to, other] = self.corners(stream);
        let along = (to - from).normalize_or(DVec3::X);
        let normal = along.cross(other - from).normalize_or(along.any_orthonormal_vector());
        let beside = if milder { normal * (BESIDE_DIAGONALS * self.diagonal()) } else { DVec3::ZERO };
        unbounded(from - along * (0.1 * stream.unit() * self.diagonal()) + beside, along)
    }

    /// From the eye.
    fn ray_of_eye(&self, direction: DVec3) -> Ray {
        let eye = self.scene.viewpoint.eye;
        Ray { origin: eye.into(), ..unbounded(eye.as_dvec3(), direction.normalize_or(DVec3::X)) }
    }

    /// Along the corner between four tiles of the frame.
    fn through_tile_border(&self, stream: &mut Stream) -> Ray {
        let viewpoint = self.scene.viewpoint;
        let [x, y] = viewpoint.frame.map(|edge| f64::from((stream.unit() * f64::from(edge / TILE + 1)) as u32 * TILE));
        self.ray_of_eye(viewpoint.frame_view().direction_through(x, y))
    }

    /// Where two faces of a cube round the eye meet, or three.
    fn through_face_border(&self, stream: &mut Stream, milder: bool) -> Ray {
        let mut direction = [0; 3].map(|_| 2.0 * stream.unit() - 1.0);
        let edges = if milder { 2 } else { 3 };
        direction[..edges].iter_mut().for_each(|part| *part = part.signum());
        direction.rotate_left((stream.unit() * 3.0) as usize);
        self.ray_of_eye(DVec3::from(direction))
    }

    /// Square to two axes or to one, and what is 0 is some other number that says nothing; a coordinate of the origin, too, where 0 is in
    /// the bounds.
    fn with_zeros(&self, zero: f32, stream: &mut Stream, milder: bool) -> Ray {
        let mut direction = stream.sphere();
        direction[(stream.unit() * 3.0) as usize] = 0.0;
        let direction = if milder { direction.normalize_or(DVec3::X) } else { axis(stream) };
        let mut ray = unbounded(self.inside(stream), direction);
        ray.direction = ray.direction.map(|part| if part == 0.0 { zero } else { part });
        let place = (stream.unit() * 3.0) as usize;
        if !milder && (self.low[place]..=self.low[place] + self.size[place]).contains(&0.0) {
            ray.origin[place] = zero;
        }
        Ray { t_min: zero, ..ray }
    }

    /// Where `t_min` is `t_max`: at a surface; or anywhere before the next one.
    fn of_no_length(&self, stream: &mut Stream, milder: bool) -> Ray {
        let ray = unbounded(self.inside(stream), stream.sphere());
        let hit = self.scene.truth.closest(&Ray64::from(&ray)).map_or(self.diagonal(), |hit| hit.t);
        let t = if milder { hit * stream.unit() } else { hit } as f32;
        Ray { t_min: t, t_max: t, ..ray }
    }

    /// From up to 100,000 diagonals away towards the scene.
    fn far_ray(&self, stream: &mut Stream) -> Ray {
        let (target, away) = (self.inside(stream), stream.sphere());
        let distance = self.diagonal() * 10_f64.powf(1.0 + (FAR_DECADES - 1.0) * stream.unit());
        unbounded(target + away * distance, -away)
    }

    /// From a surface as it is; `t_min` is 0, or a little beyond it.
    fn ray_of_surface(&self, stream: &mut Stream, milder: bool) -> Ray {
        let ([a, b, c], u) = (self.corners(stream), stream.unit());
        let t_min = if milder { (BESIDE_DIAGONALS * self.diagonal()) as f32 } else { 0.0 };
        Ray { t_min, ..unbounded(a.lerp(b, u).lerp(c, stream.unit()), stream.sphere()) }
    }
}
