//! Choices over made-up scores.

use tracebench_api::{ClockKind, Query};

use super::*;
use crate::report::fixture::{self, Quality};
use crate::results::PerRule;

const VALUES: [&str; 4] = ["0", "0.1", "0.2", "0.3"];
const QUALITY: Quality = Quality { missed: 0.1, blur: 1e-4, speed: 1.0, clock: ClockKind::Host };

/// Answers with given agreements by footprint; by the other rules it is the other way round. Of any-hit sets the balanced
/// accuracy.
fn judged(query: Query, share: Option<f64>) -> TraceRecord {
    let mut judged = fixture::run(&[("t", QUALITY)], &[("rays", query)]).rows.remove(0).traces.remove(0);
    let turned = share.map(|share| 1.0 - share);
    match &mut judged.judgement {
        Judgement::Closest(closest) => {
            closest.agreement = PerRule { hit_miss: turned, tight: turned, footprint: share };
        }
        Judgement::Any(any) => any.occlusion.balanced_accuracy = share,
    }
    judged
}

/// A set in its scene, from a viewpoint of it, of which the first is its own.
struct Set {
    scene: SceneRecord,
    viewpoint: ViewpointRecord,
    is_own: bool,
    rays: TraceRecord,
    traces: Vec<Option<TraceRecord>>,
}

/// One with a score a value: `None` for one that could not be measured, `Some(None)` for nothing but ambiguous rays.
fn set((scene, view): (&str, usize), rays: &str, query: Query, scores: [Option<Option<f64>>; 4]) -> Set {
    let row = fixture::run(&[("t", QUALITY)], &[]).rows.remove(0);
    let trace = |share| TraceRecord { rays: rays.to_owned(), ..judged(query, share) };
    Set {
        scene: SceneRecord { name: scene.to_owned(), ..row.scene },
        viewpoint: ViewpointRecord { name: view.to_string(), ..row.viewpoint },
        is_own: view == 0,
        rays: trace(None),
        traces: scores.map(|score| score.map(&trace)).into(),
    }
}

fn plain(place: (&str, usize), scores: [f64; 4]) -> Set {
    set(place, "diffuse", Query::Closest, scores.map(|score| Some(Some(score))))
}

/// The sets with their choices.
fn tuned<'a>(sets: &'a [Set], values: &[&'a str; 4], default: &'a str, rule: Rule) -> Vec<SetTuned<'a>> {
    let tuned = |Set { scene, viewpoint, is_own, rays, traces }: &'a Set| SetTuned {
        scene,
        viewpoint,
        is_own: *is_own,
        rays,
        rule,
        values: values.iter().copied().zip(traces.iter().map(Option::as_ref)).collect(),
        chosen: [None; Label::ALL.len()],
    };
    let mut tuned: Vec<SetTuned<'_>> = sets.iter().map(tuned).collect();
    choose(&mut tuned, default);
    tuned
}

fn tuned_here(set: Set, values: [&str; 4], rule: Rule) -> Option<String> {
    tuned(&[set], &values, "0.1", rule)[0].chosen(Label::TunedHere).map(str::to_owned)
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
            let found = tuned_here(set(("room", 0), "rays", query, scores), VALUES, Rule::Footprint);
            assert_eq!(found.as_deref(), expected, "{scores:?}");
        }
    }
    // Of equal ones that nearest to 0, on whichever side.
    let two_sided =
        |scores: [f64; 4]| tuned_here(plain(("room", 0), scores), ["-0.3", "-0.1", "0.2", "0.4"], Rule::Footprint);
    assert_eq!(two_sided([0.9; 4]).as_deref(), Some("-0.1"));
    assert_eq!(two_sided([0.9, 0.1, 0.9, 0.9]).as_deref(), Some("0.2"));
    assert_eq!(two_sided([0.9, 0.1, 0.8, 0.8]).as_deref(), Some("-0.3"));
    // By the other rules the shares are turned round; any-hit sets know one rule.
    let scores = [some(0.1), some(0.7), some(0.9), some(0.8)];
    for rule in [Rule::HitMiss, Rule::Tight] {
        let here = |query| tuned_here(set(("room", 0), "rays", query, scores), VALUES, rule);
        assert_eq!([Query::Closest, Query::Any].map(here), [Some("0".to_owned()), Some("0.2".to_owned())]);
    }
}

/// Proves which rays have a say in which label, and what is lost, on two scenes whose bests all differ: worked out by hand.
#[test]
fn labels_and_losses() {
    // Another set of rays has no say.
    let ao = set(("room", 0), "ao", Query::Any, [0.9, 0.1, 0.1, 0.1].map(|share| Some(Some(share))));
    let sets = [
        ao,
        plain(("room", 0), [0.1, 0.2, 0.4, 0.3]),
        plain(("room", 1), [0.5, 0.6, 0.7, 0.9]),
        plain(("hall", 0), [0.8, 0.1, 0.1, 0.2]),
        plain(("hall", 1), [0.1, 0.9, 0.1, 0.1]),
    ];
    let sets = tuned(&sets, &VALUES, "0.1", Rule::Footprint);
    let values = |set: &SetTuned<'_>| Label::ALL.map(|label| set.chosen(label).map(str::to_owned));
    let some = |values: [&str; 4]| values.map(|value| Some(value.to_owned()));
    // Default, here, elsewhere, on the other scenes' own viewpoints.
    assert_eq!(values(&sets[1]), some(["0.1", "0.2", "0.3", "0"]));
    assert_eq!(values(&sets[2]), some(["0.1", "0.3", "0.2", "0"]));
    assert_eq!(values(&sets[3]), some(["0.1", "0", "0.1", "0.2"]));
    // `ao` is there once: from nowhere else, in no other scene.
    assert_eq!(values(&sets[0]), [Some("0.1".into()), Some("0".into()), None, None]);
    let lost = |of, to| sets[1].lost(sets[1].chosen(of)?, to);
    let near = |found: Option<f64>, expected: f64| found.is_some_and(|found| (found - expected).abs() < 1e-12);
    assert!(near(lost(Label::Default, Label::TunedHere), 0.2));
    assert!(near(lost(Label::TunedElsewhere, Label::TunedHere), 0.1));
    assert!(near(lost(Label::TunedHere, Label::TunedElsewhere), -0.1));
    assert!(near(lost(Label::TunedOnOtherScenes, Label::Default), 0.1));
    assert_eq!(lost(Label::Default, Label::Default), Some(0.0));
    assert!(sets[1].labels("0.2").eq([Label::TunedHere]) && sets[1].labels("0.4").next().is_none());
    // Nothing is better than what was tuned here.
    for set in &sets {
        let lost = |value: &str| set.lost(value, Label::TunedHere);
        assert!(VALUES.into_iter().filter_map(lost).all(|lost| lost >= 0.0), "{set:?}");
    }
}

/// Proves that a value chosen for other scenes must have been judged in all of them, that scenes in which nothing was judged
/// have no say, and that a choice which could not be measured here has no score and no loss.
#[test]
fn other_scenes_must_agree_on_something() {
    let some = |share: f64| Some(Some(share));
    let with = |scene, scores| set((scene, 0), "diffuse", Query::Closest, scores);
    // The second lacks the first's best; the mean of the rest is greatest at 0.2, not where either is greatest.
    let sets = [
        with("room", [some(0.1), some(0.1), None, some(0.2)]),
        with("hall", [some(0.9), some(0.1), some(0.5), some(0.6)]),
        with("lawn", [None, some(0.7), some(0.5), some(0.2)]),
        with("void", [Some(None); 4]),
    ];
    let tuned_sets = tuned(&sets, &VALUES, "0.3", Rule::Footprint);
    let [first, .., nothing] = &tuned_sets[..] else { panic!("{tuned_sets:?}") };
    let value = first.chosen(Label::TunedOnOtherScenes).unwrap();
    let lost = Label::ALL.map(|label| first.lost(value, label));
    assert_eq!((value, first.score(value), lost), ("0.2", None, [None; 4]));
    // The default is measured here, and to what is not nothing is lost.
    let lost = Label::ALL.map(|label| first.lost("0.3", label).is_some());
    assert_eq!(lost, [true, true, false, false]);
    // Of the all but judged scene neither default nor any other has a score, and there is something to choose all the same.
    assert_eq!((nothing.chosen(Label::TunedHere), nothing.chosen(Label::TunedOnOtherScenes)), (None, Some("0.3")));
    let alone = tuned(&sets[..1], &VALUES, "0.3", Rule::Footprint);
    assert_eq!(alone[0].chosen(Label::TunedOnOtherScenes), None);
    assert_eq!(alone[0].chosen(Label::TunedElsewhere), None);
}
