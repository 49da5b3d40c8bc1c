//! The watertight way through a CWBVH: Woop, Benthin, Wald, *Watertight Ray/Triangle Intersection*, JCGT 2(1), 2013, in boxes
//! that no rounding makes too small (Ize, *Robust BVH Ray Traversal*, JCGT 2(2), 2013).
//!
//! As in the paper corners are moved to the ray's origin and sheared so that the ray runs along z, in f32, and edge functions
//! of which one is exactly zero are computed again in f64, where products are exact. An edge that two triangles share has the
//! same corners in both, so its sign in the one is opposite to that in the other. Both faces are hit, and zero is inside. t is
//! that of the triangle's plane, in f64, held between the corners' own: the weights of thin triangles are rounded at the scale
//! of their distance.

use glam::{DVec3, Vec2, Vec3A, dvec3, vec3a};
use obvhs::aabb::Aabb;
use obvhs::cwbvh::node::{CwBvhNode, extract_byte64};
use obvhs::ray::Ray;
use obvhs::triangle::Triangle;

use super::Test;

/// By how much boxes are wider on every side, over the greatest distance R of the scene's bounds from the ray's origin along an
/// axis. With u = 2^-24: sheared corners are off by 6 u R; planes of boxes by 4 u of their distance and their node's width, at
/// most 5 R together, and so are those of the axis that they are compared with; a box is cut by 16 u R at most, since obvhs
/// rounds a logarithm; directions that are nearer to an axis than 2^-23 are taken to be so far from it, 4 u R. That is 66 u R.
const BOX_SLACK: f32 = 1.0 / (1 << 17) as f32;

/// A ray among the triangles of the leaves.
#[derive(Clone, Copy)]
pub(super) struct Watertight<'a> {
    triangles: &'a [Triangle],
    /// The axis that is z in the sheared frame.
    axis: usize,
    /// x and y of the frame per unit of z; 0.
    shear: Vec3A,
    /// By how much planes of boxes are moved along the ray.
    slack: Vec3A,
}

/// A vector with this axis last, the others in turn.
fn turned(vector: Vec3A, axis: usize) -> Vec3A {
    match axis {
        0 => vec3a(vector.y, vector.z, vector.x),
        1 => vec3a(vector.z, vector.x, vector.y),
        _ => vector,
    }
}

/// Whether edge functions say that the ray passes outside.
fn passes_by(edges: [f64; 3]) -> bool {
    edges.iter().any(|edge| *edge < 0.0) && edges.iter().any(|edge| *edge > 0.0)
}

impl<'a> Watertight<'a> {
    pub(super) fn new(triangles: &'a [Triangle], bounds: &Aabb, ray: &Ray) -> Self {
        let axis = ray.direction.abs().max_position();
        let along = turned(ray.direction, axis);
        let distance = (bounds.min - ray.origin).abs().max((bounds.max - ray.origin).abs()).max_element();
        Self {
            triangles,
            axis,
            shear: vec3a(along.x / along.z, along.y / along.z, 0.0),
            slack: ray.inv_direction.abs() * (distance * BOX_SLACK),
        }
    }

    /// t and the weights of the second and third corner; none for a ray that passes by or lies in the triangle's plane.
    fn cross(&self, slot: usize, ray: &Ray) -> Option<(f64, Vec2)> {
        let Triangle { v0, v1, v2 } = self.triangles[slot];
        let [a, b, c] = [v0, v1, v2].map(|corner| {
            let local = turned(corner - ray.origin, self.axis);
            local - self.shear * local.z
        });
        // Rounding makes of a sign zero at worst.
        let edges = [c.x * b.y - c.y * b.x, a.x * c.y - a.y * c.x, b.x * a.y - b.y * a.x];
        let mut edges = edges.map(f64::from);
        if passes_by(edges) {
            return None;
        }
        if edges.contains(&0.0) {
            let [a, b, c] = [a, b, c].map(|corner| corner.as_dvec3());
            edges = [c.x * b.y - c.y * b.x, a.x * c.y - a.y * c.x, b.x * a.y - b.y * a.x];
            if passes_by(edges) {
                return None;
            }
        }
        let edges = DVec3::from(edges);
        let determinant = edges.element_sum();
        if determinant == 0.0 {
            return None;
        }
        let (origin, direction) = (ray.origin.as_dvec3(), ray.direction.as_dvec3());
        let [p, q, r] = [v0, v1, v2].map(|corner| corner.as_dvec3() - origin);
        let depths = dvec3(a.z.into(), b.z.into(), c.z.into()) / direction[self.axis];
        let normal = (q - p).cross(r - p);
        let slope = normal.dot(direction);
        let t = match slope == 0.0 {
            true => edges.dot(depths) / determinant,
            false => (normal.dot(p) / slope).clamp(depths.min_element(), depths.max_element()),
        };
        Some((t, Vec2::new((edges.y / determinant) as f32, (edges.z / determinant) as f32)))
    }
}

impl Test for Watertight<'_> {
    /// As obvhs's own, eight at once for the compiler to make vectors of.
    fn children(&self, node: &CwBvhNode, ray: &Ray, octants: u32) -> u32 {
        let factor = node.compute_extent() * ray.inv_direction;
        let base = (Vec3A::from(node.p) - ray.origin) * ray.inv_direction;
        let (near, far) = (base - self.slack, base + self.slack);
        let planes = [
            (&node.child_min_x, &node.child_max_x),
            (&node.child_min_y, &node.child_max_y),
            (&node.child_min_z, &node.child_max_z),
        ];
        let (mut enter, mut leave) = ([ray.tmin; 8], [ray.tmax; 8]);
        for (axis, (low, high)) in planes.into_iter().enumerate() {
            let (first, last) = if ray.inv_direction[axis] < 0.0 { (high, low) } else { (low, high) };
            for child in 0..8 {
                let enters = f32::from(first[child]) * factor[axis] + near[axis];
                let leaves = f32::from(last[child]) * factor[axis] + far[axis];
                // Without the built-ins' promises for what is no number.
                enter[child] = if enters > enter[child] { enters } else { enter[child] };
                leave[child] = if leaves < leave[child] { leaves } else { leave[child] };
            }
        }
        let (bits, places) = node.get_child_and_index_bits(octants);
        let met = |child: usize| u32::from(enter[child] <= leave[child]);
        (0..8).fold(0, |mask, child| mask | (met(child) * extract_byte64(bits, child)) << extract_byte64(places, child))
    }

    fn t(&self, slot: usize, ray: &Ray) -> f32 {
        let t = self.cross(slot, ray).map_or(f32::INFINITY, |(t, _)| t as f32);
        if t >= ray.tmin { t } else { f32::INFINITY }
    }

    fn weights(&self, slot: usize, ray: &Ray) -> Vec2 {
        self.cross(slot, ray).map_or(Vec2::ZERO, |(_, weights)| weights)
    }
}
