//! That causes are told from rungs, that the ladder of `dirt` explains every wrong ray of a scene, and that a ladder which
//! takes nothing away explains none.

use super::*;
use crate::plan::{RunPreset, SceneSource, ViewRequest};
use crate::rays::{RAY_SETS, default_parameters};
use crate::registry;
use tracebench_api::{AdapterChoice, EndPoint, Gpu, Preset};

/// Every ladder is of a tracer that there is, and its remedies are parameters with such values, none the published one.
#[test]
fn remedies_are_parameters() {
    for ladder in LADDERS {
        let request = TracerRequest::of(registry::find(ladder.tracer).unwrap(), Preset::Published);
        let rungs = rungs(&request, ladder).unwrap();
        assert_eq!(rungs.len(), ladder.remedies.len() + 1);
        assert!(rungs.windows(2).all(|pair| pair[0] != pair[1]));
    }
    assert!(ladder_of("no-such").is_none());
}

/// A ray's cause is what the rung takes away from which on it is right, whatever it was before.
#[test]
fn the_last_wrong_rung_tells_the_cause() {
    let ladder = ladder_of("dirt").unwrap();
    let of = |wrong: [bool; 5]| cause(ladder, &wrong);
    assert_eq!(of([false; 5]), None);
    assert_eq!(of([true, false, false, false, false]), Some("early_bucket_stop"));
    assert_eq!(of([true, true, false, false, false]), Some("pixel_acceptance"));
    assert_eq!(of([true, false, true, false, false]), Some("projection_noise_at_centre"));
    assert_eq!(of([false, false, false, true, false]), Some("near_plane"));
    assert_eq!(of([true; 5]), Some(UNEXPLAINED));
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
    let explain =
        |ladder: &Ladder| execute(&plan, &request, ladder, &device, &Cache::none(), &Progress::new(true)).unwrap();
    let found = explain(ladder_of("dirt").unwrap());
    assert_eq!(found.left(), 0);
    let sets = &found.scenes[0].sets;
    assert_eq!(sets.len(), 3);
    assert!(sets[0].wrong_by_rung[0] > 0, "nothing to explain");
    for set in sets {
        let explained: u64 = found.causes().iter().map(|cause| set.of_cause(cause)).sum();
        assert_eq!(explained, set.wrong_by_rung[0], "{}", set.rays);
        assert_eq!(set.of_cause(UNEXPLAINED), 0);
    }
    const IDLE: Remedy = Remedy { cause: "nothing", parameter: "max_steps", value: "4096", source: "" };
    let idle = explain(&Ladder { tracer: "dirt", remedies: &[IDLE] });
    assert_eq!(idle.left(), found.scenes[0].sets.iter().map(|set| set.wrong_by_rung[0]).sum::<u64>());
    assert_eq!(idle.scenes[0].sets[0].of_cause(UNEXPLAINED), sets[0].wrong_by_rung[0]);
}
