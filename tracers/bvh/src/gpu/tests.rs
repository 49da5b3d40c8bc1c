//! That the checks of hierarchies notice what is wrong with one.

use glam::Vec3A;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::node::Bvh2Node;
use obvhs::ray::{Ray, RayHit};
use obvhs::triangle::Triangle;
use tracebench_api::{Ledger, Parameters, PhaseClock, Preset};

use super::description::GpuParameters;
use super::layout::{DeviceTriangle, Tree};
use super::{BvhGpu, description};
use crate::binary::{Binary, INNER};
use crate::hierarchy;
use crate::input::BuildPreset;
use crate::touched::{assert_touched, gpu, scene};

/// A field of triangles, no two of which share a box.
pub(crate) fn field() -> Vec<Triangle> {
    let place = |index: usize| {
        let (x, z) = ((index % 24) as f32 * 5.0, (index / 24) as f32 * 5.0);
        let corner = Vec3A::new(x, ((index * 7) % 5) as f32, z);
        Triangle { v0: corner, v1: corner + Vec3A::new(3.0, 0.5, 0.0), v2: corner + Vec3A::new(0.0, 1.0, 4.0) }
    };
    (0..480).map(place).collect()
}

fn built(node: &str) -> (Tree, Vec<DeviceTriangle>) {
    let described = description().parameters;
    let mut parameters = Parameters::preset(&described, Preset::Published);
    parameters.set(&described, "node", node).unwrap();
    let triangles = field();
    let parameters = GpuParameters::try_from(&parameters).unwrap();
    let tree = Tree::build(&triangles, &parameters, &mut Ledger::new(), &mut PhaseClock::new(None));
    let ordered = tree.order(&triangles);
    (tree, ordered)
}

/// Sound hierarchies over 480 triangles, as `fresh` gives them, pass; a triangle that is missing, one that is there twice,
/// and boxes, children or leaves that are off are noticed.
pub(crate) fn assert_unsound_ones_are_noticed(node: &str, fresh: &dyn Fn() -> (Tree, Vec<DeviceTriangle>)) {
    let noticed = |spoil: &dyn Fn(&mut Tree, &mut Vec<DeviceTriangle>)| {
        let (mut tree, mut ordered) = fresh();
        tree.check(&ordered, 480, false).unwrap();
        spoil(&mut tree, &mut ordered);
        tree.check(&ordered, 480, false).is_err()
    };
    assert!(!noticed(&|_, _| ()));
    assert!(noticed(&|_, ordered| ordered[7].second[1] += 1e5), "{node}");
    assert!(noticed(&|tree, _| match tree {
        Tree::Wide(wide) => wide.primitive_indices[3] = wide.primitive_indices[4],
        Tree::Binary(binary) => binary.primitive_indices[3] = binary.primitive_indices[4],
    }));
    assert!(noticed(&|tree, _| match tree {
        Tree::Wide(wide) => wide.primitive_indices[3] = 480,
        Tree::Binary(binary) => binary.primitive_indices[3] = 480,
    }));
    assert!(noticed(&|tree, _| match tree {
        Tree::Wide(wide) => wide.nodes[0].p.x += 9e3,
        Tree::Binary(binary) => binary.nodes[0].high[0] -= 9e3,
    }));
    assert!(noticed(&|tree, _| match tree {
        Tree::Wide(wide) => wide.nodes[0].child_base_idx = 0,
        Tree::Binary(binary) =>
            if let Some(inner) = binary.nodes.iter_mut().find(|node| node.count == INNER) {
                inner.first = 0;
            },
    }));
    assert!(noticed(&|tree, _| match tree {
        Tree::Wide(wide) => {
            // The last node has nothing but leaves.
            if let Some(last) = wide.nodes.last_mut() {
                last.primitive_base_idx += 1;
            }
        }
        Tree::Binary(binary) =>
            if let Some(leaf) = binary.nodes.iter_mut().find(|node| node.count != INNER) {
                leaf.first += 1;
            },
    }));
}

/// Sound hierarchies pass and unsound ones do not, by both nodes.
#[test]
fn unsound_hierarchies_are_noticed() {
    for node in ["cwbvh", "bvh2"] {
        assert_unsound_ones_are_noticed(node, &|| built(node));
    }
}

/// The binary hierarchy as stored is obvhs's: over rays through the field, obvhs's own traversal finds the same boxes'
/// triangles in both. A hierarchy of a single leaf has two nodes, one of which is empty.
#[test]
fn binary_nodes_are_those_of_obvhs() {
    let triangles = field();
    let config = BuildPreset::Medium.values();
    let from = hierarchy::build_binary(&triangles, config, &mut Ledger::new(), &mut PhaseClock::new(None));
    let stored = Binary::new(&from);
    // A root over the stored pairs makes it one that obvhs traverses.
    let box_of = |low: [f32; 3], high: [f32; 3]| obvhs::aabb::Aabb::new(low.into(), high.into());
    let mut nodes = vec![Bvh2Node::new(*from.nodes[0].aabb(), 0, 1)];
    for node in &stored.nodes {
        let (first, count) = if node.count == INNER { (node.first + 1, 0) } else { (node.first, node.count) };
        nodes.push(Bvh2Node::new(box_of(node.low, node.high), count, first));
    }
    let copy = Bvh2 { nodes, primitive_indices: stored.primitive_indices.clone(), ..Bvh2::default() };
    for index in 0..300 {
        let origin = Vec3A::new(index as f32 * 0.4, 9.0, 50.0 - index as f32 * 0.1);
        let ray = Ray::new_inf(origin, Vec3A::new(0.3, -1.0, 0.2 - index as f32 * 1e-3).normalize());
        let search = |bvh: &Bvh2| {
            let (mut hit, mut tested) = (RayHit::none(), Vec::new());
            bvh.ray_traverse(ray, &mut hit, |ray, slot| {
                tested.push(bvh.primitive_indices[slot]);
                triangles[bvh.primitive_indices[slot] as usize].intersect(ray)
            });
            (hit.t, tested)
        };
        assert_eq!(search(&from), search(&copy));
    }
    let single = hierarchy::build_binary(&triangles[..1], config, &mut Ledger::new(), &mut PhaseClock::new(None));
    let single = Binary::new(&single);
    assert_eq!((single.nodes[0].count, single.nodes[1].count, single.depth()), (1, 0, 1));
}

/// Proves that the nodes and references counted as touched by a set of rays are those whose boxes the rays meet by brute
/// force, of both kinds of node.
#[test]
fn touched_is_what_rays_meet() {
    let gpu = gpu();
    let (geometry, rays) = scene(Some(&gpu));
    let tracer = BvhGpu::new(gpu.clone()).unwrap();
    let described = description().parameters;
    for node in ["cwbvh", "bvh2"] {
        let mut parameters = Parameters::preset(&described, Preset::Published);
        parameters.set(&described, "node", node).unwrap();
        let mut clock = PhaseClock::new(Some(&gpu));
        let structure =
            tracer.build_structure(&geometry, &crate::touched::viewpoint(), &parameters, &mut clock).unwrap();
        clock.finish().unwrap();
        let (tree, _) = structure.resident.read(&gpu).unwrap();
        let units = (structure.scale, &parameters);
        assert_touched(node, &structure, &tree, (&geometry, &rays), units, Some(&gpu));
    }
}
