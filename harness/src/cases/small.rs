//! Cases about what is smaller than a pixel.

use glam::{DVec3, dvec3};

use super::sketch::{PIXEL, RAYS, Sketch};
use super::{Case, Feature, Probe, turned};

/// Depth at which small things stand.
const DEPTH: f64 = 4.0;

fn below_a_pixel(probe: &Probe<'_>, index: usize) -> bool {
    let triangle = probe.triangle(index).zip(probe.point(index));
    triangle.is_some_and(|((_, least), point)| least < 0.5 * probe.pixel(point))
}

pub(super) const WIRES: Case = Case {
    name: "wires",
    summary: "slanted strips ever thinner than a pixel; rays from the eye between the frame's pixel centres",
    difficulty_parameter: turned("width", "pixels", &[4.0, 2.0, 1.0, 0.5, 0.2, 0.02]),
    seed: 2,
    make: wires,
    feature: Feature::of("hit something thinner than half a pixel", 0.3, below_a_pixel),
};

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

pub(super) const LEAVES: Case = Case {
    name: "leaves",
    summary: "triangles scattered in any pose, ever smaller than a pixel; half of the rays aim at one",
    difficulty_parameter: turned("edge", "pixels", &[16.0, 4.0, 1.0, 0.5, 0.1]),
    seed: 3,
    make: leaves,
    feature: Feature::of("hit something smaller than half a pixel", 0.3, below_a_pixel),
};

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
