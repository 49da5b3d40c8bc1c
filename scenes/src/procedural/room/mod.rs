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

use glam::{DVec3, dvec3};

use super::builder::{MaterialId, MeshBuilder, palette};
use super::{Built, NamedPose, cameras, path};

/// Triangles at scale 1, held by a test.
pub(crate) const TRIANGLES_AT_SCALE_1: u64 = 155_892;

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
    wall: [0.78, 0.75, 0.68];
    accent: [0.32, 0.43, 0.47];
    ceiling: [0.88, 0.88, 0.86];
    trim: [0.85, 0.84, 0.8];
    sky: [0.62, 0.78, 0.95];
    wood: [0.55, 0.36, 0.2];
    dark_wood: [0.28, 0.17, 0.1];
    black: [0.03, 0.03, 0.03];
    shade: [0.72, 0.2, 0.12];
    bulb: [0.98, 0.95, 0.82];
    marble: [0.86, 0.84, 0.8];
    stone: [0.36, 0.36, 0.38];
    clay: [0.6, 0.3, 0.2];
    glaze: [0.12, 0.3, 0.5];
    fruit: [0.9, 0.48, 0.08];
    leaf: [0.16, 0.38, 0.12];
    cloth: [0.7, 0.55, 0.3];
    books[5]: [[0.5, 0.1, 0.1], [0.1, 0.25, 0.2], [0.75, 0.65, 0.45], [0.15, 0.15, 0.35], [0.45, 0.42, 0.4]];
    floor: [0.82, 0.82, 0.84], 1.0, 0.0;
    metal: [0.75, 0.72, 0.68], 1.0, 0.35;
    mirror: [0.95, 0.93, 0.88], 1.0, 0.02;
}

/// Builds the room with about `scale` times its triangles at scale 1; it does not move.
pub(crate) fn build(scale: f64, _time_s: f64) -> Built {
    let mut builder = MeshBuilder::new(scale);
    let palette = Palette::new(&mut builder);
    builder.object("shell");
    shell::build(&mut builder, &palette);
    builder.object("table");
    table::build(&mut builder, &palette);
    builder.object("chairs");
    chairs::build(&mut builder, &palette);
    builder.object("shelf");
    shelf::build(&mut builder, &palette);
    builder.object("lamp");
    lamp::build(&mut builder, &palette);
    builder.object("corner");
    corner::build(&mut builder, &palette);
    builder.object("statue");
    statue::build(&mut builder, &palette);
    Built { mesh: builder.finish(), cameras: cameras(&VIEWPOINTS), path: path(&PATH) }
}

const VIEWPOINTS: [NamedPose; 5] = [
    ("entrance", [-2.6, 1.65, 2.15], [0.55, 0.95, -0.75]),
    ("corner", [2.65, 2.4, 2.1], [-0.5, 0.75, -0.6]),
    ("statue", [0.55, 1.7, -0.2], [1.5, 1.38, -1.3]),
    ("floor", [-2.3, 0.06, 2.0], [0.4, 0.16, -0.7]),
    ("chair_legs", [-0.35, 0.3, 1.75], [-1.0, 0.28, 0.3]),
];

/// From the entrance along the table to the statue.
const PATH: [([f32; 3], [f32; 3]); 4] = [
    ([-2.6, 1.65, 2.15], [0.55, 0.95, -0.75]),
    ([-1.2, 1.6, 2.1], [-0.9, 0.8, 0.3]),
    ([0.4, 1.6, 1.2], [0.8, 1.0, -1.0]),
    ([0.55, 1.7, -0.2], [1.5, 1.38, -1.3]),
];
