//! One body for every tracer in the registry: what the contract promises, over tiny hostile scenes.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::hostile::{Hostile, Subject, scenes, small_scenes, subjects};
use tracebench_api::glam::{DVec3, Vec3};
use tracebench_api::{
    Counter, Geometry, Hit, HitBuffer, ParameterDescription, ParameterScope, Parameters, PhaseClock, Preset,
    Projection, Query, Ray, RayBuffer, Residency, Status, Structure, TraceJob, TraceTo, TracerError,
};
use tracebench_harness::registry::{Registration, TRACERS};
use tracebench_tests::{Numbers, gpu, ray, rectangle, soup, viewpoint};

impl Subject {
    /// Hits and counters, by the counting variant.
    fn count(&self, structure: &dyn Structure, rays: &RayBuffer) -> (Vec<Hit>, Vec<Counter>) {
        let mut hits = self.poisoned(rays.host.len());
        let counted = structure.trace_counted(self.job(rays), &mut hits);
        let counters = counted.unwrap_or_else(|error| panic!("{}: {error}", self.name));
        (hits.read(Some(&self.gpu)).unwrap(), counters)
    }
}

fn bytes(hits: &[Hit]) -> &[u8] {
    bytemuck::cast_slice(hits)
}

/// What the contract says of every answer by itself; gives what is wrong with it.
fn wrong_by_itself(subject: &Subject, geometry: &Geometry, ray: &Ray, hit: &Hit) -> Option<&'static str> {
    match Status::from_code(hit.status) {
        None => Some("a status that does not exist"),
        Some(Status::Unwritten) => Some("poison is left"),
        Some(status) if status.is_hit() && !(ray.t_min..=ray.t_max).contains(&hit.t) => {
            Some("t is outside of the ray's span")
        }
        Some(status) if status.is_hit() && subject.names_primitives => {
            let exists = (hit.primitive as usize) < geometry.triangles.len();
            let weights = hit.u >= -1e-3 && hit.v >= -1e-3 && hit.u + hit.v <= 1.001;
            if exists && weights { None } else { Some("no such triangle, or barycentrics outside of it") }
        }
        Some(status) if status.is_hit() => {
            (hit.primitive != tracebench_api::NO_PRIMITIVE && !subject.has_parts).then_some("a triangle is named")
        }
        Some(_) => {
            (hit.t != 0.0 || hit.primitive != tracebench_api::NO_PRIMITIVE).then_some("a miss with a hit's fields")
        }
    }
}

/// Proves for every tracer, preset, scene and query: every ray is answered, with a status, t and triangle that can be;
/// two traces and two builds give the same bits; the counting variant gives the same hits and counts something; the
/// structure validates. Over all scenes of the set each counter counts something.
fn whole_and_repeatable(scenes: &[Hostile]) {
    for subject in subjects() {
        let mut totals = BTreeMap::new();
        for scene in scenes {
            let structures = [0, 1].map(|_| subject.build(&scene.geometry, &scene.viewpoints[0]));
            for query in [Query::Closest, Query::Any] {
                let context = format!("{} {:?} on {}, {query:?}", subject.name, subject.parameters, scene.name);
                let rays = subject.rays(&scene.rays, query);
                let first = subject.trace(&*structures[0], &rays);
                assert_eq!(first.len(), scene.rays.len());
                for (index, (ray, hit)) in scene.rays.iter().zip(&first).enumerate() {
                    let wrong = wrong_by_itself(&subject, &scene.geometry, ray, hit);
                    assert_eq!(wrong, None, "{context}: ray {index} {ray:?} {hit:?}");
                }
                assert_eq!(bytes(&subject.trace(&*structures[0], &rays)), bytes(&first), "{context}: second trace");
                assert_eq!(bytes(&subject.trace(&*structures[1], &rays)), bytes(&first), "{context}: second build");
                let (counted, counters) = subject.count(&*structures[0], &rays);
                assert_eq!(bytes(&counted), bytes(&first), "{context}: counted");
                assert!(counters.iter().any(|counter| counter.total > 0), "{context}");
                for counter in counters {
                    let Counter { name, total, max_per_ray } = counter;
                    let greatest = max_per_ray.unwrap_or(total);
                    *totals.entry(name).or_insert(0) += total;
                    // Of needles, which are thin, a sampled method may store nothing and so find nothing to open or test; of hits that
                    // are counted by where they lie, and of edges at which planes end, a scene may have none.
                    let of_some_scenes = name.starts_with("hits_") || name == "neighbours_read";
                    assert!(total > 0 || scene.name == "needles" || of_some_scenes, "{context}: {name}");
                    assert!(greatest <= total, "{context}: {name} {total} {greatest}");
                    assert!(greatest * scene.rays.len() as u64 >= total, "{context}: {name}");
                }
            }
            let statistics =
                structures[0].validate(&scene.geometry).unwrap_or_else(|error| panic!("{}: {error}", subject.name));
            assert!(statistics.iter().all(|(_, value)| value.is_finite()));
        }
        totals.retain(|_, total| *total == 0);
        assert_eq!(totals, BTreeMap::new(), "{} {:?}", subject.name, subject.parameters);
    }
}

/// See [`whole_and_repeatable`].
#[test]
fn answers_are_whole_and_repeatable() {
    whole_and_repeatable(&small_scenes());
}

/// See [`whole_and_repeatable`], with lists of thousands of equal triangles.
#[test]
#[ignore = "wider set: long lists, half a minute; on the second driver on every commit"]
fn answers_are_whole_and_repeatable_in_long_lists() {
    whole_and_repeatable(&scenes());
}

/// Proves for every tracer that what its description says it serves is what its structures serve, and that it refuses
/// parameters that are not its own by their name.
#[test]
fn descriptions_say_what_is_served() {
    let scene = &scenes()[0];
    for subject in subjects() {
        let described = tracebench_harness::registry::find(subject.name).unwrap().describe();
        let structure = subject.build(&scene.geometry, &scene.viewpoints[0]);
        for (trace_to, query) in TraceTo::ALL.into_iter().flat_map(|trace_to| Query::ALL.map(|query| (trace_to, query)))
        {
            let rays = subject.rays(&scene.rays, query);
            let mut hits =
                HitBuffer::tracing_to(trace_to, rays.host.len(), described.residency, Some(&subject.gpu)).unwrap();
            hits.poison(Some(&subject.gpu)).unwrap();
            let mut clock = PhaseClock::new(Some(&subject.gpu));
            let job = TraceJob { trace_to, ..subject.job(&rays) };
            let traced = structure.trace(job, &mut hits, &mut clock).and_then(|()| clock.finish().map(drop));
            let served = described.ends.contains(&trace_to) && described.queries.contains(&query);
            let refused = matches!(traced, Err(TracerError::Unsupported(_)));
            assert!(
                if served { traced.is_ok() } else { refused },
                "{}: {trace_to:?}, {query:?}: {traced:?}",
                subject.name
            );
        }
        let foreign = Parameters::preset(&[], Preset::Published);
        let mut clock = PhaseClock::new(Some(&subject.gpu));
        let built = subject.tracer.build(&scene.geometry, &scene.viewpoints[0], &foreign, &mut clock);
        let shapes = |each: &ParameterDescription| each.scope == ParameterScope::Build;
        match (built, described.parameters.iter().any(shapes)) {
            (Err(TracerError::Parameter(error)), true) => {
                // Which of them is found missing first is the tracer's.
                let named = |own: &ParameterDescription| error.to_string().contains(&format!("'{}'", own.name));
                assert!(described.parameters.iter().any(named), "{}: {error}", subject.name);
            }
            // Nothing shapes its structures, so nothing is asked.
            (Ok(_), false) => drop(clock.finish().unwrap()),
            (other, _) => panic!("{}: {:?}", subject.name, other.err()),
        }
    }
}

/// Proves for every tracer that it serves rays from several points, or refuses them for that, as its registration says, and that it answers
/// those from one point as before then.
#[test]
fn several_origins_are_served_or_refused() {
    let scene = &scenes()[1];
    for subject in subjects() {
        let structure = subject.build(&scene.geometry, &scene.viewpoints[0]);
        let rays = subject.rays(&scene.rays, Query::Closest);
        let before = subject.trace(&*structure, &rays);
        let several = RayBuffer::new(Arc::new(scene.rays.clone()), Query::Closest, Some(&subject.gpu));
        let mut hits = subject.poisoned(scene.rays.len());
        let traced = subject.try_trace(&*structure, &several, &mut hits);
        let refused = matches!(&traced, Err(TracerError::Unsupported(reason)) if reason.contains("several"));
        assert!(if subject.one_origin { refused } else { traced.is_ok() }, "{}: {traced:?}", subject.name);
        let counted = structure.trace_counted(subject.job(&several), &mut hits);
        assert_eq!(counted.is_err(), subject.one_origin, "{}", subject.name);
        assert_eq!(bytes(&subject.trace(&*structure, &rays)), bytes(&before), "{}", subject.name);
    }
}

/// Proves for every tracer that something is hit and something missed in the ordinary scenes, so that the test above
/// did not compare nothing with nothing.
#[test]
fn hits_and_misses_occur() {
    for subject in subjects() {
        for scene in small_scenes() {
            let structure = subject.build(&scene.geometry, &scene.viewpoints[0]);
            let hits = subject.trace(&*structure, &subject.rays(&scene.rays, Query::Closest));
            let found = hits.iter().filter(|hit| hit.is_hit()).count();
            // Needles are thin: a sampled method may well find none.
            let least = if scene.name == "needles" { 0 } else { hits.len() / 20 };
            assert!(found >= least && found < hits.len(), "{} on {}: {found}", subject.name, scene.name);
        }
    }
}

/// Negative control: each way in which an answer can be wrong by itself is noticed.
#[test]
fn wrong_answers_are_noticed() {
    let scene = &scenes()[0];
    let ray = Ray { t_min: 1.0, t_max: 2.0, ..scene.rays[0] };
    for subject in subjects() {
        let primitive = if subject.names_primitives { 0 } else { tracebench_api::NO_PRIMITIVE };
        let good = Hit { t: 1.5, primitive, u: 0.25, v: 0.25, status: Status::Hit as u32 };
        let wrong = |hit: Hit| wrong_by_itself(&subject, &scene.geometry, &ray, &hit).is_some();
        assert!(!wrong(good) && !wrong(Hit::miss(Status::Miss)));
        assert!(wrong(Hit { status: 0, ..good }) && wrong(Hit { status: 77, ..good }));
        assert!(wrong(Hit { t: 0.5, ..good }) && wrong(Hit { t: 2.5, ..good }) && wrong(Hit { t: f32::NAN, ..good }));
        assert!(wrong(Hit { primitive: 1, ..good }) || subject.has_parts);
        assert!(wrong(Hit { t: 1.0, ..Hit::miss(Status::Miss) }));
    }
}

/// Proves that of hits at equal t the lower primitive is named, whatever the structure's order: forty equal triangles
/// among others, by every value of every choice that a build has.
#[test]
fn equal_hits_go_to_the_lower_primitive() {
    let gpu = gpu();
    let mut numbers = Numbers::new(31);
    let plate = rectangle([-1.0, -1.0, 0.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0])[0];
    let mut triangles: Vec<[[f32; 3]; 3]> = Vec::new();
    for index in 0..120 {
        let aside = (numbers.point() * 0.2 + DVec3::new(1.5, -1.5, 0.3)).as_vec3();
        let other = plate.map(|corner| (Vec3::from(corner) * 0.1 + aside).to_array());
        triangles.push(if index % 3 == 1 { plate } else { other });
    }
    let geometry = soup(&triangles, Some(&gpu));
    let view = viewpoint(Vec3::new(0.0, 0.0, 3.0), Vec3::ZERO, 0.01, 10.0, [32, 32]);
    let rays: Vec<Ray> = (0..64).map(|i| ray(DVec3::new(0.7, -0.9 + 0.02 * f64::from(i), 2.0), DVec3::NEG_Z)).collect();
    for mut subject in subjects().into_iter().filter(|subject| subject.names_primitives) {
        let registration = tracebench_harness::registry::find(subject.name).unwrap();
        let described = registration.describe().parameters;
        let sweeps = described.iter().flat_map(|each| each.sweep.iter().map(|value| (each.name, value.to_string())));
        let own = subject.parameters.clone();
        for (name, value) in sweeps {
            subject.parameters = own.clone();
            subject.parameters.set(&described, name, &value).unwrap();
            let structure = subject.build(&geometry, &view);
            // One value says that it gives the rule up, and one that it loses what lies between samples.
            let any_of_equal = (name, value.as_str()) == ("equal_t", "first_met");
            let loses = (name, value.as_str()) == ("coverage", "standard");
            let hits = subject.trace(&*structure, &subject.rays(&rays, Query::Closest));
            let found: Vec<_> = hits.iter().filter(|hit| hit.is_hit()).collect();
            let least = if loses { hits.len() / 2 } else { hits.len() };
            assert!(found.len() >= least, "{} {name}={value}: {} hits", subject.name, found.len());
            let right = |hit: &&Hit| if any_of_equal { hit.primitive % 3 == 1 } else { hit.primitive == 1 };
            assert!(found.iter().all(right), "{} {name}={value}: {found:?}", subject.name);
        }
    }
}

/// Proves that structures live side by side: built at another viewpoint and over another scene in between, the first
/// still gives the same hits; a tracer that depends on the viewpoint says so and has views, one that does not has none.
#[test]
fn structures_live_side_by_side() {
    let scenes = small_scenes();
    for subject in subjects() {
        for pair in scenes.windows(2) {
            let [scene, other] = pair else { continue };
            let rays = subject.rays(&scene.rays, Query::Closest);
            let first = subject.build(&scene.geometry, &scene.viewpoints[0]);
            let before = subject.trace(&*first, &rays);
            let second = subject.build(&scene.geometry, &scene.viewpoints[1]);
            let third = subject.build(&other.geometry, &other.viewpoints[0]);
            let from_second = subject.trace(&*second, &rays);
            subject.trace(&*third, &subject.rays(&other.rays, Query::Any));
            assert_eq!(bytes(&subject.trace(&*first, &rays)), bytes(&before), "{} on {}", subject.name, scene.name);
            drop(first);
            assert_eq!(bytes(&subject.trace(&*second, &rays)), bytes(&from_second), "{}", subject.name);
            let depends = TRACERS.iter().map(Registration::describe).any(|description| {
                description.name == subject.name
                    && description.invalidated_by.contains(&tracebench_api::Invalidation::Viewpoint)
            });
            // What looks from an eye depends on it; what looks along an axis, or holds the scene, does not.
            let looks = second
                .samplings(&subject.parameters)
                .unwrap()
                .iter()
                .any(|each| matches!(each.projection, Projection::Perspective(_)));
            assert_eq!(looks, depends, "{}", subject.name);
            if !depends {
                assert_eq!(bytes(&from_second), bytes(&before), "{} on {}", subject.name, scene.name);
            }
        }
    }
}

/// Proves the memory report: something is held, used never exceeds allocated, the sum is that of the parts, the peak is
/// at least the sum, names are unique, and more triangles or pixels never take less.
#[test]
fn memory_adds_up() {
    let scenes = scenes();
    for subject in subjects() {
        let mut held = Vec::new();
        for scene in &scenes {
            let structure = subject.build(&scene.geometry, &scene.viewpoints[0]);
            let report = structure.memory();
            let sum: u64 = report.structure.iter().map(|entry| entry.allocated_bytes).sum();
            assert!(sum > 0 && report.structure_bytes() == sum && report.build_peak_bytes >= sum, "{report:?}");
            assert!(report.structure.iter().all(|entry| entry.used_bytes <= entry.allocated_bytes), "{report:?}");
            let mut names: Vec<&str> = report.structure.iter().map(|entry| entry.name.as_str()).collect();
            names.sort_unstable();
            names.dedup();
            assert_eq!(names.len(), report.structure.len(), "{report:?}");
            let of_trace = |rays: usize| -> u64 {
                let rays = subject.rays(&scene.rays[..rays], Query::Closest);
                structure.trace_memory(subject.job(&rays)).unwrap().iter().map(|entry| entry.allocated_bytes).sum()
            };
            assert!(of_trace(0) <= of_trace(scene.rays.len()));
            held.push(sum);
        }
        // What the allocator puts before a texture to align it hangs on what was allocated before: up to a page.
        assert!(held[0] <= held[6] + 4096, "{}: {held:?}", subject.name);
    }
}

/// Proves that hits or rays of the other residency are an error that says so, and that the device is usable afterwards.
#[test]
fn the_other_residency_is_an_error() {
    let scene = &scenes()[1];
    for subject in subjects() {
        let structure = subject.build(&scene.geometry, &scene.viewpoints[0]);
        let rays = subject.rays(&scene.rays, Query::Closest);
        let expected = subject.trace(&*structure, &rays);
        let other = match subject.residency {
            Residency::Host => Residency::Device,
            Residency::Device => Residency::Host,
        };
        let mut hits = HitBuffer::new(scene.rays.len(), other, Some(&subject.gpu)).unwrap();
        let error = subject.try_trace(&*structure, &rays, &mut hits).unwrap_err();
        assert!(error.to_string().len() > 10, "{}: {error}", subject.name);
        assert!(structure.trace_counted(subject.job(&rays), &mut hits).is_err(), "{}", subject.name);
        if subject.residency == Residency::Device {
            let on_host = RayBuffer::new(Arc::clone(&rays.host), Query::Closest, None);
            let mut hits = subject.poisoned(scene.rays.len());
            assert!(subject.try_trace(&*structure, &on_host, &mut hits).is_err(), "{}", subject.name);
            let host_only = Geometry::new(scene.geometry.positions.to_vec(), scene.geometry.triangles.to_vec(), None);
            let mut clock = PhaseClock::new(Some(&subject.gpu));
            let built =
                subject.tracer.build(&host_only.unwrap(), &scene.viewpoints[0], &subject.parameters, &mut clock);
            assert!(built.is_err(), "{}", subject.name);
        }
        assert_eq!(bytes(&subject.trace(&*structure, &rays)), bytes(&expected), "{}", subject.name);
    }
}

/// Proves that no rays at all do not panic, whatever is answered, and that the device is usable afterwards.
#[test]
fn no_rays_do_not_panic() {
    let scene = &scenes()[1];
    for subject in subjects() {
        let structure = subject.build(&scene.geometry, &scene.viewpoints[0]);
        let none = subject.rays(&[], Query::Closest);
        let mut hits = subject.poisoned(0);
        let traced = subject.try_trace(&*structure, &none, &mut hits);
        if traced.is_ok() {
            assert!(hits.read(Some(&subject.gpu)).is_ok_and(|hits| hits.is_empty()), "{}", subject.name);
        }
        let _ = structure.trace_counted(subject.job(&none), &mut hits);
        let rays = subject.rays(&scene.rays[..1], Query::Closest);
        assert_eq!(subject.trace(&*structure, &rays).len(), 1);
    }
}

/// Proves that a hit buffer of another length than the rays is an error, not a silent part of the answers.
#[test]
fn another_number_of_hits_is_an_error() {
    let scene = &scenes()[1];
    for subject in subjects() {
        let structure = subject.build(&scene.geometry, &scene.viewpoints[0]);
        let rays = subject.rays(&scene.rays, Query::Closest);
        for count in [1, scene.rays.len() - 1, scene.rays.len() + 1] {
            let mut hits = subject.poisoned(count);
            assert!(subject.try_trace(&*structure, &rays, &mut hits).is_err(), "{} {count}", subject.name);
            let mut hits = subject.poisoned(count);
            assert!(structure.trace_counted(subject.job(&rays), &mut hits).is_err(), "{} {count}", subject.name);
        }
    }
}
