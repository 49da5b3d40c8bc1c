//! A gingerbread man who waves, and a jelly bear that walks in a circle around him.

use glam::{DVec2, DVec3, dvec2, dvec3};

use super::sticks::rounded;
use super::{Candy, DURATION_S, height};
use crate::procedural::math::{Frame, TURN, cos, sin};

/// Where the gingerbread man stands.
const MAN: [f64; 2] = [-0.2, -0.2];
/// Radius of the bear's walk around him, in metres.
const WALK: f64 = 0.62;

pub(super) fn build(candy: &mut Candy) {
    candy.layout.take(MAN, WALK + 0.3);
    man(candy);
    bear(candy);
}

/// A flat limb with round ends.
fn limb(candy: &mut Candy, divisions: [usize; 2], [from, to]: [DVec3; 2], size: DVec2) {
    let Candy { builder, palette, .. } = candy;
    let length = (to - from).length();
    // Across the limb, within the plane of the cookie.
    let side = (to - from).cross(DVec3::Z).normalize_or(DVec3::X);
    let [around, along] = [builder.around(divisions[0]), builder.divide(divisions[1], 4)];
    builder.ribbon(
        palette.dough,
        [around, along],
        Some(side),
        |t| from + (to - from) * t,
        |t| {
            let round = rounded(size.x, t.min(1.0 - t) * length) / size.x;
            dvec2(size.x * round, size.y * (0.35 + 0.65 * round))
        },
    );
}

fn man(candy: &mut Candy) {
    let beat = TURN * candy.time_s / DURATION_S;
    candy.place("gingerbread man", MAN, 0.62 + 0.12 * sin(beat));
    let bob = 0.018 * (1.0 - cos(4.0 * beat));
    let sway = 0.05 * sin(2.0 * beat);
    candy.builder.frame = candy.builder.frame.roll(sway);
    let up = DVec3::Y * bob;
    // Legs step in place.
    for (side, phase) in [(-1.0, 0.0), (1.0, TURN / 2.0)] {
        let step = sin(2.0 * beat + phase);
        let hip = dvec3(0.09 * side, 0.46, 0.0) + up;
        let foot = dvec3(0.16 * side, 0.04 + 0.07 * step.max(0.0), 0.1 * step);
        limb(candy, [30, 34], [hip, foot], dvec2(0.095, 0.06));
    }
    // One arm waves, the other swings.
    let wave = 0.75 + 0.45 * sin(4.0 * beat);
    let swing = -0.45 + 0.25 * sin(2.0 * beat);
    for (side, raised) in [(-1.0, wave), (1.0, swing)] {
        let shoulder = dvec3(0.13 * side, 0.74, 0.0) + up;
        let hand = shoulder + dvec3(0.4 * side * cos(raised), 0.4 * sin(raised), 0.03);
        limb(candy, [30, 34], [shoulder, hand], dvec2(0.08, 0.055));
    }
    limb(candy, [40, 40], [dvec3(0.0, 0.33, 0.0) + up, dvec3(0.0, 0.88, 0.0) + up], dvec2(0.19, 0.066));
    let nod = 0.1 * sin(2.0 * beat + 0.6);
    let Candy { builder, palette, .. } = candy;
    for button in 0..3 {
        let at = dvec3(0.0, 0.5 + 0.11 * f64::from(button), 0.066) + up;
        builder.ball(palette.sweet(button as usize), at, 0.026, builder.around(16));
    }
    builder.frame = builder.frame.shift(dvec3(0.0, 0.99, 0.0) + up).roll(nod);
    builder.ellipsoid(palette.dough, DVec3::ZERO, dvec3(0.19, 0.185, 0.075), builder.around(48));
    for side in [-1.0, 1.0] {
        builder.ball(palette.white, dvec3(0.07 * side, 0.04, 0.066), 0.028, builder.around(16));
        builder.ball(palette.chocolate, dvec3(0.07 * side, 0.04, 0.088), 0.013, builder.around(12));
    }
    let smile = |t: f64| {
        let angle = TURN * (0.6 + 0.3 * t);
        dvec3(0.09 * cos(angle), 0.01 + 0.09 * sin(angle), 0.072)
    };
    builder.tube(palette.white, builder.bent(10, [24, 4]), smile, |t| rounded(0.013, t.min(1.0 - t) * 0.17));
}

/// Walks counter-clockwise, seen from above, and looks where it goes.
fn bear(candy: &mut Candy) {
    let turn = TURN * candy.time_s / DURATION_S + 0.9;
    let at = [MAN[0] + WALK * cos(turn), MAN[1] - WALK * sin(turn)];
    candy.builder.object("jelly bear");
    let stride = 6.0 * turn;
    let up = height(at[0], at[1]) + 0.012 * cos(2.0 * stride);
    let Candy { builder, palette, .. } = candy;
    // The bear's face looks along its own +z.
    let frame = Frame::at(dvec3(at[0], up, at[1])).yaw(turn + TURN / 2.0).roll(0.06 * sin(stride));
    let jelly = palette.orange;
    builder.frame = frame;
    builder.ellipsoid(jelly, dvec3(0.0, 0.27, 0.0), dvec3(0.125, 0.16, 0.11), builder.around(44));
    builder.ellipsoid(jelly, dvec3(0.0, 0.47, 0.015), dvec3(0.11, 0.1, 0.1), builder.around(40));
    builder.ellipsoid(jelly, dvec3(0.0, 0.45, 0.105), dvec3(0.05, 0.04, 0.04), builder.around(24));
    builder.ball(palette.chocolate, dvec3(0.0, 0.463, 0.143), 0.013, builder.around(10));
    builder.torus(palette.gold, builder.bent(10, [30, 5]), dvec3(0.0, 0.395, 0.0), [0.085, 0.014]);
    for side in [-1.0, 1.0] {
        let swing = 0.55 * sin(stride) * side;
        builder.frame = frame;
        builder.ellipsoid(jelly, dvec3(0.08 * side, 0.55, 0.0), dvec3(0.04, 0.045, 0.025), builder.around(20));
        builder.ball(palette.chocolate, dvec3(0.042 * side, 0.5, 0.098), 0.012, builder.around(10));
        builder.frame = frame.shift(dvec3(0.075 * side, 0.19, 0.0)).pitch(swing);
        builder.ellipsoid(jelly, dvec3(0.0, -0.08, 0.015), dvec3(0.062, 0.115, 0.07), builder.around(28));
        builder.frame = frame.shift(dvec3(0.125 * side, 0.36, 0.0)).pitch(-1.2 * swing).roll(0.35 * side);
        builder.ellipsoid(jelly, dvec3(0.0, -0.075, 0.0), dvec3(0.042, 0.1, 0.045), builder.around(24));
    }
}
