//! Jars of glass with balls in them: the deepest stacks of layers in the scene.

use glam::{DVec3, dvec3};

use super::Candy;
use crate::procedural::math::{TURN, cos, sin};

/// Where jars stand, and their size in relation to the first.
const JARS: [([f64; 2], f64); 3] = [([-1.4, 0.3], 1.0), ([1.9, -1.5], 1.2), ([-0.4, -2.6], 0.85)];

/// Radius of a ball, in relation to the jar.
const BALL: f64 = 0.078;

/// Up on the outside, down on the inside; about 14 mm of glass.
const WALL: [[f64; 2]; 15] = [
    [0.0, 0.0],
    [0.4, 0.0],
    [0.45, 0.03],
    [0.47, 0.15],
    [0.47, 0.7],
    [0.43, 0.82],
    [0.34, 0.9],
    [0.35, 0.96],
    [0.335, 0.965],
    [0.326, 0.9],
    [0.416, 0.81],
    [0.456, 0.69],
    [0.456, 0.16],
    [0.4, 0.035],
    [0.0, 0.03],
];

/// The lid with its knob.
const LID: [[f64; 2]; 9] = [
    [0.0, 0.97],
    [0.36, 0.97],
    [0.38, 0.99],
    [0.36, 1.02],
    [0.12, 1.06],
    [0.05, 1.08],
    [0.07, 1.13],
    [0.05, 1.17],
    [0.0, 1.18],
];

pub(super) fn build(candy: &mut Candy) {
    for (number, (at, size)) in JARS.into_iter().enumerate() {
        candy.layout.take(at, 0.5 * size);
        candy.place("jar", at, 0.0);
        let Candy { builder, palette, .. } = candy;
        builder.frame = builder.frame.shift(DVec3::Y * -0.01);
        let sized = |knot: [f64; 2]| knot.map(|value| value * size);
        // A multiple of the knots' number, so that the wall keeps its thickness.
        builder.revolve_smooth(palette.glass, [builder.around(52), 14 * builder.along(3)], &WALL.map(sized));
        builder.revolve_smooth(palette.silver, [builder.around(40), 8 * builder.along(3)], &LID.map(sized));
        builder.object_here("balls in the jar");
        for layer in 0..4 {
            // Rings of balls, each layer turned against the one below.
            for (ring, count) in [(0, 1), (1, 6), (2, 12)] {
                for place in 0..count {
                    let angle = TURN * (f64::from(place) + 0.5 * f64::from(layer)) / f64::from(count);
                    let flat = 0.17 * f64::from(ring);
                    let y = 0.03 + BALL + 0.03 + 0.165 * f64::from(layer);
                    let center = dvec3(flat * cos(angle), y, flat * sin(angle)) * size;
                    let material = palette.sweet(number + (3 * layer + 2 * ring + place) as usize);
                    builder.ball(material, center, BALL * size, builder.around(14));
                }
            }
        }
    }
}
