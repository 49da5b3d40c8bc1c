//! What fills the corners: a curtain on either side of the window, a potted plant, a ball and a ring on the floor.

use super::*;

pub(super) fn build(builder: &mut MeshBuilder) {
    curtain(builder, -2.12, 0.3);
    curtain(builder, 0.12, 1.7);
    let z = MIN.z + 0.1;
    builder.rod(METAL, [12, 12], [dvec3(-2.55, 2.52, z), dvec3(0.55, 2.52, z)], 0.012);
    for x in [-2.45, 0.45] {
        builder.rod(METAL, [8, 2], [dvec3(x, 2.519, MIN.z - 0.01), dvec3(x, 2.519, z)], 0.006);
    }
    plant(builder);
    builder.frame = Frame::WORLD;
    builder.ball(MIRROR, dvec3(-2.3, 0.28 - SUNK, -1.35), 0.28, 56);
    builder.torus(SHADE, [14, 40, 3], dvec3(0.55, 0.06 - SUNK, 1.75), [0.2, 0.06]);
}

/// A thin folded cloth around `x`.
fn curtain(builder: &mut MeshBuilder, x: f64, phase: f64) {
    builder.cloth(CLOTH, [[32, 6], [14, 2]], 0.0035, |up, along, off| {
        // Rows differ only in size and place, so that every cell is flat: a bent one could reach through the cloth.
        let size = 1.0 - 0.16 * up + 0.05 * sin(3.0 * up + phase);
        let fold = 0.032 * sin(TURN * 5.0 * along + phase) + 0.011 * sin(TURN * 11.0 * along + 2.0 * phase);
        let sway = 0.012 * sin(2.5 * up + phase);
        let flat = dvec3((along - 0.5) * 0.46, 0.0, fold + off) * size;
        // Counter-clockwise rings need a stack that goes up.
        dvec3(x + sway, mix(0.05, 2.515, up), MIN.z + 0.1) + flat
    });
}

/// A pot with arching leaves, in the corner between the right and the front wall.
fn plant(builder: &mut MeshBuilder) {
    builder.frame = Frame::at(dvec3(2.5, 0.0, 1.95));
    let pot = knots(
        [0.0, 0.12, 0.135, 0.16, 0.18, 0.176, 0.168, 0.16, 0.0],
        [-SUNK, -SUNK, 0.015, 0.16, 0.3, 0.31, 0.3, 0.262, 0.27],
    );
    builder.revolve_smooth(CLAY, [32, 16, 8], &pot);
    let mut random = Random(7);
    for leaf in 0..16 {
        let heading = TURN * (f64::from(leaf) * 0.382) + random.between(-0.1, 0.1);
        let out = dvec3(cos(heading), 0.0, sin(heading));
        let side = dvec3(-out.z, 0.0, out.x);
        let reach = random.between(0.12, 0.34);
        let height = random.between(0.6, 1.05);
        let droop = random.between(0.05, 0.22);
        let path = |t: f64| out * (0.05 + reach * t * t) + DVec3::Y * (0.255 + height * (t - droop * t * t * t * t));
        builder.ribbon(LEAF, [8, 12, 4], Some(side), path, |t| {
            let body = sin(TURN / 2.0 * (0.12 + 0.86 * t));
            dvec2(0.004 + 0.03 * body * body, 0.0012 + 0.002 * (1.0 - t))
        });
    }
}
