//! What stands on the floor: stacks of crates, barrels, pallets of pipes, and a tractor that pulls a cart.

use super::*;

pub(super) fn build(builder: &mut MeshBuilder, motion: &Motion) {
    crates(builder);
    barrels(builder);
    pipes(builder);
    tractor(builder, motion);
    builder.object("platform ladder");
    builder.ladder(BLUE, [dvec3(-8.0, -SUNK, 6.0), dvec3(-7.4, 2.9, 4.6)], dvec3(0.3, 0.0, 0.12), 9);
}

/// Stacks near the left end and under the catwalk.
fn crates(builder: &mut MeshBuilder) {
    let mut random = Random(31);
    let places = [
        (-26.5, -14.0, 3),
        (-24.4, -14.3, 2),
        (-22.2, -14.1, 3),
        (-26.3, -11.7, 2),
        (-16.8, -13.6, 3),
        (-14.6, -13.9, 2),
        (-12.5, -13.5, 3),
        (-26.4, 0.4, 2),
        (-26.2, 2.8, 1),
        (8.4, -6.2, 1),
        (10.6, -5.8, 2),
        (25.8, -14.5, 3),
        (-6.4, 16.6, 2),
        (-4.0, 16.8, 1),
    ];
    for (number, &(x, z, high)) in places.iter().enumerate() {
        builder.object(format!("crates {number}"));
        let mut y = -0.01;
        for level in 0..high {
            let size = dvec3(random.between(1.5, 1.8), random.between(1.2, 1.7), random.between(1.5, 1.8));
            let turn = random.between(-0.09, 0.09);
            // Each level is smaller than the one below, so that it stands on it.
            let size = size * (1.0 - 0.07 * f64::from(level));
            builder.frame = Frame::at(dvec3(x, y, z)).yaw(turn);
            builder.plank_crate([WOOD, DARK_WOOD], size);
            y += size.y - 0.01;
        }
    }
}

fn barrels(builder: &mut MeshBuilder) {
    let mut random = Random(77);
    for (group, (x, z)) in [(-19.0, 14.5), (12.5, -14.5), (27.0, 14.5)].into_iter().enumerate() {
        builder.object(format!("barrels {group}"));
        for place in 0..6 {
            let (row, column) = (place / 3, place % 3);
            let at =
                [(x, column), (z, row)].map(|(from, at)| from + 0.95 * f64::from(at) + random.between(-0.05, 0.05));
            builder.frame = Frame::at(dvec3(at[0], -SUNK, at[1])).yaw(random.between(0.0, TURN));
            if group == 1 {
                builder.barrel([WOOD, STEEL], [0.38, 1.0], place % 2 == 0);
            } else {
                let material = if random.between(0.0, 1.0) < 0.5 { BLUE } else { RED_LEAD };
                let profile = knots(
                    [0.0, 0.36, 0.36, 0.385, 0.36, 0.36, 0.385, 0.36, 0.36, 0.33, 0.33, 0.0],
                    [0.0, 0.0, 0.33, 0.36, 0.39, 0.7, 0.73, 0.76, 1.05, 1.05, 1.02, 1.02],
                );
                builder.revolve_straight(material, [24, 1], &profile);
            }
        }
    }
}

/// Pipes stacked on bearers.
fn pipes(builder: &mut MeshBuilder) {
    for (group, (x, z, turn)) in [(2.0, -9.6, 0.08), (10.0, 15.9, -0.05)].into_iter().enumerate() {
        let here = Frame::at(dvec3(x, 0.0, z)).yaw(turn);
        builder.object_at(format!("pipes {group}"), here);
        for bearer in [-2.0, 0.0, 2.0] {
            let ends = [dvec3(bearer, 0.08, -0.9), dvec3(bearer, 0.08, 0.9)];
            builder.beam(DARK_WOOD, [2, 4], ends, [0.1, 0.08], DVec3::Y);
        }
        for row in 0..3_u32 {
            for pipe in 0..6 - row {
                let z = 0.285 * (f64::from(pipe) - f64::from(5 - row) / 2.0);
                let y = 0.3 + 0.245 * f64::from(row);
                builder.frame = here.shift(dvec3(3.0, y, z)).roll(TURN / 4.0);
                // Hollow: along the outside, back along the inside.
                builder.hoop(STEEL, 10, &[[0.11, 0.0], [0.14, 0.0], [0.14, 6.0], [0.11, 6.0]], &[0, 4]);
            }
        }
    }
}

/// A tractor and a loaded cart behind it, rolling along their own x axis.
fn tractor(builder: &mut MeshBuilder, motion: &Motion) {
    let here = Frame::at(dvec3(-17.5, 0.0, 8.8)).yaw(-0.06).shift(DVec3::X * motion.rolled);
    let place = |builder: &mut MeshBuilder, middle: DVec3, radius: f64| {
        for face in [-1.0, 1.0] {
            let middle = dvec3(middle.x, middle.y, face * middle.z);
            builder.frame = here.shift(middle).roll(-motion.rolled / radius).pitch(TURN / 4.0);
            let thick = radius * 0.3;
            builder.torus(RUBBER, [12, 28, 3], DVec3::ZERO, [radius - thick, thick]);
            let hub = [[0.0, -0.08], [radius * 0.62, -0.06], [radius * 0.62, 0.06], [0.0, 0.08]];
            builder.revolve_straight(WHITE, [12, 2], &hub);
            for out in spokes(5) {
                let at = out * (radius * 0.3);
                builder.rod(STEEL, [6, 1], [at - DVec3::Y * 0.11, at + DVec3::Y * 0.11], 0.03);
            }
        }
        builder.frame = here;
    };
    builder.object("tractor");
    place(builder, dvec3(-0.7, 0.5 - SUNK, 0.75), 0.5);
    place(builder, dvec3(1.1, 0.36 - SUNK, 0.68), 0.36);
    for (x, y) in [(-0.7, 0.48), (1.1, 0.34)] {
        builder.rod(STEEL, [8, 2], [dvec3(x, y, -0.75), dvec3(x, y, 0.75)], 0.05);
    }
    let shape = [32, 10, 3];
    builder.slab(YELLOW, shape, dvec3(0.9, 0.78, 0.0), dvec3(0.85, 0.3, 0.45), 5.0);
    builder.slab(YELLOW, shape, dvec3(-0.65, 0.62, 0.0), dvec3(0.85, 0.22, 0.5), 6.0);
    builder.slab(BLACK, shape, dvec3(-0.75, 0.93, 0.0), dvec3(0.25, 0.08, 0.3), 5.0);
    let back = |t: f64| dvec3(-1.0 - 0.1 * t, 0.93 + 0.6 * t, 0.0);
    builder.ribbon(BLACK, shape, Some(DVec3::Z), back, |_| dvec2(0.28, 0.06));
    builder.rod(STEEL, [8, 2], [dvec3(0.1, 0.95, 0.0), dvec3(-0.15, 1.3, 0.0)], 0.025);
    let middle = dvec3(-0.16, 1.31, 0.0);
    let rim = |t: f64| {
        let (s, c) = (sin(TURN * t), cos(TURN * t));
        middle + dvec3(0.1 * c, 0.06 * c, 0.2 * s)
    };
    builder.loop_tube(BLACK, [8, 28, 3], rim, 0.018);
    builder.rod(BLACK, [8, 4], [dvec3(1.2, 1.0, 0.2), dvec3(1.2, 1.6, 0.2)], 0.04);

    builder.object("cart");
    place(builder, dvec3(-4.6, 0.3 - SUNK, 0.72), 0.3);
    place(builder, dvec3(-2.9, 0.3 - SUNK, 0.72), 0.3);
    builder.cuboid(GREEN, dvec3(-5.2, 0.5, -0.7), dvec3(-2.3, 0.62, 0.7), [8, 2, 4]);
    for x in [-4.6, -2.9] {
        builder.rod(STEEL, [8, 2], [dvec3(x, 0.3, -0.72), dvec3(x, 0.3, 0.72)], 0.04);
        builder.rod(STEEL, [8, 2], [dvec3(x, 0.28, 0.0), dvec3(x, 0.55, 0.0)], 0.09);
    }
    builder.rod(STEEL, [8, 4], [dvec3(-2.4, 0.55, 0.0), dvec3(-1.3, 0.5, 0.0)], 0.04);
    builder.frame = here.shift(dvec3(-4.4, 0.61, 0.0));
    builder.plank_crate([WOOD, DARK_WOOD], dvec3(1.2, 0.9, 1.1));
    builder.frame = here.shift(dvec3(-3.1, 0.61, 0.02)).yaw(0.2);
    builder.plank_crate([WOOD, DARK_WOOD], dvec3(0.9, 0.7, 0.95));
}
