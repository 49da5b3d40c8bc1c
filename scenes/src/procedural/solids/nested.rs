//! Solids within solids: shells, bubbles, boxes in boxes, and panes in a row.

use super::*;

pub(super) fn build(builder: &mut MeshBuilder) {
    shells(builder);
    bubbles(builder);
    boxes(builder);
    panes(builder);
}

/// Hollow balls in hollow balls around a full one: ten surfaces through the middle.
fn shells(builder: &mut MeshBuilder) {
    place(builder, "shells", [-1.75, -0.6], 0.74, 0.0);
    for (number, radius) in [0.74, 0.56, 0.4].into_iter().enumerate() {
        builder.ball(glass(3 * number + 2), DVec3::ZERO, radius, 46);
        builder.void(glass(3 * number + 2), DVec3::ZERO, radius - 0.07, 42);
    }
    builder.ball(GOLD, DVec3::ZERO, 0.24, 36);
}

/// Balls of other materials in one ball, so that rays go from solid into solid.
fn bubbles(builder: &mut MeshBuilder) {
    place(builder, "bubbles", [1.75, -1.25], 0.62, 0.3);
    builder.ball(CLEAR, DVec3::ZERO, 0.62, 56);
    let centers = [(0.24, 0.1, 0.1), (-0.22, 0.18, 0.14), (0.02, -0.28, 0.12), (-0.1, 0.02, -0.28), (0.1, 0.36, -0.1)];
    for (number, (center, radius)) in centers.into_iter().zip([0.17, 0.13, 0.15, 0.19, 0.1]).enumerate() {
        builder.ball(glass(number), center.into(), radius, 28);
    }
}

/// Boxes turned within boxes, standing on their faces or hanging on a corner.
fn boxes(builder: &mut MeshBuilder) {
    let places =
        [([0.25, -2.5], 0.42, 0.0), ([2.9, 3.0], 0.3, 0.0), ([-2.0, 3.6], 0.34, 0.35), ([3.9, -0.3], 0.25, 0.9)];
    for (number, (at, half, above)) in places.into_iter().enumerate() {
        place(builder, "box", at, half + above, 0.25 + 0.9 * number as f64);
        if above > 0.0 {
            builder.frame = builder.frame.roll(TURN / 8.0).pitch(0.615);
        }
        builder.cuboid(glass(number + 5), DVec3::splat(-half), DVec3::splat(half), [7; 3]);
        builder.frame = builder.frame.yaw(0.4).roll(0.5);
        let inner = half * 0.55;
        builder.cuboid(glass(number + 1), DVec3::splat(-inner), DVec3::splat(inner), [7; 3]);
        builder.frame = builder.frame.pitch(0.7);
        builder.cuboid(GOLD, DVec3::splat(-inner * 0.5), DVec3::splat(inner * 0.5), [0; 3]);
    }
}

/// Panes of glass one behind the other: seen along the row, two layers each.
fn panes(builder: &mut MeshBuilder) {
    place(builder, "panes", [2.95, -0.75], 0.0, 0.1 * TURN);
    for number in 0..5 {
        let at = f64::from(number) * 0.16 - 0.32;
        let (low, high) = (dvec3(-0.4, 0.0, at), dvec3(0.4, 0.8, at + 0.03));
        builder.cuboid(glass(number as usize), low, high, [8, 8, 0]);
    }
}
