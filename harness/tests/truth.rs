//! The f64 ground truth against an oracle in integers: vertices, origins and directions are integers, so hit or miss,
//! the nearest triangle and t are known exactly.

mod exact;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use exact::{Dice, ExactRay, Fraction, Integers, Scene, as_f32, meet, sphere};
use glam::DVec3;
use sha2::{Digest, Sha256};
use tracebench_api::{Geometry, Query, Ray};
use tracebench_harness::progress::Progress;
use tracebench_harness::truth::{Answer, Cache, Ray64, RayFrame, TrueHit, Truth, TruthError, intersect};

/// How far a t may be off where f64 rounds: the numerator's three products and their sum, against the largest of them.
const ROUNDING: f64 = 1e-14;

/// What a comparison found.
#[derive(Debug, Default)]
struct Tally {
    hits: usize,
    misses: usize,
    disputed: Vec<String>,
}

/// Compares hierarchy and brute force with each other (to the bit) and with the oracle. Rays that f64 answers without
/// rounding must agree to the bit, equal t included; of the others those that hang on no exact zero must agree on hit,
/// triangle and, within rounding, t. What hangs on an exact zero that f64 rounds is not decided.
fn compare(truth: &Truth, scene: &Scene, rays: &[ExactRay]) -> Tally {
    let extent = scene.triangles.as_flattened().as_flattened().iter().map(|x| x.abs()).max().unwrap_or(0);
    // Products of three coordinates must fit 53 bits for t to be exact, too.
    let exact_t = extent <= 2048;
    let mut tally = Tally::default();
    for ray in rays {
        let rounded = ray.rounded();
        let found = truth.closest(&rounded);
        let brute = truth.closest_by_brute_force(&rounded);
        let oracle = scene.closest(ray);
        let expected = oracle.hit;
        let exactly = ray.shears_exactly();
        // What f64 decides without rounding, or with zeros far enough away.
        let decided = (exactly || !oracle.on_an_edge) && (exactly && exact_t || !oracle.at_an_end);
        let named = exactly && exact_t || !oracle.on_an_edge && !oracle.at_equal_t;
        let same = match (expected, found) {
            (None, None) => true,
            (Some((t, primitive)), Some(found)) if exactly && exact_t => found == TrueHit { t: t.value(), primitive },
            (Some((t, primitive)), Some(found)) => {
                let length = ray.direction.iter().map(|x| x.abs()).max().unwrap_or(1) as f64;
                let reach = t.value().abs().max(extent as f64 / length);
                (found.t - t.value()).abs() <= ROUNDING * reach && (!named || found.primitive == primitive)
            }
            _ => false,
        };
        if found != brute {
            tally.disputed.push(format!("{ray:?}: hierarchy {found:?}, brute force {brute:?}"));
        } else if decided && !same {
            tally.disputed.push(format!("{ray:?}: truth {found:?}, oracle {expected:?}"));
        }
        if expected.is_some() {
            tally.hits += 1;
        } else {
            tally.misses += 1;
        }
    }
    tally
}

/// Holds truth and oracle together; both hits and misses must occur.
fn agree(scene: &Scene, rays: &[ExactRay]) {
    let tally = compare(&scene.truth(), scene, rays);
    assert!(tally.disputed.is_empty(), "{} of {}: {}", tally.disputed.len(), rays.len(), tally.disputed[0]);
    assert!(tally.hits > rays.len() / 50 && tally.misses > rays.len() / 50, "{} hits of {}", tally.hits, rays.len());
}

fn soup(dice: &mut Dice, count: usize, most: i128) -> Scene {
    Scene { triangles: (0..count).map(|_| dice.triangle(most)).collect() }
}

fn rays(dice: &mut Dice, count: usize, most: i128) -> Vec<ExactRay> {
    let ray = |index: usize| {
        let direction = if index.is_multiple_of(2) { dice.exact_direction() } else { dice.direction(9) };
        ExactRay::endless(dice.vector(most), direction)
    };
    (0..count).map(ray).collect()
}

/// Proves that on random triangles of small integers, where edges, corners, planes that hold the ray, and equal t all
/// occur, the truth is the oracle's to the bit.
#[test]
fn random_soups() {
    let mut dice = Dice::new(1);
    for (count, most) in [(1, 3), (2, 2), (7, 4), (40, 3), (150, 12), (60, 300)] {
        for _ in 0..6 {
            let scene = soup(&mut dice, count, most);
            let tally = compare(&scene.truth(), &scene, &rays(&mut dice, 700, most + 1));
            assert!(tally.disputed.is_empty(), "{} wrong: {}", tally.disputed.len(), tally.disputed[0]);
            assert!(tally.misses > 0 && tally.hits > 0);
        }
    }
}

/// Negative control: a corner moved by one unit, in the truth's scene alone, is noticed.
#[test]
fn the_comparison_notices_a_moved_corner() {
    let mut dice = Dice::new(2);
    let scene = soup(&mut dice, 40, 6);
    let rays = rays(&mut dice, 2000, 7);
    let mut moved = scene.clone();
    moved.triangles[17][1][2] += 1;
    assert!(compare(&scene.truth(), &scene, &rays).disputed.is_empty());
    assert!(!compare(&moved.truth(), &scene, &rays).disputed.is_empty());
}

/// Proves the oracle itself on cases that can be checked by eye: inside, on an edge, on a corner, beside, behind,
/// before and at either end of the span, edge-on, without area.
#[test]
fn the_oracle_is_right_on_simple_cases() {
    let triangle = [[0, 0, 0], [4, 0, 0], [0, 4, 0]];
    let at = |x, y| meet(&ExactRay::endless([x, y, 6], [0, 0, -3]), triangle);
    let inside = at(1, 1);
    assert!(inside.t.is_some_and(|t| t.value() == 2.0) && !inside.on_the_edge);
    for (x, y) in [(0, 0), (4, 0), (2, 2), (0, 3)] {
        assert!(at(x, y).t.is_some() && at(x, y).on_the_edge, "{x} {y}");
    }
    for (x, y) in [(3, 2), (-1, 1), (1, -1)] {
        assert!(at(x, y).t.is_none() && !at(x, y).on_the_edge, "{x} {y}");
    }
    assert!(meet(&ExactRay::endless([1, 1, 6], [0, 0, 1]), triangle).t.is_none());
    assert!(meet(&ExactRay::endless([-1, 1, 0], [1, 0, 0]), triangle).t.is_none());
    assert!(meet(&ExactRay::endless([1, 1, 6], [0, 0, -1]), [[0, 0, 0], [2, 2, 0], [4, 4, 0]]).t.is_none());
    for (above, hits) in [(1, false), (2, true), (3, true)] {
        let t_max = Some(Fraction { above, below: 1 });
        let ray = ExactRay { t_max, ..ExactRay::endless([1, 1, 6], [0, 0, -3]) };
        assert_eq!(meet(&ray, triangle).t.is_some(), hits);
        let ray = ExactRay { t_min: Fraction { above, below: 1 }, ..ExactRay::endless([1, 1, 6], [0, 0, -3]) };
        assert_eq!(meet(&ray, triangle).t.is_some(), above <= 2);
    }
}

/// Where rays from inside a closed surface are sent: exactly at corners and at points along edges, then anywhere.
fn aims(scene: &Scene, dice: &mut Dice, origin: Integers) -> Vec<ExactRay> {
    let towards = |weights: [i128; 3], corners: [Integers; 3]| -> Integers {
        let sum: i128 = weights.iter().sum();
        std::array::from_fn(|axis| {
            (0..3).map(|corner| weights[corner] * corners[corner][axis]).sum::<i128>() - sum * origin[axis]
        })
    };
    let mut rays = Vec::new();
    for corners in &scene.triangles {
        let along = i128::from(dice.below(9)) + 1;
        for weights in [[1, 0, 0], [1, 1, 0], [0, along, 10 - along], [dice.within(5).abs() + 1, 1, 1]] {
            rays.push(ExactRay::endless(origin, towards(weights, *corners)));
        }
    }
    rays
}

/// Proves that no ray leaves a closed surface from inside, whatever f64 rounds: thousands of rays at corners, through
/// edges and through their midpoints, over a round surface, one of needles, and one with slivers beside huge faces.
#[test]
fn closed_surfaces_do_not_leak() {
    let mut dice = Dice::new(3);
    for (scene, within) in [
        (sphere(1000.0, 3, [1, 1, 1]), [300, 300, 300]),
        (sphere(30.0, 3, [1, 20_000, 1]), [10, 100_000, 10]),
        (sphere(9.0, 2, [1, 1, 7]), [2, 2, 20]),
    ] {
        let truth = scene.truth();
        for _ in 0..6 {
            let origin = std::array::from_fn(|axis| dice.within(within[axis]));
            for ray in aims(&scene, &mut dice, origin) {
                let rounded = ray.rounded();
                let found = truth.closest(&rounded);
                assert!(found.is_some(), "{ray:?} leaks");
                assert_eq!(found, truth.closest_by_brute_force(&rounded), "{ray:?}");
                // The oracle says that the nearest crossing is where the truth finds it.
                let Some((t, _)) = scene.closest(&ray).hit else { panic!("the surface is not closed: {ray:?}") };
                let t = t.value();
                assert!(found.is_some_and(|hit| (hit.t - t).abs() <= 1e-12 * (1.0 + t)), "{ray:?} {found:?} {t}");
            }
        }
    }
}

/// Negative control: a closed surface that lost one triangle does leak.
#[test]
fn a_hole_is_noticed() {
    let mut dice = Dice::new(4);
    let scene = sphere(1000.0, 3, [1, 1, 1]);
    let rays = aims(&scene, &mut dice, [3, 5, 7]);
    let mut open = scene;
    open.triangles.remove(100);
    let truth = open.truth();
    assert!(rays.iter().any(|ray| truth.closest(&ray.rounded()).is_none()));
}

/// Proves needles: triangles a unit wide and thousands long, at every angle, rays aimed at points in and just beside
/// them.
#[test]
fn needles() {
    let mut dice = Dice::new(5);
    let needle = |dice: &mut Dice| {
        let (start, along) = (dice.vector(500), dice.direction(1500));
        let end: Integers = std::array::from_fn(|axis| start[axis] + along[axis]);
        let beside: Integers = std::array::from_fn(|axis| start[axis] + if dice.below(3) == 0 { 1 } else { 0 });
        [start, end, beside]
    };
    let scene = Scene { triangles: (0..120).map(|_| needle(&mut dice)).collect() };
    let mut rays = Vec::new();
    for [a, b, _] in &scene.triangles {
        for _ in 0..12 {
            let direction = dice.exact_direction();
            let (share, back) = (i128::from(dice.below(9)), i128::from(dice.below(40)) + 1);
            let origin = std::array::from_fn(|axis| {
                a[axis] + (b[axis] - a[axis]) * share / 8 - back * direction[axis] + dice.within(1)
            });
            rays.push(ExactRay::endless(origin, direction));
        }
    }
    agree(&scene, &rays);
}

/// Proves triangles a million wide among triangles of one unit.
#[test]
fn huge_among_small() {
    let mut dice = Dice::new(6);
    let mut scene = soup(&mut dice, 60, 4);
    scene.triangles.extend((0..10).map(|_| dice.triangle(1_000_000)));
    scene.triangles.push([[-1_000_000, -1_000_000, 3], [1_000_000, -1_000_000, 3], [0, 1_000_000, 3]]);
    let mut rays = rays(&mut dice, 1500, 5);
    rays.extend((0..500).map(|_| ExactRay::endless(dice.vector(1_000_000), dice.exact_direction())));
    agree(&scene, &rays);
}

/// Proves rays along the axes over triangles in axis planes: every answer hangs on zeros there, and rays in a
/// triangle's plane miss it.
#[test]
fn axes_and_axis_planes() {
    let mut dice = Dice::new(7);
    let flat = |dice: &mut Dice| {
        let (axis, level) = (dice.below(3) as usize, dice.within(3));
        dice.triangle(4).map(|mut corner| {
            corner[axis] = level;
            corner
        })
    };
    let scene = Scene { triangles: (0..50).map(|_| flat(&mut dice)).collect() };
    let along = |dice: &mut Dice| {
        let mut direction = [0; 3];
        direction[dice.below(3) as usize] = [1, -1, 2, -4][dice.below(4) as usize];
        ExactRay::endless(dice.vector(6), direction)
    };
    let rays: Vec<ExactRay> = (0..3000).map(|_| along(&mut dice)).collect();
    agree(&scene, &rays);
}

/// Proves that a ray in the plane of a triangle does not hit it, from within or from beside, and that a neighbour that
/// it does cross is found.
#[test]
fn edge_on() {
    let edge_on = Scene { triangles: vec![[[0, 0, 0], [8, 0, 0], [0, 8, 0]]] };
    let truth = edge_on.truth();
    let mut dice = Dice::new(8);
    let in_plane = |dice: &mut Dice| {
        let direction = dice.exact_direction();
        ExactRay::endless([dice.within(9), dice.within(9), 0], [direction[0], direction[1], 0])
    };
    let rays: Vec<ExactRay> =
        (0..500).map(|_| in_plane(&mut dice)).filter(|ray| ray.direction != [0; 3] && ray.shears_exactly()).collect();
    assert!(rays.len() > 200 && rays.iter().all(|ray| truth.closest(&ray.rounded()).is_none()));
    let mut crossed = edge_on;
    crossed.triangles.push([[5, -3, -3], [5, 9, -3], [5, 3, 9]]);
    let tally = compare(&crossed.truth(), &crossed, &rays);
    assert!(tally.disputed.is_empty() && tally.hits > 20, "{tally:?}");
}

/// Proves that triangles without area are hit by nothing and hide nothing.
#[test]
fn triangles_without_area() {
    let mut dice = Dice::new(9);
    let flat = |dice: &mut Dice| {
        let (start, along) = (dice.vector(4), dice.vector(2));
        let at = |factor: i128| std::array::from_fn(|axis| start[axis] + factor * along[axis]);
        [at(0), at(dice.within(2)), at(dice.within(2))]
    };
    let mut scene = Scene { triangles: (0..30).map(|_| flat(&mut dice)).collect() };
    let rays = rays(&mut dice, 1500, 5);
    let truth = scene.truth();
    assert!(rays.iter().filter(|ray| ray.shears_exactly()).all(|ray| truth.closest(&ray.rounded()).is_none()));
    scene.triangles.extend(soup(&mut dice, 20, 4).triangles);
    agree(&scene, &rays);
}

/// Proves that of triangles at equal t the lowest is named, wherever in the hierarchy they are: coplanar duplicates,
/// overlapping ones, and fans that meet in one corner, in several orders.
#[test]
fn equal_t_goes_to_the_lower_triangle() {
    let mut dice = Dice::new(10);
    let mut scene = soup(&mut dice, 40, 5);
    for index in 0..40 {
        let [a, b, c] = scene.triangles[index];
        scene.triangles.push([b, c, a]);
        scene.triangles.push([a, c, b]);
        scene.triangles.push([a, b, std::array::from_fn(|axis| a[axis] + b[axis] - c[axis])]);
    }
    let corner = [1, 1, 1];
    for _ in 0..30 {
        scene.triangles.push([dice.vector(6), corner, dice.vector(6)]);
    }
    let mut rays = rays(&mut dice, 1500, 6);
    for _ in 0..300 {
        let direction = dice.exact_direction();
        rays.push(ExactRay::endless(std::array::from_fn(|axis| corner[axis] - 2 * direction[axis]), direction));
    }
    agree(&scene, &rays);
    scene.triangles.reverse();
    agree(&scene, &rays);
}

/// Proves that both ends of a span belong to it: origins on surfaces with t_min = 0 hit them, a span that begins or
/// ends exactly on a surface hits it, one that stops an ulp short does not.
#[test]
fn spans_end_on_surfaces() {
    let mut dice = Dice::new(11);
    let scene = soup(&mut dice, 60, 5);
    let truth = scene.truth();
    let (mut ends, mut starts, mut on_surface) = (0, 0, 0);
    let candidates: Vec<ExactRay> = rays(&mut dice, 2500, 6).into_iter().filter(ExactRay::shears_exactly).collect();
    for ray in candidates {
        let Some((t, primitive)) = scene.closest(&ray).hit else { continue };
        let ending = ExactRay { t_max: Some(t), ..ray };
        let tally = compare(&truth, &scene, &[ending]);
        assert!(tally.disputed.is_empty() && tally.hits == 1, "{tally:?}");
        ends += 1;
        if t.above == 0 {
            assert_eq!(truth.closest(&ray.rounded()), Some(TrueHit { t: 0.0, primitive }));
            on_surface += 1;
            continue;
        }
        let short = Ray64 { t_max: t.value().next_down(), ..ray.rounded() };
        assert_eq!(truth.closest(&short), None, "{ray:?}");
        let starting = ExactRay { t_min: t, ..ray };
        let tally = compare(&truth, &scene, &[starting]);
        assert!(tally.disputed.is_empty() && tally.hits == 1, "{tally:?}");
        let late = Ray64 { t_min: t.value().next_up(), ..ray.rounded() };
        assert!(truth.closest(&late).is_none_or(|hit| hit.t > t.value()));
        assert_eq!(truth.closest(&late), truth.closest_by_brute_force(&late));
        starts += 1;
    }
    assert!(ends > 200 && starts > 200 && on_surface > 5, "{ends} {starts} {on_surface}");
}

/// Proves the triangle test alone, without any hierarchy: single triangles against single rays.
#[test]
fn single_triangles() {
    let mut dice = Dice::new(12);
    let (mut hits, mut edges) = (0, 0);
    for _ in 0..40_000 {
        let ray = ExactRay::endless(dice.vector(4), dice.exact_direction());
        let triangle = dice.triangle(4);
        let rounded = ray.rounded();
        let found = RayFrame::new(&rounded).and_then(|frame| intersect(&frame, &rounded, triangle.map(as_f32)));
        let meeting = meet(&ray, triangle);
        assert_eq!(found, meeting.t.map(Fraction::value), "{ray:?} {triangle:?}");
        hits += usize::from(found.is_some());
        edges += usize::from(found.is_some() && meeting.on_the_edge);
    }
    assert!(hits > 1500 && edges > 300, "{hits} {edges}");
}

/// Proves that rays without a usable direction or origin hit nothing and break nothing.
#[test]
fn rays_that_are_none() {
    let truth = sphere(10.0, 1, [1, 1, 1]).truth();
    for (origin, direction) in [
        (DVec3::ZERO, DVec3::ZERO),
        (DVec3::ZERO, DVec3::new(f64::NAN, 0.0, 1.0)),
        (DVec3::ZERO, DVec3::new(f64::INFINITY, 0.0, 1.0)),
        (DVec3::new(0.0, f64::NAN, 0.0), DVec3::Z),
        (DVec3::new(0.0, f64::INFINITY, 0.0), DVec3::Z),
    ] {
        let ray = Ray64 { origin, direction, t_min: 0.0, t_max: f64::INFINITY };
        assert_eq!(truth.closest(&ray), None);
        assert!(truth.answer_one(&ray, Query::Closest).hit.is_none());
    }
    let tiny = Ray64 { origin: DVec3::ZERO, direction: DVec3::new(1e-300, 0.0, 1.0), t_min: 0.0, t_max: f64::INFINITY };
    assert_eq!(truth.closest(&tiny).map(|hit| hit.t), Some(10.0));
    let empty = Ray64 { direction: DVec3::Z, t_min: 11.0, t_max: 9.0, ..tiny };
    assert_eq!(truth.closest(&empty), None);
}

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

fn cached_scene() -> (Truth, Arc<Vec<Ray>>) {
    let truth = sphere(100.0, 2, [1, 1, 1]).truth();
    let mut numbers = tracebench_tests::Numbers::new(14);
    let rays = (0..32).map(|_| tracebench_tests::ray(numbers.point() * 150.0, numbers.direction())).collect();
    (truth, Arc::new(rays))
}

fn answer(truth: &Truth, rays: &Arc<Vec<Ray>>, cache: &Cache) -> Result<Vec<Answer>, TruthError> {
    truth.answer(rays, Query::Closest, cache, &Progress::new(true))
}

fn only_file(folder: &Path) -> PathBuf {
    let files: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    assert_eq!(files.len(), 1, "{files:?}");
    files[0].clone()
}

/// Proves that answers are the same without a cache, with an empty one and with a filled one, that queries and scenes do
/// not share answers, and that a damaged file is told anew and mended.
#[test]
fn the_cache_changes_no_answer() {
    let (truth, rays) = cached_scene();
    let folder = tempfile::tempdir().unwrap();
    let cache = Cache::in_folder(folder.path());
    let fresh = answer(&truth, &rays, &Cache::none()).unwrap();
    assert!(fresh.iter().any(|each| each.hit.is_some()) && fresh.iter().any(|each| each.hit.is_none()));
    assert_eq!(answer(&truth, &rays, &cache).unwrap(), fresh);
    let path = only_file(folder.path());
    let stored = std::fs::read(&path).unwrap();
    assert_eq!(answer(&truth, &rays, &cache).unwrap(), fresh);
    for damage in [0, 40, stored.len() - 1] {
        let mut bytes = stored.clone();
        bytes[damage] ^= 0x10;
        std::fs::write(&path, &bytes).unwrap();
        assert_eq!(answer(&truth, &rays, &cache).unwrap(), fresh);
        assert_eq!(std::fs::read(&path).unwrap(), stored, "the file was not mended");
    }
    for shorter in [0, 31, 32, stored.len() - 16] {
        std::fs::write(&path, &stored[..shorter]).unwrap();
        assert_eq!(answer(&truth, &rays, &cache).unwrap(), fresh);
    }
    truth.answer(&rays, Query::Any, &cache, &Progress::new(true)).unwrap();
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2);
    let other = Truth::new(truth.geometry(), "another scene");
    answer(&other, &rays, &cache).unwrap();
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 3);
}

/// Proves that a cache that cannot be written costs nothing but time.
#[test]
fn a_cache_that_cannot_be_written_is_no_error() {
    let (truth, rays) = cached_scene();
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("file");
    std::fs::write(&file, b"in the way").unwrap();
    let answers = answer(&truth, &rays, &Cache::in_folder(&file.join("below"))).unwrap();
    assert_eq!(answers, answer(&truth, &rays, &Cache::none()).unwrap());
}

/// Negative control of the audit: answers that are whole by their digest but wrong in one hit's t, its triangle, or in
/// whether there is one, are refused, with the ray named.
#[test]
fn the_audit_refuses_wrong_answers() {
    let (truth, rays) = cached_scene();
    let folder = tempfile::tempdir().unwrap();
    let cache = Cache::in_folder(folder.path());
    let fresh = answer(&truth, &rays, &cache).unwrap();
    let hit = fresh.iter().position(|each| each.hit.is_some()).unwrap();
    let path = only_file(folder.path());
    let stored = std::fs::read(&path).unwrap();
    // A record is t as f64, the triangle as u32, flags as u32 with bit 0 for a hit; SHA-256 of all follows.
    for (offset, flip) in [(0, 1), (8, 1), (12, 1)] {
        let mut body = stored[..stored.len() - 32].to_vec();
        body[hit * 16 + offset] ^= flip;
        let digest = Sha256::digest(&body);
        body.extend_from_slice(&digest);
        std::fs::write(&path, &body).unwrap();
        match answer(&truth, &rays, &cache) {
            Err(error @ TruthError::Audit { ray, by_brute_force, .. }) => {
                assert_eq!((ray, by_brute_force), (hit, fresh[hit].hit));
                assert!(error.to_string().contains(&folder.path().display().to_string()), "{error}");
            }
            other => panic!("not refused at {offset}: {other:?}"),
        }
    }
    std::fs::write(&path, &stored).unwrap();
    assert_eq!(answer(&truth, &rays, &cache).unwrap(), fresh);
}

/// Proves scenes of one triangle, and of many with the same bounds and centre, for which hierarchies are built in
/// special ways.
#[test]
fn hierarchies_of_odd_scenes() {
    let mut dice = Dice::new(15);
    let one = Scene { triangles: vec![[[0, 0, 0], [8, 1, 0], [2, 8, 3]]] };
    agree(
        &one,
        &(0..800).map(|_| ExactRay::endless([dice.within(6), dice.within(6), 8], [0, 0, -1])).collect::<Vec<_>>(),
    );
    let piled = Scene { triangles: vec![[[-4, -4, 0], [4, -4, 1], [0, 4, 0]]; 500] };
    agree(&piled, &rays(&mut dice, 800, 4));
    let line = Scene { triangles: (0..200).map(|x| [[x, 0, 0], [x, 2, 0], [x, 0, 2]]).collect() };
    let along: Vec<ExactRay> =
        (0..800).map(|_| ExactRay::endless([dice.within(250), dice.within(3), dice.within(3)], [1, 0, 0])).collect();
    agree(&line, &along);
    assert!(Geometry::new(Vec::new(), Vec::new(), None).is_err());
}
