//! Structures that follow moving scenes and eyes, against fresh builds over fresh scenes of the same frame.

use std::collections::BTreeSet;
use std::rc::Rc;
use std::sync::Arc;

use tracebench_api::glam::Vec3;
use tracebench_api::{
    Geometry, Gpu, Hit, HitBuffer, Invalidation, Parameters, PhaseClock, Preset, Query, Ray, RayBuffer, Structure,
    TraceJob, TraceTo, Tracer, TracerError, Update, Viewpoint,
};
use tracebench_harness::registry::{Registration, TRACERS};
use tracebench_scenes::{Scene, procedural};
use tracebench_tests::{Numbers, available, gpu, presets, ray, viewpoint};

/// A tracer with a preset's parameters.
struct Subject {
    name: String,
    tracer: Rc<dyn Tracer>,
    parameters: Parameters,
    follows_geometry_only: bool,
    registration: &'static Registration,
    gpu: Arc<Gpu>,
}

fn subjects() -> Vec<Subject> {
    let gpu = gpu();
    let of = |registration: &'static Registration| {
        let description = registration.describe();
        // One for all presets: drivers compile each of its pipelines once.
        let created = registration.create(&Ok(Arc::clone(&gpu)));
        let tracer = available(description.name, created, &gpu).map(Rc::<dyn Tracer>::from);
        let subject = |(preset, parameters): (Preset, Parameters)| {
            Some(Subject {
                name: format!("{}:{}", description.name, preset.name()),
                tracer: tracer.clone()?,
                parameters,
                follows_geometry_only: !description.invalidated_by.contains(&Invalidation::Viewpoint),
                registration,
                gpu: Arc::clone(&gpu),
            })
        };
        presets(&description.parameters).into_iter().filter_map(subject).collect::<Vec<_>>()
    };
    TRACERS.iter().flat_map(of).collect()
}

impl Subject {
    fn build(&self, geometry: &Geometry, viewpoint: &Viewpoint) -> Box<dyn Structure> {
        let mut clock = PhaseClock::new(Some(&self.gpu));
        let structure = self.tracer.build(geometry, viewpoint, &self.parameters, &mut clock).unwrap();
        clock.finish().unwrap();
        structure
    }

    fn update(
        &self,
        structure: &mut dyn Structure,
        update: Update,
        geometry: &Geometry,
        viewpoint: &Viewpoint,
    ) -> Result<(), TracerError> {
        let mut clock = PhaseClock::new(Some(&self.gpu));
        structure.update(update, geometry, viewpoint, &self.parameters, &mut clock)?;
        // A reused structure has no work to time.
        if update != Update::Reuse {
            let timing = clock.finish()?;
            assert!(timing.total_ms >= 0.0 && !timing.phases.is_empty(), "{}", self.name);
            // What is sized from counts may need more room for what moved, as the harness gives it.
            if structure.grow_on_overflow()? {
                let mut clock = PhaseClock::new(Some(&self.gpu));
                structure.update(Update::Rebuild, geometry, viewpoint, &self.parameters, &mut clock)?;
                clock.finish()?;
                assert!(!structure.grow_on_overflow()?, "{}", self.name);
            }
        }
        Ok(())
    }

    fn hits(&self, structure: &dyn Structure, rays: &[Ray]) -> Vec<Hit> {
        let rays = RayBuffer::new(Arc::new(rays.to_vec()), Query::Closest, Some(&self.gpu));
        let residency = self.registration.describe().residency;
        let mut hits = HitBuffer::new(rays.host.len(), residency, Some(&self.gpu)).unwrap();
        hits.poison(Some(&self.gpu)).unwrap();
        let mut clock = PhaseClock::new(Some(&self.gpu));
        let job = TraceJob { rays: &rays, trace_to: TraceTo::Hit, parameters: &self.parameters };
        structure.trace(job, &mut hits, &mut clock).unwrap();
        clock.finish().unwrap();
        hits.read(Some(&self.gpu)).unwrap()
    }
}

fn bytes(hits: &[Hit]) -> &[u8] {
    bytemuck::cast_slice(hits)
}

/// A scene imported afresh, as it stands at a time.
fn at(name: &str, time_s: f64) -> Scene {
    let mut scene = procedural(name, 0.02).unwrap();
    scene.set_time(time_s).unwrap();
    scene
}

fn geometry(scene: &Scene, gpu: &Gpu) -> Geometry {
    Geometry::new(scene.mesh.positions.clone(), scene.mesh.triangles.clone(), Some(gpu)).unwrap()
}

fn views(scene: &Scene) -> [Viewpoint; 2] {
    let diagonal = scene.diagonal() as f32;
    let view = |index: usize| {
        let camera = &scene.cameras[index];
        viewpoint(camera.eye.into(), camera.target.into(), 1e-3 * diagonal, 4.0 * diagonal, [96, 64])
    };
    [view(0), view(1)]
}

/// Rays from both eyes and from all over the scene; of a tracer that serves rays from one point alone from the first eye.
fn rays(scene: &Scene, seed: u64, one_origin: bool) -> Vec<Ray> {
    let mut numbers = Numbers::new(seed);
    let (low, high) = (Vec3::from(scene.bounds_min).as_dvec3(), Vec3::from(scene.bounds_max).as_dvec3());
    let mut place = || (low + high) / 2.0 + numbers.point() * (high - low) / 2.0;
    let mut rays = Vec::new();
    for index in 0..1500 {
        let camera = if one_origin { 0 } else { index % 2 };
        let eye = Vec3::from(scene.cameras[camera].eye).as_dvec3();
        let from = if index % 3 == 0 && !one_origin { place() } else { eye };
        rays.push(ray(from, place() - from));
    }
    rays
}

/// [`structures_follow`] where all of the scene deforms.
#[test]
fn structures_follow_deforming_scenes() {
    structures_follow("cloth", 0.9);
}

/// [`structures_follow`] where parts move rigidly.
#[test]
#[ignore = "wider set: twice as long as where all deforms, a quarter of a minute on a software adapter"]
fn structures_follow_rigid_parts() {
    structures_follow("hangar", 2.3);
}

/// Proves for a scene, and a later time, that vertices are moved on the device without a new import: a structure that is rebuilt or
/// refitted over the moved geometry gives the hits of a fresh build over a fresh scene of that frame, bit for bit, and one that is reused
/// gives those of before, which are others (the negative control). Back at the first frame all is as it was.
fn structures_follow(name: &str, time_s: f64) {
    for subject in subjects() {
        let context = format!("{} over {name}", subject.name);
        let (start, later) = (at(name, 0.0), at(name, time_s));
        assert_eq!(start.mesh.triangles, later.mesh.triangles);
        let (view, rays) = (views(&start)[0], rays(&later, 5, subject.registration.one_origin()));
        let fresh = subject.build(&geometry(&later, &subject.gpu), &view);
        let expected = subject.hits(&*fresh, &rays);
        for update in Update::ALL {
            let mut moving = geometry(&start, &subject.gpu);
            let mut structure = subject.build(&moving, &view);
            let before = subject.hits(&*structure, &rays);
            let hit_count = before.iter().filter(|hit| hit.is_hit()).count();
            assert!(hit_count > 100, "{context}: {hit_count} hits");
            moving = moving.with_positions(later.mesh.positions.clone(), Some(&subject.gpu)).unwrap();
            // What is not served is told before and refused in the same words.
            let served = subject.registration.describe().serves(update);
            match subject.update(&mut *structure, update, &moving, &view) {
                Ok(()) => assert!(served.is_ok(), "{context} {}", update.name()),
                Err(error @ TracerError::Unsupported(_)) => {
                    assert_eq!(served.unwrap_err().to_string(), error.to_string(), "{context}");
                    assert_eq!(update, Update::Refit, "{context}: {error}");
                    let as_before = subject.hits(&*structure, &rays) == before;
                    assert!(as_before || structure.memory().geometry_bytes > 0, "{context}");
                    let _back = moving.with_positions(start.mesh.positions.clone(), Some(&subject.gpu)).unwrap();
                    assert_eq!(bytes(&subject.hits(&*structure, &rays)), bytes(&before), "{context}");
                    continue;
                }
                Err(error) => panic!("{context} {}: {error}", update.name()),
            }
            let found = subject.hits(&*structure, &rays);
            if update == Update::Reuse {
                // What asks the scene's own vertices while it traces has moved ones in stale places, until they are back.
                assert!(found == before || structure.memory().geometry_bytes > 0, "{context}");
                assert!(found != expected, "{context}: nothing moves");
                let _back = moving.with_positions(start.mesh.positions.clone(), Some(&subject.gpu)).unwrap();
                assert_eq!(bytes(&subject.hits(&*structure, &rays)), bytes(&before), "{context}");
                continue;
            }
            let same = found.iter().zip(&expected).filter(|(a, b)| a == b).count();
            assert_eq!(same, rays.len(), "{context} {}", update.name());
            structure.validate(&moving).unwrap();
            moving = moving.with_positions(start.mesh.positions.clone(), Some(&subject.gpu)).unwrap();
            subject.update(&mut *structure, update, &moving, &view).unwrap();
            assert_eq!(bytes(&subject.hits(&*structure, &rays)), bytes(&before), "{context} {}", update.name());
        }
    }
}

/// Proves that a rebuild follows the eye, in another frame size too, and that what does not depend on the viewpoint gives
/// the same hits when it is reused, while what depends on it gives those of the old view: others than those of the new one, of every method
/// that samples.
#[test]
fn structures_follow_the_eye() {
    let scene = at("cloth", 0.0);
    let (mut stale, mut asked) = (BTreeSet::new(), BTreeSet::new());
    for subject in subjects() {
        let rays = rays(&scene, 6, subject.registration.one_origin());
        let geometry = geometry(&scene, &subject.gpu);
        let [first, second] = views(&scene);
        // An analytic method that keeps every triangle may answer alike from everywhere; one of samples does not.
        if !subject.follows_geometry_only && !subject.registration.is_analytic() {
            asked.insert(subject.name.clone());
        }
        for other in [second, Viewpoint { frame: [40, 56], ..second }] {
            let expected = subject.hits(&*subject.build(&geometry, &other), &rays);
            let mut structure = subject.build(&geometry, &first);
            let before = subject.hits(&*structure, &rays);
            assert!(before == expected || !subject.follows_geometry_only, "{}", subject.name);
            if before != expected {
                stale.insert(subject.name.clone());
            }
            subject.update(&mut *structure, Update::Reuse, &geometry, &other).unwrap();
            assert_eq!(bytes(&subject.hits(&*structure, &rays)), bytes(&before), "{}", subject.name);
            subject.update(&mut *structure, Update::Rebuild, &geometry, &other).unwrap();
            assert_eq!(bytes(&subject.hits(&*structure, &rays)), bytes(&expected), "{}", subject.name);
        }
    }
    assert!(asked.len() > 5 && asked.is_subset(&stale), "{asked:?} of {stale:?}");
}

/// Proves that a structure cannot be fitted to other triangles, nor a scene moved to another number of vertices, and that
/// the structure answers as before then.
#[test]
fn other_triangles_are_refused() {
    let (scene, other) = (at("cloth", 0.0), at("hangar", 0.0));
    for subject in subjects() {
        let rays = rays(&scene, 7, subject.registration.one_origin());
        let geometry = geometry(&scene, &subject.gpu);
        let view = views(&scene)[0];
        let mut structure = subject.build(&geometry, &view);
        let before = subject.hits(&*structure, &rays);
        let others = Geometry::new(other.mesh.positions.clone(), other.mesh.triangles.clone(), Some(&subject.gpu));
        let error = subject.update(&mut *structure, Update::Refit, &others.unwrap(), &view).unwrap_err();
        assert!(!error.to_string().is_empty());
        assert_eq!(bytes(&subject.hits(&*structure, &rays)), bytes(&before), "{}", subject.name);
        let error = geometry.with_positions(other.mesh.positions.clone(), Some(&subject.gpu)).unwrap_err();
        assert!(error.to_string().contains("vertices"), "{error}");
    }
}

/// Proves that what depends on the size of the scene follows it: a scene that grows to three times its size, seen from
/// as much farther, is traced as by a fresh build.
#[test]
fn structures_follow_growing_scenes() {
    let scene = at("cloth", 1.5);
    let grown: Vec<[f32; 3]> = scene.mesh.positions.iter().map(|position| position.map(|value| 3.0 * value)).collect();
    for subject in subjects() {
        let before = geometry(&scene, &subject.gpu);
        let after = Geometry::new(grown.clone(), scene.mesh.triangles.clone(), Some(&subject.gpu)).unwrap();
        let [first, _] = views(&scene);
        let second = Viewpoint { eye: first.eye * 3.0, near: first.near * 3.0, far: first.far * 3.0, ..first };
        let rays = rays(&scene, 8, subject.registration.one_origin()).into_iter();
        let rays: Vec<Ray> = rays.map(|ray| Ray { origin: ray.origin.map(|value| 3.0 * value), ..ray }).collect();
        let expected = subject.hits(&*subject.build(&after, &second), &rays);
        let described = subject.registration.describe();
        for update in [Update::Rebuild, Update::Refit].into_iter().filter(|update| described.serves(*update).is_ok()) {
            let mut structure = subject.build(&before, &first);
            subject.update(&mut *structure, update, &after, &second).unwrap();
            assert_eq!(bytes(&subject.hits(&*structure, &rays)), bytes(&expected), "{}", subject.name);
        }
    }
}
