//! That the checks of hierarchies notice what is wrong with one that the device built, and constants of both sides.

use std::sync::Arc;

use tracebench_api::{AdapterChoice, Geometry, Gpu, Parameters, PhaseClock, Preset};
use tracebench_shaders::Shader;
use tracebench_shaders::bvh::{CONVERT, Cluster, LEAVES, RadixTree};

use super::iterations::LAST_CLUSTERS;
use super::kernels::{CROWDED, FINISHED, LEVELS, RAISED, RUN, SEARCHED, TAKEN_SLOTS};
use super::{PlocGpu, description};
use crate::binary::{BinaryNode, INNER};
use crate::gpu::BINARY_STACK;
use crate::gpu::layout::Tree;
use crate::gpu::tests::{assert_unsound_ones_are_noticed, field};
use crate::touched::{self, assert_touched};

/// Both kinds of node over both kinds of tree.
const FORMS: [(&str, &str); 4] = [("cwbvh", "ploc"), ("bvh2", "ploc"), ("cwbvh", "lbvh"), ("bvh2", "lbvh")];

fn parameters(node: &str, tree: &str) -> Parameters {
    let described = description().parameters;
    let mut parameters = Parameters::preset(&described, Preset::Published);
    parameters.set(&described, "node", node).unwrap();
    parameters.set(&described, "tree", tree).unwrap();
    parameters
}

/// Hierarchies read back from the device pass as they are, by both nodes; those that were spoilt do not.
#[test]
fn unsound_hierarchies_are_noticed() {
    let gpu = Arc::new(Gpu::open(&AdapterChoice::default()).unwrap());
    let corners = field().into_iter().flat_map(|triangle| [triangle.v0, triangle.v1, triangle.v2]);
    let positions: Vec<[f32; 3]> = corners.map(|corner| corner.to_array()).collect();
    let triangles = (0..positions.len() as u32 / 3).map(|first| [3 * first, 3 * first + 1, 3 * first + 2]).collect();
    let geometry = Geometry::new(positions, triangles, Some(&gpu)).unwrap();
    let tracer = PlocGpu::new(Arc::clone(&gpu)).unwrap();
    for (node, tree) in FORMS {
        let parameters = parameters(node, tree);
        let mut clock = PhaseClock::new(Some(&gpu));
        let structure = tracer.build_structure(&geometry, &touched::viewpoint(), &parameters, &mut clock).unwrap();
        clock.finish().unwrap();
        assert_unsound_ones_are_noticed(node, &|| structure.read().unwrap());
    }
}

/// Places and sizes that the host knows are those of the shaders.
#[test]
fn constants_are_those_of_the_shaders() {
    let cluster = Shader::from(Cluster { wide: false });
    for (shader, name, expected) in [
        (cluster, "FINISHED", FINISHED),
        (CONVERT, "TAKEN_SLOTS", TAKEN_SLOTS),
        (LEAVES, "CROWDED", CROWDED),
        (CONVERT, "LEVELS", LEVELS),
        (cluster, "RUN", RUN as usize),
        (cluster, "SEARCHED", SEARCHED as usize),
        (Shader::from(RadixTree { wide: false }), "RAISED", RAISED as usize),
        (cluster, "LAST_CLUSTERS", LAST_CLUSTERS as usize),
        (cluster, "MAX_LEVELS", BINARY_STACK),
    ] {
        assert_eq!(shader.constant(name), Some(expected as u32), "{name}");
    }
    // The words of all iterations end before those that follow: searches, then pairings of what they may leave.
    let searches = cluster.constant("MAX_SEARCHES").unwrap() as usize;
    assert!(FINISHED + searches + (LAST_CLUSTERS.ilog2() as usize) < TAKEN_SLOTS);
    // Negative control: a name that is only the beginning of one is not found.
    assert_eq!(cluster.constant("FINISH"), None);
}

/// Proves that the nodes and references counted as touched by a set of rays are those whose boxes the rays meet by brute
/// force, of both kinds of node.
#[test]
fn touched_is_what_rays_meet() {
    let gpu = touched::gpu();
    let (geometry, rays) = touched::scene(Some(&gpu));
    let tracer = PlocGpu::new(Arc::clone(&gpu)).unwrap();
    for (node, tree) in FORMS {
        let parameters = parameters(node, tree);
        let mut clock = PhaseClock::new(Some(&gpu));
        let structure = tracer.build_structure(&geometry, &touched::viewpoint(), &parameters, &mut clock).unwrap();
        clock.finish().unwrap();
        let (tree, _) = structure.read().unwrap();
        let units = (structure.scale, &parameters);
        assert_touched(node, &structure, &tree, (&geometry, &rays), units, Some(&gpu));
    }
}

type Corners = [[u32; 3]; 2];

/// Splits of the curve, `(first, last left one, last)`, from the top down, of the keys of places in order.
fn splits(keys: &[u64], first: usize, found: &mut Vec<[usize; 3]>) {
    let Some(differing) = keys.first().zip(keys.last()).map(|(one, other)| one ^ other).filter(|bits| *bits != 0)
    else {
        return;
    };
    let bit = 1 << differing.ilog2();
    let left = keys.partition_point(|key| key & bit == 0);
    found.push([first, first + left - 1, first + keys.len() - 1]);
    splits(&keys[..left], first, found);
    splits(&keys[left..], first + left, found);
}

/// The same as a hierarchy has them, from one of its pairs on; its boxes are the least that hold the triangles.
fn splits_of(nodes: &[BinaryNode], pair: usize, leaves: &[BinaryNode], found: &mut Vec<[usize; 3]>) -> [usize; 2] {
    let place = found.len();
    found.push([0; 3]);
    let ranges = [pair, pair + 1].map(|index| {
        let node = nodes[index];
        let first = node.first as usize;
        let [first, last] = if node.count == INNER { splits_of(nodes, first, leaves, found) } else { [first; 2] };
        for axis in 0..3 {
            let within = &leaves[first..=last];
            assert_eq!(node.low[axis], within.iter().map(|leaf| leaf.low[axis]).fold(f32::MAX, f32::min));
            assert_eq!(node.high[axis], within.iter().map(|leaf| leaf.high[axis]).fold(f32::MIN, f32::max));
        }
        [first, last]
    });
    assert_eq!(ranges[0][1] + 1, ranges[1][0]);
    found[place] = [ranges[0][0], ranges[0][1], ranges[1][1]];
    [ranges[0][0], ranges[1][1]]
}

/// The 30-bit code of a box's centre in a grid of 1024 unit cells an axis, bit by bit, of axes in an order.
fn code([low, high]: Corners, axes: [usize; 3]) -> u64 {
    let cell = |axis: usize| u64::from((low[axis] + high[axis]) / 2).min(1023);
    let bit = |bit: usize| axes.iter().fold(0, |code, axis| (code << 1) | ((cell(*axis) >> bit) & 1));
    (0..10).rev().fold(0, |code, place| (code << 3) | bit(place))
}

/// Proves that a radix tree splits the curve where keys of code and place do from the top down, in integers, and that its
/// boxes are tight: at random, of points, of many triangles in few cells, and of equal ones. The negative control: codes
/// with axes in another order split it elsewhere.
#[test]
fn radix_trees_are_those_of_integers() {
    let gpu = Arc::new(Gpu::open(&AdapterChoice::default()).unwrap());
    let tracer = PlocGpu::new(Arc::clone(&gpu)).unwrap();
    // The first triangle spans the grid, so that cells are units.
    let whole = [[0; 3], [1024; 3]];
    for (name, count, spread, size) in [
        ("two", 2, 900, 9),
        ("three", 3, 900, 9),
        ("at random", 5_003, 990, 20),
        ("points", 700, 1000, 0),
        ("few cells", 4_000, 3, 2),
        ("equal", 2_049, 1, 0),
    ] {
        let mut state = count;
        let mut random = |most: u32| {
            state = u32::wrapping_add(u32::wrapping_mul(state, 747_796_405), 2_891_336_453);
            (state >> 9) % most
        };
        let mut boxes = vec![whole];
        while boxes.len() < count as usize {
            let low: [u32; 3] = std::array::from_fn(|_| 7 + random(spread));
            boxes.push([low, low.map(|edge| edge + random(size + 1))]);
        }
        let positions = boxes.iter().flat_map(|[low, high]| [low, high, low].map(|corner| corner.map(|x| x as f32)));
        let triangles = (0..count).map(|each| [3 * each, 3 * each + 1, 3 * each + 2]).collect();
        let geometry = Geometry::new(positions.collect(), triangles, Some(&gpu)).unwrap();
        let mut clock = PhaseClock::new(Some(&gpu));
        let structure =
            tracer.build_structure(&geometry, &touched::viewpoint(), &parameters("bvh2", "lbvh"), &mut clock).unwrap();
        clock.finish().unwrap();
        let (Tree::Binary(tree), _) = structure.read().unwrap() else { panic!("not binary") };
        let expected = |axes: [usize; 3]| {
            let mut order: Vec<u32> = (0..count).collect();
            order.sort_by_key(|each| code(boxes[*each as usize], axes));
            let key = |(place, each): (usize, &u32)| (code(boxes[*each as usize], axes) << 32) | place as u64;
            let keys: Vec<u64> = order.iter().enumerate().map(key).collect();
            let mut found = Vec::new();
            splits(&keys, 0, &mut found);
            (order, found)
        };
        let mut leaves: Vec<BinaryNode> = tree.nodes.iter().filter(|node| node.count != INNER).copied().collect();
        leaves.sort_by_key(|leaf| leaf.first);
        let mut found = Vec::new();
        splits_of(&tree.nodes, 0, &leaves, &mut found);
        let same = (tree.primitive_indices.clone(), found);
        assert!(same == expected([0, 1, 2]), "{name}");
        assert!(count < 100 || spread < 9 || same != expected([2, 1, 0]), "{name}");
    }
}
