//! What stands and hangs in the court: a fountain, drapes, potted plants, bronze vases, lanterns on chains, benches.

use super::*;

pub(super) fn build(builder: &mut MeshBuilder) {
    builder.part("fountain", Frame::WORLD, fountain);
    for (number, side) in Side::all().iter().enumerate() {
        for bay in 0..side.bays {
            let middle = side.column(bay) + side.half / side.bays as f64;
            let key = number * 10 + bay;
            if key % 2 == 1 {
                builder.object_at(format!("drape {number}.{bay}"), side.frame.shift(dvec3(middle, 0.0, 0.05)));
                hang(builder, key, [4.35, 0.9], 1.5);
            }
            if bay % 3 == 1 {
                builder.object_at(format!("banner {number}.{bay}"), side.frame.shift(dvec3(middle, FLOORS[1], -0.62)));
                hang(builder, key + 1, [0.9, -1.3], 1.1);
            } else {
                builder.object_at(format!("lantern {number}.{bay}"), side.frame.shift(dvec3(middle, 0.0, 1.9)));
                lantern(builder, FLOORS[1] - 0.44);
            }
        }
    }
    let mut random = Random(61);
    let plants = [(-7.6, -3.6), (7.6, -3.6), (7.6, 3.6), (-7.6, 3.6), (0.0, 3.9), (0.0, -3.9)];
    for (number, (x, z)) in plants.into_iter().enumerate() {
        let frame = Frame::at(dvec3(x, 0.0, z)).yaw(random.between(0.0, TURN));
        builder.object_at(format!("plant {number}"), frame);
        plant(builder, &mut random);
    }
    let [x, z] = COURT.map(|half| half + 3.0);
    let vases = [(-x, -z), (x, -z), (x, z), (-x, z), (-4.5, z), (1.5, z), (-1.5, -z), (4.5, -z)];
    for (number, (x, z)) in vases.into_iter().enumerate() {
        builder.part(format!("vase {number}"), Frame::at(dvec3(x, 0.0, z)), vase);
    }
    let benches = [(-4.6, 3.4, 0.05), (4.6, 3.4, -0.04), (-4.6, -3.4, 0.03), (4.6, -3.4, 0.0)];
    for (number, (x, z, turn)) in benches.into_iter().enumerate() {
        builder.part(format!("bench {number}"), Frame::at(dvec3(x, -SUNK, z)).yaw(turn), bench);
    }
}

/// A wide basin with water, a stem, two bowls, and jets.
fn fountain(builder: &mut MeshBuilder) {
    let basin = knots(
        [0.0, 1.65, 1.8, 1.75, 1.85, 1.9, 1.82, 1.68, 1.6, 1.45, 0.0],
        [-0.006, -0.006, 0.06, 0.2, 0.42, 0.5, 0.54, 0.5, 0.2, 0.1, 0.08],
    );
    builder.revolve_smooth(MARBLE, [60, 40, 10], &basin);
    let water = [[0.0, 0.2], [1.63, 0.2], [1.665, 0.42], [1.2, 0.425], [0.6, 0.422], [0.0, 0.42]];
    builder.revolve(WATER, 48, &water.map(DVec2::from_array));
    let stem = knots(
        [
            0.0, 0.35, 0.25, 0.14, 0.2, 0.5, 0.85, 0.88, 0.82, 0.5, 0.16, 0.1, 0.14, 0.42, 0.45, 0.4, 0.1, 0.06, 0.09,
            0.0,
        ],
        [
            0.07, 0.08, 0.3, 0.6, 0.85, 1.05, 1.22, 1.26, 1.25, 1.12, 1.08, 1.4, 1.62, 1.8, 1.84, 1.83, 1.74, 1.95,
            2.05, 2.12,
        ],
    );
    builder.revolve_smooth(MARBLE, [40, 60, 20], &stem);
    for (y, radius) in [(1.18, 0.72), (1.79, 0.33)] {
        let water = [[0.0, y - 0.05], [0.7 * radius, y - 0.05], [radius, y + 0.012], [0.0, y + 0.016]];
        builder.revolve(WATER, 32, &water.map(DVec2::from_array));
    }
    for out in spokes(8) {
        let path = |t: f64| out * mix(0.7, 1.35, t) + DVec3::Y * (1.2 + 0.55 * t - 1.35 * t * t);
        builder.tube(WATER, [8, 16, 4], path, |t| mix(0.02, 0.012, t));
    }
}

/// A cloth on a rod, in the frame's plane z = 0.
fn hang(builder: &mut MeshBuilder, key: usize, [top, bottom]: [f64; 2], width: f64) {
    let (folds, depth, phase) = (4.0, 0.05, 0.7 * key as f64);
    builder.cloth([RED_CLOTH, BLUE_CLOTH, GREEN_CLOTH][key % 3], [[24, 6], [10, 2]], 0.0045, |up, along, off| {
        // Rows differ in size and place only, so that every cell is flat: a bent one could reach through the cloth.
        let size = 1.0 - 0.12 * up + 0.04 * sin(3.0 * up + phase);
        let fold = sin(TURN * folds * along + phase) + 0.3 * sin(TURN * 2.3 * folds * along + 2.0 * phase);
        let flat = dvec3((along - 0.5) * width, 0.0, depth * fold + off) * size;
        dvec3(0.1 * depth * sin(2.5 * up + phase), mix(bottom, top, up), 0.0) + flat
    });
    let half = width * 0.56;
    builder.rod(IRON, [8, 6], [dvec3(-half, top - 0.01, 0.0), dvec3(half, top - 0.01, 0.0)], 0.016);
}

/// A lantern with a flame that hangs by a chain from height `top`.
fn lantern(builder: &mut MeshBuilder, top: f64) {
    let low = 3.2;
    builder.chain(IRON, [6, 10, 3], [DVec3::Y * (top + 0.02), DVec3::Y * low], 0.0, [0.24, 0.018]);
    builder.frame = builder.frame.shift(DVec3::Y * (low - 0.5));
    let cap = [[0.0, 0.38], [0.2, 0.4], [0.12, 0.46], [0.04, 0.5], [0.0, 0.52]];
    builder.revolve_smooth(IRON, [14, 10, 4], &cap);
    let dish = [[0.0, 0.0], [0.09, 0.01], [0.16, 0.07], [0.15, 0.075], [0.0, 0.03]];
    builder.revolve_smooth(BRONZE, [14, 10, 4], &dish);
    for out in spokes(6) {
        builder.rod(IRON, [6, 4], [out * 0.15 + DVec3::Y * 0.06, out * 0.18 + DVec3::Y * 0.4], 0.008);
    }
    builder.ball(FLAME, DVec3::Y * 0.14, 0.07, 12);
}

/// A clay pot with arching leaves.
fn plant(builder: &mut MeshBuilder, random: &mut Random) {
    let pot = knots([0.0, 0.26, 0.3, 0.42, 0.46, 0.43, 0.38, 0.0], [-SUNK, -SUNK, 0.05, 0.4, 0.62, 0.64, 0.55, 0.53]);
    builder.revolve_smooth(CLAY, [32, 20, 8], &pot);
    for leaf in 0..22 {
        let heading = TURN * (f64::from(leaf) * 0.382) + random.between(-0.1, 0.1);
        let out = dvec3(cos(heading), 0.0, sin(heading));
        let side = dvec3(-out.z, 0.0, out.x);
        let (reach, tall) = (random.between(0.3, 0.95), random.between(0.9, 1.7));
        let droop = random.between(0.1, 0.4);
        let path = |t: f64| out * (0.08 + reach * t * t) + DVec3::Y * (0.5 + tall * (t - droop * t * t * t));
        builder.ribbon(LEAF, [6, 10, 4], Some(side), path, |t| {
            let body = sin(TURN / 2.0 * (0.1 + 0.88 * t));
            dvec2(0.008 + 0.06 * body * body, 0.003 + 0.004 * (1.0 - t))
        });
    }
}

/// A polished bronze vase on a pedestal, with two handles.
fn vase(builder: &mut MeshBuilder) {
    let fine = [2, 4, 2];
    builder.cuboid(STONE, dvec3(-0.28, -SUNK, -0.28), dvec3(0.28, 0.7, 0.28), fine);
    builder.cuboid(STONE, dvec3(-0.33, 0.66, -0.33), dvec3(0.33, 0.76, 0.33), fine);
    let profile = knots(
        [0.0, 0.16, 0.08, 0.2, 0.31, 0.24, 0.12, 0.18, 0.165, 0.1, 0.21, 0.28, 0.17, 0.0],
        [0.75, 0.755, 0.84, 1.0, 1.25, 1.5, 1.66, 1.78, 1.785, 1.66, 1.48, 1.25, 1.02, 0.95],
    );
    builder.revolve_smooth(BRONZE, [28, 30, 14], &profile);
    for face in [-1.0, 1.0] {
        let path = |t: f64| {
            let angle = TURN * mix(-0.22, 0.25, t);
            dvec3(face * (0.2 + 0.14 * cos(angle)), 1.48 + 0.17 * sin(angle), 0.0)
        };
        builder.tube(BRONZE, [8, 18, 4], path, |_| 0.018);
    }
    builder.torus(BRONZE, [8, 32, 3], DVec3::Y * 1.25, [0.315, 0.014]);
}

fn bench(builder: &mut MeshBuilder) {
    builder.cuboid(MARBLE, dvec3(-0.9, 0.4, -0.22), dvec3(0.9, 0.48, 0.22), [8, 2, 2]);
    for x in [-0.65, 0.65] {
        builder.cuboid(STONE, dvec3(x - 0.09, 0.0, -0.17), dvec3(x + 0.09, 0.41, 0.17), [2, 2, 2]);
    }
}
