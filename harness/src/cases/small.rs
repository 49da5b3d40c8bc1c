//! Cases about what is smaller than a pixel.

use glam::{DVec3, dvec3};
use tracebench_api::{Query, TracerError};

use super::sketch::{Camera, CaseRays, PIXEL, RAYS, Sketch};
use super::{Case, Feature, Probe, Setup, turned};

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
    make: wires,
    feature: Feature::of("hit something thinner than half a pixel", 0.3, below_a_pixel),
};

fn wires(width: f64) -> Result<Setup, TracerError> {
    const WIRES: u32 = 20;
    let width = width * PIXEL * DEPTH;
    let slant = dvec3(0.3, 3.6, 0.2);
    let foot = |wire: u32| dvec3(-1.7 + 3.4 * f64::from(wire) / f64::from(WIRES), -1.8, -DEPTH);
    let mut sketch = Sketch::default();
    for wire in 0..WIRES {
        sketch.plate(foot(wire), DVec3::X * width, slant);
    }
    let stage = sketch.seen_by(Camera::default())?;
    let mut rays_made = CaseRays::new(2);
    for index in 0..RAYS as u32 {
        let part = rays_made.unit();
        // Wires are never wider than the gaps between them.
        let across = if index % 2 == 0 { width * part } else { 0.075 + 0.085 * part };
        let target = foot(index % WIRES) + DVec3::X * across + slant * (0.02 + 0.96 * rays_made.unit());
        rays_made.towards(DVec3::ZERO, target);
    }
    Ok(stage.with(rays_made, Query::Closest))
}

pub(super) const LEAVES: Case = Case {
    name: "leaves",
    summary: "triangles scattered in any pose, ever smaller than a pixel; half of the rays aim at one",
    difficulty_parameter: turned("edge", "pixels", &[16.0, 4.0, 1.0, 0.5, 0.1]),
    make: leaves,
    feature: Feature::of("hit something smaller than half a pixel", 0.3, below_a_pixel),
};

fn leaves(edge: f64) -> Result<Setup, TracerError> {
    let edge = edge * PIXEL * DEPTH;
    let mut sketch = Sketch::default();
    let mut rays_made = CaseRays::new(3);
    let mut centres = Vec::new();
    for _ in 0..300 {
        let centre = dvec3(1.8 * rays_made.signed(), 1.8 * rays_made.signed(), -DEPTH + 0.5 * rays_made.signed());
        let (across, upward) = rays_made.direction().any_orthonormal_pair();
        let corner = |x: f64, y: f64| centre + (across * x + upward * y) * edge;
        sketch.triangle([corner(-0.5, -0.29), corner(0.5, -0.29), corner(0.0, 0.58)]);
        centres.push(centre);
    }
    let stage = sketch.seen_by(Camera::default())?;
    for index in 0..RAYS {
        let random = dvec3(1.8 * rays_made.signed(), 1.8 * rays_made.signed(), -DEPTH);
        let near_leaf = centres[index % centres.len()] + rays_made.point() * (0.1 * edge);
        rays_made.towards(DVec3::ZERO, if index % 2 == 0 { near_leaf } else { random });
    }
    Ok(stage.with(rays_made, Query::Closest))
}
