//! The table and what lies on it.

use glam::{DVec3, dvec3};

use super::{Palette, SUNK, TABLE};
use crate::procedural::builder::MeshBuilder;
use crate::procedural::math::{Frame, TURN, cos, mix, sin};

/// Height of the table's upper side.
const TOP: f64 = 0.75;

pub(super) fn build(builder: &mut MeshBuilder, palette: &Palette) {
    builder.frame = Frame::at(TABLE);
    builder.slab(palette.wood, builder.bent(64, [8, 2]), dvec3(0.0, TOP - 0.018, 0.0), dvec3(0.85, 0.018, 0.48), 7.0);
    for (z, length) in [(-0.36, 0.7), (0.36, 0.7)] {
        builder.cuboid(
            palette.dark_wood,
            dvec3(-length, TOP - 0.11, z - 0.011),
            dvec3(length, TOP - 0.02, z + 0.011),
            [builder.along(6), 1, 1],
        );
    }
    for (x, half) in [(-0.71, 0.35), (0.71, 0.35)] {
        builder.cuboid(
            palette.dark_wood,
            dvec3(x - 0.011, TOP - 0.105, -half),
            dvec3(x + 0.011, TOP - 0.022, half),
            [1, 1, builder.along(4)],
        );
    }
    let leg = [
        [0.0, -SUNK],
        [0.016, -SUNK + 0.001],
        [0.017, 0.08],
        [0.024, 0.34],
        [0.03, 0.58],
        [0.032, TOP - 0.03],
        [0.0, TOP - 0.012],
    ];
    for (x, z) in [(-0.7, -0.35), (0.7, -0.352), (-0.702, 0.351), (0.701, 0.35)] {
        builder.frame = Frame::at(TABLE + dvec3(x, 0.0, z));
        builder.revolve_smooth(palette.dark_wood, builder.bent(20, [18, 6]), &leg);
    }
    bowl(builder, palette);
    mug(builder, palette, dvec3(0.38, 0.0, 0.22), 0.5);
    mug(builder, palette, dvec3(-0.52, 0.0, -0.2), 2.4);
    glass(builder, palette, dvec3(0.5, 0.0, -0.17));
    builder.frame = Frame::at(TABLE + dvec3(-0.42, TOP, 0.2));
    builder.torus(palette.mirror, builder.ring(16, 40), dvec3(0.0, 0.021, 0.0), [0.06, 0.0215]);
}

fn bowl(builder: &mut MeshBuilder, palette: &Palette) {
    let here = Frame::at(TABLE + dvec3(0.02, TOP, 0.0));
    builder.frame = here;
    let profile = [
        [0.0, -0.001],
        [0.05, -0.001],
        [0.062, 0.006],
        [0.11, 0.04],
        [0.15, 0.085],
        [0.163, 0.1],
        [0.158, 0.102],
        [0.142, 0.088],
        [0.102, 0.046],
        [0.05, 0.018],
        [0.0, 0.013],
    ];
    builder.revolve_smooth(palette.glaze, builder.bent(40, [20, 10]), &profile);
    for (x, y, z, radius) in [
        (0.045, 0.058, 0.02, 0.04),
        (-0.04, 0.059, 0.035, 0.041),
        (-0.005, 0.057, -0.052, 0.039),
        (0.0, 0.12, 0.0, 0.04),
    ] {
        builder.ball(palette.fruit, dvec3(x, y, z), radius, builder.around(16));
    }
}

fn mug(builder: &mut MeshBuilder, palette: &Palette, at: DVec3, turn: f64) {
    builder.frame = Frame::at(TABLE + at + DVec3::Y * TOP).yaw(turn);
    let profile = [
        [0.0, -0.001],
        [0.034, -0.001],
        [0.039, 0.006],
        [0.04, 0.05],
        [0.041, 0.09],
        [0.0395, 0.0925],
        [0.0375, 0.09],
        [0.0365, 0.05],
        [0.034, 0.01],
        [0.0, 0.006],
    ];
    builder.revolve_smooth(palette.clay, builder.bent(24, [16, 9]), &profile);
    let handle = |t: f64| {
        let angle = mix(-0.24, 0.24, t) * TURN;
        dvec3(0.0395 + 0.026 * cos(angle), 0.048 + 0.03 * sin(angle), 0.0)
    };
    builder.tube(palette.clay, builder.bent(8, [14, 4]), handle, |_| 0.0045);
}

fn glass(builder: &mut MeshBuilder, palette: &Palette, at: DVec3) {
    builder.frame = Frame::at(TABLE + at + DVec3::Y * TOP);
    let profile = [
        [0.0, -0.001],
        [0.034, -0.001],
        [0.03, 0.003],
        [0.008, 0.007],
        [0.0035, 0.03],
        [0.0035, 0.07],
        [0.008, 0.085],
        [0.034, 0.115],
        [0.036, 0.15],
        [0.031, 0.185],
        [0.0298, 0.186],
        [0.0345, 0.15],
        [0.0325, 0.117],
        [0.012, 0.094],
        [0.0, 0.088],
    ];
    builder.revolve_smooth(palette.metal, builder.bent(24, [30, 14]), &profile);
}
