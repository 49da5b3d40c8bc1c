//! The statue: a robed figure on a plinth, one closed surface of about 100,000 triangles at scale 1.

use super::*;

/// Height of the plinth's upper side.
const PLINTH: f64 = 0.72;
/// Height of the figure.
const HEIGHT: f64 = 1.3;

pub(super) fn build(builder: &mut MeshBuilder) {
    builder.frame = Frame::at(STATUE);
    plinth(builder);
    // The figure's face looks along its own +x; turned towards the entrance.
    builder.frame = Frame::at(STATUE + DVec3::Y * (PLINTH - 0.004)).yaw(0.64 * TURN);
    figure(builder);
}

fn plinth(builder: &mut MeshBuilder) {
    let profile = knots(
        [0.0, 0.33, 0.33, 0.31, 0.285, 0.27, 0.265, 0.275, 0.3, 0.31, 0.31, 0.305, 0.0],
        [-SUNK, -SUNK, 0.06, 0.08, 0.1, 0.14, 0.6, 0.63, 0.65, 0.67, 0.715, PLINTH, PLINTH],
    );
    builder.revolve_straight(STONE, [64, 1], &profile);
}

/// Rings around a swaying line: an ellipse that changes with height, folded like cloth below, with a face above.
fn figure(builder: &mut MeshBuilder) {
    let (around, rows) = (builder.divide(224, 8), builder.divide(206, 12));
    let center = |v: f64| dvec3(0.022 * sin(TURN * 0.9 * v) - 0.01 * v, HEIGHT * v, 0.035 * sin(TURN * 0.75 * v + 0.4));
    builder.turned(MARBLE, [rows, around], Ends::Closed(center(0.0), center(1.0)), |ring, angle| {
        // No ring lies at the very top, where the end point is.
        let v = ring as f64 / rows as f64;
        let size = radius(v, angle) * proportion(v);
        center(v) + dvec3(size.x * cos(angle), 0.0, -size.y * sin(angle))
    });
}

/// Radius of the body at share `v` of its height, without what is carved into it.
fn body(v: f64) -> f64 {
    // The crown of the head closes like a ball.
    const CROWN: f64 = 0.9;
    let crown = ((v - CROWN) / (1.0 - CROWN)).clamp(0.0, 1.0);
    let round = sqrt((1.0 - crown * crown).max(0.0));
    let body = knots(
        [0.0, 0.015, 0.05, 0.2, 0.4, 0.5, 0.62, 0.7, 0.745, 0.775, 0.8, 0.825, 0.86, 0.9, 1.0],
        [0.25, 0.262, 0.25, 0.195, 0.152, 0.146, 0.168, 0.172, 0.13, 0.07, 0.056, 0.066, 0.09, 0.098, 0.098],
    );
    round * spline(&body, v)
}

/// How much wider than deep the body is: shoulders and hips are broad, the head is long.
fn proportion(v: f64) -> DVec2 {
    let broad = knots([0.0, 0.45, 0.68, 0.76, 0.8, 0.86, 1.0], [1.0, 1.06, 1.34, 1.15, 1.0, 0.86, 0.9]);
    let broad = spline(&broad, v);
    dvec2(1.0 / sqrt(broad), broad)
}

fn radius(v: f64, angle: f64) -> f64 {
    let body = body(v);
    // -half to half a turn, 0 at the face.
    let front = if angle > TURN / 2.0 { angle - TURN } else { angle };
    body * (1.0 + robe(v, angle) + drape(v, angle) + hair(v, front)) + face(v, front)
}

/// Long folds that start at the waist, wander and deepen towards the floor.
fn robe(v: f64, angle: f64) -> f64 {
    let deep = 1.0 - smoothstep(0.06, 0.6, v);
    let wander = angle + 0.35 * sin(2.0 * angle + 5.0 * v) + 0.5 * v;
    let wide = cos(9.0 * wander + 0.8 * sin(3.0 * angle));
    // Cloth hangs in broad rounds with narrow valleys between.
    let rounds = 1.0 - 2.0 * libm::pow((1.0 - wide) / 2.0, 2.2);
    let fine = cos(22.0 * wander + 6.0 * v + sin(4.0 * angle));
    deep * (0.085 * rounds + 0.022 * fine) + 0.012 * deep * cos(41.0 * wander + 11.0 * v)
}

/// A cloth thrown over the shoulder: slanting folds around chest and waist.
fn drape(v: f64, angle: f64) -> f64 {
    let there = smoothstep(0.3, 0.46, v) * (1.0 - smoothstep(0.68, 0.76, v));
    let slant = TURN * 8.5 * v + 2.0 * sin(angle) + 1.4 * sin(2.0 * angle + 1.0);
    let folds = 1.0 - 2.0 * libm::pow((1.0 - cos(slant)) / 2.0, 1.8);
    let belt = bell(v - 0.47, 0.014) * (0.09 + 0.02 * cos(30.0 * angle));
    there * (0.045 * folds + 0.012 * cos(2.3 * slant + 3.0 * angle)) + belt
}

/// Curls over the back and the crown of the head.
fn hair(v: f64, front: f64) -> f64 {
    let line = 0.925 - 0.075 * smoothstep(0.5, 1.3, front.abs());
    let there = smoothstep(line - 0.012, line + 0.012, v) * smoothstep(0.815, 0.85, v);
    let strands = cos(26.0 * front + 9.0 * sin(TURN * 6.0 * v)) * (1.0 - smoothstep(0.965, 0.995, v));
    there * (0.07 + 0.045 * strands)
}

/// Nose, brow, eyes, lips and chin, in metres.
fn face(v: f64, front: f64) -> f64 {
    let side = front.abs();
    let nose = 0.030 * bell(side, 0.16) * bell((v - 0.872).min(0.0), 0.008) * bell((v - 0.872).max(0.0), 0.028);
    let brow = 0.008 * bell(v - 0.908, 0.009) * bell(side - 0.3, 0.35);
    let eyes = -0.011 * bell(v - 0.894, 0.011) * bell(side - 0.36, 0.17)
        + 0.006 * bell(v - 0.893, 0.005) * bell(side - 0.36, 0.11);
    let lips = 0.006 * bell(side, 0.2) * (bell(v - 0.854, 0.0035) + bell(v - 0.8465, 0.0035));
    let chin = 0.014 * bell(side, 0.4) * bell(v - 0.829, 0.011);
    nose + brow + eyes + lips + chin
}
