//! The judge against hand-made cases: every class under every rule, just inside and just outside of each tolerance,
//! every cause from the smallest scene that shows it, and the controls.

use std::sync::Arc;

use glam::{DVec3, Vec3};
use tracebench_api::{Geometry, Hit, NO_PRIMITIVE, Query, Ray, Status, View, ViewSet, Viewpoint};
use tracebench_harness::controls::Control;
use tracebench_harness::judge::{CURVE_TOLERANCES, Class, Judge, JudgeError, MOST_WRONG_RAYS, Rule};
use tracebench_harness::progress::Progress;
use tracebench_harness::results::{AnyJudgement, Classes, ClosestJudgement, Judgement};
use tracebench_harness::truth::{Answer, Cache, TrueHit, Truth};
use tracebench_tests::{rectangle, soup};

/// Two far corners make the diagonal exactly 12 (8, 8, 4); what the tests look at is a plate in between.
fn framed(mut triangles: Vec<[[f32; 3]; 3]>) -> Truth {
    triangles.push([[-4.0, -4.0, -2.0]; 3]);
    triangles.push([[4.0, 4.0, 2.0]; 3]);
    Truth::new(&soup(&triangles, None), "judge")
}

const DIAGONAL: f64 = 12.0;

/// A plate of side 2 in the plane z = 0.
fn plate() -> Vec<[[f32; 3]; 3]> {
    rectangle([-1.0, -1.0, 0.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]).to_vec()
}

fn ray(origin: [f32; 3], direction: [f32; 3]) -> Ray {
    Ray { origin, t_min: 0.0, direction, t_max: Ray::UNBOUNDED }
}

fn down(x: f32, y: f32, z: f32) -> Ray {
    ray([x, y, z], [0.0, 0.0, -1.0])
}

fn hit(t: f32) -> Hit {
    Hit { t, primitive: 0, u: 0.0, v: 0.0, status: Status::Hit as u32 }
}

fn miss() -> Hit {
    Hit::miss(Status::Miss)
}

/// Rays with their truth and a judge over them.
struct Case {
    truth: Truth,
    eye: DVec3,
    rays: Arc<Vec<Ray>>,
    answers: Vec<Answer>,
    query: Query,
    views: Vec<View>,
}

impl Case {
    fn new(truth: Truth, rays: Vec<Ray>, query: Query) -> Self {
        let rays = Arc::new(rays);
        let answers = truth.answer(&rays, query, &Cache::none(), &Progress::new(true)).unwrap();
        Self { truth, eye: DVec3::new(0.0, 0.0, 2.0), rays, answers, query, views: Vec::new() }
    }

    fn judge(&self) -> Judge<'_> {
        Judge {
            truth: &self.truth,
            eye: self.eye,
            rays: &self.rays,
            answers: &self.answers,
            query: self.query,
            views: &self.views,
            names_primitives: true,
        }
    }

    fn closest(&self, hits: &[Hit]) -> ClosestJudgement {
        match self.judge().judge(hits) {
            Ok(Judgement::Closest(judgement)) => judgement,
            other => panic!("{other:?}"),
        }
    }

    fn any(&self, hits: &[Hit]) -> AnyJudgement {
        match self.judge().judge(hits) {
            Ok(Judgement::Any(judgement)) => judgement,
            other => panic!("{other:?}"),
        }
    }

    /// What an oracle answers.
    fn right(&self) -> Vec<Hit> {
        let answer = |answer: &Answer| match answer.hit {
            Some(TrueHit { t, primitive }) => Hit { primitive, ..hit(t as f32) },
            None => miss(),
        };
        self.answers.iter().map(answer).collect()
    }

    /// The one cause of a single wrong ray under a rule.
    fn cause(&self, rule: &str, hits: &[Hit]) -> String {
        let causes = match self.judge().judge(hits).unwrap() {
            Judgement::Closest(judgement) => judgement.causes,
            Judgement::Any(judgement) => judgement.causes,
        };
        let causes = &causes[rule];
        assert_eq!((causes.len(), causes.values().sum::<u64>()), (1, 1), "{causes:?}");
        causes.keys().next().unwrap().clone()
    }
}

/// One ray down onto the plate from z = 2: true t is 2, and the eye is where it starts.
fn one() -> Case {
    Case::new(framed(plate()), vec![down(0.25, 0.5, 2.0)], Query::Closest)
}

fn classes(case: &Case, hit: Hit) -> [Class; 3] {
    [Rule::HitMiss, Rule::Tight, Rule::Footprint].map(|rule| case.judge().class(rule, 0, &hit))
}

/// Proves each class under each rule for a ray that hits: right, missed, too near and too far by more than a pixel.
#[test]
fn classes_of_a_ray_that_hits() {
    use Class::{Early, FalseMiss, Late, TrueHit};
    let case = one();
    assert_eq!(case.answers[0].hit.map(|hit| (hit.t, hit.primitive)), Some((2.0, 1)));
    assert!(!case.answers[0].tie);
    assert_eq!(classes(&case, hit(2.0)), [TrueHit, TrueHit, TrueHit]);
    assert_eq!(classes(&case, hit(1.9)), [TrueHit, Early, Early]);
    assert_eq!(classes(&case, hit(2.1)), [TrueHit, Late, Late]);
    assert_eq!(classes(&case, hit(2.002)), [TrueHit, Late, TrueHit]);
    assert_eq!(classes(&case, hit(1.998)), [TrueHit, Early, TrueHit]);
    assert_eq!(classes(&case, hit(0.0)), [TrueHit, Early, Early]);
    for status in [Status::Miss, Status::LeftViews, Status::StepCap, Status::ThicknessRejected] {
        assert_eq!(classes(&case, Hit::miss(status)), [FalseMiss; 3]);
    }
}

/// Proves both classes for a ray that misses; t does not matter then.
#[test]
fn classes_of_a_ray_that_misses() {
    let case = Case::new(framed(plate()), vec![down(3.0, 0.5, 2.0)], Query::Closest);
    assert_eq!(case.answers[0], Answer { hit: None, tie: false });
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

/// A hundred rays: sixty onto the plate, forty beside it.
fn hundred(query: Query) -> Case {
    let rays = (0..100).map(|index| {
        let along = index as f32 / 100.0;
        if index < 60 { down(along - 0.3, 0.31, 2.0) } else { down(2.0 + along, 0.31, 2.0) }
    });
    let case = Case::new(framed(plate()), rays.collect(), query);
    assert!(case.answers.iter().all(|answer| !answer.tie));
    assert_eq!(case.answers.iter().filter(|answer| answer.hit.is_some()).count(), 60);
    case
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
    assert_eq!(judgement.ties, 0);
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
    assert_eq!(judgement.wrong_rays.len(), 10);
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
    case.answers.iter_mut().for_each(|answer| answer.tie = true);
    assert_eq!(case.closest(&hits).identity, None);
}

/// Proves that ties are in no class, share, curve, percentile, cause or list, whatever was answered, that they are
/// counted, that more than a thousandth of them is said, and that a set of ties only has no share at all.
#[test]
fn ties_are_left_out() {
    let mut case = hundred(Query::Closest);
    case.answers[5].tie = true;
    case.answers[70].tie = true;
    let mut hits = case.right();
    let right = case.closest(&hits);
    hits[5] = miss();
    hits[70] = hit(77.0);
    let judgement = case.closest(&hits);
    assert_eq!(judgement, right);
    assert_eq!((judgement.ties, judgement.many_ties), (2, true));
    assert_eq!((judgement.classes.tight.true_hit, judgement.classes.tight.true_miss), (59, 39));
    assert_eq!(judgement.agreement.tight, Some(1.0));
    case.answers.iter_mut().for_each(|answer| answer.tie = true);
    let none = case.closest(&hits);
    assert_eq!((none.ties, none.agreement.hit_miss, none.interval.tight, none.curve.len()), (100, None, None, 0));
    case.query = Query::Any;
    let none = case.any(&hits);
    assert_eq!(
        (none.ties, none.occlusion.balanced_accuracy, none.occlusion.balanced_accuracy_interval),
        (100, None, None)
    );
    // One in a thousand is not yet many.
    let rays = vec![down(0.25, 0.5, 2.0); 1000];
    let mut case = Case::new(framed(plate()), rays, Query::Closest);
    case.answers[0].tie = true;
    assert!(!case.closest(&case.right()).many_ties);
    case.answers[1].tie = true;
    assert!(case.closest(&case.right()).many_ties);
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

/// Proves that what is no answer is refused, with the number of such rays and the first of them: poison, a status that
/// does not exist, a t that is no number, another count.
#[test]
fn what_is_no_answer_is_refused() {
    for query in [Query::Closest, Query::Any] {
        let case = hundred(query);
        let poison = Hit { t: 0.0, primitive: 0, u: 0.0, v: 0.0, status: 0 };
        let unknown = Hit { status: 6, ..hit(2.0) };
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

/// Proves that the list of wrong rays is capped and spread over all of them, while counts are not.
#[test]
fn wrong_rays_are_capped() {
    let case = Case::new(framed(plate()), vec![down(0.25, 0.5, 2.0); 1000], Query::Closest);
    let judgement = case.closest(&vec![miss(); 1000]);
    let indices: Vec<u64> = judgement.wrong_rays.iter().map(|wrong| wrong.index).collect();
    assert_eq!(indices.len(), MOST_WRONG_RAYS);
    let apart = 1000 / MOST_WRONG_RAYS as u64;
    assert!(indices.windows(2).all(|pair| (apart..=apart + 1).contains(&(pair[1] - pair[0]))));
    assert!(indices[0] <= apart && indices[MOST_WRONG_RAYS - 1] + 2 * apart >= 1000);
    assert_eq!(judgement.classes.tight.false_miss, 1000);
    assert_eq!(judgement.causes["tight"].values().sum::<u64>(), 1000);
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

/// A view from z = 2 down onto the plane z = 0, of 64 x 64 pixels and 90 degrees: it shows |x|, |y| < 2 there, a pixel
/// is 1/16 wide.
fn view() -> View {
    Viewpoint {
        eye: Vec3::new(0.0, 0.0, 2.0),
        forward: Vec3::NEG_Z,
        up: Vec3::Y,
        vertical_fov: std::f32::consts::FRAC_PI_2,
        near: 0.5,
        far: 50.0,
        frame: [64, 64],
        face: 64,
        view_set: ViewSet::Frame,
    }
    .frame_view()
}

fn seen(triangles: Vec<[[f32; 3]; 3]>, ray: Ray) -> Case {
    let mut case = Case::new(framed(triangles), vec![ray], Query::Closest);
    assert!(!case.answers[0].tie);
    case.views = vec![view()];
    case
}

fn status(status: Status) -> Hit {
    Hit::miss(status)
}

/// A plate of side `2 * half` at a height.
fn plate_at(z: f32, half: f32) -> Vec<[[f32; 3]; 3]> {
    rectangle([-half, -half, z], [2.0 * half, 0.0, 0.0], [0.0, 2.0 * half, 0.0]).to_vec()
}

/// Proves `within_footprint`: the right surface, off by less than a reference pixel, is wrong under `tight` only.
#[test]
fn cause_within_footprint() {
    let case = seen(plate(), down(0.25, 0.5, 1.0));
    assert_eq!(case.cause("tight", &[hit(1.002)]), "within_footprint");
    assert!(case.closest(&[hit(1.002)]).causes["footprint"].is_empty());
    assert_ne!(case.cause("tight", &[hit(1.2)]), "within_footprint");
}

/// Proves `off_view`: what was missed lies beside the view, behind its eye, or before its near plane.
#[test]
fn cause_off_view() {
    let beside = rectangle([3.0, -1.0, -1.0], [0.0, 2.0, 0.0], [0.0, 0.0, 2.0]).to_vec();
    let rays = [
        (beside, ray([0.0, 0.25, 0.0], [1.0, 0.0, 0.0])),
        (plate_at(3.0, 1.0), ray([0.25, 0.125, 1.0], [0.0, 0.0, 1.0])),
        (plate_at(1.75, 1.0), ray([0.1, 0.05, 0.5], [0.0, 0.0, 1.0])),
    ];
    for (triangles, ray) in rays {
        let case = seen(triangles, ray);
        assert!(case.answers[0].hit.is_some());
        // The cause is the judge's own finding: no status of the tracer's changes it.
        for said in [Status::LeftViews, Status::Miss, Status::StepCap, Status::ThicknessRejected] {
            assert_eq!(case.cause("tight", &[status(said)]), "off_view");
        }
    }
}

/// Proves `hidden_layer`: what was missed lies behind another surface, and is none once that surface is gone.
#[test]
fn cause_hidden_layer() {
    let mut triangles = plate_at(-1.0, 1.0);
    triangles.extend(plate_at(0.5, 1.0));
    let ray = ray([0.25, 0.125, 0.0], [0.0, 0.0, -1.0]);
    let case = seen(triangles, ray);
    assert_eq!(case.cause("tight", &[status(Status::ThicknessRejected)]), "hidden_layer");
    assert_ne!(seen(plate_at(-1.0, 1.0), ray).cause("tight", &[miss()]), "hidden_layer");
}

/// Proves `step_cap`: what was missed is in plain sight, and the tracer gave up before.
#[test]
fn cause_step_cap() {
    let case = seen(plate_at(0.0, 1.0), ray([-0.75, 0.1, 0.5], [0.8, 0.0, -0.6]));
    assert_eq!(case.cause("tight", &[status(Status::StepCap)]), "step_cap");
    // The same without any view, for methods that have steps and no views.
    let mut case = case;
    case.views.clear();
    assert_eq!(case.cause("tight", &[status(Status::StepCap)]), "step_cap");
    assert_eq!(case.cause("tight", &[miss()]), "unexplained");
}

/// Proves `thickness_rejected` and `unexplained`: what was missed is in plain sight, on a pixel's centre, far from the
/// ray's start, and only the first says a reason.
#[test]
fn cause_thickness_rejected_or_unexplained() {
    let case = seen(plate_at(0.0, 1.0), ray([-0.75, 0.1, 0.5], [0.8, 0.0, -0.6]));
    assert_eq!(case.cause("tight", &[status(Status::ThicknessRejected)]), "thickness_rejected");
    for said in [Status::Miss, Status::LeftViews] {
        assert_eq!(case.cause("tight", &[status(said)]), "unexplained");
    }
}

/// Proves `between_samples`: a sliver that falls between pixel centres is missed; a hit a pixel beside the right place
/// is off; a surface that a pixel's centre shows is hit beside it.
#[test]
fn cause_between_samples() {
    // Pixel centres lie at odd multiples of 1/32 in the plane z = 0; this sliver lies between two of them.
    let sliver = rectangle([0.0625 + 0.01, -1.0, 0.0], [0.02, 0.0, 0.0], [0.0, 2.0, 0.0]).to_vec();
    let mut triangles = sliver;
    triangles.extend(plate_at(-1.5, 3.0));
    let case = seen(triangles, down(0.0625 + 0.02, 0.3, 1.0));
    assert_eq!(case.answers[0].hit.map(|hit| hit.t), Some(1.0));
    assert_eq!(case.cause("tight", &[status(Status::Miss)]), "between_samples");
    assert_eq!(case.cause("tight", &[hit(2.5)]), "between_samples");
    // A slanted ray over a plate: 0.1 too late along it is 0.08 aside, less than two pixels (0.125).
    let case = seen(plate_at(0.0, 1.0), ray([-0.75, 0.1, 0.5], [0.8, 0.0, -0.6]));
    let truth = case.answers[0].hit.unwrap().t as f32;
    assert_eq!(case.cause("tight", &[hit(truth + 0.1)]), "between_samples");
    assert_ne!(case.cause("tight", &[hit(truth + 0.5)]), "between_samples");
    // Beside the edge of a plate whose pixel's centre still shows the plate: a false hit at the plate's depth.
    let edge = 0.5 + 1.0 / 32.0 + 0.005;
    let case = seen(plate_at(0.0, edge), down(0.5 + 0.05, 0.1, 1.0));
    assert!(case.answers[0].hit.is_none());
    assert_eq!(case.cause("tight", &[hit(1.0)]), "between_samples");
}

/// Proves `near_start`: what was missed lies within two pixels of the ray's start.
#[test]
fn cause_near_start() {
    let triangles = plate_at(0.0, 1.0);
    let near = seen(triangles.clone(), ray([0.21, 0.1, 0.06], [0.8, 0.0, -0.6]));
    assert_eq!(near.cause("tight", &[miss()]), "near_start");
    let far = seen(triangles, ray([0.21, 0.1, 0.3], [0.8, 0.0, -0.6]));
    assert_eq!(far.cause("tight", &[miss()]), "unexplained");
}

/// Proves `self_hit`: an invented hit within four reference pixels of the ray's start, and none farther along.
#[test]
fn cause_self_hit() {
    let case = seen(plate_at(0.0, 1.0), ray([0.25, 0.125, 0.001], [0.0, 0.0, 1.0]));
    assert!(case.answers[0].hit.is_none());
    // The start is 2 from the eye: a reference pixel there is 2 * 2 / 1024.
    assert_eq!(case.cause("tight", &[hit(0.015)]), "self_hit");
    assert_ne!(case.cause("tight", &[hit(0.1)]), "self_hit");
    // Any-hit sets have the same causes.
    let mut any = case;
    any.query = Query::Any;
    assert_eq!(any.cause("occlusion", &[hit(0.015)]), "self_hit");
}

/// Proves `assumed_thickness`: a hit was invented behind what the view shows there.
#[test]
fn cause_assumed_thickness() {
    let case = seen(plate_at(0.0, 1.0), ray([-1.5, 0.1, -0.25], [1.0, 0.0, 0.0]));
    assert!(case.answers[0].hit.is_none());
    assert_eq!(case.cause("tight", &[hit(1.0)]), "assumed_thickness");
    // Off the view no view explains it.
    assert_eq!(case.cause("tight", &[hit(100.0)]), "unexplained");
    // In front of everything it is no thickness.
    let before = seen(plate_at(0.0, 1.0), ray([-1.5, 0.1, 0.25], [1.0, 0.0, 0.0]));
    assert_ne!(before.cause("tight", &[hit(1.5)]), "assumed_thickness");
}

/// Answers of a control to a hundred rays of which a few are ties, as the judge sees them.
fn controlled(control: Control, query: Query) -> (Judgement, u64, u64) {
    let mut case = hundred(query);
    case.answers[3].tie = true;
    case.answers[64].tie = true;
    let hits: Vec<Hit> = match control {
        Control::Oracle => case.right(),
        Control::AlwaysMiss => vec![miss(); 100],
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
                        Control::AlwaysHit => vec![hit(6.0); 8],
                    };
                    let judgement = case.judge().judge(&hits).unwrap();
                    control.check(&judgement, occluded, free).unwrap();
                }
            }
        }
    }
}

/// Proves that the diagonal that tolerances rest on is the one the tests assume.
#[test]
fn the_test_scene_has_the_diagonal_it_claims() {
    assert_eq!(framed(plate()).diagonal(), DIAGONAL);
    assert!(Geometry::new(vec![[0.0; 3]], Vec::new(), None).is_err());
}
