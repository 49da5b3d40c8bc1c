//! Five chairs of thin round rods; their legs have a radius of 8 millimetres.

use super::*;

/// Radius of a leg in metres.
const LEG_RADIUS: f64 = 0.008;
/// Height of the seat's middle.
const SEAT: f64 = 0.45;

pub(super) fn build(builder: &mut MeshBuilder) {
    // Place beside the table's middle and turn in turns; a chair faces its own -z.
    for (x, z, turn) in
        [(-0.42, 0.72, 0.01), (0.4, 0.78, -0.03), (-0.38, -0.74, 0.5), (0.45, -0.7, 0.485), (1.25, 0.1, 0.29)]
    {
        builder.frame = Frame::at(TABLE + dvec3(x, 0.0, z)).yaw(turn * TURN);
        chair(builder);
    }
}

fn chair(builder: &mut MeshBuilder) {
    builder.slab(WOOD, [40, 6, 2], dvec3(0.0, SEAT, 0.0), dvec3(0.21, 0.014, 0.2), 4.0);
    let thick = [12, 8, 2];
    // Legs spread towards the floor and bow a little.
    let on_leg = |x: f64, z: f64, t: f64| {
        let (foot, hip) = (dvec3(x * 0.205, -SUNK, z * 0.2), dvec3(x * 0.165, SEAT, z * 0.155));
        foot + (hip - foot) * t + dvec3(x, 0.0, z) * (0.012 * t * (1.0 - t))
    };
    for (x, z) in [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)] {
        builder.tube(DARK_WOOD, thick, |t| on_leg(x, z, t), |_| LEG_RADIUS);
    }
    for (from, to, height) in [
        ((-1.0, -1.0), (1.0, -1.0), 0.42),
        ((-1.0, 1.0), (1.0, 1.0), 0.42),
        ((-1.0, -1.0), (-1.0, 1.0), 0.33),
        ((1.0, -1.0), (1.0, 1.0), 0.33),
    ] {
        builder.rod(DARK_WOOD, [8, 4], [on_leg(from.0, from.1, height), on_leg(to.0, to.1, height)], 0.0055);
    }
    // The back: two posts, a bowed rail on top, spindles between.
    let bow = [(-0.2, 0.86, 0.255), (-0.1, 0.885, 0.285), (0.0, 0.892, 0.293), (0.1, 0.885, 0.285), (0.2, 0.86, 0.255)];
    let rail = |t: f64| curve(&bow.map(DVec3::from), t);
    builder.tube(WOOD, thick, rail, |t| 0.012 + 0.01 * t * (1.0 - t));
    for (side, t) in [(-1.0, 0.06), (1.0, 0.94)] {
        builder.tube(DARK_WOOD, thick, line([dvec3(side * 0.165, SEAT - 0.005, 0.165), rail(t)]), |_| 0.009);
    }
    for spindle in 1..=6 {
        let share = f64::from(spindle) / 7.0;
        let way = line([dvec3((share - 0.5) * 0.3, SEAT - 0.004, 0.176), rail(0.06 + 0.88 * share)]);
        builder.tube(DARK_WOOD, [8, 8, 2], way, |t| 0.004 + 0.006 * t * (1.0 - t));
    }
}
