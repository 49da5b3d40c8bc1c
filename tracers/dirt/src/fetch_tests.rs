//! Surfaces fetched by raster against those gathered from the vertices, over hostile triangles.

use std::ops::RangeInclusive;
use std::sync::Arc;

use tracebench_api::glam::{DVec3, Vec3};
use tracebench_api::{
    Gpu, Hit, HitBuffer, PhaseClock, PhaseSample, Query, Ray, RayBuffer, Residency, Structure, Surface, SurfaceStatus,
    TraceJob, TraceTo,
};
use tracebench_kit::Built;
use tracebench_tests::{Numbers, gpu, gpu_that_binds, ray, soup};

use super::structure::DirtStructure;
use super::tests::{built, hostile, parameters, viewpoint};

/// Rays from the eye and from all over the triangles.
fn rays() -> Vec<Ray> {
    let mut numbers = Numbers::new(71);
    let eye = viewpoint().eye.as_dvec3();
    let from_eye = |numbers: &mut Numbers| ray(eye, numbers.direction());
    let from_anywhere = |numbers: &mut Numbers| ray(eye + numbers.point() * 5.0, numbers.direction());
    (0..4000).map(|index| if index % 2 == 0 { from_eye(&mut numbers) } else { from_anywhere(&mut numbers) }).collect()
}

struct Traced {
    hits: Vec<Hit>,
    surfaces: Vec<Surface>,
    phases: Vec<PhaseSample>,
    lost: u64,
}

fn traced(gpu: &Arc<Gpu>, structure: &Built<DirtStructure>, query: Query, fetch: &str) -> Traced {
    let rays = RayBuffer::new(Arc::new(rays()), query, Some(gpu));
    let room = || {
        let mut hits = HitBuffer::tracing_to(TraceTo::Surface, rays.host.len(), Residency::Device, Some(gpu)).unwrap();
        hits.poison(Some(gpu)).unwrap();
        hits
    };
    let parameters = parameters(&[("fetch", fetch)]);
    let job = TraceJob { rays: &rays, trace_to: TraceTo::Surface, parameters: &parameters };
    let mut hits = room();
    let mut clock = PhaseClock::new(Some(gpu));
    structure.trace(job, &mut hits, &mut clock).unwrap();
    let phases = clock.finish().unwrap().phases;
    let surfaces = hits.read_surfaces(Some(gpu)).unwrap();
    let mut counted = room();
    let counters = structure.trace_counted(job, &mut counted).unwrap();
    assert_eq!(counted.read_surfaces(Some(gpu)).unwrap(), surfaces);
    let lost = counters.iter().find(|counter| counter.name == "fetches_lost").unwrap().total;
    Traced { hits: hits.read(Some(gpu)).unwrap(), surfaces, phases, lost }
}

fn has(surface: &Surface, status: SurfaceStatus) -> bool {
    surface.status == status as u32
}

/// Whether a hit lies well within a view, by f64: between near and far, and on a pixel beyond rounding.
fn well_within_a_view(structure: &Built<DirtStructure>, ray: &Ray, hit: &Hit) -> bool {
    let point = Vec3::from(ray.origin).as_dvec3() + Vec3::from(ray.direction).as_dvec3() * f64::from(hit.t);
    structure.layout.views.iter().any(|view| {
        view.project(point).is_some_and(|at| {
            let within = |at: f64, size: u32| (1e-3..f64::from(size) - 1e-3).contains(&at);
            within(at.x, view.size[0])
                && within(at.y, view.size[1])
                && (view.near * (1.0 + 1e-4)..view.far * (1.0 - 1e-4)).contains(&at.depth)
        })
    })
}

/// Settings, and how many hits may be lost that a view has.
type Expected<'a> = (&'a [(&'a str, &'a str)], RangeInclusive<usize>);

/// What the raster fetches is what a gather gives, bit for bit, for coverages, tile sizes, views and queries. With
/// conservative coverage it loses no hit that a view has (none has what lies before near, on triangles that reach beyond).
/// With standard coverage of pixels as of tiles it loses next to none: triangles that cover no pixel's centre are in no list.
/// With standard coverage of tiles it loses many, whose pixels' centres their triangles do not cover. All lost are counted.
fn fetched_is_gathered(cases: &[Expected<'_>]) {
    let gpu = gpu();
    let geometry = soup(&hostile(), Some(&gpu));
    let rays = rays();
    for (settings, lost_of_views) in cases {
        let structure = built(&gpu, &geometry, settings);
        for query in [Query::Closest, Query::Any] {
            let (fetched, gathered) =
                (traced(&gpu, &structure, query, "raster"), traced(&gpu, &structure, query, "gather"));
            assert_eq!(fetched.hits, gathered.hits, "{settings:?} {query:?}");
            let found = fetched.hits.iter().filter(|hit| hit.is_hit()).count() as u64;
            let lost = fetched.surfaces.iter().filter(|each| has(each, SurfaceStatus::Lost)).count() as u64;
            assert_eq!((fetched.lost, gathered.lost), (lost, 0), "{settings:?} {query:?}");
            assert!(found > 100 && lost < found / 2, "{settings:?} {query:?}: {lost} of {found}");
            let all = fetched.surfaces.iter().zip(&fetched.hits).zip(&rays);
            let unseen = all.filter(|((surface, hit), ray)| {
                has(surface, SurfaceStatus::Lost) && well_within_a_view(&structure, ray, hit)
            });
            let unseen = unseen.count();
            assert!(lost_of_views.contains(&unseen), "{settings:?} {query:?}: {unseen} of {found}");
            for (index, (fetched, gathered)) in fetched.surfaces.iter().zip(&gathered.surfaces).enumerate() {
                let same = bytemuck::bytes_of(fetched) == bytemuck::bytes_of(gathered);
                assert!(
                    same || has(fetched, SurfaceStatus::Lost),
                    "{settings:?} {query:?}, ray {index}: {fetched:?} {gathered:?}"
                );
            }
        }
    }
}

#[test]
fn what_is_fetched_is_what_is_gathered() {
    fetched_is_gathered(&[(&[], 0..=0), (&[("centre", "eye"), ("buckets", "3")], 0..=0)]);
}

#[test]
#[ignore = "wider set: other sizes of tiles, a dozen seconds"]
fn what_is_fetched_is_what_is_gathered_by_other_tiles() {
    fetched_is_gathered(&[(&[("tile_size", "1")], 0..=0), (&[("tile_size", "8")], 0..=0)]);
}

#[test]
fn what_is_fetched_is_what_is_gathered_by_other_coverage_and_views() {
    fetched_is_gathered(&[
        (&[("views", "frame")], 0..=0),
        (&[("coverage", "standard"), ("tile_size", "1")], 0..=8),
        (&[("coverage", "standard"), ("tile_size", "1"), ("views", "frame")], 0..=0),
        (&[("coverage", "standard"), ("tile_size", "2")], 50..=1999),
    ]);
}

/// The phases are the paper's passes.
#[test]
fn phases_are_named() {
    let gpu = gpu();
    let structure = built(&gpu, &soup(&hostile(), Some(&gpu)), &[]);
    let names = |fetch: &str| -> Vec<String> {
        traced(&gpu, &structure, Query::Closest, fetch).phases.into_iter().map(|phase| phase.name).collect()
    };
    assert_eq!(names("raster"), ["trace", "final storage", "mask", "fetch"]);
    assert_eq!(names("gather"), ["trace", "gather"]);
}

/// Used bytes of a trace are those of the paper's Table 3 with a ray a pixel: 4 for a head and 32 for a node, 32 for one of the
/// three points of the shading buffer, 2 for the mask.
#[test]
fn memory_of_a_trace_is_that_of_table_3() {
    let gpu = gpu();
    let structure = built(&gpu, &soup(&hostile(), Some(&gpu)), &[]);
    let edge = viewpoint().face;
    let pixels = u64::from(edge * edge);
    let rays = vec![ray(DVec3::ZERO, DVec3::X); pixels as usize];
    let rays = RayBuffer::new(Arc::new(rays), Query::Closest, Some(&gpu));
    let parameters = parameters(&[]);
    let job = TraceJob { rays: &rays, trace_to: TraceTo::Surface, parameters: &parameters };
    let mut parts = structure.trace_memory(job).unwrap();
    parts.extend(HitBuffer::memory(TraceTo::Surface, rays.host.len()));
    let used = |name: &str| {
        let of_name: Vec<u64> = parts.iter().filter(|part| part.name == name).map(|part| part.used_bytes).collect();
        assert_eq!(of_name.len(), 1, "{name}: {parts:?}");
        of_name[0]
    };
    assert_eq!(used("hit buffer: heads") + used("hit buffer: nodes"), (4 + 32) * pixels);
    assert_eq!(used("shading buffer"), 32 * pixels);
    assert_eq!(used("mask texture"), 2 * pixels);
}

/// Heads that one binding does not hold are refused with what to turn down, and the same rays are then answered without
/// surfaces, and with surfaces by a gather.
#[test]
fn heads_too_large_are_refused() {
    let view = viewpoint();
    let small = gpu_that_binds(u64::from(view.face * view.face) * 4 - 4);
    let geometry = soup(&hostile()[..3], Some(&small));
    let structure = built(&small, &geometry, &[("tile_size", "8"), ("buckets", "1")]);
    let some = rays()[..100].to_vec();
    let rays = RayBuffer::new(Arc::new(some), Query::Closest, Some(&small));
    let mut hits = HitBuffer::tracing_to(TraceTo::Surface, rays.host.len(), Residency::Device, Some(&small)).unwrap();
    let mut trace = |settings: &[(&str, &str)], trace_to| {
        let mut clock = PhaseClock::new(Some(&small));
        let parameters = parameters(settings);
        let job = TraceJob { rays: &rays, trace_to, parameters: &parameters };
        structure.trace(job, &mut hits, &mut clock).and_then(|()| clock.finish())
    };
    let message = trace(&[], TraceTo::Surface).err().map(|error| error.to_string()).unwrap_or_default();
    assert!(message.contains("hit buffer: heads") && message.contains("--face-size"), "{message}");
    trace(&[], TraceTo::Hit).unwrap();
    trace(&[("fetch", "gather")], TraceTo::Surface).unwrap();
}
