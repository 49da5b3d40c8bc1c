//! The table and what lies on it.

use super::*;

/// Height of the table's upper side.
const TOP: f64 = 0.75;

pub(super) fn build(builder: &mut MeshBuilder) {
    builder.frame = Frame::at(TABLE);
    builder.slab(WOOD, [64, 8, 2], dvec3(0.0, TOP - 0.018, 0.0), dvec3(0.85, 0.018, 0.48), 7.0);
    for z in [-0.36, 0.36] {
        let (min, max) = (dvec3(-0.7, TOP - 0.11, z - 0.011), dvec3(0.7, TOP - 0.02, z + 0.011));
        builder.cuboid(DARK_WOOD, min, max, [6, 0, 0]);
    }
    for x in [-0.71, 0.71] {
        let (min, max) = (dvec3(x - 0.011, TOP - 0.105, -0.35), dvec3(x + 0.011, TOP - 0.022, 0.35));
        builder.cuboid(DARK_WOOD, min, max, [0, 0, 4]);
    }
    let leg = knots([0.0, 0.016, 0.017, 0.024, 0.03, 0.032, 0.0], [-SUNK, -0.001, 0.08, 0.34, 0.58, 0.72, 0.738]);
    for (x, z) in [(-0.7, -0.35), (0.7, -0.352), (-0.702, 0.351), (0.701, 0.35)] {
        builder.frame = Frame::at(TABLE + dvec3(x, 0.0, z));
        builder.revolve_smooth(DARK_WOOD, [20, 18, 6], &leg);
    }
    bowl(builder);
    mug(builder, dvec3(0.38, 0.0, 0.22), 0.5);
    mug(builder, dvec3(-0.52, 0.0, -0.2), 2.4);
    glass(builder, dvec3(0.5, 0.0, -0.17));
    builder.frame = Frame::at(TABLE + dvec3(-0.42, TOP, 0.2));
    builder.torus(MIRROR, [16, 40, 3], dvec3(0.0, 0.021, 0.0), [0.06, 0.0215]);
}

fn bowl(builder: &mut MeshBuilder) {
    builder.frame = Frame::at(TABLE + dvec3(0.02, TOP, 0.0));
    let profile = knots(
        [0.0, 0.05, 0.062, 0.11, 0.15, 0.163, 0.158, 0.142, 0.102, 0.05, 0.0],
        [-0.001, -0.001, 0.006, 0.04, 0.085, 0.1, 0.102, 0.088, 0.046, 0.018, 0.013],
    );
    builder.revolve_smooth(GLAZE, [40, 20, 10], &profile);
    for (x, y, z, radius) in [
        (0.045, 0.058, 0.02, 0.04),
        (-0.04, 0.059, 0.035, 0.041),
        (-0.005, 0.057, -0.052, 0.039),
        (0.0, 0.12, 0.0, 0.04),
    ] {
        builder.ball(FRUIT, dvec3(x, y, z), radius, 16);
    }
}

fn mug(builder: &mut MeshBuilder, at: DVec3, turn: f64) {
    builder.frame = Frame::at(TABLE + at + DVec3::Y * TOP).yaw(turn);
    let profile = knots(
        [0.0, 0.034, 0.039, 0.04, 0.041, 0.0395, 0.0375, 0.0365, 0.034, 0.0],
        [-0.001, -0.001, 0.006, 0.05, 0.09, 0.0925, 0.09, 0.05, 0.01, 0.006],
    );
    builder.revolve_smooth(CLAY, [24, 16, 9], &profile);
    let handle = |t: f64| {
        let angle = mix(-0.24, 0.24, t) * TURN;
        dvec3(0.0395 + 0.026 * cos(angle), 0.048 + 0.03 * sin(angle), 0.0)
    };
    builder.tube(CLAY, [8, 14, 4], handle, |_| 0.0045);
}

fn glass(builder: &mut MeshBuilder, at: DVec3) {
    builder.frame = Frame::at(TABLE + at + DVec3::Y * TOP);
    let profile = knots(
        [0.0, 0.034, 0.03, 0.008, 0.0035, 0.0035, 0.008, 0.034, 0.036, 0.031, 0.0298, 0.0345, 0.0325, 0.012, 0.0],
        [-0.001, -0.001, 0.003, 0.007, 0.03, 0.07, 0.085, 0.115, 0.15, 0.185, 0.186, 0.15, 0.117, 0.094, 0.088],
    );
    builder.revolve_smooth(METAL, [24, 30, 14], &profile);
}
