//! That causes are told from steps, that the remedy sequence of `dirt` explains every wrong ray of a scene, that a remedy sequence which
//! takes nothing away explains none, and that the judge explains what those of sampled methods leave.

use super::*;
use crate::measure::Journal;
use crate::plan::{RunPreset, SceneSource, ViewRequest};
use crate::progress::Progress;
use crate::rays::{RAY_SETS, default_parameters};
use crate::registry::{self, Device};
use crate::results::Judgement;
use crate::truth::Cache;
use tracebench_api::{AdapterChoice, Gpu, Preset, TraceTo};

/// Every remedy sequence is of a tracer that there is, and its remedies are parameters with such values; some change what is
/// published, and none takes back what one before has set.
#[test]
fn remedies_are_parameters() {
    for registration in registry::TRACERS.iter().filter(|each| !each.remedies.is_empty()) {
        let (remedies, request) = (&registration.remedies, TracerRequest::of(registration, Preset::Published));
        let steps = steps(&request, remedies).unwrap();
        assert_eq!(steps.len(), remedies.len() + 1);
        let names = remedies.iter().map(|remedy| &remedy.parameter);
        assert_eq!(names.collect::<std::collections::BTreeSet<_>>().len(), remedies.len());
        assert!(steps[0].parameters != steps[remedies.len()].parameters);
        // All are there at a time: what hangs together over steps is looked at in one interleaved set.
        assert!(steps.len() <= measure::MAX_RESIDENT);
    }
}

/// A ray's cause is what the step takes away from which on it is right, whatever it was before; on the last step its status
/// tells.
#[test]
fn the_last_wrong_rung_tells_the_cause() {
    let remedies = &registry::find("dirt").unwrap().remedies;
    let of = |steps: &[usize], given_up| {
        let wrong: Vec<bool> = (0..=remedies.len()).map(|step| steps.contains(&step)).collect();
        cause(remedies, &wrong, given_up)
    };
    assert_eq!(of(&[], false), None);
    assert_eq!(of(&[0], false), Some("outside_of_the_views"));
    assert_eq!(of(&[0, 1, 2], true), Some("early_bucket_stop"));
    assert_eq!(of(&[0, 2, 3], false), Some("pixel_acceptance"));
    assert_eq!(of(&[5], false), Some("near_plane"));
    assert_eq!(of(&[0, 6], false), Some(UNEXPLAINED));
    assert_eq!(of(&[6], true), Some(GIVEN_UP));
}

/// A tracer's rays in the small room.
fn in_the_room(request: &TracerRequest, rays: &[&str]) -> Plan {
    Plan {
        scenes: vec![SceneSource::Catalogue("room".to_owned())],
        tracers: vec![request.clone()],
        ray_sets: RAY_SETS.iter().filter(|set| rays.contains(&set.name)).copied().collect(),
        ray_parameters: default_parameters(),
        preset: RunPreset::named("smoke").unwrap(),
        view: ViewRequest::Default,
        time_s: 0.0,
        seed: 1,
        trace_to: TraceTo::Hit,
        builds_timed: true,
        wrong_rays_per_cause: crate::judge::WRONG_RAYS_PER_CAUSE,
        table: None,
    }
}

/// Over a scene, the remedy sequence of `dirt` leaves no ray wrong and names a cause for each that was; counts add up; a remedy sequence
/// that takes nothing away leaves all of them unexplained.
#[test]
fn the_ladder_of_dirt_explains_every_wrong_ray() {
    let device: Device = Gpu::open(&AdapterChoice::default()).map(std::sync::Arc::new);
    let request = TracerRequest::of(registry::find("dirt").unwrap(), Preset::Published);
    let plan = in_the_room(&request, &["primary", "specular", "ao"]);
    let (cache, quiet, journal) = (Cache::none(), Progress::new(true), Journal::none());
    let context = Context::new(&device, &cache, &quiet, &journal);
    let explain = |remedies: &[RemedyRecord]| {
        let record = execute(&plan, &request, remedies, &context).unwrap();
        // The rows of the steps tell the same numbers of wrong rays as the section.
        let found = record.explanation.unwrap();
        let last = record.rows.last().unwrap();
        for (set, trace) in found.scenes[0].sets.iter().zip(&last.traces) {
            let wrong = match &trace.judgement {
                Judgement::Closest(closest) => closest.classes.tight.wrong(),
                Judgement::Any(any) => any.occlusion.false_free + any.occlusion.false_occluded,
            };
            assert_eq!(wrong, set.left(), "{}", set.rays);
        }
        found
    };
    let found = explain(&request.registration.remedies);
    assert!(found.unexplained() == 0 && !found.judged);
    let sets = &found.scenes[0].sets;
    assert_eq!(sets.len(), 3);
    assert!(sets[0].wrong_by_remedy[0] > 0, "nothing to explain");
    for set in sets {
        let explained: u64 = found.causes().iter().map(|cause| set.of_cause(cause)).sum();
        assert_eq!(explained, set.wrong_by_remedy[0], "{}", set.rays);
        assert_eq!(set.of_cause(UNEXPLAINED), 0);
    }
    // Rays that the last step gives up are told from those that it gets wrong.
    let steps_of = |value: &str| {
        let [cause, parameter, value] = ["nothing", "max_steps", value].map(str::to_owned);
        RemedyRecord { cause, parameter, value, source: String::new() }
    };
    let capped = steps_of("1");
    let capped = explain(&[capped]);
    assert!(capped.unexplained() == 0 && capped.scenes[0].sets[0].wrong_by_remedy[1] > 1000);
    let idle = steps_of("4096");
    let idle = explain(&[idle]);
    assert_eq!(idle.unexplained(), found.scenes[0].sets.iter().map(|set| set.wrong_by_remedy[0]).sum::<u64>());
    assert_eq!(idle.scenes[0].sets[0].of_cause(UNEXPLAINED), sets[0].wrong_by_remedy[0]);
}

/// Of methods that sample the judge tells what their remedy sequences leave: the same number of every cause as it tells of the last step's
/// row, but for those rays that were right at first; so that no set has more than the share that may be unexplained.
#[test]
fn the_judge_explains_what_ladders_of_sampled_methods_leave() {
    let sampled = |each: &&registry::Registration| !each.is_analytic() && !each.remedies.is_empty();
    let names: Vec<&str> = registry::TRACERS.iter().filter(sampled).map(registry::Registration::name).collect();
    assert_eq!(names, ["fragment-abuffer", "voxel-abuffer", "voxel-octree", "quadtree"]);
    // Side by side: none keeps all cores busy.
    std::thread::scope(|scope| {
        let found: Vec<_> =
            names.into_iter().map(|name| scope.spawn(move || judge_explains_what_is_left(name))).collect();
        found.into_iter().for_each(|found| found.join().unwrap());
    });
}

fn judge_explains_what_is_left(name: &str) {
    let device: Device = Gpu::open(&AdapterChoice::default()).map(std::sync::Arc::new);
    let (cache, quiet, journal) = (Cache::none(), Progress::new(true), Journal::none());
    let context = Context::new(&device, &cache, &quiet, &journal);
    let request = TracerRequest::of(registry::find(name).unwrap(), Preset::Published);
    let remedies = &request.registration.remedies;
    let record = execute(&in_the_room(&request, &["ao", "random"]), &request, remedies, &context).unwrap();
    let found = record.explanation.unwrap();
    assert!(found.judged && found.left_open().is_empty(), "{name}");
    let of_steps: Vec<&str> = remedies.iter().map(|remedy| remedy.cause.as_str()).collect();
    let mut of_all = 0;
    for (set, trace) in found.scenes[0].sets.iter().zip(&record.rows.last().unwrap().traces) {
        let causes = trace.judgement.causes();
        let of_row = causes.get("tight").or_else(|| causes.get("occlusion")).unwrap();
        assert_eq!(of_row.values().sum::<u64>(), set.left(), "{name}, {}", set.rays);
        assert_eq!(of_row.get(UNEXPLAINED).copied().unwrap_or(0), set.unexplained, "{name}, {}", set.rays);
        let (mut explained, mut by_judge) = (0, 0);
        for cause in found.causes() {
            explained += set.of_cause(cause);
            if !of_steps.contains(&cause) {
                by_judge += set.of_cause(cause);
                let most = of_row.get(cause).copied().unwrap_or(0);
                assert!(set.of_cause(cause) <= most, "{name}, {}: {cause}", set.rays);
            }
        }
        assert_eq!(explained, set.wrong_by_remedy[0], "{name}, {}", set.rays);
        assert!(by_judge < explained, "{name}, {}: {by_judge} of {explained}", set.rays);
        of_all += by_judge;
    }
    // Planes over all three images may leave nothing wrong here that the judge would have to explain.
    assert!(of_all > 0 || name == "voxel-abuffer", "{name}");
    // Where more than the share is unexplained, or any at all of a method that does not sample, it is told of which set.
    let opened = |judged, unexplained| {
        let mut found = ExplanationRecord { judged, ..found.clone() };
        found.scenes[0].sets.iter_mut().for_each(|set| set.unexplained = 0);
        found.scenes[0].sets[0].unexplained = unexplained;
        found.left_open().into_iter().map(|(scene, set)| (scene.to_owned(), set.rays.clone())).collect::<Vec<_>>()
    };
    let (first, share) = (vec![("room".to_owned(), "ao".to_owned())], found.scenes[0].sets[0].count / 50);
    assert_eq!((opened(true, share), opened(true, share + 1)), (Vec::new(), first.clone()));
    assert_eq!((opened(false, 0), opened(false, 1)), (Vec::new(), first));
}
