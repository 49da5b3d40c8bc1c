//! Whether a case shows its difficulty: what truth says of its rays, without any tracer.

use glam::DVec3;
use tracebench_api::View;

use super::Setup;
use crate::truth::{Answer, Ray64, TrueHit, Truth};

/// A case at one strength with its truth.
pub struct Probe<'a> {
    /// The case.
    pub setup: &'a Setup,
    /// The truth of its scene.
    pub truth: &'a Truth,
    /// The truth of its rays.
    pub answers: &'a [Answer],
}

impl Probe<'_> {
    /// A ray.
    pub fn ray(&self, index: usize) -> Ray64 {
        Ray64::from(&self.setup.rays[index])
    }

    /// What it truly hits.
    pub fn hit(&self, index: usize) -> Option<TrueHit> {
        self.answers[index].hit
    }

    /// Where.
    pub fn point(&self, index: usize) -> Option<DVec3> {
        self.hit(index).map(|hit| self.ray(index).at(hit.t))
    }

    /// The frame's view.
    pub fn view(&self) -> View {
        self.setup.viewpoint.frame_view()
    }

    /// Edge of the frame's pixels at a point, scene units.
    pub fn pixel(&self, point: DVec3) -> f64 {
        let view = self.view();
        2.0 * view.tan_half_height / f64::from(view.size[1]) * (point - view.eye).dot(view.forward).abs()
    }

    /// Longest edge and least height of the triangle that a ray hits.
    pub fn triangle(&self, index: usize) -> Option<(f64, f64)> {
        let [a, b, c] = self.truth.geometry().corners(self.hit(index)?.primitive).map(|corner| corner.as_dvec3());
        let longest = (b - a).length().max((c - b).length()).max((a - c).length());
        Some((longest, (b - a).cross(c - a).length() / longest))
    }

    /// Whether what a ray hits is less than so many of the frame's pixels wide.
    pub fn is_thinner(&self, index: usize, pixels: f64) -> bool {
        let triangle = self.triangle(index).zip(self.point(index));
        triangle.is_some_and(|((_, least), point)| least < pixels * self.pixel(point))
    }

    /// Surfaces along a ray from its first hit on, over a length in scene units; counted up to `most`.
    pub fn surfaces(&self, index: usize, length: f64, most: usize) -> usize {
        let Some(first) = self.hit(index) else { return 0 };
        let mut ray = Ray64 { t_max: first.t + length, ..self.ray(index) };
        let mut count = 0;
        while count < most {
            let Some(hit) = self.truth.closest(&ray) else { break };
            count += 1;
            ray.t_min = hit.t + 1e-9 * self.truth.diagonal();
        }
        count
    }
}
