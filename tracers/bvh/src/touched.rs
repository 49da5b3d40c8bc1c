//! What a set of rays touches of a hierarchy, by brute force: what counters of touched nodes and references are held
//! against.

use glam::{DVec3, Vec3};
use obvhs::aabb::Aabb;
use tracebench_api::{AdapterChoice, Counter, Geometry, Gpu, HitBuffer, Parameters, Query, Ray, RayBuffer, TraceTo};
use tracebench_api::{Residency, Structure, TraceJob, Viewpoint};

use std::sync::Arc;

use crate::binary::{INNER, box_of};
use crate::gpu::layout::Tree;

/// By how much boxes are shrunk and grown, over the scene's diagonal: more than searches and compressed boxes round by.
const MARGIN: f64 = 1e-5;

/// A seeded number from -1 to 1 (splitmix64).
fn signed(state: &mut u64) -> f64 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mixed = (*state ^ (*state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((mixed ^ (mixed >> 31)) >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
}

/// Needles of no area, which nothing hits, so that what a search visits hangs on boxes alone and not on its order; and
/// short rays among them, which together meet a part.
pub(crate) fn scene(gpu: Option<&Gpu>) -> (Geometry, Vec<Ray>) {
    let mut state = 5;
    let mut point = || DVec3::new(signed(&mut state), signed(&mut state), signed(&mut state));
    let mut positions = Vec::new();
    for _ in 0..3000 {
        let from = 8.0 * point();
        let to = from + 0.7 * point();
        positions.extend([from, to, to].map(|corner| corner.as_vec3().to_array()));
    }
    let triangles = (0..3000).map(|index| [3 * index, 3 * index + 1, 3 * index + 2]).collect();
    let ray = |_| Ray {
        origin: (8.0 * point()).as_vec3().to_array(),
        direction: point().normalize().as_vec3().to_array(),
        t_min: 0.0,
        t_max: 3.0,
    };
    let rays = (0..2000).map(ray).collect();
    (Geometry::new(positions, triangles, gpu).unwrap(), rays)
}

/// Hierarchies hang on none.
pub(crate) fn viewpoint() -> Viewpoint {
    Viewpoint {
        eye: Vec3::ZERO,
        forward: Vec3::X,
        up: Vec3::Y,
        vertical_fov: 1.0,
        near: 0.1,
        far: 100.0,
        frame: [8, 8],
        face: 8,
    }
}

/// A device of one's own.
pub(crate) fn gpu() -> Arc<Gpu> {
    Arc::new(Gpu::open(&AdapterChoice::default()).unwrap())
}

fn counters(structure: &dyn Structure, rays: &[Ray], parameters: &Parameters, gpu: Option<&Gpu>) -> Vec<Counter> {
    let rays = RayBuffer::new(Arc::new(rays.to_vec()), Query::Closest, gpu);
    let residency = if gpu.is_some() { Residency::Device } else { Residency::Host };
    let mut hits = HitBuffer::new(rays.host.len(), residency, gpu).unwrap();
    let job = TraceJob { rays: &rays, trace_to: TraceTo::Hit, parameters };
    let counters = structure.trace_counted(job, &mut hits).unwrap();
    assert!(hits.read(gpu).unwrap().iter().all(|hit| !hit.is_hit()), "something was hit");
    counters
}

fn meets(bounds: &Aabb, ray: &Ray, scale: f64, grow: f64) -> bool {
    let origin = DVec3::from(ray.origin.map(f64::from)) * scale;
    let direction = DVec3::from(ray.direction.map(f64::from));
    let low = (bounds.min.as_dvec3() - grow - origin) / direction;
    let high = (bounds.max.as_dvec3() + grow - origin) / direction;
    let enter = low.min(high).max_element().max(f64::from(ray.t_min) * scale);
    let leave = low.max(high).min_element().min(f64::from(ray.t_max) * scale);
    // A box that was shrunk may be inside out.
    enter <= leave && (bounds.max - bounds.min).as_dvec3().min_element() >= -2.0 * grow
}

/// Numbers of nodes and references that any of the rays touches, with every box grown.
fn by_force(tree: &Tree, rays: &[Ray], scale: f64, grow: f64) -> [usize; 2] {
    let mut nodes = vec![false; tree.node_count()];
    let mut references = vec![false; tree.primitive_indices().len()];
    for ray in rays {
        let mut open = vec![0_usize];
        while let Some(index) = open.pop() {
            match tree {
                Tree::Wide(wide) => {
                    nodes[index] = true;
                    let node = &wide.nodes[index];
                    for child in (0..8).filter(|child| !node.is_child_empty(*child)) {
                        if !meets(&node.child_aabb(child), ray, scale, grow) {
                            continue;
                        }
                        if node.is_leaf(child) {
                            let (first, count) = node.child_primitives(child);
                            references[first as usize..(first + count) as usize].fill(true);
                        } else {
                            open.push(node.child_node_index(child) as usize);
                        }
                    }
                }
                // Places are those of pairs.
                Tree::Binary(binary) => {
                    nodes[index..index + 2].fill(true);
                    for node in
                        binary.nodes[index..index + 2].iter().filter(|node| meets(&box_of(node), ray, scale, grow))
                    {
                        let first = node.first as usize;
                        match node.count {
                            INNER => open.push(first),
                            count => references[first..first + count as usize].fill(true),
                        }
                    }
                }
            }
        }
    }
    [nodes, references].map(|bits| bits.into_iter().filter(|bit| *bit).count())
}

/// Holds what a structure counts over the rays of [`scene`] between brute force with boxes shrunk and grown by the
/// rounding of searches; and shows that it would be noticed if the rays were others.
pub(crate) fn assert_touched(
    name: &str,
    structure: &dyn Structure,
    tree: &Tree,
    (geometry, rays): (&Geometry, &[Ray]),
    (scale, parameters): (f32, &Parameters),
    gpu: Option<&Gpu>,
) {
    let scale = f64::from(scale);
    let grow = MARGIN * geometry.diagonal() * scale;
    let touched = |rays: &[Ray]| {
        let counters = counters(structure, rays, parameters, gpu);
        ["nodes_touched", "references_touched"].map(|name| {
            let counter = counters.iter().find(|counter| counter.name == name).unwrap();
            assert_eq!(counter.max_per_ray, None);
            counter.total as usize
        })
    };
    let between = |found: [usize; 2], rays: &[Ray]| {
        let (least, most) = (by_force(tree, rays, scale, -grow), by_force(tree, rays, scale, grow));
        // Narrow enough to say something.
        assert!((0..2).all(|which| most[which] - least[which] <= 2 + most[which] / 50), "{name}: {least:?} {most:?}");
        (0..2).all(|which| (least[which]..=most[which]).contains(&found[which]))
    };
    let (half, whole) = (&rays[..rays.len() / 2], rays);
    for rays in [&rays[..1], half, whole] {
        let found = touched(rays);
        assert!(between(found, rays), "{name}: {found:?} by {} rays", rays.len());
    }
    assert!(!between(touched(whole), half) && !between(touched(half), whole), "{name}");
    let stored = [tree.node_count(), tree.primitive_indices().len()];
    let part = touched(whole);
    assert!((0..2).all(|which| 5 * part[which] > stored[which] && part[which] < stored[which]), "{name}: {part:?}");
}
