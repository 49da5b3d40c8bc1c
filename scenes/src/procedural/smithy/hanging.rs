//! What hangs: tools on racks along the walls, shields, chains with hooks, lanterns, strings of horseshoes.

use super::*;

pub(super) fn build(builder: &mut MeshBuilder) {
    let [x, z] = HALF;
    // Where the middle of a rack is, which way it faces, its height, its length.
    let racks = [
        (dvec3(-1.4, 2.1, z), TURN / 2.0, 3.0),
        (dvec3(1.9, 2.05, z), TURN / 2.0, 2.4),
        (dvec3(-1.3, 2.15, -z), 0.0, 2.0),
        (dvec3(-x, 2.12, 1.2), TURN / 4.0, 3.0),
        (dvec3(x, 2.18, 2.2), -TURN / 4.0, 2.6),
        (dvec3(-x, 2.2, -1.6), TURN / 4.0, 1.6),
    ];
    for (number, (at, turn, long)) in racks.into_iter().enumerate() {
        builder.object_at(format!("rack {number}"), Frame::at(at).yaw(turn));
        rack(builder, long, number as u64);
    }
    let shields = [
        (dvec3(x - 0.07, 2.55, 1.1), -TURN / 4.0, 0.36),
        (dvec3(x - 0.07, 1.6, 3.3), -TURN / 4.0, 0.3),
        (dvec3(0.3, 2.75, z - 0.07), TURN / 2.0, 0.34),
        (dvec3(-x + 0.07, 2.75, 0.1), TURN / 4.0, 0.32),
    ];
    for (number, (at, turn, radius)) in shields.into_iter().enumerate() {
        builder.object_at(format!("shield {number}"), Frame::at(at).yaw(turn));
        tools::shield(builder, radius);
    }
    chains(builder);
    let lanterns = [(-2.2, -0.2), (0.0, 1.9), (2.2, -1.2), (4.4, 2.2), (-4.4, 2.6), (2.2, 2.6)];
    for (number, (x, z)) in lanterns.into_iter().enumerate() {
        builder.object(format!("lantern {number}"));
        let low = dvec3(x, 2.62 - 0.04 * number as f64, z);
        builder.rod(ROPE, [8, 8], [low, low.with_y(3.34)], 0.007);
        builder.frame = Frame::at(low);
        tools::lantern(builder);
    }
    strings(builder);
}

/// A board on the wall with pegs, a tool on each; the frame's plane z = 0 is the wall.
fn rack(builder: &mut MeshBuilder, long: f64, seed: u64) {
    let mut random = Random(800 + seed);
    let here = builder.frame;
    let ends = [dvec3(-long / 2.0, 0.0, 0.028), dvec3(long / 2.0, 0.0, 0.028)];
    builder.beam(DARK_WOOD, [2, 8], ends, [0.05, 0.018], DVec3::Y);
    let pegs = libm::round(long / 0.17) as usize;
    for peg in 0..pegs {
        let x = long * ((peg as f64 + 0.5) / pegs as f64 - 0.5);
        builder.frame = here;
        builder.rod(WOOD, [8, 4], [dvec3(x, 0.0, 0.03), dvec3(x, 0.02, 0.15)], 0.009);
        builder.frame = here.shift(dvec3(x, 0.03, random.between(0.085, 0.12))).yaw(random.between(-0.3, 0.3));
        match (peg as u64 + seed) % 5 {
            0 | 3 => tools::tongs(builder, random.between(0.45, 0.6)),
            1 => tools::hammer(builder, random.between(0.3, 0.42)),
            2 => tools::horseshoe(builder),
            _ => tools::sword(builder, random.between(0.6, 0.8)),
        }
    }
}

/// Chains from the beams: straight ones with hooks, and some that sag from beam to beam.
fn chains(builder: &mut MeshBuilder) {
    let mut random = Random(31);
    let divisions = [6, 10, 3];
    for number in 0..14_u32 {
        builder.object(format!("chain {number}"));
        let x = -4.4 + 2.2 * f64::from(number % 5) + random.between(-0.04, 0.04);
        let top = dvec3(x, 3.33, -2.8 + 0.42 * f64::from(number) + random.between(-0.05, 0.05));
        let low = top.with_y(random.between(1.95, 2.6));
        builder.chain(IRON, divisions, [top, low], 0.0, [0.095, 0.009]);
        let bend = |t: f64| {
            let angle = TURN * mix(0.25, -0.5, t);
            low + dvec3(0.05 * cos(angle), -0.05 + 0.05 * sin(angle), 0.0)
        };
        builder.tube(IRON, [8, 18, 5], bend, |t| 0.011 - 0.006 * t * t);
    }
    for (number, z) in [-1.9, 0.6, 2.9].into_iter().enumerate() {
        for bay in 0..3 {
            builder.object(format!("sagging chain {number}.{bay}"));
            let x = -4.4 + 2.2 * f64::from(bay + (number as u32 % 2));
            let ends = [dvec3(x, 3.34, z), dvec3(x + 2.2, 3.34, z + 0.15)];
            builder.chain(STEEL, divisions, ends, 0.5 + 0.1 * f64::from(bay), [0.12, 0.012]);
        }
    }
}

/// Ropes from the beams with horseshoes and buckets on them.
fn strings(builder: &mut MeshBuilder) {
    let places = [(-2.2, 1.1), (0.0, -2.1), (0.0, 3.1), (2.2, 1.6), (4.4, -2.2), (-4.4, -0.4)];
    for (number, (x, z)) in places.into_iter().enumerate() {
        builder.object(format!("string {number}"));
        let top = dvec3(x, 3.34, z);
        let path = |t: f64| top + dvec3(0.01 * sin(9.0 * t), -1.15 * t, 0.01 * cos(9.0 * t));
        builder.tube(ROPE, [8, 20, 4], path, |_| 0.006);
        for shoe in 0..6 {
            builder.frame = Frame::at(path(0.2 + 0.15 * f64::from(shoe))).yaw(0.9 * f64::from(shoe));
            tools::horseshoe(builder);
        }
        builder.frame = Frame::at(path(1.0) - DVec3::Y * 0.36).yaw(number as f64);
        tools::bucket(builder, 0.85);
    }
}
