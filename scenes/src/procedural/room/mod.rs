//! The scene `room`: a closed, furnished room of 6 x 3 x 5 metres around the origin of its floor.
//!
//! Its floor is a mirror, its chairs have thin legs, its lamp hangs on a thin cord, and a dense statue holds two thirds
//! of its triangles. What stands or hangs is sunk a little into what holds it, so that no two faces coincide.

mod chairs;
mod corner;
mod lamp;
mod shelf;
mod shell;
mod statue;
mod table;

use super::prelude::*;

/// Least corner of the inside of the room.
const MIN: DVec3 = dvec3(-3.0, 0.0, -2.5);
/// Greatest corner of the inside of the room.
const MAX: DVec3 = dvec3(3.0, 3.0, 2.5);
/// How deep things are sunk into what they stand on.
const SUNK: f64 = 0.002;
/// Middle of the table on the floor.
const TABLE: DVec3 = dvec3(-0.9, 0.0, 0.3);
/// Middle of the statue on the floor.
const STATUE: DVec3 = dvec3(1.55, 0.0, -1.35);

palette! {
    WALL: [0.78, 0.75, 0.68];
    ACCENT: [0.32, 0.43, 0.47];
    CEILING: [0.88, 0.88, 0.86];
    TRIM: [0.85, 0.84, 0.8];
    SKY: [0.62, 0.78, 0.95];
    WOOD: [0.55, 0.36, 0.2];
    DARK_WOOD: [0.28, 0.17, 0.1];
    BLACK: [0.03, 0.03, 0.03];
    SHADE: [0.72, 0.2, 0.12];
    BULB: [0.98, 0.95, 0.82];
    MARBLE: [0.86, 0.84, 0.8];
    STONE: [0.36, 0.36, 0.38];
    CLAY: [0.6, 0.3, 0.2];
    GLAZE: [0.12, 0.3, 0.5];
    FRUIT: [0.9, 0.48, 0.08];
    LEAF: [0.16, 0.38, 0.12];
    CLOTH: [0.7, 0.55, 0.3];
    RED_BOOK: [0.5, 0.1, 0.1];
    GREEN_BOOK: [0.1, 0.25, 0.2];
    TAN_BOOK: [0.75, 0.65, 0.45];
    BLUE_BOOK: [0.15, 0.15, 0.35];
    GREY_BOOK: [0.45, 0.42, 0.4];
    FLOOR: [0.82, 0.82, 0.84], 1.0, 0.0;
    METAL: [0.75, 0.72, 0.68], 1.0, 0.35;
    MIRROR: [0.95, 0.93, 0.88], 1.0, 0.02;
}

/// Builds the room with about `scale` times its triangles at scale 1; it does not move.
pub(crate) fn build(scale: f64, _time_s: f64) -> Mesh {
    let mut builder = MeshBuilder::new(scale, PALETTE);
    builder.part("shell", Frame::WORLD, shell::build);
    builder.part("table", Frame::WORLD, table::build);
    builder.part("chairs", Frame::WORLD, chairs::build);
    builder.part("shelf", Frame::WORLD, shelf::build);
    builder.part("lamp", Frame::WORLD, lamp::build);
    builder.part("corner", Frame::WORLD, corner::build);
    builder.part("statue", Frame::WORLD, statue::build);
    builder.finish()
}
