//! How rays are answered, in minimal cases and by their work.

use std::sync::Arc;

use tracebench_api::glam::{DVec3, Vec3};
use tracebench_api::{Hit, HitBuffer, Query, Ray, RayBuffer, Residency, Status, Structure, TraceJob, TraceTo};
use tracebench_tests::{Numbers, gpu, ray, soup};

use super::structure::FragmentAbuffer;
use super::tests::{SKIPS, STORAGES, answer, built, built_by, parameters, rectangle, viewpoint};

/// Each kind of skipping saves what it says and nothing else: bounds and buckets lists, lists fragments; all of them leave the
/// pixels looked at, and the hits.
#[test]
fn each_skip_saves_what_it_says() {
    let gpu = gpu();
    let eye = viewpoint().eye.as_dvec3();
    // A dozen walls from 2 to 4.2 away; rays before, between and behind them, along them and at a slant.
    let wall = |depth: f64| rectangle(eye + DVec3::new(-3.0, -3.0, -depth), DVec3::X * 6.0, DVec3::Y * 6.0);
    let walls: Vec<[[f32; 3]; 3]> = (0..12).flat_map(|index| wall(2.0 + 0.2 * f64::from(index))).collect();
    let geometry = soup(&walls, Some(&gpu));
    let slanted = |depth: f64| {
        let from = move |height: i32| eye + DVec3::new(-1.0, 0.05 * f64::from(height), -depth);
        (-8..8).flat_map(move |height| [0.0, 0.2, -0.2].map(|slant| ray(from(height), DVec3::new(1.0, 0.0, slant))))
    };
    let rays: Vec<Ray> = [1.0, 2.5, 3.1, 3.7, 6.0].into_iter().flat_map(slanted).collect();
    let tracer = FragmentAbuffer::new(Arc::clone(&gpu)).unwrap();
    for storage in STORAGES {
        let shape = [("storage", storage), ("views", "frame"), ("binary_search_above", "1000")];
        let structure = built_by(&tracer, &gpu, &geometry, &shape);
        // Pixels and lists visited, fragments tested, hits.
        let counted = |switches: [&str; 3]| {
            let settings = [&shape[..], &SKIPS.into_iter().zip(switches).collect::<Vec<_>>()].concat();
            let rays = RayBuffer::new(Arc::new(rays.clone()), Query::Closest, Some(&gpu));
            let mut hits = HitBuffer::tracing_to(TraceTo::Hit, rays.host.len(), Residency::Device, Some(&gpu)).unwrap();
            hits.poison(Some(&gpu)).unwrap();
            let job = TraceJob { rays: &rays, trace_to: TraceTo::Hit, parameters: &parameters(&settings) };
            let counters = structure.trace_counted(job, &mut hits).unwrap();
            let of = |name: &str| counters.iter().find(|counter| counter.name == name).unwrap().total;
            (["pixels_visited", "lists_visited", "fragments_tested"].map(of), hits.read(Some(&gpu)).unwrap())
        };
        let ([pixels, lists, fragments], hits) = counted(["off", "off", "off"]);
        assert!(fragments > 1000 && hits.iter().any(Hit::is_hit), "{storage}: {fragments}");
        let is_bucketed = ["llb", "dllb"].contains(&storage);
        for (switches, saves_lists, saves_fragments) in [
            (["on", "off", "off"], is_bucketed || storage == "dll", true),
            (["off", "on", "off"], is_bucketed, is_bucketed),
            (["off", "off", "on"], false, true),
        ] {
            let ([same, fewer_lists, fewer_fragments], found) = counted(switches);
            let context = format!("{storage} {switches:?}: {fewer_lists} of {lists}, {fewer_fragments} of {fragments}");
            assert!(same == pixels && found == hits, "{context}");
            assert_eq!((fewer_lists < lists, fewer_fragments < fragments), (saves_lists, saves_fragments), "{context}");
            assert!(saves_lists || fewer_lists == lists, "{context}");
        }
    }
}

/// Rays whose lanes have more to do than a driver lets loops run are answered all the same, as with a ray a lane, counted or not.
/// Hundreds of fragments a pixel are tested in each of dozens of pixels: ten such rays a lane are more than Mesa's 65,535 rounds.
#[test]
fn rays_of_lanes_that_are_cut_off_are_answered() {
    let gpu = gpu();
    let eye = viewpoint().eye.as_dvec3();
    let wall = |depth: f64| rectangle(eye + DVec3::new(-9.0, -9.0, -depth), DVec3::X * 18.0, DVec3::Y * 18.0);
    let walls: Vec<[[f32; 3]; 3]> = (0..300).flat_map(|index| wall(2.0 + 0.01 * f64::from(index))).collect();
    let geometry = soup(&walls, Some(&gpu));
    let mut numbers = Numbers::new(12);
    let along = |index: usize| {
        let origin = eye + DVec3::new(-2.0, 0.3 * numbers.signed(), -3.005);
        ray(origin, DVec3::new(1.0, 0.0, if index.is_multiple_of(8) { 0.004 * numbers.signed() } else { 0.0 }))
    };
    let rays: Vec<Ray> = (0..640).map(along).collect();
    let shape = [("storage", "ll"), ("views", "frame")];
    let structure = built(&gpu, &geometry, &shape);
    let of = |rays_per_lane| {
        let settings = [&shape[..], &[("rays_per_lane", rays_per_lane)]].concat();
        answer(&gpu, &structure, &rays, &settings, TraceTo::Surface)
    };
    let one = of("1");
    let count = |is: fn(&Hit) -> bool| one.0.iter().filter(|hit| is(hit)).count();
    assert!(count(Hit::is_hit) > 20 && count(|hit| !hit.is_hit()) > 500);
    assert_eq!(count(|hit| hit.status == Status::StepCap as u32), 0);
    assert!(of("10") == one && of("256") == one);
}

/// Minimal case: walls square to the rays' view, one behind the other. Rays from the eye hit the first, rays from behind the last
/// one that they meet, whatever the list's direction; t is exact where the wall is square to the view; surfaces are the wall's.
#[test]
fn rays_find_the_wall_that_they_meet_first() {
    let gpu = gpu();
    let eye = viewpoint().eye.as_dvec3();
    let wall = |depth: f64| rectangle(eye + DVec3::new(-3.0, -3.0, -depth), DVec3::X * 6.0, DVec3::Y * 6.0);
    let walls: Vec<[[f32; 3]; 3]> = [2.0, 3.0, 3.5, 5.0].into_iter().flat_map(wall).collect();
    let geometry = soup(&walls, Some(&gpu));
    // Onto pixels' centres of the camera's view, from before, between and behind.
    let starts = [(0.5, 2.0), (2.5, 3.0), (3.2, 3.5), (4.0, 5.0)];
    let back = [(6.0, 5.0), (4.0, 3.5), (3.2, 3.0), (2.5, 2.0)];
    for storage in STORAGES {
        for march in ["steps", "pixels", "hi-z"] {
            let settings = [("storage", storage), ("march", march), ("start_bias", "0")];
            let structure = built(&gpu, &geometry, &settings);
            let mut rays = Vec::new();
            let mut expected = Vec::new();
            for (from, to) in starts.into_iter().chain(back) {
                let direction = DVec3::new(0.03, 0.05, -(to - from) / f64::abs(to - from));
                let origin = eye + DVec3::new(0.1, -0.05, -from);
                rays.push(ray(origin, direction));
                expected.push(f64::abs(to - from) * direction.length());
            }
            let (hits, surfaces) = answer(&gpu, &structure, &rays, &settings, TraceTo::Surface);
            for ((hit, surface), expected) in hits.iter().zip(&surfaces).zip(&expected) {
                let context = format!("{storage} {march}: {hit:?} {expected}");
                assert!(hit.is_hit() && (f64::from(hit.t) - expected).abs() < 1e-4 * expected, "{context}");
                assert!((Vec3::from(surface.normal).z.abs() - 1.0).abs() < 1e-6, "{context}");
            }
        }
    }
}

/// Minimal case: thickness. A ray that passes a surface between two fragments, as it runs against its slope, gets through at
/// thickness 0 and is stopped by some thickness; with much of it rays that pass behind a plate in the distance are stopped, too.
#[test]
fn thickness_closes_gaps_and_invents_hits() {
    let gpu = gpu();
    let eye = viewpoint().eye.as_dvec3();
    let plate = rectangle(eye + DVec3::new(-2.0, -1.0, -2.0), DVec3::X * 4.0, DVec3::new(0.0, 1.6, -2.0));
    let geometry = soup(&plate, Some(&gpu));
    let settings = |thickness| [("march", "pixels"), ("views", "frame"), ("thickness", thickness)];
    let structure = built(&gpu, &geometry, &settings("0"));
    let mut numbers = Numbers::new(8);
    let through: Vec<Ray> = (0..400)
        .map(|_| {
            let target = eye + DVec3::new(numbers.signed(), 0.3 * numbers.signed(), -2.9);
            ray(target + DVec3::new(0.4 * numbers.signed(), 1.0, -0.4), DVec3::new(0.0, -1.0, 0.4))
        })
        .collect();
    let behind: Vec<Ray> =
        (0..400).map(|_| ray(eye + DVec3::new(-1.5, 0.3 * numbers.signed(), -4.2), DVec3::X)).collect();
    let share = |rays: &[Ray], thickness| {
        let (hits, _) = answer(&gpu, &structure, rays, &settings(thickness), TraceTo::Hit);
        hits.iter().filter(|hit| hit.is_hit()).count() as f64 / rays.len() as f64
    };
    let shares = ["0", "0.01", "0.05", "1"].map(|thickness| share(&through, thickness));
    assert!(shares[0] < 0.9 && shares.is_sorted() && shares[3] > 0.98, "{shares:?}");
    let invented = ["0", "0.01", "1"].map(|thickness| share(&behind, thickness));
    assert!(invented[0] == 0.0 && invented[1] == 0.0 && invented[2] > 0.9, "{invented:?}");
}
