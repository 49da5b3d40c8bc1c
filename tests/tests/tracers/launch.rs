//! That how a search reads and is launched changes nothing of what it finds.

use std::sync::Arc;

use tracebench_api::glam::Vec3;
use tracebench_api::{
    Geometry, Hit, HitBuffer, Parameters, PhaseClock, Preset, Query, Ray, RayBuffer, Surface, TraceJob, TraceTo,
    Viewpoint,
};
use tracebench_harness::launch::combinations;
use tracebench_harness::registry::TRACERS;
use tracebench_harness::results::{MEMORY_ACCESS, RAYS_PER_LANE};
use tracebench_scenes::procedural;
use tracebench_tests::{Numbers, available, gpu, ray, viewpoint};

/// The room seen from within, with rays from all over it.
fn scene() -> (Geometry, Viewpoint, Arc<Vec<Ray>>) {
    let scene = procedural("room", 0.05).unwrap();
    let camera = &scene.cameras[0];
    let view = viewpoint(camera.eye.into(), camera.target.into(), 0.05, 50.0, [64, 32]);
    let mut numbers = Numbers::new(91);
    let (low, high) = (Vec3::from(scene.bounds_min).as_dvec3(), Vec3::from(scene.bounds_max).as_dvec3());
    // As many as fill no workgroup of persistent lanes, a third from the eye, which every view sees.
    let origin = |index: u32, numbers: &mut Numbers| match index % 3 {
        0 => view.eye.as_dvec3(),
        _ => low + (numbers.point() * 0.5 + 0.5) * (high - low),
    };
    let rays = (0..2100).map(|index| ray(origin(index, &mut numbers), numbers.direction())).collect();
    let mesh = scene.mesh;
    (Geometry::new(mesh.positions, mesh.triangles, Some(&gpu())).unwrap(), view, Arc::new(rays))
}

/// Hits and surfaces as bytes: any bit counts.
fn bytes(hits: &[Hit], surfaces: &[Surface]) -> Vec<u8> {
    [bytemuck::cast_slice::<Hit, u8>(hits), bytemuck::cast_slice::<Surface, u8>(surfaces)].concat()
}

/// Proves for every tracer that has the choice that hits and surfaces are the same bit for bit from buffers and textures, with a ray
/// a lane and with many, of both queries, timed and counted; and that what textures take, or what they save, is in the ledger.
#[test]
fn means_change_no_hit() {
    let gpu = gpu();
    let (geometry, view, rays) = scene();
    let mut compared = 0;
    for registration in TRACERS {
        let description = registration.describe();
        let name = description.name;
        let has = |parameter: &str| description.parameters.iter().any(|each| each.name == parameter);
        if !has(MEMORY_ACCESS) || !has(RAYS_PER_LANE) {
            continue;
        }
        let created = registration.create(&Ok(Arc::clone(&gpu)));
        let Some(tracer) = available(name, created, &gpu) else { continue };
        let mut first: Option<Vec<Vec<u8>>> = None;
        let mut structure_bytes = Vec::new();
        for launch in combinations() {
            let mut parameters = Parameters::preset(&description.parameters, Preset::Published);
            parameters.set(&description.parameters, MEMORY_ACCESS, &launch.memory_access).unwrap();
            parameters.set(&description.parameters, RAYS_PER_LANE, &launch.rays_per_lane.to_string()).unwrap();
            let mut clock = PhaseClock::new(Some(&gpu));
            let mut structure = tracer.build(&geometry, &view, &parameters, &mut clock).unwrap();
            clock.finish().unwrap();
            if structure.grow_on_overflow().unwrap() {
                let mut clock = PhaseClock::new(Some(&gpu));
                let update = tracebench_api::Update::Rebuild;
                structure.update(update, &geometry, &view, &parameters, &mut clock).unwrap();
                clock.finish().unwrap();
            }
            structure_bytes.push((launch.memory_access.clone(), structure.memory().structure_bytes()));
            let mut answers = Vec::new();
            for (query, trace_to) in [(Query::Closest, TraceTo::Surface), (Query::Any, TraceTo::Hit)] {
                let rays = RayBuffer::new(Arc::clone(&rays), query, Some(&gpu));
                let job = TraceJob { rays: &rays, trace_to, parameters: &parameters };
                let mut hits =
                    HitBuffer::tracing_to(trace_to, rays.host.len(), description.residency, Some(&gpu)).unwrap();
                hits.poison(Some(&gpu)).unwrap();
                let mut clock = PhaseClock::new(Some(&gpu));
                structure.trace(job, &mut hits, &mut clock).unwrap();
                clock.finish().unwrap();
                let timed = hits.read(Some(&gpu)).unwrap();
                assert!(timed.iter().filter(|hit| hit.is_hit()).count() > 300, "{name}, {launch}: hardly a hit");
                answers.push(bytes(&timed, &hits.read_surfaces(Some(&gpu)).unwrap()));
                hits.poison(Some(&gpu)).unwrap();
                structure.trace_counted(job, &mut hits).unwrap();
                let counted = hits.read(Some(&gpu)).unwrap();
                assert!(answers.last() == Some(&bytes(&counted, &hits.read_surfaces(Some(&gpu)).unwrap())), "{name}");
            }
            let expected = first.get_or_insert_with(|| answers.clone());
            assert!(answers == *expected, "{name} answers otherwise by {launch}");
            // The negative control: one bit is noticed.
            answers[0][4] ^= 1;
            assert!(answers != *expected);
            compared += 1;
        }
        let of =
            |memory_access: &str| structure_bytes.iter().find(|(of, _)| of == memory_access).map(|(_, bytes)| *bytes);
        assert_ne!(of("buffer"), of("texture"), "{name}");
    }
    assert!(compared >= 20, "{compared}");
}
