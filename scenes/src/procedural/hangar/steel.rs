//! The steelwork: lattice columns, oblique trusses, bracing in the roof, purlins, lamps and sagging cables.

use super::*;

/// Distance between two trusses.
const BAY: f64 = 6.0;
/// Height of a truss's lower chord.
const CHORD: f64 = 12.3;

pub(super) fn build(builder: &mut MeshBuilder) {
    for number in 0..10 {
        let x = -27.0 + BAY * f64::from(number);
        builder.object(format!("truss {number}"));
        truss(builder, x);
        for face in [-1.0, 1.0] {
            column(builder, x, face * (HALF[1] - 1.0));
        }
    }
    builder.part("bracing", Frame::WORLD, bracing);
    builder.part("cables", Frame::WORLD, cables);
    let lamps = [(-18.0, -7.0), (-18.0, 7.0), (0.0, -7.0), (0.0, 7.0), (18.0, -7.0), (18.0, 7.0)];
    for (number, (x, z)) in lamps.into_iter().enumerate() {
        builder.object(format!("lamp {number}"));
        lamp(builder, dvec3(x + 3.0, CHORD, z));
    }
}

/// The upper chord's height over z.
fn slope(z: f64) -> f64 {
    mix(RIDGE - 0.6, EAVES - 0.1, z.abs() / HALF[1])
}

fn truss(builder: &mut MeshBuilder, x: f64) {
    let (thin, long) = ([6, 4], [8, 16]);
    let end = HALF[1] - 0.3;
    let low = |z: f64| dvec3(x, CHORD, z);
    let high = |z: f64| dvec3(x, slope(z), z);
    builder.rod(RED_LEAD, long, [low(-end), low(end)], 0.11);
    for face in [-1.0, 1.0] {
        builder.rod(RED_LEAD, long, [high(face * (end + 0.2)), high(face * -0.05)], 0.1);
        for panel in 0..6 {
            let [z0, z1] = [panel, panel + 1].map(|at| face * end * (1.0 - f64::from(at) / 6.0));
            if panel > 0 {
                builder.rod(RED_LEAD, thin, [low(z0), high(z0)], 0.055);
            }
            builder.rod(RED_LEAD, thin, [low(z0), high(z1)], 0.05);
        }
    }
    builder.rod(RED_LEAD, thin, [low(0.0), high(0.0)], 0.06);
}

/// Two posts and oblique rods between them, on a foot.
fn column(builder: &mut MeshBuilder, x: f64, z: f64) {
    let post = |at: f64| [dvec3(x, -SUNK, z + at), dvec3(x, CHORD + 0.05, z + at)];
    for at in [-0.4, 0.4] {
        builder.beam(RED_LEAD, [2, 6], post(at), [0.13, 0.09], DVec3::X);
    }
    builder.zigzag(RED_LEAD, [6, 4], [post(-0.4), post(0.4)], 3, 0.045);
    let foot = dvec3(x, -SUNK, z);
    builder.beam(CONCRETE, [2, 2], [foot - DVec3::Y * 0.02, foot + DVec3::Y * 0.4], [0.4, 0.7], DVec3::X);
}

/// Purlins along the roof, crosses between trusses, ties in the plane of the lower chords.
fn bracing(builder: &mut MeshBuilder) {
    let divisions = [6, 8];
    for z in [-16.3, -9.8, -3.3, 3.3, 9.8, 16.3] {
        let y = slope(z) + 0.16;
        builder.beam(STEEL, [2, 24], [dvec3(-HALF[0] - 0.1, y, z), dvec3(HALF[0] + 0.1, y, z)], [0.1, 0.06], DVec3::Y);
    }
    for bay in [0, 4, 8] {
        let [x0, x1] = [bay, bay + 1].map(|at| -27.0 + BAY * f64::from(at));
        for (z0, z1) in [(-19.0, -10.0), (-10.0, -0.5), (0.5, 10.0), (10.0, 19.0)] {
            for (a, b, drop) in [(z0, z1, 0.0), (z1, z0, 0.05)] {
                builder.rod(STEEL, divisions, [dvec3(x0, slope(a) - drop, a), dvec3(x1, slope(b) - drop, b)], 0.035);
            }
        }
        for face in [-1.0, 1.0] {
            let z = face * (HALF[1] - 1.0);
            for (a, b, aside) in [(0.6, 11.5, 0.02), (11.5, 0.6, -0.05)] {
                builder.rod(STEEL, divisions, [dvec3(x0, a, z + aside), dvec3(x1, b, z + aside)], 0.045);
            }
        }
    }
}

/// Power cables that sag from truss to truss.
fn cables(builder: &mut MeshBuilder) {
    for (number, z) in [-14.2, -6.6, 1.2, 7.4, 13.1].into_iter().enumerate() {
        for span in 0..9 {
            let x = -27.0 + BAY * f64::from(span);
            let sag = 0.5 + 0.35 * sin(2.0 * f64::from(span) + number as f64);
            let path = |t: f64| dvec3(x + BAY * t, CHORD - 0.09 - 4.0 * sag * t * (1.0 - t), z + 0.3 * sin(3.0 * t));
            builder.tube(BLACK, [6, 12, 1], path, |_| 0.03);
        }
    }
}

/// A pendant lamp hanging from `from`.
fn lamp(builder: &mut MeshBuilder, from: DVec3) {
    let drop = 2.6;
    builder.rod(BLACK, [6, 6], [from, from - DVec3::Y * drop], 0.02);
    builder.frame = Frame::at(from - DVec3::Y * (drop + 0.5));
    let shade = knots([0.0, 0.16, 0.5, 0.62, 0.63, 0.52, 0.18, 0.0], [0.44, 0.42, 0.05, -0.02, 0.0, 0.1, 0.5, 0.53]);
    builder.revolve_smooth(GREEN, [24, 12, 7], &shade);
    builder.ball(LAMP, DVec3::Y * 0.2, 0.17, 16);
    builder.frame = Frame::WORLD;
    // What the lamp hangs from, between two trusses.
    let half = DVec3::X * BAY / 2.0;
    builder.rod(STEEL, [6, 6], [from - half, from + half], 0.04);
}
