//! The scene `smithy`: a cluttered workshop of 10 x 4.2 x 8 metres around the origin of its floor.
//!
//! A stand-in for the interiors full of small things that papers on multi-view A-buffers trace through: wherever one
//! looks, tools, barrels, chains, wheels, shelves and vessels within vessels lie behind one another, panelled walls
//! and boards behind them.

mod forge;
mod hanging;
mod shell;
mod store;
mod tools;

use super::builder::{MaterialId, MeshBuilder, palette};
use super::{Built, NamedPose, cameras, path};

/// Triangles at scale 1, held by a test.
pub(crate) const TRIANGLES_AT_SCALE_1: u64 = 350_616;

/// Half the inside along x and z, and its height, in metres.
const HALF: [f64; 2] = [5.0, 4.0];
const HEIGHT: f64 = 4.2;
/// How deep things are sunk into what they stand on.
const SUNK: f64 = 0.006;

palette! {
    wall: [0.55, 0.5, 0.43];
    stone: [0.42, 0.41, 0.39];
    brick: [0.48, 0.25, 0.18];
    wood: [0.5, 0.34, 0.19];
    dark_wood: [0.27, 0.17, 0.1];
    board: [0.42, 0.3, 0.18];
    leather: [0.36, 0.18, 0.09];
    rope: [0.62, 0.52, 0.33];
    coal: [0.05, 0.05, 0.05];
    ember: [0.95, 0.35, 0.06];
    clay: [0.6, 0.33, 0.21];
    glaze: [0.16, 0.3, 0.36];
    sack: [0.6, 0.52, 0.4];
    iron: [0.22, 0.22, 0.23], 1.0, 0.5;
    steel: [0.55, 0.56, 0.58], 1.0, 0.3;
    polished: [0.88, 0.88, 0.9], 1.0, 0.03;
    copper: [0.9, 0.55, 0.4], 1.0, 0.1;
    water: [0.4, 0.45, 0.48], 1.0, 0.0;
}

/// Builds the smithy with about `scale` times its triangles at scale 1; it does not move.
pub(crate) fn build(scale: f64, _time_s: f64) -> Built {
    let mut builder = MeshBuilder::new(scale);
    let palette = Palette::new(&mut builder);
    shell::build(&mut builder, &palette);
    forge::build(&mut builder, &palette);
    store::build(&mut builder, &palette);
    hanging::build(&mut builder, &palette);
    Built { mesh: builder.finish(), cameras: cameras(&VIEWPOINTS), path: path(&PATH) }
}

const VIEWPOINTS: [NamedPose; 5] = [
    ("door", [3.9, 1.65, 2.6], [-1.5, 1.3, -1.2]),
    ("forge", [-1.2, 1.6, 0.5], [-3.6, 1.1, -2.6]),
    ("shelves", [0.6, 1.5, -0.8], [3.6, 1.4, -3.6]),
    ("bench", [0.4, 1.55, 1.3], [-1.0, 1.2, 3.8]),
    ("rafters", [2.2, 3.15, 1.2], [-3.0, 2.4, -1.6]),
];

/// From the door past the bench to the forge.
const PATH: [([f32; 3], [f32; 3]); 5] = [
    ([3.9, 1.65, 2.6], [-1.5, 1.3, -1.2]),
    ([2.2, 1.65, 1.7], [-1.5, 1.3, 0.5]),
    ([0.4, 1.6, 1.3], [-2.0, 1.2, 0.0]),
    ([-0.6, 1.6, 0.8], [-3.4, 1.2, -2.0]),
    ([-1.2, 1.6, 0.5], [-3.6, 1.1, -2.6]),
];
