//! Hostile rays are what their kinds say, and of each kind some have one answer.

use itertools::Itertools as _;

use super::*;
use crate::rays::hostile::KINDS;
use crate::rays::order::TILE;

fn hostile_kind(pixel: Pixel) -> &'static str {
    KINDS[pixel as usize % KINDS.len()].0
}

/// Proves that in the room and round a solid a quarter of each kind at least is unambiguous, and that of all rays some are ambiguous;
/// that directions have unit length, and that they repeat.
#[test]
fn a_quarter_of_each_kind_has_one_answer() {
    for (name, scene) in [("room", TestScene::room()), ("solid", TestScene::solid())] {
        let made = scene.made(&HOSTILE, [80, 60]);
        assert!(made.rays.iter().all(|ray| (direction(ray).length() - 1.0).abs() < 1e-6 && origin(ray).is_finite()));
        assert_eq!(bits(&made.rays), bits(&scene.made(&HOSTILE, [80, 60]).rays));
        let ambiguous: Vec<bool> = scene.tell(&made.rays).iter().map(Answer::is_ambiguous).collect();
        assert!(ambiguous.contains(&true), "{name}");
        for (kind, _) in KINDS {
            let of_kind = made.pixels.iter().zip(&ambiguous).filter(|(pixel, _)| hostile_kind(**pixel) == kind);
            let (all, sure) = of_kind.fold((0, 0), |(all, sure), (_, is)| (all + 1, sure + usize::from(!is)));
            assert!(all > 400 && 4 * sure >= all, "{name}, {kind}: {sure} of {all}");
        }
    }
}

/// Proves that kinds are what they say: zeros with a sign, numbers below the least normal one, spans of a point, origins far away.
#[test]
fn kinds_are_what_they_say() {
    let scene = TestScene::solid();
    let made = scene.made(&HOSTILE, [80, 60]);
    let of = |kind: &str| -> Vec<Ray> {
        let of_kind = made.pixels.iter().zip(made.rays.iter()).filter(|(pixel, _)| hostile_kind(**pixel) == kind);
        of_kind.map(|(_, ray)| *ray).collect()
    };
    let is_negative_zero = |part: &f32| part.to_bits() == (-0.0_f32).to_bits();
    assert!(of("with -0.0").iter().all(|ray| ray.direction.iter().any(is_negative_zero)));
    assert!(of("with denormals").iter().all(|ray| ray.direction.iter().any(|part| part.is_subnormal())));
    assert!(of("of no length").iter().all(|ray| ray.t_min == ray.t_max));
    assert!(of("along axes").iter().all(|ray| ray.direction.iter().filter(|part| **part == 0.0).count() == 2));
    assert!(of("from far away").iter().all(|ray| origin(ray).length() > 30.0));
    // A kind is none of the others.
    assert!(!of("through vertices").iter().any(|ray| ray.direction.iter().any(is_negative_zero)));
}

/// Proves that rays go through what their kind names: a vertex, an edge, along an edge, through a corner of tiles of the frame, where faces of a
/// cube meet, from a surface. Random rays (the negative control) do none of it.
#[test]
fn kinds_go_through_what_they_name() {
    let mut scene = TestScene::solid();
    scene.viewpoint.frame = [64, 48];
    let made = scene.made(&HOSTILE, [80, 60]);
    let geometry = scene.truth.geometry();
    let near = 1e-5 * scene.truth.diagonal();
    let triangles = || (0..geometry.triangles.len() as u32).map(|of| geometry.corners(of).map(Vec3::as_dvec3));
    let edges = || triangles().flat_map(|[a, b, c]| [[a, b], [b, c], [c, a]]);
    // How far a ray's line passes a point.
    let off = |ray: &Ray, point: DVec3| (point - origin(ray)).cross(direction(ray)).length();
    let crosses = |ray: &Ray, [from, to]: [DVec3; 2]| {
        let normal = (to - from).cross(direction(ray));
        let apart = (from - origin(ray)).dot(normal.normalize_or_zero()).abs();
        // Where the edge comes nearest to the line, as a share of the edge.
        let at = (origin(ray) - from).cross(direction(ray)).dot(normal) / normal.length_squared();
        apart < near && (0.0..=1.0).contains(&at)
    };
    let view = scene.viewpoint.frame_view();
    let tiles = (0..=scene.viewpoint.frame[0]).cartesian_product(0..=scene.viewpoint.frame[1]);
    let corners: Vec<DVec3> = (tiles.filter(|(x, y)| x % TILE == 0 && y % TILE == 0))
        .map(|(x, y)| view.direction_through(f64::from(x), f64::from(y)).normalize())
        .collect();
    let is_of_eye = |ray: &Ray| (origin(ray) - scene.viewpoint.eye.as_dvec3()).length() < near;
    let is_true = |kind: &str, ray: &Ray| match kind {
        "through vertices" => triangles().flatten().any(|vertex| off(ray, vertex) < near),
        "through edges" => edges().any(|edge| crosses(ray, edge)),
        "along edges" => edges().any(|[from, to]| {
            let along = (to - from).normalize().cross(direction(ray)).length() < 1e-6;
            along && off(ray, from) < 2e-3 * scene.truth.diagonal()
        }),
        "through borders of tiles" => {
            is_of_eye(ray) && corners.iter().any(|corner| corner.cross(direction(ray)).length() < 1e-6)
        }
        "through borders of faces" => {
            let mut parts = ray.direction.map(f32::abs);
            parts.sort_by(f32::total_cmp);
            is_of_eye(ray) && parts[2] - parts[1] < 1e-6
        }
        "from surfaces" => scene.truth.nearest(origin(ray), near).is_some(),
        _ => panic!("{kind}"),
    };
    let random = scene.make("random");
    for (kind, _) in &KINDS[..] {
        if ["along axes", "with -0.0", "with denormals", "of no length", "from far away"].contains(kind) {
            continue;
        }
        let of_kind = made.pixels.iter().zip(made.rays.iter()).filter(|(pixel, _)| hostile_kind(**pixel) == *kind);
        let wrong = of_kind.filter(|(_, ray)| !is_true(kind, ray)).count();
        let by_chance = random.iter().filter(|ray| is_true(kind, ray)).count();
        assert!(wrong == 0 && by_chance * 20 < random.len(), "{kind}: {wrong}, {by_chance} of {}", random.len());
    }
}
