//! The scene `hangar`: a hall of 60 x 18 x 40 metres around the origin of its floor, in which things move.
//!
//! A stand-in for the large industrial halls with oblique steelwork that papers on layered depth trace through: lattice
//! columns and trusses, an overhead crane, catwalks, cables, stacked crates, machinery and two propeller aircraft with
//! hollow fuselages. Everything that moves is rigid: crane and trolley travel with hook and load, a tractor with its
//! cart rolls, the propellers turn.

mod aircraft;
mod catwalk;
mod crane;
mod dock;
mod ground;
mod machinery;
mod shell;
mod steel;

use super::builder::{MaterialId, MeshBuilder, palette};
use super::math::{TURN, cos};
use super::{Built, NamedPose, cameras, path};

/// Triangles at scale 1, held by a test.
pub(crate) const TRIANGLES_AT_SCALE_1: u64 = 265_628;
/// Length of the animation in seconds.
pub(crate) const ANIMATION_S: f64 = 4.0;

/// Half the inside along x and z, in metres.
const HALF: [f64; 2] = [30.0, 20.0];
/// Heights of eaves and ridge.
const EAVES: f64 = 13.0;
const RIDGE: f64 = 18.0;
/// How deep things are sunk into what they stand on.
const SUNK: f64 = 0.02;

palette! {
    concrete: [0.5, 0.49, 0.47];
    wall: [0.62, 0.6, 0.55];
    sheet: [0.42, 0.47, 0.5];
    glass: [0.66, 0.8, 0.92];
    red_lead: [0.5, 0.2, 0.13];
    yellow: [0.85, 0.62, 0.08];
    black: [0.04, 0.04, 0.04];
    rubber: [0.08, 0.08, 0.085];
    wood: [0.6, 0.43, 0.25];
    dark_wood: [0.4, 0.27, 0.15];
    green: [0.18, 0.33, 0.22];
    blue: [0.14, 0.26, 0.46];
    white: [0.85, 0.85, 0.83];
    lamp: [0.98, 0.95, 0.82];
    steel: [0.45, 0.46, 0.48], 1.0, 0.4;
    polished: [0.86, 0.87, 0.88], 1.0, 0.06;
    puddle: [0.3, 0.32, 0.34], 1.0, 0.0;
}

/// How far what moves has come; all zero at rest.
struct Motion {
    /// Metres along x of the crane with all that hangs from it, and along z of its trolley.
    bridge: f64,
    trolley: f64,
    /// Metres that the tractor rolled.
    rolled: f64,
    /// Turn of the propellers in radians.
    propeller: f64,
}

impl Motion {
    fn at(time_s: f64) -> Self {
        // Starts and ends gently.
        let eased = 0.5 - 0.5 * cos(TURN / 2.0 * time_s / ANIMATION_S);
        Self { bridge: 7.0 * eased, trolley: -5.0 * eased, rolled: 9.0 * eased, propeller: TURN * 0.85 * time_s }
    }
}

/// Builds the hangar with about `scale` times its triangles at scale 1 as it stands at `time_s`.
pub(crate) fn build(scale: f64, time_s: f64) -> Built {
    let motion = Motion::at(time_s);
    let mut builder = MeshBuilder::new(scale);
    let palette = Palette::new(&mut builder);
    shell::build(&mut builder, &palette);
    steel::build(&mut builder, &palette);
    crane::build(&mut builder, &palette, &motion);
    catwalk::build(&mut builder, &palette);
    aircraft::build(&mut builder, &palette, &motion);
    dock::build(&mut builder, &palette);
    ground::build(&mut builder, &palette, &motion);
    machinery::build(&mut builder, &palette);
    Built { mesh: builder.finish(), cameras: cameras(&VIEWPOINTS), path: path(&PATH) }
}

const VIEWPOINTS: [NamedPose; 6] = [
    ("truss", [10.0, 14.8, 9.0], [-3.0, 4.0, -3.0]),
    ("gallery", [-27.0, 9.4, 15.5], [4.0, 5.0, -4.0]),
    ("gate", [28.0, 1.7, 3.0], [0.0, 4.0, -2.0]),
    ("wing", [-3.0, 1.7, 12.5], [-10.0, 3.0, 0.0]),
    ("crates", [-22.0, 1.2, -9.5], [-12.0, 2.0, -15.0]),
    ("catwalk", [6.0, 8.6, -17.2], [-6.0, 3.0, 6.0]),
];

/// From the gallery down the middle of the hall to the gate.
const PATH: [([f32; 3], [f32; 3]); 5] = [
    ([-27.0, 9.4, 15.5], [4.0, 5.0, -4.0]),
    ([-16.0, 8.0, 15.0], [2.0, 3.0, -4.0]),
    ([-3.0, 5.5, 14.5], [2.0, 3.0, -4.0]),
    ([12.0, 3.5, 14.5], [4.0, 4.0, -6.0]),
    ([27.0, 2.0, 12.0], [0.0, 5.0, -4.0]),
];
