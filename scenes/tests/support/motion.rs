//! Compares positions at a time with numbers worked out in f64.

use tracebench_scenes::Scene;

/// Rounding of an answer to f32, with coordinates up to 20.
const TOLERANCE: f64 = 2e-6;

/// The positions of an animated scene at a time in seconds.
pub fn at(scene: &Scene, time_s: f64) -> Vec<[f32; 3]> {
    scene.animation.as_ref().expect("an animation").positions_at(time_s).expect("positions")
}

/// The greatest difference between two coordinates.
pub fn far(got: &[[f32; 3]], wanted: &[[f64; 3]]) -> f64 {
    assert_eq!(got.len(), wanted.len());
    let differences = got.iter().flatten().zip(wanted.iter().flatten());
    differences.map(|(&got, &wanted)| (f64::from(got) - wanted).abs()).fold(0.0, f64::max)
}

/// `got` must be `wanted`, and must be told from it when one coordinate is off by a thousandth.
#[track_caller]
pub fn same(got: &[[f32; 3]], wanted: &[[f64; 3]]) {
    assert!(far(got, wanted) < TOLERANCE, "{got:?} for {wanted:?}");
    let mut corrupted = wanted.to_vec();
    corrupted[1][2] += 1e-3;
    assert!(far(got, &corrupted) > TOLERANCE, "the comparison is blind");
}
