//! Ambiguous rays: several answers are right, and no other.

use super::*;

/// A ray onto the plate whose true hits are at 2 and 3 of triangle 1 and at 3.5 of triangle 0; with a miss among them if it may.
fn ambiguous(may_miss: bool) -> Case {
    let mut case = one();
    let moved = [Some((3.0, 1)), Some((3.5, 0)), None];
    make_ambiguous(&mut case.answers[0], if may_miss { &moved } else { &moved[..2] });
    case
}

/// Proves each class of an ambiguous ray under each rule, by hand: right is what is within the tolerance of one true answer, or between two
/// t of one triangle; what is not is early or late by the nearest, and a miss is right only if a true answer is one.
#[test]
fn classes_of_ambiguous_rays() {
    use Class::{Early, FalseMiss, Late, TrueHit, TrueMiss};
    for may_miss in [false, true] {
        let case = ambiguous(may_miss);
        // Within `tight` (2.1e-4 to 3.6e-4) or a reference pixel (4e-3 to 7e-3) of one of them, and between two of triangle 1.
        for t in [2.0, 1.9998, 2.4, 2.9, 3.0, 3.0002, 3.5, 3.4998] {
            assert_eq!(classes(&case, hit(t)), [TrueHit; 3], "{t}");
        }
        assert_eq!(classes(&case, hit(1.998)), [TrueHit, Early, TrueHit]);
        assert_eq!(classes(&case, hit(3.502)), [TrueHit, Late, TrueHit]);
        // Between t of two triangles nothing is.
        for (t, class) in [(1.9, Early), (3.2, Late), (3.3, Early), (3.6, Late), (77.0, Late), (0.0, Early)] {
            assert_eq!(classes(&case, hit(t)), [TrueHit, class, class], "{t}");
        }
        assert_eq!(classes(&case, miss()), [if may_miss { TrueMiss } else { FalseMiss }; 3]);
    }
}

/// Proves that a ray that misses itself and may hit when it is moved is judged by what it may hit.
#[test]
fn a_miss_that_may_hit() {
    let mut case = Case::new(framed(plate()), vec![down(3.0, 0.5, 2.0)], Query::Closest);
    make_ambiguous(&mut case.answers[0], &[Some((4.0, 1)), Some((5.0, 1))]);
    assert_eq!(classes(&case, miss()), [Class::TrueMiss; 3]);
    assert_eq!(classes(&case, hit(4.5)), [Class::TrueHit; 3]);
    assert_eq!(classes(&case, hit(77.0)), [Class::TrueHit, Class::Late, Class::Late]);
    let judged = case.closest(&[hit(77.0)]);
    let wrong = &judged.wrong_rays[0];
    assert_eq!(
        (wrong.true_t, wrong.true_primitive, wrong.class.as_str(), wrong.ambiguous),
        (Some(5.0), Some(1), "late", true)
    );
    assert_eq!((judged.position_error.p50, judged.curve.last().unwrap()[1]), (Some(72.0), 0.0));
    assert_eq!(case.closest(&[hit(4.5)]).position_error.p50, Some(0.0));
}

/// Proves that a right answer to an ambiguous ray stays right, that t = 77 and a miss that no true answer is are wrong, with cause and
/// place in the list, in every share over all rays and in none without ambiguous ones, and that intervals are over all.
#[test]
fn wrong_answers_to_ambiguous_rays_are_wrong() {
    let mut case = hundred(Query::Closest);
    make_ambiguous(&mut case.answers[5], &[Some((3.0, 0))]);
    make_ambiguous(&mut case.answers[70], &[Some((4.0, 0))]);
    let mut hits = case.right();
    let right = case.closest(&hits);
    assert_eq!((right.ambiguous_rays, right.many_ambiguous_rays, right.agreement.tight), (2, true, Some(1.0)));
    assert_eq!((right.classes.tight.true_hit, right.classes.tight.true_miss), (60, 40));
    // The other true answers.
    (hits[5], hits[70]) = (hit(3.0), hit(4.0));
    let other = case.closest(&hits);
    assert_eq!((&other.agreement, &other.truth), (&right.agreement, &right.truth));
    assert_eq!((other.classes.tight.true_hit, other.classes.tight.true_miss), (61, 39));
    (hits[5], hits[70]) = (miss(), hit(77.0));
    let judged = case.closest(&hits);
    let all = &judged.agreement;
    assert_eq!([all.hit_miss, all.tight, all.footprint], [Some(0.99), Some(0.98), Some(0.98)]);
    let without = judged.agreement_without_ambiguous.unwrap();
    assert_eq!([without.hit_miss, without.tight, without.footprint], [Some(1.0); 3]);
    assert_eq!((judged.classes.tight.false_miss, judged.classes.tight.late), (1, 1));
    // Wilson's of 98 of 100.
    let [low, high] = judged.interval.tight.unwrap();
    assert!((low - 0.9300).abs() < 1e-4 && (high - 0.9945).abs() < 1e-4, "{low} {high}");
    let found: Vec<(u64, bool)> = judged.wrong_rays.iter().map(|wrong| (wrong.index, wrong.ambiguous)).collect();
    assert_eq!(found, [(5, true), (70, true)]);
    for rule in ["tight", "footprint"] {
        assert_eq!(judged.causes[rule].values().sum::<u64>(), 2, "{rule}");
    }
    // 77 is more than a diagonal off.
    assert_eq!(judged.curve.last().map(|point| point[1]), Some(0.98));
    assert_eq!(case.judge().classes(Rule::Tight, &hits).unwrap().iter().flatten().count(), 100);
}

/// Proves by real rays along the edge of a plate before a wall, all ambiguous, that who always misses is always wrong, and along an edge
/// before nothing, where a miss is right, that who hits far behind is; that a set of ambiguous rays has a share over all of them and none
/// without them; and that who answers either side of the edge is right.
#[test]
fn sets_of_ambiguous_rays_alone() {
    let wall = rectangle([-3.0, -3.0, -1.0], [6.0, 0.0, 0.0], [0.0, 6.0, 0.0]);
    let along = |index: i32| down(1.0, index as f32 / 64.0, 2.0);
    let before_wall =
        Case::new(framed([plate(), wall.to_vec()].concat()), (-40..40).map(along).collect(), Query::Closest);
    let alone = Case::new(framed(plate()), (-40..40).map(along).collect(), Query::Closest);
    for case in [&before_wall, &alone] {
        assert!(case.answers.iter().all(Answer::is_ambiguous));
        let judged = case.closest(&case.right());
        assert_eq!((judged.ambiguous_rays, judged.agreement.tight), (80, Some(1.0)));
        assert_eq!(judged.agreement_without_ambiguous.unwrap().tight, None);
    }
    let tight = |case: &Case, hit: Hit| case.closest(&[hit; 80]).agreement.tight;
    assert_eq!(
        [miss(), hit(2.0), hit(3.0), hit(77.0)].map(|hit| tight(&before_wall, hit)),
        [Some(0.0), Some(1.0), Some(1.0), Some(0.0)]
    );
    assert_eq!(
        [miss(), hit(2.0), hit(3.0), hit(77.0)].map(|hit| tight(&alone, hit)),
        [Some(1.0), Some(1.0), Some(0.0), Some(0.0)]
    );
    for (case, share) in [(before_wall, 0.0), (alone, 1.0)] {
        let judged = Judgement::Closest(case.closest(&[miss(); 80]));
        Control::AlwaysMiss.check(&judged, &true_counts(&case.answers)).unwrap();
        let Judgement::Closest(closest) = judged else { unreachable!() };
        assert_eq!(closest.agreement.hit_miss, Some(share));
    }
}

/// Proves that ambiguous any-hit rays, where both answers are right, are in no count, share, cause or list, that they are counted, and that
/// a set of them alone has no share; and that more than a thousandth of them is said.
#[test]
fn ambiguous_any_hit_rays_are_left_out() {
    let mut case = hundred(Query::Any);
    make_ambiguous(&mut case.answers[5], &[None]);
    make_ambiguous(&mut case.answers[70], &[Some((4.0, 0))]);
    let mut hits = case.right();
    let right = case.any(&hits);
    (hits[5], hits[70]) = (miss(), hit(77.0));
    assert_eq!(case.any(&hits), right);
    assert_eq!(
        (right.ambiguous_rays, right.many_ambiguous_rays, right.occlusion.balanced_accuracy),
        (2, true, Some(1.0))
    );
    assert_eq!((right.occlusion.true_occluded, right.occlusion.true_free), (59, 39));
    let classes = case.judge().classes(Rule::Tight, &hits).unwrap();
    assert_eq!((classes[5], classes[70], classes.iter().flatten().count()), (None, None, 98));
    case.answers.iter_mut().for_each(|answer| make_ambiguous(answer, &[None]));
    let none = case.any(&hits);
    assert_eq!(
        (none.ambiguous_rays, none.occlusion.balanced_accuracy, none.occlusion.balanced_accuracy_interval),
        (100, None, None)
    );
    // One in a thousand is not yet many.
    let mut case = Case::new(framed(plate()), vec![down(0.25, 0.5, 2.0); 1000], Query::Closest);
    make_ambiguous(&mut case.answers[0], &[None]);
    assert!(!case.closest(&case.right()).many_ambiguous_rays);
    make_ambiguous(&mut case.answers[1], &[None]);
    assert!(case.closest(&case.right()).many_ambiguous_rays);
}

/// Proves that records of before ambiguous rays were judged read as they were: their shares leave these out, and what is written has no
/// field that it lacks.
#[test]
fn older_judgements_leave_ambiguous_rays_out() {
    let mut case = hundred(Query::Closest);
    make_ambiguous(&mut case.answers[5], &[None]);
    let now = Judgement::Closest(case.closest(&case.right()));
    assert_eq!((now.ambiguous(), now.left_out(), now.has_ambiguous()), (1, 0, true));
    let mut older = serde_json::to_value(&now).unwrap();
    for field in ["truth", "agreement_without_ambiguous"] {
        assert!(older.as_object_mut().unwrap().remove(field).is_some(), "{field}");
    }
    let read: Judgement = serde_json::from_value(older.clone()).unwrap();
    assert_eq!((read.ambiguous(), read.left_out(), read.has_ambiguous()), (1, 1, false));
    assert_eq!(serde_json::to_value(&read).unwrap(), older);
}
