//! That one structure serves every value of a trace parameter, as descriptions promise and the harness relies on: contenders that
//! differ in parameters of the trace alone share what is built.

mod subject;

use subject::Subject;
use tracebench_api::glam::Vec3;
use tracebench_api::{Geometry, Hit, ParameterScope, PhaseClock, Query, Ray, Structure, Viewpoint};
use tracebench_harness::registry::TRACERS;
use tracebench_scenes::procedural;
use tracebench_tests::{Numbers, available, gpu, ray, viewpoint};

/// The room seen from within, with rays from all over it.
fn scene() -> (Geometry, Viewpoint, Vec<Ray>) {
    let (geometry, rays) = subject::room(&gpu());
    let camera = procedural("room", 0.1).unwrap().cameras.remove(0);
    let [eye, target] = [camera.eye, camera.target].map(Vec3::from);
    let view = viewpoint(eye, target, 0.05, 50.0, [64, 32]);
    let mut numbers = Numbers::new(62);
    // Half of them from the eye, which every view sees.
    let from_eye = (0..1000).map(|_| ray(eye.as_dvec3(), numbers.direction()));
    (geometry, view, rays.into_iter().take(1000).chain(from_eye).collect())
}

fn build(subject: &Subject, geometry: &Geometry, view: &Viewpoint) -> Box<dyn Structure> {
    let mut clock = PhaseClock::new(Some(&subject.gpu));
    let mut structure = subject.tracer.build(geometry, view, &subject.parameters, &mut clock).unwrap();
    clock.finish().unwrap();
    assert!(!structure.make_room().unwrap());
    structure
}

/// Hits of a tracer with a value: from a structure that was built with the preset's values, and from one of its own.
fn both(name: &str, (parameter, value): (&str, &str), query: Query) -> [Vec<Hit>; 2] {
    let (geometry, view, rays) = scene();
    let (preset, changed) = (Subject::new(name, &[], &gpu()), Subject::new(name, &[(parameter, value)], &gpu()));
    let (shared, own) = (build(&preset, &geometry, &view), build(&changed, &geometry, &view));
    [&shared, &own].map(|structure| changed.answer(&**structure, &rays, query).0)
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
                let [shared, own] = both(name, (parameter.name, &value), Query::Closest);
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
    let [shared, own] = both("fragment-abuffer", ("views", "frame"), Query::Closest);
    assert!(shared != own, "a structure of seven views answers as one of a single view does");
    let [shared, own] = both("dirt", ("views", "frame"), Query::Closest);
    assert!(shared != own, "a structure of six views answers as one of a single view does");
}
