//! Wound solids: torus knots, springs, chains and gears.

use super::*;

pub(super) fn build(builder: &mut MeshBuilder) {
    torus_knots(builder);
    springs(builder);
    chain(builder);
    gears(builder);
}

/// Closed curves that wind around a ring: `p` times along it while `q` times around its tube.
fn torus_knots(builder: &mut MeshBuilder) {
    for (material, at, [p, q], size, thick) in [
        (ROSE, [0.0, 0.0], [2.0, 3.0], 0.62, 0.1),
        (CHROME, [-3.0, -1.5], [3.0, 4.0], 0.5, 0.06),
        (AMBER, [-3.95, 0.55], [2.0, 5.0], 0.34, 0.05),
    ] {
        place(builder, "knot", at, 0.0, 0.3);
        let foot = [[0.0, 0.0], [0.3, 0.0], [0.3, 0.2], [0.24, 0.24], [0.0, 0.24]];
        builder.revolve_straight(STONE, [40, 3], &foot);
        // On edge, so that one looks through it.
        builder.frame = builder.frame.shift(DVec3::Y * (0.26 + 1.5 * size + thick)).pitch(TURN / 4.0);
        let path = |t: f64| {
            let (along, about) = (TURN * p * t, TURN * q * t);
            let wide = size * (1.0 + 0.45 * cos(about));
            dvec3(wide * cos(along), size * 0.45 * sin(about), wide * sin(along))
        };
        builder.loop_tube(material, [17, 230, 12], path, thick);
    }
}

/// Upright springs, one in the other.
fn springs(builder: &mut MeshBuilder) {
    for (at, height, turns) in [([-1.0, -2.6], 1.3, 6.0), ([1.95, 0.95], 0.8, 4.0), ([0.2, 3.9], 0.9, 5.0)] {
        place(builder, "spring", at, 0.0, 0.0);
        for (number, material) in [GREEN, GOLD].into_iter().enumerate() {
            let (radius, wire) = (0.27 - 0.12 * number as f64, 0.035);
            let path = |t: f64| {
                let angle = TURN * turns * t;
                dvec3(radius * cos(angle), wire + 0.012 + (height - 2.0 * wire) * t, -radius * sin(angle))
            };
            // Ends taper like drawn wire.
            let thick = |t: f64| wire * (0.3 + 0.7 * smoothstep(0.0, 0.02, t) * smoothstep(0.0, 0.02, 1.0 - t));
            builder.tube(material, [10, 140, 15], path, thick);
        }
    }
}

/// Links that go through each other without touching, hanging in the air.
fn chain(builder: &mut MeshBuilder) {
    for (at, links, drop) in [([1.0, 0.3], 4, 1.75), ([-0.6, -1.4], 5, 1.6), ([-1.4, 2.9], 4, 1.4)] {
        place(builder, "chain", at, drop, 0.4);
        for number in 0..links {
            let turned = if number % 2 == 0 { 0.0 } else { TURN / 4.0 };
            let frame = builder.frame.shift(DVec3::Y * (0.21 * number as f64)).yaw(turned).pitch(TURN / 4.0);
            let material = if number == 1 { GOLD } else { glass(number + 3) };
            builder.within(frame, |here| here.torus(material, [10, 28, 8], DVec3::ZERO, [0.14, 0.03]));
        }
    }
}

/// Upright gears that almost touch.
fn gears(builder: &mut MeshBuilder) {
    for (metal, teeth, x, y, phase) in
        [(CHROME, 16, 0.0, 0.45, 0.0), (BRASS, 10, 0.72, 0.62, 0.36), (GOLD, 8, 0.9, 1.15, 0.1)]
    {
        place(builder, "gear", [2.3, 0.1], 0.0, -0.2 * TURN);
        builder.frame = builder.frame.shift(dvec3(x, y, 0.0)).pitch(TURN / 4.0);
        gear(builder, metal, teeth, phase);
    }
}

/// A gear about the frame's y axis, with a hole for its axle: a section that is led once around.
fn gear(builder: &mut MeshBuilder, material: MaterialId, teeth: usize, phase: f64) {
    // Eight points make a tooth; fewer would not.
    let around = teeth * builder.divide(8, 4);
    let pitch = 0.0264 * teeth as f64;
    // Once around the section: up outside, in over the top, down the hole, out below.
    let section = builder.outline(&[[1.0, -0.5], [1.0, 0.5], [0.0, 0.5], [0.0, -0.5]], &[4, 6]);
    builder.turned(material, [section.len(), around], Ends::Looped, |ring, angle| {
        let DVec2 { x: out, y: up } = section[ring];
        let tooth = smoothstep(-0.35, 0.35, cos(angle * teeth as f64 + TURN * phase)) - 0.5;
        let radius = pitch * 0.35 + (pitch * 0.65 + 0.07 * tooth - 0.012) * out;
        dvec3(radius * cos(angle), 0.14 * up, -radius * sin(angle))
    });
}
