//! A shelf against the right wall with books, vases, balls and a knot.

use super::*;

/// Width, height and depth in metres.
const SIZE: DVec3 = dvec3(1.5, 1.9, 0.3);
/// Upper sides of the boards, from the lowest.
const BOARDS: [f64; 5] = [0.1, 0.55, 0.98, 1.4, 1.885];

pub(super) fn build(builder: &mut MeshBuilder) {
    // In this frame x runs along the wall, z out of it, and the shelf's back is in the plane z = 0.
    let here = Frame::at(dvec3(MAX.x - 0.016, 0.0, -0.35)).yaw(-TURN / 4.0);
    builder.frame = here;
    let half = SIZE.x / 2.0;
    for x in [-half, half] {
        builder.cuboid(WOOD, dvec3(x - 0.012, -SUNK, 0.0), dvec3(x + 0.012, SIZE.y, SIZE.z), [0, 6, 0]);
    }
    for y in BOARDS {
        builder.cuboid(WOOD, dvec3(-half, y - 0.02, 0.003), dvec3(half, y, SIZE.z - 0.004), [6, 0, 0]);
    }
    let mut random = Random(20);
    for (board, row) in BOARDS.into_iter().zip([[-0.7, 0.55], [-0.7, 0.05], [-0.1, 0.7], [-0.7, -0.25]]) {
        books(builder, here, &mut random, board, row);
    }
    builder.frame = here;
    ornaments(builder, here);
}

/// A row of upright books; now and then one leans on the one before it.
fn books(builder: &mut MeshBuilder, here: Frame, random: &mut Random, board: f64, [mut x, to]: [f64; 2]) {
    let covers = [RED_BOOK, GREEN_BOOK, TAN_BOOK, BLUE_BOOK, GREY_BOOK];
    while x < to {
        let thick = random.between(0.014, 0.045);
        let tall = random.between(0.2, 0.31);
        let deep = random.between(0.14, 0.2);
        let lean = if random.between(0.0, 1.0) < 0.2 { random.between(0.05, 0.16) } else { 0.0 };
        let cover = covers[random.between(0.0, 5.0) as usize % 5];
        // Leaning to the left needs room for the top on that side, and the lower right edge rises.
        let room = tall * sin(lean);
        builder.frame = here.shift(dvec3(x + room, board - 0.001, random.between(0.02, 0.05))).roll(lean);
        builder.cuboid(cover, DVec3::ZERO, dvec3(thick, tall, deep), [0; 3]);
        x += room + thick / cos(lean) + random.between(0.001, 0.003);
    }
}

fn ornaments(builder: &mut MeshBuilder, here: Frame) {
    let vase = knots(
        [0.0, 0.04, 0.05, 0.085, 0.06, 0.026, 0.038, 0.035, 0.021, 0.054, 0.079, 0.04, 0.0],
        [-0.001, -0.001, 0.01, 0.09, 0.19, 0.25, 0.29, 0.291, 0.25, 0.19, 0.09, 0.014, 0.01],
    );
    let vase = smooth_profile(&vase, builder.divide(24, 12));
    for (x, board, size, material) in [
        (0.3, 1, 1.0, GLAZE),
        (0.52, 1, 0.72, CLAY),
        (-0.55, 2, 0.9, MARBLE),
        (0.55, 3, 1.15, GLAZE),
        (-0.45, 4, 1.3, CLAY),
    ] {
        let profile: Vec<_> = vase.iter().map(|&point| point * size).collect();
        builder.frame = here.shift(dvec3(x, BOARDS[board], 0.15));
        builder.revolve(material, 24, &profile);
    }
    // A trefoil knot.
    builder.frame = here.shift(dvec3(0.05, BOARDS[3] + 0.118, 0.16));
    let knot = |t: f64| {
        let angle = TURN * t;
        let reach = 2.0 + cos(3.0 * angle);
        dvec3(0.034 * reach * cos(2.0 * angle), 0.034 * reach * sin(2.0 * angle), 0.034 * sin(3.0 * angle))
    };
    builder.loop_tube(MIRROR, [12, 96, 12], knot, 0.0165);
    builder.frame = here;
    for (x, y, radius, material) in [
        (-0.32, BOARDS[2] + 0.069, 0.07, MIRROR),
        (0.3, BOARDS[3] + 0.049, 0.05, FRUIT),
        (0.1, BOARDS[4] + 0.089, 0.09, STONE),
    ] {
        builder.ball(material, dvec3(x, y, 0.15), radius, 24);
    }
    builder.torus(METAL, [12, 36, 3], dvec3(0.45, BOARDS[4] + 0.024, 0.15), [0.09, 0.025]);
}
