//! Cases about where the eye stands.

use glam::{DVec3, Vec3, dvec3};

use super::sketch::{Camera, RAYS, Sketch};
use super::{Drawn, Probe};

pub(super) const DRAWN: &[Drawn] = &[
    ("eye-inside-object", inside, |probe, index| {
        probe.hit(index).is_some_and(|hit| hit.t < 0.01 * probe.truth.diagonal())
    }),
    ("eye-on-surface", on_surface, before_near),
    ("eye-at-vertex", at_vertex, before_near),
    ("before-near", nearer_than_near, before_near),
    (
        "depth-range",
        |sketch, decades| drop(plates_by_decade(sketch, decades)),
        |probe, index| probe.point(index).is_some_and(|point| -point.z < 1e-5 * probe.view().far),
    ),
    ("secondary-depth-ratio", secondary_depth_ratio, |probe, index| {
        let start = probe.ray(index).origin[2];
        probe.point(index).is_some_and(|point| start > 1e-5 * point.z)
    }),
    ("plane-through-eye", plane_through_eye, |probe, index| {
        let eye = probe.setup.viewpoint.eye;
        probe.point(index).is_some_and(|point| point.y.abs() < 1e-6 && eye.y == 0.0)
    }),
];

fn inside(sketch: &mut Sketch, radius: f64) {
    sketch.widen([DVec3::splat(-2.0), DVec3::splat(2.0)]);
    let radius = radius * 48.0_f64.sqrt();
    sketch.sphere(DVec3::ZERO, radius, 6, |_| true);
    for index in 0..30 {
        let place = dvec3(f64::from(index % 6) * 0.36 - 0.9, f64::from(index / 6) * 0.42 - 0.84, -1.9);
        sketch.plate_around(place, dvec3(0.12, 0.0, 0.02), dvec3(0.0, 0.14, -0.03));
    }
    sketch.through_centres(RAYS / 2);
    for _ in 0..RAYS / 2 {
        let target = dvec3(sketch.signed(), sketch.signed(), -1.9);
        let origin = target * 0.8 + 0.05 * sketch.point();
        sketch.towards(origin, target);
    }
}

/// Nearer to the eye than the near distance that viewpoints get.
fn before_near(probe: &Probe<'_>, index: usize) -> bool {
    let view = probe.view();
    probe.point(index).is_some_and(|point| (point - view.eye).dot(view.forward) < view.near)
}

fn on_surface(sketch: &mut Sketch, height: f64) {
    // A slanted floor, 2 by 2: what is close to the eye has no special coordinates.
    let (along, upward) = (dvec3(1.0, 0.02, 0.0), dvec3(0.0, 0.05, -1.0));
    let normal = along.cross(upward).normalize();
    let floor = -normal * (height * 8.0_f64.sqrt());
    sketch.plate_around(floor, along, upward);
}

fn at_vertex(sketch: &mut Sketch, distance: f64) {
    const SIDES: u32 = 9;
    let tip = dvec3(0.0, 0.0, -distance * 2.5);
    let rim = |side: u32| {
        let (sine, cosine) = (std::f64::consts::TAU * f64::from(side % SIDES) / f64::from(SIDES)).sin_cos();
        tip + dvec3(0.5 * cosine, 0.5 * sine, -1.0)
    };
    for side in 0..SIDES {
        sketch.triangle([tip, rim(side), rim(side + 1)]);
    }
    // Keeps the diagonal at about 2.5 and gives rays beside the cone something to hit.
    sketch.plate(dvec3(-0.6, -1.2, -1.9), DVec3::X * 1.2, DVec3::Y * 0.5);
    sketch.speck(dvec3(0.6, 1.0, -0.5));
}

fn nearer_than_near(sketch: &mut Sketch, depth: f64) {
    const NEAR: f64 = 0.004;
    let depth = depth * NEAR;
    sketch.plate(dvec3(-0.8, -0.4, -1.0) * depth, dvec3(0.7, 0.0, 0.0) * depth, DVec3::Y * 0.9 * depth);
    sketch.plate(dvec3(-1.1, -1.3, -3.0), dvec3(1.9, 0.0, 0.1), dvec3(0.0, 1.7, 0.2));
    sketch.camera.near = Some(NEAR as f32);
}

/// A plate a decade of depth side by side in one view: corner, and the two edges that start there.
fn plates_by_decade(sketch: &mut Sketch, decades: f64) -> Vec<[DVec3; 3]> {
    let plates = decades as i32 + 1;
    let width = 1.1 / f64::from(plates);
    let plate = |plate: i32| {
        let corner = dvec3(-0.55 + width * f64::from(plate), -0.4, -1.0);
        let edges = [corner, DVec3::X * (0.9 * width), dvec3(0.0, 0.75, 0.2)];
        edges.map(|each| each * (1e-3 * 10_f64.powi(plate)))
    };
    let plates: Vec<[DVec3; 3]> = (0..plates).map(plate).collect();
    plates.iter().for_each(|[corner, along, upward]| sketch.plate(*corner, *along, *upward));
    sketch.camera.near = Some(5e-4);
    plates
}

/// The plates that rays start on: so far apart are they from the deepest.
const STARTED_ON: f64 = 3.0;

fn secondary_depth_ratio(sketch: &mut Sketch, decades: f64) {
    let plates = plates_by_decade(sketch, decades);
    let deepest = plates.len() - 1;
    for index in 0..RAYS {
        // Of starts that are deeper ulps are as large as near plates, which truth could not tell.
        let from = (sketch.unit() * STARTED_ON.min(deepest as f64)) as usize;
        let to = from + 1 + (sketch.unit() * (deepest - from) as f64) as usize;
        let on = |[corner, along, upward]: [DVec3; 3], sketch: &mut Sketch| {
            corner + along * (0.1 + 0.8 * sketch.unit()) + upward * (0.1 + 0.8 * sketch.unit())
        };
        let (start, target) = (on(plates[from], sketch), on(plates[to], sketch));
        // Off the surface, on the side away from the eye, by more than ties are told by.
        let lifted = start + DVec3::NEG_Z * (0.05 * start.z.abs());
        if index % 4 == 0 {
            let aside = sketch.direction();
            sketch.towards(lifted, lifted + dvec3(aside.x, aside.y, -aside.z.abs()) * start.z.abs());
        } else {
            sketch.towards(lifted, target);
        }
    }
}

fn plane_through_eye(sketch: &mut Sketch, height: f64) {
    // Not square, so that no edge between its triangles passes below the eye.
    sketch.plate(dvec3(-4.0, 0.0, 3.0), DVec3::X * 9.0, DVec3::NEG_Z * 8.0);
    for _ in 0..12 {
        let centre = dvec3(3.0 * sketch.signed(), 0.3 + sketch.unit(), -1.0 + 2.5 * sketch.signed());
        sketch.plate_around(centre, DVec3::X * 0.25, dvec3(0.0, 0.1, 0.25));
    }
    let diagonal = dvec3(9.0, 1.4, 8.0).length();
    let eye = Vec3::new(0.0, (height * diagonal) as f32, 0.0);
    sketch.camera = Camera { eye, target: eye + Vec3::NEG_Z, ..Camera::default() };
    for index in 0..RAYS {
        let origin = dvec3(3.0 * sketch.signed(), 0.2 + 1.5 * sketch.unit(), -1.0 + 3.0 * sketch.signed());
        let fall = if index % 4 == 0 { 0.5 } else { -1.5 };
        let target = origin + dvec3(2.0 * sketch.signed(), fall, 2.0 * sketch.signed());
        sketch.towards(origin, target);
    }
}
