//! How the animated scenes `hangar` and `foliage` move.
#![allow(missing_docs)]

use glam::DVec3;
use tracebench_scenes::{Scene, procedural};

fn to_f64(point: [f32; 3]) -> DVec3 {
    DVec3::from_array(point.map(f64::from))
}

fn positions(scene: &Scene, time_s: f64) -> Vec<DVec3> {
    scene.animation.as_ref().unwrap().positions_at(time_s).unwrap().into_iter().map(to_f64).collect()
}

/// How far the vertex that goes furthest goes, in metres.
fn furthest(from: &[DVec3], to: &[DVec3]) -> f64 {
    from.iter().zip(to).map(|(a, b)| (*b - *a).length()).fold(0.0, f64::max)
}

/// The greatest change of an edge's length, in metres.
fn stretched(scene: &Scene, before: &[DVec3], after: &[DVec3]) -> f64 {
    let edges = scene.mesh.triangles.iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)]);
    edges
        .map(|(from, to)| {
            let length = |points: &[DVec3]| (points[to as usize] - points[from as usize]).length();
            (length(after) - length(before)).abs()
        })
        .fold(0.0, f64::max)
}

/// Proves that what moves in the hangar moves rigidly: no edge changes its length by more than rounding to f32, though
/// vertices travel metres. The leaves of `foliage`, which bend, show that a change would be seen.
#[test]
fn hangar_moves_rigidly() {
    let hangar = procedural("hangar", 0.1).unwrap();
    let rest = positions(&hangar, 0.0);
    for time_s in [0.31, 1.7, 4.0] {
        let later = positions(&hangar, time_s);
        let change = stretched(&hangar, &rest, &later);
        assert!(change < 2e-5, "{change} at {time_s} s");
    }
    let end = positions(&hangar, 4.0);
    assert!(furthest(&rest, &end) > 5.0);
    let moved = rest.iter().zip(&end).filter(|(a, b)| a != b).count();
    assert!(moved > 1000 && moved * 2 < rest.len(), "{moved} of {}", rest.len());
    let foliage = procedural("foliage", 0.1).unwrap();
    assert!(stretched(&foliage, &positions(&foliage, 0.0), &positions(&foliage, 1.7)) > 1e-2);
}

/// Proves that plants sway smoothly (within a sixtieth of a second no vertex goes further than a few centimetres,
/// which it does within a quarter), come back to where they were, and are bent less near the ground.
#[test]
fn foliage_sways() {
    let foliage = procedural("foliage", 0.1).unwrap();
    let rest = positions(&foliage, 0.0);
    for step in 0..12 {
        let time_s = f64::from(step) * 0.33;
        let now = positions(&foliage, time_s);
        let next = furthest(&now, &positions(&foliage, time_s + 1.0 / 60.0));
        assert!(next < 0.08, "{next} m at {time_s} s");
        assert!(furthest(&now, &positions(&foliage, time_s + 0.25)) > 0.08);
        let mut greatest = [0.0_f64; 3];
        for (at, now) in rest.iter().zip(&now) {
            let layer = if at.y < 0.0 { 0 } else { 1 + usize::from(at.y > 3.0) };
            greatest[layer] = greatest[layer].max((*now - *at).length());
        }
        assert!(greatest[0] <= greatest[1] && greatest[1] <= greatest[2], "{greatest:?}");
        assert!(greatest[2] < 2.0, "{greatest:?}");
    }
    assert!(furthest(&rest, &positions(&foliage, 4.0)) < 1e-5);
}
