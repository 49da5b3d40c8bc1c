//! The procedural scene `cloth`: that it falls as cloth does.
#![allow(missing_docs)]

use glam::DVec3;
use tracebench_scenes::{Scene, procedural};

/// Radius of the ball, which rests on the floor, in metres.
const RADIUS: f64 = 0.55;

/// The cloth's triangles at a time.
fn cloth(scene: &Scene, time_s: f64) -> Vec<[DVec3; 3]> {
    let positions = scene.animation.as_ref().unwrap().positions_at(time_s).unwrap();
    let each = scene.mesh.triangles.iter().zip(&scene.mesh.triangle_objects);
    each.filter(|&(_, &object)| scene.mesh.objects[object as usize] == "cloth")
        .map(|(triangle, _)| triangle.map(|at| DVec3::from_array(positions[at as usize].map(f64::from))))
        .collect()
}

/// The deepest that a triangle goes into the ball or the floor, at corners, middles of edges and its own middle.
fn depth(triangles: &[[DVec3; 3]]) -> f64 {
    let ball = DVec3::Y * RADIUS;
    let samples = |[a, b, c]: &[DVec3; 3]| {
        [*a, *b, *c, (a + b) / 2.0, (b + c) / 2.0, (c + a) / 2.0, (a + b + c) / 3.0]
            .map(|point| (RADIUS - (point - ball).length()).max(-point.y))
    };
    triangles.iter().flat_map(samples).fold(f64::NEG_INFINITY, f64::max)
}

/// Proves that the cloth never goes into the ball or the floor. Let down by 2 cm it would.
#[test]
fn ball_and_floor_hold() {
    let scene = procedural("cloth", 0.25).unwrap();
    for tenth in (0..=30).step_by(3) {
        let mut triangles = cloth(&scene, f64::from(tenth) / 10.0);
        let found = depth(&triangles);
        assert!(found < 0.0, "{found} m deep at {tenth} tenths of a second");
        if tenth > 10 {
            triangles.iter_mut().flatten().for_each(|point| point.y -= 0.02);
            assert!(depth(&triangles) > 0.0);
        }
    }
}

/// Proves that the cloth is neither stretched nor torn, and that it folds: its area stays within a few per cent while
/// its shadow on the floor loses more than half. A cloth that is pressed flat instead loses its area.
#[test]
fn cloth_folds_and_does_not_stretch() {
    let scene = procedural("cloth", 0.25).unwrap();
    let area = |triangles: &[[DVec3; 3]]| -> f64 {
        triangles.iter().map(|[a, b, c]| (b - a).cross(c - a).length() / 2.0).sum()
    };
    // Of a hundred by hundred cells of 4 cm, those over which something lies.
    let shadow = |triangles: &[[DVec3; 3]]| -> f64 {
        let mut covered = vec![false; 10_000];
        for [a, b, c] in triangles {
            let at = ((a + b + c) / 3.0 + DVec3::splat(2.0)) / 0.04;
            covered[at.x as usize * 100 + at.z as usize] = true;
        }
        covered.iter().filter(|&&covered| covered).count() as f64 * 0.04 * 0.04
    };
    let start = cloth(&scene, 0.0);
    let (area_at_start, shadow_at_start) = (area(&start), shadow(&start));
    assert!((area_at_start / (2.6 * 2.6) - 1.0).abs() < 0.01, "{area_at_start}");
    for time_s in [0.5, 1.0, 2.0, 3.0] {
        let now = cloth(&scene, time_s);
        let ratio = area(&now) / area_at_start;
        assert!((0.93..1.03).contains(&ratio), "{ratio} of the area at {time_s} s");
    }
    let end = cloth(&scene, 3.0);
    assert!(shadow(&end) < 0.5 * shadow_at_start, "{} of {shadow_at_start}", shadow(&end));
    let flat: Vec<[DVec3; 3]> = end.iter().map(|triangle| triangle.map(|point| point.with_y(0.0))).collect();
    assert!(area(&flat) / area_at_start < 0.93);
}

/// Proves that every scale moves alike: corners of the cloth that two scales share lie at the same places at all times.
/// At different times they do not.
#[test]
fn scales_move_alike() {
    let (fine, coarse) = (procedural("cloth", 1.0).unwrap(), procedural("cloth", 0.25).unwrap());
    let corner = |scene: &Scene, time_s: f64| {
        let triangles = cloth(scene, time_s);
        (triangles[0][0], triangles[triangles.len() - 1][1])
    };
    for time_s in [0.0, 0.77, 3.0] {
        assert_eq!(corner(&fine, time_s), corner(&coarse, time_s));
    }
    assert_ne!(corner(&fine, 0.77), corner(&coarse, 0.78));
}
