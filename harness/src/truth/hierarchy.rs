//! Closest hits in f64 over a hierarchy that obvhs built.

use glam::{DVec3, Vec3A};
use obvhs::BvhBuildParams;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2_from_tris;
use obvhs::bvh2::node::Bvh2Node;
use obvhs::triangle::Triangle;
use rayon::prelude::*;
use tracebench_api::Geometry;

use super::{Ray64, RayFrame, TrueHit, intersect};

/// Boxes are widened by this share of the largest coordinate in the scene: far more than f64 rounding in the slab test
/// and in the triangle test, far less than anything that costs time.
const PADDING: f64 = 1e-9;

/// A direction component below this has no finite inverse that is worth having.
const MIN_COMPONENT: f64 = 1e-200;

/// The hierarchy.
pub struct Hierarchy {
    pub(super) bvh: Bvh2,
    pub(super) padding: f64,
}

impl Hierarchy {
    /// Builds it over all triangles.
    pub fn new(geometry: &Geometry) -> Self {
        let gather = |corners: &[u32; 3]| {
            let [v0, v1, v2] = corners.map(|vertex| Vec3A::from(geometry.positions[vertex as usize]));
            Triangle { v0, v1, v2 }
        };
        let triangles: Vec<Triangle> = geometry.triangles.par_iter().map(gather).collect();
        let bvh = build_bvh2_from_tris(&triangles, BvhBuildParams::medium_build(), &mut std::time::Duration::default());
        let largest = geometry.bounds_min.abs().max(geometry.bounds_max.abs()).max_element();
        Self { bvh, padding: f64::from(largest) * PADDING }
    }

    /// The nearest hit within the ray's span; of several at equal t the lowest triangle.
    pub fn closest(&self, geometry: &Geometry, ray: &Ray64) -> Option<TrueHit> {
        let frame = RayFrame::new(ray)?;
        let root = self.bvh.nodes.first()?;
        let slabs = Slabs::new(ray, self.padding);
        let mut best: Option<TrueHit> = None;
        let mut nearest = ray.t_max;
        let mut open: Vec<(f64, &Bvh2Node)> = Vec::with_capacity(64);
        if let Some(entry) = slabs.entry(root, nearest) {
            open.push((entry, root));
        }
        while let Some((entry, node)) = open.pop() {
            if entry > nearest {
                continue;
            }
            let first = node.first_index as usize;
            if node.is_leaf() {
                for slot in first..first + node.prim_count as usize {
                    let primitive = self.bvh.primitive_indices[slot];
                    let Some(t) = intersect(&frame, ray, geometry.corners(primitive)) else { continue };
                    let nearer = best.is_none_or(|best| t < best.t || (t == best.t && primitive < best.primitive));
                    if nearer {
                        best = Some(TrueHit { t, primitive });
                        nearest = t;
                    }
                }
                continue;
            }
            let children = [&self.bvh.nodes[first], &self.bvh.nodes[first + 1]];
            let entries = [slabs.entry(children[0], nearest), slabs.entry(children[1], nearest)];
            // The nearer child is opened first: it goes on the stack last.
            let order = if entries[0] < entries[1] { [1, 0] } else { [0, 1] };
            for child in order {
                if let Some(entry) = entries[child] {
                    open.push((entry, children[child]));
                }
            }
        }
        best
    }
}

/// A ray against padded boxes.
pub(super) struct Slabs {
    origin: DVec3,
    inverse: DVec3,
    t_min: f64,
    padding: DVec3,
}

impl Slabs {
    pub(super) fn new(ray: &Ray64, padding: f64) -> Self {
        let invert = |component: f64| {
            if component.abs() < MIN_COMPONENT { 1.0_f64.copysign(component) / MIN_COMPONENT } else { 1.0 / component }
        };
        let inverse = DVec3::from(ray.direction.to_array().map(invert));
        // The origin may lie far outside of the scene; its rounding counts too.
        let padding = padding.max(ray.origin.abs().max_element() * PADDING);
        Self { origin: ray.origin, inverse, t_min: ray.t_min, padding: DVec3::splat(padding) }
    }

    /// Where the ray enters a box, if it does so before `nearest`.
    pub(super) fn entry(&self, node: &Bvh2Node, nearest: f64) -> Option<f64> {
        let aabb = node.aabb();
        let low = (aabb.min.as_dvec3() - self.padding - self.origin) * self.inverse;
        let high = (aabb.max.as_dvec3() + self.padding - self.origin) * self.inverse;
        let entry = low.min(high).max_element().max(self.t_min);
        let exit = low.max(high).min_element().min(nearest);
        // Relative slack for the products' own rounding at large t.
        (entry * (1.0 - 1e-12) <= exit * (1.0 + 1e-12)).then_some(entry * (1.0 - 1e-12))
    }
}
