//! What stands and hangs in the court: a fountain, drapes, potted plants, bronze vases, lanterns on chains, benches.

use glam::{DVec2, DVec3, dvec2, dvec3};

use super::{COURT, FLOORS, Palette, SUNK, Side};
use crate::procedural::builder::MeshBuilder;
use crate::procedural::furnish::Drape;
use crate::procedural::math::{Frame, Random, TURN, cos, mix, sin};

pub(super) fn build(builder: &mut MeshBuilder, palette: &Palette) {
    builder.object("fountain");
    fountain(builder, palette);
    for (number, side) in Side::all().iter().enumerate() {
        for bay in 0..side.bays {
            let middle = side.column(bay) + side.half / side.bays as f64;
            let key = number * 10 + bay;
            if key % 2 == 1 {
                builder.object(format!("drape {number}.{bay}"));
                builder.frame = side.frame.shift(dvec3(middle, 0.0, 0.05));
                hang(builder, palette, key, [4.35, 0.9], 1.5);
            }
            if bay % 3 == 1 {
                builder.object(format!("banner {number}.{bay}"));
                builder.frame = side.frame.shift(dvec3(middle, FLOORS[1], -0.62));
                hang(builder, palette, key + 1, [0.9, -1.3], 1.1);
            } else {
                builder.object(format!("lantern {number}.{bay}"));
                builder.frame = side.frame.shift(dvec3(middle, 0.0, 1.9));
                lantern(builder, palette, FLOORS[1] - 0.44);
            }
        }
    }
    let mut random = Random(61);
    for (number, (x, z)) in
        [(-7.6, -3.6), (7.6, -3.6), (7.6, 3.6), (-7.6, 3.6), (0.0, 3.9), (0.0, -3.9)].into_iter().enumerate()
    {
        builder.object(format!("plant {number}"));
        builder.frame = Frame::at(dvec3(x, 0.0, z)).yaw(random.between(0.0, TURN));
        plant(builder, palette, &mut random);
    }
    let [x, z] = COURT.map(|half| half + 3.0);
    for (number, (x, z)) in
        [(-x, -z), (x, -z), (x, z), (-x, z), (-4.5, z), (1.5, z), (-1.5, -z), (4.5, -z)].into_iter().enumerate()
    {
        builder.object(format!("vase {number}"));
        builder.frame = Frame::at(dvec3(x, 0.0, z));
        vase(builder, palette);
    }
    for (number, (x, z, turn)) in
        [(-4.6, 3.4, 0.05), (4.6, 3.4, -0.04), (-4.6, -3.4, 0.03), (4.6, -3.4, 0.0)].into_iter().enumerate()
    {
        builder.object(format!("bench {number}"));
        builder.frame = Frame::at(dvec3(x, -SUNK, z)).yaw(turn);
        bench(builder, palette);
    }
}

/// A wide basin with water, a stem, two bowls, and jets.
fn fountain(builder: &mut MeshBuilder, palette: &Palette) {
    let basin = [
        [0.0, -0.006],
        [1.65, -0.006],
        [1.8, 0.06],
        [1.75, 0.2],
        [1.85, 0.42],
        [1.9, 0.5],
        [1.82, 0.54],
        [1.68, 0.5],
        [1.6, 0.2],
        [1.45, 0.1],
        [0.0, 0.08],
    ];
    builder.revolve_smooth(palette.marble, builder.bent(60, [40, 10]), &basin);
    let water =
        [[0.0, 0.2], [1.63, 0.2], [1.665, 0.42], [1.2, 0.425], [0.6, 0.422], [0.0, 0.42]].map(DVec2::from_array);
    builder.revolve(palette.water, builder.around(48), &water);
    let stem = [
        [0.0, 0.07],
        [0.35, 0.08],
        [0.25, 0.3],
        [0.14, 0.6],
        [0.2, 0.85],
        [0.5, 1.05],
        [0.85, 1.22],
        [0.88, 1.26],
        [0.82, 1.25],
        [0.5, 1.12],
        [0.16, 1.08],
        [0.1, 1.4],
        [0.14, 1.62],
        [0.42, 1.8],
        [0.45, 1.84],
        [0.4, 1.83],
        [0.1, 1.74],
        [0.06, 1.95],
        [0.09, 2.05],
        [0.0, 2.12],
    ];
    builder.revolve_smooth(palette.marble, builder.bent(40, [60, 20]), &stem);
    for (y, radius) in [(1.18, 0.72), (1.79, 0.33)] {
        let water =
            [[0.0, y - 0.05], [0.7 * radius, y - 0.05], [radius, y + 0.012], [0.0, y + 0.016]].map(DVec2::from_array);
        builder.revolve(palette.water, builder.around(32), &water);
    }
    for jet in 0..8 {
        let angle = TURN * f64::from(jet) / 8.0;
        let out = dvec3(cos(angle), 0.0, sin(angle));
        let path = |t: f64| out * mix(0.7, 1.35, t) + DVec3::Y * (1.2 + 0.55 * t - 1.35 * t * t);
        builder.tube(palette.water, builder.bent(8, [16, 4]), path, |t| mix(0.02, 0.012, t));
    }
}

/// A cloth on a rod, in the frame's plane z = 0.
fn hang(builder: &mut MeshBuilder, palette: &Palette, key: usize, [top, bottom]: [f64; 2], width: f64) {
    let cloth = Drape { width, top, bottom, folds: 4.0, depth: 0.05, phase: 0.7 * key as f64 };
    builder.drape(palette.cloth[key % 3], [builder.divide(24, 6), builder.divide(10, 2)], &cloth);
    let half = width * 0.56;
    let ends = [dvec3(-half, top - 0.01, 0.0), dvec3(half, top - 0.01, 0.0)];
    builder.rod(palette.iron, builder.round(8, 6), ends, 0.016);
}

/// A lantern with a flame that hangs by a chain from height `top`.
fn lantern(builder: &mut MeshBuilder, palette: &Palette, top: f64) {
    let low = 3.2;
    let ends = [DVec3::Y * (top + 0.02), DVec3::Y * low];
    builder.chain(palette.iron, builder.ring(6, 10), ends, 0.0, [0.24, 0.018]);
    let here = builder.frame;
    builder.frame = here.shift(DVec3::Y * (low - 0.5));
    let cap = [[0.0, 0.38], [0.2, 0.4], [0.12, 0.46], [0.04, 0.5], [0.0, 0.52]];
    builder.revolve_smooth(palette.iron, builder.bent(14, [10, 4]), &cap);
    let dish = [[0.0, 0.0], [0.09, 0.01], [0.16, 0.07], [0.15, 0.075], [0.0, 0.03]];
    builder.revolve_smooth(palette.bronze, builder.bent(14, [10, 4]), &dish);
    for bar in 0..6 {
        let angle = TURN * f64::from(bar) / 6.0;
        let out = dvec3(cos(angle), 0.0, sin(angle));
        let ends = [out * 0.15 + DVec3::Y * 0.06, out * 0.18 + DVec3::Y * 0.4];
        builder.rod(palette.iron, builder.round(6, 4), ends, 0.008);
    }
    builder.ball(palette.flame, DVec3::Y * 0.14, 0.07, builder.around(12));
}

/// A clay pot with arching leaves.
fn plant(builder: &mut MeshBuilder, palette: &Palette, random: &mut Random) {
    let pot =
        [[0.0, -SUNK], [0.26, -SUNK], [0.3, 0.05], [0.42, 0.4], [0.46, 0.62], [0.43, 0.64], [0.38, 0.55], [0.0, 0.53]];
    builder.revolve_smooth(palette.clay, builder.bent(32, [20, 8]), &pot);
    for leaf in 0..22 {
        let heading = TURN * (f64::from(leaf) * 0.382) + random.between(-0.1, 0.1);
        let out = dvec3(cos(heading), 0.0, sin(heading));
        let side = dvec3(-out.z, 0.0, out.x);
        let (reach, tall) = (random.between(0.3, 0.95), random.between(0.9, 1.7));
        let droop = random.between(0.1, 0.4);
        let path = |t: f64| out * (0.08 + reach * t * t) + DVec3::Y * (0.5 + tall * (t - droop * t * t * t));
        builder.ribbon(palette.leaf, builder.bent(6, [10, 4]), Some(side), path, |t| {
            let body = sin(TURN / 2.0 * (0.1 + 0.88 * t));
            dvec2(0.008 + 0.06 * body * body, 0.003 + 0.004 * (1.0 - t))
        });
    }
}

/// A polished bronze vase on a pedestal, with two handles.
fn vase(builder: &mut MeshBuilder, palette: &Palette) {
    let fine = builder.sides([2, 4, 2]);
    builder.cuboid(palette.stone, dvec3(-0.28, -SUNK, -0.28), dvec3(0.28, 0.7, 0.28), fine);
    builder.cuboid(palette.stone, dvec3(-0.33, 0.66, -0.33), dvec3(0.33, 0.76, 0.33), fine);
    let profile = [
        [0.0, 0.75],
        [0.16, 0.755],
        [0.08, 0.84],
        [0.2, 1.0],
        [0.31, 1.25],
        [0.24, 1.5],
        [0.12, 1.66],
        [0.18, 1.78],
        [0.165, 1.785],
        [0.1, 1.66],
        [0.21, 1.48],
        [0.28, 1.25],
        [0.17, 1.02],
        [0.0, 0.95],
    ];
    builder.revolve_smooth(palette.bronze, builder.bent(28, [30, 14]), &profile);
    for face in [-1.0, 1.0] {
        let path = |t: f64| {
            let angle = TURN * mix(-0.22, 0.25, t);
            dvec3(face * (0.2 + 0.14 * cos(angle)), 1.48 + 0.17 * sin(angle), 0.0)
        };
        builder.tube(palette.bronze, builder.bent(8, [18, 4]), path, |_| 0.018);
    }
    builder.torus(palette.bronze, builder.ring(8, 32), DVec3::Y * 1.25, [0.315, 0.014]);
}

fn bench(builder: &mut MeshBuilder, palette: &Palette) {
    let fine = builder.along(2);
    let seat = dvec3(-0.9, 0.4, -0.22);
    builder.cuboid(palette.marble, seat, dvec3(0.9, 0.48, 0.22), [builder.along(8), fine, fine]);
    for x in [-0.65, 0.65] {
        let min = dvec3(x - 0.09, 0.0, -0.17);
        builder.cuboid(palette.stone, min, dvec3(x + 0.09, 0.41, 0.17), [fine, fine, fine]);
    }
}
