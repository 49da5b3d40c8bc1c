//! Cases about what uniform grids over a scene are made of: voxels, as many along every axis.

use glam::{DQuat, DVec3, Vec3, dvec3};
use tracebench_api::Query;

use super::Drawn;
use super::sketch::{Camera, RAYS, Sketch};

pub(super) const DRAWN: &[Drawn] = &[
    ("thin-walls", thin_walls, |probe, index| probe.surfaces(index, 0.2 * VOXEL_EDGE, 2) == 2),
    ("long-scene", long_scene, |probe, index| {
        probe.triangle(index).is_some_and(|(longest, _)| longest < VOXEL_EDGE * probe.truth.diagonal())
    }),
];

/// Edge of a voxel where the scene spans 1 and a grid has 64 of them along it, as in HHZ14.
pub(super) const VOXEL_EDGE: f64 = 1.0 / 64.0;

fn thin_walls(sketch: &mut Sketch, wall: f64) {
    /// Half of the room's edge: it fills what its turn leaves it of the scene.
    const HALF: f64 = 0.25;
    sketch.widen([DVec3::ZERO, DVec3::ONE]);
    // Off the axes, so that no wall is a special one to a grid or to a projection along an axis.
    let turn = DQuat::from_rotation_y(0.35) * DQuat::from_rotation_x(0.2);
    let edges = |half: f64| [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| turn * axis * half);
    let centre = DVec3::splat(0.5);
    sketch.block(centre, edges(HALF + wall * VOXEL_EDGE));
    // A wall is a solid: its inner side shows its front to the room.
    let [x, y, z] = edges(HALF);
    sketch.block(centre, [x, y, -z]);
    sketch.camera = Camera { eye: Vec3::new(0.5, 0.5, 0.6), target: Vec3::new(0.5, 0.5, 0.0), ..Camera::default() };
    for index in 0..RAYS {
        // In view, before the wall that is seen.
        let mut at = |depth: f64| sketch.eye() + depth * dvec3(0.4 * sketch.signed(), 0.4 * sketch.signed(), -1.0);
        let start = at(0.05 + 0.1 * (index % 7) as f64 / 7.0);
        // A quarter ends in the room; the others end at lamps outside.
        let target = if index % 4 == 0 { at(0.2) } else { at(1.0) };
        sketch.until(start, target);
    }
    sketch.query = Query::Any;
}

fn long_scene(sketch: &mut Sketch, length: f64) {
    /// Blocks stand apart in so many columns, rows and slices a width.
    const CELLS: [u32; 3] = [2, 2, 2];
    const HALF_EDGE: f64 = 0.12;
    // The passage is 1 by 1 and begins before the eye, which near does not cut.
    let (low, high) = (dvec3(-0.5, -0.5, -0.5 - length), dvec3(0.5, 0.5, -0.5));
    sketch.widen([low, high]);
    let cell = DVec3::ONE / DVec3::from(CELLS.map(f64::from));
    let slices = (length * f64::from(CELLS[2])).round() as u32;
    for slice in 0..slices {
        for place in 0..CELLS[0] * CELLS[1] {
            let steps = [place % CELLS[0], place / CELLS[0], slice].map(|step| f64::from(step) + 0.5);
            let centre = low + cell * DVec3::from(steps) + 0.04 * sketch.point();
            let (x, y) = sketch.direction().any_orthonormal_pair();
            sketch.block(centre, [x, y, x.cross(y)].map(|axis| axis * HALF_EDGE));
        }
    }
}
