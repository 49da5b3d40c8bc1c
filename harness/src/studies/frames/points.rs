//! Flicker of answers: surface points with directions that are fixed in their triangles, traced in every frame in which they are seen.

use std::sync::Arc;

use glam::DVec3;
use rayon::prelude::*;
use tracebench_api::{Ray, Viewpoint};

use crate::rays::sampling::Stream;
use crate::rays::{lift, unbounded};
use crate::truth::{Ray64, Truth};

/// Points, at most.
const POINTS: u64 = 8_192;

/// Tells the numbers that points are drawn by from those of rays.
const TAG: u64 = 0xf11c;

/// A point may be hidden by what is nearer by less than this share of its distance: itself.
const OWN_SHARE: f64 = 1e-6;

/// A point on a triangle with a direction.
struct Point {
    primitive: u32,
    /// Weights of the second and the third corner.
    weights: [f64; 2],
    /// Along the first edge, along the normal on the side that is seen, and square to both.
    direction: DVec3,
    /// Whether the side of the winding is the one that is seen.
    front: bool,
}

/// The points of a scene.
pub(super) struct Points(Vec<Point>);

/// A triangle's first corner, its edges from there, and its frame: along the first edge, the normal, and square to both.
fn frame(truth: &Truth, primitive: u32, front: bool) -> ([DVec3; 3], [DVec3; 3]) {
    let [a, b, c] = truth.geometry().corners(primitive).map(|corner| corner.as_dvec3());
    let normal = truth.normal(primitive) * if front { 1.0 } else { -1.0 };
    let along = (b - a).normalize_or_zero();
    ([a, b - a, c - a], [along, normal, normal.cross(along)])
}

impl Points {
    /// Points that are seen through random pixels from any of some viewpoints, as many from each; directions are cosine-distributed.
    pub(super) fn new(seen: &[(&Truth, &Viewpoint)], seed: u64) -> Self {
        let each = POINTS / seen.len().max(1) as u64;
        let drawn = (0..seen.len() as u64).flat_map(|view| (0..each).map(move |index| (view, index)));
        let point = |(view, index): (u64, u64)| {
            let (truth, viewpoint) = seen[view as usize];
            let mut stream = Stream::new(seed, TAG, view * POINTS + index);
            let (view, [width, height]) = (viewpoint.frame_view(), viewpoint.frame.map(f64::from));
            let way = view.direction_through(stream.unit() * width, stream.unit() * height).normalize();
            let ray = Ray64::from(&unbounded(view.eye, way));
            let hit = truth.closest(&ray)?;
            let front = truth.normal(hit.primitive).dot(ray.direction) <= 0.0;
            let ([a, b, c], [along, normal, across]) = frame(truth, hit.primitive, front);
            let direction = stream.cosine(normal);
            let direction = DVec3::new(direction.dot(along), direction.dot(normal), direction.dot(across));
            Some(Point { primitive: hit.primitive, weights: weights(ray.at(hit.t) - a, b, c)?, direction, front })
        };
        Self(drawn.collect::<Vec<_>>().into_par_iter().filter_map(point).collect())
    }

    pub(super) fn len(&self) -> usize {
        self.0.len()
    }

    /// The rays of those that are seen, each with its point's place.
    pub(super) fn rays(&self, truth: &Truth, viewpoint: &Viewpoint) -> (Vec<usize>, Arc<Vec<Ray>>) {
        let eye = viewpoint.eye.as_dvec3();
        let view = viewpoint.frame_view();
        let ray = |(index, point): (usize, &Point)| {
            let ([a, b, c], [along, normal, across]) = frame(truth, point.primitive, point.front);
            let at = a + b * point.weights[0] + c * point.weights[1];
            let (way, distance) = (at - eye, at.distance(eye));
            if way.dot(normal) >= 0.0 || view.project_inside(at).is_none() {
                return None;
            }
            let sight =
                Ray64 { origin: eye, direction: way / distance, t_min: 0.0, t_max: distance * (1.0 - OWN_SHARE) };
            let is_hidden = truth.closest(&sight).is_some_and(|hit| hit.primitive != point.primitive);
            let direction = along * point.direction.x + normal * point.direction.y + across * point.direction.z;
            (!is_hidden).then(|| (index, unbounded(lift(at, normal, truth.diagonal()), direction)))
        };
        let (places, rays) = self.0.par_iter().enumerate().filter_map(ray).collect::<Vec<_>>().into_iter().unzip();
        (places, Arc::new(rays))
    }
}

/// Weights of the edges of a triangle that lead to a point in its plane.
fn weights(to: DVec3, b: DVec3, c: DVec3) -> Option<[f64; 2]> {
    let (bb, bc, cc, tb, tc) = (b.dot(b), b.dot(c), c.dot(c), to.dot(b), to.dot(c));
    let determinant = bb * cc - bc * bc;
    (determinant > 0.0).then(|| [(cc * tb - bc * tc) / determinant, (bb * tc - bc * tb) / determinant])
}
