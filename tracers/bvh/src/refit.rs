//! Fits a CWBVH's boxes to triangles that moved, from the leaves up; its shape stays.

use glam::{UVec3, Vec3A};
use obvhs::aabb::Aabb;
use obvhs::cwbvh::CwBvh;
use obvhs::cwbvh::node::CwBvhNode;
use obvhs::triangle::Triangle;

/// Steps into which a node's box is divided along each axis.
const STEPS: f32 = 255.0;

/// The least extent of a node, as in obvhs's own conversion: its step is a normal number.
const MIN_EXTENT: f32 = 1e-20;

/// Fits every box. `triangles` are all of the scene's, in its order; every node comes after its parent.
pub(crate) fn refit(bvh: &mut CwBvh, triangles: &[Triangle]) {
    let mut boxes = vec![Aabb::empty(); bvh.nodes.len()];
    for index in (0..bvh.nodes.len()).rev() {
        let node = bvh.nodes[index];
        let mut children = [Aabb::empty(); 8];
        for (child, fitted) in children.iter_mut().enumerate().filter(|(child, _)| !node.is_child_empty(*child)) {
            if node.is_leaf(child) {
                let (first, count) = node.child_primitives(child);
                for slot in first..first + count {
                    let triangle = &triangles[bvh.primitive_indices[slot as usize] as usize];
                    *fitted = fitted.union(&triangle.aabb());
                }
            } else {
                *fitted = boxes[node.child_node_index(child) as usize];
            }
        }
        boxes[index] = children.iter().fold(Aabb::empty(), |whole, child| whole.union(child));
        bvh.nodes[index] = quantized(node, &boxes[index], &children);
    }
    if let Some(whole) = boxes.first() {
        bvh.total_aabb = *whole;
    }
}

/// A node with its children's boxes on the grid of its own (Ylitie, Karras, Laine 2017, section 3.1), rounded outward.
fn quantized(mut node: CwBvhNode, whole: &Aabb, children: &[Aabb; 8]) -> CwBvhNode {
    let extent = (whole.max - whole.min).max(Vec3A::splat(MIN_EXTENT));
    let mut step = (extent / STEPS).log2().ceil().exp2();
    for axis in 0..3 {
        // The logarithm is rounded: a step too small would cut the box.
        while step[axis] * STEPS < extent[axis] {
            step[axis] *= 2.0;
        }
    }
    node.p = whole.min.into();
    let exponents = UVec3::from_array(step.to_array().map(|step| step.to_bits() >> 23));
    node.e = exponents.to_array().map(|exponent| exponent as u8);
    for (child, fitted) in children.iter().enumerate() {
        if node.is_child_empty(child) {
            continue;
        }
        let low = ((fitted.min - whole.min) / step).floor().clamp(Vec3A::ZERO, Vec3A::splat(STEPS));
        let high = ((fitted.max - whole.min) / step).ceil().clamp(Vec3A::ZERO, Vec3A::splat(STEPS));
        let [low, high] = [low, high].map(|corner| corner.to_array().map(|value| value as u8));
        [node.child_min_x[child], node.child_min_y[child], node.child_min_z[child]] = low;
        [node.child_max_x[child], node.child_max_y[child], node.child_max_z[child]] = high;
    }
    node
}
