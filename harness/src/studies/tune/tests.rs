//! Choices over made-up scores.

use tracebench_api::{ClockKind, Query};

use super::*;
use crate::report::fixture::{self, Quality};
use crate::results::{Judgement, PerRule};

const VALUES: [&str; 4] = ["0", "0.1", "0.2", "0.3"];

/// Answers with given agreements by footprint; by the other rules it is the other way round. Of any-hit sets the balanced
/// accuracy.
fn judged(query: Query, share: Option<f64>) -> Judged {
    let quality = Quality { missed: 0.1, blur: 1e-4, speed: 1.0, clock: ClockKind::Host };
    let mut judged = fixture::run(&[("t", quality)], &[("rays", query)]).rows.remove(0).traces.remove(0);
    let turned = share.map(|share| 1.0 - share);
    match &mut judged.judgement {
        Judgement::Closest(closest) => {
            closest.agreement = PerRule { hit_miss: turned, tight: turned, footprint: share };
        }
        Judgement::Any(any) => any.occlusion.balanced_accuracy = share,
    }
    judged
}

/// A set with a score a value: `None` for one that could not be measured, `Some(None)` for nothing but ambiguous rays.
fn set(rays: &str, query: Query, scores: [Option<Option<f64>>; 4]) -> SetTuned {
    let value = |(value, score): (&str, Option<Option<f64>>)| ValueTuned {
        value: value.to_owned(),
        judged: score.map(|share| judged(query, share)),
        skipped: score.is_none().then(|| "too large".to_owned()),
    };
    let values = VALUES.into_iter().zip(scores).map(value).collect();
    SetTuned { rays: rays.to_owned(), rays_sha256: String::new(), query, count: 100, values, choices: Vec::new() }
}

fn plain(scores: [f64; 4]) -> SetTuned {
    set("diffuse", Query::Closest, scores.map(|score| Some(Some(score))))
}

/// A scene with a viewpoint for every list of sets.
fn scene(views: Vec<Vec<SetTuned>>) -> SceneTuned {
    let quality = Quality { missed: 0.1, blur: 1e-4, speed: 1.0, clock: ClockKind::Host };
    let row = fixture::run(&[("t", quality)], &[]).rows.remove(0);
    let view = |sets| ViewTuned { viewpoint: row.viewpoint.clone(), sets, controls: Vec::new() };
    SceneTuned { scene: row.scene.clone(), views: views.into_iter().map(view).collect() }
}

fn value_of(set: &SetTuned, label: Label) -> Option<&str> {
    set.choice(label).unwrap().value.as_deref()
}

fn tuned_here(set: SetTuned, rule: Rule) -> Option<String> {
    let mut scenes = [scene(vec![vec![set]])];
    choose(&mut scenes, "0.1", rule);
    value_of(&scenes[0].views[0].sets[0], Label::TunedHere).map(str::to_owned)
}

/// Proves that the best value is the one with the greatest score by the rule that is asked for, the smaller of equal ones, and
/// that what has no score (not measured, nothing but ambiguous rays, no number) is never it.
#[test]
fn the_best_value() {
    let some = |share: f64| Some(Some(share));
    for (scores, expected) in [
        ([some(0.1), some(0.7), some(0.9), some(0.8)], Some("0.2")),
        ([some(0.1), some(0.9), some(0.9), some(0.9)], Some("0.1")),
        ([some(0.9), some(0.9), some(0.1), some(0.9)], Some("0")),
        ([some(f64::NAN), some(0.2), some(f64::INFINITY), some(0.1)], Some("0.1")),
        ([None, Some(None), some(0.0), None], Some("0.2")),
        ([None, Some(None), None, some(f64::NAN)], None),
        ([None; 4], None),
    ] {
        for query in [Query::Closest, Query::Any] {
            let found = tuned_here(set("rays", query, scores), Rule::Footprint);
            assert_eq!(found.as_deref(), expected, "{scores:?}");
        }
    }
    // Of equal ones that nearest to 0, on whichever side.
    let two_sided = |scores: [f64; 4]| {
        let mut set = plain(scores);
        for (value, name) in set.values.iter_mut().zip(["-0.3", "-0.1", "0.2", "0.4"]) {
            name.clone_into(&mut value.value);
        }
        tuned_here(set, Rule::Footprint)
    };
    assert_eq!(two_sided([0.9; 4]).as_deref(), Some("-0.1"));
    assert_eq!(two_sided([0.9, 0.1, 0.9, 0.9]).as_deref(), Some("0.2"));
    assert_eq!(two_sided([0.9, 0.1, 0.8, 0.8]).as_deref(), Some("-0.3"));
    // By the other rules the shares are turned round; any-hit sets know one rule.
    let scores = [some(0.1), some(0.7), some(0.9), some(0.8)];
    for rule in [Rule::HitMiss, Rule::Tight] {
        assert_eq!(tuned_here(set("rays", Query::Closest, scores), rule).as_deref(), Some("0"));
        assert_eq!(tuned_here(set("rays", Query::Any, scores), rule).as_deref(), Some("0.2"));
    }
}

/// Proves which rays have a say in which label, and what is lost, on two scenes whose bests all differ: worked out by hand.
#[test]
fn labels_and_losses() {
    let own = plain([0.1, 0.2, 0.4, 0.3]);
    let other = plain([0.5, 0.6, 0.7, 0.9]);
    let else_where = [plain([0.8, 0.1, 0.1, 0.2]), plain([0.1, 0.9, 0.1, 0.1])];
    let [theirs, unasked] = else_where;
    // Another set of rays has no say.
    let ao = set("ao", Query::Any, [0.9, 0.1, 0.1, 0.1].map(|share| Some(Some(share))));
    let mut scenes = [scene(vec![vec![ao, own], vec![other]]), scene(vec![vec![theirs], vec![unasked]])];
    choose(&mut scenes, "0.1", Rule::Footprint);
    let labels = |set: &SetTuned| Label::ALL.map(|label| value_of(set, label).map(str::to_owned));
    let some = |values: [&str; 4]| values.map(|value| Some(value.to_owned()));
    let [first, second] = &scenes;
    // Default, here, elsewhere, on the other scenes' own viewpoints.
    assert_eq!(labels(&first.views[0].sets[1]), some(["0.1", "0.2", "0.3", "0"]));
    assert_eq!(labels(&first.views[1].sets[0]), some(["0.1", "0.3", "0.2", "0"]));
    assert_eq!(labels(&second.views[0].sets[0]), some(["0.1", "0", "0.1", "0.2"]));
    // `ao` is there once: from nowhere else, in no other scene.
    assert_eq!(labels(&first.views[0].sets[0]), [Some("0.1".into()), Some("0".into()), None, None]);
    let set = &first.views[0].sets[1];
    let lost = |of, to| set.choice(of).unwrap().lost_to.get(&to).copied();
    let near = |found: Option<f64>, expected: f64| found.is_some_and(|found| (found - expected).abs() < 1e-12);
    assert!(near(lost(Label::Default, Label::TunedHere), 0.2));
    assert!(near(lost(Label::TunedElsewhere, Label::TunedHere), 0.1));
    assert!(near(lost(Label::TunedHere, Label::TunedElsewhere), -0.1));
    assert!(near(lost(Label::TunedOnOtherScenes, Label::Default), 0.1));
    assert_eq!(lost(Label::Default, Label::Default), None);
    for view in scenes.iter().flat_map(|scene| &scene.views) {
        for choice in view.sets.iter().flat_map(|set| &set.choices) {
            // Nothing is better than what was tuned here, and nobody gains what the other does not lose.
            assert!(choice.lost_to.get(&Label::TunedHere).is_none_or(|lost| *lost >= 0.0), "{choice:?}");
        }
    }
}

/// Proves that a value chosen for other scenes must have been judged in all of them, that scenes in which nothing was judged
/// have no say, and that a choice which could not be measured here has no score and no loss.
#[test]
fn other_scenes_must_agree_on_something() {
    let some = |share: f64| Some(Some(share));
    let with = |scores| scene(vec![vec![set("diffuse", Query::Closest, scores)]]);
    // The second lacks the first's best; the mean of the rest is greatest at 0.2, not where either is greatest.
    let mut scenes = [
        with([some(0.1), some(0.1), None, some(0.2)]),
        with([some(0.9), some(0.1), some(0.5), some(0.6)]),
        with([None, some(0.7), some(0.5), some(0.2)]),
        with([Some(None); 4]),
    ];
    choose(&mut scenes, "0.3", Rule::Footprint);
    let set = &scenes[0].views[0].sets[0];
    let choice = set.choice(Label::TunedOnOtherScenes).unwrap();
    assert_eq!((choice.value.as_deref(), choice.score, choice.lost_to.len()), (Some("0.2"), None, 0));
    assert!(set.choice(Label::Default).unwrap().lost_to.keys().eq([&Label::TunedHere]), "{set:?}");
    // Of the all but judged scene neither default nor any other has a score, and there is something to choose all the same.
    let nothing = &scenes[3].views[0].sets[0];
    assert_eq!(
        (value_of(nothing, Label::TunedHere), value_of(nothing, Label::TunedOnOtherScenes)),
        (None, Some("0.3"))
    );
    let mut alone = [with([some(0.1); 4])];
    choose(&mut alone, "0.3", Rule::Footprint);
    assert_eq!(value_of(&alone[0].views[0].sets[0], Label::TunedOnOtherScenes), None);
    assert_eq!(value_of(&alone[0].views[0].sets[0], Label::TunedElsewhere), None);
}
