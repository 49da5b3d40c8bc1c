//! What is stored and found of hostile triangles and of minimal scenes, the same by every means, and that the check notices what is wrong.

mod answers;
mod closed;
mod crossings;
mod planes;
mod stored;
mod true_hits;

use std::sync::Arc;

use tracebench_api::glam::{DVec3, Vec3};
use tracebench_api::{
    Counter, Geometry, Gpu, Hit, HitBuffer, Parameters, PhaseClock, Query, Ray, RayBuffer, Residency, Structure,
    Surface, TraceJob, TraceTo, TracerError, Viewpoint,
};
use tracebench_kit::Built;
use tracebench_tests::{Numbers, answers, gpu, gpu_that_binds, ray, rectangle as rectangle_of, soup, total};

use super::description;
use super::structure::{VoxelAbuffer, VoxelStructure};

/// Faces of 16 texels, of which images have 40 and the grid 16.
fn viewpoint() -> Viewpoint {
    Viewpoint {
        eye: Vec3::new(0.3, -0.2, 0.1),
        forward: Vec3::NEG_Z,
        up: Vec3::Y,
        vertical_fov: 1.2,
        near: 0.1,
        far: 2e3,
        frame: [63, 41],
        face: 16,
    }
}

fn parameters(settings: &[(&str, &str)]) -> Parameters {
    tracebench_tests::parameters(&description().parameters, settings)
}

fn try_built(
    gpu: &Arc<Gpu>,
    geometry: &Geometry,
    settings: &[(&str, &str)],
) -> Result<Built<VoxelStructure>, TracerError> {
    let tracer = VoxelAbuffer::new(Arc::clone(gpu))?;
    let mut clock = PhaseClock::new(Some(gpu));
    let structure = tracer.build_structure(geometry, &viewpoint(), &parameters(settings), &mut clock)?;
    clock.finish()?;
    Ok(structure)
}

fn built(gpu: &Arc<Gpu>, geometry: &Geometry, settings: &[(&str, &str)]) -> Built<VoxelStructure> {
    try_built(gpu, geometry, settings).unwrap_or_else(|error| panic!("{settings:?}: {error}"))
}

/// Hits and, where they are asked for, surfaces.
fn answer(
    gpu: &Arc<Gpu>,
    structure: &Built<VoxelStructure>,
    rays: &[Ray],
    query: Query,
    settings: &[(&str, &str)],
    trace_to: TraceTo,
) -> (Vec<Hit>, Vec<Surface>) {
    answers(gpu, structure, rays, query, &parameters(settings), trace_to)
}

fn closest(gpu: &Arc<Gpu>, structure: &Built<VoxelStructure>, rays: &[Ray], settings: &[(&str, &str)]) -> Vec<Hit> {
    answer(gpu, structure, rays, Query::Closest, settings, TraceTo::Hit).0
}

/// Hits and counters by the variant that counts.
fn counted(
    gpu: &Arc<Gpu>,
    structure: &Built<VoxelStructure>,
    rays: &[Ray],
    query: Query,
    settings: &[(&str, &str)],
) -> (Vec<Hit>, Vec<Counter>) {
    let (hits, _, counters) =
        tracebench_tests::counted(gpu, structure, rays, query, &parameters(settings), TraceTo::Hit);
    (hits, counters)
}

/// Random triangles of many sizes, needles, triangles along the axes' planes, without area, and copies.
fn hostile() -> Vec<[[f32; 3]; 3]> {
    let mut numbers = Numbers::new(31);
    let mut triangles: Vec<[DVec3; 3]> = Vec::new();
    for size in [0.02, 0.2, 1.0, 4.0] {
        for _ in 0..40 {
            let centre = numbers.point() * 6.0;
            let triangle = [0; 3].map(|_| centre + numbers.point() * size);
            triangles.extend([triangle, triangle]);
        }
    }
    for _ in 0..30 {
        let (at, along, other) = (numbers.point() * 4.0, numbers.direction(), numbers.direction());
        triangles.push([at, at + along * 4.0, at + along * 2.0 + other * 1e-3]);
        triangles.push([at, at + along, at + along * 2.0]);
        triangles.push([at, at, at]);
        triangles.push([0; 3].map(|_| at + numbers.point() * 1e-3));
        let [flat, tilted] = [DVec3::new(1.0, 1.0, 0.0), DVec3::new(1.0, 1.0, 1e-5)];
        triangles.push([at, at + along * flat, at + other * flat]);
        triangles.push([at, at + along * tilted, at + other * tilted]);
    }
    triangles.into_iter().map(|corners| corners.map(|corner| corner.as_vec3().into())).collect()
}

fn rectangle(corner: DVec3, first: DVec3, second: DVec3) -> [[[f32; 3]; 3]; 2] {
    let [corner, first, second] = [corner, first, second].map(|vector| vector.as_vec3().into());
    rectangle_of(corner, first, second)
}

/// A box whose normals point outwards, as twelve triangles.
fn solid(low: DVec3, high: DVec3) -> Vec<[[f32; 3]; 3]> {
    let size = high - low;
    let [x, y, z] = [DVec3::X * size.x, DVec3::Y * size.y, DVec3::Z * size.z];
    let before = [(low, z, y), (low, x, z), (low, y, x)];
    let behind = [(high, -y, -z), (high, -z, -x), (high, -x, -y)];
    before.into_iter().chain(behind).flat_map(|(corner, first, second)| rectangle(corner, first, second)).collect()
}

fn rays(count: usize) -> Vec<Ray> {
    let mut numbers = Numbers::new(4);
    let any = |index: usize, numbers: &mut Numbers| match index % 4 {
        // From outside, along axes, from anywhere within, to and from surfaces nearby.
        0 => {
            let from = numbers.direction() * 20.0;
            ray(from, numbers.point() * 5.0 - from)
        }
        1 => ray(numbers.point() * 8.0, [DVec3::X, DVec3::NEG_Y, DVec3::Z][index % 3]),
        2 => ray(numbers.point() * 5.0, numbers.direction()),
        _ => Ray { t_min: 0.5, t_max: 4.0, ..ray(numbers.point() * 5.0, numbers.direction()) },
    };
    (0..count).map(|index| any(index, &mut numbers)).collect()
}
