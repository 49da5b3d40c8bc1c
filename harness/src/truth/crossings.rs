//! Every surface along a ray, in f64: what parity is told by.

use obvhs::bvh2::node::Bvh2Node;
use tracebench_api::Geometry;

use super::hierarchy::Slabs;
use super::{Hierarchy, Ray64, RayFrame, intersect};

/// Crossings by surfaces of one facing that are nearer to each other than this, in scene diagonals, are one: an edge that two
/// triangles share is crossed once, and a surface that is there twice is one surface.
const SAME_CROSSING: f64 = 1e-9;

/// Where a ray goes through a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossing {
    /// Ray parameter.
    pub t: f64,
    /// Triangle; of those that are one the lowest.
    pub primitive: u32,
    /// Whether the triangle's normal points along the ray.
    pub leaves: bool,
}

impl Hierarchy {
    /// Every crossing within the ray's span, the nearest first. `diagonal`: the scene's.
    pub fn crossings(&self, geometry: &Geometry, ray: &Ray64, diagonal: f64) -> Vec<Crossing> {
        let mut found = Vec::new();
        let (Some(frame), Some(root)) = (RayFrame::new(ray), self.bvh.nodes.first()) else { return found };
        let slabs = Slabs::new(ray, self.padding);
        let mut open: Vec<&Bvh2Node> = vec![root];
        while let Some(node) = open.pop() {
            if slabs.entry(node, ray.t_max).is_none() {
                continue;
            }
            let first = node.first_index as usize;
            if !node.is_leaf() {
                open.extend([&self.bvh.nodes[first], &self.bvh.nodes[first + 1]]);
                continue;
            }
            for slot in first..first + node.prim_count as usize {
                let primitive = self.bvh.primitive_indices[slot];
                let corners = geometry.corners(primitive);
                if let Some(t) = intersect(&frame, ray, corners) {
                    let [a, b, c] = corners.map(|corner| corner.as_dvec3());
                    found.push(Crossing { t, primitive, leaves: (b - a).cross(c - a).dot(ray.direction) > 0.0 });
                }
            }
        }
        found.sort_by(|one, other| one.t.total_cmp(&other.t).then(one.primitive.cmp(&other.primitive)));
        let same = SAME_CROSSING * diagonal / ray.direction.length();
        let mut kept: Vec<Crossing> = Vec::with_capacity(found.len());
        for each in found {
            let near = kept.iter().rev().take_while(|before| each.t - before.t <= same);
            if !near.into_iter().any(|before| before.leaves == each.leaves) {
                kept.push(each);
            }
        }
        kept
    }
}
