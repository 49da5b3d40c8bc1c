//! Thick walls, a floor of flagstones, panelling, posts, beams and boards under the ceiling.

use super::*;

pub(super) fn build(builder: &mut MeshBuilder) {
    builder.part("walls", Frame::WORLD, inside);
    let [x, z] = HALF.map(|half| half + 0.35);
    builder.cuboid(STONE, dvec3(-x, -0.4, -z), dvec3(x, HEIGHT + 0.35, z), [10, 6, 10]);
    builder.part("flagstones", Frame::WORLD, flagstones);
    builder.part("panelling", Frame::WORLD, panelling);
    builder.part("beams", Frame::WORLD, beams);
}

/// The room's six sides, seen from inside.
fn inside(builder: &mut MeshBuilder) {
    let [x, z] = HALF;
    let (xs, zs) = (steps(-x, x, builder.along(20)), steps(-z, z, builder.along(16)));
    let ys = steps(0.0, HEIGHT, builder.along(8));
    // du x dv points inwards.
    builder.sheet(WALL, &ys, &zs, |v, u| dvec3(-x, v, u));
    builder.sheet(WALL, &zs, &ys, |u, v| dvec3(x, v, u));
    builder.sheet(WALL, &xs, &ys, |u, v| dvec3(u, v, -z));
    builder.sheet(WALL, &ys, &xs, |v, u| dvec3(u, v, z));
    builder.sheet(WALL, &zs, &xs, |v, u| dvec3(u, 0.0, v));
    builder.sheet(WALL, &xs, &zs, |u, v| dvec3(u, HEIGHT, v));
}

/// Stones of different widths in rows, with joints between them and not all equally high.
fn flagstones(builder: &mut MeshBuilder) {
    let mut random = Random(5);
    let [half_x, half_z] = HALF;
    let rows = 10;
    let deep = 2.0 * half_z / f64::from(rows);
    for row in 0..rows {
        let z = -half_z + deep * f64::from(row);
        let mut x = -half_x;
        while x < half_x - 0.3 {
            let wide = random.between(0.7, 1.2);
            let end = if x + wide > half_x - 0.5 { half_x } else { x + wide };
            let top = random.between(0.008, 0.016);
            let max = dvec3(end - 0.008, top, z + deep - 0.008);
            builder.cuboid(STONE, dvec3(x + 0.008, -0.05, z + 0.008), max, [0; 3]);
            x = end;
        }
    }
}

/// Upright boards along the walls, with gaps, up to where the posts' braces begin.
fn panelling(builder: &mut MeshBuilder) {
    let mut random = Random(6);
    for turn in 0..4 {
        let (half, out) = if turn % 2 == 0 { (HALF[0], HALF[1]) } else { (HALF[1], HALF[0]) };
        builder.frame = Frame::WORLD.yaw(TURN / 4.0 * f64::from(turn)).shift(DVec3::Z * out);
        let boards = (half / 0.25) as usize;
        let wide = 2.0 * half / boards as f64;
        for board in 0..boards {
            let x = -half + wide * board as f64;
            let thick = random.between(0.015, 0.03);
            let high = random.between(2.75, 2.85);
            let material = if random.between(0.0, 1.0) < 0.5 { BOARD } else { WOOD };
            let min = dvec3(x + 0.006, -0.03 - 0.004 * f64::from(turn), -thick);
            builder.cuboid(material, min, dvec3(x + wide - 0.006, high, thick), [0; 3]);
        }
    }
}

/// Posts with braces along the long walls, beams across, rafters along, boards above these.
fn beams(builder: &mut MeshBuilder) {
    let mut random = Random(7);
    let divisions = [2, 8];
    let [half_x, half_z] = HALF;
    for at in 0..5 {
        let x = -4.4 + 2.2 * f64::from(at);
        let across = [dvec3(x, 3.45, -half_z - 0.06), dvec3(x, 3.45, half_z + 0.06)];
        builder.beam(DARK_WOOD, divisions, across, [0.13, 0.1], DVec3::Y);
        for face in [-1.0, 1.0] {
            let z = face * (half_z - 0.08);
            let post = [dvec3(x + 0.005, -0.02, z), dvec3(x + 0.005, 3.4, z)];
            builder.beam(DARK_WOOD, divisions, post, [0.09, 0.1], DVec3::X);
            let brace = [dvec3(x, 2.5, face * (half_z - 0.15)), dvec3(x, 3.38, face * (half_z - 1.0))];
            builder.beam(DARK_WOOD, divisions, brace, [0.05, 0.07], DVec3::X);
        }
    }
    for at in 0..7 {
        let z = -3.6 + 1.2 * f64::from(at);
        let along = [dvec3(-half_x - 0.08, 3.65, z), dvec3(half_x + 0.08, 3.65, z)];
        builder.beam(WOOD, divisions, along, [0.1, 0.06], DVec3::Y);
    }
    for at in 0..33 {
        let x = -4.95 + 0.3 * f64::from(at);
        let y = 3.765 + random.between(0.0, 0.01);
        let min = dvec3(x + 0.008, y, -half_z - random.between(0.03, 0.09));
        builder.cuboid(BOARD, min, dvec3(x + 0.292, y + 0.03, half_z + random.between(0.03, 0.09)), [0; 3]);
    }
}
