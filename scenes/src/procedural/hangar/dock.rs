//! Service docks: scaffolds of tubes with planked decks on either side of the transport's tail and before its nose.

use super::*;

pub(super) fn build(builder: &mut MeshBuilder) {
    let places = [(-9.0, 4.9, 0.42, 8.0), (-12.4, -2.6, 0.42, 6.0), (8.5, 0.4, 0.9, 6.0)];
    for (number, (x, z, turn, long)) in places.into_iter().enumerate() {
        builder.object_at(format!("dock {number}"), Frame::at(dvec3(x, 0.0, z)).yaw(turn));
        dock(builder, long);
    }
}

/// A scaffold `long` metres along x with three decks.
fn dock(builder: &mut MeshBuilder, long: f64) {
    let tube = [6, 4];
    let half = long / 2.0;
    let bays = libm::round(long / 2.0) as usize;
    for face in [-1.0, 1.0] {
        for post in 0..=bays {
            let x = -half + long * post as f64 / bays as f64;
            builder.rod(YELLOW, tube, [dvec3(x, -SUNK, face), dvec3(x, 5.2, face)], 0.04);
        }
        for (number, y) in [1.3, 2.7, 4.1].into_iter().enumerate() {
            for rail in [-0.12, 0.95] {
                let ends = [-half - 0.15, half + 0.15].map(|x| dvec3(x, y + rail, face * 1.02));
                builder.rod(YELLOW, tube, ends, 0.03);
            }
            let bay = 2.0 * half / bays as f64;
            let from = -half + bay * (number % bays) as f64;
            let brace = [dvec3(from, y - 1.3, face * 1.04), dvec3(from + bay, y - 0.1, face * 1.04)];
            builder.rod(STEEL, tube, brace, 0.025);
        }
    }
    for y in [1.3, 2.7, 4.1] {
        for plank in 0..3 {
            let z = -0.64 + 0.64 * f64::from(plank);
            let min = dvec3(-half - 0.1, y - 0.05, z - 0.3);
            builder.cuboid(WOOD, min, dvec3(half + 0.1, y, z + 0.3), [4, 1, 2]);
        }
        for bearer in 0..=bays {
            let x = -half + long * bearer as f64 / bays as f64;
            builder.beam(STEEL, [1, 2], [dvec3(x, y - 0.08, -1.1), dvec3(x, y - 0.08, 1.1)], [0.04, 0.03], DVec3::Y);
        }
    }
}
