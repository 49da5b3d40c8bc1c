//! The ground, the pool in it, stones, and grass.

use super::*;

/// Height of the ground.
pub(super) fn height(x: f64, z: f64) -> f64 {
    let hills = 0.22 * sin(0.45 * x + 0.8) * cos(0.38 * z) + 0.07 * sin(1.3 * x - 0.9 * z);
    let (dx, dz) = (x - POOL.0.x, z - POOL.0.z);
    let away = sqrt(dx * dx + dz * dz) / POOL.1;
    let basin = 1.0 - smoothstep(0.75, 1.6, away);
    hills * (1.0 - basin) - 0.4 * basin
}

pub(super) fn build(builder: &mut MeshBuilder) {
    builder.object("ground");
    let line = steps(-HALF, HALF, builder.divide(64, 8));
    builder.sheet(EARTH, &line, &line, |z, x| dvec3(x, height(x, z), z));
    builder.object("pool");
    let around = builder.around(40);
    let (middle, radius) = (POOL.0, POOL.1 * 1.3);
    let ends = Ends::Closed(middle - DVec3::Y * 0.05, middle);
    builder.turned(WATER, [2, around], ends, |ring, angle| {
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
        builder.frame = Frame::at(at.with_y(height(at.x, at.z) + 0.2 * size)).yaw(random.between(0.0, TURN));
        let (around, rows) = (builder.around(14), builder.divide(8, 2));
        let phase = random.between(0.0, TURN);
        let point = |up: f64, turn: f64| {
            let bump = 1.0 + 0.12 * sin(3.0 * turn + phase) * sin(up) + 0.08 * sin(5.0 * up + 2.0 * turn);
            dvec3(1.3 * cos(turn) * sin(up), -0.6 * cos(up), -sin(turn) * sin(up)) * (size * bump)
        };
        let half = TURN / 2.0;
        let poles = Ends::Closed(point(0.0, 0.0), point(half, 0.0));
        builder
            .turned(STONE, [rows - 1, around], poles, |ring, turn| point(half * (ring + 1) as f64 / rows as f64, turn));
    }
}

/// Bent blades of three triangles, everywhere but in the pool, denser and taller around it.
pub(super) fn grass(builder: &mut MeshBuilder, setting: Setting) {
    builder.object("grass");
    for number in 0..setting.count(30_000) {
        let mut random = Random(0x6772_6173 + number as u64 * 0x9e37);
        // Squared, so that more stand near the middle.
        let (angle, share) = (random.between(0.0, TURN), random.between(0.0, 1.0));
        let away = 2.2 + 9.4 * share * sqrt(share);
        let (x, z) = (POOL.0.x + away * cos(angle), POOL.0.z + away * sin(angle));
        let (tall, heading) = (random.between(0.2, 0.6), random.between(0.0, TURN));
        let (wide, bow) = (random.between(0.009, 0.018) * setting.size(), random.between(0.1, 0.5));
        let material = if random.between(0.0, 1.0) < 0.4 { DRY_GRASS } else { GRASS };
        // Kept, so that the number of triangles does not depend on chance: moved to the other side of the pool.
        let (material, x, z) = if x.abs() > HALF || z.abs() > HALF {
            (GRASS, POOL.0.x * 2.0 - x, POOL.0.z * 2.0 - z)
        } else {
            (material, x, z)
        };
        let (x, z) = (x.clamp(-HALF, HALF), z.clamp(-HALF, HALF));
        let root = dvec3(x, height(x, z) - 0.03, z);
        let out = dvec3(cos(heading), 0.0, sin(heading));
        let side = dvec3(-out.z, 0.0, out.x) * wide;
        let [low, middle, tip] = [0.0, 0.55, 1.0].map(|up| {
            let point = root + out * (bow * tall * up * up) + DVec3::Y * (tall * up);
            setting.bend(point, up, 0.22 * tall, 0.6 * x + 0.4 * z)
        });
        let points = [low - side, low + side, middle - side * 0.8, middle + side * 0.8, tip];
        builder.patch(material, &points, &[[0, 1, 3], [0, 3, 2], [2, 3, 4]]);
    }
}
