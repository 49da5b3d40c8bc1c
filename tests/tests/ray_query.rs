//! `ray-query` where the adapter has ray queries, against `bvh-gpu`'s watertight test over the same triangles.

use std::sync::Arc;

use tracebench_api::glam::Vec3;
use tracebench_api::{
    Geometry, Gpu, Hit, HitBuffer, Parameters, PhaseClock, Preset, Query, Ray, RayBuffer, Residency, Structure,
    TraceJob, TraceTo, Tracer, TracerError, Update, Viewpoint,
};
use tracebench_harness::registry::find;
use tracebench_scenes::procedural;
use tracebench_tests::{Numbers, adapter_has_ray_queries, available, gpu, ray, viewpoint};

/// A tracer with parameters.
struct Subject {
    tracer: Box<dyn Tracer>,
    parameters: Parameters,
    gpu: Arc<Gpu>,
}

fn view() -> Viewpoint {
    viewpoint(Vec3::Z, Vec3::ZERO, 0.01, 10.0, [16, 16])
}

impl Subject {
    /// Nothing where the adapter cannot run it.
    fn new(name: &str, set: &[(&str, &str)], gpu: &Arc<Gpu>) -> Option<Self> {
        let registration = find(name).unwrap();
        let description = registration.describe();
        let mut parameters = Parameters::preset(&description.parameters, Preset::Published);
        for (name, value) in set {
            parameters.set(&description.parameters, name, value).unwrap();
        }
        let tracer = available(name, registration.create(&Ok(Arc::clone(gpu))), gpu)?;
        Some(Self { tracer, parameters, gpu: Arc::clone(gpu) })
    }

    fn build(&self, geometry: &Geometry) -> Box<dyn Structure> {
        let mut clock = PhaseClock::new(Some(&self.gpu));
        let structure = self.tracer.build(geometry, &view(), &self.parameters, &mut clock).unwrap();
        clock.finish().unwrap();
        structure
    }

    fn trace(&self, structure: &dyn Structure, rays: &[Ray], query: Query) -> Vec<Hit> {
        let rays = RayBuffer::new(Arc::new(rays.to_vec()), query, Some(&self.gpu));
        let job = TraceJob { rays: &rays, trace_to: TraceTo::Hit, parameters: &self.parameters };
        let mut hits = HitBuffer::new(rays.host.len(), Residency::Device, Some(&self.gpu)).unwrap();
        hits.poison(Some(&self.gpu)).unwrap();
        let mut clock = PhaseClock::new(Some(&self.gpu));
        structure.trace(job, &mut hits, &mut clock).unwrap();
        clock.finish().unwrap();
        hits.read(Some(&self.gpu)).unwrap()
    }
}

fn room(gpu: &Gpu) -> (Geometry, Vec<Ray>) {
    let scene = procedural("room", 0.1).unwrap();
    let mut numbers = Numbers::new(71);
    let (low, high) = (Vec3::from(scene.bounds_min).as_dvec3(), Vec3::from(scene.bounds_max).as_dvec3());
    let rays = (0..4000).map(|index| {
        let from = low + (numbers.point() * 0.5 + 0.5) * (high - low);
        let ray = ray(from, numbers.direction());
        // Some begin late, some end early.
        let t_min = if index % 7 == 0 { 0.5 } else { 0.0 };
        Ray { t_min, t_max: if index % 5 == 0 { 1.0 } else { ray.t_max }, ..ray }
    });
    let rays = rays.collect();
    (Geometry::new(scene.mesh.positions, scene.mesh.triangles, Some(gpu)).unwrap(), rays)
}

/// Hits that differ by more than rounding.
fn differences(found: &[Hit], expected: &[Hit]) -> usize {
    let differ = |(a, b): &(&Hit, &Hit)| a.is_hit() != b.is_hit() || (a.t - b.t).abs() > 1e-5 * b.t + 1e-5;
    found.iter().zip(expected).filter(differ).count()
}

/// Proves that an adapter without ray queries is told by name with the feature that it lacks, and that one with them gets
/// the tracer: the two answers come from the adapter itself.
#[test]
fn availability_is_the_adapters() {
    let gpu = gpu();
    let created = find("ray-query").unwrap().create(&Ok(Arc::clone(&gpu)));
    match created {
        Ok(_) => assert!(adapter_has_ray_queries(&gpu) && gpu.has_ray_queries()),
        Err(TracerError::Unavailable(reason)) => {
            assert!(!adapter_has_ray_queries(&gpu) && !gpu.has_ray_queries());
            assert!(reason.contains(&gpu.listing.name) && reason.contains("EXPERIMENTAL_RAY_QUERY"), "{reason}");
        }
        Err(error) => panic!("{error}"),
    }
}

/// Proves by both preferences and with both rules for equal t that closest and any hits are those of `bvh-gpu`, within the
/// rays' spans, and that barycentric weights give the hit's point on the triangle that is named.
#[test]
fn hits_are_those_of_the_other_hierarchy() {
    let gpu = gpu();
    let (geometry, rays) = room(&gpu);
    let other = Subject::new("bvh-gpu", &[], &gpu).unwrap();
    let there = other.build(&geometry);
    let expected = other.trace(&*there, &rays, Query::Closest);
    assert!(expected.iter().filter(|hit| hit.is_hit()).count() > 2000);
    for set in [&[][..], &[("prefer", "fast_build")], &[("equal_t", "first_met")]] {
        let Some(subject) = Subject::new("ray-query", set, &gpu) else { return };
        let structure = subject.build(&geometry);
        let hits = subject.trace(&*structure, &rays, Query::Closest);
        assert!(differences(&hits, &expected) <= 2, "{set:?}: {}", differences(&hits, &expected));
        let mut spoilt = hits.clone();
        spoilt.iter_mut().step_by(400).for_each(|hit| hit.t += 0.01);
        assert!(differences(&spoilt, &expected) > 2);
        for (ray, hit) in rays.iter().zip(&hits).filter(|(_, hit)| hit.is_hit()) {
            let [a, b, c] = geometry.corners(hit.primitive);
            let on_triangle = a + (b - a) * hit.u + (c - a) * hit.v;
            let on_ray = Vec3::from(ray.origin) + Vec3::from(ray.direction) * hit.t;
            assert!((on_triangle - on_ray).length() < 1e-4, "{set:?} {ray:?} {hit:?}");
        }
        let any = subject.trace(&*structure, &rays, Query::Any);
        let agree = any.iter().zip(&expected).filter(|(a, b)| a.is_hit() == b.is_hit()).count();
        assert!(agree + 2 >= rays.len(), "{set:?}");
    }
}

/// Proves that validation finds every triangle of a structure, and notices one that lacks a triangle, has one moved or
/// numbers them otherwise.
#[test]
fn unsound_structures_are_noticed() {
    let gpu = gpu();
    let scene = procedural("room", 0.02).unwrap();
    let Some(subject) = Subject::new("ray-query", &[], &gpu) else { return };
    let upload = |positions: &[[f32; 3]], triangles: &[[u32; 3]]| {
        Geometry::new(positions.to_vec(), triangles.to_vec(), Some(&gpu)).unwrap()
    };
    let mesh = &scene.mesh;
    let whole = upload(&mesh.positions, &mesh.triangles);
    let structure = subject.build(&whole);
    let statistics = structure.validate(&whole).unwrap();
    let of = |name: &str| statistics.iter().find(|(known, _)| *known == name).map(|(_, value)| *value).unwrap();
    assert_eq!(of("triangles"), mesh.triangles.len() as f64);
    assert!(of("triangles_looked_for") > 0.9 * of("triangles"), "{statistics:?}");
    let mut collapsed = mesh.triangles.clone();
    collapsed[11] = [collapsed[11][0]; 3];
    let mut swapped = mesh.triangles.clone();
    swapped.swap(3, mesh.triangles.len() - 2);
    let mut moved = mesh.positions.clone();
    for vertex in mesh.triangles[7] {
        moved[vertex as usize][1] += 3.0;
    }
    for (positions, triangles) in
        [(&mesh.positions, &collapsed), (&mesh.positions, &swapped), (&moved, &mesh.triangles)]
    {
        // Built from one scene, compared with another.
        assert!(subject.build(&upload(positions, triangles)).validate(&whole).is_err());
    }
}

/// Proves that a refit is refused with the reason, that the structure answers as before, and that a rebuild over moved
/// triangles takes no more memory than is there.
#[test]
fn updates_are_rebuilds() {
    let gpu = gpu();
    let Some(subject) = Subject::new("ray-query", &[], &gpu) else { return };
    let (geometry, rays) = room(&gpu);
    let mut structure = subject.build(&geometry);
    let before = subject.trace(&*structure, &rays, Query::Closest);
    let bytes = structure.memory().structure_bytes();
    let mut clock = PhaseClock::new(Some(&gpu));
    let refitted = structure.update(Update::Refit, &geometry, &view(), &subject.parameters, &mut clock);
    assert!(matches!(&refitted, Err(TracerError::Unsupported(reason)) if reason.contains("PreferUpdate")));
    assert_eq!(subject.trace(&*structure, &rays, Query::Closest), before);
    let lower = geometry.positions.iter().map(|[x, y, z]| [*x, 0.5 * y, *z]).collect();
    let geometry = geometry.with_positions(lower, Some(&gpu)).unwrap();
    let mut clock = PhaseClock::new(Some(&gpu));
    structure.update(Update::Rebuild, &geometry, &view(), &subject.parameters, &mut clock).unwrap();
    clock.finish().unwrap();
    assert_ne!(subject.trace(&*structure, &rays, Query::Closest), before);
    assert_eq!(structure.memory().structure_bytes(), bytes);
    structure.validate(&geometry).unwrap();
}
