//! Cases about what image-space structures are made of: pixels, cells, faces, and rays in special positions to them.

use glam::{DVec3, dvec3};
use tracebench_api::{View, Viewpoint};

use super::Drawn;
use super::sketch::{Camera, PIXEL, RAYS, Sketch};

pub(super) const DRAWN: &[Drawn] = &[
    ("cube-borders", cube_borders, |probe, index| {
        let direction = probe.ray(index).direction.abs();
        let (most, least) = (direction.max_element(), direction.min_element());
        let middle = direction.element_sum() - most - least;
        most - middle < 1e-6
    }),
    ("coarse-frame", coarse_frame, |probe, index| {
        let triangle = probe.triangle(index).zip(probe.point(index));
        triangle.is_some_and(|((longest, _), point)| longest < probe.pixel(point))
    }),
    ("wide-frame", wide_frame, |probe, index| probe.hit(index).is_some() && probe.view().size[1] == 1),
    ("surface-starts", surface_starts, |probe, index| {
        (probe.ray(index).origin.y + 1.0).abs() < 1e-5 * probe.truth.diagonal()
    }),
    ("cell-borders", cell_borders, |probe, index| {
        let on_border = |at: f64| (at - at.round()).abs() < 1e-3;
        let at = probe.view().project(probe.ray(index).origin);
        at.is_some_and(|at| on_border(at.x) || on_border(at.y))
    }),
    ("face-cell-borders", face_cell_borders, |probe, index| {
        let on_border = |at: f64| (at / 2.0 - (at / 2.0).round()).abs() < 5e-4;
        let at = forward_face(&probe.setup.viewpoint).project(probe.ray(index).origin);
        at.is_some_and(|at| on_border(at.x) || on_border(at.y))
    }),
    ("through-view-centre", view_centre, |probe, index| {
        let ray = probe.ray(index);
        let offset = probe.view().eye - ray.origin;
        let aside = offset - ray.direction * offset.dot(ray.direction);
        aside.length() < 1e-6 * probe.truth.diagonal()
    }),
];

fn cube_borders(sketch: &mut Sketch, off: f64) {
    sketch.sphere(DVec3::ZERO, 2.0, 12, |numbers| numbers.unit() < 0.75);
    sketch.camera.vertical_fov = 2.0;
    for index in 0..RAYS {
        let sign = |value: f64| if value < 0.0 { -1.0 } else { 1.0 };
        let corner = dvec3(sign(sketch.signed()), sign(sketch.signed()), sign(sketch.signed()));
        let border = match index % 4 {
            0 => corner,
            // Anywhere on the border between two faces.
            axis => {
                let along = [DVec3::X, DVec3::Y, DVec3::Z][axis - 1];
                corner - along * corner.dot(along) + along * sketch.signed()
            }
        };
        let origin = if index % 3 == 0 { border.as_vec3().as_dvec3() * 0.25 } else { DVec3::ZERO };
        let target = origin + border + sketch.point() * off;
        sketch.towards(origin, target);
    }
}

/// Plates in all depths.
fn plates(sketch: &mut Sketch, width: f64, height: f64) {
    for _ in 0..24 {
        let depth = 2.0 + 3.0 * sketch.unit();
        let centre = dvec3(sketch.signed() * width, sketch.signed() * height, -1.0) * depth;
        let (along, upward) =
            (dvec3(0.18 * width, 0.02 * height, 0.05), dvec3(-0.02 * width, 0.18 * height, 0.04 * height));
        sketch.plate_around(centre, along * depth, upward * depth);
    }
}

fn coarse_frame(sketch: &mut Sketch, edge: f64) {
    let edge = edge as u32;
    plates(sketch, 0.5, 0.5);
    sketch.camera = Camera { frame: [edge, edge], face: edge, ..Camera::default() };
    for _ in 0..RAYS {
        let target = dvec3(0.55 * sketch.signed(), 0.55 * sketch.signed(), -1.0);
        sketch.towards(DVec3::ZERO, target);
    }
}

fn wide_frame(sketch: &mut Sketch, aspect: f64) {
    let frame = match aspect as u32 {
        1 => [64, 64],
        8 => [256, 32],
        64 => [1024, 16],
        512 => [2048, 4],
        _ => [4096, 1],
    };
    let height = 1.0 / aspect;
    // 90 degrees across, whatever the height.
    let vertical_fov = 2.0 * (height as f32).atan();
    plates(sketch, 0.9, 0.9 * height);
    sketch.camera = Camera { frame, face: 64, vertical_fov, ..Camera::default() };
}

fn surface_starts(sketch: &mut Sketch, lift: f64) {
    sketch.plate(dvec3(-2.0, -1.0, -1.0), DVec3::X * 4.0, DVec3::NEG_Z * 4.0);
    sketch.plate(dvec3(-2.0, -1.0, -5.0), DVec3::X * 4.0, DVec3::Y * 2.5);
    let lift = lift * sketch.diagonal();
    for _ in 0..RAYS {
        let origin = dvec3(1.2 * sketch.signed(), -1.0 + lift, -3.5 + sketch.signed());
        let direction = sketch.direction();
        sketch.towards(origin, origin + dvec3(direction.x, direction.y.abs(), direction.z));
    }
}

/// Rays along lines of an image, pixels from its middle and so many pixels off, up to a reach across and a depth.
fn along_borders(sketch: &mut Sketch, off: f64, (pixel, eye): (f64, DVec3), border: fn(f64) -> f64, to: [f64; 2]) {
    for index in 0..RAYS {
        let line = (border(sketch.signed()) + if sketch.unit() < 0.5 { off } else { -off }) * pixel;
        let along = to[0] * sketch.signed();
        let start = 1.0 + 2.5 * sketch.unit();
        let end = along + 0.3 * sketch.signed();
        let on = |along: f64| if index % 2 == 0 { dvec3(line, along, -1.0) } else { dvec3(along, line, -1.0) };
        sketch.towards(eye + on(along) * start, eye + on(end) * to[1]);
    }
}

fn cell_borders(sketch: &mut Sketch, off: f64) {
    // A wall square to the view that fills half of it.
    sketch.plate(dvec3(-1.5, -1.5, -4.0), DVec3::X * 3.0, DVec3::Y * 2.0);
    along_borders(sketch, off, (PIXEL, DVec3::ZERO), |unit| (0.4 * unit * 256.0).round(), [0.45, 4.0]);
}

/// The face that looks along -z, as image-space methods with pulled-back centres have it (VVP16, section 3.2).
fn forward_face(viewpoint: &Viewpoint) -> View {
    let faces = viewpoint.face_views(f64::from(viewpoint.near));
    let along = |view: &&View| view.forward.dot(DVec3::NEG_Z) > 0.5;
    faces.iter().find(along).copied().unwrap_or_else(|| faces[0])
}

fn face_cell_borders(sketch: &mut Sketch, off: f64) {
    sketch.plate(dvec3(-1.5, -1.5, -4.0), DVec3::X * 3.0, DVec3::Y * 2.0);
    sketch.camera.near = Some(0.05);
    let face = forward_face(&sketch.viewpoint());
    let pixel = 2.0 * face.tan_half_width / f64::from(face.size[0]);
    along_borders(sketch, off, (pixel, face.eye), |unit| 2.0 * (0.2 * unit * 128.0).round(), [0.4, 4.2]);
}

fn view_centre(sketch: &mut Sketch, distance: f64) {
    sketch.sphere(DVec3::ZERO, 2.0, 8, |numbers| numbers.unit() < 0.7);
    let distance = distance * sketch.diagonal();
    for _ in 0..RAYS {
        // From behind the eye, so that every ray goes on into the view.
        let forward = dvec3(0.45 * sketch.signed(), 0.45 * sketch.signed(), -1.0);
        let aside = forward.any_orthonormal_vector() * distance;
        let origin = aside - forward * (0.2 + 0.8 * sketch.unit());
        sketch.towards(origin, aside + forward);
    }
}
