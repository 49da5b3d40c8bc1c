//! The overhead crane: rails on brackets, a bridge of two lattice girders, a trolley, ropes, a hook and its load.

use super::*;

/// Height of the rails' upper side and where they run.
const RAIL: f64 = 10.3;
const TRACK: f64 = 17.6;
/// Where the bridge, its trolley and its hook are at rest.
const REST: DVec3 = dvec3(2.0, 7.2, 4.0);

pub(super) fn build(builder: &mut MeshBuilder, motion: &Motion) {
    builder.object("crane rails");
    for face in [-1.0, 1.0] {
        let ends = [-1.0, 1.0].map(|end| dvec3(end * (HALF[0] - 0.2), RAIL - 0.31, face * TRACK));
        builder.beam(STEEL, [2, 24], ends, [0.31, 0.12], DVec3::Y);
        for bracket in 0..10 {
            let x = -27.0 + 6.0 * f64::from(bracket);
            let ends = [dvec3(x, RAIL - 0.75, face * (TRACK - 0.1)), dvec3(x, RAIL - 0.75, face * (HALF[1] - 0.6))];
            builder.beam(RED_LEAD, [2, 4], ends, [0.1, 0.2], DVec3::X);
        }
    }
    builder.object("crane bridge");
    let x = REST.x + motion.bridge;
    for side in [-1.0, 1.0] {
        let ends = [-1.0, 1.0].map(|end| dvec3(x + side * 1.1, RAIL + 0.55, end * (TRACK - 0.2)));
        builder.girder(YELLOW, [6, 4], ends, 0.5, 9);
        let z = side * TRACK;
        builder.cuboid(YELLOW, dvec3(x - 2.0, RAIL + 0.02, z - 0.22), dvec3(x + 2.0, RAIL + 0.9, z + 0.22), [8, 2, 2]);
        for wheel in [-1.5, 1.5] {
            let frame = Frame::at(dvec3(x + wheel, RAIL + 0.22, z)).pitch(TURN / 4.0);
            builder.within(frame, |here| here.torus(STEEL, [8, 20, 3], DVec3::ZERO, [0.2, 0.06]));
        }
    }
    builder.object("crane trolley");
    let z = REST.z + motion.trolley;
    let top = RAIL + 1.1;
    builder.cuboid(YELLOW, dvec3(x - 1.5, top + 0.02, z - 1.0), dvec3(x + 1.5, top + 0.3, z + 1.0), [4, 2, 4]);
    builder.rod(STEEL, [24, 8], [dvec3(x - 0.9, top + 0.7, z), dvec3(x + 0.9, top + 0.7, z)], 0.42);
    let motor = dvec3(x + 0.7, top + 0.29, z - 0.75);
    builder.cuboid(GREEN, motor, motor + dvec3(0.6, 0.5, 0.35), [2, 2, 2]);
    let hook = dvec3(x, REST.y, z);
    for (a, b) in [(-0.4, -0.12), (0.4, 0.12), (-0.35, -0.1), (0.35, 0.1)] {
        builder.rod(BLACK, [6, 10], [dvec3(x + a, top + 0.5, z + a * 0.3), hook + dvec3(b, 0.7, b * 0.3)], 0.02);
    }
    builder.object("crane hook");
    load(builder, hook);
}

/// The block, the hook, and an engine block that hangs from it by chains.
fn load(builder: &mut MeshBuilder, hook: DVec3) {
    builder.cuboid(YELLOW, hook + dvec3(-0.25, 0.35, -0.18), hook + dvec3(0.25, 0.85, 0.18), [2, 2, 2]);
    let bend = |t: f64| {
        let angle = TURN * (0.25 - 0.8 * t);
        let reach = 0.22 - 0.02 * t;
        hook + dvec3(reach * cos(angle), 0.12 + reach * sin(angle), 0.0)
    };
    builder.tube(STEEL, [10, 24, 1], bend, |t| 0.065 - 0.04 * t * t);
    builder.rod(STEEL, [10, 2], [hook + DVec3::Y * 0.3, hook + DVec3::Y * 0.5], 0.06);
    let body = hook - DVec3::Y * 2.6;
    for (a, b) in CORNERS {
        let ends = [hook - DVec3::Y * 0.1, body + dvec3(a * 0.9, 0.88, b * 0.45)];
        builder.chain(STEEL, [6, 12, 3], ends, 0.02, [0.27, 0.03]);
    }
    let half = dvec3(1.0, 0.45, 0.5);
    builder.cuboid(GREEN, body - half, body + half, [6, 4, 4]);
    for cylinder in 0..4 {
        let at = body + dvec3(-0.72 + 0.48 * f64::from(cylinder), 0.44, 0.0);
        builder.rod(STEEL, [16, 6], [at, at + DVec3::Y * 0.5], 0.19);
        builder.frame = Frame::at(at);
        for fin in 0..3 {
            let y = 0.08 + 0.13 * f64::from(fin);
            builder.hoop(STEEL, 16, &[[0.17, y], [0.23, y], [0.23, y + 0.03], [0.17, y + 0.03]], &[1]);
        }
        builder.frame = Frame::WORLD;
    }
}
