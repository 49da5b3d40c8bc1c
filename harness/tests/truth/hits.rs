//! Hits against the oracle.

use super::*;

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
