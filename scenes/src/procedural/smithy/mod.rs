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

use super::prelude::*;

/// Half the inside along x and z, and its height, in metres.
const HALF: [f64; 2] = [5.0, 4.0];
const HEIGHT: f64 = 4.2;
/// How deep things are sunk into what they stand on.
const SUNK: f64 = 0.006;

palette! {
    WALL: [0.55, 0.5, 0.43];
    STONE: [0.42, 0.41, 0.39];
    BRICK: [0.48, 0.25, 0.18];
    WOOD: [0.5, 0.34, 0.19];
    DARK_WOOD: [0.27, 0.17, 0.1];
    BOARD: [0.42, 0.3, 0.18];
    LEATHER: [0.36, 0.18, 0.09];
    ROPE: [0.62, 0.52, 0.33];
    COAL: [0.05, 0.05, 0.05];
    EMBER: [0.95, 0.35, 0.06];
    CLAY: [0.6, 0.33, 0.21];
    GLAZE: [0.16, 0.3, 0.36];
    SACK: [0.6, 0.52, 0.4];
    IRON: [0.22, 0.22, 0.23], 1.0, 0.5;
    STEEL: [0.55, 0.56, 0.58], 1.0, 0.3;
    POLISHED: [0.88, 0.88, 0.9], 1.0, 0.03;
    COPPER: [0.9, 0.55, 0.4], 1.0, 0.1;
    WATER: [0.4, 0.45, 0.48], 1.0, 0.0;
}

/// Builds the smithy with about `scale` times its triangles at scale 1; it does not move.
pub(crate) fn build(scale: f64, _time_s: f64) -> Mesh {
    let mut builder = MeshBuilder::new(scale, PALETTE);
    shell::build(&mut builder);
    forge::build(&mut builder);
    store::build(&mut builder);
    hanging::build(&mut builder);
    builder.finish()
}
