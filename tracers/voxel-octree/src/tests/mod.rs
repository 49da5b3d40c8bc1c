//! What is stored and found of hostile triangles, the same by every means, and that the checks notice what is wrong.

mod answers;
mod functions;
mod refused;
mod stored;
mod walked;

use std::sync::Arc;

use tracebench_api::glam::{DVec3, Vec3};
use tracebench_api::{
    Counter, Geometry, Gpu, Hit, Parameters, PhaseClock, Preset, Query, Ray, Structure, Surface, TraceTo, TracerError,
    Viewpoint,
};
use tracebench_kit::Built;
use tracebench_tests::{Numbers, answers, counted, gpu, gpu_that_binds, ray, rectangle, soup, total};

use super::description;
use super::structure::{OctreeStructure, VoxelOctree};

/// Faces of 16 texels, whose tree has 5 levels.
fn viewpoint() -> Viewpoint {
    tracebench_tests::viewpoint(Vec3::new(0.3, -0.2, 0.1), Vec3::NEG_Z, 0.1, 2e3, [63, 41])
}

fn parameters(settings: &[(&str, &str)]) -> Parameters {
    tracebench_tests::parameters(&description().parameters, settings)
}

fn try_built(
    gpu: &Arc<Gpu>,
    geometry: &Geometry,
    settings: &[(&str, &str)],
) -> Result<Built<OctreeStructure>, TracerError> {
    let tracer = VoxelOctree::new(Arc::clone(gpu))?;
    let mut clock = PhaseClock::new(Some(gpu));
    let structure = tracer.build_structure(geometry, &viewpoint(), &parameters(settings), &mut clock)?;
    clock.finish()?;
    Ok(structure)
}

fn built(gpu: &Arc<Gpu>, geometry: &Geometry, settings: &[(&str, &str)]) -> Built<OctreeStructure> {
    try_built(gpu, geometry, settings).unwrap_or_else(|error| panic!("{settings:?}: {error}"))
}

/// Hits, surfaces where they are asked for, and counters where the variant that counts is.
fn answer(
    structure: &Built<OctreeStructure>,
    rays: &[Ray],
    query: Query,
    settings: &[(&str, &str)],
    trace_to: TraceTo,
    counts: bool,
) -> (Vec<Hit>, Vec<Surface>, Vec<Counter>) {
    let (gpu, parameters) = (&structure.kernels.gpu, parameters(settings));
    if counts {
        return counted(gpu, structure, rays, query, &parameters, trace_to);
    }
    let (hits, surfaces) = answers(gpu, structure, rays, query, &parameters, trace_to);
    (hits, surfaces, Vec::new())
}

fn closest(structure: &Built<OctreeStructure>, rays: &[Ray], settings: &[(&str, &str)]) -> Vec<Hit> {
    answer(structure, rays, Query::Closest, settings, TraceTo::Hit, false).0
}

/// Random triangles of many sizes, needles, triangles along the axes' planes, without area, and copies.
fn hostile() -> Vec<[[f32; 3]; 3]> {
    let mut numbers = Numbers::new(31);
    let mut triangles: Vec<[DVec3; 3]> = Vec::new();
    for size in [0.02, 0.2, 1.0, 4.0] {
        for _ in 0..20 {
            let centre = numbers.point() * 6.0;
            let triangle = [0; 3].map(|_| centre + numbers.point() * size);
            triangles.extend([triangle, triangle]);
        }
    }
    for _ in 0..15 {
        let (at, along, other) = (numbers.point() * 4.0, numbers.direction(), numbers.direction());
        triangles.push([at, at + along * 4.0, at + along * 2.0 + other * 1e-3]);
        triangles.push([at, at + along, at + along * 2.0]);
        triangles.push([at, at, at]);
        triangles.push([0; 3].map(|_| at + numbers.point() * 1e-3));
        let flat = DVec3::new(1.0, 1.0, 0.0);
        triangles.push([at, at + along * flat, at + other * flat]);
    }
    triangles.into_iter().map(|corners| corners.map(|corner| corner.as_vec3().into())).collect()
}

/// A wall across the scene at a height.
fn wall(z: f64) -> [[[f32; 3]; 3]; 2] {
    rectangle([-1.0, -1.0, z as f32], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0])
}
