//! Nearest points of the scene, and what of it lies in a box, in f64.

use glam::DVec3;
use tracebench_api::Geometry;

use super::{Hierarchy, Pieces};

/// The nearest point of the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nearest {
    /// How far it is, scene units.
    pub distance: f64,
    /// The triangle that it lies on.
    pub primitive: u32,
}

impl Hierarchy {
    /// The triangle nearest to a point, if one is within a distance; of one piece of mesh alone, if it is said.
    pub fn nearest(
        &self,
        geometry: &Geometry,
        point: DVec3,
        within: f64,
        of: Option<(&Pieces, u32)>,
    ) -> Option<Nearest> {
        let mut best: Option<Nearest> = None;
        let mut limit = within;
        let distance_to = |index: usize| {
            let aabb = self.bvh.nodes[index].aabb();
            let (low, high) = (aabb.min.as_dvec3(), aabb.max.as_dvec3());
            (point - point.clamp(low, high)).length()
        };
        let holds = |index: usize| of.is_none_or(|(pieces, piece)| pieces.node_may_hold(index, piece));
        let mut open: Vec<(f64, usize)> = Vec::with_capacity(64);
        if !self.bvh.nodes.is_empty() {
            open.push((distance_to(0), 0));
        }
        while let Some((distance, index)) = open.pop() {
            // Boxes are the triangles' own, in the same coordinates: nothing is lost by rounding but in the last bits.
            if distance > limit * (1.0 + 1e-12) || !holds(index) {
                continue;
            }
            let node = &self.bvh.nodes[index];
            let first = node.first_index as usize;
            if node.is_leaf() {
                for slot in first..first + node.prim_count as usize {
                    let primitive = self.bvh.primitive_indices[slot];
                    if of.is_some_and(|(pieces, piece)| pieces.of_triangle(primitive) != piece) {
                        continue;
                    }
                    let [a, b, c] = geometry.corners(primitive);
                    let distance = point.distance(nearest_point(point, [a.as_dvec3(), b.as_dvec3(), c.as_dvec3()]));
                    if distance <= limit {
                        limit = distance;
                        best = Some(Nearest { distance, primitive });
                    }
                }
                continue;
            }
            let (one, other) = ((distance_to(first), first), (distance_to(first + 1), first + 1));
            // The nearer one is opened first: it goes on the stack last.
            let (farther, nearer) = if one.0 < other.0 { (other, one) } else { (one, other) };
            open.push(farther);
            open.push(nearer);
        }
        best
    }

    /// Shows every triangle whose bounds overlap a box.
    pub fn in_box(&self, geometry: &Geometry, low: DVec3, high: DVec3, mut show: impl FnMut(u32)) {
        let apart = |least: DVec3, greatest: DVec3| least.cmpgt(high).any() || greatest.cmplt(low).any();
        let mut open: Vec<usize> = if self.bvh.nodes.is_empty() { Vec::new() } else { vec![0] };
        while let Some(index) = open.pop() {
            let node = &self.bvh.nodes[index];
            let aabb = node.aabb();
            if apart(aabb.min.as_dvec3(), aabb.max.as_dvec3()) {
                continue;
            }
            let first = node.first_index as usize;
            if !node.is_leaf() {
                open.extend([first, first + 1]);
                continue;
            }
            for slot in first..first + node.prim_count as usize {
                let primitive = self.bvh.primitive_indices[slot];
                let [a, b, c] = geometry.corners(primitive).map(|corner| corner.as_dvec3());
                if !apart(a.min(b).min(c), a.max(b).max(c)) {
                    show(primitive);
                }
            }
        }
    }

    /// Of every node the least and the greatest number of a piece that it holds.
    pub(super) fn piece_ranges(&self, of_triangle: &[u32]) -> Vec<[u32; 2]> {
        let mut ranges = vec![[u32::MAX, 0]; self.bvh.nodes.len()];
        let mut open: Vec<(usize, bool)> = if self.bvh.nodes.is_empty() { Vec::new() } else { vec![(0, false)] };
        while let Some((index, children_known)) = open.pop() {
            let node = &self.bvh.nodes[index];
            let first = node.first_index as usize;
            if node.is_leaf() {
                let pieces = (first..first + node.prim_count as usize)
                    .map(|slot| of_triangle[self.bvh.primitive_indices[slot] as usize]);
                ranges[index] = pieces.fold([u32::MAX, 0], |[low, high], piece| [low.min(piece), high.max(piece)]);
            } else if children_known {
                let [one, other] = [ranges[first], ranges[first + 1]];
                ranges[index] = [one[0].min(other[0]), one[1].max(other[1])];
            } else {
                open.extend([(index, true), (first, false), (first + 1, false)]);
            }
        }
        ranges
    }
}

/// The point of a triangle that is nearest to a point (Ericson, *Real-Time Collision Detection*, 5.1.5); of one without area, of
/// its edges.
pub fn nearest_point(point: DVec3, [a, b, c]: [DVec3; 3]) -> DVec3 {
    let (along, across) = (b - a, c - a);
    let normal = along.cross(across);
    let area = normal.length_squared();
    if area > 0.0 {
        let offset = point - a;
        let v = offset.cross(across).dot(normal) / area;
        let w = along.cross(offset).dot(normal) / area;
        if v >= 0.0 && w >= 0.0 && v + w <= 1.0 {
            return a + along * v + across * w;
        }
    }
    // Outside of the triangle, seen along its normal, the nearest point lies on an edge.
    let nearer = |one: DVec3, other: DVec3| {
        if point.distance_squared(other) < point.distance_squared(one) { other } else { one }
    };
    nearer(nearer(nearest_on_edge(point, a, b), nearest_on_edge(point, b, c)), nearest_on_edge(point, c, a))
}

fn nearest_on_edge(point: DVec3, from: DVec3, to: DVec3) -> DVec3 {
    let along = to - from;
    let length = along.length_squared();
    if length == 0.0 {
        return from;
    }
    from + along * ((point - from).dot(along) / length).clamp(0.0, 1.0)
}

/// The area of a triangle within a box (Sutherland, Hodgman 1974: cut by one side after the other).
pub fn area_in_box(corners: [DVec3; 3], low: DVec3, high: DVec3) -> f64 {
    let mut polygon: Vec<DVec3> = corners.to_vec();
    for axis in 0..3 {
        for (side, sign) in [(low[axis], 1.0), (high[axis], -1.0)] {
            let inside = |point: DVec3| (point[axis] - side) * sign;
            let mut kept = Vec::with_capacity(polygon.len() + 1);
            for (index, &to) in polygon.iter().enumerate() {
                let from = polygon[(index + polygon.len() - 1) % polygon.len()];
                let (before, behind) = (inside(from), inside(to));
                if (before < 0.0) != (behind < 0.0) {
                    kept.push(from.lerp(to, before / (before - behind)));
                }
                if behind >= 0.0 {
                    kept.push(to);
                }
            }
            polygon = kept;
            if polygon.is_empty() {
                return 0.0;
            }
        }
    }
    let fan = polygon.windows(2).map(|pair| (pair[0] - polygon[0]).cross(pair[1] - polygon[0]));
    fan.sum::<DVec3>().length() / 2.0
}
