//! That causes are told from rungs, that the ladder of `dirt` explains every wrong ray of a scene, and that a ladder which
//! takes nothing away explains none.

use super::*;
use crate::measure::Journal;
use crate::plan::{RunPreset, SceneSource, ViewRequest};
use crate::progress::Progress;
use crate::rays::{RAY_SETS, default_parameters};
use crate::registry::{self, Device};
use crate::results::Judgement;
use crate::truth::Cache;
use tracebench_api::{AdapterChoice, EndPoint, Gpu, Preset};

/// Every ladder is of a tracer that there is, and its remedies are parameters with such values; some change what is
/// published, and none takes back what one before has set.
#[test]
fn remedies_are_parameters() {
    for registration in registry::TRACERS.iter().filter(|each| !each.ladder.is_empty()) {
        let (ladder, request) = (registration.ladder, TracerRequest::of(registration, Preset::Published));
        let rungs = rungs(&request, ladder).unwrap();
        assert_eq!(rungs.len(), ladder.len() + 1);
        let names = ladder.iter().map(|remedy| remedy.parameter);
        assert_eq!(names.collect::<std::collections::BTreeSet<_>>().len(), ladder.len());
        assert!(rungs[0].parameters != rungs[ladder.len()].parameters);
        // All are there at a time: what hangs together over rungs is looked at in one race.
        assert!(rungs.len() <= measure::WINDOW);
    }
}

/// A ray's cause is what the rung takes away from which on it is right, whatever it was before; on the last rung its status
/// tells.
#[test]
fn the_last_wrong_rung_tells_the_cause() {
    let ladder = registry::find("dirt").unwrap().ladder;
    let of = |rungs: &[usize], given_up| {
        let wrong: Vec<bool> = (0..=ladder.len()).map(|rung| rungs.contains(&rung)).collect();
        cause(ladder, &wrong, given_up)
    };
    assert_eq!(of(&[], false), None);
    assert_eq!(of(&[0], false), Some("outside_of_the_views"));
    assert_eq!(of(&[0, 1, 2], true), Some("early_bucket_stop"));
    assert_eq!(of(&[0, 2, 3], false), Some("pixel_acceptance"));
    assert_eq!(of(&[5], false), Some("near_plane"));
    assert_eq!(of(&[0, 6], false), Some(UNEXPLAINED));
    assert_eq!(of(&[6], true), Some(GIVEN_UP));
}

/// Over a scene, the ladder of `dirt` leaves no ray wrong and names a cause for each that was; counts add up; a ladder that
/// takes nothing away leaves all of them unexplained.
#[test]
fn the_ladder_of_dirt_explains_every_wrong_ray() {
    let device: Device = Gpu::open(&AdapterChoice::default()).map(std::sync::Arc::new);
    let request = TracerRequest::of(registry::find("dirt").unwrap(), Preset::Published);
    let plan = Plan {
        scenes: vec![SceneSource::Catalogue("room".to_owned())],
        tracers: vec![request.clone()],
        ray_sets: RAY_SETS.iter().filter(|set| ["primary", "specular", "ao"].contains(&set.name)).copied().collect(),
        ray_parameters: default_parameters(),
        preset: RunPreset::named("smoke").unwrap(),
        view: ViewRequest::Default,
        time_s: 0.0,
        seed: 1,
        end: EndPoint::Hit,
        table: None,
    };
    let (cache, quiet, journal) = (Cache::none(), Progress::new(true), Journal::none());
    let context = Context::new(&device, &cache, &quiet, &journal);
    let explain = |ladder: &[Remedy]| {
        let run = execute(&plan, &request, ladder, &context).unwrap();
        // The rows of the rungs tell the same numbers of wrong rays as the section.
        let found = run.explanation.unwrap();
        let last = run.runs.last().unwrap();
        for (set, trace) in found.scenes[0].sets.iter().zip(&last.traces) {
            let wrong = match &trace.judgement {
                Judgement::Closest(closest) => closest.classes.tight.wrong(),
                Judgement::Any(any) => any.occlusion.false_free + any.occlusion.false_occluded,
            };
            assert_eq!(wrong, set.left(), "{}", set.rays);
        }
        found
    };
    let found = explain(request.registration.ladder);
    assert_eq!(found.unexplained(), 0);
    let sets = &found.scenes[0].sets;
    assert_eq!(sets.len(), 3);
    assert!(sets[0].wrong_by_rung[0] > 0, "nothing to explain");
    for set in sets {
        let explained: u64 = found.causes().iter().map(|cause| set.of_cause(cause)).sum();
        assert_eq!(explained, set.wrong_by_rung[0], "{}", set.rays);
        assert_eq!(set.of_cause(UNEXPLAINED), 0);
    }
    // Rays that the last rung gives up are told from those that it gets wrong.
    let capped = Remedy { cause: "nothing", parameter: "max_steps", value: "1", source: "" };
    let capped = explain(&[capped]);
    assert!(capped.unexplained() == 0 && capped.scenes[0].sets[0].wrong_by_rung[1] > 1000);
    let idle = Remedy { cause: "nothing", parameter: "max_steps", value: "4096", source: "" };
    let idle = explain(&[idle]);
    assert_eq!(idle.unexplained(), found.scenes[0].sets.iter().map(|set| set.wrong_by_rung[0]).sum::<u64>());
    assert_eq!(idle.scenes[0].sets[0].of_cause(UNEXPLAINED), sets[0].wrong_by_rung[0]);
}
