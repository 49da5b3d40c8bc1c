//! Surfaces that DIRT fetches by raster against those that it gathers, over scenes of the catalogue.

use std::sync::Arc;

use tracebench_api::glam::Vec3;
use tracebench_api::{
    Geometry, HitBuffer, Parameters, PhaseClock, Preset, Query, Ray, RayBuffer, Residency, Surface, SurfaceStatus,
    TraceJob, TraceTo,
};
use tracebench_harness::registry::find;
use tracebench_scenes::procedural;
use tracebench_tests::{Numbers, gpu, ray, viewpoint};

/// Proves for scenes of the catalogue, closest and any hit and both coverages: what the raster fetches is what a gather
/// gives, bit for bit, and conservative coverage loses no more than what stands before near planes or beside borders.
#[test]
fn fetches_equal_gathers_over_the_catalogue() {
    let gpu = gpu();
    let registration = find("dirt").unwrap();
    let described = registration.describe().parameters;
    let tracer = registration.create(&Ok(Arc::clone(&gpu))).unwrap();
    for (name, scale) in [("room", 0.05), ("hangar", 0.02), ("foliage", 0.02)] {
        let scene = procedural(name, scale).unwrap();
        let camera = &scene.cameras[0];
        let (eye, target) = (Vec3::from(camera.eye), Vec3::from(camera.target));
        let mesh = scene.mesh;
        let geometry =
            Geometry::with_materials(mesh.positions, mesh.triangles, mesh.triangle_materials, Some(&gpu)).unwrap();
        let diagonal = geometry.diagonal() as f32;
        let view = viewpoint(eye, target, 1e-3 * diagonal, 2.0 * diagonal, [64, 64]);
        let mut numbers = Numbers::new(91);
        let rays: Vec<Ray> = (0..3000)
            .map(|index| {
                let from = eye.as_dvec3() + numbers.point() * f64::from(index % 2) * 0.05 * f64::from(diagonal);
                ray(from, numbers.direction())
            })
            .collect();
        for coverage in ["conservative", "standard"] {
            let mut parameters = Parameters::preset(&described, Preset::Published);
            parameters.set(&described, "coverage", coverage).unwrap();
            let mut clock = PhaseClock::new(Some(&gpu));
            let structure = tracer.build(&geometry, &view, &parameters, &mut clock).unwrap();
            clock.finish().unwrap();
            for query in [Query::Closest, Query::Any] {
                let rays = RayBuffer::new(Arc::new(rays.clone()), query, Some(&gpu));
                let mut surfaces = |fetch: &str| -> Vec<Surface> {
                    parameters.set(&described, "fetch", fetch).unwrap();
                    let count = rays.host.len();
                    let mut hits =
                        HitBuffer::tracing_to(TraceTo::Surface, count, Residency::Device, Some(&gpu)).unwrap();
                    hits.poison(Some(&gpu)).unwrap();
                    let mut clock = PhaseClock::new(Some(&gpu));
                    let job = TraceJob { rays: &rays, trace_to: TraceTo::Surface, parameters: &parameters };
                    structure.trace(job, &mut hits, &mut clock).unwrap();
                    clock.finish().unwrap();
                    hits.read_surfaces(Some(&gpu)).unwrap()
                };
                let (fetched, gathered) = (surfaces("raster"), surfaces("gather"));
                let lost = |surface: &Surface| surface.status == SurfaceStatus::Lost as u32;
                let differ = |(fetched, gathered): &(&Surface, &Surface)| {
                    !lost(fetched) && bytemuck::bytes_of(*fetched) != bytemuck::bytes_of(*gathered)
                };
                let context = format!("{name}, {coverage}, {query:?}");
                assert_eq!(fetched.iter().zip(&gathered).find(differ), None, "{context}");
                let found = gathered.iter().filter(|each| each.status == SurfaceStatus::Written as u32).count();
                let lost = fetched.iter().filter(|each| lost(each)).count();
                assert!(found > 500 && !gathered.iter().any(|each| each.status == SurfaceStatus::Lost as u32));
                match coverage {
                    "conservative" => assert!(lost * 1000 <= found, "{context}: {lost} of {found} lost"),
                    _ => assert!(lost > 0 && lost < found / 2, "{context}: {lost} of {found} lost"),
                }
            }
        }
    }
}
