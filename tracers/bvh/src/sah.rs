//! What a hierarchy costs by the surface area heuristic: the one definition for every hierarchy of the suite.
//!
//! A random line (evenly spread over all lines) that meets a convex body meets a convex body within it with the
//! probability of the ratio of their surface areas. So a search that nothing shortens is expected to take
//!
//! cost = sum over nodes of area / root's area + sum over leaves of area / root's area x triangles
//!
//! node visits and triangle tests, which cost 1 each (Goldsmith, Salmon: Automatic Creation of Object Hierarchies for Ray
//! Tracing, IEEE CG&A 1987; MacDonald, Booth: Heuristics for Ray Tracing Using Space Subdivision, The Visual Computer
//! 1990). A node is what a search visits at once: a wide node counts as one, as two siblings of a binary hierarchy do, which
//! is their parent's inner node. The root counts 1. Leaves are no visits of their own: their boxes are tested with their
//! parent's node. Wide and binary costs are therefore in the units of the counters `nodes_visited` and `triangle_tests`, and
//! do not say that both kinds of visit take as long.

use obvhs::aabb::Aabb;
use obvhs::cwbvh::CwBvh;
use obvhs::cwbvh::node::CwBvhNode;

use crate::binary::{BinaryNode, INNER, box_of};

/// Half the surface of a box, squared units; nothing for one that is inside out.
fn half_area(aabb: &Aabb) -> f64 {
    let edges = (aabb.max.as_dvec3() - aabb.min.as_dvec3()).max(glam::DVec3::ZERO);
    (edges.x + edges.y) * edges.z + edges.x * edges.y
}

/// A cost that is being summed up.
struct Cost {
    root: f64,
    terms: Vec<f64>,
}

impl Cost {
    /// That of visiting the root.
    fn of_root(aabb: &Aabb) -> Self {
        Self { root: half_area(aabb), terms: vec![1.0] }
    }

    /// The chance of a box to be met. No random line meets a root without area (a point, a line), so that such a one costs
    /// what is most there: everything is met.
    fn chance(&self, aabb: &Aabb) -> f64 {
        if self.root > 0.0 { half_area(aabb) / self.root } else { 1.0 }
    }

    /// Adds an inner node below the root.
    fn node(&mut self, aabb: &Aabb) {
        self.terms.push(self.chance(aabb));
    }

    /// Adds a leaf with so many triangles.
    fn leaf(&mut self, aabb: &Aabb, triangles: u32) {
        self.terms.push(self.chance(aabb) * f64::from(triangles));
    }

    /// The sum, least terms first: nodes that stand in another order cost the same to the last bit.
    fn sum(mut self) -> f64 {
        self.terms.sort_by(f64::total_cmp);
        self.terms.iter().sum()
    }
}

fn union(boxes: impl Iterator<Item = Aabb>) -> Aabb {
    boxes.fold(Aabb::empty(), |whole, each| whole.union(&each))
}

/// The cost of an eight-wide hierarchy by its boxes as they are stored, rounded outward; 0 for one without nodes.
pub(crate) fn of_wide(bvh: &CwBvh) -> f64 {
    let Some(root) = bvh.nodes.first() else { return 0.0 };
    let children = |node: &CwBvhNode| {
        let node = *node;
        (0..8).filter(move |child| !node.is_child_empty(*child))
    };
    let mut cost = Cost::of_root(&union(children(root).map(|child| root.child_aabb(child))));
    for node in &bvh.nodes {
        for child in children(node) {
            if node.is_leaf(child) {
                cost.leaf(&node.child_aabb(child), node.child_primitives(child).1);
            } else {
                cost.node(&node.child_aabb(child));
            }
        }
    }
    cost.sum()
}

/// The cost of a binary hierarchy stored as pairs of siblings, without its root; 0 for one without nodes.
pub(crate) fn of_binary(nodes: &[BinaryNode]) -> f64 {
    let Some(pair) = nodes.first_chunk::<2>() else { return 0.0 };
    // An empty leaf stands beside a leaf that is the whole hierarchy.
    let filled = |node: &&BinaryNode| node.count > 0;
    let mut cost = Cost::of_root(&union(pair.iter().filter(filled).map(box_of)));
    for node in nodes.iter().filter(filled) {
        match node.count {
            INNER => cost.node(&box_of(node)),
            triangles => cost.leaf(&box_of(node), triangles),
        }
    }
    cost.sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn node(low: [f32; 3], high: [f32; 3], first: u32, count: u32) -> BinaryNode {
        BinaryNode { low, first, high, count }
    }

    /// A leaf of two triangles, and beside it an inner node over leaves of one and three: halves of surfaces are 9 (the
    /// root, 4x1x1), 3 (every leaf, a cube) and 5 (the inner node, 2x1x1).
    fn small() -> Vec<BinaryNode> {
        vec![
            node([0.0; 3], [1.0; 3], 0, 2),
            node([2.0, 0.0, 0.0], [4.0, 1.0, 1.0], 2, INNER),
            node([2.0, 0.0, 0.0], [3.0, 1.0, 1.0], 2, 1),
            node([3.0, 0.0, 0.0], [4.0, 1.0, 1.0], 3, 3),
        ]
    }

    /// Proves the definition on a binary hierarchy small enough to be worked out by hand, and that the cost does not depend
    /// on the unit of length.
    #[test]
    fn a_binary_hierarchy_by_hand() {
        let expected = 1.0 + 5.0 / 9.0 + 3.0 / 9.0 * (2.0 + 1.0 + 3.0);
        assert!((of_binary(&small()) - expected).abs() < 1e-12);
        let scale = |corner: [f32; 3]| corner.map(|x| x * 64.0);
        let scaled = |each: BinaryNode| BinaryNode { low: scale(each.low), high: scale(each.high), ..each };
        let scaled: Vec<_> = small().into_iter().map(scaled).collect();
        assert!((of_binary(&scaled) - expected).abs() < 1e-12);
        // Negative control: a larger leaf costs more.
        let mut larger = small();
        larger[2].high[0] = 3.5;
        assert!(of_binary(&larger) > expected + 0.1);
    }

    /// The same boxes in wide nodes: the root with a leaf and a node, below it two leaves.
    #[test]
    fn a_wide_hierarchy_by_hand() {
        let mut root = CwBvhNode { e: [127; 3], imask: 0b10, child_base_idx: 1, ..CwBvhNode::default() };
        // Two triangles from slot 0 on; an inner node in slot 1.
        (root.child_meta[0], root.child_meta[1]) = (0b0110_0000, 0b0010_0000 | 25);
        (root.child_max_x[0], root.child_min_x[1], root.child_max_x[1]) = (1, 2, 4);
        let mut below = CwBvhNode { e: [127; 3], primitive_base_idx: 2, ..CwBvhNode::default() };
        (below.child_meta[0], below.child_meta[1]) = (0b0010_0000, 0b1110_0001);
        (below.child_min_x[0], below.child_max_x[0], below.child_min_x[1], below.child_max_x[1]) = (2, 3, 3, 4);
        for node in [&mut root, &mut below] {
            (node.child_max_y[0], node.child_max_y[1], node.child_max_z[0], node.child_max_z[1]) = (1, 1, 1, 1);
        }
        let wide = CwBvh {
            nodes: vec![root, below],
            primitive_indices: (0..6).collect(),
            total_aabb: Aabb::empty(),
            exact_node_aabbs: None,
            uses_spatial_splits: false,
        };
        assert!((of_wide(&wide) - of_binary(&small())).abs() < 1e-6);
    }

    /// A single leaf costs its visit and its tests whatever stands beside it for a sibling; a root without area has a cost
    /// too, and so has nothing at all.
    #[test]
    fn degenerate_hierarchies_have_a_cost() {
        let empty = node([9.0; 3], [-9.0; 3], 0, 0);
        assert_eq!(of_binary(&[node([0.0; 3], [1.0; 3], 0, 5), empty]), 6.0);
        let line = |from: f32, to: f32, count| node([from, 0.0, 0.0], [to, 0.0, 0.0], 0, count);
        assert_eq!(of_binary(&[line(0.0, 1.0, 2), line(1.0, 2.0, 3)]), 1.0 + 5.0);
        assert_eq!(of_binary(&[line(0.0, 1.0, 2), line(1.0, 2.0, INNER), line(1.0, 1.5, 1), line(1.5, 2.0, 1)]), 6.0);
        assert_eq!(of_binary(&[]), 0.0);
        // A flat root has an area.
        let plate = |from: f32, to: f32| node([from, 0.0, 0.0], [to, 1.0, 0.0], 0, 1);
        assert_eq!(of_binary(&[plate(0.0, 1.0), plate(1.0, 2.0)]), 2.0);
    }
}
