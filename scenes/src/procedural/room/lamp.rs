//! The pendant lamp: a thin cord that sags from an outlet to a hook over the table, and the shade below it.

use super::*;

/// Radius of the power cord in metres.
const CORD_RADIUS: f64 = 0.003;
/// Where the cord comes out of the ceiling.
const OUTLET: DVec3 = dvec3(1.35, MAX.y, 1.0);
/// Height of the hook that the cord hangs over.
const HOOK: f64 = 2.9;
/// Height at which the cord enters the lamp.
const NECK: f64 = 1.83;
/// The catenary's parameter in metres: small sags deep.
const SAG: f64 = 2.1;

pub(super) fn build(builder: &mut MeshBuilder) {
    let hook = dvec3(TABLE.x, HOOK, TABLE.z);
    cord(builder, hook);

    // The hook is a ring around the cord on a short stem.
    builder.frame = Frame::at(hook + DVec3::Y * 0.004).roll(TURN / 4.0);
    builder.torus(METAL, [10, 24, 3], DVec3::ZERO, [0.014, 0.0035]);
    builder.frame = Frame::at(hook);
    builder.tube(METAL, [10, 6, 1], |t| DVec3::Y * mix(0.016, MAX.y - HOOK + 0.01, t), |_| 0.004);
    builder.frame = Frame::at(OUTLET);
    let canopy = [[0.0, -0.03], [0.02, -0.03], [0.05, -0.012], [0.055, 0.01], [0.0, 0.01]];
    builder.revolve_straight(METAL, [32, 2], &canopy);
    shade(builder);
}

/// From the outlet along a catenary to the hook, then down with the faint wave of a cord that was once coiled.
fn cord(builder: &mut MeshBuilder, hook: DVec3) {
    let from = OUTLET - DVec3::Y * 0.025;
    let across = dvec3(hook.x - from.x, 0.0, hook.z - from.z);
    let span = across.length();
    // The lowest point lies where the catenary through both ends has it; found by halving, 60 steps are exact to f64.
    let rise = |low: f64| SAG * (libm::cosh((span - low) / SAG) - libm::cosh(low / SAG));
    let (mut left, mut right) = (-2.0 * span, 3.0 * span);
    for _ in 0..60 {
        let middle = (left + right) / 2.0;
        // `rise` falls as the lowest point moves towards the hook.
        if rise(middle) > hook.y - from.y {
            left = middle;
        } else {
            right = middle;
        }
    }
    let low = left;
    let sagging = |t: f64| {
        let height = SAG * (libm::cosh((t * span - low) / SAG) - libm::cosh(low / SAG));
        from + across * t + DVec3::Y * height
    };
    builder.tube(BLACK, [10, 90, 8], sagging, |_| CORD_RADIUS);
    let hanging = |t: f64| {
        let wave = 0.006 * t * (1.0 - t);
        let angle = 3.0 * TURN * t;
        dvec3(hook.x + wave * sin(angle), mix(hook.y + 0.002, NECK - 0.01, t), hook.z + wave * cos(angle))
    };
    builder.tube(BLACK, [10, 60, 8], hanging, |_| CORD_RADIUS);
}

fn shade(builder: &mut MeshBuilder) {
    builder.frame = Frame::at(dvec3(TABLE.x, NECK, TABLE.z));
    let socket = [[0.0, -0.075], [0.018, -0.075], [0.02, -0.01], [0.008, 0.004], [0.0, 0.004]];
    builder.revolve_straight(METAL, [20, 2], &socket);
    // A thin bell: from the top down its inside, around the rim, and up its outside.
    let bell = knots(
        [0.0, 0.05, 0.11, 0.16, 0.192, 0.195, 0.197, 0.165, 0.114, 0.052, 0.0],
        [-0.03, -0.036, -0.07, -0.14, -0.22, -0.221, -0.218, -0.136, -0.064, -0.031, -0.025],
    );
    builder.revolve_smooth(SHADE, [48, 28, 10], &bell);
    builder.ball(BULB, dvec3(0.0, -0.112, 0.0), 0.042, 28);
}
