//! Catwalks along the back wall and across the hall, with handrails, hangers, a stair and a ladder.

use super::*;

/// Height of the walking surface.
const DECK: f64 = 6.8;

pub(super) fn build(builder: &mut MeshBuilder) {
    builder.object("catwalk along the wall");
    let back = -HALF[1] + 2.6;
    walk(builder, [dvec3(-28.0, DECK, back), dvec3(28.0, DECK, back)], 24);
    builder.object("catwalk across");
    walk(builder, [dvec3(-21.0, DECK + 0.03, back + 0.9), dvec3(-21.0, DECK + 0.03, 18.6)], 14);
    builder.object("stair");
    stair(builder, dvec3(20.0, 0.0, back + 1.6), dvec3(9.5, DECK, back + 1.6));
    builder.object("ladder");
    builder.ladder(YELLOW, [dvec3(-21.0, -SUNK, 19.3), dvec3(-21.0, 11.9, 19.3)], DVec3::X * 0.3, 24);
}

/// A deck of bars between two beams, with posts, two rails on either side and brackets underneath.
fn walk(builder: &mut MeshBuilder, [from, to]: [DVec3; 2], bays: usize) {
    let side = DVec3::Y.cross((to - from).normalize_or(DVec3::X)) * 0.8;
    let at = line([from, to]);
    for face in [-1.0, 1.0] {
        let along = |up: f64| [from, to].map(|end| end + side * face + DVec3::Y * up);
        builder.beam(STEEL, [2, 24], along(-0.1), [0.1, 0.04], DVec3::Y);
        for up in [0.55, 1.1] {
            builder.rod(YELLOW, [8, 24], along(up), 0.025);
        }
        for post in 0..=bays {
            let foot = at((post as f64 + 0.2) / (bays as f64 + 0.4)) + side * face * 1.005;
            builder.rod(YELLOW, [6, 4], [foot - DVec3::Y * 0.17, foot + DVec3::Y * 1.1], 0.03);
        }
    }
    // The grating: bars across.
    for bar in 0..bays * 2 {
        let middle = at((bar as f64 + 0.5) / (bays * 2) as f64) - DVec3::Y * 0.03;
        builder.beam(STEEL, [1, 2], [middle - side, middle + side], [0.025, 0.2], DVec3::Y);
    }
    for hanger in 0..bays / 4 {
        let foot = at((hanger as f64 + 0.5) / (bays / 4) as f64) - DVec3::Y * 0.15;
        builder.beam(RED_LEAD, [2, 2], [foot - side * 1.1, foot + side * 1.1], [0.06, 0.06], DVec3::Y);
        for face in [-1.0, 1.0] {
            let low = foot + side * face * 1.05;
            builder.rod(STEEL, [6, 8], [low, low + DVec3::Y * 5.7], 0.025);
        }
    }
}

/// A straight stair with open treads and a rail.
fn stair(builder: &mut MeshBuilder, from: DVec3, to: DVec3) {
    let side = DVec3::Z * 0.55;
    for face in [-1.0, 1.0] {
        let ends = [from - DVec3::Y * SUNK, to].map(|end| end + side * face);
        builder.beam(STEEL, [2, 20], ends, [0.14, 0.03], DVec3::Y);
        builder.rod(YELLOW, [8, 20], ends.map(|end| end + DVec3::Y * 1.05), 0.025);
        for post in 0..7 {
            let foot = line(ends)((f64::from(post) + 0.4) / 7.0);
            builder.rod(YELLOW, [6, 4], [foot, foot + DVec3::Y * 1.05], 0.022);
        }
    }
    for tread in 0..26 {
        let middle = line([from, to])((f64::from(tread) + 0.7) / 26.0);
        builder.beam(STEEL, [1, 2], [middle - side, middle + side], [0.02, 0.13], DVec3::Y);
    }
}
