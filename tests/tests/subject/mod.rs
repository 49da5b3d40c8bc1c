//! A tracer of the registry with parameters, and what tests of hierarchies build and ask.

use std::sync::Arc;

use tracebench_api::glam::Vec3;
use tracebench_api::{
    Counter, Geometry, Gpu, Hit, HitBuffer, Parameters, PhaseClock, Preset, Query, Ray, RayBuffer, Residency,
    Structure, TraceJob, TraceTo, Tracer, TracerError, Viewpoint,
};
use tracebench_harness::registry::find;
use tracebench_scenes::procedural;
use tracebench_tests::{Numbers, ray, viewpoint};

/// A tracer with parameters.
pub struct Subject {
    pub tracer: Box<dyn Tracer>,
    pub parameters: Parameters,
    pub residency: Residency,
    pub gpu: Arc<Gpu>,
}

/// A viewpoint, which hierarchies do not depend on.
pub fn view() -> Viewpoint {
    viewpoint(Vec3::Z, Vec3::ZERO, 0.01, 10.0, [16, 16])
}

impl Subject {
    pub fn new(name: &str, set: &[(&str, &str)], gpu: &Arc<Gpu>) -> Self {
        let registration = find(name).unwrap();
        let description = registration.describe();
        let mut parameters = Parameters::preset(&description.parameters, Preset::Published);
        for (name, value) in set {
            parameters.set(&description.parameters, name, value).unwrap();
        }
        let tracer = registration.create(&Ok(Arc::clone(gpu))).unwrap();
        Self { tracer, parameters, residency: description.residency, gpu: Arc::clone(gpu) }
    }

    pub fn try_build(&self, geometry: &Geometry) -> Result<Box<dyn Structure>, TracerError> {
        let mut clock = PhaseClock::new(Some(&self.gpu));
        let structure = self.tracer.build(geometry, &view(), &self.parameters, &mut clock)?;
        clock.finish().map(|_| structure)
    }

    /// Hits and counters, by variants that must agree.
    pub fn answer(&self, structure: &dyn Structure, rays: &[Ray], query: Query) -> (Vec<Hit>, Vec<Counter>) {
        let rays = RayBuffer::new(Arc::new(rays.to_vec()), query, Some(&self.gpu));
        let job = TraceJob { rays: &rays, trace_to: TraceTo::Hit, parameters: &self.parameters };
        let mut hits = HitBuffer::new(rays.host.len(), self.residency, Some(&self.gpu)).unwrap();
        let mut clock = PhaseClock::new(Some(&self.gpu));
        structure.trace(job, &mut hits, &mut clock).unwrap();
        clock.finish().unwrap();
        let timed = hits.read(Some(&self.gpu)).unwrap();
        let counters = structure.trace_counted(job, &mut hits).unwrap();
        assert_eq!(timed, hits.read(Some(&self.gpu)).unwrap());
        (timed, counters)
    }
}

/// A room of some 15,000 triangles, with rays from all over it.
pub fn room(gpu: &Gpu) -> (Geometry, Vec<Ray>) {
    let scene = procedural("room", 0.1).unwrap();
    let mut numbers = Numbers::new(61);
    let (low, high) = (Vec3::from(scene.bounds_min).as_dvec3(), Vec3::from(scene.bounds_max).as_dvec3());
    let rays = (0..4000).map(|_| {
        let from = low + (numbers.point() * 0.5 + 0.5) * (high - low);
        ray(from, numbers.direction())
    });
    let rays = rays.collect();
    (Geometry::new(scene.mesh.positions, scene.mesh.triangles, Some(gpu)).unwrap(), rays)
}

/// A counter's sum over all rays.
pub fn total(counters: &[Counter], name: &str) -> f64 {
    counters.iter().find(|counter| counter.name == name).map(|counter| counter.total as f64).unwrap()
}
