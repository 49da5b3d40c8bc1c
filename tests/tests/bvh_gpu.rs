//! `bvh-gpu` by both kinds of node against `bvh-cpu`, which traverses the same hierarchy, and where it reaches limits.

use crate::subject;

use std::sync::Arc;

use tracebench_api::glam::{DVec3, Vec3};
use tracebench_api::{
    AdapterChoice, Geometry, Gpu, Hit, HitBuffer, PhaseClock, Query, Ray, RayBuffer, Residency, Structure, Timing,
    TraceJob, TraceTo, TracerError, Update,
};
use tracebench_scenes::procedural;
use tracebench_tests::{Numbers, gpu, ray, rectangle, soup};

use subject::{Subject, room, total, view};

/// Hits that differ in more than rounding and the choice between triangles that meet at an edge.
fn differences(found: &[Hit], expected: &[Hit]) -> usize {
    let differ = |(a, b): &(&Hit, &Hit)| a.is_hit() != b.is_hit() || (a.t - b.t).abs() > 1e-5 * b.t + 1e-5;
    found.iter().zip(expected).filter(differ).count()
}

/// Proves that the device visits no more than 1.1 times the nodes that obvhs's own traversal of the same CWBVH visits, and
/// tests no more than 1.1 times the triangles, for every build; that it gives the same answers; and that the launch changes
/// no bit of them.
#[test]
fn the_same_tree_takes_the_same_work() {
    let gpu = gpu();
    let (geometry, rays) = room(&gpu);
    for build in ["fastest", "fast", "medium", "slow"] {
        let on_host = Subject::new("bvh-cpu", &[("build", build)], &gpu);
        let on_device = Subject::new("bvh-gpu", &[("build", build)], &gpu);
        let expected = on_host.try_build(&geometry).unwrap();
        let structure = on_device.try_build(&geometry).unwrap();
        structure.validate(&geometry).unwrap();
        for query in [Query::Closest, Query::Any] {
            let (expected_hits, expected_work) = on_host.answer(&*expected, &rays, query);
            let (hits, work) = on_device.answer(&*structure, &rays, query);
            if query == Query::Closest {
                assert!(differences(&hits, &expected_hits) <= 2, "{build}");
            }
            for name in ["nodes_visited", "triangle_tests"] {
                let ratio = total(&work, name) / total(&expected_work, name);
                assert!((0.9..1.1).contains(&ratio), "{build} {query:?} {name}: {ratio}");
            }
            for lanes in ["1", "3", "256"] {
                let other = Subject::new("bvh-gpu", &[("build", build), ("rays_per_lane", lanes)], &gpu);
                assert_eq!(other.answer(&*structure, &rays, query).0, hits, "{build} {query:?} {lanes}");
            }
        }
    }
}

/// Proves that binary nodes give the hits of compressed ones, bit for bit, by every build.
#[test]
fn both_nodes_give_the_same_hits() {
    let gpu = gpu();
    let (geometry, rays) = room(&gpu);
    let wide = Subject::new("bvh-gpu", &[], &gpu);
    let expected = wide.answer(&*wide.try_build(&geometry).unwrap(), &rays, Query::Closest).0;
    for build in ["fastest", "very_fast", "fast", "medium", "slow", "very_slow"] {
        let binary = Subject::new("bvh-gpu", &[("node", "bvh2"), ("build", build)], &gpu);
        let structure = binary.try_build(&geometry).unwrap();
        structure.validate(&geometry).unwrap();
        let hits = binary.answer(&*structure, &rays, Query::Closest).0;
        assert_eq!(hits, expected, "{build}");
        let any = binary.answer(&*structure, &rays, Query::Any).0;
        assert!(any.iter().zip(&hits).all(|(any, closest)| any.is_hit() == closest.is_hit()), "{build}");
    }
}

/// Proves that refits, from the one that reads the hierarchy back to later ones, give the hits of a fresh build by both
/// nodes, with and without splits, that the ledger tells the copy that they keep, and that a rebuild drops it.
#[test]
fn refits_follow_by_both_nodes() {
    let gpu = gpu();
    let [start, later] = [0.0, 0.9].map(|time_s| {
        let mut scene = procedural("cloth", 0.05).unwrap();
        scene.set_time(time_s).unwrap();
        scene
    });
    let rays = room(&gpu).1;
    for node in ["cwbvh", "bvh2"] {
        for build in ["medium", "slow"] {
            let subject = Subject::new("bvh-gpu", &[("node", node), ("build", build)], &gpu);
            let mesh = start.mesh.clone();
            let mut geometry = Geometry::new(mesh.positions, mesh.triangles, Some(&gpu)).unwrap();
            let mut structure = subject.try_build(&geometry).unwrap();
            let before = subject.answer(&*structure, &rays, Query::Closest).0;
            let bytes = structure.memory().structure_bytes();
            let mut refit = |structure: &mut dyn Structure, positions: &[[f32; 3]], update: Update| {
                geometry = geometry.clone().with_positions(positions.to_vec(), Some(&gpu)).unwrap();
                let mut clock = PhaseClock::new(Some(&gpu));
                structure.update(update, &geometry, &view(), &subject.parameters, &mut clock).unwrap();
                clock.finish().unwrap();
                structure.validate(&geometry).unwrap();
                subject.answer(structure, &rays, Query::Closest).0
            };
            let moved = refit(&mut *structure, &later.mesh.positions, Update::Refit);
            assert_ne!(moved, before);
            assert!(structure.memory().structure_bytes() > bytes);
            assert_eq!(refit(&mut *structure, &start.mesh.positions, Update::Refit), before, "{node} {build}");
            assert_eq!(refit(&mut *structure, &later.mesh.positions, Update::Refit), moved, "{node} {build}");
            assert_eq!(refit(&mut *structure, &later.mesh.positions, Update::Rebuild), moved, "{node} {build}");
            assert!(structure.memory().structure.iter().all(|entry| !entry.name.contains("copy")));
        }
    }
}

/// Proves that hierarchies too deep for the private stack, which thousands of equal triangles give, are searched with
/// stacks in device memory: what lies among and behind the equal triangles is found.
#[test]
fn deep_hierarchies_are_searched() {
    let gpu = gpu();
    let plate = rectangle([-1.0, -1.0, 0.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0])[0];
    let mut triangles = vec![plate; 6000];
    triangles.extend(rectangle([-3.0, -3.0, -1.0], [6.0, 0.0, 0.0], [0.0, 6.0, 0.0]));
    let geometry = soup(&triangles, Some(&gpu));
    let mut numbers = Numbers::new(62);
    let rays: Vec<Ray> = (0..2500).map(|_| ray(numbers.point() * 2.9 + DVec3::Z * 5.0, DVec3::NEG_Z)).collect();
    for (node, private) in [("cwbvh", tracebench_bvh::WIDE_STACK), ("bvh2", tracebench_bvh::BINARY_STACK)] {
        let subject = Subject::new("bvh-gpu", &[("node", node), ("build", "fastest")], &gpu);
        let structure = subject.try_build(&geometry).unwrap();
        let statistics = structure.validate(&geometry).unwrap();
        let depth = statistics.iter().find(|(name, _)| *name == "depth").map(|(_, depth)| *depth).unwrap();
        let stacks = structure.memory().structure.iter().any(|entry| entry.name == "traversal stacks");
        assert_eq!(stacks, depth > private as f64, "{node}: {depth} levels");
        assert!(stacks, "{node}: {depth} levels");
        for query in [Query::Closest, Query::Any] {
            for (ray, hit) in rays.iter().zip(subject.answer(&*structure, &rays, query).0) {
                let [x, y, z] = ray.origin;
                let on_plate = x.abs() < 0.999 && y < x - 1e-3 && y > -0.999;
                let off_plate = x.abs() > 1.001 || y > x + 1e-3 || y < -1.001;
                assert!(hit.is_hit(), "{node} {ray:?}");
                if on_plate && query == Query::Closest {
                    assert!((hit.t - z).abs() < 1e-5 && hit.primitive == 0, "{node} {ray:?} {hit:?}");
                } else if off_plate {
                    assert!((hit.t - z - 1.0).abs() < 1e-5, "{node} {ray:?} {hit:?}");
                }
            }
        }
    }
}

/// Proves that hierarchies of a part of a texture's row, of whole rows and of some more are there as they were built, in
/// new textures, in larger ones and, after growing, in others.
#[test]
fn rows_hold_every_count() {
    let gpu = gpu();
    let mut numbers = Numbers::new(63);
    let mut near = || (numbers.point() * 0.1).as_vec3();
    let triangles: Vec<_> = (0..2049)
        .map(|index| {
            let corner = Vec3::new(index as f32, (index % 7) as f32, 0.0);
            [corner + near(), corner + near() + Vec3::X, corner + near() + Vec3::Y].map(|corner| corner.to_array())
        })
        .collect();
    for node in ["cwbvh", "bvh2"] {
        let subject = Subject::new("bvh-gpu", &[("node", node), ("memory_access", "texture")], &gpu);
        let mut structure = subject.try_build(&soup(&triangles[..700], Some(&gpu))).unwrap();
        // Three quads a triangle: 2048 of them fill three rows.
        for count in [1, 2, 682, 683, 2047, 2048, 2049, 3] {
            let geometry = soup(&triangles[..count], Some(&gpu));
            let fresh = subject.try_build(&geometry).unwrap();
            let mut clock = PhaseClock::new(Some(&gpu));
            structure.update(Update::Rebuild, &geometry, &view(), &subject.parameters, &mut clock).unwrap();
            clock.finish().unwrap();
            let through = |[corner, ..]: &[[f32; 3]; 3]| {
                ray(Vec3::from(*corner).as_dvec3() + DVec3::new(0.3, 0.3, 5.0), DVec3::NEG_Z)
            };
            let rays: Vec<Ray> = triangles[..count].iter().map(through).collect();
            let hits = subject.answer(&*fresh, &rays, Query::Closest).0;
            assert!(hits.iter().zip(0..).all(|(hit, index)| hit.primitive == index), "{node} {count}");
            assert_eq!(subject.answer(&*structure, &rays, Query::Closest).0, hits, "{node} {count}");
            assert_eq!(fresh.validate(&geometry).unwrap(), structure.validate(&geometry).unwrap(), "{node} {count}");
        }
    }
}

/// Proves that what the device cannot hold in a texture, or bind as a buffer, is an error that names the part, its bytes and what to
/// turn down.
#[test]
fn too_large_is_said() {
    let mut small = Gpu::open(&AdapterChoice::default()).unwrap();
    // A row.
    let row = 1 << tracebench_kit::ROW_BITS;
    (small.limits.max_texture_dimension_2d, small.limits.max_storage_buffer_binding_size) = (1, row);
    let small = Arc::new(small);
    let (geometry, _) = room(&small);
    for (node, name, memory_access) in [
        ("cwbvh", "CWBVH nodes", "texture"),
        ("bvh2", "BVH2 nodes", "texture"),
        ("cwbvh", "CWBVH nodes", "buffer"),
        ("bvh2", "BVH2 nodes", "buffer"),
    ] {
        let subject = Subject::new("bvh-gpu", &[("node", node), ("memory_access", memory_access)], &small);
        let Err(error) = subject.try_build(&geometry) else { panic!("{node} was built") };
        let TracerError::TooLarge { name: part, bytes, limit, hint } = &error else { panic!("{error}") };
        assert!(part == name && *bytes > row && *limit == row && hint.contains("triangle"), "{error}");
    }
}

/// Proves that the device's clock covers a compute pass after render passes, which a software driver may stamp late: the
/// samples are believed, and more than half of the wait lies between their stamps.
#[test]
fn timestamps_after_rasterizing_cover_the_trace() {
    let gpu = gpu();
    let (geometry, rays) = room(&gpu);
    let subject = Subject::new("bvh-gpu", &[], &gpu);
    let structure = subject.try_build(&geometry).unwrap();
    // Enough work to stand out of what a submission costs.
    let rays: Vec<Ray> = rays.iter().cycle().take(rays.len() * 16).copied().collect();
    let rays = RayBuffer::new(Arc::new(rays), Query::Closest, Some(&gpu));
    let job = TraceJob { rays: &rays, trace_to: TraceTo::Hit, parameters: &subject.parameters };
    let mut hits = HitBuffer::new(rays.host.len(), Residency::Device, Some(&gpu)).unwrap();
    let timings: Vec<_> = (0..5)
        .map(|_| {
            Subject::new("screen-dda", &[], &gpu).try_build(&geometry).unwrap();
            let mut clock = PhaseClock::new(Some(&gpu));
            structure.trace(job, &mut hits, &mut clock).unwrap();
            clock.finish().unwrap()
        })
        .collect();
    assert!(Timing::plausible(&timings), "{timings:?}");
    if gpu.listing.timestamps {
        let covers_half = |timing: &Timing| timing.total_ms * 2.0 >= timing.submit_to_done_ms.unwrap();
        assert!(timings.iter().any(covers_half), "{timings:?}");
    }
}
