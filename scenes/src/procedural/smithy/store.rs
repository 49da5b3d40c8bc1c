//! What stands on the floor and lies on benches and shelves: barrels, crates, wheels, vessels within vessels.

use super::*;

pub(super) fn build(builder: &mut MeshBuilder) {
    barrels(builder);
    crates(builder);
    wheels(builder);
    let back = -HALF[1] + 0.42;
    let shelves = [(3.2, back, 0.0), (0.9, back, 0.0), (HALF[0] - 0.42, -0.6, -TURN / 4.0)];
    for (number, (x, z, turn)) in shelves.into_iter().enumerate() {
        builder.object_at(format!("shelf {number}"), Frame::at(dvec3(x, 0.0, z)).yaw(turn));
        shelf(builder, number as u64);
    }
    for (number, (x, z, long)) in [(-1.4, HALF[1] - 0.55, 2.8), (1.9, HALF[1] - 0.52, 2.2)].into_iter().enumerate() {
        builder.object_at(format!("bench {number}"), Frame::at(dvec3(x, 0.0, z)));
        bench(builder, long, number as u64);
    }
    builder.object_at("table", Frame::at(dvec3(0.5, 0.0, -0.75)).yaw(-0.25));
    bench(builder, 1.5, 7);
    builder.object("ladder");
    builder.ladder(WOOD, [dvec3(-2.6, -SUNK, 2.2), dvec3(-3.1, 3.4, 3.3)], dvec3(0.25, 0.0, 0.11), 11);
}

/// Closed ones with sacks on them, open ones full of rods, swords and handles.
fn barrels(builder: &mut MeshBuilder) {
    let mut random = Random(21);
    let places = [
        (-4.4, -0.7, true),
        (-4.35, 0.2, true),
        (-4.45, 1.1, false),
        (-3.6, 0.6, true),
        (-2.0, -3.5, true),
        (-1.35, -3.45, false),
        (4.5, 1.1, false),
        (4.4, 3.4, true),
        (2.6, 0.9, true),
        (2.3, -1.7, true),
        (-0.3, 2.4, true),
    ];
    for (number, (x, z, open)) in places.into_iter().enumerate() {
        let here = Frame::at(dvec3(x, -SUNK, z)).yaw(random.between(0.0, TURN));
        builder.object_at(format!("barrel {number}"), here);
        let size = [random.between(0.27, 0.32), random.between(0.75, 0.92)];
        builder.barrel([WOOD, IRON], size, open);
        if open {
            for stick in 0..9 {
                let angle = TURN * (f64::from(stick) + random.between(-0.3, 0.3)) / 9.0;
                let out = dvec3(cos(angle), 0.0, sin(angle));
                let away = size[0] * random.between(0.2, 0.55);
                let foot = out * (away * 0.7) + DVec3::Y * 0.06;
                let high = size[1] + random.between(0.2, 0.65);
                let top = out * (away * 1.25) + DVec3::Y * high;
                if stick % 3 == 0 {
                    let upright = here.span(top, foot, DVec3::X).pitch(TURN / 2.0);
                    builder.within(upright, |here| tools::sword(here, high * 0.92));
                } else {
                    let material = if stick % 2 == 0 { IRON } else { WOOD };
                    builder.rod(material, [8, 6], [foot, top], random.between(0.008, 0.016));
                }
            }
        } else {
            builder.frame = here.shift(DVec3::Y * (0.955 * size[1]));
            tools::coil(builder, 0.2);
        }
    }
}

/// Crates, and open boxes with boxes, pots and balls in them.
fn crates(builder: &mut MeshBuilder) {
    let mut random = Random(22);
    let places = [
        (4.35, 2.3, 2),
        (3.5, 3.3, 0),
        (-4.3, 3.3, 2),
        (-3.4, 3.45, 1),
        (-4.35, 2.2, 1),
        (3.4, -0.9, 1),
        (3.3, 0.3, 1),
        (1.2, 2.1, 1),
    ];
    for (number, (x, z, high)) in places.into_iter().enumerate() {
        builder.object(format!("crates {number}"));
        let mut y = -SUNK;
        for level in 0..high {
            let size = dvec3(0.72, 0.56, 0.68) * (1.0 - 0.08 * f64::from(level)) * random.between(0.9, 1.05);
            builder.frame = Frame::at(dvec3(x, y, z)).yaw(random.between(-0.2, 0.2));
            builder.plank_crate([BOARD, DARK_WOOD], size);
            y += size.y - 0.005;
        }
        let here = Frame::at(dvec3(x, y, z)).yaw(random.between(-0.3, 0.3));
        builder.frame = here;
        tools::open_box(builder, WOOD, dvec3(0.52, 0.3, 0.46));
        builder.frame = here.shift(dvec3(-0.08, 0.011, 0.0)).yaw(0.1);
        tools::open_box(builder, BOARD, dvec3(0.26, 0.22, 0.3));
        builder.frame = here.shift(dvec3(-0.08, 0.021, 0.0));
        tools::pot(builder, CLAY, dvec2(0.09, 0.24));
        builder.frame = here;
        for shot in 0..7 {
            let x = 0.15 + random.between(-0.05, 0.05);
            builder.ball(IRON, dvec3(x, 0.05 + 0.045 * f64::from(shot), random.between(-0.13, 0.13)), 0.042, 10);
        }
    }
}

/// Wagon wheels that lean against each other and the walls, one lying on a trestle of crates.
fn wheels(builder: &mut MeshBuilder) {
    let places = [
        (dvec3(4.75, 0.52, 0.0), TURN / 4.0, -1.35, 0.55),
        (dvec3(4.55, 0.48, 0.05), TURN / 4.0, -1.3, 0.5),
        (dvec3(-4.75, 0.55, -1.5), -TURN / 4.0, -1.4, 0.58),
        (dvec3(2.9, 0.5, 3.55), 0.1, 1.35, 0.52),
        (dvec3(-0.2, 0.42, 0.55), 0.5, 1.15, 0.46),
        (dvec3(1.9, 0.45, 3.0), -0.3, 1.2, 0.5),
    ];
    for (number, (at, turn, lean, radius)) in places.into_iter().enumerate() {
        builder.object_at(format!("wheel {number}"), Frame::at(at).yaw(turn).pitch(lean));
        builder.wheel([WOOD, IRON], [radius, 0.035], 12);
    }
}

/// Boards between posts with rows of pots within pots, boxes, buckets and coils.
fn shelf(builder: &mut MeshBuilder, seed: u64) {
    let mut random = Random(300 + seed);
    let half = 1.05;
    let here = builder.frame;
    for x in [-half, half] {
        for z in [-0.275, 0.275] {
            builder.beam(DARK_WOOD, [2, 6], [dvec3(x, -SUNK, z), dvec3(x, 2.55, z)], [0.03, 0.03], DVec3::X);
        }
    }
    for level in 0..5 {
        let y = 0.14 + 0.55 * f64::from(level);
        builder.frame = here;
        builder.cuboid(BOARD, dvec3(-half - 0.02, y - 0.03, -0.285), dvec3(half + 0.02, y, 0.285), [6, 2, 2]);
        let mut x = -half + 0.05;
        while x < half - 0.3 {
            let kind = random.between(0.0, 1.0);
            let radius = random.between(0.11, 0.15);
            let at = dvec3(x + radius, y - 0.002, random.between(-0.08, 0.08));
            let place = here.shift(at).yaw(random.between(0.0, TURN));
            builder.frame = place;
            if kind < 0.55 {
                let high = random.between(0.26, 0.42);
                for nested in 0..3 {
                    let share = 1.0 - 0.27 * f64::from(nested);
                    builder.frame = place.shift(DVec3::Y * (0.06 * high * f64::from(nested)));
                    let material = [CLAY, GLAZE, COPPER][(seed as usize + nested as usize + level as usize) % 3];
                    tools::pot(builder, material, dvec2(radius, high) * share);
                }
            } else if kind < 0.7 {
                tools::bucket(builder, 0.75);
            } else if kind < 0.85 {
                tools::coil(builder, radius * 0.85);
            } else {
                tools::open_box(builder, WOOD, dvec3(radius * 1.3, 0.2, radius * 1.3));
                for shot in 0..4 {
                    let at = dvec3(0.0, 0.05 + 0.06 * f64::from(shot), 0.02 * f64::from(shot % 2));
                    builder.ball(POLISHED, at, 0.038, 12);
                }
            }
            x += 2.0 * radius + random.between(0.01, 0.05);
        }
    }
}

/// A bench with a lower board; hammers, tongs, boxes and pots lie on it, buckets and sacks below.
fn bench(builder: &mut MeshBuilder, long: f64, seed: u64) {
    let mut random = Random(700 + seed);
    let half = long / 2.0;
    let here = builder.frame;
    for (y, thick, deep) in [(0.9, 0.06, 0.4), (0.26, 0.03, 0.375)] {
        builder.cuboid(WOOD, dvec3(-half, y - thick, -deep), dvec3(half, y, deep), [8, 2, 2]);
    }
    for x in [-half + 0.1, half - 0.1] {
        for z in [-0.33, 0.33] {
            builder.beam(DARK_WOOD, [2, 4], [dvec3(x, -SUNK, z), dvec3(x, 0.87, z)], [0.045, 0.05], DVec3::X);
        }
    }
    let count = libm::round(long / 0.32) as usize;
    for thing in 0..count {
        let x = -half + long * (thing as f64 + 0.5) / count as f64;
        let place = here.shift(dvec3(x, 0.9, random.between(-0.1, 0.1)));
        let turn = random.between(-0.5, 0.5);
        match thing % 4 {
            0 => {
                builder.frame = place.shift(dvec3(0.0, 0.028, -0.2)).yaw(turn).pitch(-TURN / 4.0).yaw(TURN / 4.0);
                tools::hammer(builder, 0.38);
            }
            1 => {
                builder.frame = place.shift(DVec3::Y * -0.002);
                tools::pot(builder, COPPER, dvec2(0.12, 0.22));
                builder.frame = place.shift(DVec3::Y * 0.012);
                tools::pot(builder, GLAZE, dvec2(0.08, 0.26));
            }
            2 => {
                builder.frame = place.shift(dvec3(0.0, 0.012, -0.28)).yaw(turn).pitch(-TURN / 4.0);
                tools::tongs(builder, 0.55);
            }
            _ => {
                builder.frame = place.shift(DVec3::Y * -0.006).yaw(turn);
                tools::open_box(builder, BOARD, dvec3(0.24, 0.16, 0.3));
                for shoe in 0..4 {
                    let at = dvec3(-0.06 + 0.04 * f64::from(shoe), 0.18, 0.0);
                    builder.frame = place.shift(at).yaw(TURN / 4.0 + 0.2 * f64::from(shoe));
                    tools::horseshoe(builder);
                }
            }
        }
        builder.frame = here.shift(dvec3(x, 0.257, random.between(-0.06, 0.06))).yaw(random.between(0.0, TURN));
        match thing % 3 {
            0 => tools::bucket(builder, 0.8),
            1 => tools::sack(builder, 0.55),
            _ => tools::coil(builder, 0.13),
        }
    }
}
