//! The scene `atrium`: a court of 18 x 10 metres between colonnades on two storeys, with galleries behind them.
//!
//! A stand-in for the atrium of the Sponza palace, which nearly every paper on ray tracing in image space shows: long
//! rows of columns and arches, balustrades, drapes and vases, seen along and through. The court ends in a painted sky.

mod arcade;
mod court;
mod shell;

use glam::DVec3;

use super::builder::{MaterialId, MeshBuilder, palette};
use super::math::{Frame, TURN};
use super::{Built, NamedPose, cameras, path};

/// Triangles at scale 1, held by a test.
pub(crate) const TRIANGLES_AT_SCALE_1: u64 = 264_216;

/// Half the court between the middles of its columns, along x and z, in metres.
const COURT: [f64; 2] = [9.0, 5.0];
/// Depth of the galleries from there to the outer walls.
const GALLERY: f64 = 4.0;
/// Floors of the storeys, and the sky above the court.
const FLOORS: [f64; 2] = [0.0, 5.0];
const SKY: f64 = 12.5;
/// How deep things are sunk into what they stand on.
const SUNK: f64 = 0.01;

palette! {
    wall: [0.72, 0.63, 0.5];
    floor: [0.5, 0.46, 0.4];
    tile[2]: [[0.62, 0.57, 0.48], [0.42, 0.36, 0.3]];
    sky: [0.55, 0.74, 0.95];
    stone: [0.74, 0.68, 0.58];
    marble: [0.82, 0.79, 0.73];
    trim: [0.66, 0.56, 0.43];
    wood: [0.36, 0.23, 0.13];
    clay: [0.62, 0.33, 0.2];
    leaf: [0.16, 0.4, 0.12];
    flame: [0.98, 0.82, 0.45];
    cloth[3]: [[0.62, 0.1, 0.08], [0.12, 0.22, 0.5], [0.14, 0.4, 0.2]];
    iron: [0.25, 0.25, 0.26], 1.0, 0.5;
    bronze: [0.8, 0.6, 0.35], 1.0, 0.08;
    water: [0.72, 0.8, 0.85], 1.0, 0.0;
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
pub(crate) fn build(scale: f64, _time_s: f64) -> Built {
    let mut builder = MeshBuilder::new(scale);
    let palette = Palette::new(&mut builder);
    shell::build(&mut builder, &palette);
    arcade::build(&mut builder, &palette);
    court::build(&mut builder, &palette);
    Built { mesh: builder.finish(), cameras: cameras(&VIEWPOINTS), path: path(&PATH) }
}

const VIEWPOINTS: [NamedPose; 6] = [
    ("court", [-7.2, 1.8, 2.0], [4.0, 3.3, -1.2]),
    ("colonnade", [-11.2, 1.7, 6.9], [3.0, 2.4, 1.0]),
    ("gallery", [-11.3, 6.6, -6.9], [4.0, 4.6, 1.5]),
    ("fountain", [2.6, 1.5, 2.9], [-0.5, 0.9, -0.6]),
    ("arches", [11.4, 1.6, -7.2], [-6.0, 2.6, -7.0]),
    ("roof", [8.0, 10.6, 3.9], [-3.0, 2.0, -2.0]),
];

/// Through the colonnade into the court and around the fountain.
const PATH: [([f32; 3], [f32; 3]); 5] = [
    ([-11.2, 1.7, 6.9], [3.0, 2.4, 1.0]),
    ([-7.5, 1.7, 6.6], [2.0, 2.2, 0.0]),
    ([-7.0, 1.7, 2.2], [3.0, 2.5, -1.0]),
    ([-2.0, 1.8, 3.2], [4.0, 3.0, -2.0]),
    ([4.0, 2.0, 3.2], [-4.0, 3.4, -2.0]),
];
