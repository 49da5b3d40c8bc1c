//! Machinery along the walls: tanks on legs with pipes, workbenches, a lathe, shelves of parts, a compressor.

use super::*;

pub(super) fn build(builder: &mut MeshBuilder) {
    for (number, x) in [-13.0, -9.8, 14.5].into_iter().enumerate() {
        let at = dvec3(x, 0.0, HALF[1] - 3.0 + 0.1 * number as f64);
        builder.part(format!("tank {number}"), Frame::at(at), tank);
    }
    let benches = [(1.0, 16.2, 0.03), (5.5, 16.4, -0.02), (-28.4, -6.0, TURN / 4.0)];
    for (number, (x, z, turn)) in benches.into_iter().enumerate() {
        builder.object_at(format!("workbench {number}"), Frame::at(dvec3(x, 0.0, z)).yaw(turn));
        workbench(builder, number as u64);
    }
    for (number, x) in [-4.0, 0.5, 5.0].into_iter().enumerate() {
        builder.object_at(format!("shelf {number}"), Frame::at(dvec3(x, 0.0, -HALF[1] + 1.3)));
        shelf(builder, number as u64);
    }
    builder.part("pipework", Frame::WORLD, pipework);
}

/// A standing vessel with domed ends on four legs, with bands and a manhole.
fn tank(builder: &mut MeshBuilder) {
    let profile = knots([0.0, 0.6, 1.05, 1.1, 1.1, 1.05, 0.6, 0.0], [0.8, 0.85, 1.15, 1.6, 3.9, 4.35, 4.7, 4.75]);
    builder.revolve_smooth(WHITE, [32, 18, 8], &profile);
    for y in [1.6, 2.75, 3.9] {
        builder.torus(STEEL, [6, 32, 3], DVec3::Y * y, [1.11, 0.05]);
    }
    for (x, z) in CORNERS {
        builder.rod(STEEL, [10, 6], [dvec3(x * 0.72, -SUNK, z * 0.72), dvec3(x * 0.66, 1.5, z * 0.66)], 0.09);
    }
    builder.rod(STEEL, [20, 4], [DVec3::Y * 4.6, DVec3::Y * 5.1], 0.3);
    builder.rod(STEEL, [20, 4], [dvec3(0.0, 2.0, 0.9), dvec3(0.0, 2.0, -1.3)], 0.28);
}

/// A bench with drawers, a vice and a lathe-like machine on it.
fn workbench(builder: &mut MeshBuilder, seed: u64) {
    let mut random = Random(400 + seed);
    let top = dvec3(1.8, 0.05, 0.5);
    let middle = DVec3::Y * 0.92;
    builder.cuboid(WOOD, middle - top, middle + top, [8, 2, 4]);
    for x in [-1.7, 0.0, 1.7] {
        for z in [-0.4, 0.4] {
            builder.beam(GREEN, [2, 4], [dvec3(x, -SUNK, z), dvec3(x, 0.9, z)], [0.05, 0.05], DVec3::X);
        }
    }
    builder.cuboid(GREEN, dvec3(-1.74, 0.2, -0.41), dvec3(1.73, 0.24, 0.42), [8, 2, 4]);
    for drawer in 0..3 {
        let x = -1.3 + 0.6 * f64::from(drawer);
        let min = dvec3(x, 0.64, -0.3);
        builder.cuboid(GREEN, min, min + dvec3(0.5, 0.255, 0.73), [2, 2, 2]);
        let knob = dvec3(x + 0.25, 0.75, 0.41);
        builder.rod(STEEL, [8, 2], [knob, knob + DVec3::Z * 0.08], 0.03);
    }
    // Headstock, bed and chuck.
    builder.cuboid(GREEN, dvec3(-1.25, 0.93, -0.27), dvec3(-0.55, 1.52, 0.27), [2, 2, 2]);
    builder.slab(GREEN, [24, 8, 3], dvec3(0.1, 1.031, 0.0), dvec3(1.0, 0.083, 0.2), 6.0);
    builder.cuboid(GREEN, dvec3(0.65, 0.96, -0.16), dvec3(1.05, 1.4, 0.16), [2, 2, 2]);
    builder.rod(POLISHED, [24, 4], [dvec3(-0.6, 1.28, 0.0), dvec3(-0.4, 1.28, 0.0)], 0.17);
    builder.rod(POLISHED, [14, 10], [dvec3(-0.45, 1.28, 0.0), dvec3(0.8, 1.28, 0.0)], 0.05);
    for tool in 0..6 {
        let at = dvec3(1.15 + 0.06 * f64::from(tool), 0.985, random.between(-0.3, -0.05));
        let ends = [at, at + dvec3(random.between(-0.02, 0.02), 0.0, random.between(0.25, 0.45))];
        builder.rod(STEEL, [8, 4], ends, random.between(0.012, 0.02));
    }
}

/// A rack of boards with boxes, cans and rings.
fn shelf(builder: &mut MeshBuilder, seed: u64) {
    let mut random = Random(500 + seed);
    let here = builder.frame;
    for x in [-1.95, 1.95] {
        for z in [-0.4, 0.4] {
            builder.beam(BLUE, [2, 8], [dvec3(x, -SUNK, z), dvec3(x, 4.5, z)], [0.04, 0.04], DVec3::X);
        }
    }
    for level in 0..5 {
        let y = 0.3 + f64::from(level);
        builder.frame = here;
        builder.cuboid(STEEL, dvec3(-1.97, y - 0.06, -0.38), dvec3(1.97, y, 0.38), [4, 2, 2]);
        let mut x = -1.75;
        while x < 1.15 {
            let kind = random.between(0.0, 3.0);
            let size = random.between(0.2, 0.34);
            let z = random.between(-0.08, 0.08);
            builder.frame = here.shift(dvec3(x + size, y - 0.01, z)).yaw(random.between(-0.15, 0.15));
            if kind < 1.4 {
                let half = dvec3(size * 0.85, 0.0, size * 0.8);
                let high = DVec3::Y * random.between(0.2, 0.6);
                let material = if kind < 0.7 { WOOD } else { RED_LEAD };
                builder.cuboid(material, -half, half + high, [2, 2, 2]);
            } else if kind < 2.3 {
                let high = random.between(0.25, 0.55);
                let can =
                    [[0.0, 0.0], [size * 0.8, 0.0], [size * 0.82, high * 0.5], [size * 0.8, high], [0.0, high * 1.02]];
                builder.revolve_smooth(WHITE, [14, 6, 4], &can);
            } else {
                for ring in 0..3 {
                    let up = DVec3::Y * (0.05 + 0.095 * f64::from(ring));
                    builder.torus(RUBBER, [6, 14, 3], up, [size * 0.7, 0.055]);
                }
            }
            x += 2.0 * size + random.between(0.02, 0.12);
        }
    }
}

/// Pipes along the front wall that rise and bend, with flanges.
fn pipework(builder: &mut MeshBuilder) {
    for (number, radius) in [0.16, 0.11, 0.2].into_iter().enumerate() {
        let shift = number as f64;
        let z = HALF[1] - 0.55 - 0.33 * shift;
        let knots = [
            dvec3(-25.0, 3.0 + 0.6 * shift, z),
            dvec3(-14.0, 3.05 + 0.6 * shift, z),
            dvec3(-7.0, 4.4 + 0.7 * shift, z + 0.1),
            dvec3(1.0, 5.5 + 0.7 * shift, z),
            dvec3(12.0, 5.5 + 0.7 * shift, z),
            dvec3(24.0, 6.3 + 0.7 * shift, z),
        ];
        let path = |t: f64| curve(&knots, t);
        builder.tube(STEEL, [12, 70, 10], path, |_| radius);
        for flange in 0..8 {
            let t = (f64::from(flange) + 0.5) / 8.0;
            builder.rod(RED_LEAD, [16, 2], [path(t), path(t + 0.003)], radius * 1.45);
        }
    }
}
