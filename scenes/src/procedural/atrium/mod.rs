//! The scene `atrium`: a court of 18 x 10 metres between colonnades on two storeys, with galleries behind them.
//!
//! A stand-in for the atrium of the Sponza palace, which nearly every paper on ray tracing in image space shows: long
//! rows of columns and arches, balustrades, drapes and vases, seen along and through. The court ends in a painted sky.

mod arcade;
mod court;
mod shell;

use super::prelude::*;

/// Half the court between the middles of its columns, along x and z, in metres.
const COURT: [f64; 2] = [9.0, 5.0];
/// Depth of the galleries from there to the outer walls.
const GALLERY: f64 = 4.0;
/// Floors of the storeys, and the sky above the court.
const FLOORS: [f64; 2] = [0.0, 5.0];
const SKY_HEIGHT: f64 = 12.5;
/// How deep things are sunk into what they stand on.
const SUNK: f64 = 0.01;

palette! {
    WALL: [0.72, 0.63, 0.5];
    FLOOR: [0.5, 0.46, 0.4];
    LIGHT_TILE: [0.62, 0.57, 0.48];
    DARK_TILE: [0.42, 0.36, 0.3];
    SKY: [0.55, 0.74, 0.95];
    STONE: [0.74, 0.68, 0.58];
    MARBLE: [0.82, 0.79, 0.73];
    TRIM: [0.66, 0.56, 0.43];
    WOOD: [0.36, 0.23, 0.13];
    CLAY: [0.62, 0.33, 0.2];
    LEAF: [0.16, 0.4, 0.12];
    FLAME: [0.98, 0.82, 0.45];
    RED_CLOTH: [0.62, 0.1, 0.08];
    BLUE_CLOTH: [0.12, 0.22, 0.5];
    GREEN_CLOTH: [0.14, 0.4, 0.2];
    IRON: [0.25, 0.25, 0.26], 1.0, 0.5;
    BRONZE: [0.8, 0.6, 0.35], 1.0, 0.08;
    WATER: [0.72, 0.8, 0.85], 1.0, 0.0;
}

/// A side of the court: in its frame x runs along the columns and z from the court outwards.
struct Side {
    frame: Frame,
    /// Half its length in metres, and the number of arches.
    half: f64,
    bays: usize,
}

impl Side {
    /// The four sides; the columns at the start of each are the corners.
    fn all() -> [Self; 4] {
        [0, 1, 2, 3].map(|turn| {
            let long = turn % 2 == 0;
            let (half, out, bays) = if long { (COURT[0], COURT[1], 6) } else { (COURT[1], COURT[0], 3) };
            Self { frame: Frame::WORLD.yaw(TURN / 4.0 * f64::from(turn)).shift(DVec3::Z * out), half, bays }
        })
    }

    /// Where column number `at` stands along the side.
    fn column(&self, at: usize) -> f64 {
        self.half * (2.0 * at as f64 / self.bays as f64 - 1.0)
    }
}

/// Builds the atrium with about `scale` times its triangles at scale 1; it does not move.
pub(crate) fn build(scale: f64, _time_s: f64) -> Mesh {
    let mut builder = MeshBuilder::new(scale, PALETTE);
    shell::build(&mut builder);
    arcade::build(&mut builder);
    court::build(&mut builder);
    builder.finish()
}
