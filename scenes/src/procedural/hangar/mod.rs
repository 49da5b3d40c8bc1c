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

use super::prelude::*;

/// Length of the animation in seconds.
pub(crate) const DURATION_S: f64 = 4.0;

/// Half the inside along x and z, in metres.
const HALF: [f64; 2] = [30.0, 20.0];
/// Heights of eaves and ridge.
const EAVES: f64 = 13.0;
const RIDGE: f64 = 18.0;
/// How deep things are sunk into what they stand on.
const SUNK: f64 = 0.02;

palette! {
    CONCRETE: [0.5, 0.49, 0.47];
    WALL: [0.62, 0.6, 0.55];
    SHEET: [0.42, 0.47, 0.5];
    GLASS: [0.66, 0.8, 0.92];
    RED_LEAD: [0.5, 0.2, 0.13];
    YELLOW: [0.85, 0.62, 0.08];
    BLACK: [0.04, 0.04, 0.04];
    RUBBER: [0.08, 0.08, 0.085];
    WOOD: [0.6, 0.43, 0.25];
    DARK_WOOD: [0.4, 0.27, 0.15];
    GREEN: [0.18, 0.33, 0.22];
    BLUE: [0.14, 0.26, 0.46];
    WHITE: [0.85, 0.85, 0.83];
    LAMP: [0.98, 0.95, 0.82];
    STEEL: [0.45, 0.46, 0.48], 1.0, 0.4;
    POLISHED: [0.86, 0.87, 0.88], 1.0, 0.06;
    PUDDLE: [0.3, 0.32, 0.34], 1.0, 0.0;
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
        let eased = 0.5 - 0.5 * cos(TURN / 2.0 * time_s / DURATION_S);
        Self { bridge: 7.0 * eased, trolley: -5.0 * eased, rolled: 9.0 * eased, propeller: TURN * 0.85 * time_s }
    }
}

/// Builds the hangar with about `scale` times its triangles at scale 1 as it stands at `time_s`.
pub(crate) fn build(scale: f64, time_s: f64) -> Mesh {
    let motion = Motion::at(time_s);
    let mut builder = MeshBuilder::new(scale, PALETTE);
    shell::build(&mut builder);
    steel::build(&mut builder);
    crane::build(&mut builder, &motion);
    catwalk::build(&mut builder);
    aircraft::build(&mut builder, &motion);
    dock::build(&mut builder);
    ground::build(&mut builder, &motion);
    machinery::build(&mut builder);
    builder.finish()
}
