//! What holds of a CWBVH whoever traverses it.

use std::mem::offset_of;

use obvhs::aabb::Aabb;
use obvhs::cwbvh::CwBvh;
use obvhs::cwbvh::node::CwBvhNode;
use obvhs::triangle::Triangle;
use tracebench_api::TracerError;
use tracebench_shaders::bvh::WideNode;

// Nodes go to the device as they are. obvhs keeps the exponents and the mask of nodes as four bytes, the planes of an axis as two arrays
// of eight.
const _: () = {
    assert!(size_of::<CwBvhNode>() == size_of::<WideNode>());
    assert!(offset_of!(CwBvhNode, p) == offset_of!(WideNode, origin));
    assert!(offset_of!(CwBvhNode, e) == offset_of!(WideNode, exponents_and_nodes));
    assert!(offset_of!(CwBvhNode, imask) == offset_of!(CwBvhNode, e) + 3);
    assert!(offset_of!(CwBvhNode, child_base_idx) == offset_of!(WideNode, first_child));
    assert!(offset_of!(CwBvhNode, primitive_base_idx) == offset_of!(WideNode, first_triangle));
    assert!(offset_of!(CwBvhNode, child_meta) == offset_of!(WideNode, children));
    assert!(offset_of!(CwBvhNode, child_min_x) == offset_of!(WideNode, x));
    assert!(offset_of!(CwBvhNode, child_min_y) == offset_of!(WideNode, y));
    assert!(offset_of!(CwBvhNode, child_min_z) == offset_of!(WideNode, z));
    assert!(offset_of!(CwBvhNode, child_max_x) == offset_of!(CwBvhNode, child_min_x) + 8);
    assert!(offset_of!(CwBvhNode, child_max_y) == offset_of!(CwBvhNode, child_min_y) + 8);
    assert!(offset_of!(CwBvhNode, child_max_z) == offset_of!(CwBvhNode, child_min_z) + 8);
};

/// How far a stored box may cut what it bounds, in widths of its node: obvhs rounds outward after a division in f32.
const BOX_SLACK: f64 = 1.0 / (1 << 22) as f64;

/// Levels of nodes from the root down, and that every node is reached once, after its parent.
pub(crate) fn depth(bvh: &CwBvh) -> Result<usize, TracerError> {
    let mut deepest = 0;
    let mut open = vec![(0_usize, 1_usize)];
    let mut visited = 0;
    while let Some((index, level)) = open.pop() {
        let Some(node) = bvh.nodes.get(index) else {
            return Err(TracerError::Failed(format!("node {index} does not exist")));
        };
        visited += 1;
        if visited > bvh.nodes.len() {
            return Err(TracerError::Failed("a node is reached twice".to_owned()));
        }
        deepest = deepest.max(level);
        for child in 0..node.imask.count_ones() {
            let below = (node.child_base_idx + child) as usize;
            // Refitting relies on it.
            if below <= index {
                return Err(TracerError::Failed(format!("node {below} comes before its parent {index}")));
            }
            open.push((below, level + 1));
        }
    }
    Ok(deepest)
}

/// That every triangle is in a leaf, and in one only unless large ones were split.
pub(crate) fn check_references(
    primitive_indices: &[u32],
    triangle_count: usize,
    with_splits: bool,
) -> Result<(), TracerError> {
    let mut seen = vec![0_u32; triangle_count];
    for index in primitive_indices {
        match seen.get_mut(*index as usize) {
            Some(count) => *count += 1,
            None => return Err(TracerError::Failed(format!("a leaf names triangle {index}, which does not exist"))),
        }
    }
    let missing = seen.iter().filter(|count| **count == 0).count();
    let doubled = seen.iter().filter(|count| **count > 1).count();
    if missing > 0 {
        return Err(TracerError::Failed(format!("{missing} triangles are in no leaf")));
    }
    if doubled > 0 && !with_splits {
        return Err(TracerError::Failed(format!("{doubled} triangles are in several leaves without splits")));
    }
    Ok(())
}

/// That leaves take every slot once and that each stored box bounds the triangles below it. `triangles` are in the order
/// of the slots. A triangle that was split reaches out of its boxes; without `whole` they must only meet.
pub(crate) fn check_boxes(bvh: &CwBvh, triangles: &[Triangle], whole: bool) -> Result<(), TracerError> {
    let failed = |what: String| Err(TracerError::Failed(what));
    let mut taken = vec![false; triangles.len()];
    let mut bounds = vec![Aabb::empty(); bvh.nodes.len()];
    for index in (0..bvh.nodes.len()).rev() {
        let node = &bvh.nodes[index];
        for child in (0..8).filter(|child| !node.is_child_empty(*child)) {
            let stored = node.child_aabb(child);
            let mut below = Aabb::empty();
            if node.is_leaf(child) {
                let (first, count) = node.child_primitives(child);
                for slot in first as usize..(first + count) as usize {
                    let (Some(taken), Some(triangle)) = (taken.get_mut(slot), triangles.get(slot)) else {
                        return failed(format!("slot {slot} does not exist"));
                    };
                    if std::mem::replace(taken, true) {
                        return failed(format!("slot {slot} is in two leaves"));
                    }
                    below = below.union(&triangle.aabb());
                }
            } else {
                below = bounds[node.child_node_index(child) as usize];
            }
            let slack = (node.compute_extent() * (255.0 * BOX_SLACK as f32))
                .max(stored.max.abs().max(stored.min.abs()) * f32::EPSILON);
            let bounded = stored.min.cmple(below.min + slack).all() && stored.max.cmpge(below.max - slack).all();
            let meets = stored.min.cmple(below.max + slack).all() && stored.max.cmpge(below.min - slack).all();
            if !(if whole { bounded } else { meets }) {
                return failed(format!("the box of child {child} of node {index} does not bound what is below it"));
            }
            bounds[index] = bounds[index].union(&below);
        }
    }
    match taken.iter().position(|taken| !taken) {
        Some(slot) => failed(format!("slot {slot} is in no leaf")),
        None => Ok(()),
    }
}
