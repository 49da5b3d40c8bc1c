//! The building: thick walls and a gabled roof, a floor slab, cladding, window bands, gate leaves, puddles.

use glam::{DVec3, dvec2, dvec3};

use super::{EAVES, HALF, Palette, RIDGE, SUNK};
use crate::procedural::builder::{Ends, MaterialId, MeshBuilder};
use crate::procedural::math::{Frame, TURN, cos, sin};
use crate::procedural::parts::outline;
use crate::procedural::shapes::steps;

pub(super) fn build(builder: &mut MeshBuilder, palette: &Palette) {
    builder.object("walls and roof");
    let thick = 0.4;
    gabled(builder, palette.wall, 0.0, true);
    gabled(builder, palette.wall, thick, false);
    builder.object("floor");
    builder.cuboid(
        palette.concrete,
        dvec3(-HALF[0] - 0.1, -0.15, -HALF[1] - 0.1),
        dvec3(HALF[0] + 0.1, 0.0, HALF[1] + 0.1),
        [builder.along(38), 1, builder.along(26)],
    );
    cladding(builder, palette);
    gate(builder, palette);
    puddles(builder, palette);
}

/// The hall's section drawn along x, `out` metres outside of its inside; seen from inside if `inward`.
fn gabled(builder: &mut MeshBuilder, material: MaterialId, out: f64, inward: bool) {
    let z = HALF[1] + out;
    let corners = [
        dvec2(-z, -0.1 - out),
        dvec2(-z, EAVES + out),
        dvec2(0.0, RIDGE + out),
        dvec2(z, EAVES + out),
        dvec2(z, -0.1 - out),
    ];
    let mut section =
        outline(&corners, &[builder.along(5), builder.along(8), builder.along(8), builder.along(5), builder.along(12)]);
    // About +x, from +y to +z, is counter-clockwise.
    if inward {
        section.reverse();
    }
    let xs = steps(-HALF[0] - out, HALF[0] + out, builder.along(30));
    let ends = [xs[0], xs[xs.len() - 1]].map(|x| dvec3(x, 6.0, 0.0));
    builder.rings(material, xs.len(), section.len(), &Ends::Closed(ends[0], ends[1]), |ring, at| {
        dvec3(xs[ring], section[at].y, section[at].x)
    });
}

/// Panels on the long walls and under the roof, and bands of windows above them.
fn cladding(builder: &mut MeshBuilder, palette: &Palette) {
    builder.object("cladding");
    let [fine, rows] = builder.sides([2, 2]);
    for bay in 0..10 {
        let middle = -27.0 + 6.0 * f64::from(bay);
        for face in [-1.0, 1.0] {
            let plane = face * (HALF[1] + 0.02);
            let panel = |builder: &mut MeshBuilder, material, [y0, y1]: [f64; 2], half: f64, deep: f64| {
                let min = dvec3(middle - half, y0, plane - deep);
                builder.cuboid(material, min, dvec3(middle + half, y1, plane + deep), [rows, rows, fine]);
            };
            panel(builder, palette.sheet, [-0.05, 5.6], 2.93, 0.1);
            panel(builder, palette.sheet, [5.7, 9.4], 2.93, 0.1);
            panel(builder, palette.glass, [9.6, 11.8], 2.7, 0.07);
            for bar in [-0.9, 0.9] {
                let min = dvec3(middle + bar - 0.04, 9.5, plane - 0.12);
                let max = dvec3(middle + bar + 0.04, 11.9, plane + 0.12);
                builder.cuboid(palette.white, min, max, [fine, rows, fine]);
            }
            // A sheet under the roof's slope.
            let eave = dvec3(middle, EAVES + 0.02, face * (HALF[1] - 0.08));
            let ridge = dvec3(middle, RIDGE - 0.12, face * 0.4);
            builder.beam(palette.sheet, [rows, rows], [eave, ridge], [2.96, 0.09], DVec3::X);
        }
    }
}

/// Two leaves of a sliding gate at the far end (greatest x), with ribs.
fn gate(builder: &mut MeshBuilder, palette: &Palette) {
    builder.object("gate");
    let [fine, rows] = builder.sides([2, 10]);
    for (leaf, z) in [-7.6, 7.6].into_iter().enumerate() {
        let x = HALF[0] - 0.3 - 0.35 * leaf as f64;
        let min = dvec3(x - 0.08, 0.03, z - 7.9);
        builder.cuboid(palette.blue, min, dvec3(x + 0.08, 9.5, z + 7.9), [fine, rows, rows]);
        for rib in 0..6 {
            let at = z - 6.9 + 2.76 * f64::from(rib);
            let min = dvec3(x - 0.14, 0.06, at - 0.07);
            builder.cuboid(palette.blue, min, dvec3(x + 0.12, 9.45, at + 0.07), [fine, rows, fine]);
        }
        let min = dvec3(x - 0.12, 9.3, -HALF[1] - 0.05);
        builder.cuboid(palette.steel, min, dvec3(x + 0.13, 9.7, HALF[1] + 0.05), [fine, fine, rows]);
    }
}

/// Flat lenses of water on the floor, with uneven rims: mirrors.
fn puddles(builder: &mut MeshBuilder, palette: &Palette) {
    builder.object("puddles");
    for (x, z, size, phase) in
        [(-14.0, 12.0, 2.6, 0.3), (9.0, 13.0, 1.8, 2.0), (3.0, -13.5, 2.2, 4.0), (22.0, 1.0, 2.9, 5.1)]
    {
        builder.frame = Frame::at(dvec3(x, 0.0, z));
        let around = builder.around(48);
        let middle = |y: f64| DVec3::Y * y;
        builder.rings(palette.puddle, 3, around, &Ends::Closed(middle(-SUNK), middle(0.012)), |ring, at| {
            let angle = TURN * at as f64 / around as f64;
            let wave = 1.0 + 0.22 * sin(2.0 * angle + phase) + 0.1 * sin(5.0 * angle + 2.0 * phase);
            let (radius, y) = [(size * wave, -SUNK), (size * wave, 0.004), (0.9 * size * wave, 0.011)][ring];
            dvec3(radius * cos(angle), y, -radius * sin(angle))
        });
    }
}
