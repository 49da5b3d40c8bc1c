//! The controls, and what they must not score.

use super::*;

/// Answers of the truth, wrong where the corrupted control's are.
fn corrupted_of(case: &Case) -> Vec<Hit> {
    let wrong = corrupted(&case.answers);
    let answer = |(right, wrong): (Hit, bool)| match (wrong, right.is_hit()) {
        (false, _) => right,
        (true, true) => miss(),
        (true, false) => Hit { primitive: NO_PRIMITIVE, ..hit((DIAGONAL / 2.0) as f32) },
    };
    case.right().into_iter().zip(wrong).map(answer).collect()
}

/// A hundred rays of which three are ambiguous: one that hits and may miss, one that hits either near or far, one that misses and may
/// hit; and what the truth says of them, counted by hand.
fn hundred_with_ambiguous(query: Query) -> (Case, TrueCounts) {
    let mut case = hundred(query);
    make_ambiguous(&mut case.answers[3], &[None]);
    make_ambiguous(&mut case.answers[10], &[Some((3.0, 0))]);
    make_ambiguous(&mut case.answers[64], &[Some((4.0, 0))]);
    let counts = TrueCounts { hits: 58, misses: 39, ambiguous_hits: 2, ambiguous_misses: 1, ambiguous_may_miss: 2 };
    assert_eq!(true_counts(&case.answers), counts);
    (case, counts)
}

/// Answers of a control to these, as the judge sees them.
fn controlled(control: Control, query: Query) -> (Judgement, TrueCounts) {
    let (case, counts) = hundred_with_ambiguous(query);
    let hits: Vec<Hit> = match control {
        Control::Oracle => case.right(),
        Control::AlwaysMiss => vec![miss(); 100],
        Control::Corrupted => corrupted_of(&case),
        Control::AlwaysHit => vec![Hit { primitive: NO_PRIMITIVE, ..hit((DIAGONAL / 2.0) as f32) }; 100],
    };
    let judge = Judge { names_primitives: control.description().names_primitives, ..case.judge() };
    (judge.judge(&hits).unwrap(), counts)
}

/// Every single count of a verdict, to be changed.
fn counts(judgement: &mut Judgement) -> Vec<&mut u64> {
    match judgement {
        Judgement::Closest(judgement) => [&mut judgement.classes.tight, &mut judgement.classes.footprint]
            .into_iter()
            .flat_map(|classes| {
                let Classes { true_hit, true_miss, false_hit, false_miss, early, late } = classes;
                [true_hit, true_miss, false_hit, false_miss, early, late]
            })
            .collect(),
        Judgement::Any(judgement) => {
            let table = &mut judgement.occlusion;
            vec![&mut table.true_occluded, &mut table.true_free, &mut table.false_occluded, &mut table.false_free]
        }
    }
}

/// Proves that each control passes on its own answers, and, as a negative control, that it fails as soon as one count,
/// agreement or other control's answers are put in the place of its own.
#[test]
fn controls_pass_and_fail() {
    for query in [Query::Closest, Query::Any] {
        for control in Control::ALL {
            let (judgement, truth) = controlled(control, query);
            control.check(&judgement, &truth).unwrap();
            let count = counts(&mut judgement.clone()).len();
            for slot in 0..count {
                let mut changed = judgement.clone();
                *counts(&mut changed)[slot] += 1;
                assert!(control.check(&changed, &truth).is_err(), "{control:?} {query:?} {slot}");
            }
            let is_refused = |counts: TrueCounts| control.check(&judgement, &counts).is_err();
            assert!(is_refused(TrueCounts { hits: 59, ..truth.clone() }));
            assert!(is_refused(TrueCounts { misses: 40, ..truth.clone() }));
            // Ambiguous rays count where they can be wrong.
            let counted = query == Query::Closest;
            assert_eq!(is_refused(TrueCounts { ambiguous_hits: 3, ..truth.clone() }), counted);
            assert_eq!(is_refused(TrueCounts { ambiguous_misses: 2, ..truth.clone() }), counted);
            let may_miss = TrueCounts { ambiguous_may_miss: 3, ..truth.clone() };
            assert_eq!(is_refused(may_miss), counted && control == Control::AlwaysMiss);
            for other in Control::ALL.into_iter().filter(|other| *other != control) {
                let (theirs, ..) = controlled(other, query);
                let error = control.check(&theirs, &truth).unwrap_err();
                assert!(error.contains(control.description().name), "{error}");
            }
            let mut changed = judgement.clone();
            match &mut changed {
                Judgement::Closest(judgement) => judgement.agreement.hit_miss = Some(0.123),
                Judgement::Any(judgement) => judgement.occlusion.balanced_accuracy = Some(0.123),
            }
            assert!(control.check(&changed, &truth).is_err());
            let mut changed = judgement;
            if let Judgement::Closest(judgement) = &mut changed {
                judgement.agreement_without_ambiguous.as_mut().unwrap().hit_miss = Some(0.123);
                assert!(control.check(&changed, &truth).is_err());
            }
        }
    }
    let (mut judgement, truth) = controlled(Control::Oracle, Query::Closest);
    let Judgement::Closest(closest) = &mut judgement else { panic!("closest was asked") };
    closest.identity = Some(0.98);
    assert!(Control::Oracle.check(&judgement, &truth).is_err());
}

/// Proves the controls over sets where truth knows one kind of ray, or ambiguous ones alone.
#[test]
fn controls_of_one_kind() {
    for query in [Query::Closest, Query::Any] {
        for (x, other) in [(0.25, None), (0.25, Some((3.0, 0))), (3.0, Some((2.0, 0)))] {
            for all_ambiguous in [false, true] {
                let mut case = Case::new(framed(plate()), vec![down(x, 0.5, 2.0); 8], query);
                if all_ambiguous {
                    case.answers.iter_mut().for_each(|answer| make_ambiguous(answer, &[other]));
                }
                let truth = true_counts(&case.answers);
                for control in Control::ALL {
                    let hits = match control {
                        Control::Oracle => case.right(),
                        Control::AlwaysMiss => vec![miss(); 8],
                        Control::Corrupted => corrupted_of(&case),
                        Control::AlwaysHit => vec![hit(6.0); 8],
                    };
                    let judgement = case.judge().judge(&hits).unwrap();
                    control.check(&judgement, &truth).unwrap();
                }
            }
        }
    }
}

/// Proves that the corrupted control is wrong with one of eight rays that hit and one of eight that miss, never with an ambiguous one, and
/// that one which is wrong with one ray more, or fewer, or another share does not pass for it.
#[test]
fn the_corrupted_share_is_known() {
    let (case, truth) = hundred_with_ambiguous(Query::Closest);
    let wrong = corrupted(&case.answers);
    let of_kind = |is_hit: bool| {
        let both = wrong.iter().zip(&case.answers);
        both.filter(|(wrong, answer)| **wrong && answer.hit.is_some() == is_hit).count()
    };
    // Of 58 that hit and 39 that miss.
    assert_eq!((of_kind(true), of_kind(false)), (8, 5));
    assert!(!wrong[3] && !wrong[10] && !wrong[64]);
    let judge = Judge { names_primitives: true, ..case.judge() };
    let (hits, right) = (corrupted_of(&case), case.right());
    let said = |hits: &[Hit]| Control::Corrupted.check(&judge.judge(hits).unwrap(), &truth);
    said(&hits).unwrap();
    let wrong_at = wrong.iter().position(|wrong| *wrong).unwrap();
    let right_at = (0..100).find(|index| !wrong[*index] && !case.answers[*index].is_ambiguous()).unwrap();
    let mut fewer = hits.clone();
    fewer[wrong_at] = right[wrong_at];
    let mut more = hits.clone();
    more[right_at] = if right[right_at].is_hit() { miss() } else { hit(6.0) };
    assert!(said(&fewer).is_err() && said(&more).is_err() && said(&right).is_err());
}

/// Proves that the diagonal that tolerances rest on is the one the tests assume.
#[test]
fn the_test_scene_has_the_diagonal_it_claims() {
    assert_eq!(framed(plate()).diagonal(), DIAGONAL);
    assert!(Geometry::new(vec![[0.0; 3]], Vec::new(), None).is_err());
}
