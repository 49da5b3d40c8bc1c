//! Cases of what users of engines report: halos at half resolution, views that are narrow or wide, scenes far from the origin.

use glam::{DVec3, Vec3, dvec3};
use tracebench_api::Viewpoint;

use super::Drawn;
use super::sketch::{Camera, PIXEL, RAYS, Sketch};
use crate::truth::Ray64;

pub(super) const DRAWN: &[Drawn] = &[
    ("half-resolution", half_resolution, |probe, index| {
        let (view, ray) = (probe.view(), probe.ray(index));
        let Some(at) = view.project(ray.at(1.0)) else { return false };
        let direction = view.direction_through(at.x.floor() + 0.5, at.y.floor() + 0.5);
        let sampled = probe.truth.closest(&Ray64 { direction, ..ray });
        sampled.map(|hit| hit.primitive / 2) != probe.hit(index).map(|hit| hit.primitive / 2)
    }),
    ("field-of-view", field_of_view, |probe, index| {
        let view = probe.view();
        let cosine = |point: DVec3| (point - view.eye).normalize().dot(view.forward);
        probe.point(index).is_some_and(|point| cosine(point) < 75.0_f64.to_radians().cos())
    }),
    ("off-origin", off_origin, |probe, index| {
        probe.point(index).is_some_and(|point| point.length() > 50.0 * probe.truth.diagonal())
    }),
];

fn half_resolution(sketch: &mut Sketch, edge: f64) {
    const RAY_IMAGE: u32 = 256;
    // The wall fills the upper half.
    sketch.plate(dvec3(-2.4, 0.0, -4.0), DVec3::X * 4.8, dvec3(0.0, 2.4, -0.2));
    let mut borders = Vec::new();
    for place in 0..9 {
        let at = |step: i32| 0.34 * f64::from(step - 1);
        let centre = 2.0 * dvec3(at(place % 3), at(place / 3), -1.0);
        // Turned in the image, so that no border runs along its rows.
        let (sine, cosine) = (0.2 + 0.4 * sketch.unit()).sin_cos();
        let (along, upward) = (dvec3(cosine, sine, 0.1) * 0.2, dvec3(-sine, cosine, 0.05) * 0.2);
        sketch.plate_around(centre, along, upward);
        for (side, other) in [(along, upward), (-along, upward), (upward, along), (-upward, along)] {
            borders.push((centre + side, other));
        }
    }
    let frame = RAY_IMAGE / edge as u32;
    sketch.camera = Camera { frame: [frame; 2], face: frame, ..Camera::default() };
    let image = Viewpoint { frame: [RAY_IMAGE; 2], ..sketch.viewpoint() }.frame_view();
    for index in 0..RAYS {
        let (middle, half) = borders[index % borders.len()];
        let near = middle + half * sketch.signed();
        let near = near + dvec3(sketch.signed(), sketch.signed(), 0.0) * (12.0 * PIXEL);
        if let Some(at) = image.project(near) {
            sketch.towards(image.eye, image.eye + image.direction_through(at.x.floor() + 0.5, at.y.floor() + 0.5));
        }
    }
}

fn field_of_view(sketch: &mut Sketch, degrees: f64) {
    sketch.camera.vertical_fov = degrees.to_radians() as f32;
    side_by_side(sketch);
}

/// Plates, one a cell of the image, none before another; rays of which half go through pixel centres, half from before all plates onto one
/// or between two, with an image that stays near.
fn side_by_side(sketch: &mut Sketch) {
    const CELLS: usize = 6;
    let half = (0.5 * f64::from(sketch.camera.vertical_fov)).tan();
    let cell = 2.0 * half / CELLS as f64;
    let eye = sketch.eye();
    let mut plates = Vec::new();
    for place in 0..CELLS * CELLS {
        let at = |step: usize| (step as f64 + 0.5) * cell - half;
        let depth = 2.0 + sketch.unit();
        let centre = dvec3(at(place % CELLS), at(place / CELLS), -1.0) * depth;
        // So little that at the rim of a wide view no plate gets before another.
        let slant = depth * (0.05 * cell).min(0.025);
        let along = dvec3(0.3 * cell * depth, 0.0, slant * sketch.signed());
        let upward = dvec3(0.0, 0.3 * cell * depth, slant * sketch.signed());
        sketch.plate_around(eye + centre, along, upward);
        plates.push((centre, along, upward));
    }
    sketch.through_centres(RAYS / 2);
    for index in 0..RAYS / 2 {
        let (centre, along, upward) = plates[index / 2 % plates.len()];
        let to_middle = dvec3(-centre.x.signum(), -centre.y.signum(), 0.0);
        let target = match index % 2 {
            0 => centre + along * (0.8 * sketch.signed()) + upward * (0.8 * sketch.signed()),
            // The corner of its cell.
            _ => centre - to_middle * (0.5 * cell * centre.z),
        };
        let start = target / -target.z + to_middle * dvec3(sketch.unit(), sketch.unit(), 0.0) * (0.5 * cell);
        sketch.towards(eye + start, eye + target);
    }
}

fn off_origin(sketch: &mut Sketch, distance: f64) {
    let mut at_origin = Sketch::new(sketch.seed);
    side_by_side(&mut at_origin);
    let eye = (dvec3(0.48, -0.6, 0.64) * distance * at_origin.diagonal()).as_vec3();
    sketch.camera = Camera { eye, target: eye + Vec3::NEG_Z, ..Camera::default() };
    side_by_side(sketch);
}
