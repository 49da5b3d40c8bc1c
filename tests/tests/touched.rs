//! How much of what is stored a set of rays touched, of every tracer that counts it.

use crate::subject;

use std::sync::Arc;

use subject::{Subject, room, total};
use tracebench_api::glam::Vec3;
use tracebench_api::{Counter, Geometry, Gpu, PhaseClock, Query, Ray, Residency, Structure, Update, Viewpoint};
use tracebench_harness::rays::primary_rays;
use tracebench_harness::registry::{Family, TRACERS};
use tracebench_tests::{Numbers, available, gpu, ray, viewpoint};

/// A camera in the room that looks along it.
fn camera(frame: [u32; 2]) -> Viewpoint {
    viewpoint(Vec3::new(0.3, 1.4, 0.5), Vec3::new(0.9, 1.2, 3.0), 0.01, 40.0, frame)
}

/// Rays as a tracer serves them; where it wants them all from one point, from the camera's eye over its view.
fn served(name: &str, rays: &[Ray]) -> Vec<Ray> {
    let registration = TRACERS.iter().find(|registration| name.split(' ').next() == Some(registration.name()));
    if !registration.is_some_and(|registration| registration.one_origin()) {
        return rays.to_vec();
    }
    let (view, mut numbers) = (camera([96, 64]).frame_view(), Numbers::new(62));
    let mut seen = || view.direction_through(96.0 * numbers.unit(), 64.0 * numbers.unit());
    rays.iter().map(|_| ray(view.eye, seen())).collect()
}

/// Every tracer that counts what is touched, and of hierarchies both kinds of node.
fn subjects(gpu: &Arc<Gpu>) -> Vec<(String, Family, Subject)> {
    let mut subjects = Vec::new();
    for registration in TRACERS {
        let description = registration.describe();
        let Some(_) = available(description.name, registration.create(&Ok(Arc::clone(gpu))), gpu) else { continue };
        let by_node = description.parameters.iter().any(|each| each.name == "node");
        for node in if by_node { &["cwbvh", "bvh2"][..] } else { &[""] } {
            let set: Vec<(&str, &str)> = by_node.then_some(("node", *node)).into_iter().collect();
            let name = format!("{} {node}", description.name);
            subjects.push((name, registration.family, Subject::new(description.name, &set, gpu)));
        }
    }
    assert!(subjects.len() >= 7);
    subjects
}

/// Built from a camera in the room, which hierarchies do not depend on.
fn build(subject: &Subject, family: Family, geometry: &Geometry, view: &Viewpoint) -> Box<dyn Structure> {
    if family == Family::Bvh {
        return subject.try_build(geometry).unwrap();
    }
    let mut clock = PhaseClock::new(Some(&subject.gpu));
    let mut structure = subject.tracer.build(geometry, view, &subject.parameters, &mut clock).unwrap();
    clock.finish().unwrap();
    // Structures that are sized from counts may have to be built again.
    if structure.grow_on_overflow().unwrap() {
        let mut clock = PhaseClock::new(Some(&subject.gpu));
        structure.update(Update::Rebuild, geometry, view, &subject.parameters, &mut clock).unwrap();
        clock.finish().unwrap();
    }
    structure
}

/// The counts of what is touched, by name.
fn touched(counters: &[Counter]) -> Vec<(&'static str, u64)> {
    let of_set = counters.iter().filter(|counter| counter.name.ends_with("_touched"));
    of_set.map(|counter| (counter.name, counter.total)).collect()
}

/// Proves for every tracer and query that what is touched is a part of what is stored, by the same name; that it grows with
/// the rays, is the same for a set that has every ray twice (while what is counted ray by ray doubles), and is no more than
/// what two halves touch together; and that the timed variant gives the same hits.
#[test]
fn touched_is_a_part_of_what_is_stored() {
    let gpu = gpu();
    let (geometry, rays) = room(&gpu);
    for (name, family, subject) in subjects(&gpu) {
        let rays = &served(&name, &rays[..600])[..];
        let structure = build(&subject, family, &geometry, &camera([96, 64]));
        let statistics = structure.validate(&geometry).unwrap();
        for query in [Query::Closest, Query::Any] {
            let count = |rays: &[Ray]| subject.answer(&*structure, rays, query).1;
            let (first, second) = rays.split_at(300);
            let all = count(rays);
            let [whole, first, second] = [touched(&all), touched(&count(first)), touched(&count(second))];
            assert!(!whole.is_empty() || name.starts_with("ray-query"), "{name}");
            let twice = count(&[rays, rays].concat());
            assert_eq!(touched(&twice), whole, "{name}");
            let per_ray = all.iter().find(|counter| counter.max_per_ray.is_some()).unwrap();
            assert_eq!(total(&twice, per_ray.name), 2.0 * per_ray.total as f64, "{name}");
            for (index, (of, total)) in whole.iter().enumerate() {
                let stored = statistics.iter().find(|(name, _)| Some(*name) == of.strip_suffix("_touched"));
                let stored = stored.unwrap_or_else(|| panic!("{name} does not say what {of} is a part of")).1;
                let [(_, first), (_, second)] = [first[index], second[index]];
                assert!(0 < first && (*total as f64) <= stored, "{name}: {of} {total} of {stored}");
                assert!(first.max(second) <= *total && *total <= first + second, "{name}: {of}");
                assert!(first < *total && *total < first + second, "{name}: {of} says nothing here");
            }
        }
    }
}

/// Proves against the counts of single rays, which are counted apart, that one ray touches what it visits and tests: of
/// hierarchies each node (of binary ones each pair) and each reference once, of others no more than it tests; and that a
/// hit has at least its own reference touched.
#[test]
fn one_ray_touches_what_it_visits() {
    let gpu = gpu();
    let (geometry, rays) = room(&gpu);
    // What is made of others tests and visits what they do.
    let others = ["ray-query", "hybrid"];
    let counted = |(name, ..): &(String, Family, Subject)| !others.iter().any(|other| name.starts_with(other));
    for (name, family, subject) in subjects(&gpu).into_iter().filter(counted) {
        let structure = build(&subject, family, &geometry, &camera([96, 64]));
        let mut at_work = 0;
        for ray in &served(&name, &rays[..40]) {
            let (found, counters) = subject.answer(&*structure, std::slice::from_ref(ray), Query::Closest);
            let count = |name: &str| total(&counters, name);
            let has = |name: &str| counters.iter().any(|counter| counter.name == name);
            at_work += usize::from(touched(&counters).iter().all(|(_, total)| *total > 0));
            if has("pixels_touched") {
                assert!(count("pixels_touched") <= count("depth_samples"), "{name}");
                assert!(!found[0].is_hit() || count("pixels_touched") >= 1.0, "{name}");
                continue;
            }
            if has("vertices_touched") {
                assert_eq!(count("vertices_touched"), 3.0 * count("triangles_read"), "{name}");
                assert!(count("triangles_read") <= count("pixels_read") && count("pixels_read") <= 1.0, "{name}");
                assert!(!found[0].is_hit() || count("triangles_read") == 1.0, "{name}");
                continue;
            }
            if has("leaves_touched") {
                assert!(count("nodes_touched") <= count("nodes_visited"), "{name}");
                assert!(count("leaves_touched") <= count("steps"), "{name}");
                assert!(!found[0].is_hit() || count("leaves_touched") >= 1.0, "{name}");
                continue;
            }
            if has("plane_tests") {
                assert!(count("nodes_touched") <= count("nodes_visited"), "{name}");
                assert_eq!(count("plane_tests") + count("box_tests"), count("nodes_visited"), "{name}");
                assert!(!found[0].is_hit() || count("plane_tests") >= 1.0, "{name}");
                continue;
            }
            if has("cells_touched") {
                assert!(count("cells_touched") <= count("cells_visited"), "{name}");
                assert!(count("depth_samples") <= count("cells_visited"), "{name}");
                assert!(!found[0].is_hit() || count("cells_touched") >= 1.0, "{name}");
                continue;
            }
            if has("fragments_touched") {
                let tested = ["fragments_tested", "layers_tested"].into_iter().find(|tested| has(tested)).unwrap();
                assert!(count("fragments_touched") <= count(tested), "{name}");
                assert!(!found[0].is_hit() || count("fragments_touched") >= 1.0, "{name}");
                continue;
            }
            assert!(!found[0].is_hit() || count("references_touched") >= 1.0, "{name}");
            assert!(count("references_touched") <= count("triangle_tests"), "{name}");
            if has("nodes_touched") {
                let siblings = if name.ends_with("bvh2") { 2.0 } else { 1.0 };
                assert_eq!(count("nodes_touched"), siblings * count("nodes_visited"), "{name}");
                assert_eq!(count("references_touched"), count("triangle_tests"), "{name}");
            }
        }
        assert!(at_work > 5, "{name}");
    }
}

/// Proves for `screen-dda` that primary rays, each of which is one step on its own pixel, touch as many pixels as they are,
/// however often each is there, at any place in the frame.
#[test]
fn primary_rays_touch_their_pixels() {
    let gpu = gpu();
    let (geometry, _) = room(&gpu);
    let subject = Subject::new("screen-dda", &[], &gpu);
    assert_eq!(subject.residency, Residency::Device);
    let view = camera([45, 31]);
    let structure = build(&subject, Family::Image, &geometry, &view);
    let rays = primary_rays(&view, view.frame);
    assert_eq!(rays.len(), 45 * 31);
    for chosen in
        [vec![0], vec![44], vec![45 * 31 - 1], (0..rays.len()).collect(), (0..rays.len()).step_by(7).collect()]
    {
        let some: Vec<Ray> = chosen.iter().chain(&chosen).map(|index: &usize| rays[*index]).collect();
        let counters = subject.answer(&*structure, &some, Query::Closest).1;
        assert_eq!(touched(&counters), [("pixels_touched", chosen.len() as u64)]);
        assert_eq!(total(&counters, "depth_samples"), 2.0 * chosen.len() as f64);
    }
}
