//! The building: thick walls and a gabled roof, a floor slab, cladding, window bands, gate leaves, puddles.

use super::*;

pub(super) fn build(builder: &mut MeshBuilder) {
    builder.object("walls and roof");
    gabled(builder, WALL, 0.0, true);
    gabled(builder, WALL, 0.4, false);
    builder.object("floor");
    let [x, z] = HALF.map(|half| half + 0.1);
    builder.cuboid(CONCRETE, dvec3(-x, -0.15, -z), dvec3(x, 0.0, z), [38, 0, 26]);
    cladding(builder);
    gate(builder);
    puddles(builder);
}

/// The hall's section drawn along x, `out` metres outside of its inside; seen from inside if `inward`.
fn gabled(builder: &mut MeshBuilder, material: MaterialId, out: f64, inward: bool) {
    let z = HALF[1] + out;
    let [low, eaves, ridge] = [-0.1 - out, EAVES + out, RIDGE + out];
    let corners = [[-z, low], [-z, eaves], [0.0, ridge], [z, eaves], [z, low]];
    let mut section = builder.outline(&corners, &[5, 8, 8, 5, 12]);
    // About +x, from +y to +z, is counter-clockwise.
    if inward {
        section.reverse();
    }
    let xs = steps(-HALF[0] - out, HALF[0] + out, builder.along(30));
    let ends = Ends::Closed(dvec3(xs[0], 6.0, 0.0), dvec3(xs[xs.len() - 1], 6.0, 0.0));
    builder.rings(material, [xs.len(), section.len()], ends, |ring, at| dvec3(xs[ring], section[at].y, section[at].x));
}

/// Panels on the long walls and under the roof, and bands of windows above them.
fn cladding(builder: &mut MeshBuilder) {
    builder.object("cladding");
    for bay in 0..10 {
        let middle = -27.0 + 6.0 * f64::from(bay);
        for face in [-1.0, 1.0] {
            let plane = face * (HALF[1] + 0.02);
            for (material, middle, half, [y0, y1], deep) in [
                (SHEET, middle, 2.93, [-0.05, 5.6], 0.1),
                (SHEET, middle, 2.93, [5.7, 9.4], 0.1),
                (GLASS, middle, 2.7, [9.6, 11.8], 0.07),
                (WHITE, middle - 0.9, 0.04, [9.5, 11.9], 0.12),
                (WHITE, middle + 0.9, 0.04, [9.5, 11.9], 0.12),
            ] {
                let min = dvec3(middle - half, y0, plane - deep);
                builder.cuboid(material, min, dvec3(middle + half, y1, plane + deep), [2, 2, 2]);
            }
            // A sheet under the roof's slope.
            let eave = dvec3(middle, EAVES + 0.02, face * (HALF[1] - 0.08));
            let ridge = dvec3(middle, RIDGE - 0.12, face * 0.4);
            builder.beam(SHEET, [2, 2], [eave, ridge], [2.96, 0.09], DVec3::X);
        }
    }
}

/// Two leaves of a sliding gate at the far end (greatest x), with ribs.
fn gate(builder: &mut MeshBuilder) {
    builder.object("gate");
    for (leaf, z) in [-7.6, 7.6].into_iter().enumerate() {
        let x = HALF[0] - 0.3 - 0.35 * leaf as f64;
        builder.cuboid(BLUE, dvec3(x - 0.08, 0.03, z - 7.9), dvec3(x + 0.08, 9.5, z + 7.9), [2, 10, 10]);
        for rib in 0..6 {
            let at = z - 6.9 + 2.76 * f64::from(rib);
            builder.cuboid(BLUE, dvec3(x - 0.14, 0.06, at - 0.07), dvec3(x + 0.12, 9.45, at + 0.07), [2, 10, 2]);
        }
        builder.cuboid(STEEL, dvec3(x - 0.12, 9.3, -HALF[1] - 0.05), dvec3(x + 0.13, 9.7, HALF[1] + 0.05), [2, 2, 10]);
    }
}

/// Flat lenses of water on the floor, with uneven rims: mirrors.
fn puddles(builder: &mut MeshBuilder) {
    builder.object("puddles");
    for (x, z, size, phase) in
        [(-14.0, 12.0, 2.6, 0.3), (9.0, 13.0, 1.8, 2.0), (3.0, -13.5, 2.2, 4.0), (22.0, 1.0, 2.9, 5.1)]
    {
        builder.frame = Frame::at(dvec3(x, 0.0, z));
        let around = builder.around(48);
        let ends = Ends::Closed(DVec3::Y * -SUNK, DVec3::Y * 0.012);
        builder.turned(PUDDLE, [3, around], ends, |ring, angle| {
            let wave = 1.0 + 0.22 * sin(2.0 * angle + phase) + 0.1 * sin(5.0 * angle + 2.0 * phase);
            let (radius, y) = [(size * wave, -SUNK), (size * wave, 0.004), (0.9 * size * wave, 0.011)][ring];
            dvec3(radius * cos(angle), y, -radius * sin(angle))
        });
    }
}
