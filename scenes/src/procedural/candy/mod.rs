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

use super::prelude::*;

use self::layout::Layout;
use crate::catalogue::viewpoints;

/// Length of the animation in seconds.
pub(crate) const DURATION_S: f64 = 4.0;

/// Radius of the ground in metres.
const GROUND_RADIUS: f64 = 6.0;

palette! {
    GROUND: [0.62, 0.8, 0.6];
    WHITE: [0.93, 0.91, 0.87], 0.0, 0.3;
    RED: [0.78, 0.08, 0.1], 0.0, 0.2;
    PINK: [0.92, 0.42, 0.58], 0.0, 0.3;
    ORANGE: [0.93, 0.45, 0.08], 0.0, 0.2;
    YELLOW: [0.95, 0.8, 0.15], 0.0, 0.2;
    GREEN: [0.2, 0.66, 0.18], 0.0, 0.2;
    BLUE: [0.15, 0.38, 0.82], 0.0, 0.2;
    VIOLET: [0.5, 0.2, 0.68], 0.0, 0.2;
    DOUGH: [0.55, 0.3, 0.13];
    CHOCOLATE: [0.2, 0.1, 0.05], 0.0, 0.5;
    GLASS: [0.8, 0.88, 0.9], 0.0, 0.02;
    GOLD: [0.95, 0.76, 0.36], 1.0, 0.06;
    SILVER: [0.92, 0.92, 0.94], 1.0, 0.02;
}

/// One of the colours, in turn.
fn sweet(number: usize) -> MaterialId {
    [RED, YELLOW, GREEN, PINK, BLUE, ORANGE, VIOLET][number % 7]
}

/// Begins an object on the ground, turned about the vertical.
fn place(builder: &mut MeshBuilder, name: &str, [x, z]: [f64; 2], yaw: f64) {
    builder.object_at(name, Frame::at(dvec3(x, height(x, z), z)).yaw(yaw));
}

/// Height of the ground, which rolls gently, in metres.
fn height(x: f64, z: f64) -> f64 {
    0.05 * sin(0.9 * x + 0.4) * cos(0.8 * z) + 0.03 * sin(1.7 * z - 0.6 * x)
}

/// Builds the scene with about `scale` times its triangles at scale 1, at a time in seconds.
pub(crate) fn build(scale: f64, time_s: f64) -> Mesh {
    let mut builder = MeshBuilder::new(scale, PALETTE);
    let mut layout = Layout::around(viewpoints("candy"));
    ground(&mut builder);
    figures::build(&mut builder, &mut layout, time_s);
    jar::build(&mut builder, &mut layout);
    sticks::build(&mut builder, &mut layout);
    sweets::build(&mut builder, &mut layout);
    builder.finish()
}

/// A round slab with a rolling upper side.
fn ground(builder: &mut MeshBuilder) {
    builder.object("ground");
    let (around, across, below) = (builder.divide(110, 16), builder.divide(44, 4), builder.along(4));
    let ends = Ends::Closed(DVec3::Y * -0.4, DVec3::Y * height(0.0, 0.0));
    builder.turned(GROUND, [below + across, around], ends, |ring, angle| {
        let under = ring < below;
        let share =
            if under { (ring + 1) as f64 / below as f64 } else { (below + across - ring) as f64 / across as f64 };
        // The rim bulges, so that the two sides never meet.
        let radius = GROUND_RADIUS * share * if under { 0.97 } else { 1.0 };
        let (x, z) = (radius * cos(angle), -radius * sin(angle));
        dvec3(x, if under { -0.4 } else { height(x, z) }, z)
    });
}
