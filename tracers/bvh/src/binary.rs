//! A binary hierarchy as the device has it: siblings stand together, in 32 bytes a node. They come after their parents, but in
//! a radix tree that the device has built.

use glam::Vec3A;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::node::Bvh2Node;
use obvhs::triangle::Triangle;
use tracebench_api::TracerError;
pub(crate) use tracebench_shaders::bvh::BinaryNode;

/// `count` of a node that is no leaf.
pub(crate) const INNER: u32 = u32::MAX;

/// Half the edge of the inside-out box of an empty leaf: the scene's diagonal, as it is scaled.
const INSIDE_OUT: f32 = 131_072.0;

fn node_of(aabb: &Aabb, first: u32, count: u32) -> BinaryNode {
    BinaryNode { low: aabb.min.to_array(), first, high: aabb.max.to_array(), count }
}

/// A node's box.
pub(crate) fn box_of(node: &BinaryNode) -> Aabb {
    Aabb::new(Vec3A::from(node.low), Vec3A::from(node.high))
}

/// Pairs of siblings from the root's children on; the root itself is not stored.
#[derive(Clone, Debug)]
pub(crate) struct Binary {
    /// An even number of nodes.
    pub(crate) nodes: Vec<BinaryNode>,
    /// The triangle in each slot of the leaves.
    pub(crate) primitive_indices: Vec<u32>,
    /// Whether large triangles were split and may stand in several leaves.
    pub(crate) with_splits: bool,
}

impl Binary {
    /// Takes obvhs's hierarchy over, each parent before its children, and leaves' slots in that order.
    pub(crate) fn new(from: &Bvh2) -> Self {
        let mut nodes = Vec::with_capacity(from.nodes.len() + 1);
        let mut primitive_indices = Vec::with_capacity(from.primitive_indices.len());
        let mut open = Vec::new();
        let mut take = |node: &Bvh2Node, nodes: &mut Vec<BinaryNode>, open: &mut Vec<(usize, u32)>| {
            if node.is_leaf() {
                let first = primitive_indices.len() as u32;
                let slots = node.first_index as usize..(node.first_index + node.prim_count) as usize;
                primitive_indices.extend_from_slice(&from.primitive_indices[slots]);
                nodes.push(node_of(node.aabb(), first, node.prim_count));
            } else {
                open.push((nodes.len(), node.first_index));
                nodes.push(node_of(node.aabb(), 0, INNER));
            }
        };
        match from.nodes.first() {
            Some(root) if root.is_leaf() => {
                take(root, &mut nodes, &mut open);
                // Nothing meets a box that is inside out, and were it met there is nothing in it.
                let low = [INSIDE_OUT; 3];
                nodes.push(BinaryNode { low, first: 0, high: low.map(|edge| -edge), count: 0 });
            }
            Some(root) => open.push((usize::MAX, root.first_index)),
            None => {}
        }
        while let Some((parent, pair)) = open.pop() {
            let first = nodes.len() as u32;
            // The root alone is out of range: it is not stored.
            if let Some(parent) = nodes.get_mut(parent) {
                parent.first = first;
            }
            for node in &from.nodes[pair as usize..pair as usize + 2] {
                take(node, &mut nodes, &mut open);
            }
        }
        Self { nodes, primitive_indices, with_splits: from.uses_spatial_splits }
    }

    /// Levels of pairs.
    pub(crate) fn depth(&self) -> usize {
        let (mut level, mut depth): (Vec<BinaryNode>, _) = (self.nodes.iter().take(2).copied().collect(), 0);
        while !level.is_empty() {
            let below = level.iter().filter(|node| node.count == INNER).map(|node| node.first as usize);
            level = below.flat_map(|first| [self.nodes[first], self.nodes[first + 1]]).collect();
            depth += 1;
        }
        depth
    }

    /// Fits every box to triangles that moved, from the leaves up. `triangles` are all of the scene's, in its order.
    pub(crate) fn refit(&mut self, triangles: &[Triangle]) {
        for index in (0..self.nodes.len()).rev() {
            let node = self.nodes[index];
            if node.count == 0 {
                continue;
            }
            let first = node.first as usize;
            let fitted = if node.count == INNER {
                box_of(&self.nodes[first]).union(&box_of(&self.nodes[first + 1]))
            } else {
                let slots = &self.primitive_indices[first..first + node.count as usize];
                let boxes = slots.iter().map(|primitive| triangles[*primitive as usize].aabb());
                boxes.fold(Aabb::empty(), |whole, each| whole.union(&each))
            };
            self.nodes[index] = node_of(&fitted, node.first, node.count);
        }
    }

    /// That pairs are reached once, that leaves take every slot once, and that each box bounds
    /// the triangles below it. `triangles` are in the order of the slots. A triangle that was split reaches out of its
    /// boxes; without `whole` they must only meet.
    pub(crate) fn check(&self, triangles: &[Triangle], whole: bool) -> Result<(), TracerError> {
        let failed = |what: String| Err(TracerError::Failed(what));
        let mut reached = vec![false; self.nodes.len() / 2];
        // Parents before their children, in whatever order they are stored.
        let mut order: Vec<usize> = (0..self.nodes.len().min(2)).collect();
        let mut next = 0;
        while let Some(&index) = order.get(next) {
            let first = self.nodes[index].first as usize;
            if self.nodes[index].count == INNER {
                let is_pair = first > 1 && first.is_multiple_of(2) && first + 1 < self.nodes.len();
                if !is_pair || std::mem::replace(&mut reached[first / 2], true) {
                    return failed(format!("the children of node {index} do not exist or are reached twice"));
                }
                order.extend([first, first + 1]);
            }
            next += 1;
        }
        let mut taken = vec![false; triangles.len()];
        let mut bounds = vec![Aabb::empty(); self.nodes.len()];
        for index in order.into_iter().rev() {
            let node = &self.nodes[index];
            let first = node.first as usize;
            if node.count == INNER {
                bounds[index] = bounds[first].union(&bounds[first + 1]);
            } else {
                for slot in first..first + node.count as usize {
                    let (Some(taken), Some(triangle)) = (taken.get_mut(slot), triangles.get(slot)) else {
                        return failed(format!("slot {slot} does not exist"));
                    };
                    if std::mem::replace(taken, true) {
                        return failed(format!("slot {slot} is in two leaves"));
                    }
                    bounds[index] = bounds[index].union(&triangle.aabb());
                }
            }
            let (stored, below) = (box_of(node), bounds[index]);
            let bounded = stored.min.cmple(below.min).all() && stored.max.cmpge(below.max).all();
            let meets = stored.min.cmple(below.max).all() && stored.max.cmpge(below.min).all();
            if node.count > 0 && !(if whole { bounded } else { meets }) {
                return failed(format!("the box of node {index} does not bound what is below it"));
            }
        }
        if let Some(pair) = reached.iter().skip(1).position(|reached| !reached) {
            return failed(format!("node {} has no parent", 2 * pair + 2));
        }
        match taken.iter().position(|taken| !taken) {
            Some(slot) => failed(format!("slot {slot} is in no leaf")),
            None => Ok(()),
        }
    }
}
