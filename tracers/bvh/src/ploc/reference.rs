//! The device's clustering against one on the host that takes every pair of neighbours by itself.

use std::sync::Arc;

use tracebench_api::{AdapterChoice, Geometry, Gpu, Parameters, PhaseClock, Preset};

use super::iterations::{LAST_CLUSTERS, bounds};
use super::plan::EARLY_ITERATIONS;
use super::{PlocGpu, description};
use crate::binary::{BinaryNode, INNER};
use crate::gpu::BINARY_STACK;
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
fn nearest(clusters: &[(BinaryNode, u32)], place: usize, radius: usize) -> usize {
    let others = place.saturating_sub(radius)..(place + radius + 1).min(clusters.len());
    let of = |other: usize| cost(&clusters[place].0, &clusters[other].0);
    let order = |a: &usize, b: &usize| of(*a).total_cmp(&of(*b)).then((a ^ place).cmp(&(b ^ place)));
    others.filter(|other| *other != place).min_by(order).unwrap()
}

/// The pairs of siblings over leaves along the curve, and how often clusters were paired without a search.
fn cluster(leaves: &[BinaryNode], [radius, early_radius]: [usize; 2]) -> (Vec<BinaryNode>, u32) {
    let bounds = bounds(leaves.len() as u32);
    let mut nodes = vec![leaves[0]; 2 * leaves.len() - 2];
    let mut clusters: Vec<(BinaryNode, u32)> = leaves.iter().map(|leaf| (*leaf, 0)).collect();
    let (mut done, mut previous, mut pairings) = (0, 0, 0);
    while clusters.len() > 1 {
        let count = clusters.len();
        let last = count <= LAST_CLUSTERS as usize;
        let paired = if last { count == previous } else { count > bounds[done].allowed as usize };
        pairings += u32::from(paired);
        let radius = if done < EARLY_ITERATIONS && !last { early_radius } else { radius };
        let rest = count.next_power_of_two().ilog2();
        let find = |place: usize| match paired {
            true if place ^ 1 < count => place ^ 1,
            false if clusters[place].1 + rest < BINARY_STACK as u32 => nearest(&clusters, place, radius),
            _ => place,
        };
        let found: Vec<usize> = (0..count).map(find).collect();
        let mut kept = Vec::new();
        let mut pair = 2 * (count - 1);
        for (place, other) in found.iter().enumerate() {
            if *other == place || found[*other] != place {
                kept.push(clusters[place]);
            } else if place < *other {
                pair -= 2;
                let [(own, height), (sibling, its_height)] = [clusters[place], clusters[*other]];
                nodes[pair..pair + 2].copy_from_slice(&[own, sibling]);
                kept.push((union(&own, &sibling, pair as u32), height.max(its_height) + 1));
            }
        }
        if last {
            previous = count;
        }
        clusters = kept;
        done += 1;
    }
    (nodes, pairings)
}

fn geometry(positions: Vec<[f32; 3]>, gpu: &Gpu) -> Geometry {
    let triangles = (0..positions.len() as u32 / 3).map(|first| [3 * first, 3 * first + 1, 3 * first + 2]).collect();
    Geometry::new(positions, triangles, Some(gpu)).unwrap()
}

/// Triangles at random; some coincide, so that neighbours are equally near.
fn soup(count: u32) -> Vec<[f32; 3]> {
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
    positions
}

/// Triangles that are each nearest to the one before, so that a search merges a single pair.
fn growing(count: u32, factor: f32) -> Vec<[f32; 3]> {
    let corners = |triangle: u32| {
        let size = factor.powi(triangle as i32 - count as i32);
        [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [-1.0, 1.0, 0.0_f32]].map(|corner| corner.map(|value| value * size))
    };
    (0..count).flat_map(corners).collect()
}

/// What the device and the host make of the same leaves, and how often the host paired clusters.
fn compare(
    gpu: &Arc<Gpu>,
    tracer: &PlocGpu,
    positions: Vec<[f32; 3]>,
    radii: [usize; 2],
) -> ([Vec<BinaryNode>; 3], u32) {
    let described = description().parameters;
    let mut parameters = Parameters::preset(&described, Preset::Published);
    let named = [("search_radius", radii[0]), ("early_search_radius", radii[1])];
    for (name, value) in named.map(|(name, radius)| (name, radius.to_string())) {
        parameters.set(&described, name, &value).unwrap();
    }
    parameters.set(&described, "node", "bvh2").unwrap();
    let mut clock = PhaseClock::new(Some(gpu));
    let geometry = geometry(positions, gpu);
    let structure = tracer.build_structure(&geometry, &crate::touched::viewpoint(), &parameters, &mut clock).unwrap();
    clock.finish().unwrap();
    let (Tree::Binary(tree), _) = structure.read().unwrap() else { panic!("not binary") };
    let mut leaves: Vec<BinaryNode> = tree.nodes.iter().filter(|node| node.count != INNER).copied().collect();
    leaves.sort_by_key(|leaf| leaf.first);
    assert_eq!(2 * leaves.len() - 2, tree.nodes.len());
    let (expected, pairings) = cluster(&leaves, radii);
    let (other, _) = cluster(&leaves, radii.map(|radius| radius.max(2) - 1));
    ([tree.nodes, expected, other], pairings)
}

/// Proves that lanes that search for eight clusters at once find what one search a cluster does: node for node the
/// hierarchy of the host, of numbers of triangles that are no multiple of eight, too, and by small and large radii. The
/// negative control: radii of one less give another hierarchy.
#[test]
fn clusters_are_those_of_single_searches() {
    let gpu = Arc::new(Gpu::open(&AdapterChoice::default()).unwrap());
    let tracer = PlocGpu::new(Arc::clone(&gpu)).unwrap();
    for (count, radii) in
        [(2, [8, 8]), (7, [8, 8]), (9, [1, 1]), (500, [16, 2]), (2_049, [3, 8]), (6_001, [8, 2]), (6_003, [8, 8])]
    {
        let ([found, expected, other], pairings) = compare(&gpu, &tracer, soup(count), radii);
        assert_eq!(pairings, 0, "{count}");
        let differing = found.iter().zip(&expected).filter(|(found, expected)| found != expected).count();
        assert_eq!(differing, 0, "{count} triangles, radii {radii:?}: {differing} nodes differ");
        assert!(count < 2_000 || found != other, "{count}");
    }
}

/// Proves the same where clusters are too many or too tall, and are paired without a search.
#[test]
fn pairings_are_those_of_the_host() {
    let gpu = Arc::new(Gpu::open(&AdapterChoice::default()).unwrap());
    let tracer = PlocGpu::new(Arc::clone(&gpu)).unwrap();
    for (count, factor) in [(400, 1.2), (5_001, 1.004)] {
        let ([found, expected, _], pairings) = compare(&gpu, &tracer, growing(count, factor), [8, 8]);
        assert!(pairings > 0, "{count}");
        let differing = found.iter().zip(&expected).filter(|(found, expected)| found != expected).count();
        assert_eq!(differing, 0, "{count} triangles: {differing} nodes differ");
    }
}
