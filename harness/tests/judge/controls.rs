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

/// Answers of a control to a hundred rays of which a few are ties, as the judge sees them.
fn controlled(control: Control, query: Query) -> (Judgement, u64, u64) {
    let mut case = hundred(query);
    case.answers[3].tie = true;
    case.answers[64].tie = true;
    let hits: Vec<Hit> = match control {
        Control::Oracle => case.right(),
        Control::AlwaysMiss => vec![miss(); 100],
        Control::Corrupted => corrupted_of(&case),
        Control::AlwaysHit => vec![Hit { primitive: NO_PRIMITIVE, ..hit((DIAGONAL / 2.0) as f32) }; 100],
    };
    let judge = Judge { names_primitives: control.description().names_primitives, ..case.judge() };
    (judge.judge(&hits).unwrap(), 59, 39)
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
            let (judgement, occluded, free) = controlled(control, query);
            control.check(&judgement, occluded, free).unwrap();
            let count = counts(&mut judgement.clone()).len();
            for slot in 0..count {
                let mut changed = judgement.clone();
                *counts(&mut changed)[slot] += 1;
                assert!(control.check(&changed, occluded, free).is_err(), "{control:?} {query:?} {slot}");
            }
            assert!(control.check(&judgement, occluded + 1, free).is_err());
            assert!(control.check(&judgement, occluded, free + 1).is_err());
            for other in Control::ALL.into_iter().filter(|other| *other != control) {
                let (theirs, ..) = controlled(other, query);
                let error = control.check(&theirs, occluded, free).unwrap_err();
                assert!(error.contains(control.description().name), "{error}");
            }
            let mut changed = judgement.clone();
            match &mut changed {
                Judgement::Closest(judgement) => judgement.agreement.hit_miss = Some(0.123),
                Judgement::Any(judgement) => judgement.occlusion.balanced_accuracy = Some(0.123),
            }
            assert!(control.check(&changed, occluded, free).is_err());
        }
    }
    let (mut judgement, occluded, free) = controlled(Control::Oracle, Query::Closest);
    let Judgement::Closest(closest) = &mut judgement else { panic!("closest was asked") };
    closest.identity = Some(0.98);
    assert!(Control::Oracle.check(&judgement, occluded, free).is_err());
}

/// Proves the controls over sets where truth knows one kind of ray, or nothing but ties.
#[test]
fn controls_of_one_kind() {
    for query in [Query::Closest, Query::Any] {
        for (x, occluded, free) in [(0.25, 8, 0), (3.0, 0, 8)] {
            for all_ties in [false, true] {
                let mut case = Case::new(framed(plate()), vec![down(x, 0.5, 2.0); 8], query);
                case.answers.iter_mut().for_each(|answer| answer.tie = all_ties);
                let (occluded, free) = if all_ties { (0, 0) } else { (occluded, free) };
                for control in Control::ALL {
                    let hits = match control {
                        Control::Oracle => case.right(),
                        Control::AlwaysMiss => vec![miss(); 8],
                        Control::Corrupted => corrupted_of(&case),
                        Control::AlwaysHit => vec![hit(6.0); 8],
                    };
                    let judgement = case.judge().judge(&hits).unwrap();
                    control.check(&judgement, occluded, free).unwrap();
                }
            }
        }
    }
}

/// Proves that the corrupted control is wrong with one of eight rays that hit and one of eight that miss, never with a tie, and
/// that one which is wrong with one ray more, or fewer, or another share does not pass for it.
#[test]
fn the_corrupted_share_is_known() {
    let mut case = hundred(Query::Closest);
    case.answers[3].tie = true;
    case.answers[64].tie = true;
    let wrong = corrupted(&case.answers);
    let of_kind = |is_hit: bool| {
        let both = wrong.iter().zip(&case.answers);
        both.filter(|(wrong, answer)| **wrong && answer.hit.is_some() == is_hit).count()
    };
    // Of 59 that hit and 39 that miss.
    assert_eq!((of_kind(true), of_kind(false)), (8, 5));
    assert!(!wrong[3] && !wrong[64]);
    let judge = Judge { names_primitives: true, ..case.judge() };
    let (hits, right) = (corrupted_of(&case), case.right());
    let said = |hits: &[Hit]| Control::Corrupted.check(&judge.judge(hits).unwrap(), 59, 39);
    said(&hits).unwrap();
    let wrong_at = wrong.iter().position(|wrong| *wrong).unwrap();
    let right_at = (0..100).find(|index| !wrong[*index] && !case.answers[*index].tie).unwrap();
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
