//! The f64 ground truth against an oracle in integers: vertices, origins and directions are integers, so hit or miss,
//! the nearest triangle and t are known exactly.

mod ambiguous_rays;
mod caching;
mod exact;
mod hits;
mod pieces;

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
