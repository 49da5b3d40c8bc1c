//! The ground, the pool in it, stones, and grass.

use glam::{DVec3, dvec3};

use super::{Glade, HALF, POOL};
use crate::procedural::builder::{Ends, MaterialId};
use crate::procedural::math::{Frame, Random, TURN, cos, sin, smoothstep};
use crate::procedural::shapes::steps;

/// Grass blades at scale 1.
const BLADES: usize = 30_000;

/// Height of the ground.
pub(super) fn height(x: f64, z: f64) -> f64 {
    let hills = 0.22 * sin(0.45 * x + 0.8) * cos(0.38 * z) + 0.07 * sin(1.3 * x - 0.9 * z);
    let away = distance_to_pool(x, z) / POOL.1;
    let basin = 1.0 - smoothstep(0.75, 1.6, away);
    hills * (1.0 - basin) - 0.4 * basin
}

/// Horizontal distance to the pool's middle, in metres.
pub(super) fn distance_to_pool(x: f64, z: f64) -> f64 {
    let (dx, dz) = (x - POOL.0.x, z - POOL.0.z);
    libm::sqrt(dx * dx + dz * dz)
}

pub(super) fn build(glade: &mut Glade) {
    let Glade { builder, palette, .. } = glade;
    builder.object("ground");
    let line = steps(-HALF, HALF, builder.divide(64, 8));
    builder.sheet(palette.earth, &line, &line, |z, x| dvec3(x, height(x, z), z), |_, _| false);
    builder.object("pool");
    let around = builder.around(40);
    let (middle, radius) = (POOL.0, POOL.1 * 1.3);
    let ends = Ends::Closed(middle - DVec3::Y * 0.05, middle);
    builder.rings(palette.water, 2, around, &ends, |ring, at| {
        let angle = TURN * at as f64 / around as f64;
        let y = if ring == 0 { -0.05 } else { -0.002 };
        middle + dvec3(radius * cos(angle), y, -radius * sin(angle))
    });
    builder.object("stones");
    let mut random = Random(11);
    for stone in 0..14 {
        let angle = TURN * (f64::from(stone) + random.between(-0.3, 0.3)) / 14.0;
        let away = POOL.1 * random.between(1.15, 1.45);
        let at = dvec3(POOL.0.x + away * cos(angle), 0.0, POOL.0.z + away * sin(angle));
        let size = random.between(0.12, 0.3);
        let rest = Frame::at(at.with_y(height(at.x, at.z) + 0.2 * size)).yaw(random.between(0.0, TURN));
        builder.frame = rest;
        let [around, rows] = builder.bent(14, [8, 2]);
        let phase = random.between(0.0, TURN);
        let point = |up: f64, turn: f64| {
            let bump = 1.0 + 0.12 * sin(3.0 * turn + phase) * sin(up) + 0.08 * sin(5.0 * up + 2.0 * turn);
            dvec3(1.3 * cos(turn) * sin(up), -0.6 * cos(up), -sin(turn) * sin(up)) * (size * bump)
        };
        let half = TURN / 2.0;
        let poles = Ends::Closed(point(0.0, 0.0), point(half, 0.0));
        builder.rings(palette.stone, rows - 1, around, &poles, |ring, at| {
            point(half * (ring + 1) as f64 / rows as f64, TURN * at as f64 / around as f64)
        });
    }
}

/// Bent blades of three triangles, everywhere but in the pool, denser and taller around it.
pub(super) fn grass(glade: &mut Glade) {
    glade.builder.object("grass");
    for number in 0..glade.density.count(BLADES) {
        let mut random = Random(0x6772_6173 + number as u64 * 0x9e37);
        // Squared, so that more stand near the middle.
        let (angle, share) = (random.between(0.0, TURN), random.between(0.0, 1.0));
        let away = 2.2 + 9.4 * share * libm::sqrt(share);
        let (x, z) = (POOL.0.x + away * cos(angle), POOL.0.z + away * sin(angle));
        let (tall, heading) = (random.between(0.2, 0.6), random.between(0.0, TURN));
        let (wide, bow) = (random.between(0.009, 0.018) * glade.density.size(), random.between(0.1, 0.5));
        let material = glade.palette.grass[usize::from(random.between(0.0, 1.0) < 0.4)];
        if x.abs() > HALF || z.abs() > HALF {
            // Kept, so that the number of triangles does not depend on chance: moved to the other side of the pool.
            let other = [POOL.0.x * 2.0 - x, POOL.0.z * 2.0 - z];
            blade(glade, glade.palette.grass[0], other, [tall, wide, bow], heading);
        } else {
            blade(glade, material, [x, z], [tall, wide, bow], heading);
        }
    }
}

fn blade(glade: &mut Glade, material: MaterialId, [x, z]: [f64; 2], [tall, wide, bow]: [f64; 3], heading: f64) {
    let (x, z) = (x.clamp(-HALF, HALF), z.clamp(-HALF, HALF));
    let root = dvec3(x, height(x, z) - 0.03, z);
    let out = dvec3(cos(heading), 0.0, sin(heading));
    let side = dvec3(-out.z, 0.0, out.x) * wide;
    let at = |up: f64| {
        let point = root + out * (bow * tall * up * up) + DVec3::Y * (tall * up);
        glade.wind.bend(point, up, 0.22 * tall, 0.6 * x + 0.4 * z)
    };
    let (low, middle, tip) = (at(0.0), at(0.55), at(1.0));
    let points = [low - side, low + side, middle - side * 0.8, middle + side * 0.8, tip];
    glade.builder.patch(material, &points, &[[0, 1, 3], [0, 3, 2], [2, 3, 4]]);
}
