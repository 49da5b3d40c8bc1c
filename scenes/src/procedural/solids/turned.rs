//! Solids of revolution: vases, goblets, bowls, lenses, crystals, drops.

use super::*;

pub(super) fn build(builder: &mut MeshBuilder) {
    vases(builder);
    goblets(builder);
    bowl(builder);
    lenses(builder);
    crystals(builder);
    drops(builder);
    pebbles(builder);
}

/// Vases with 16 mm of wall.
fn vases(builder: &mut MeshBuilder) {
    let knots = knots(
        [0.0, 0.17, 0.19, 0.24, 0.33, 0.3, 0.16, 0.13, 0.2, 0.185, 0.114, 0.144, 0.284, 0.31, 0.0],
        [0.0, 0.0, 0.03, 0.2, 0.48, 0.78, 1.02, 1.14, 1.26, 1.265, 1.14, 1.01, 0.77, 0.48, 0.06],
    );
    let places = [([-2.9, 1.0], 1.15), ([3.4, -1.7], 1.3), ([-0.2, -3.6], 1.2), ([-3.9, -0.6], 0.8)];
    for (number, (at, size)) in places.into_iter().enumerate() {
        place(builder, "vase", at, 0.004, 0.0);
        // A multiple of the knots' number, so that the walls keep their thickness.
        let profile = smooth_profile(&knots.map(|knot| knot.map(|value| value * size)), 14 * builder.along(3));
        builder.revolve(glass(number), 38, &profile);
    }
}

/// Goblets on a stem with 8 mm of wall.
fn goblets(builder: &mut MeshBuilder) {
    let knots = knots(
        [0.0, 0.16, 0.155, 0.05, 0.018, 0.018, 0.06, 0.15, 0.165, 0.13, 0.122, 0.156, 0.14, 0.0],
        [0.0, 0.0, 0.012, 0.035, 0.1, 0.3, 0.36, 0.46, 0.6, 0.74, 0.74, 0.6, 0.465, 0.375],
    );
    for at in [[0.9, 2.3], [1.35, 2.05], [1.1, 2.75], [-0.1, 2.85]] {
        place(builder, "goblet", at, 0.0, 0.0);
        builder.revolve(CLEAR, 26, &smooth_profile(&knots, 13 * builder.along(3)));
    }
}

/// A bowl with marbles that lie in it, apart from each other.
fn bowl(builder: &mut MeshBuilder) {
    place(builder, "bowl", [-1.3, 1.9], 0.0, 0.0);
    let rows = builder.divide(16, 4);
    let arc = |radius: f64, from: f64, at: usize| {
        let angle = from + (0.24 * TURN - from) * at as f64 / rows as f64;
        [radius * sin(angle), 0.6 - radius * cos(angle)]
    };
    // Up on the outside, with a little flat foot, and down on the inside.
    let mut knots = vec![[0.0, 0.0]];
    knots.extend((0..=rows).map(|at| arc(0.6, 0.05 * TURN, at)).map(|[x, y]| [x, if y < 0.03 { 0.0 } else { y }]));
    knots.extend((0..=rows).rev().map(|at| arc(0.57, 0.01 * TURN, at)));
    knots.push([0.0, 0.03]);
    builder.revolve_straight(VIOLET, [48, 0], &knots);
    builder.object_here("marbles");
    for number in 0..7 {
        let angle = TURN * number as f64 / 6.0;
        let (flat, y) = if number == 6 { (0.0, 0.145) } else { (0.26, 0.222) };
        let center = dvec3(flat * cos(angle), y, flat * sin(angle));
        let material = if number % 3 == 0 { CHROME } else { glass(number) };
        builder.ball(material, center, 0.105, 24);
    }
}

/// Lenses on edge, in a row along one axis.
fn lenses(builder: &mut MeshBuilder) {
    for (number, curve) in [0.16, 0.1, -0.05, 0.13].into_iter().enumerate() {
        let along = number as f64 * 0.42;
        place(builder, "lens", [-3.0 + 0.905 * along, -2.7 + 0.426 * along], 0.0, 0.18 * TURN);
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
        builder.revolve_straight(glass(number + 4), [34, 0], &knots);
    }
}

/// Crystals with flat faces: their sides do not multiply with the scale, what they are divided into does.
fn crystals(builder: &mut MeshBuilder) {
    let places = [[3.5, 0.9], [3.0, 2.0], [-3.4, 2.3], [-2.6, 2.9], [1.9, -3.3], [0.9, 0.95]];
    let shapes = [(6, 0.9), (5, 0.6), (6, 1.1), (8, 0.55), (6, 1.2), (4, 0.5)];
    for (number, (at, (sides, height))) in places.into_iter().zip(shapes).enumerate() {
        place(builder, "crystal", at, 0.0, 0.1 * TURN * number as f64);
        let wide = 0.16 + 0.09 * height;
        let knots = [[0.0, 0.0], [wide * 0.8, 0.0], [wide, 0.1], [wide * 0.9, height * 0.75], [0.0, height]];
        builder.lathe(glass(number * 5 + 1), sides, &straight_profile(&knots, builder.along(6)));
    }
}

/// Drops that hang in the air.
fn drops(builder: &mut MeshBuilder) {
    const DROP: [[f64; 2]; 8] =
        [[0.0, -0.2], [0.1, -0.17], [0.19, -0.04], [0.19, 0.08], [0.12, 0.24], [0.05, 0.38], [0.015, 0.5], [0.0, 0.56]];
    for number in 0..24 {
        let (ring, turn) = if number < 8 { (1.25, number as f64 / 8.0) } else { (2.9, number as f64 / 16.0 + 0.03) };
        let angle = TURN * turn;
        let height = 2.25 + 0.3 * sin(3.0 * angle + ring) + if number < 8 { 0.75 } else { 0.0 };
        place(builder, "drop", [ring * cos(angle), ring * sin(angle)], height, 0.0);
        let material = if number % 5 == 2 { GOLD } else { glass(number) };
        builder.revolve_smooth(material, [18, 14, 5], &DROP);
    }
}

/// Round and flat pebbles, and balls of metal.
fn pebbles(builder: &mut MeshBuilder) {
    let places = [
        ([1.5, 1.3], dvec3(0.22, 0.1, 0.16)),
        ([-0.5, 1.4], dvec3(0.14, 0.09, 0.2)),
        ([2.2, 2.6], dvec3(0.24, 0.15, 0.2)),
        ([-1.9, 0.5], dvec3(0.17, 0.12, 0.12)),
        ([0.6, -1.2], dvec3(0.2, 0.1, 0.26)),
        ([-0.8, 3.6], dvec3(0.3, 0.16, 0.2)),
        ([1.1, -2.2], DVec3::splat(0.24)),
        ([-0.9, 0.85], DVec3::splat(0.2)),
        ([2.5, -2.6], DVec3::splat(0.34)),
    ];
    for (number, (at, half)) in places.into_iter().enumerate() {
        place(builder, "pebble", at, half.y, 0.6 * number as f64);
        let material = if half.x == half.z { CHROME } else { glass(number + 2) };
        builder.ellipsoid(material, DVec3::ZERO, half, 28);
    }
}
