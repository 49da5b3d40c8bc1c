//! Wound solids: torus knots, springs, chains and gears.

use glam::{DVec3, dvec3};

use super::Solids;
use crate::procedural::builder::{Ends, MaterialId};
use crate::procedural::math::{TURN, cos, sin, smoothstep};

pub(super) fn build(solids: &mut Solids) {
    knots(solids);
    springs(solids);
    chain(solids);
    gears(solids);
}

/// Closed curves that wind around a ring: `p` times along it while `q` times around its tube.
fn knots(solids: &mut Solids) {
    let (rose, chrome, amber) = (solids.palette.rose, solids.palette.chrome, solids.palette.amber);
    for (material, at, [p, q], size, thick) in [
        (rose, [0.0, 0.0], [2.0, 3.0], 0.62, 0.1),
        (chrome, [-3.0, -1.5], [3.0, 4.0], 0.5, 0.06),
        (amber, [-3.95, 0.55], [2.0, 5.0], 0.34, 0.05),
    ] {
        solids.place("knot", at, 0.0, 0.3);
        let Solids { builder, palette } = solids;
        let foot = [[0.0, 0.0], [0.3, 0.0], [0.3, 0.2], [0.24, 0.24], [0.0, 0.24]];
        builder.revolve_straight(palette.stone, builder.round(40, 3), &foot);
        // On edge, so that one looks through it.
        builder.frame = builder.frame.shift(DVec3::Y * (0.26 + 1.5 * size + thick)).pitch(TURN / 4.0);
        let path = |t: f64| {
            let (along, about) = (TURN * p * t, TURN * q * t);
            let wide = size * (1.0 + 0.45 * cos(about));
            dvec3(wide * cos(along), size * 0.45 * sin(about), wide * sin(along))
        };
        builder.loop_tube(material, builder.bent(17, [230, 12]), path, thick);
    }
}

/// Upright springs, one in the other.
fn springs(solids: &mut Solids) {
    for (at, height, turns) in [([-1.0, -2.6], 1.3, 6.0), ([1.95, 0.95], 0.8, 4.0), ([0.2, 3.9], 0.9, 5.0)] {
        solids.place("spring", at, 0.0, 0.0);
        let Solids { builder, palette } = solids;
        for (number, material) in [palette.green, palette.gold].into_iter().enumerate() {
            let (radius, wire) = (0.27 - 0.12 * number as f64, 0.035);
            let path = |t: f64| {
                let angle = TURN * turns * t;
                dvec3(radius * cos(angle), wire + 0.012 + (height - 2.0 * wire) * t, -radius * sin(angle))
            };
            // Ends taper like drawn wire.
            let thick = |t: f64| wire * (0.3 + 0.7 * smoothstep(0.0, 0.02, t) * smoothstep(0.0, 0.02, 1.0 - t));
            builder.tube(material, builder.bent(10, [140, 15]), path, thick);
        }
    }
}

/// Links that go through each other without touching, hanging in the air.
fn chain(solids: &mut Solids) {
    for (at, links, drop) in [([1.0, 0.3], 4, 1.75), ([-0.6, -1.4], 5, 1.6), ([-1.4, 2.9], 4, 1.4)] {
        solids.place("chain", at, drop, 0.4);
        for number in 0..links {
            let Solids { builder, palette } = solids;
            let turned = if number % 2 == 0 { 0.0 } else { TURN / 4.0 };
            let frame = builder.frame;
            builder.frame = frame.shift(DVec3::Y * (0.21 * f64::from(number))).yaw(turned).pitch(TURN / 4.0);
            let material = if number == 1 { palette.gold } else { palette.glass(number as usize + 3) };
            builder.torus(material, builder.bent(10, [28, 8]), DVec3::ZERO, [0.14, 0.03]);
            builder.frame = frame;
        }
    }
}

/// Upright gears that almost touch.
fn gears(solids: &mut Solids) {
    let metals = [solids.palette.chrome, solids.palette.brass, solids.palette.gold];
    for (number, (teeth, x, y, phase)) in
        [(16, 0.0, 0.45, 0.0), (10, 0.72, 0.62, 0.36), (8, 0.9, 1.15, 0.1)].into_iter().enumerate()
    {
        solids.place("gear", [2.3, 0.1], 0.0, -0.2 * TURN);
        solids.builder.frame = solids.builder.frame.shift(dvec3(x, y, 0.0)).pitch(TURN / 4.0);
        gear(solids, metals[number], teeth, phase);
    }
}

/// A gear about the frame's y axis, with a hole for its axle: a section that is led once around.
fn gear(solids: &mut Solids, material: MaterialId, teeth: usize, phase: f64) {
    let Solids { builder, .. } = solids;
    // Eight points make a tooth; fewer would not.
    let around = teeth * builder.divide(8, 4);
    let pitch = 0.0264 * teeth as f64;
    let across = builder.divide(4, 1);
    let wide = builder.divide(6, 1);
    // Once around the section: up outside, in over the top, down the hole, out below.
    let corners = [(1.0, -0.5), (1.0, 0.5), (0.0, 0.5), (0.0, -0.5)];
    let divisions = [across, wide, across, wide];
    let mut section = Vec::new();
    for (at, count) in divisions.into_iter().enumerate() {
        let (from, to) = (corners[at], corners[(at + 1) % 4]);
        section.extend((0..count).map(|step| {
            let t = step as f64 / count as f64;
            (from.0 + (to.0 - from.0) * t, from.1 + (to.1 - from.1) * t)
        }));
    }
    builder.rings(material, section.len(), around, &Ends::Looped, |ring, at| {
        let angle = TURN * at as f64 / around as f64;
        let (out, up) = section[ring];
        let tooth = smoothstep(-0.35, 0.35, cos(angle * teeth as f64 + TURN * phase)) - 0.5;
        let radius = pitch * 0.35 + (pitch * 0.65 + 0.07 * tooth - 0.012) * out;
        dvec3(radius * cos(angle), 0.14 * up, -radius * sin(angle))
    });
}
