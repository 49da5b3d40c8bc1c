//! Solids of revolution: vases, goblets, bowls, lenses, crystals, drops.

use glam::{DVec3, dvec3};

use super::Solids;
use crate::procedural::math::{TURN, cos, sin};

pub(super) fn build(solids: &mut Solids) {
    vases(solids);
    goblets(solids);
    bowl(solids);
    lenses(solids);
    crystals(solids);
    drops(solids);
    pebbles(solids);
}

/// A vase: radii outside from foot to rim; 16 mm of wall.
const VASE: [[f64; 2]; 15] = [
    [0.0, 0.0],
    [0.17, 0.0],
    [0.19, 0.03],
    [0.24, 0.2],
    [0.33, 0.48],
    [0.3, 0.78],
    [0.16, 1.02],
    [0.13, 1.14],
    [0.2, 1.26],
    [0.185, 1.265],
    [0.114, 1.14],
    [0.144, 1.01],
    [0.284, 0.77],
    [0.31, 0.48],
    [0.0, 0.06],
];

fn vases(solids: &mut Solids) {
    for (number, (at, size)) in
        [([-2.9, 1.0], 1.15), ([3.4, -1.7], 1.3), ([-0.2, -3.6], 1.2), ([-3.9, -0.6], 0.8)].into_iter().enumerate()
    {
        solids.place("vase", at, 0.004, 0.0);
        let Solids { builder, palette } = solids;
        let knots = VASE.map(|knot| knot.map(|value| value * size));
        // A multiple of the knots' number, so that the walls keep their thickness.
        builder.revolve_smooth(palette.glass(number), [builder.around(38), 14 * builder.along(3)], &knots);
    }
}

/// A goblet on a stem with 8 mm of wall.
const GOBLET: [[f64; 2]; 14] = [
    [0.0, 0.0],
    [0.16, 0.0],
    [0.155, 0.012],
    [0.05, 0.035],
    [0.018, 0.1],
    [0.018, 0.3],
    [0.06, 0.36],
    [0.15, 0.46],
    [0.165, 0.6],
    [0.13, 0.74],
    [0.122, 0.74],
    [0.156, 0.6],
    [0.14, 0.465],
    [0.0, 0.375],
];

fn goblets(solids: &mut Solids) {
    for at in [[0.9, 2.3], [1.35, 2.05], [1.1, 2.75], [-0.1, 2.85]] {
        solids.place("goblet", at, 0.0, 0.0);
        let Solids { builder, palette } = solids;
        builder.revolve_smooth(palette.clear, [builder.around(26), 13 * builder.along(3)], &GOBLET);
    }
}

/// A bowl with marbles that lie in it, apart from each other.
fn bowl(solids: &mut Solids) {
    solids.place("bowl", [-1.3, 1.9], 0.0, 0.0);
    let Solids { builder, palette } = solids;
    let arc = |radius: f64, from: f64, to: f64, count: usize| -> Vec<[f64; 2]> {
        (0..=count)
            .map(|at| {
                let angle = from + (to - from) * at as f64 / count as f64;
                [radius * sin(angle), 0.6 - radius * cos(angle)]
            })
            .collect()
    };
    let rows = builder.divide(16, 4);
    let mut knots = vec![[0.0, 0.0]];
    // Up on the outside, with a little flat foot, and down on the inside.
    knots
        .extend(arc(0.6, 0.05 * TURN, 0.24 * TURN, rows).into_iter().map(|[x, y]| [x, if y < 0.03 { 0.0 } else { y }]));
    knots.extend(arc(0.57, 0.01 * TURN, 0.24 * TURN, rows).into_iter().rev());
    knots.push([0.0, 0.03]);
    builder.revolve_straight(palette.violet, [builder.around(48), 1], &knots);
    builder.object_here("marbles");
    for number in 0..7 {
        let angle = TURN * number as f64 / 6.0;
        let (flat, y) = if number == 6 { (0.0, 0.145) } else { (0.26, 0.222) };
        let center = dvec3(flat * cos(angle), y, flat * sin(angle));
        let material = if number % 3 == 0 { palette.chrome } else { palette.glass(number) };
        builder.ball(material, center, 0.105, builder.around(24));
    }
}

/// Lenses on edge, in a row along one axis.
fn lenses(solids: &mut Solids) {
    for (number, curve) in [0.16, 0.1, -0.05, 0.13].into_iter().enumerate() {
        let along = number as f64 * 0.42;
        solids.place("lens", [-3.0 + 0.905 * along, -2.7 + 0.426 * along], 0.0, 0.18 * TURN);
        let Solids { builder, palette } = solids;
        let (radius, half) = (0.42, 0.055);
        builder.frame = builder.frame.shift(DVec3::Y * radius).pitch(TURN / 4.0);
        let rows = builder.divide(9, 3);
        // Of thickness half at the rim and curve more in the middle; the hollow one is thick at the rim.
        let rim = if curve < 0.0 { half - curve } else { half * 0.3 };
        let side = |at: usize| {
            let share = at as f64 / rows as f64;
            [radius * share, rim + curve * (1.0 - share * share)]
        };
        let mut knots: Vec<[f64; 2]> = (0..=rows).map(side).map(|[x, y]| [x, -y]).collect();
        knots.extend((0..=rows).rev().map(side));
        builder.revolve_straight(palette.glass(number + 4), [builder.around(34), 1], &knots);
    }
}

/// Crystals with flat faces: their sides do not multiply with the scale, what they are divided into does.
fn crystals(solids: &mut Solids) {
    for (number, (at, sides, height)) in [
        ([3.5, 0.9], 6, 0.9),
        ([3.0, 2.0], 5, 0.6),
        ([-3.4, 2.3], 6, 1.1),
        ([-2.6, 2.9], 8, 0.55),
        ([1.9, -3.3], 6, 1.2),
        ([0.9, 0.95], 4, 0.5),
    ]
    .into_iter()
    .enumerate()
    {
        solids.place("crystal", at, 0.0, 0.1 * TURN * number as f64);
        let Solids { builder, palette } = solids;
        let wide = 0.16 + 0.09 * height;
        let knots = [[0.0, 0.0], [wide * 0.8, 0.0], [wide, 0.1], [wide * 0.9, height * 0.75], [0.0, height]];
        builder.revolve_straight(palette.glass(number * 5 + 1), [sides, builder.along(6)], &knots);
    }
}

/// Drops that hang in the air.
fn drops(solids: &mut Solids) {
    const DROP: [[f64; 2]; 8] =
        [[0.0, -0.2], [0.1, -0.17], [0.19, -0.04], [0.19, 0.08], [0.12, 0.24], [0.05, 0.38], [0.015, 0.5], [0.0, 0.56]];
    for number in 0..24 {
        let (ring, turn) = if number < 8 { (1.25, number as f64 / 8.0) } else { (2.9, number as f64 / 16.0 + 0.03) };
        let angle = TURN * turn;
        let height = 2.25 + 0.3 * sin(3.0 * angle + ring) + if number < 8 { 0.75 } else { 0.0 };
        solids.place("drop", [ring * cos(angle), ring * sin(angle)], height, 0.0);
        let Solids { builder, palette } = solids;
        let material = if number % 5 == 2 { palette.gold } else { palette.glass(number) };
        builder.revolve_smooth(material, builder.bent(18, [14, 5]), &DROP);
    }
}

/// Round and flat pebbles, and balls of metal.
fn pebbles(solids: &mut Solids) {
    for (number, (at, half)) in [
        ([1.5, 1.3], dvec3(0.22, 0.1, 0.16)),
        ([-0.5, 1.4], dvec3(0.14, 0.09, 0.2)),
        ([2.2, 2.6], dvec3(0.24, 0.15, 0.2)),
        ([-1.9, 0.5], dvec3(0.17, 0.12, 0.12)),
        ([0.6, -1.2], dvec3(0.2, 0.1, 0.26)),
        ([-0.8, 3.6], dvec3(0.3, 0.16, 0.2)),
        ([1.1, -2.2], DVec3::splat(0.24)),
        ([-0.9, 0.85], DVec3::splat(0.2)),
        ([2.5, -2.6], DVec3::splat(0.34)),
    ]
    .into_iter()
    .enumerate()
    {
        solids.place("pebble", at, half.y, 0.6 * number as f64);
        let Solids { builder, palette } = solids;
        let material = if half.x == half.z { palette.chrome } else { palette.glass(number + 2) };
        builder.ellipsoid(material, DVec3::ZERO, half, builder.around(28));
    }
}
