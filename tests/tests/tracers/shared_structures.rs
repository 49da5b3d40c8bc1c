//! That one structure serves every value of a trace parameter, as descriptions promise and the harness relies on: contenders that
//! differ in parameters of the trace alone share what is built.

use std::sync::Arc;

use tracebench_api::glam::Vec3;
use tracebench_api::{
    EndPoint, Geometry, Hit, HitBuffer, ParameterScope, Parameters, PhaseClock, Preset, Query, Ray, RayBuffer,
    Structure, TraceJob, Viewpoint,
};
use tracebench_harness::registry::{TRACERS, find};
use tracebench_scenes::procedural;
use tracebench_tests::{Numbers, available, gpu, ray, viewpoint};

/// The room seen from within, with rays from all over it.
fn scene() -> (Geometry, Viewpoint, Vec<Ray>) {
    let scene = procedural("room", 0.1).unwrap();
    let camera = &scene.cameras[0];
    let [eye, target] = [camera.eye, camera.target].map(Vec3::from);
    let view = viewpoint(eye, target, 0.05, 50.0, [64, 32]);
    let mut numbers = Numbers::new(62);
    let (low, high) = (Vec3::from(scene.bounds_min).as_dvec3(), Vec3::from(scene.bounds_max).as_dvec3());
    // Half of them from the eye, which every view sees.
    let origin = |index: u32, numbers: &mut Numbers| match index % 2 {
        0 => eye.as_dvec3(),
        _ => low + (numbers.point() * 0.5 + 0.5) * (high - low),
    };
    let rays = (0..2000).map(|index| ray(origin(index, &mut numbers), numbers.direction())).collect();
    let mesh = scene.mesh;
    (Geometry::new(mesh.positions, mesh.triangles, Some(&gpu())).unwrap(), view, rays)
}

/// Hits of a tracer with a value: from a structure that was built with the preset's values, and from one of its own.
fn both(name: &str, (parameter, value): (&str, &str)) -> [Vec<Hit>; 2] {
    let gpu = gpu();
    let (geometry, view, rays) = scene();
    let registration = find(name).unwrap();
    let description = (registration.describe)();
    let tracer = registration.create(&Ok(Arc::clone(&gpu))).unwrap();
    let preset = Parameters::preset(&description.parameters, Preset::Published);
    let mut changed = preset.clone();
    changed.set(&description.parameters, parameter, value).unwrap();
    let build = |parameters: &Parameters| {
        let mut clock = PhaseClock::new(Some(&gpu));
        let mut structure: Box<dyn Structure> = tracer.build(&geometry, &view, parameters, &mut clock).unwrap();
        clock.finish().unwrap();
        assert!(!structure.make_room().unwrap());
        structure
    };
    let structures = [build(&preset), build(&changed)];
    let rays = RayBuffer::new(Arc::new(rays), Query::Closest, Some(&gpu));
    structures.map(|structure| {
        let job = TraceJob { rays: &rays, end: EndPoint::Hit, parameters: &changed };
        let mut hits = HitBuffer::new(rays.host.len(), description.residency, Some(&gpu)).unwrap();
        let mut clock = PhaseClock::new(Some(&gpu));
        structure.trace(job, &mut hits, &mut clock).unwrap();
        clock.finish().unwrap();
        hits.read(Some(&gpu)).unwrap()
    })
}

/// Proves for every tracer and every value worth sweeping of every trace parameter that the hits from a structure that was
/// built with other values are those from one of its own, bit for bit.
#[test]
fn trace_parameters_share_structures() {
    let mut compared = 0;
    for registration in TRACERS {
        let description = (registration.describe)();
        let name = description.name;
        if available(name, registration.create(&Ok(gpu())), &gpu()).is_none() {
            continue;
        }
        for parameter in description.parameters.iter().filter(|each| each.scope == ParameterScope::Trace) {
            // The ends of the sweep: what lies between them is built from the same.
            let ends = [parameter.sweep.first(), parameter.sweep.last()];
            for value in ends.into_iter().flatten().map(ToString::to_string) {
                let [shared, own] = both(name, (parameter.name, &value));
                assert!(shared == own, "{name} {}={value}", parameter.name);
                compared += 1;
            }
        }
    }
    assert!(compared > 20, "{compared}");
}

/// The negative control: of a build parameter the same comparison tells the two apart.
#[test]
fn build_parameters_do_not() {
    let [shared, own] = both("fragment-abuffer", ("views", "frame"));
    assert!(shared != own, "a structure of seven views answers as one of a single view does");
    let [shared, own] = both("dirt", ("views", "frame"));
    assert!(shared != own, "a structure of six views answers as one of a single view does");
}
