//! Outer walls, ground and painted sky, seen from inside; the floors of the galleries, cornices, doors, windows.

use super::*;

pub(super) fn build(builder: &mut MeshBuilder) {
    builder.part("walls", Frame::WORLD, walls);
    builder.part("floors", Frame::WORLD, slabs);
    for side in Side::all() {
        builder.frame = side.frame.shift(DVec3::Z * GALLERY);
        openings(builder, &side);
    }
}

fn walls(builder: &mut MeshBuilder) {
    let [x, z] = COURT.map(|half| half + GALLERY);
    // A metre or a part of it, so that the floor can be paved.
    let part = builder.along(1);
    let (xs, zs) = (steps(-x, x, 26 * part), steps(-z, z, 18 * part));
    let ys = steps(0.0, SKY_HEIGHT, builder.along(16));
    // du x dv points inwards.
    builder.sheet(WALL, &ys, &zs, |v, u| dvec3(-x, v, u));
    builder.sheet(WALL, &zs, &ys, |u, v| dvec3(x, v, u));
    builder.sheet(WALL, &xs, &ys, |u, v| dvec3(u, v, -z));
    builder.sheet(WALL, &ys, &xs, |v, u| dvec3(u, v, z));
    builder.sheet(SKY, &xs, &zs, |u, v| dvec3(u, SKY_HEIGHT, v));
    // The court is paved in two colours.
    let paved = |row: usize, column: usize| {
        let (i, j) = (column / part, row / part);
        if (4..22).contains(&i) && (4..14).contains(&j) { Some((i + j) % 2) } else { None }
    };
    for (material, tile) in [(FLOOR, None), (LIGHT_TILE, Some(0)), (DARK_TILE, Some(1))] {
        let hole = |row, column| paved(row, column) != tile;
        builder.sheet_with_holes(material, &zs, &xs, |v, u| dvec3(u, 0.0, v), hole);
    }
}

/// The upper galleries' floor, the roof over them, and what stands out from their edges.
fn slabs(builder: &mut MeshBuilder) {
    let [x, z] = COURT;
    let inside = |by: f64| dvec2(x - by, z - by);
    // Everything reaches into the wall by another depth, so that no faces coincide there.
    let outside = |by: f64| dvec2(x + GALLERY + by, z + GALLERY + by);
    let divisions = [16, 8, 1];
    builder.border(FLOOR, divisions, [inside(0.42), outside(0.3)], [FLOORS[1] - 0.45, FLOORS[1]]);
    builder.border(TRIM, divisions, [inside(0.44), outside(0.32)], [8.7, 9.3]);
    // Mouldings under either edge and a gutter above.
    let thin = [16, 1, 1];
    for (by, bottom, top) in
        [(0.5, 4.86, 4.95), (0.47, 4.7, 4.88), (0.52, 9.12, 9.24), (0.48, 8.94, 9.14), (0.58, 9.22, 9.36)]
    {
        builder.border(STONE, thin, [inside(by), inside(by - 0.13)], [bottom, top]);
    }
    // Skirting and a string course along the outer walls.
    for (by, bottom, top) in [(3.94, -0.05, 0.22), (3.93, 3.9, 4.02), (3.95, 4.9, 5.2), (3.92, 8.1, 8.24)] {
        builder.border(STONE, thin, [inside(-by), outside(0.32 - 0.02 * by)], [bottom, top]);
    }
    // A low wall around the roof.
    builder.border(WALL, thin, [inside(0.3), inside(-0.05)], [9.25, 9.9]);
    builder.border(STONE, thin, [inside(0.36), inside(-0.11)], [9.86, 9.98]);
}

/// Doors below and windows above, in the outer wall of a side (its frame's plane z = 0).
fn openings(builder: &mut MeshBuilder, side: &Side) {
    for bay in 0..side.bays {
        let x = side.column(bay) + side.half / side.bays as f64;
        let part = |builder: &mut MeshBuilder, material, [x0, x1]: [f64; 2], [y0, y1]: [f64; 2], out: f64| {
            builder.cuboid(material, dvec3(x + x0, y0, -out), dvec3(x + x1, y1, 0.05 + out), [2, 4, 2]);
        };
        builder.object_here("door");
        part(builder, WOOD, [-0.62, 0.62], [-0.04, 2.55], 0.05);
        part(builder, STONE, [-0.78, -0.6], [-0.06, 2.54], 0.09);
        part(builder, STONE, [0.6, 0.78], [-0.06, 2.54], 0.09);
        part(builder, STONE, [-0.8, 0.8], [2.5, 2.75], 0.1);
        builder.object_here("window");
        part(builder, SKY, [-0.58, 0.58], [6.0, 7.6], 0.03);
        part(builder, STONE, [-0.7, -0.55], [5.9, 7.58], 0.09);
        part(builder, STONE, [0.55, 0.7], [5.9, 7.58], 0.09);
        part(builder, STONE, [-0.72, 0.72], [7.55, 7.75], 0.1);
        part(builder, STONE, [-0.8, 0.8], [5.82, 6.02], 0.16);
        part(builder, WOOD, [-0.03, 0.03], [5.95, 7.62], 0.05);
    }
}
