//! The scene `candy`: sweets in the open, most of them curved, and two figures that move among them.
//!
//! A stand-in for the still life of VVP16's Table 1 (3 layers on average, at most 30) and for the scenes of sweets and
//! toys that papers on animated scenes show; their models are not public. What they share is many curved things of all
//! sizes close to each other, glass with things in it, and an open sky. Everything stands on, and a little in, a closed
//! ground. The animation is a loop.

mod figures;
mod jar;
mod layout;
mod sticks;
mod sweets;

use glam::dvec3;

use self::layout::Layout;
use super::builder::{Ends, MaterialId, MeshBuilder, palette};
use super::math::{Frame, TURN, cos, sin};
use super::{Built, NamedPose, cameras, path};

/// Triangles at scale 1, held by a test.
pub(crate) const TRIANGLES_AT_SCALE_1: u64 = 420_836;
/// Length of the animation in seconds.
pub(crate) const DURATION_S: f64 = 4.0;

/// Radius of the ground in metres.
const GROUND: f64 = 6.0;

palette! {
    ground: [0.62, 0.8, 0.6];
    white: [0.93, 0.91, 0.87], 0.0, 0.3;
    red: [0.78, 0.08, 0.1], 0.0, 0.2;
    pink: [0.92, 0.42, 0.58], 0.0, 0.3;
    orange: [0.93, 0.45, 0.08], 0.0, 0.2;
    yellow: [0.95, 0.8, 0.15], 0.0, 0.2;
    green: [0.2, 0.66, 0.18], 0.0, 0.2;
    blue: [0.15, 0.38, 0.82], 0.0, 0.2;
    violet: [0.5, 0.2, 0.68], 0.0, 0.2;
    dough: [0.55, 0.3, 0.13];
    chocolate: [0.2, 0.1, 0.05], 0.0, 0.5;
    glass: [0.8, 0.88, 0.9], 0.0, 0.02;
    gold: [0.95, 0.76, 0.36], 1.0, 0.06;
    silver: [0.92, 0.92, 0.94], 1.0, 0.02;
}

impl Palette {
    /// One of the colours, in turn.
    fn sweet(&self, number: usize) -> MaterialId {
        [self.red, self.yellow, self.green, self.pink, self.blue, self.orange, self.violet][number % 7]
    }
}

/// The scene under construction.
struct Candy {
    builder: MeshBuilder,
    palette: Palette,
    layout: Layout,
    time_s: f64,
}

impl Candy {
    /// Begins an object on the ground, turned about the vertical.
    fn place(&mut self, name: &str, [x, z]: [f64; 2], yaw: f64) {
        self.builder.object(name);
        self.builder.frame = Frame::at(dvec3(x, height(x, z), z)).yaw(yaw);
    }
}

/// Height of the ground, which rolls gently, in metres.
fn height(x: f64, z: f64) -> f64 {
    0.05 * sin(0.9 * x + 0.4) * cos(0.8 * z) + 0.03 * sin(1.7 * z - 0.6 * x)
}

/// Builds the scene with about `scale` times its triangles at scale 1, at a time in seconds.
pub(crate) fn build(scale: f64, time_s: f64) -> Built {
    let mut builder = MeshBuilder::new(scale);
    let palette = Palette::new(&mut builder);
    let layout = Layout::around(&VIEWPOINTS);
    let mut candy = Candy { builder, palette, layout, time_s };
    ground(&mut candy);
    figures::build(&mut candy);
    jar::build(&mut candy);
    sticks::build(&mut candy);
    sweets::build(&mut candy);
    Built { mesh: candy.builder.finish(), cameras: cameras(&VIEWPOINTS), path: path(&PATH) }
}

/// A round slab with a rolling upper side.
fn ground(candy: &mut Candy) {
    let Candy { builder, palette, .. } = candy;
    builder.object("ground");
    let across = builder.divide(44, 4);
    let below = builder.along(4);
    let ends = Ends::Closed(dvec3(0.0, -0.4, 0.0), dvec3(0.0, height(0.0, 0.0), 0.0));
    let around = builder.divide(110, 16);
    builder.rings(palette.ground, below + across, around, &ends, |ring, at| {
        let angle = TURN * at as f64 / around as f64;
        let under = ring < below;
        let share =
            if under { (ring + 1) as f64 / below as f64 } else { (below + across - ring) as f64 / across as f64 };
        // The rim bulges, so that the two sides never meet.
        let radius = GROUND * share * if under { 0.97 } else { 1.0 };
        let (x, z) = (radius * cos(angle), -radius * sin(angle));
        dvec3(x, if under { -0.4 } else { height(x, z) }, z)
    });
}

const VIEWPOINTS: [NamedPose; 6] = [
    ("figure", [0.75, 0.8, 0.85], [-0.35, 0.62, -0.3]),
    ("clearing", [1.5, 0.75, 1.9], [-0.2, 0.62, -0.2]),
    ("jar", [-2.2, 0.7, 1.5], [-1.4, 0.5, 0.3]),
    ("ground", [2.6, 0.25, -0.8], [-0.4, 0.55, 0.0]),
    ("above", [1.2, 4.2, 2.6], [0.0, 0.2, -0.1]),
    ("outside", [-4.6, 1.9, 5.6], [0.0, 0.6, 0.0]),
];

/// Through the clearing, around the figures.
const PATH: [([f32; 3], [f32; 3]); 5] = [
    ([1.5, 0.75, 1.9], [-0.2, 0.62, -0.2]),
    ([0.2, 0.95, 2.0], [-0.3, 0.6, -0.2]),
    ([-0.9, 1.1, 1.6], [-0.3, 0.6, -0.3]),
    ([-1.3, 1.5, -0.6], [0.0, 0.5, -0.3]),
    ([-0.6, 2.2, -1.9], [0.2, 0.4, 0.0]),
];
