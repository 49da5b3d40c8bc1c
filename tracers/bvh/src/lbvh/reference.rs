//! The device's clustering against one on the host that takes every pair of neighbours by itself.

use std::sync::Arc;

use tracebench_api::{AdapterChoice, Geometry, Gpu, Parameters, PhaseClock, Preset};

use super::iterations::{LAST_CLUSTERS, bounds};
use super::plan::EARLY_ITERATIONS;
use super::{LbvhGpu, LbvhStructure, description};
use crate::binary::{BinaryNode, INNER};
use crate::gpu::layout::Tree;

fn union(a: &BinaryNode, b: &BinaryNode, first: u32) -> BinaryNode {
    let low = std::array::from_fn(|axis| a.low[axis].min(b.low[axis]));
    let high = std::array::from_fn(|axis| a.high[axis].max(b.high[axis]));
    BinaryNode { low, first, high, count: INNER }
}

fn cost(a: &BinaryNode, b: &BinaryNode) -> f32 {
    let both = union(a, b, 0);
    let [x, y, z] = std::array::from_fn(|axis| both.high[axis] - both.low[axis]);
    x * y + y * z + z * x
}

/// The nearest of the neighbours; of equal ones that whose place differs in lower bits.
fn nearest(clusters: &[BinaryNode], place: usize, radius: usize) -> usize {
    let others = place.saturating_sub(radius)..(place + radius + 1).min(clusters.len());
    let of = |other: usize| cost(&clusters[place], &clusters[other]);
    let order = |a: &usize, b: &usize| of(*a).total_cmp(&of(*b)).then((a ^ place).cmp(&(b ^ place)));
    others.filter(|other| *other != place).min_by(order).unwrap()
}

/// The pairs of siblings over leaves along the curve.
fn cluster(leaves: &[BinaryNode], [radius, early_radius]: [usize; 2]) -> Vec<BinaryNode> {
    let bounds = bounds(leaves.len() as u32);
    let mut nodes = vec![leaves[0]; 2 * leaves.len() - 2];
    let mut clusters = leaves.to_vec();
    let mut done = 0;
    while clusters.len() > 1 {
        let count = clusters.len();
        // No scene here is so slow to merge that places are paired without a search.
        assert!(count <= LAST_CLUSTERS as usize || count <= bounds[done].allowed as usize);
        let early = done < EARLY_ITERATIONS && count > LAST_CLUSTERS as usize;
        let radius = if early { early_radius } else { radius };
        let found: Vec<usize> = (0..count).map(|place| nearest(&clusters, place, radius)).collect();
        let mut kept = Vec::new();
        let mut pair = 2 * (count - 1);
        for (place, other) in found.iter().enumerate() {
            if found[*other] != place {
                kept.push(clusters[place]);
            } else if place < *other {
                pair -= 2;
                let siblings = [clusters[place], clusters[*other]];
                nodes[pair..pair + 2].copy_from_slice(&siblings);
                kept.push(union(&siblings[0], &siblings[1], pair as u32));
            }
        }
        clusters = kept;
        done += 1;
    }
    nodes
}

/// Triangles at random; some coincide, so that neighbours are equally near.
fn soup(count: u32, gpu: &Gpu) -> Geometry {
    let mut state = count;
    let mut random = || {
        state = state.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        (state >> 8) as f32 / (1 << 24) as f32
    };
    let mut positions: Vec<[f32; 3]> = Vec::new();
    for triangle in 0..count {
        let corner: [f32; 3] = std::array::from_fn(|_| random());
        for _ in 0..3 {
            let own = corner.map(|value| value + 0.03 * random());
            positions.push(if triangle % 7 == 6 { positions[positions.len() - 3] } else { own });
        }
    }
    let triangles = (0..count).map(|first| [3 * first, 3 * first + 1, 3 * first + 2]).collect();
    Geometry::new(positions, triangles, Some(gpu)).unwrap()
}

/// Proves that lanes that search for eight clusters at once find what one search a cluster does: node for node the
/// hierarchy of the host, of numbers of triangles that are no multiple of eight, too, and by small and large radii. The
/// negative control: a radius of one less gives another hierarchy.
#[test]
fn clusters_are_those_of_single_searches() {
    let gpu = Arc::new(Gpu::open(&AdapterChoice::default()).unwrap());
    let tracer = LbvhGpu::new(Arc::clone(&gpu)).unwrap();
    let described = description().parameters;
    for (count, radii) in
        [(2, [8, 8]), (7, [8, 8]), (9, [1, 1]), (500, [16, 2]), (2_049, [3, 8]), (6_001, [8, 2]), (6_003, [8, 8])]
    {
        let geometry = soup(count, &gpu);
        let mut parameters = Parameters::preset(&described, Preset::Published);
        let named = [("node", "bvh2".to_owned()), ("search_radius", radii[0].to_string())];
        for (name, value) in named.into_iter().chain([("early_search_radius", radii[1].to_string())]) {
            parameters.set(&described, name, &value).unwrap();
        }
        let mut clock = PhaseClock::new(Some(&gpu));
        let structure =
            LbvhStructure::build(&tracer.kernels, &tracer.searches, &geometry, &parameters, None, &mut clock).unwrap();
        clock.finish().unwrap();
        let (Tree::Binary(tree), _) = structure.read().unwrap() else { panic!("not binary") };
        let mut leaves: Vec<BinaryNode> = tree.nodes.iter().filter(|node| node.count != INNER).copied().collect();
        leaves.sort_by_key(|leaf| leaf.first);
        assert_eq!(leaves.len(), count as usize);
        let expected = cluster(&leaves, radii);
        let differing = tree.nodes.iter().zip(&expected).filter(|(found, expected)| found != expected).count();
        assert_eq!(differing, 0, "{count} triangles, radii {radii:?}: {differing} nodes differ");
        if count > 2_000 {
            assert_ne!(tree.nodes, cluster(&leaves, [radii[0] - 1, radii[1]]), "{count}");
            assert_ne!(tree.nodes, cluster(&leaves, [radii[0], radii[1] - 1]), "{count}");
        }
    }
}
