//! Builds in compute shaders, of every tracer that offers them (`build=compute`), over hostile scenes.

use super::hostile::{Subject, small_scenes, subjects};
use tracebench_api::{Domain, Geometry, Hit, PhaseClock, Query, Structure, TracerError, Update, Viewpoint};
use tracebench_harness::registry::find;

/// The published forms of tracers that rasterize, drawn in compute.
fn drawn_in_compute() -> Vec<Subject> {
    let mut found: Vec<Subject> = Vec::new();
    for mut subject in subjects() {
        let described = find(subject.name).unwrap().describe().parameters;
        let offers = described.iter().any(|parameter| {
            parameter.name == "build"
                && matches!(&parameter.domain, Domain::Choice(names) if names.contains(&"compute"))
        });
        if offers && found.iter().all(|other| other.name != subject.name) {
            subject.parameters.set(&described, "build", "compute").unwrap();
            found.push(subject);
        }
    }
    found
}

/// Nothing where it binds more at once than the device allows.
fn try_built(subject: &Subject, geometry: &Geometry, viewpoint: &Viewpoint) -> Option<Box<dyn Structure>> {
    let mut clock = PhaseClock::new(Some(&subject.gpu));
    match subject.tracer.build(geometry, viewpoint, &subject.parameters, &mut clock) {
        Err(TracerError::Unavailable(why)) => {
            assert!(why.contains("storage buffers in a stage"), "{}: {why}", subject.name);
            None
        }
        built => {
            let structure = built.unwrap_or_else(|error| panic!("{}: {error}", subject.name));
            clock.finish().unwrap();
            Some(structure)
        }
    }
}

/// Proves that such structures are sound, that two builds of one answer alike, bit for bit, whatever the order in which lanes draw, and
/// that one which follows the eye answers as a fresh one does, where, as a negative control, one that does not follow is noticed.
#[test]
fn builds_are_sound_and_repeatable() {
    let (mut sound, mut stale) = (0, 0);
    for subject in drawn_in_compute() {
        for scene in small_scenes() {
            let context = format!("{} on {}", subject.name, scene.name);
            let [first, second] = scene.viewpoints;
            let Some(mut structure) = try_built(&subject, &scene.geometry, &first) else { continue };
            structure.validate(&scene.geometry).unwrap_or_else(|error| panic!("{context}: {error}"));
            let rays = subject.rays(&scene.rays, Query::Closest);
            let hits = |structure: &dyn Structure| -> Vec<Hit> { subject.trace(structure, &rays) };
            let before = hits(&*structure);
            assert!(before == hits(&*subject.build(&scene.geometry, &first)), "{context}: second build");
            let fresh = hits(&*subject.build(&scene.geometry, &second));
            let mut clock = PhaseClock::new(Some(&subject.gpu));
            structure.update(Update::Rebuild, &scene.geometry, &second, &subject.parameters, &mut clock).unwrap();
            clock.finish().unwrap();
            if structure.grow_on_overflow().unwrap() {
                let mut clock = PhaseClock::new(Some(&subject.gpu));
                structure.update(Update::Rebuild, &scene.geometry, &second, &subject.parameters, &mut clock).unwrap();
                clock.finish().unwrap();
            }
            assert!(hits(&*structure) == fresh, "{context}: rebuilt");
            sound += 1;
            stale += usize::from(before != fresh);
        }
    }
    assert!(sound >= 2 * small_scenes().len() && stale > 0, "{sound} {stale}");
}
