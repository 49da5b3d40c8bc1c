//! Ambiguous rays.

use super::*;

/// A square of side 2 in the plane z = 0, its diagonal from corner to corner.
fn square(level: f32) -> Vec<[[f32; 3]; 3]> {
    let (a, b, c, d) = ([-1.0, -1.0, level], [1.0, -1.0, level], [1.0, 1.0, level], [-1.0, 1.0, level]);
    vec![[a, b, c], [a, c, d]]
}

fn truth_of(triangles: &[[[f32; 3]; 3]]) -> Truth {
    Truth::new(&tracebench_tests::soup(triangles, None), "ambiguous_rays")
}

/// A ray down from z = 8: an ulp of its largest coordinate is 2^-20, the move that makes an ambiguous ray 2^-18.
fn down(x: f64, y: f64) -> Ray64 {
    Ray64 { origin: DVec3::new(x, y, 8.0), direction: DVec3::NEG_Z, t_min: 0.0, t_max: f64::INFINITY }
}

const MOVE: f64 = 1.0 / (1 << 18) as f64;

/// Proves the band of ambiguous rays along the edge of an open square, by the arithmetic of its definition: within four ulp of
/// the largest coordinate a ray is an ambiguous ray on either side of the edge, and beyond it is none.
#[test]
fn ties_lie_along_open_edges() {
    let truth = truth_of(&square(0.0));
    for step in -24..=24_i32 {
        let beyond = f64::from(step) * MOVE / 8.0;
        for query in [Query::Closest, Query::Any] {
            for ray in [down(1.0 + beyond, 0.3), down(-1.0 - beyond, 0.3), down(0.3, 1.0 + beyond)] {
                let answer = truth.answer_one(&ray, query);
                let (hit, tie) = (answer.hit, answer.is_ambiguous());
                assert_eq!(hit.is_some(), step <= 0, "{step}");
                // Inside it is lost by a move of more than the distance to the edge; outside, a move that reaches the
                // edge finds it.
                assert_eq!(tie, if step <= 0 { step > -8 } else { step <= 8 }, "{step} {query:?}");
            }
        }
    }
}

/// Proves that an edge between two triangles of one flat surface makes not ambiguous, nor does its corner, though either
/// triangle may be named.
#[test]
fn inner_edges_are_no_ties() {
    let truth = truth_of(&square(0.0));
    for at in [-0.5, 0.0, 0.25, 0.75] {
        for offset in [0.0, MOVE / 2.0, -MOVE / 2.0] {
            let answer = truth.answer_one(&down(at + offset, at), Query::Closest);
            assert!(answer.hit.is_some_and(|hit| hit.t == 8.0) && !answer.is_ambiguous(), "{at} {offset}");
        }
        assert_eq!(truth.answer_one(&down(at, at), Query::Closest).hit.map(|hit| hit.primitive), Some(0));
    }
}

/// Proves that whether a ray is an ambiguous ray depends on what was asked: at the edge of a plate before a wall the nearest hit
/// jumps, but there is a hit either way.
#[test]
fn ties_depend_on_the_query() {
    let mut triangles = square(0.0);
    triangles.extend(square(-1.0).iter().map(|triangle| triangle.map(|[x, y, z]| [x * 4.0, y * 4.0, z])));
    let truth = truth_of(&triangles);
    assert!(truth.answer_one(&down(1.0, 0.3), Query::Closest).is_ambiguous());
    assert!(!truth.answer_one(&down(1.0, 0.3), Query::Any).is_ambiguous());
    // Beyond the tolerance: a step in depth as small as that is none.
    let lowered: Vec<_> = square(0.0)
        .into_iter()
        .chain(square(-1e-6).iter().map(|triangle| triangle.map(|[x, y, z]| [x * 4.0, y * 4.0, z])))
        .collect();
    assert!(!truth_of(&lowered).answer_one(&down(1.0, 0.3), Query::Closest).is_ambiguous());
    // At the edge of both, a ray may hit nothing.
    assert!(truth.answer_one(&down(4.0, 0.3), Query::Any).is_ambiguous());
}

/// Proves the ends of spans: a ray that ends on a slanted surface is ambiguous, since a move to the side loses it, and one that ends well
/// before or behind is not.
#[test]
fn ties_at_the_end_of_a_span() {
    let slanted: Vec<_> = square(0.0).iter().map(|triangle| triangle.map(|[x, y, _]| [x, y, 2.0 * x])).collect();
    let (flat, slanted) = (truth_of(&square(0.0)), truth_of(&slanted));
    let ending = |t_max: f64| Ray64 { t_max, ..down(0.0, 0.25) };
    for query in [Query::Closest, Query::Any] {
        assert!(slanted.answer_one(&ending(8.0), query).is_ambiguous());
        assert!(slanted.answer_one(&ending(8.0 - MOVE), query).is_ambiguous());
        assert!(!slanted.answer_one(&ending(8.1), query).is_ambiguous());
        assert!(!slanted.answer_one(&ending(7.9), query).is_ambiguous());
        assert!(!flat.answer_one(&ending(8.1), query).is_ambiguous());
        assert!(!flat.answer_one(&ending(7.9), query).is_ambiguous());
    }
}

/// Proves that ambiguous rays are a property of ray and surface: neither the order of the triangles nor duplicates change them.
#[test]
fn ties_do_not_depend_on_the_order_of_triangles() {
    let mut dice = Dice::new(13);
    let scene = soup(&mut dice, 60, 6);
    let mut shuffled = scene.clone();
    shuffled.triangles.reverse();
    shuffled.triangles.extend(scene.triangles[..20].iter().map(|[a, b, c]| [*b, *c, *a]));
    let (truth, other) = (scene.truth(), shuffled.truth());
    let mut ambiguous_rays = [0, 0];
    for ray in rays(&mut dice, 3000, 7) {
        for query in [Query::Closest, Query::Any] {
            let [first, second] = [&truth, &other].map(|truth| truth.answer_one(&ray.rounded(), query));
            assert_eq!(
                (first.is_ambiguous(), first.hit.is_some()),
                (second.is_ambiguous(), second.hit.is_some()),
                "{ray:?}"
            );
            let near = first.hit.zip(second.hit).is_none_or(|(a, b)| (a.t - b.t).abs() <= 1e-12 * (1.0 + a.t));
            // An any-hit ray is not ambiguous where only t hangs on rounding.
            assert!(near || first.is_ambiguous() || query == Query::Any, "{ray:?} {first:?} {second:?}");
            ambiguous_rays[usize::from(first.is_ambiguous())] += 1;
        }
    }
    assert!(ambiguous_rays[0] > 500 && ambiguous_rays[1] > 50, "{ambiguous_rays:?}");
}

/// Proves that an ambiguous ray stays one when ray and scene are moved together, wherever the coordinates' origin lies: an eye on a
/// floor that is the plane of a coordinate hangs on rounding no less than one on a floor beside it. An eye above the
/// floor by more than the move is not ambiguous in any place.
#[test]
fn ties_do_not_depend_on_where_zero_is() {
    // All of these are whole numbers of the ulps of 16, so that moving loses nothing.
    let step = 1.0 / f64::from(1 << 18);
    for by in [[0.0, 0.0, 0.0], [0.5, 0.25, 1.0], [-8.0, 4.0, 8.0], [0.0, 0.0, 0.5]] {
        let moved = |[x, y, z]: [f32; 3]| [x + by[0], y + by[1], z + by[2]];
        let floor: Vec<_> = square(0.0).into_iter().map(|triangle| triangle.map(moved)).collect();
        let truth = truth_of(&floor);
        for direction in [DVec3::new(0.6, 0.0, -0.8), DVec3::new(0.0, -0.8, -0.6)] {
            let from = |height: f64| {
                let origin = DVec3::from(by.map(f64::from)) + DVec3::new(0.0, 0.25, height);
                Ray64 { origin, direction, t_min: 0.0, t_max: f64::INFINITY }
            };
            assert!(truth.answer_one(&from(0.0), Query::Closest).is_ambiguous(), "{by:?} {direction}");
            assert!(truth.answer_one(&from(0.0), Query::Any).is_ambiguous(), "{by:?} {direction}");
            assert!(!truth.answer_one(&from(16.0 * step), Query::Any).is_ambiguous(), "{by:?} {direction}");
            assert!(!truth.answer_one(&from(-16.0 * step), Query::Any).is_ambiguous(), "{by:?} {direction}");
        }
    }
}

/// Proves the bands of ambiguous rays at the ends of spans, by the arithmetic of their definition: a plate square to the ray comes into the
/// span, or leaves it, by a move of 4 ulp of the larger of the end and the origin's largest coordinate.
#[test]
fn ambiguous_at_both_ends() {
    let plates = [square(0.0), square(-1000.0)].map(|plate| truth_of(&plate));
    // Of 8 an ulp is 2^-20, of 1008 it is 2^-14.
    for (truth, t, step) in [(&plates[0], 8.0, MOVE), (&plates[1], 1008.0, 64.0 * MOVE)] {
        for part in -24..=24_i32 {
            let end = t + f64::from(part) * step / 8.0;
            for query in [Query::Closest, Query::Any] {
                let ending = truth.answer_one(&Ray64 { t_max: end, ..down(0.25, 0.5) }, query);
                let beginning = truth.answer_one(&Ray64 { t_min: end, ..down(0.25, 0.5) }, query);
                assert_eq!([ending.hit.is_some(), beginning.hit.is_some()], [part >= 0, part <= 0]);
                assert_eq!(
                    ending.is_ambiguous(),
                    if part >= 0 { part < 8 } else { part >= -8 },
                    "{t} {part} {query:?}"
                );
                assert_eq!(
                    beginning.is_ambiguous(),
                    if part <= 0 { part > -8 } else { part <= 8 },
                    "{t} {part} {query:?}"
                );
            }
        }
        let answer = truth.answer_one(&Ray64 { t_max: t, ..down(0.25, 0.5) }, Query::Closest);
        let hit = [true, true, true, true, true, true, true, false];
        assert_eq!(answer.perturbed.unwrap().map(|hit| hit.map(|hit| hit.t)), hit.map(|hit| hit.then_some(t)));
    }
    // Where another surface lies within the tolerance behind, or nearer is another one, losing or finding the plate changes no closest hit.
    let doubled = truth_of(&[square(0.0), square(-1e-5)].concat());
    assert!(!doubled.answer_one(&Ray64 { t_min: 8.0, ..down(0.25, 0.5) }, Query::Closest).is_ambiguous());
    let behind = truth_of(&[square(0.0), square(1.0)].concat());
    assert!(!behind.answer_one(&Ray64 { t_max: 8.0, ..down(0.25, 0.5) }, Query::Closest).is_ambiguous());
    // Infinite ends stay, and the greatest finite ones.
    for t_max in [f64::INFINITY, f64::from(f32::MAX), 1e30] {
        let edge = plates[0].answer_one(&Ray64 { t_max, ..down(1.0, 0.3) }, Query::Closest);
        let perturbed = edge.perturbed.unwrap();
        assert_eq!(perturbed[4..], [edge.hit; 4]);
        assert!(perturbed[..4].iter().any(Option::is_none));
        assert!(!plates[0].answer_one(&Ray64 { t_max, ..down(0.25, 0.5) }, Query::Closest).is_ambiguous());
    }
}

/// Möller and Trumbore in f64 over every triangle; `None` where rounding might decide.
fn decided(triangles: &[[DVec3; 3]], ray: &Ray64) -> Option<Option<TrueHit>> {
    const CLOSE: f64 = 1e-11;
    let mut best: Option<TrueHit> = None;
    for (primitive, [a, b, c]) in triangles.iter().enumerate() {
        let (along, across, from) = (*b - *a, *c - *a, ray.origin - *a);
        let normal = ray.direction.cross(across);
        let determinant = along.dot(normal);
        if determinant.abs() < CLOSE {
            return None;
        }
        let turned = from.cross(along);
        let [u, v, t] = [from.dot(normal), ray.direction.dot(turned), across.dot(turned)].map(|x| x / determinant);
        let inside = u.min(v).min(1.0 - u - v);
        let in_span = (t - ray.t_min).min(ray.t_max - t);
        // Far outside by one measure is outside.
        if inside < -CLOSE || in_span < -CLOSE {
            continue;
        }
        if inside < CLOSE || in_span < CLOSE || best.is_some_and(|best| (best.t - t).abs() < CLOSE) {
            return None;
        }
        if best.is_none_or(|best| t < best.t) {
            best = Some(TrueHit { t, primitive: primitive as u32 });
        }
    }
    Some(best)
}

/// Proves the nine answers and who is ambiguous against a second caster that moves rays by the definition and tries every triangle by
/// another test: over random rays, rays that begin or end at what they hit, rays past edges, and rays that graze.
#[test]
fn nine_answers_by_brute_force() {
    let mut dice = Dice::new(35);
    let scene = soup(&mut dice, 40, 6);
    let truth = scene.truth();
    let triangles: Vec<[DVec3; 3]> =
        scene.triangles.iter().map(|corners| corners.map(|corner| DVec3::from(corner.map(|x| x as f64)))).collect();
    let least = 1e-4 * truth.diagonal();
    let mut numbers = tracebench_tests::Numbers::new(36);
    let (mut compared, mut ambiguous) = ([0; 4], [0; 4]);
    for index in 0..4000_usize {
        let kind = index % 4;
        let corners = triangles[index / 4 % triangles.len()];
        let [u, v] = [numbers.unit(), numbers.unit()].map(|x| 0.05 + 0.4 * x);
        let inner = corners[0] + (corners[1] - corners[0]) * u + (corners[2] - corners[0]) * v;
        let plane = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize_or_zero();
        let (aim, from) = match kind {
            // Onto an edge, and almost in the plane of a triangle.
            2 => (corners[0].lerp(corners[1], u), numbers.point() * 12.0),
            3 => (inner, inner + (corners[1] - corners[0]) * 4.0 + plane * 1e-5 * numbers.unit()),
            _ => (inner, numbers.point() * 12.0),
        };
        let ray = tracebench_tests::ray(from, aim - from);
        let mut ray = Ray64::from(&Ray { t_max: f32::INFINITY, ..ray });
        if kind == 1 {
            // To within an f32 of what it hits, with either end.
            let t = truth.closest(&ray).map_or(1.0, |hit| f64::from(hit.t as f32));
            if index % 8 == 1 { ray.t_max = t } else { ray.t_min = t }
        }
        let ulps = |of: f64| 4.0 * f64::from((of as f32).next_up() - of as f32);
        let largest = ray.origin.abs().max_element().max(least);
        let of_end = |end: f64| if end.is_finite() { ulps(end.max(largest)) } else { 0.0 };
        let (across, upward) = ray.direction.normalize().any_orthonormal_pair();
        let sideways =
            [across, -across, upward, -upward].map(|by| Ray64 { origin: ray.origin + by * ulps(largest), ..ray });
        let ends = [1.0, -1.0].map(|sign| Ray64 { t_min: ray.t_min + sign * of_end(ray.t_min), ..ray });
        let far = [1.0, -1.0].map(|sign| Ray64 { t_max: ray.t_max + sign * of_end(ray.t_max), ..ray });
        let all: Vec<Ray64> = [ray].into_iter().chain(sideways).chain(ends).chain(far).collect();
        let Some(expected) = all.iter().map(|ray| decided(&triangles, ray)).collect::<Option<Vec<_>>>() else {
            continue;
        };
        let same = |one: Option<TrueHit>, other: Option<TrueHit>, within: f64| match (one, other) {
            (Some(one), Some(other)) => (one.t - other.t).abs() <= within,
            (one, other) => one == other,
        };
        let tolerance = |hit: Option<TrueHit>| hit.map_or(0.0, |hit| 1e-4 * hit.t + 1e-6 * truth.diagonal());
        let changes = expected.iter().any(|moved| !same(expected[0], *moved, tolerance(expected[0])));
        let answer = truth.answer_one(&ray, Query::Closest);
        assert_eq!(answer.is_ambiguous(), changes, "{ray:?}: {expected:?}");
        let blocked = expected.iter().any(|moved| moved.is_some() != expected[0].is_some());
        assert_eq!(truth.answer_one(&ray, Query::Any).is_ambiguous(), blocked, "{ray:?}: {expected:?}");
        for (found, wanted) in answer.all().zip(&expected) {
            assert!(same(found, *wanted, 1e-7), "{ray:?}: {found:?}, not {wanted:?}");
        }
        compared[kind] += 1;
        ambiguous[kind] += usize::from(changes);
    }
    assert!(compared.iter().all(|rays| *rays > 500), "{compared:?}");
    assert!(ambiguous[0] < 20 && ambiguous[1] > 300 && ambiguous[2] > 200 && ambiguous[3] > 50, "{ambiguous:?}");
}
