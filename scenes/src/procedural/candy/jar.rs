//! Jars of glass with balls in them: the deepest stacks of layers in the scene.

use super::*;

/// Where jars stand, and their size in relation to the first.
const JARS: [([f64; 2], f64); 3] = [([-1.4, 0.3], 1.0), ([1.9, -1.5], 1.2), ([-0.4, -2.6], 0.85)];

/// Radius of a ball, in relation to the jar.
const BALL: f64 = 0.078;

pub(super) fn build(builder: &mut MeshBuilder, layout: &mut Layout) {
    // Up on the outside, down on the inside; about 14 mm of glass.
    let wall = knots(
        [0.0, 0.4, 0.45, 0.47, 0.47, 0.43, 0.34, 0.35, 0.335, 0.326, 0.416, 0.456, 0.456, 0.4, 0.0],
        [0.0, 0.0, 0.03, 0.15, 0.7, 0.82, 0.9, 0.96, 0.965, 0.9, 0.81, 0.69, 0.16, 0.035, 0.03],
    );
    // With its knob.
    let lid = knots(
        [0.0, 0.36, 0.38, 0.36, 0.12, 0.05, 0.07, 0.05, 0.0],
        [0.97, 0.97, 0.99, 1.02, 1.06, 1.08, 1.13, 1.17, 1.18],
    );
    for (number, (at, size)) in JARS.into_iter().enumerate() {
        layout.take(at, 0.5 * size);
        place(builder, "jar", at, 0.0);
        builder.frame = builder.frame.shift(DVec3::Y * -0.01);
        let sized = |knot: [f64; 2]| knot.map(|value| value * size);
        // A multiple of the knots' number, so that the wall keeps its thickness.
        builder.revolve(GLASS, 52, &smooth_profile(&wall.map(sized), 14 * builder.along(3)));
        builder.revolve(SILVER, 40, &smooth_profile(&lid.map(sized), 8 * builder.along(3)));
        builder.object_here("balls in the jar");
        for layer in 0..4 {
            // Rings of balls, each layer turned against the one below.
            for (ring, count) in [(0, 1), (1, 6), (2, 12)] {
                for place in 0..count {
                    let angle = TURN * (f64::from(place) + 0.5 * f64::from(layer)) / f64::from(count);
                    let flat = 0.17 * f64::from(ring);
                    let y = 0.03 + BALL + 0.03 + 0.165 * f64::from(layer);
                    let center = dvec3(flat * cos(angle), y, flat * sin(angle)) * size;
                    let material = sweet(number + (3 * layer + 2 * ring + place) as usize);
                    builder.ball(material, center, BALL * size, 14);
                }
            }
        }
    }
}
