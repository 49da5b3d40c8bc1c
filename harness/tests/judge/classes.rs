//! Classes, tolerances, shares, curves, identity.

use super::*;

/// Proves each class under each rule for a ray that hits: right, missed, too near and too far by more than a pixel.
#[test]
fn classes_of_a_ray_that_hits() {
    use Class::{Early, FalseMiss, Late, TrueHit};
    let case = one();
    assert_eq!(case.answers[0].hit.map(|hit| (hit.t, hit.primitive)), Some((2.0, 1)));
    assert!(!case.answers[0].is_ambiguous());
    assert_eq!(classes(&case, hit(2.0)), [TrueHit, TrueHit, TrueHit]);
    assert_eq!(classes(&case, hit(1.9)), [TrueHit, Early, Early]);
    assert_eq!(classes(&case, hit(2.1)), [TrueHit, Late, Late]);
    assert_eq!(classes(&case, hit(2.002)), [TrueHit, Late, TrueHit]);
    assert_eq!(classes(&case, hit(1.998)), [TrueHit, Early, TrueHit]);
    assert_eq!(classes(&case, hit(0.0)), [TrueHit, Early, Early]);
    for status in [Status::Miss, Status::LeftViews, Status::StepCap, Status::ThicknessRejected, Status::BehindLastLayer]
    {
        assert_eq!(classes(&case, Hit::miss(status)), [FalseMiss; 3]);
    }
    // What was made up counts as a hit.
    assert_eq!(classes(&case, Hit { status: Status::Inpainted as u32, ..hit(2.0) }), [TrueHit; 3]);
}

/// Proves both classes for a ray that misses; t does not matter then.
#[test]
fn classes_of_a_ray_that_misses() {
    let case = Case::new(framed(plate()), vec![down(3.0, 0.5, 2.0)], Query::Closest);
    assert_eq!(case.answers[0], Answer { hit: None, perturbed: None });
    assert_eq!(classes(&case, miss()), [Class::TrueMiss; 3]);
    for t in [0.0, 2.0, 1e20] {
        assert_eq!(classes(&case, hit(t)), [Class::FalseHit; 3]);
    }
}

/// Proves the tolerances: 1e-4 t + 1e-6 diagonal for `tight`, one pixel of 90 degrees over 1024 at the true point's
/// distance from the viewpoint for `footprint`; half a thousandth of it inside is right, outside is wrong, either way.
#[test]
fn tolerances_are_where_they_are_said_to_be() {
    for (z, eye) in
        [(2.0, DVec3::new(0.0, 0.0, 2.0)), (0.5, DVec3::new(3.0, -2.0, 1.5)), (2.0, DVec3::new(0.25, 0.5, -0.125))]
    {
        let mut case = Case::new(framed(plate()), vec![down(0.25, 0.5, z)], Query::Closest);
        case.eye = eye;
        let true_t = f64::from(z);
        let distance = (DVec3::new(0.25, 0.5, 0.0) - eye).length();
        let tight = 1e-4 * true_t + 1e-6 * DIAGONAL;
        let footprint = 2.0 * distance / 1024.0;
        for (rule, tolerance) in [(Rule::Tight, tight), (Rule::Footprint, footprint)] {
            let class = |share: f64| case.judge().class(rule, 0, &hit((true_t + share * tolerance) as f32));
            let inside = 0.998;
            assert_eq!([class(inside), class(-inside)], [Class::TrueHit; 2], "{rule:?} {z}");
            assert_eq!([class(1.002), class(-1.002)], [Class::Late, Class::Early], "{rule:?} {z}");
        }
    }
}

/// Proves that the footprint is a distance in space: for a ray whose direction is twice as long it is half in t.
#[test]
fn footprints_are_distances() {
    let case = Case::new(framed(plate()), vec![ray([0.25, 0.5, 2.0], [0.0, 0.0, -2.0])], Query::Closest);
    let footprint = 2.0 * DVec3::new(0.25, 0.5, 2.0).length() / 1024.0;
    let class = |error: f64| case.judge().class(Rule::Footprint, 0, &hit((1.0 + error) as f32));
    assert_eq!([class(0.499 * footprint), class(0.501 * footprint)], [Class::TrueHit, Class::Late]);
}

/// Proves that classes are counted, agreements are their shares, and intervals Wilson's: of 100 rays, 92, 90 and 91
/// right, worked out from the formula by hand.
#[test]
fn counts_shares_and_intervals() {
    let case = hundred(Query::Closest);
    let mut hits = case.right();
    hits[0] = hit(2.5);
    hits[1] = hit(2.002);
    hits[2..7].fill(miss());
    hits[60..63].fill(hit(1.0));
    let judgement = case.closest(&hits);
    let expected = |true_hit, late| Classes { true_hit, true_miss: 37, false_hit: 3, false_miss: 5, early: 0, late };
    assert_eq!(judgement.classes.tight, expected(53, 2));
    assert_eq!(judgement.classes.footprint, expected(54, 1));
    assert_eq!(judgement.ambiguous_rays, 0);
    let agreement = &judgement.agreement;
    assert_eq!([agreement.hit_miss, agreement.tight, agreement.footprint], [Some(0.92), Some(0.90), Some(0.91)]);
    // (p + z2/2n -+ z sqrt(p(1-p)/n + z2/4n2)) / (1 + z2/n) with z = 1.959964 and n = 100.
    let wilson = |p: f64| {
        let (z, n) = (1.959_964_f64, 100.0);
        let half = z * (p * (1.0 - p) / n + z * z / (4.0 * n * n)).sqrt();
        [-half, half].map(|half| (p + z * z / (2.0 * n) + half) / (1.0 + z * z / n))
    };
    for (interval, share) in
        [(judgement.interval.hit_miss, 0.92), (judgement.interval.tight, 0.90), (judgement.interval.footprint, 0.91)]
    {
        let found = interval.unwrap();
        let wanted = wilson(share);
        assert!((found[0] - wanted[0]).abs() < 1e-6 && (found[1] - wanted[1]).abs() < 1e-6, "{found:?} {wanted:?}");
    }
    // Tabulated: 90 of 100 gives 0.8256 to 0.9448.
    let tight = judgement.interval.tight.unwrap();
    assert!((tight[0] - 0.8256).abs() < 1e-4 && (tight[1] - 0.9448).abs() < 1e-4);
    let indices: Vec<u64> = judgement.wrong_rays.iter().map(|wrong| wrong.index).collect();
    assert_eq!(indices, [0, 1, 2, 3, 4, 5, 6, 60, 61, 62]);
    let first = &judgement.wrong_rays[0];
    assert_eq!((first.true_t, first.answered_t, first.class.as_str()), (Some(2.0), Some(2.5), "late"));
    assert_eq!((first.origin, first.true_primitive), (case.rays[0].origin, Some(1)));
    let lost = &judgement.wrong_rays[2];
    assert_eq!((lost.answered_t, lost.answered_primitive, lost.class.as_str()), (None, None, "false_miss"));
    assert_eq!(lost.status, "miss");
    let invented = &judgement.wrong_rays[7];
    assert_eq!((invented.true_t, invented.true_primitive, invented.class.as_str()), (None, None, "false_hit"));
}

/// Proves the curve: one point a tolerance, agreement never falls, each point is the share within that tolerance times
/// the diagonal, and at its end stands `hit_miss`.
#[test]
fn the_curve_rises_to_hit_miss() {
    let case = hundred(Query::Closest);
    let mut hits = case.right();
    // Ten errors each of about 2e-7, 2e-4 and 2e-2 diagonals, five false misses.
    for (index, hit_here) in hits.iter_mut().enumerate().take(35) {
        let error = [2e-7, 2e-4, 2e-2, 0.0][index / 10] * DIAGONAL;
        *hit_here = if index < 30 { hit((2.0 - error) as f32) } else { miss() };
    }
    let judgement = case.closest(&hits);
    let curve = &judgement.curve;
    assert_eq!(curve.iter().map(|point| point[0]).collect::<Vec<_>>(), CURVE_TOLERANCES);
    assert!(curve.windows(2).all(|pair| pair[0][1] <= pair[1][1] && pair[0][0] < pair[1][0]));
    let at = |tolerance: f64| curve.iter().find(|point| point[0] == tolerance).unwrap()[1];
    assert_eq!(
        [1e-8, 1e-7, 3e-7, 1e-4, 3e-4, 1e-2, 3e-2, 1.0].map(at),
        [0.65, 0.65, 0.75, 0.75, 0.85, 0.85, 0.95, 0.95]
    );
    assert_eq!(curve.last().map(|point| point[1]), judgement.agreement.hit_miss);
}

/// Proves the percentiles of position error by the nearest-rank rule, over rays that truth and tracer both say hit, and
/// that there are none without such rays.
#[test]
fn position_errors() {
    let case = hundred(Query::Closest);
    let mut hits = case.right();
    for (index, hit_here) in hits.iter_mut().enumerate().take(50) {
        *hit_here = hit(2.0 + (index as f32 + 1.0) / 64.0);
    }
    hits[50..60].fill(miss());
    // False hits are no part of it.
    hits[99] = hit(100.0);
    let error = case.closest(&hits).position_error;
    // Ranks of 50: 25, 48 (95 % of 50 is 47.5) and 50 (49.5).
    assert_eq!([error.p50, error.p95, error.p99], [Some(25.0 / 64.0), Some(48.0 / 64.0), Some(50.0 / 64.0)]);
    let none = case.closest(&vec![miss(); 100]).position_error;
    assert_eq!([none.p50, none.p95, none.p99], [None; 3]);
}

/// Proves that identity is the share of tight true hits that name the right triangle, and that who names none has none.
#[test]
fn identity() {
    let mut case = hundred(Query::Closest);
    let mut hits = case.right();
    assert_eq!(case.closest(&hits).identity, Some(1.0));
    for named in &mut hits[..15] {
        named.primitive = 7;
    }
    assert_eq!(case.closest(&hits).identity, Some(0.75));
    // A wrong t takes the ray out of the share; a false hit never was in it.
    for wrong in &mut hits[..10] {
        wrong.t = 3.0;
    }
    hits[80] = hit(1.0);
    assert_eq!(case.closest(&hits).identity, Some(0.9));
    let nameless = Judge { names_primitives: false, ..case.judge() };
    match nameless.judge(&hits).unwrap() {
        Judgement::Closest(judgement) => assert_eq!(judgement.identity, None),
        Judgement::Any(_) => panic!("closest was asked"),
    }
    assert_eq!(case.closest(&vec![miss(); 100]).identity, None);
    // An ambiguous ray may name the triangle of any of its true hits.
    hits.clone_from(&case.right());
    make_ambiguous(&mut case.answers[0], &[Some((2.0, 7))]);
    let named = |primitive: u32| case.closest(&[&[Hit { primitive, ..hit(2.0) }], &hits[1..]].concat()).identity;
    assert_eq!([1, 7, 8].map(named), [Some(1.0), Some(1.0), Some(59.0 / 60.0)]);
}

/// Proves that of two triangles which overlap in a plane either names what is hit, and one that lies elsewhere, or a
/// number that is no triangle, does not.
#[test]
fn identity_of_coplanar_overlaps() {
    let mut triangles = plate();
    triangles.extend(rectangle([-1.0, -0.5, 0.0], [1.7, 0.0, 0.0], [0.3, 1.1, 0.0]));
    triangles.extend(rectangle([-1.0, -1.0, -0.5], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]));
    let case = Case::new(framed(triangles), vec![down(0.125, 0.0625, 2.0)], Query::Closest);
    let identity = |primitive: u32| case.closest(&[Hit { primitive, ..hit(2.0) }]).identity;
    let names: Vec<u32> = (0..8).filter(|primitive| identity(*primitive) == Some(1.0)).collect();
    assert_eq!(names.len(), 2, "{names:?}: one of the plate, one of what lies on it");
    assert!(names[0] < 2 && (2..4).contains(&names[1]), "{names:?}");
    assert_eq!(identity(1000), Some(0.0));
}

/// Proves the 2x2 table of an any-hit set, that t does not count there, and the balanced accuracy.
#[test]
fn occlusion() {
    let case = hundred(Query::Any);
    let mut hits = case.right();
    for (index, far) in hits.iter_mut().enumerate().take(20) {
        far.t = index as f32 * 10.0;
    }
    hits[20..35].fill(miss());
    hits[60..62].fill(hit(0.0));
    let judgement = case.any(&hits);
    let table = &judgement.occlusion;
    assert_eq!([table.true_occluded, table.true_free, table.false_occluded, table.false_free], [45, 38, 2, 15]);
    // (45/60 + 38/40) / 2
    assert_eq!(table.balanced_accuracy, Some(0.85));
    let [low, high] = table.balanced_accuracy_interval.unwrap();
    assert!(low < 0.85 && 0.85 < high && low > 0.7 && high < 0.95);
    assert_eq!(judgement.causes["occlusion"].values().sum::<u64>(), 17);
    let names: Vec<&str> = judgement.wrong_rays.iter().map(|wrong| wrong.class.as_str()).collect();
    assert_eq!((names.len(), names[0], names[16]), (17, "false_free", "false_occluded"));
}

/// Proves that where truth knows one kind of ray only, the balanced accuracy is the share of that kind.
#[test]
fn balanced_accuracy_of_one_kind() {
    for (x, wrong, right) in [(0.25, miss(), hit(2.0)), (3.0, hit(2.0), miss())] {
        let case = Case::new(framed(plate()), vec![down(x, 0.5, 2.0); 8], Query::Any);
        let mut hits = vec![right; 8];
        assert_eq!(case.any(&hits).occlusion.balanced_accuracy, Some(1.0));
        hits[3] = wrong;
        hits[4] = wrong;
        assert_eq!(case.any(&hits).occlusion.balanced_accuracy, Some(0.75));
    }
}

/// Proves that answers are counted by their status, and which of them are right by each rule, as the answers were made; ambiguous rays of an
/// any-hit set are in no count.
#[test]
fn answers_are_counted_by_status() {
    let right = |of: &StatusCounts| of.right.iter().map(|(rule, rays)| (rule.clone(), *rays)).collect::<Vec<_>>();
    let case = hundred(Query::Closest);
    let mut hits = case.right();
    // Three hits a little off, two far off, four misses that are hits, one of them by another status.
    hits[..3].fill(hit(2.002));
    hits[3..5].fill(hit(1.0));
    hits[5..8].fill(miss());
    hits[8] = Hit::miss(Status::StepCap);
    let counts = case.closest(&hits).by_status;
    assert_eq!(
        counts.iter().map(|(name, of)| (name.as_str(), of.rays)).collect::<Vec<_>>(),
        [("hit", 56), ("miss", 43), ("step_cap", 1)]
    );
    let of = |footprint, hit_miss, tight| {
        [("footprint", footprint), ("hit_miss", hit_miss), ("tight", tight)].map(|(rule, rays)| (rule.to_owned(), rays))
    };
    assert_eq!(right(&counts["hit"]), of(54, 56, 51));
    assert_eq!(right(&counts["miss"]), of(40, 40, 40));
    assert_eq!(right(&counts["step_cap"]), of(0, 0, 0));
    let mut case = hundred(Query::Any);
    make_ambiguous(&mut case.answers[0], &[None]);
    let mut hits = case.right();
    hits[1] = miss();
    let counts = case.any(&hits).by_status;
    assert_eq!((counts["hit"].rays, right(&counts["hit"])), (58, vec![("occlusion".to_owned(), 58)]));
    assert_eq!((counts["miss"].rays, right(&counts["miss"])), (41, vec![("occlusion".to_owned(), 40)]));
}

/// Proves that what is no answer is refused, with the number of such rays and the first of them: poison, a status that
/// does not exist, a t that is no number, another count.
#[test]
fn what_is_no_answer_is_refused() {
    for query in [Query::Closest, Query::Any] {
        let case = hundred(query);
        let poison = Hit { t: 0.0, primitive: 0, u: 0.0, v: 0.0, status: 0 };
        let unknown = Hit { status: Status::ALL.len() as u32, ..hit(2.0) };
        for bad in [
            poison,
            unknown,
            hit(f32::NAN),
            hit(f32::INFINITY),
            hit(f32::NEG_INFINITY),
            Hit { status: u32::MAX, ..poison },
        ] {
            let mut hits = case.right();
            hits[41] = bad;
            hits[97] = bad;
            match case.judge().judge(&hits) {
                Err(JudgeError::Malformed { count: 2, first: 41, hit }) => assert_eq!(hit.status, bad.status),
                other => panic!("{bad:?}: {other:?}"),
            }
        }
        // A miss need not carry a t.
        let mut hits = case.right();
        hits[99] = Hit { t: f32::NAN, ..miss() };
        assert!(case.judge().judge(&hits).is_ok());
        for count in [0, 99, 101] {
            let hits = vec![miss(); count];
            match case.judge().judge(&hits) {
                Err(JudgeError::Count { hits, rays: 100 }) => assert_eq!(hits, count),
                other => panic!("{count}: {other:?}"),
            }
        }
    }
}

/// Proves that the list of wrong rays is capped for each cause and spread over all of that cause, while counts are not; and that as
/// many are kept as are asked for.
#[test]
fn wrong_rays_are_capped_by_cause() {
    let case = Case::new(framed(plate()), vec![down(0.25, 0.5, 2.0); 1000], Query::Closest);
    let capped = |ray| ray % 100 == 50;
    let status = |ray| if capped(ray) { Status::StepCap } else { Status::Miss };
    let answers: Vec<Hit> = (0..1000).map(|ray| Hit::miss(status(ray))).collect();
    let kept = |wrong_rays_per_cause| match (Judge { wrong_rays_per_cause, ..case.judge() }).judge(&answers) {
        Ok(Judgement::Closest(judgement)) => judgement,
        other => panic!("{other:?}"),
    };
    let judgement = kept(WRONG_RAYS_PER_CAUSE);
    let (rare, common): (Vec<u64>, Vec<u64>) =
        judgement.wrong_rays.iter().map(|wrong| wrong.index).partition(|ray| capped(*ray));
    assert_eq!(rare, [50, 250, 550, 750]);
    assert_eq!((common.len(), common[0]), (4, 0));
    assert!(common.windows(2).all(|pair| (245..=255).contains(&(pair[1] - pair[0]))), "{common:?}");
    assert!(judgement.wrong_rays.is_sorted_by_key(|wrong| wrong.index));
    assert_eq!(judgement.classes.tight.false_miss, 1000);
    assert_eq!(judgement.causes["tight"].values().sum::<u64>(), 1000);
    assert_eq!((kept(0).wrong_rays.len(), kept(20).wrong_rays.len()), (0, 30));
}

/// Proves, as a negative control, that one corrupted answer of an oracle's is noticed under each rule it breaks.
#[test]
fn one_corrupted_ray_is_noticed() {
    let case = hundred(Query::Closest);
    let right = case.right();
    let judged = case.closest(&right);
    for agreement in [judged.agreement.hit_miss, judged.agreement.tight, judged.agreement.footprint] {
        assert_eq!(agreement, Some(1.0));
    }
    assert!(judged.wrong_rays.is_empty());
    let corrupted = |index: usize, hit: Hit| {
        let mut hits = right.clone();
        hits[index] = hit;
        let agreement = case.closest(&hits).agreement;
        [agreement.hit_miss, agreement.tight, agreement.footprint].map(|share| share == Some(1.0))
    };
    assert_eq!(corrupted(13, miss()), [false; 3]);
    assert_eq!(corrupted(77, hit(2.0)), [false; 3]);
    assert_eq!(corrupted(13, hit(2.5)), [true, false, false]);
    assert_eq!(corrupted(13, hit(2.001)), [true, false, true]);
    let case = hundred(Query::Any);
    let mut hits = case.right();
    hits[13] = miss();
    assert!(case.any(&hits).occlusion.balanced_accuracy.is_some_and(|share| share < 1.0));
}
