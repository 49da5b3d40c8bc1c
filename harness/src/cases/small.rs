//! Cases about what is smaller than a pixel.

use glam::{DVec3, dvec3};

use super::Drawn;
use super::sketch::{PIXEL, RAYS, Sketch};

pub(super) const DRAWN: &[Drawn] = &[
    ("wires", wires, |probe, index| probe.is_thinner(index, 0.5)),
    ("leaves", leaves, |probe, index| probe.is_thinner(index, 0.5)),
];

/// Depth at which small things stand.
const DEPTH: f64 = 4.0;

fn wires(sketch: &mut Sketch, width: f64) {
    const WIRES: u32 = 20;
    let width = width * PIXEL * DEPTH;
    let slant = dvec3(0.3, 3.6, 0.2);
    let foot = |wire: u32| dvec3(-1.7 + 3.4 * f64::from(wire) / f64::from(WIRES), -1.8, -DEPTH);
    for wire in 0..WIRES {
        sketch.plate(foot(wire), DVec3::X * width, slant);
    }
    for index in 0..RAYS as u32 {
        let part = sketch.unit();
        // Wires are never wider than the gaps between them.
        let across = if index % 2 == 0 { width * part } else { 0.075 + 0.085 * part };
        let target = foot(index % WIRES) + DVec3::X * across + slant * (0.02 + 0.96 * sketch.unit());
        sketch.towards(DVec3::ZERO, target);
    }
}

fn leaves(sketch: &mut Sketch, edge: f64) {
    let edge = edge * PIXEL * DEPTH;
    let mut centres = Vec::new();
    for _ in 0..300 {
        let centre = dvec3(1.8 * sketch.signed(), 1.8 * sketch.signed(), -DEPTH + 0.5 * sketch.signed());
        let (across, upward) = sketch.direction().any_orthonormal_pair();
        let corner = |x: f64, y: f64| centre + (across * x + upward * y) * edge;
        sketch.triangle([corner(-0.5, -0.29), corner(0.5, -0.29), corner(0.0, 0.58)]);
        centres.push(centre);
    }
    for index in 0..RAYS {
        let random = dvec3(1.8 * sketch.signed(), 1.8 * sketch.signed(), -DEPTH);
        let near_leaf = centres[index % centres.len()] + sketch.point() * (0.1 * edge);
        sketch.towards(DVec3::ZERO, if index % 2 == 0 { near_leaf } else { random });
    }
}
