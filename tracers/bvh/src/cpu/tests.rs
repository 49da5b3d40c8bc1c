//! Refits that become rebuilds.

use tracebench_api::glam::Vec3;
use tracebench_api::{Choice, Preset};

use super::*;
use crate::gpu::layout::Tree;
use crate::touched::viewpoint;
use crate::touched::{assert_touched, scene};

/// A grid of triangles that a wave runs through: at another time other triangles lie close together.
fn waving(time: f32) -> Geometry {
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for index in 0..600_u32 {
        let (x, z) = ((index % 25) as f32, (index / 25) as f32);
        let lift = 9.0 * (0.4 * x + time).sin() + 7.0 * (0.9 * z - 2.0 * time).cos();
        let corner = Vec3::new(x + 0.3 * lift, lift, z - 0.2 * lift);
        positions.extend(
            [corner, corner + Vec3::new(0.9, 0.1, 0.0), corner + Vec3::new(0.0, 0.2, 0.8)].map(<[f32; 3]>::from),
        );
        triangles.push([3 * index, 3 * index + 1, 3 * index + 2]);
    }
    Geometry::new(positions, triangles, None).unwrap()
}

fn parameters(build: &str, rebuild_every: u64) -> Parameters {
    let described = description().parameters;
    let mut parameters = Parameters::preset(&described, Preset::Published);
    parameters.set(&described, "build", build).unwrap();
    parameters.set(&described, "rebuild_every", &rebuild_every.to_string()).unwrap();
    parameters
}

fn built(geometry: &Geometry, parameters: &Parameters) -> BvhCpuStructure {
    BvhCpuStructure::build(geometry, &CpuParameters::try_from(parameters).unwrap(), &mut PhaseClock::new(None)).unwrap()
}

/// Refits, and gives the names of the phases.
fn refit(structure: &mut BvhCpuStructure, geometry: &Geometry, parameters: &Parameters) -> Vec<String> {
    let view = viewpoint();
    let mut clock = PhaseClock::new(None);
    structure.update(Update::Refit, geometry, &view, parameters, &mut clock).unwrap();
    clock.finish().unwrap().phases.into_iter().map(|phase| phase.name).collect()
}

/// Everything that a search reads, bit for bit: nodes, order of triangles, triangles, scale, depth.
fn everything(structure: &BvhCpuStructure) -> (Vec<u8>, Vec<u32>, Vec<[u32; 9]>, u32, usize) {
    let Leaves::Edges(triangles) = &structure.triangles else { panic!("published triangles have edges") };
    let bits = |triangle: &RtTriangle| {
        let corners = [triangle.v0, triangle.e1, triangle.e2].map(|vector| vector.to_array().map(f32::to_bits));
        std::array::from_fn(|index| corners[index / 3][index % 3])
    };
    let nodes = bytemuck::cast_slice(&structure.bvh.nodes).to_vec();
    let indices = structure.bvh.primitive_indices.clone();
    (nodes, indices, triangles.iter().map(bits).collect(), structure.scale.to_bits(), structure.depth)
}

/// Proves for every build preset that with `rebuild_every = n` the n-th refit leaves what a fresh build over that frame
/// leaves, bit for bit, by the phases of a build, and again after as many; and that those before are refits by their phases,
/// keep the order that the build gave, and are not what a fresh build leaves (the negative control).
#[test]
fn every_nth_refit_is_a_rebuild() {
    for build in BuildPreset::NAMES {
        for every in [1_u64, 2, 3] {
            let parameters = parameters(build, every);
            let mut structure = built(&waving(0.0), &parameters);
            for frame in 1..=2 * every {
                let (geometry, before) = (waving(frame as f32), everything(&structure));
                let phases = refit(&mut structure, &geometry, &parameters);
                let (found, fresh) = (everything(&structure), everything(&built(&geometry, &parameters)));
                let rebuilt = frame % every == 0;
                let named = |name: &str| phases.iter().any(|phase| phase == name);
                assert_eq!((named("build binary hierarchy (PLOC)"), named("refit boxes")), (rebuilt, !rebuilt));
                assert_eq!(found == fresh, rebuilt, "{build}, frame {frame} of {every}");
                assert_eq!(found.1 == before.1, !rebuilt, "{build}, frame {frame} of {every}");
                structure.validate(&geometry).unwrap();
            }
        }
    }
}

/// Proves that without it no refit is a rebuild, and that it does not change what is built.
#[test]
fn without_it_refits_stay_refits() {
    let never = parameters("medium", 0);
    let mut structure = built(&waving(0.0), &never);
    assert!(everything(&structure) == everything(&built(&waving(0.0), &parameters("medium", 5))));
    let order = structure.bvh.primitive_indices.clone();
    for frame in 1..40 {
        let phases = refit(&mut structure, &waving(frame as f32), &never);
        assert!(phases.iter().any(|phase| phase == "refit boxes"), "{phases:?}");
    }
    assert_eq!(structure.bvh.primitive_indices, order);
}

/// Proves that the refit which would be a rebuild refuses other triangles as every refit does, and that the count starts
/// again with a rebuild that was asked for.
#[test]
fn counting_starts_again_and_others_are_refused() {
    let every_second = parameters("fast", 2);
    let mut structure = built(&waving(0.0), &every_second);
    let named = |phases: Vec<String>| phases.iter().any(|phase| phase == "refit boxes");
    assert!(named(refit(&mut structure, &waving(1.0), &every_second)));
    structure = built(&waving(1.0), &every_second);
    assert!(named(refit(&mut structure, &waving(2.0), &every_second)));
    let whole = waving(3.0);
    let fewer = Geometry::new(whole.positions.to_vec(), whole.triangles[1..].to_vec(), None).unwrap();
    let before = everything(&structure);
    assert!(
        structure.refit(&fewer, &CpuParameters::try_from(&every_second).unwrap(), &mut PhaseClock::new(None)).is_err()
    );
    assert!(everything(&structure) == before);
    assert!(!named(refit(&mut structure, &whole, &every_second)));
}

/// Proves that the nodes and references counted as touched by a set of rays are those whose boxes the rays meet by brute
/// force, with triangles split and not.
#[test]
fn touched_is_what_rays_meet() {
    let (geometry, rays) = scene(None);
    for build in ["fastest", "very_slow"] {
        let parameters = parameters(build, 0);
        let structure = built(&geometry, &parameters);
        let tree = Tree::Wide(structure.bvh.clone());
        assert_touched(build, &structure, &tree, (&geometry, &rays), (structure.scale, &parameters), None);
    }
}
