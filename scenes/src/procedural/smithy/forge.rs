//! The forge with its hood, fire and bellows; anvil and stump; trough, grindstone, and what lies around them.

use super::*;

/// Middle of the hearth on the floor.
const HEARTH: DVec3 = dvec3(-3.6, 0.0, -2.6);
/// Middle of the anvil's stump on the floor.
const ANVIL: DVec3 = dvec3(-1.7, 0.0, -1.3);

pub(super) fn build(builder: &mut MeshBuilder) {
    builder.part("hearth", Frame::at(HEARTH), hearth);
    builder.part("hood", Frame::at(HEARTH), hood);
    builder.part("bellows", Frame::at(HEARTH + dvec3(1.75, 0.95, 0.15)).yaw(0.1), bellows);
    builder.part("anvil", Frame::at(ANVIL).yaw(0.4), anvil);
    builder.part("trough", Frame::at(dvec3(-0.4, 0.0, -2.9)).yaw(0.06), trough);
    builder.part("grindstone", Frame::at(dvec3(1.5, 0.0, 0.1)).yaw(0.7), grindstone);
}

/// Brickwork, a rim around the fire, coals and irons in it.
fn hearth(builder: &mut MeshBuilder) {
    let mut random = Random(15);
    builder.cuboid(BRICK, dvec3(-1.0, -SUNK, -0.8), dvec3(1.0, 0.8, 0.8), [2, 2, 2]);
    for course in 0..6 {
        let y = 0.02 + 0.13 * f64::from(course);
        for brick in 0..8 {
            let x = -1.01 + 0.25 * f64::from(brick) + 0.06 * f64::from(course % 2);
            let out = random.between(0.012, 0.03);
            builder.cuboid(BRICK, dvec3(x, y, 0.7), dvec3(x + 0.23, y + 0.115, 0.8 + out), [2, 2, 2]);
        }
    }
    builder.border(STONE, [4, 2, 2], [dvec2(0.55, 0.42), dvec2(0.82, 0.66)], [0.76, 0.95]);
    for coal in 0..90 {
        let (x, z) = (random.between(-0.5, 0.5), random.between(-0.37, 0.37));
        let y = 0.82 + 0.12 * (1.0 - x * x * 4.0) * random.between(0.2, 1.0);
        let material = if coal % 3 == 0 { EMBER } else { COAL };
        builder.ball(material, dvec3(x, y, z), random.between(0.03, 0.055), 8);
    }
    for bar in 0..4 {
        let from = dvec3(-0.2 + 0.15 * f64::from(bar), 0.92, 0.1);
        let to = from + dvec3(random.between(0.1, 0.5), random.between(0.06, 0.12), 0.95);
        builder.rod(IRON, [8, 8], [from, to], 0.014);
    }
}

/// A hollow pyramid of sheet and a chimney through the ceiling's boards.
fn hood(builder: &mut MeshBuilder) {
    let rings = [(1.02, 0.82, 1.9), (1.02, 0.82, 2.05), (0.4, 0.36, 3.0), (0.34, 0.3, HEIGHT + 0.05)];
    // Down the inside, then up the outside.
    let thick = 0.03;
    let mut section: Vec<[f64; 3]> = rings.iter().rev().map(|&(x, z, y)| [x - thick, z - thick, y]).collect();
    section.extend(rings.map(|(x, z, y)| [x, z, y]));
    section[4][2] = rings[0].2 + 0.001;
    let flat = builder.outline(&[[1.0, 1.0], [1.0, -1.0], [-1.0, -1.0], [-1.0, 1.0]], &[10]);
    builder.rings(IRON, [flat.len(), section.len()], Ends::Looped, |ring, at| {
        let [x, z, y] = section[section.len() - 1 - at];
        dvec3(flat[ring].x * x, y, flat[ring].y * z)
    });
    for (x, z) in [(-0.95, 0.75), (0.95, 0.75)] {
        builder.rod(IRON, [10, 8], [dvec3(x, 0.75, z), dvec3(x, 2.0, z)], 0.025);
    }
}

/// Two boards, a pleated leather between them, a nozzle into the fire, on a trestle.
fn bellows(builder: &mut MeshBuilder) {
    for (y, wide) in [(-0.2, 0.33), (0.22, 0.34)] {
        builder.slab(WOOD, [32, 5, 2], dvec3(0.1, y, 0.0), dvec3(0.55, 0.022, wide), 3.0);
    }
    let (around, rows) = (builder.around(36), builder.divide(24, 6));
    let ends = Ends::Closed(dvec3(0.1, -0.19, 0.0), dvec3(0.1, 0.21, 0.0));
    builder.turned(LEATHER, [rows + 1, around], ends, |ring, angle| {
        let up = ring as f64 / rows as f64;
        let pleat = 0.86 + 0.07 * sin(TURN * 3.0 * up);
        dvec3(0.1 + 0.52 * pleat * cos(angle), mix(-0.19, 0.21, up), -0.31 * pleat * sin(angle))
    });
    let nozzle = |t: f64| dvec3(mix(-0.4, -1.15, t), -0.02 * t, 0.0);
    builder.tube(COPPER, [14, 10, 3], nozzle, |t| mix(0.07, 0.03, t));
    for x in [-0.25, 0.45] {
        for z in [-0.25, 0.25] {
            let ends = [dvec3(x * 1.1, -0.95 - SUNK, z * 1.2), dvec3(x, -0.18, z)];
            builder.beam(DARK_WOOD, [2, 4], ends, [0.035, 0.035], DVec3::X);
        }
    }
    builder.rod(WOOD, [10, 6], [dvec3(0.6, 0.23, 0.0), dvec3(1.15, 0.4, 0.0)], 0.025);
}

/// A stump with hoops, the anvil on it, and a hammer on the anvil.
fn anvil(builder: &mut MeshBuilder) {
    let stump = [[0.0, -SUNK], [0.33, -SUNK], [0.3, 0.12], [0.28, 0.4], [0.285, 0.56], [0.0, 0.565]];
    builder.revolve_smooth(DARK_WOOD, [40, 16, 5], &stump);
    for (y, radius) in [(0.14, 0.3), (0.45, 0.285)] {
        let (inner, outer) = (radius - 0.02, radius + 0.012);
        builder.hoop(IRON, 40, &[[inner, y], [outer, y], [outer, y + 0.05], [inner, y + 0.05]], &[0]);
    }
    for (x, z, y0, y1) in [(0.2, 0.12, 0.55, 0.62), (0.11, 0.06, 0.61, 0.74), (0.24, 0.075, 0.73, 0.85)] {
        builder.cuboid(STEEL, dvec3(-x, y0, -z), dvec3(x, y1, z), [2, 2, 2]);
    }
    let horn = |t: f64| dvec3(mix(0.2, 0.52, t), 0.79 + 0.035 * t, 0.0);
    builder.ribbon(POLISHED, [20, 20, 4], Some(DVec3::Z), horn, |t| dvec2(0.065, 0.055) * sqrt(1.0 - 0.98 * t));
    builder.frame = builder.frame.shift(dvec3(-0.1, 0.868, -0.2)).pitch(-TURN / 4.0).yaw(0.2);
    tools::hammer(builder, 0.36);
}

/// A stone trough with water in it and tongs over its rim.
fn trough(builder: &mut MeshBuilder) {
    let here = builder.frame;
    builder.border(STONE, [6, 2, 4], [dvec2(0.55, 0.22), dvec2(0.68, 0.34)], [-SUNK, 0.55]);
    builder.cuboid(STONE, dvec3(-0.6, -0.004, -0.28), dvec3(0.6, 0.1, 0.28), [2, 2, 2]);
    builder.cuboid(WATER, dvec3(-0.58, 0.09, -0.26), dvec3(0.58, 0.44, 0.26), [2, 2, 2]);
    for tool in 0..4 {
        builder.frame = here.shift(dvec3(-0.4 + 0.27 * f64::from(tool), 0.95, 0.3)).pitch(0.55);
        tools::tongs(builder, 0.62);
    }
}

/// A stone wheel with a crank between two trestles, over a box.
fn grindstone(builder: &mut MeshBuilder) {
    let here = builder.frame;
    let stone = [[0.0, -0.07], [0.36, -0.065], [0.4, -0.05], [0.405, 0.0], [0.4, 0.05], [0.36, 0.065], [0.0, 0.07]];
    let upright = here.shift(DVec3::Y * 0.8).pitch(TURN / 4.0);
    builder.within(upright, |here| here.revolve_smooth(STONE, [56, 20, 7], &stone));
    builder.rod(IRON, [12, 6], [dvec3(0.0, 0.8, -0.3), dvec3(0.0, 0.8, 0.36)], 0.02);
    builder.rod(IRON, [10, 4], [dvec3(0.0, 0.8, 0.34), dvec3(0.16, 0.66, 0.345)], 0.016);
    builder.rod(WOOD, [12, 4], [dvec3(0.15, 0.665, 0.33), dvec3(0.15, 0.665, 0.5)], 0.02);
    for z in [-0.18, 0.18] {
        for x in [-0.35, 0.35] {
            builder.beam(WOOD, [2, 6], [dvec3(x, -SUNK, z), dvec3(0.1 * x, 0.84, z * 0.98)], [0.03, 0.03], DVec3::Z);
        }
    }
    builder.frame = here.shift(DVec3::Y * 0.1);
    tools::open_box(builder, DARK_WOOD, dvec3(0.7, 0.3, 0.26));
}
