//! Solids within solids: shells, bubbles, boxes in boxes, and panes in a row.

use glam::{DVec3, dvec3};

use super::Solids;
use crate::procedural::math::TURN;

pub(super) fn build(solids: &mut Solids) {
    shells(solids);
    bubbles(solids);
    boxes(solids);
    panes(solids);
}

/// Hollow balls in hollow balls around a full one: ten surfaces through the middle.
fn shells(solids: &mut Solids) {
    solids.place("shells", [-1.75, -0.6], 0.74, 0.0);
    let Solids { builder, palette } = solids;
    for (number, radius) in [0.74, 0.56, 0.4].into_iter().enumerate() {
        builder.ball(palette.glass(3 * number + 2), DVec3::ZERO, radius, builder.around(46));
        builder.void(palette.glass(3 * number + 2), DVec3::ZERO, radius - 0.07, builder.around(42));
    }
    builder.ball(palette.gold, DVec3::ZERO, 0.24, builder.around(36));
}

/// Balls of other materials in one ball, so that rays go from solid into solid.
fn bubbles(solids: &mut Solids) {
    solids.place("bubbles", [1.75, -1.25], 0.62, 0.3);
    let Solids { builder, palette } = solids;
    builder.ball(palette.clear, DVec3::ZERO, 0.62, builder.around(56));
    for (number, (center, radius)) in [
        (dvec3(0.24, 0.1, 0.1), 0.17),
        (dvec3(-0.22, 0.18, 0.14), 0.13),
        (dvec3(0.02, -0.28, 0.12), 0.15),
        (dvec3(-0.1, 0.02, -0.28), 0.19),
        (dvec3(0.1, 0.36, -0.1), 0.1),
    ]
    .into_iter()
    .enumerate()
    {
        builder.ball(palette.glass(number), center, radius, builder.around(28));
    }
}

/// Boxes turned within boxes, standing on their faces or hanging on a corner.
fn boxes(solids: &mut Solids) {
    for (number, (at, half, above)) in
        [([0.25, -2.5], 0.42, 0.0), ([2.9, 3.0], 0.3, 0.0), ([-2.0, 3.6], 0.34, 0.35), ([3.9, -0.3], 0.25, 0.9)]
            .into_iter()
            .enumerate()
    {
        solids.place("box", at, half + above, 0.25 + 0.9 * number as f64);
        let Solids { builder, palette } = solids;
        let cells = builder.along(7);
        if above > 0.0 {
            builder.frame = builder.frame.roll(TURN / 8.0).pitch(0.615);
        }
        builder.cuboid(palette.glass(number + 5), DVec3::splat(-half), DVec3::splat(half), [cells; 3]);
        builder.frame = builder.frame.yaw(0.4).roll(0.5);
        let inner = half * 0.55;
        builder.cuboid(palette.glass(number + 1), DVec3::splat(-inner), DVec3::splat(inner), [cells; 3]);
        builder.frame = builder.frame.pitch(0.7);
        builder.plain_box(palette.gold, DVec3::splat(-inner * 0.5), DVec3::splat(inner * 0.5));
    }
}

/// Panes of glass one behind the other: seen along the row, two layers each.
fn panes(solids: &mut Solids) {
    solids.place("panes", [2.95, -0.75], 0.0, 0.1 * TURN);
    let Solids { builder, palette } = solids;
    for number in 0..5 {
        let at = f64::from(number) * 0.16 - 0.32;
        let (low, high) = (dvec3(-0.4, 0.0, at), dvec3(0.4, 0.8, at + 0.03));
        let cells = [builder.along(8), builder.along(8), 1];
        builder.cuboid(palette.glass(number as usize), low, high, cells);
    }
}
