//! Cases about many surfaces in one place: lists, voxels, hierarchies that grow.

use glam::{DVec3, Vec3, dvec3};
use tracebench_api::Query;

use super::Drawn;
use super::grids::VOXEL_EDGE;
use super::sketch::{Camera, PIXEL, RAYS, Sketch};

pub(super) const DRAWN: &[Drawn] = &[
    ("voxel-stack", voxel, |probe, index| probe.surfaces(index, 2.0 * VOXEL_EDGE, 4) == 4),
    ("equal-triangles", equal_triangles, |probe, index| {
        probe.hit(index).is_some() && probe.truth.geometry().triangles.len() > 1000
    }),
    ("stacked-layers", layers, |probe, index| probe.surfaces(index, 10.0, 100) == 100),
    ("crowded-pixel", crowd, |probe, index| probe.is_thinner(index, 0.05)),
];

fn voxel(sketch: &mut Sketch, surfaces: f64) {
    const STACKS: usize = 24;
    sketch.widen([DVec3::ZERO, DVec3::ONE]);
    let mut centres = Vec::new();
    for _ in 0..STACKS {
        // The middle of a voxel.
        let centre = ((DVec3::splat(0.5) + 0.35 * sketch.point()) / VOXEL_EDGE).floor() * VOXEL_EDGE;
        let centre = centre + DVec3::splat(0.5 * VOXEL_EDGE);
        let normal = sketch.direction();
        let (across, upward) = normal.any_orthonormal_pair();
        for layer in 0..surfaces as u32 {
            let height = ((f64::from(layer) + 0.5) / surfaces - 0.5) * 0.5 * VOXEL_EDGE;
            let half = 0.25 * VOXEL_EDGE;
            sketch.plate_around(centre + normal * height, across * half, upward * half);
        }
        centres.push(centre);
    }
    sketch.camera = Camera {
        eye: Vec3::new(0.5, 0.5, 2.0),
        target: Vec3::splat(0.5),
        vertical_fov: 0.8,
        frame: [512, 512],
        ..Camera::default()
    };
    for index in 0..RAYS {
        let target = centres[index % STACKS] + sketch.point() * (0.35 * VOXEL_EDGE);
        let origin = target + sketch.direction() * 0.1;
        sketch.towards(origin, target);
    }
}

fn equal_triangles(sketch: &mut Sketch, copies: f64) {
    for _ in 0..copies as u32 {
        sketch.triangle([[-1.0, -1.0, -3.0], [1.4, -0.8, -3.2], [0.1, 1.3, -2.7]].map(DVec3::from));
    }
    // Every ray is tested against every copy, several times over for its truth.
    sketch.through_centres(RAYS / 2);
}

fn layers(sketch: &mut Sketch, layers: f64) {
    for layer in 0..layers as u32 {
        let depth = -2.0 - 2.0 * (f64::from(layer) + 0.5) / layers;
        sketch.plate_around(dvec3(0.05, 0.05, depth), dvec3(0.8, 0.0, 0.001), dvec3(0.0, 0.8, 0.0));
    }
    sketch.through_centres(RAYS / 2);
    for _ in 0..RAYS / 2 {
        let origin = dvec3(0.6 * sketch.signed(), 0.6 * sketch.signed(), -3.0 + sketch.signed());
        let direction = sketch.direction();
        sketch.towards(origin, origin + dvec3(direction.x * 0.3, direction.y * 0.3, direction.z));
    }
}

fn crowd(sketch: &mut Sketch, triangles: f64) {
    // The middle of a pixel of the default camera at depth 4, a hundredth of a voxel of a scene this wide.
    let centre = dvec3(0.5, 0.5, 0.0) * (PIXEL * 4.0) - DVec3::Z * 4.0;
    let radius = 0.4 * PIXEL * 4.0;
    sketch.widen([dvec3(-2.0, -2.0, -6.0), dvec3(2.0, 2.0, -2.0)]);
    // The more, the smaller: so that the cloud never becomes one solid thing.
    let size = 3.0 * radius / triangles.sqrt();
    for _ in 0..triangles as u32 {
        let at = centre + sketch.direction() * (radius * sketch.unit());
        let corners = [0, 1, 2].map(|_| at + sketch.direction() * size);
        sketch.triangle(corners);
    }
    for index in 0..RAYS {
        let target = centre + sketch.direction() * (radius * sketch.unit());
        let origin = if index % 2 == 0 { sketch.eye() } else { centre + sketch.direction() };
        sketch.towards(origin, target);
    }
    sketch.query = Query::Any;
}
