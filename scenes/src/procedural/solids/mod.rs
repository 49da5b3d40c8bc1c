//! The scene `solids`: closed objects that stand apart in a hollow dome, for rays that go into what they hit.
//!
//! A stand-in for the pool of VVP16's Table 1 (4 layers on average, at most 20), whose model is not public: what the
//! two share is the depth of their layers and that refraction matters. Every surface is closed and none cuts another,
//! so that "inside" has one meaning everywhere. Some solids are in solids: bubbles of another material (counted twice),
//! and voids in shells.

mod fine;
mod nested;
mod turned;

use super::prelude::*;

/// Between what stands and what it stands on: surfaces do not touch.
const GAP: f64 = 0.002;
/// Height of the stage's upper side, in metres.
const STAGE_TOP: f64 = 0.1;
/// Radius of the dome inside, in metres.
const DOME_RADIUS: f64 = 5.2;

palette! {
    DOME: [0.7, 0.78, 0.84], 0.0, 0.1;
    STAGE: [0.46, 0.43, 0.4], 0.0, 0.7;
    STONE: [0.3, 0.31, 0.34], 0.0, 0.8;
    CLEAR: [0.86, 0.9, 0.92], 0.0, 0.02;
    BLUE: [0.14, 0.34, 0.72], 0.0, 0.02;
    GREEN: [0.12, 0.55, 0.3], 0.0, 0.02;
    AMBER: [0.88, 0.52, 0.1], 0.0, 0.02;
    ROSE: [0.8, 0.2, 0.28], 0.0, 0.02;
    VIOLET: [0.45, 0.24, 0.62], 0.0, 0.02;
    CHROME: [0.92, 0.92, 0.93], 1.0, 0.0;
    GOLD: [0.95, 0.75, 0.35], 1.0, 0.05;
    BRASS: [0.75, 0.62, 0.32], 1.0, 0.4;
}

/// One of the coloured glasses, in turn.
fn glass(number: usize) -> MaterialId {
    [BLUE, AMBER, GREEN, ROSE, VIOLET, CLEAR][number % 6]
}

/// Begins an object at a place on the stage, `above` it by so many metres and turned about the vertical.
fn place(builder: &mut MeshBuilder, name: &str, [x, z]: [f64; 2], above: f64, yaw: f64) {
    builder.object_at(name, Frame::at(dvec3(x, STAGE_TOP + GAP + above, z)).yaw(yaw));
}

/// Builds the solids with about `scale` times their triangles at scale 1; they do not move.
pub(crate) fn build(scale: f64, _time_s: f64) -> Mesh {
    let mut builder = MeshBuilder::new(scale, PALETTE);
    dome(&mut builder);
    turned::build(&mut builder);
    nested::build(&mut builder);
    fine::build(&mut builder);
    builder.finish()
}

/// A thick shell all around, with a flat floor, and a stage on it.
fn dome(builder: &mut MeshBuilder) {
    let (around, rows) = (builder.divide(80, 24), builder.divide(24, 8));
    let across = builder.along(6);
    let profile = |radius: f64, floor: f64| {
        let mut knots = vec![[0.0, floor]];
        knots.extend((1..=across).map(|at| [radius * at as f64 / across as f64, floor]));
        knots.extend((if floor < 0.0 { 0 } else { 1 }..=rows).map(|at| {
            let angle = TURN / 4.0 * at as f64 / rows as f64;
            let flat = if at == rows { 0.0 } else { radius * cos(angle) };
            [flat, radius * sin(angle)]
        }));
        straight_profile(&knots, 1)
    };
    builder.object("dome");
    builder.lathe(DOME, around, &profile(DOME_RADIUS + 0.15, -0.15));
    let mut inside = profile(DOME_RADIUS, 0.0);
    inside.reverse();
    builder.lathe(DOME, around, &inside);
    builder.object("stage");
    let stage = [[0.0, GAP], [4.7, GAP], [4.75, 0.05], [4.7, STAGE_TOP], [0.0, STAGE_TOP]];
    builder.lathe(STAGE, around, &straight_profile(&stage, builder.along(4)));
}
