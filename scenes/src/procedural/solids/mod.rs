//! The scene `solids`: closed objects that stand apart in a hollow dome, for rays that go into what they hit.
//!
//! A stand-in for the pool of VVP16's Table 1 (4 layers on average, at most 20), whose model is not public: what the
//! two share is the depth of their layers and that refraction matters. Every surface is closed and none cuts another,
//! so that "inside" has one meaning everywhere. Some solids are in solids: bubbles of another material (counted twice),
//! and voids in shells.

mod fine;
mod nested;
mod turned;

use glam::dvec3;

use super::builder::{MaterialId, MeshBuilder, palette};
use super::math::Frame;
use super::shapes::straight_profile;
use super::{Built, NamedPose, cameras, path};

/// Triangles at scale 1, held by a test.
pub(crate) const TRIANGLES_AT_SCALE_1: u64 = 149_990;

/// Between what stands and what it stands on: surfaces do not touch.
const GAP: f64 = 0.002;
/// Height of the stage's upper side, in metres.
const STAGE: f64 = 0.1;
/// Radius of the dome inside, in metres.
const DOME: f64 = 5.2;

palette! {
    dome: [0.7, 0.78, 0.84], 0.0, 0.1;
    stage: [0.46, 0.43, 0.4], 0.0, 0.7;
    stone: [0.3, 0.31, 0.34], 0.0, 0.8;
    clear: [0.86, 0.9, 0.92], 0.0, 0.02;
    blue: [0.14, 0.34, 0.72], 0.0, 0.02;
    green: [0.12, 0.55, 0.3], 0.0, 0.02;
    amber: [0.88, 0.52, 0.1], 0.0, 0.02;
    rose: [0.8, 0.2, 0.28], 0.0, 0.02;
    violet: [0.45, 0.24, 0.62], 0.0, 0.02;
    chrome: [0.92, 0.92, 0.93], 1.0, 0.0;
    gold: [0.95, 0.75, 0.35], 1.0, 0.05;
    brass: [0.75, 0.62, 0.32], 1.0, 0.4;
}

impl Palette {
    /// One of the coloured glasses, in turn.
    fn glass(&self, number: usize) -> MaterialId {
        [self.blue, self.amber, self.green, self.rose, self.violet, self.clear][number % 6]
    }
}

/// The solids under construction.
struct Solids {
    builder: MeshBuilder,
    palette: Palette,
}

impl Solids {
    /// Begins an object at a place on the stage, `above` it by so many metres and turned about the vertical.
    fn place(&mut self, name: &str, [x, z]: [f64; 2], above: f64, yaw: f64) {
        self.builder.object(name);
        self.builder.frame = Frame::at(dvec3(x, STAGE + GAP + above, z)).yaw(yaw);
    }
}

/// Builds the solids with about `scale` times their triangles at scale 1; they do not move.
pub(crate) fn build(scale: f64, _time_s: f64) -> Built {
    let mut builder = MeshBuilder::new(scale);
    let palette = Palette::new(&mut builder);
    let mut solids = Solids { builder, palette };
    dome(&mut solids);
    turned::build(&mut solids);
    nested::build(&mut solids);
    fine::build(&mut solids);
    Built { mesh: solids.builder.finish(), cameras: cameras(&VIEWPOINTS), path: path(&PATH) }
}

/// A thick shell all around, with a flat floor, and a stage on it.
fn dome(solids: &mut Solids) {
    let Solids { builder, palette } = solids;
    let around = builder.divide(80, 24);
    let rows = builder.divide(24, 8);
    let across = builder.along(6);
    let profile = |radius: f64, floor: f64| {
        let mut knots = vec![[0.0, floor]];
        knots.extend((1..=across).map(|at| [radius * at as f64 / across as f64, floor]));
        knots.extend((if floor < 0.0 { 0 } else { 1 }..=rows).map(|at| {
            let angle = std::f64::consts::FRAC_PI_2 * at as f64 / rows as f64;
            let flat = if at == rows { 0.0 } else { radius * libm::cos(angle) };
            [flat, radius * libm::sin(angle)]
        }));
        straight_profile(&knots, 1)
    };
    builder.object("dome");
    builder.revolve(palette.dome, around, &profile(DOME + 0.15, -0.15));
    let mut inside = profile(DOME, 0.0);
    inside.reverse();
    builder.revolve(palette.dome, around, &inside);
    builder.object("stage");
    let stage = [[0.0, GAP], [4.7, GAP], [4.75, 0.05], [4.7, STAGE], [0.0, STAGE]];
    builder.revolve_straight(palette.stage, [around, builder.along(4)], &stage);
}

const VIEWPOINTS: [NamedPose; 6] = [
    ("entrance", [2.7, 1.7, 3.1], [-0.3, 0.75, -0.3]),
    ("center", [0.2, 1.15, 1.0], [-1.6, 0.8, -0.6]),
    ("stage", [-2.6, 0.35, 2.1], [0.6, 0.5, -0.4]),
    ("gears", [1.25, 0.9, 0.35], [2.4, 0.75, 0.0]),
    ("above", [0.4, 4.6, 0.8], [0.0, 0.2, -0.2]),
    ("shells", [-2.6, 1.2, 0.7], [-1.75, 0.85, -0.6]),
];

/// From the entrance around the middle.
const PATH: [([f32; 3], [f32; 3]); 5] = [
    ([2.7, 1.7, 3.1], [-0.3, 0.75, -0.3]),
    ([-0.3, 1.5, 3.7], [0.0, 0.8, 0.0]),
    ([-3.2, 1.6, 2.4], [-0.2, 0.8, -0.3]),
    ([-3.7, 1.9, -0.9], [0.0, 0.8, -0.2]),
    ([-1.4, 2.1, -3.6], [0.2, 0.7, 0.0]),
];
