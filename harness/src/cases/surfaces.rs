//! Cases about what surfaces are like.

use glam::{DVec3, Vec3, dvec3};

use super::sketch::{Camera, RAYS, Sketch};
use super::{Case, Feature, turned};

pub(super) const EDGE_ON: Case = Case {
    name: "edge-on",
    summary: "a plate turned until it lies along the line of sight; rays cross it from the side",
    difficulty_parameter: turned("slant", "degrees", &[45.0, 80.0, 87.0, 89.0, 89.8, 89.98]),
    seed: 1,
    make: edge_on,
    feature: Feature::of("hit a surface seen at less than a degree", 0.3, |probe, index| {
        probe.hit(index).zip(probe.point(index)).is_some_and(|(hit, point)| {
            let sampling_model = (point - probe.view().eye).normalize();
            probe.truth.normal(hit.primitive).dot(sampling_model).abs() < 0.017
        })
    }),
};

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

pub(super) const SHEETS: Case = Case {
    name: "close-sheets",
    summary: "two parallel sheets ever closer together; half of the rays start midway between them",
    difficulty_parameter: turned("gap", "diagonals", &[0.1, 0.01, 1e-3, 1e-4, 2e-5]),
    seed: 4,
    make: sheets,
    feature: Feature::of(
        "hit a sheet with the other one closer than a thousandth of the diagonal",
        0.4,
        |probe, index| {
            probe.hit(index).is_some_and(|hit| hit.t < 1e-3 * probe.truth.diagonal())
                || probe.surfaces(index, 1e-3 * probe.truth.diagonal(), 2) == 2
        },
    ),
};

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

pub(super) const OPEN_MESH: Case = Case {
    name: "open-mesh",
    summary: "a sphere with triangles missing, seen through its holes: insides show, nothing is closed",
    difficulty_parameter: turned("missing", "share of triangles", &[0.05, 0.1, 0.25, 0.4, 0.6]),
    seed: 6,
    make: |sketch, missing| sketch.sphere(SPHERE, 1.2, 6, |numbers| numbers.unit() >= missing),
    feature: Feature::of("hit the sphere from its inside", 0.1, |probe, index| {
        probe.point(index).is_some_and(|point| (point - SPHERE).dot(probe.ray(index).direction) > 0.0)
    }),
};

const SPHERE: DVec3 = dvec3(0.0, 0.0, -2.6);

pub(super) const HUGE: Case = Case {
    name: "huge-triangle",
    summary: "small pyramids on a floor of one triangle that is ever larger than what is seen of it",
    difficulty_parameter: turned("edge", "eye heights", &[10.0, 100.0, 1e3, 1e4, 1e5]),
    seed: 7,
    make: huge,
    feature: Feature::of("hit a triangle a thousand times as large as it is far", 0.2, |probe, index| {
        probe.hit(index).zip(probe.triangle(index)).is_some_and(|(hit, (longest, _))| longest > 1e3 * hit.t)
    }),
};

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

pub(super) const NEEDLES: Case = Case {
    name: "needles",
    summary: "a plate cut into ever thinner triangles; every other ray aims at an edge between two of them",
    difficulty_parameter: turned("length", "widths", &[8.0, 32.0, 128.0, 1024.0, 8192.0]),
    seed: 8,
    make: needles,
    feature: Feature::of("hit a triangle a thousand times as long as wide", 0.5, |probe, index| {
        probe.triangle(index).is_some_and(|(longest, least)| longest > 1e3 * least)
    }),
};

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

pub(super) const COPLANAR: Case = Case {
    name: "coplanar-copies",
    summary: "the same plate many times over in one plane",
    difficulty_parameter: turned("copies", "", &[1.0, 2.0, 4.0, 16.0, 64.0, 256.0]),
    seed: 9,
    make: |sketch, copies| {
        for _ in 0..copies as u32 {
            sketch.plate_around(dvec3(0.1, 0.1, -3.0), dvec3(1.2, 0.0, 0.3), dvec3(0.1, 1.2, -0.2));
        }
    },
    feature: Feature::of("hit a triangle of which there are more than a hundred copies", 0.3, |probe, index| {
        let geometry = probe.truth.geometry();
        probe.hit(index).is_some_and(|hit| {
            let same = |other: &u32| geometry.corners(*other) == geometry.corners(hit.primitive);
            (0..geometry.triangles.len() as u32).filter(same).count() > 100
        })
    }),
};

pub(super) const FLAT_TILE: Case = Case {
    name: "flat-tile",
    summary: "a wall square to the view whose relief shrinks to nothing: tiles without any range of depth",
    difficulty_parameter: turned("relief", "diagonals", &[0.1, 0.01, 1e-4, 1e-6, 0.0]),
    seed: 21,
    make: flat_tile,
    feature: Feature::of("hit the wall at its one depth", 0.3, |probe, index| {
        probe.point(index).is_some_and(|point| point.z == -3.0 || (point.z + 3.0).abs() < 1e-6)
    }),
};

fn flat_tile(sketch: &mut Sketch, relief: f64) {
    for cell in 0..64 {
        let (column, row) = (f64::from(cell % 8), f64::from(cell / 8));
        let depth = -3.0 + relief * 3.4 * sketch.signed();
        sketch.plate(dvec3(-1.2 + 0.3 * column, -1.2 + 0.3 * row, depth), DVec3::X * 0.3, DVec3::Y * 0.3);
    }
}
