//! Cases about what users of screen-space effects meet most: things that float before what a ray passes, rays that come towards the
//! camera, foregrounds beside a ray's way, ways that are long on the image.

use glam::{DVec3, dvec3};

use super::sketch::{Camera, PIXEL, RAYS, Sketch};
use super::{Drawn, Probe};
use crate::truth::Ray64;

pub(super) const DRAWN: &[Drawn] = &[
    ("behind-foreground", behind_foreground, |probe, index| {
        let ray = probe.ray(index);
        let gap = -FLOATING - ray.at(-ray.origin.x / ray.direction.x).z;
        probe.hit(index).is_none() && gap > 0.0 && gap < 0.0015 * probe.truth.diagonal()
    }),
    (
        "towards-camera",
        |sketch, angle| near_line_of_sight(sketch, angle, 1.0, [2.5, 1.0, 1.2]),
        |probe, index| cosine_to_eye(probe, index).is_some_and(|cosine| cosine > 1.0_f64.to_radians().cos()),
    ),
    (
        "away-from-camera",
        |sketch, angle| near_line_of_sight(sketch, angle, -1.0, [4.0, 0.5, 2.5]),
        |probe, index| cosine_to_eye(probe, index).is_some_and(|cosine| -cosine > 0.2_f64.to_radians().cos()),
    ),
    ("foreground-in-cell", foreground_in_cell, |probe, index| {
        let view = probe.view();
        let point = probe.ray(index).at(0.3);
        let Some(at) = view.project(point) else { return false };
        let direction = view.direction_through(at.x - 1.5, at.y);
        let beside = Ray64 { origin: view.eye, direction, t_min: view.near, t_max: 0.6 * at.depth };
        probe.truth.closest(&beside).is_some()
    }),
    ("long-rays", long_rays, |probe, index| {
        let view = probe.view();
        let ends = view.project(probe.ray(index).origin).zip(probe.point(index).and_then(|point| view.project(point)));
        ends.is_some_and(|(begin, end)| (end.x - begin.x).abs() > 4096.0)
    }),
];

/// Eye depth of the plate that floats before rays.
const FLOATING: f64 = 2.0;

fn behind_foreground(sketch: &mut Sketch, gap: f64) {
    const HALF_WIDTH: f64 = 0.15;
    sketch.widen([dvec3(-1.0, -1.0, -3.0), dvec3(1.0, 1.0, -1.0)]);
    sketch.plate_around(DVec3::NEG_Z * FLOATING, DVec3::X * HALF_WIDTH, DVec3::Y * 0.8);
    let gap = gap * sketch.diagonal();
    for index in 0..RAYS {
        if index % 4 == 0 {
            let target = dvec3(0.9 * HALF_WIDTH * sketch.signed(), 0.7 * sketch.signed(), -FLOATING);
            let from = dvec3(0.5 * sketch.signed(), 0.3 * sketch.signed(), -1.2);
            sketch.towards(from, target);
        } else {
            let behind = dvec3(0.9 * HALF_WIDTH * sketch.signed(), 0.5 * sketch.signed(), -FLOATING - gap);
            let side = if index % 2 == 0 { 1.0 } else { -1.0 };
            // Over the plate's half width a fifth of the gap deeper or less deep.
            let along = dvec3(side, 0.2 * sketch.signed(), 0.2 * gap / HALF_WIDTH * sketch.signed());
            sketch.towards(behind - along * 0.8, behind);
        }
    }
}

/// Of the angle between a ray and the way from its hit to the eye.
fn cosine_to_eye(probe: &Probe<'_>, index: usize) -> Option<f64> {
    let to_eye = |point: DVec3| (probe.view().eye - point).normalize();
    probe.point(index).map(|point| probe.ray(index).direction.dot(to_eye(point)))
}

/// Rays onto a plate at a depth, of a size and from so far away, at an angle to the way to the eye (`sign` 1) or from it (-1).
fn near_line_of_sight(sketch: &mut Sketch, angle: f64, sign: f64, [depth, size, length]: [f64; 3]) {
    let centre = dvec3(0.0, 0.0, -depth);
    let (along, upward) = (dvec3(0.5, 0.0, -0.5) * size, DVec3::Y * (0.7 * size));
    sketch.widen([dvec3(-1.5, -1.5, -4.5), dvec3(1.5, 1.5, -0.5)]);
    sketch.plate_around(centre, along, upward);
    // Finer than the reference pixels that hits are judged by.
    sketch.camera.frame = [1024, 1024];
    let (aside, towards) = angle.to_radians().sin_cos();
    for index in 0..RAYS {
        // A third passes beside the plate.
        let across = if index % 3 == 0 { 1.3 + 0.2 * sketch.unit() } else { 0.9 * sketch.signed() };
        let side = if sketch.unit() < 0.5 { 1.0 } else { -1.0 };
        let target = centre + along * (across * side) + upward * (0.9 * sketch.signed());
        let to_eye = (sketch.eye() - target).normalize();
        let up = DVec3::Y * if sketch.unit() < 0.5 { 1.0 } else { -1.0 };
        let square = (up - to_eye * up.dot(to_eye)).normalize();
        sketch.towards(target - (to_eye * (sign * towards) + square * aside) * length, target);
    }
}

/// A post's right border, columns of the default frame: odd, so that the first cell of a pyramid has pixels of both its sides.
const POST_BORDER: f64 = 141.0;

fn foreground_in_cell(sketch: &mut Sketch, pixels: f64) {
    let column = |at: f64| (at - 128.0) * PIXEL;
    sketch.plate(dvec3(column(POST_BORDER - 28.0), -0.45, -1.0), DVec3::X * (28.0 * PIXEL), DVec3::Y * 0.9);
    sketch.plate(dvec3(-2.0, -2.0, -4.0), DVec3::X * 4.0, DVec3::Y * 4.0);
    for index in 0..RAYS {
        let across = column(POST_BORDER + pixels + 0.9 * sketch.unit());
        let side = if sketch.unit() < 0.5 { 1.0 } else { -1.0 };
        let [low, high] = [-0.3, 0.3].map(|end| dvec3(across, side * (end + 0.08 * sketch.signed()), -1.0));
        let [near, far] = if index % 2 == 0 { [2.2, 4.2] } else { [3.0, 3.0] };
        sketch.towards(low * near, high * far);
    }
}

/// Of long ways, pixels.
const LONG_FRAME: [u32; 2] = [6144, 24];

fn long_rays(sketch: &mut Sketch, length: f64) {
    const DEPTH: f64 = 2.0;
    const POST: [f64; 2] = [5800.0, 5816.0];
    let [width, height] = LONG_FRAME.map(f64::from);
    // 90 degrees across: from -1 to 1 at depth 1.
    let pixel = 2.0 / width;
    let at = |column: f64, row: f64| dvec3((column - 0.5 * width) * pixel, row * pixel, -1.0);
    sketch.widen([dvec3(-1.0, -0.5, -3.0), dvec3(2.0, 0.5, -1.0)]);
    let (low, high) = (at(POST[0], -8.0) * DEPTH, at(POST[1], 8.0) * DEPTH);
    sketch.plate(low, DVec3::X * (high.x - low.x), DVec3::Y * (high.y - low.y));
    let vertical_fov = 2.0 * ((height / width) as f32).atan();
    sketch.camera = Camera { frame: LONG_FRAME, vertical_fov, ..Camera::default() };
    for index in 0..RAYS {
        let column = POST[0] + 2.0 + 12.0 * sketch.unit();
        // A quarter passes over the post.
        let row = if index % 4 == 0 { 9.5 + 1.5 * sketch.unit() } else { 7.0 * sketch.signed() };
        let from = row + 0.4 * sketch.signed();
        let origin = at(column - length, from) * (1.3 + 0.2 * sketch.unit());
        sketch.towards(origin, at(column, row) * DEPTH);
    }
}
