//! Catwalks along the back wall and across the hall, with handrails, hangers, a stair and a ladder.

use glam::{DVec3, dvec3};

use super::{HALF, Palette, SUNK};
use crate::procedural::builder::MeshBuilder;

/// Height of the walking surface.
const DECK: f64 = 6.8;

pub(super) fn build(builder: &mut MeshBuilder, palette: &Palette) {
    builder.object("catwalk along the wall");
    let back = -HALF[1] + 2.6;
    walk(builder, palette, [dvec3(-28.0, DECK, back), dvec3(28.0, DECK, back)], 24);
    builder.object("catwalk across");
    walk(builder, palette, [dvec3(-21.0, DECK + 0.03, back + 0.9), dvec3(-21.0, DECK + 0.03, 18.6)], 14);
    builder.object("stair");
    stair(builder, palette, dvec3(20.0, 0.0, back + 1.6), dvec3(9.5, DECK, back + 1.6));
    builder.object("ladder");
    let ends = [dvec3(-21.0, -SUNK, 19.3), dvec3(-21.0, 11.9, 19.3)];
    builder.ladder(palette.yellow, ends, DVec3::X * 0.3, 24);
}

/// A deck of bars between two beams, with posts, two rails on either side and brackets underneath.
fn walk(builder: &mut MeshBuilder, palette: &Palette, [from, to]: [DVec3; 2], bays: usize) {
    let along = (to - from).normalize_or(DVec3::X);
    let side = DVec3::Y.cross(along) * 0.8;
    let [fine, long] = builder.sides([2, 24]);
    let at = |t: f64| from + (to - from) * t;
    for face in [-1.0, 1.0] {
        let line = |up: f64| [from, to].map(|end| end + side * face + DVec3::Y * up);
        builder.beam(palette.steel, [fine, long], line(-0.1), [0.1, 0.04], DVec3::Y);
        for up in [0.55, 1.1] {
            builder.rod(palette.yellow, [builder.around(8), long], line(up), 0.025);
        }
        for post in 0..=bays {
            let foot = at((post as f64 + 0.2) / (bays as f64 + 0.4)) + side * face * 1.005;
            let ends = [foot - DVec3::Y * 0.17, foot + DVec3::Y * 1.1];
            builder.rod(palette.yellow, builder.round(6, 4), ends, 0.03);
        }
    }
    // The grating: bars across.
    for bar in 0..bays * 2 {
        let middle = at((bar as f64 + 0.5) / (bays * 2) as f64) - DVec3::Y * 0.03;
        builder.beam(palette.steel, builder.sides([1, 2]), [middle - side, middle + side], [0.025, 0.2], DVec3::Y);
    }
    for hanger in 0..bays / 4 {
        let foot = at((hanger as f64 + 0.5) / (bays / 4) as f64) - DVec3::Y * 0.15;
        let ends = [foot - side * 1.1, foot + side * 1.1];
        builder.beam(palette.red_lead, [fine, fine], ends, [0.06, 0.06], DVec3::Y);
        for face in [-1.0, 1.0] {
            let low = foot + side * face * 1.05;
            builder.rod(palette.steel, builder.round(6, 8), [low, low + DVec3::Y * 5.7], 0.025);
        }
    }
}

/// A straight stair with open treads and a rail.
fn stair(builder: &mut MeshBuilder, palette: &Palette, from: DVec3, to: DVec3) {
    let fine = builder.along(2);
    let side = DVec3::Z * 0.55;
    for face in [-1.0, 1.0] {
        let ends = [from - DVec3::Y * SUNK, to].map(|end| end + side * face);
        builder.beam(palette.steel, [fine, builder.along(20)], ends, [0.14, 0.03], DVec3::Y);
        let rail = ends.map(|end| end + DVec3::Y * 1.05);
        builder.rod(palette.yellow, builder.round(8, 20), rail, 0.025);
        for post in 0..7 {
            let foot = ends[0] + (ends[1] - ends[0]) * ((f64::from(post) + 0.4) / 7.0);
            let post = [foot, foot + DVec3::Y * 1.05];
            builder.rod(palette.yellow, builder.round(6, 4), post, 0.022);
        }
    }
    for tread in 0..26 {
        let middle = from + (to - from) * ((f64::from(tread) + 0.7) / 26.0);
        builder.beam(palette.steel, [builder.along(1), fine], [middle - side, middle + side], [0.02, 0.13], DVec3::Y);
    }
}
