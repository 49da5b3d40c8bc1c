//! The runner against contenders that cheat or waver, which the registry has none of.

use tracebench_api::{Description, Parameters, Preset, Ray, Tracer};
use tracebench_tests::{Fake, Manner};

use super::*;
use crate::controls::Control;
use crate::rays::{RAY_SETS, default_parameters};

/// A triangle that fills half of the image.
fn session() -> Session {
    let corners = vec![[-2.0, -2.0, 0.0], [2.0, -2.0, 0.0], [0.0, 0.5, 0.0]];
    let geometry = Geometry::new(corners, vec![[0, 1, 2]], None).unwrap();
    let truth = Truth::new(&geometry, "fake");
    let viewpoint = Pose::parse("0,0,3:0,0,0").unwrap().viewpoint(&geometry, [8, 8], 8);
    let parameters = default_parameters();
    let request =
        RayRequest { sets: &RAY_SETS[..1], image: [8, 8], seed: 1, parameters: &parameters, path: None, mirrors: &[] };
    let quiet = Progress::new(true);
    Session::new("fake", truth, viewpoint, request, None, &Cache::none(), &quiet).unwrap()
}

/// Builds and traces one contender as the runner does.
fn measure(tracer: Box<dyn Tracer>, control: Option<Control>) -> Result<Entry, RunError> {
    let description = Description { name: "fake", ..Control::AlwaysMiss.description() };
    let parameters = Parameters::preset(&[], Preset::Published);
    let session = session();
    let mut entries = [Entry::new(Contender::ready(description, parameters, tracer), None, control)];
    let quiet = Progress::new(true);
    sample_builds(&session, &mut entries, 2, &quiet);
    validate(session.geometry(), &mut entries, &quiet);
    sample_traces(&session, &session.rays[0], &mut entries, 2, &quiet)?;
    let [entry] = entries;
    Ok(entry)
}

/// Proves that the buffer is poisoned before every sample: a contender that answers once and rests on that is refused;
/// one that answers every time is taken, with a record of each.
#[test]
fn answers_of_an_earlier_sample_do_not_count() {
    let honest = measure(Box::new(Fake(Manner::Honest)), None).unwrap();
    assert!(honest.failure.is_none());
    assert_eq!((honest.builds.len(), honest.traces.len(), honest.traces[0].times.samples_ms.len()), (2, 1, 2));
    // Its counted answers are written, its last timed ones are poison.
    let idle = measure(Box::new(Fake(Manner::Idle)), None).unwrap();
    assert!(idle.failure.is_some() && idle.traces.is_empty());
}

/// Proves that the first trace warms up and is not among the samples.
#[test]
fn warming_up_is_not_counted() {
    let slow = measure(Box::new(Fake(Manner::Slow)), None).unwrap();
    let samples = &slow.traces[0].times.samples_ms;
    assert!(samples.len() == 2 && samples.iter().all(|sample| *sample < 200.0), "{samples:?}");
}

/// Proves that hits which differ between the timed and the counting variant take a contender out of the race.
#[test]
fn hits_must_not_depend_on_counting() {
    let wavering = measure(Box::new(Fake(Manner::Wavering)), None).unwrap();
    let failure = wavering.failure.map(|error| error.to_string()).unwrap_or_default();
    assert!(failure.contains("other hits") && wavering.traces.is_empty(), "{failure}");
}

/// Proves that a control which does not score what it must voids the run: one that always misses in the oracle's place
/// does, in its own place it does not.
#[test]
fn a_failing_control_voids_the_run() {
    assert!(measure(Box::new(Fake(Manner::Honest)), Some(Control::AlwaysMiss)).is_ok());
    for place in [Control::Oracle, Control::AlwaysHit] {
        let error = measure(Box::new(Fake(Manner::Honest)), Some(place)).map(|_| ()).unwrap_err();
        assert!(matches!(error, RunError::Control(_)) && error.to_string().contains("void"), "{error}");
    }
}

/// Proves that rays reach the tracer as they were made: through the pixel centres, from the eye.
#[test]
fn primary_rays_start_at_the_eye() {
    let session = session();
    let rays: &[Ray] = &session.rays[0].buffer.host;
    assert!(rays.len() == 64 && rays.iter().all(|ray| ray.origin == [0.0, 0.0, 3.0]));
}

/// Proves that what a structure says of itself is kept, and that one which is unsound, or says what is no number, is out of
/// the race before it is traced.
#[test]
fn structures_must_be_sound() {
    let honest = measure(Box::new(Fake(Manner::Honest)), None).unwrap();
    assert_eq!(honest.statistics.into_iter().collect::<Vec<_>>(), [("nodes".to_owned(), 1.0)]);
    for (manner, part) in [(Manner::Unsound, "where it should be"), (Manner::Numberless, "cost is NaN")] {
        let entry = measure(Box::new(Fake(manner)), None).unwrap();
        let failure = entry.failure.map(|error| error.to_string()).unwrap_or_default();
        assert!(failure.contains(part) && entry.traces.is_empty() && entry.statistics.is_empty(), "{failure}");
    }
}
