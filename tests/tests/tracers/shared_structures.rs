//! That one structure serves every value of a trace parameter, as descriptions promise and the harness relies on: configurations that
//! differ in parameters of the trace alone share what is built.

use std::sync::Arc;

use tracebench_api::glam::Vec3;
use tracebench_api::{
    Geometry, Gpu, Hit, HitBuffer, ParameterScope, Parameters, PhaseClock, Preset, Query, RayBuffer, Structure,
    TraceJob, TraceTo, Tracer, TracerDescription, Viewpoint,
};
use tracebench_harness::registry::{Registration, TRACERS, find};
use tracebench_scenes::procedural;
use tracebench_tests::{Numbers, available, gpu, ray, viewpoint};

/// A tracer over the room seen from within, with rays from all over it and the structure that its preset builds.
struct Subject {
    gpu: Arc<Gpu>,
    description: TracerDescription,
    tracer: Box<dyn Tracer>,
    geometry: Geometry,
    view: Viewpoint,
    rays: RayBuffer,
    preset: Box<dyn Structure>,
}

impl Subject {
    /// Nothing where the adapter cannot run it.
    fn new(registration: &Registration) -> Option<Self> {
        let gpu = gpu();
        let description = registration.describe();
        let tracer = available(description.name, registration.create(&Ok(Arc::clone(&gpu))), &gpu)?;
        let scene = procedural("room", 0.03).unwrap();
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
        let rays = RayBuffer::new(Arc::new(rays), Query::Closest, Some(&gpu));
        let geometry = Geometry::new(scene.mesh.positions, scene.mesh.triangles, Some(&gpu)).unwrap();
        let parameters = Parameters::preset(&description.parameters, Preset::Published);
        let preset = build(&*tracer, &geometry, &view, &parameters, &gpu);
        Some(Self { gpu, description, tracer, geometry, view, rays, preset })
    }

    /// Hits with a value: from the structure that was built with the preset's values, and from one of its own.
    fn both(&self, parameter: &str, value: &str) -> [Vec<Hit>; 2] {
        let described = &self.description.parameters;
        let mut changed = Parameters::preset(described, Preset::Published);
        changed.set(described, parameter, value).unwrap();
        let own = build(&*self.tracer, &self.geometry, &self.view, &changed, &self.gpu);
        [&self.preset, &own].map(|structure| {
            let job = TraceJob { rays: &self.rays, trace_to: TraceTo::Hit, parameters: &changed };
            let mut hits = HitBuffer::new(self.rays.host.len(), self.description.residency, Some(&self.gpu)).unwrap();
            let mut clock = PhaseClock::new(Some(&self.gpu));
            structure.trace(job, &mut hits, &mut clock).unwrap();
            clock.finish().unwrap();
            hits.read(Some(&self.gpu)).unwrap()
        })
    }
}

fn build(
    tracer: &dyn Tracer,
    geometry: &Geometry,
    view: &Viewpoint,
    parameters: &Parameters,
    gpu: &Gpu,
) -> Box<dyn Structure> {
    let mut clock = PhaseClock::new(Some(gpu));
    let mut structure = tracer.build(geometry, view, parameters, &mut clock).unwrap();
    clock.finish().unwrap();
    assert!(!structure.grow_on_overflow().unwrap());
    structure
}

/// Proves for every tracer and every value worth sweeping of every trace parameter that the hits from a structure that was
/// built with other values are those from one of its own, bit for bit.
#[test]
fn trace_parameters_share_structures() {
    let mut compared = 0;
    for registration in TRACERS {
        let Some(subject) = Subject::new(registration) else { continue };
        for parameter in subject.description.parameters.iter().filter(|each| each.scope == ParameterScope::Trace) {
            // The ends of the sweep: what lies between them is built from the same.
            let ends = [parameter.sweep.first(), parameter.sweep.last()];
            for value in ends.into_iter().flatten().map(ToString::to_string) {
                let [shared, own] = subject.both(parameter.name, &value);
                assert!(shared == own, "{} {}={value}", subject.description.name, parameter.name);
                compared += 1;
            }
        }
    }
    assert!(compared > 20, "{compared}");
}

/// The negative control: of a build parameter the same comparison tells the two apart.
#[test]
fn build_parameters_do_not() {
    let subject = |name| Subject::new(find(name).unwrap()).unwrap();
    let [shared, own] = subject("fragment-abuffer").both("views", "frame");
    assert!(shared != own, "a structure of seven views answers as one of a single view does");
    let [shared, own] = subject("dirt").both("views", "frame");
    assert!(shared != own, "a structure of six views answers as one of a single view does");
}
