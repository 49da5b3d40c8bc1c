//! Cases about what surfaces are like.

use glam::{DVec3, Vec3, dvec3};

use super::Drawn;
use super::sketch::{Camera, RAYS, Sketch};

pub(super) const DRAWN: &[Drawn] = &[
    ("edge-on", edge_on, |probe, index| {
        probe.hit(index).zip(probe.point(index)).is_some_and(|(hit, point)| {
            let sampling_model = (point - probe.view().eye).normalize();
            probe.truth.normal(hit.primitive).dot(sampling_model).abs() < 0.017
        })
    }),
    ("close-sheets", sheets, |probe, index| {
        let close = 1e-3 * probe.truth.diagonal();
        probe.hit(index).is_some_and(|hit| hit.t < close) || probe.surfaces(index, close, 2) == 2
    }),
    (
        "open-mesh",
        |sketch, missing| sketch.sphere(SPHERE, 1.2, 6, |numbers| numbers.unit() >= missing),
        |probe, index| probe.point(index).is_some_and(|point| (point - SPHERE).dot(probe.ray(index).direction) > 0.0),
    ),
    ("huge-triangle", huge, |probe, index| {
        probe.hit(index).zip(probe.triangle(index)).is_some_and(|(hit, (longest, _))| longest > 1e3 * hit.t)
    }),
    ("needles", needles, |probe, index| probe.triangle(index).is_some_and(|(longest, least)| longest > 1e3 * least)),
    ("coplanar-copies", coplanar, |probe, index| {
        let geometry = probe.truth.geometry();
        probe.hit(index).is_some_and(|hit| {
            let same = |other: &u32| geometry.corners(*other) == geometry.corners(hit.primitive);
            (0..geometry.triangles.len() as u32).filter(same).count() > 100
        })
    }),
    ("flat-tile", flat_tile, |probe, index| {
        probe.point(index).is_some_and(|point| point.z == -3.0 || (point.z + 3.0).abs() < 1e-6)
    }),
];

fn edge_on(sketch: &mut Sketch, slant: f64) {
    let centre = dvec3(0.0, 0.0, -4.0);
    let (across, along) = (90.0 - slant).to_radians().sin_cos();
    let along = dvec3(across, 0.0, -along);
    sketch.plate_around(centre, along, DVec3::Y);
    for index in 0..RAYS {
        let origin = centre + dvec3(-1.5, 0.5, 0.5) + 0.4 * sketch.point();
        // A third passes above the plate.
        let height = if index % 3 == 0 { 1.2 + 0.5 * sketch.unit() } else { 0.95 * sketch.signed() };
        let target = centre + along * (0.95 * sketch.signed()) + DVec3::Y * height;
        sketch.towards(origin, target);
    }
}

fn sheets(sketch: &mut Sketch, gap: f64) {
    let gap = gap * 8.0_f64.sqrt();
    let (front, rear) = (DVec3::NEG_Z, DVec3::Z * (-1.0 - gap));
    for centre in [front, rear] {
        sketch.plate_around(centre, DVec3::X, DVec3::Y);
    }
    for index in 0..RAYS {
        let place = dvec3(sketch.signed(), sketch.signed(), 0.0);
        match index % 4 {
            // Steep enough to stay between the sheets for a few gaps only.
            0 | 1 => {
                let side = if sketch.unit() < 0.5 { 1.0 } else { -1.0 };
                let slope = dvec3(sketch.signed(), sketch.signed(), 0.0) * 0.7;
                let origin = place * 0.6 + DVec3::Z * (-1.0 - 0.5 * gap);
                sketch.towards(origin, origin + slope + DVec3::Z * side);
            }
            2 => sketch.towards(DVec3::ZERO, place * 0.5 + front),
            _ => sketch.towards(DVec3::ZERO, place.normalize_or(DVec3::X) * 2.5 + front),
        }
    }
}

const SPHERE: DVec3 = dvec3(0.0, 0.0, -2.6);

fn huge(sketch: &mut Sketch, edge: f64) {
    let floor = dvec3(0.013, -1.0, -0.027);
    sketch.triangle([floor + dvec3(-edge, 0.0, edge), floor + dvec3(edge, 0.0, edge), floor + dvec3(0.0, 0.0, -edge)]);
    for _ in 0..40 {
        let base = dvec3(3.0 * sketch.signed(), -1.0, -3.0 + 2.0 * sketch.signed());
        let corners = [dvec3(-0.2, 0.0, -0.15), dvec3(0.2, 0.0, -0.1), dvec3(0.0, 0.0, 0.2)].map(|x| base + x);
        let apex = base + DVec3::Y * 0.3;
        for side in 0..3 {
            sketch.triangle([corners[side], corners[(side + 1) % 3], apex]);
        }
    }
    sketch.camera = Camera { target: Vec3::new(0.0, -0.3, -1.0), near: Some(0.01), ..Camera::default() };
}

fn needles(sketch: &mut Sketch, length: f64) {
    let corner = dvec3(-1.05, -0.95, -4.0);
    // Tilted, and turned so that no edge lies along an axis.
    let (along, upward) = (dvec3(2.0, 0.11, 0.1), dvec3(-0.13, 2.0, 0.3));
    let count = length as u32;
    for strip in 0..count {
        let start = corner + along * (f64::from(strip) / length);
        let end = corner + along * (f64::from(strip + 1) / length);
        sketch.triangle([start, end, end + upward]);
        sketch.triangle([start, end + upward, start + upward]);
    }
    for index in 0..RAYS {
        let mut across = sketch.unit();
        if index % 2 == 0 {
            across = (across * length).floor().max(1.0) / length;
        }
        // A quarter passes above.
        let height = if index % 4 == 3 { 1.1 + 0.3 * sketch.unit() } else { 0.02 + 0.96 * sketch.unit() };
        sketch.towards(DVec3::ZERO, corner + along * across + upward * height);
    }
}

fn coplanar(sketch: &mut Sketch, copies: f64) {
    for _ in 0..copies as u32 {
        sketch.plate_around(dvec3(0.1, 0.1, -3.0), dvec3(1.2, 0.0, 0.3), dvec3(0.1, 1.2, -0.2));
    }
}

fn flat_tile(sketch: &mut Sketch, relief: f64) {
    for cell in 0..64 {
        let (column, row) = (f64::from(cell % 8), f64::from(cell / 8));
        let depth = -3.0 + relief * 3.4 * sketch.signed();
        sketch.plate(dvec3(-1.2 + 0.3 * column, -1.2 + 0.3 * row, depth), DVec3::X * 0.3, DVec3::Y * 0.3);
    }
}
