//! A watertight ray-triangle test in f64: Woop, Benthin and Wald, *Watertight Ray/Triangle Intersection*, JCGT 2(1),
//! 2013.
//!
//! Corners are moved to the ray's origin and sheared so that the ray runs along z; the signs of three edge functions
//! decide. An edge shared by two triangles gives both the same products, so no ray slips between them. Both signs count
//! (two-sided), and a ray through an edge or a corner hits.

use glam::{DVec3, Vec3};

use super::Ray64;

/// What the test needs of a ray: the axis along which it is steepest, and its shear.
#[derive(Clone, Copy, Debug)]
pub struct RayFrame {
    axes: [usize; 3],
    shear: DVec3,
}

impl RayFrame {
    /// Prepares a ray; `None` for one without a finite direction, which hits nothing.
    pub fn new(ray: &Ray64) -> Option<Self> {
        let direction = ray.direction;
        if !direction.is_finite() || direction == DVec3::ZERO || !ray.origin.is_finite() {
            return None;
        }
        let z = direction.abs().max_position();
        let (x, y) = ((z + 1) % 3, (z + 2) % 3);
        let shear = DVec3::new(direction[x] / direction[z], direction[y] / direction[z], 1.0 / direction[z]);
        Some(Self { axes: [x, y, z], shear })
    }

    #[inline]
    fn transform(&self, ray: &Ray64, corner: Vec3) -> DVec3 {
        let moved = corner.as_dvec3() - ray.origin;
        let [x, y, z] = [moved[self.axes[0]], moved[self.axes[1]], moved[self.axes[2]]];
        DVec3::new(x - self.shear.x * z, y - self.shear.y * z, self.shear.z * z)
    }
}

/// The ray's parameter at the triangle, within the ray's span (ends included). A triangle seen exactly edge-on, or
/// without area, is not hit.
#[inline]
pub fn intersect(frame: &RayFrame, ray: &Ray64, corners: [Vec3; 3]) -> Option<f64> {
    let [a, b, c] = corners;
    let (a, b, c) = (frame.transform(ray, a), frame.transform(ray, b), frame.transform(ray, c));
    let u = c.x * b.y - c.y * b.x;
    let v = a.x * c.y - a.y * c.x;
    let w = b.x * a.y - b.y * a.x;
    if (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0) {
        return None;
    }
    let determinant = u + v + w;
    if determinant == 0.0 {
        return None;
    }
    let t = (u * a.z + v * b.z + w * c.z) / determinant;
    if !(ray.t_min..=ray.t_max).contains(&t) {
        return None;
    }
    // Seen edge-on, u, v and w may be nothing but rounding of one sign: the point is then anywhere on the ray.
    let [p, q, r] = corners.map(|corner| corner.as_dvec3());
    let slack = 1e-12 * (p.abs().max(q.abs()).max(r.abs()).max(ray.origin.abs())).max_element();
    let point = ray.at(t);
    let inside = point.cmpge(p.min(q).min(r) - slack).all() && point.cmple(p.max(q).max(r) + slack).all();
    inside.then_some(t)
}
