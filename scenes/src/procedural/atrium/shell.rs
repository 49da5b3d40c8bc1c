//! Outer walls, ground and painted sky, seen from inside; the floors of the galleries, cornices, doors, windows.

use glam::{DVec3, dvec2, dvec3};

use super::{COURT, FLOORS, GALLERY, Palette, SKY, Side};
use crate::procedural::builder::{MaterialId, MeshBuilder};
use crate::procedural::shapes::steps;

pub(super) fn build(builder: &mut MeshBuilder, palette: &Palette) {
    builder.object("walls");
    walls(builder, palette);
    builder.object("floors");
    slabs(builder, palette);
    for side in Side::all() {
        builder.frame = side.frame.shift(DVec3::Z * GALLERY);
        openings(builder, palette, &side);
    }
}

fn walls(builder: &mut MeshBuilder, palette: &Palette) {
    let [x, z] = COURT.map(|half| half + GALLERY);
    // A metre or a part of it, so that the floor can be paved.
    let part = builder.along(1);
    let (xs, zs) = (steps(-x, x, 26 * part), steps(-z, z, 18 * part));
    let ys = steps(0.0, SKY, builder.along(16));
    let solid = |_: usize, _: usize| false;
    // du x dv points inwards.
    builder.sheet(palette.wall, &ys, &zs, |v, u| dvec3(-x, v, u), solid);
    builder.sheet(palette.wall, &zs, &ys, |u, v| dvec3(x, v, u), solid);
    builder.sheet(palette.wall, &xs, &ys, |u, v| dvec3(u, v, -z), solid);
    builder.sheet(palette.wall, &ys, &xs, |v, u| dvec3(u, v, z), solid);
    builder.sheet(palette.sky, &xs, &zs, |u, v| dvec3(u, SKY, v), solid);
    // The court is paved in two colours.
    let paved = |row: usize, column: usize| {
        let (i, j) = (column / part, row / part);
        if (4..22).contains(&i) && (4..14).contains(&j) { Some((i + j) % 2) } else { None }
    };
    for (material, tile) in [(palette.floor, None), (palette.tile[0], Some(0)), (palette.tile[1], Some(1))] {
        builder.sheet(material, &zs, &xs, |v, u| dvec3(u, 0.0, v), |row, column| paved(row, column) != tile);
    }
}

/// The upper galleries' floor, the roof over them, and what stands out from their edges.
fn slabs(builder: &mut MeshBuilder, palette: &Palette) {
    let [x, z] = COURT;
    let inside = |by: f64| dvec2(x - by, z - by);
    // Everything reaches into the wall by another depth, so that no faces coincide there.
    let outside = |by: f64| dvec2(x + GALLERY + by, z + GALLERY + by);
    let divisions = builder.sides([16, 8, 1]);
    builder.border(palette.floor, divisions, [inside(0.42), outside(0.3)], [FLOORS[1] - 0.45, FLOORS[1]]);
    builder.border(palette.trim, divisions, [inside(0.44), outside(0.32)], [8.7, 9.3]);
    // Mouldings under either edge and a gutter above.
    let thin = builder.sides([16, 1, 1]);
    for (by, bottom, top) in
        [(0.5, 4.86, 4.95), (0.47, 4.7, 4.88), (0.52, 9.12, 9.24), (0.48, 8.94, 9.14), (0.58, 9.22, 9.36)]
    {
        builder.border(palette.stone, thin, [inside(by), inside(by - 0.13)], [bottom, top]);
    }
    // Skirting and a string course along the outer walls.
    for (by, bottom, top) in [(3.94, -0.05, 0.22), (3.93, 3.9, 4.02), (3.95, 4.9, 5.2), (3.92, 8.1, 8.24)] {
        builder.border(palette.stone, thin, [inside(-by), outside(0.32 - 0.02 * by)], [bottom, top]);
    }
    // A low wall around the roof.
    builder.border(palette.wall, thin, [inside(0.3), inside(-0.05)], [9.25, 9.9]);
    builder.border(palette.stone, thin, [inside(0.36), inside(-0.11)], [9.86, 9.98]);
}

/// Doors below and windows above, in the outer wall of a side (its frame's plane z = 0).
fn openings(builder: &mut MeshBuilder, palette: &Palette, side: &Side) {
    let [fine, rows] = builder.sides([2, 4]);
    for bay in 0..side.bays {
        let x = side.column(bay) + side.half / side.bays as f64;
        let part =
            |builder: &mut MeshBuilder, material: MaterialId, [x0, x1]: [f64; 2], [y0, y1]: [f64; 2], out: f64| {
                let min = dvec3(x0, y0, -out);
                builder.cuboid(material, min, dvec3(x1, y1, 0.05 + out), [fine, rows, fine]);
            };
        builder.object_here("door");
        part(builder, palette.wood, [x - 0.62, x + 0.62], [-0.04, 2.55], 0.05);
        part(builder, palette.stone, [x - 0.78, x - 0.6], [-0.06, 2.54], 0.09);
        part(builder, palette.stone, [x + 0.6, x + 0.78], [-0.06, 2.54], 0.09);
        part(builder, palette.stone, [x - 0.8, x + 0.8], [2.5, 2.75], 0.1);
        builder.object_here("window");
        part(builder, palette.sky, [x - 0.58, x + 0.58], [6.0, 7.6], 0.03);
        part(builder, palette.stone, [x - 0.7, x - 0.55], [5.9, 7.58], 0.09);
        part(builder, palette.stone, [x + 0.55, x + 0.7], [5.9, 7.58], 0.09);
        part(builder, palette.stone, [x - 0.72, x + 0.72], [7.55, 7.75], 0.1);
        part(builder, palette.stone, [x - 0.8, x + 0.8], [5.82, 6.02], 0.16);
        part(builder, palette.wood, [x - 0.03, x + 0.03], [5.95, 7.62], 0.05);
    }
}
