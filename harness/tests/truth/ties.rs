//! Ties.

use super::*;

/// A square of side 2 in the plane z = 0, its diagonal from corner to corner.
fn square(level: f32) -> Vec<[[f32; 3]; 3]> {
    let (a, b, c, d) = ([-1.0, -1.0, level], [1.0, -1.0, level], [1.0, 1.0, level], [-1.0, 1.0, level]);
    vec![[a, b, c], [a, c, d]]
}

fn truth_of(triangles: &[[[f32; 3]; 3]]) -> Truth {
    Truth::new(&tracebench_tests::soup(triangles, None), "ties")
}

/// A ray down from z = 8: an ulp of its largest coordinate is 2^-20, the move that makes a tie 2^-18.
fn down(x: f64, y: f64) -> Ray64 {
    Ray64 { origin: DVec3::new(x, y, 8.0), direction: DVec3::NEG_Z, t_min: 0.0, t_max: f64::INFINITY }
}

const MOVE: f64 = 1.0 / (1 << 18) as f64;

/// Proves the band of ties along the edge of an open square, by the arithmetic of its definition: within four ulp of
/// the largest coordinate a ray is a tie on either side of the edge, and beyond it is none.
#[test]
fn ties_lie_along_open_edges() {
    let truth = truth_of(&square(0.0));
    for step in -24..=24_i32 {
        let beyond = f64::from(step) * MOVE / 8.0;
        for query in [Query::Closest, Query::Any] {
            for ray in [down(1.0 + beyond, 0.3), down(-1.0 - beyond, 0.3), down(0.3, 1.0 + beyond)] {
                let Answer { hit, tie } = truth.answer_one(&ray, query);
                assert_eq!(hit.is_some(), step <= 0, "{step}");
                // Inside it is lost by a move of more than the distance to the edge; outside, a move that reaches the
                // edge finds it.
                assert_eq!(tie, if step <= 0 { step > -8 } else { step <= 8 }, "{step} {query:?}");
            }
        }
    }
}

/// Proves that an edge between two triangles of one flat surface makes no tie, nor does its corner, though either
/// triangle may be named.
#[test]
fn inner_edges_are_no_ties() {
    let truth = truth_of(&square(0.0));
    for at in [-0.5, 0.0, 0.25, 0.75] {
        for offset in [0.0, MOVE / 2.0, -MOVE / 2.0] {
            let answer = truth.answer_one(&down(at + offset, at), Query::Closest);
            assert!(answer.hit.is_some_and(|hit| hit.t == 8.0) && !answer.tie, "{at} {offset}");
        }
        assert_eq!(truth.answer_one(&down(at, at), Query::Closest).hit.map(|hit| hit.primitive), Some(0));
    }
}

/// Proves that whether a ray is a tie depends on what was asked: at the edge of a plate before a wall the nearest hit
/// jumps, but there is a hit either way.
#[test]
fn ties_depend_on_the_query() {
    let mut triangles = square(0.0);
    triangles.extend(square(-1.0).iter().map(|triangle| triangle.map(|[x, y, z]| [x * 4.0, y * 4.0, z])));
    let truth = truth_of(&triangles);
    assert!(truth.answer_one(&down(1.0, 0.3), Query::Closest).tie);
    assert!(!truth.answer_one(&down(1.0, 0.3), Query::Any).tie);
    // Beyond the tolerance: a step in depth as small as that is none.
    let lowered: Vec<_> = square(0.0)
        .into_iter()
        .chain(square(-1e-6).iter().map(|triangle| triangle.map(|[x, y, z]| [x * 4.0, y * 4.0, z])))
        .collect();
    assert!(!truth_of(&lowered).answer_one(&down(1.0, 0.3), Query::Closest).tie);
    // At the edge of both, a ray may hit nothing.
    assert!(truth.answer_one(&down(4.0, 0.3), Query::Any).tie);
}

/// Proves the ends of spans: a ray that ends on a slanted surface is a tie, since a move to the side loses it, one that
/// ends on a surface square to it is none, and one that ends well before is none.
#[test]
fn ties_at_the_end_of_a_span() {
    let slanted: Vec<_> = square(0.0).iter().map(|triangle| triangle.map(|[x, y, _]| [x, y, 2.0 * x])).collect();
    let (flat, slanted) = (truth_of(&square(0.0)), truth_of(&slanted));
    let ending = |t_max: f64| Ray64 { t_max, ..down(0.0, 0.25) };
    for query in [Query::Closest, Query::Any] {
        assert!(slanted.answer_one(&ending(8.0), query).tie);
        assert!(slanted.answer_one(&ending(8.0 - MOVE), query).tie);
        assert!(!slanted.answer_one(&ending(8.1), query).tie);
        assert!(!slanted.answer_one(&ending(7.9), query).tie);
        assert!(!flat.answer_one(&ending(8.0), query).tie);
        assert!(!flat.answer_one(&ending(8.0 - MOVE), query).tie);
    }
}

/// Proves that ties are a property of ray and surface: neither the order of the triangles nor duplicates change them.
#[test]
fn ties_do_not_depend_on_the_order_of_triangles() {
    let mut dice = Dice::new(13);
    let scene = soup(&mut dice, 60, 6);
    let mut shuffled = scene.clone();
    shuffled.triangles.reverse();
    shuffled.triangles.extend(scene.triangles[..20].iter().map(|[a, b, c]| [*b, *c, *a]));
    let (truth, other) = (scene.truth(), shuffled.truth());
    let mut ties = [0, 0];
    for ray in rays(&mut dice, 3000, 7) {
        for query in [Query::Closest, Query::Any] {
            let [first, second] = [&truth, &other].map(|truth| truth.answer_one(&ray.rounded(), query));
            assert_eq!((first.tie, first.hit.is_some()), (second.tie, second.hit.is_some()), "{ray:?}");
            let near = first.hit.zip(second.hit).is_none_or(|(a, b)| (a.t - b.t).abs() <= 1e-12 * (1.0 + a.t));
            // An any-hit ray is no tie where only t hangs on rounding.
            assert!(near || first.tie || query == Query::Any, "{ray:?} {first:?} {second:?}");
            ties[usize::from(first.tie)] += 1;
        }
    }
    assert!(ties[0] > 500 && ties[1] > 50, "{ties:?}");
}

/// Proves that a tie stays one when ray and scene are moved together, wherever the coordinates' origin lies: an eye on a
/// floor that is the plane of a coordinate hangs on rounding no less than one on a floor beside it. An eye above the
/// floor by more than the move is no tie in any place.
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
            assert!(truth.answer_one(&from(0.0), Query::Closest).tie, "{by:?} {direction}");
            assert!(truth.answer_one(&from(0.0), Query::Any).tie, "{by:?} {direction}");
            assert!(!truth.answer_one(&from(16.0 * step), Query::Any).tie, "{by:?} {direction}");
            assert!(!truth.answer_one(&from(-16.0 * step), Query::Any).tie, "{by:?} {direction}");
        }
    }
}
