//! That the checks of hierarchies notice what is wrong with one that the device built, and constants of both sides.

use std::sync::Arc;

use tracebench_api::{AdapterChoice, Geometry, Gpu, Parameters, PhaseClock, Preset};
use tracebench_shaders::Shader;
use tracebench_shaders::bvh::{CONVERT, Cluster, LEAVES};

use super::iterations::LAST_CLUSTERS;
use super::kernels::{CROWDED, FINISHED, LEVELS, RUN, SEARCHED, TAKEN_SLOTS};
use super::{LbvhGpu, description};
use crate::gpu::BINARY_STACK;
use crate::gpu::tests::{assert_unsound_ones_are_noticed, field};
use crate::touched::{self, assert_touched};

/// Hierarchies read back from the device pass as they are, by both nodes; those that were spoilt do not.
#[test]
fn unsound_hierarchies_are_noticed() {
    let gpu = Arc::new(Gpu::open(&AdapterChoice::default()).unwrap());
    let corners = field().into_iter().flat_map(|triangle| [triangle.v0, triangle.v1, triangle.v2]);
    let positions: Vec<[f32; 3]> = corners.map(|corner| corner.to_array()).collect();
    let triangles = (0..positions.len() as u32 / 3).map(|first| [3 * first, 3 * first + 1, 3 * first + 2]).collect();
    let geometry = Geometry::new(positions, triangles, Some(&gpu)).unwrap();
    let tracer = LbvhGpu::new(Arc::clone(&gpu)).unwrap();
    let described = description().parameters;
    for node in ["cwbvh", "bvh2"] {
        let mut parameters = Parameters::preset(&described, Preset::Published);
        parameters.set(&described, "node", node).unwrap();
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
    let tracer = LbvhGpu::new(Arc::clone(&gpu)).unwrap();
    let described = description().parameters;
    for node in ["cwbvh", "bvh2"] {
        let mut parameters = Parameters::preset(&described, Preset::Published);
        parameters.set(&described, "node", node).unwrap();
        let mut clock = PhaseClock::new(Some(&gpu));
        let structure = tracer.build_structure(&geometry, &touched::viewpoint(), &parameters, &mut clock).unwrap();
        clock.finish().unwrap();
        let (tree, _) = structure.read().unwrap();
        let units = (structure.scale, &parameters);
        assert_touched(node, &structure, &tree, (&geometry, &rays), units, Some(&gpu));
    }
}
