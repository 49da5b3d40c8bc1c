//! What fills the corners: a curtain on either side of the window, a potted plant, a ball and a ring on the floor.

use glam::{DVec3, dvec2, dvec3};

use super::{MIN, Palette, SUNK};
use crate::procedural::builder::{Ends, MeshBuilder};
use crate::procedural::math::{Frame, Random, TURN, cos, mix, sin};

pub(super) fn build(builder: &mut MeshBuilder, palette: &Palette) {
    curtain(builder, palette, -2.12, 0.3);
    curtain(builder, palette, 0.12, 1.7);
    builder.rod(
        palette.metal,
        builder.round(12, 12),
        [dvec3(-2.55, 2.52, MIN.z + 0.1), dvec3(0.55, 2.52, MIN.z + 0.1)],
        0.012,
    );
    for x in [-2.45, 0.45] {
        builder.rod(
            palette.metal,
            builder.round(8, 2),
            [dvec3(x, 2.519, MIN.z - 0.01), dvec3(x, 2.519, MIN.z + 0.1)],
            0.006,
        );
    }
    plant(builder, palette);
    builder.frame = Frame::WORLD;
    builder.ball(palette.mirror, dvec3(-2.3, 0.28 - SUNK, -1.35), 0.28, builder.around(56));
    builder.torus(palette.shade, builder.ring(14, 40), dvec3(0.55, 0.06 - SUNK, 1.75), [0.2, 0.06]);
}

/// A thin folded cloth around `x`: each ring runs along its front and back along its back.
fn curtain(builder: &mut MeshBuilder, palette: &Palette, x: f64, phase: f64) {
    let half_around = builder.divide(32, 6);
    let rows = builder.divide(14, 2);
    let (top, bottom) = (2.515, 0.05);
    let point = |row: usize, at: usize| {
        let up = row as f64 / rows as f64;
        let (along, face) = if at <= half_around {
            (at as f64 / half_around as f64, 1.0)
        } else {
            (2.0 - at as f64 / half_around as f64, -1.0)
        };
        // Rows differ only in size and place, so that every cell is flat: a bent one could reach through the cloth.
        let size = 1.0 - 0.16 * up + 0.05 * sin(3.0 * up + phase);
        let fold = 0.032 * sin(TURN * 5.0 * along + phase) + 0.011 * sin(TURN * 11.0 * along + 2.0 * phase);
        // Front and back meet at the tips.
        let thick = 0.0035 * libm::sqrt((4.0 * along * (1.0 - along)).max(0.0)) * face;
        let sway = 0.012 * sin(2.5 * up + phase);
        let flat = dvec3((along - 0.5) * 0.46, 0.0, fold + thick) * size;
        // Counter-clockwise rings need a stack that goes up.
        dvec3(x + sway, mix(bottom, top, up), MIN.z + 0.1) + flat
    };
    builder.rings(palette.cloth, rows + 1, 2 * half_around, &Ends::Pressed, point);
}

/// A pot with arching leaves, in the corner between the right and the front wall.
fn plant(builder: &mut MeshBuilder, palette: &Palette) {
    builder.frame = Frame::at(dvec3(2.5, 0.0, 1.95));
    let pot = [
        [0.0, -SUNK],
        [0.12, -SUNK],
        [0.135, 0.015],
        [0.16, 0.16],
        [0.18, 0.3],
        [0.176, 0.31],
        [0.168, 0.3],
        [0.16, 0.262],
        [0.0, 0.27],
    ];
    builder.revolve_smooth(palette.clay, builder.bent(32, [16, 8]), &pot);
    let mut random = Random(7);
    let leaves = 16;
    for leaf in 0..leaves {
        let heading = TURN * (f64::from(leaf) * 0.382) + random.between(-0.1, 0.1);
        let out = dvec3(cos(heading), 0.0, sin(heading));
        let side = dvec3(-out.z, 0.0, out.x);
        let reach = random.between(0.12, 0.34);
        let height = random.between(0.6, 1.05);
        let droop = random.between(0.05, 0.22);
        let path = |t: f64| out * (0.05 + reach * t * t) + DVec3::Y * (0.255 + height * (t - droop * t * t * t * t));
        builder.ribbon(palette.leaf, builder.bent(8, [12, 4]), Some(side), path, |t| {
            let body = sin(TURN / 2.0 * (0.12 + 0.86 * t));
            dvec2(0.004 + 0.03 * body * body, 0.0012 + 0.002 * (1.0 - t))
        });
    }
}
