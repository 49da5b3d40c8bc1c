//! A gingerbread man who waves, and a jelly bear that walks in a circle around him.

use super::sticks::rounded;
use super::*;

/// Where the gingerbread man stands.
const MAN: [f64; 2] = [-0.2, -0.2];
/// Radius of the bear's walk around him, in metres.
const WALK: f64 = 0.62;

pub(super) fn build(builder: &mut MeshBuilder, layout: &mut Layout, time_s: f64) {
    layout.take(MAN, WALK + 0.3);
    man(builder, TURN * time_s / DURATION_S);
    bear(builder, TURN * time_s / DURATION_S + 0.9);
}

/// A flat limb with round ends.
fn limb(builder: &mut MeshBuilder, [around, along]: [usize; 2], [from, to]: [DVec3; 2], size: DVec2) {
    let length = (to - from).length();
    // Across the limb, within the plane of the cookie.
    let side = (to - from).cross(DVec3::Z).normalize_or(DVec3::X);
    builder.ribbon(DOUGH, [around, along, 4], Some(side), line([from, to]), |t| {
        let round = rounded(size.x, t.min(1.0 - t) * length) / size.x;
        dvec2(size.x * round, size.y * (0.35 + 0.65 * round))
    });
}

fn man(builder: &mut MeshBuilder, beat: f64) {
    place(builder, "gingerbread man", MAN, 0.62 + 0.12 * sin(beat));
    builder.frame = builder.frame.roll(0.05 * sin(2.0 * beat));
    let up = DVec3::Y * (0.018 * (1.0 - cos(4.0 * beat)));
    // Legs step in place.
    for (side, phase) in [(-1.0, 0.0), (1.0, TURN / 2.0)] {
        let step = sin(2.0 * beat + phase);
        let hip = dvec3(0.09 * side, 0.46, 0.0) + up;
        let foot = dvec3(0.16 * side, 0.04 + 0.07 * step.max(0.0), 0.1 * step);
        limb(builder, [30, 34], [hip, foot], dvec2(0.095, 0.06));
    }
    // One arm waves, the other swings.
    let wave = 0.75 + 0.45 * sin(4.0 * beat);
    let swing = -0.45 + 0.25 * sin(2.0 * beat);
    for (side, raised) in [(-1.0, wave), (1.0, swing)] {
        let shoulder = dvec3(0.13 * side, 0.74, 0.0) + up;
        let hand = shoulder + dvec3(0.4 * side * cos(raised), 0.4 * sin(raised), 0.03);
        limb(builder, [30, 34], [shoulder, hand], dvec2(0.08, 0.055));
    }
    limb(builder, [40, 40], [dvec3(0.0, 0.33, 0.0) + up, dvec3(0.0, 0.88, 0.0) + up], dvec2(0.19, 0.066));
    for button in 0..3 {
        builder.ball(sweet(button), dvec3(0.0, 0.5 + 0.11 * button as f64, 0.066) + up, 0.026, 16);
    }
    builder.frame = builder.frame.shift(dvec3(0.0, 0.99, 0.0) + up).roll(0.1 * sin(2.0 * beat + 0.6));
    builder.ellipsoid(DOUGH, DVec3::ZERO, dvec3(0.19, 0.185, 0.075), 48);
    for side in [-1.0, 1.0] {
        builder.ball(WHITE, dvec3(0.07 * side, 0.04, 0.066), 0.028, 16);
        builder.ball(CHOCOLATE, dvec3(0.07 * side, 0.04, 0.088), 0.013, 12);
    }
    let smile = |t: f64| {
        let angle = TURN * (0.6 + 0.3 * t);
        dvec3(0.09 * cos(angle), 0.01 + 0.09 * sin(angle), 0.072)
    };
    builder.tube(WHITE, [10, 24, 4], smile, |t| rounded(0.013, t.min(1.0 - t) * 0.17));
}

/// Walks counter-clockwise, seen from above, and looks where it goes.
fn bear(builder: &mut MeshBuilder, turn: f64) {
    let at = [MAN[0] + WALK * cos(turn), MAN[1] - WALK * sin(turn)];
    let stride = 6.0 * turn;
    let up = height(at[0], at[1]) + 0.012 * cos(2.0 * stride);
    // The bear's face looks along its own +z.
    let frame = Frame::at(dvec3(at[0], up, at[1])).yaw(turn + TURN / 2.0).roll(0.06 * sin(stride));
    let jelly = ORANGE;
    builder.object_at("jelly bear", frame);
    builder.ellipsoid(jelly, dvec3(0.0, 0.27, 0.0), dvec3(0.125, 0.16, 0.11), 44);
    builder.ellipsoid(jelly, dvec3(0.0, 0.47, 0.015), dvec3(0.11, 0.1, 0.1), 40);
    builder.ellipsoid(jelly, dvec3(0.0, 0.45, 0.105), dvec3(0.05, 0.04, 0.04), 24);
    builder.ball(CHOCOLATE, dvec3(0.0, 0.463, 0.143), 0.013, 10);
    builder.torus(GOLD, [10, 30, 5], dvec3(0.0, 0.395, 0.0), [0.085, 0.014]);
    for side in [-1.0, 1.0] {
        let swing = 0.55 * sin(stride) * side;
        builder.frame = frame;
        builder.ellipsoid(jelly, dvec3(0.08 * side, 0.55, 0.0), dvec3(0.04, 0.045, 0.025), 20);
        builder.ball(CHOCOLATE, dvec3(0.042 * side, 0.5, 0.098), 0.012, 10);
        builder.frame = frame.shift(dvec3(0.075 * side, 0.19, 0.0)).pitch(swing);
        builder.ellipsoid(jelly, dvec3(0.0, -0.08, 0.015), dvec3(0.062, 0.115, 0.07), 28);
        builder.frame = frame.shift(dvec3(0.125 * side, 0.36, 0.0)).pitch(-1.2 * swing).roll(0.35 * side);
        builder.ellipsoid(jelly, dvec3(0.0, -0.075, 0.0), dvec3(0.042, 0.1, 0.045), 24);
    }
}
