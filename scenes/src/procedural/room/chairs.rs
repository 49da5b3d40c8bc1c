//! Five chairs of thin round rods; their legs have a radius of 8 millimetres.

use glam::dvec3;

use super::{Palette, SUNK, TABLE};
use crate::procedural::builder::MeshBuilder;
use crate::procedural::math::{Frame, TURN, curve};

/// Radius of a leg in metres.
const LEG_RADIUS: f64 = 0.008;
/// Height of the seat's middle.
const SEAT: f64 = 0.45;

pub(super) fn build(builder: &mut MeshBuilder, palette: &Palette) {
    // Place beside the table's middle and turn in turns; a chair faces its own -z.
    for (x, z, turn) in
        [(-0.42, 0.72, 0.01), (0.4, 0.78, -0.03), (-0.38, -0.74, 0.5), (0.45, -0.7, 0.485), (1.25, 0.1, 0.29)]
    {
        builder.frame = Frame::at(TABLE + dvec3(x, 0.0, z)).yaw(turn * TURN);
        chair(builder, palette);
    }
}

fn chair(builder: &mut MeshBuilder, palette: &Palette) {
    builder.slab(palette.wood, builder.bent(40, [6, 2]), dvec3(0.0, SEAT, 0.0), dvec3(0.21, 0.014, 0.2), 4.0);
    let thick = builder.bent(12, [8, 2]);
    let thin = builder.bent(8, [4, 1]);
    // Legs spread towards the floor and bow a little.
    let foot = |x: f64, z: f64| dvec3(x * 0.205, -SUNK, z * 0.2);
    let hip = |x: f64, z: f64| dvec3(x * 0.165, SEAT, z * 0.155);
    let on_leg = |x: f64, z: f64, t: f64| {
        let bow = dvec3(x, 0.0, z) * (0.012 * t * (1.0 - t));
        foot(x, z) + (hip(x, z) - foot(x, z)) * t + bow
    };
    for (x, z) in [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)] {
        builder.tube(palette.dark_wood, thick, |t| on_leg(x, z, t), |_| LEG_RADIUS);
    }
    for (from, to, height) in [
        ((-1.0, -1.0), (1.0, -1.0), 0.42),
        ((-1.0, 1.0), (1.0, 1.0), 0.42),
        ((-1.0, -1.0), (-1.0, 1.0), 0.33),
        ((1.0, -1.0), (1.0, 1.0), 0.33),
    ] {
        let ends = [on_leg(from.0, from.1, height), on_leg(to.0, to.1, height)];
        builder.rod(palette.dark_wood, thin, ends, 0.0055);
    }
    // The back: two posts, a bowed rail on top, spindles between.
    let rail = |t: f64| {
        curve(
            &[
                dvec3(-0.2, 0.86, 0.255),
                dvec3(-0.1, 0.885, 0.285),
                dvec3(0.0, 0.892, 0.293),
                dvec3(0.1, 0.885, 0.285),
                dvec3(0.2, 0.86, 0.255),
            ],
            t,
        )
    };
    builder.tube(palette.wood, thick, rail, |t| 0.012 + 0.01 * t * (1.0 - t));
    for t in [0.06, 0.94] {
        let side = if t < 0.5 { -1.0 } else { 1.0 };
        let ends = [dvec3(side * 0.165, SEAT - 0.005, 0.165), rail(t)];
        builder.rod(palette.dark_wood, thick, ends, 0.009);
    }
    for spindle in 1..=6 {
        let share = f64::from(spindle) / 7.0;
        let ends = [dvec3((share - 0.5) * 0.3, SEAT - 0.004, 0.176), rail(0.06 + 0.88 * share)];
        builder.tube(
            palette.dark_wood,
            [thin[0], thick[1]],
            |t| ends[0] + (ends[1] - ends[0]) * t,
            |t| 0.004 + 0.006 * t * (1.0 - t),
        );
    }
}
