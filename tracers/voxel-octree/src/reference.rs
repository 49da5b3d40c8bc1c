//! Which voxels a triangle touches, on the host, in f64: by separating axes, not by the cuts of the device.

use tracebench_api::Geometry;
use tracebench_api::glam::{DVec3, Vec3};
use tracebench_kit::to_unit;

use crate::layout::Layout;

/// How much wider than they are voxels are taken to be on every side: as `SLACK` in shaders/voxel-octree/rows.wgsl.
pub(crate) const SLACK: f64 = 1.0 / 512.0;

/// Within which distance of that the device may decide either way, voxels: where f32 puts corners and cuts.
pub(crate) const ROUNDING: f64 = 1.0 / 1024.0;

/// As `MIN_LENGTH` in shaders/voxel-octree/leaves.wgsl.
pub(crate) const MIN_LENGTH: f64 = 0.0625;

/// Sine of the angle between a triangle's edges below which its normal in f32 is noise, and may be none.
const THIN: f64 = 1e-3;

/// A triangle of the scene.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Triangle {
    /// Corners, voxels.
    pub corners: [DVec3; 3],
    /// Of unit length; 0 without an area.
    pub normal: DVec3,
    /// Whether rounding decides on its normal, and whether it has any.
    pub thin: bool,
}

impl Triangle {
    pub(crate) fn of(layout: &Layout, geometry: &Geometry, primitive: u32) -> Self {
        let scene = geometry.corners(primitive).map(Vec3::as_dvec3);
        let [a, b, c] = scene;
        let across = (b - a).normalize_or_zero().cross((c - a).normalize_or_zero());
        Self {
            corners: scene.map(|corner| to_unit(&layout.space, corner) * f64::from(layout.edge())),
            normal: across.normalize_or_zero(),
            thin: across.length() < THIN,
        }
    }

    /// Whether it touches a box that is wider by so much on every side (Akenine-Möller, "Fast 3D Triangle-Box Overlap Testing", 2001).
    pub(crate) fn touches(&self, low: DVec3, high: DVec3, wider: f64) -> bool {
        let (centre, half) = ((low + high) / 2.0, (high - low) / 2.0 + DVec3::splat(wider));
        let corners = self.corners.map(|corner| corner - centre);
        let [a, b, c] = corners;
        let edges = [b - a, c - b, a - c];
        let separates = |axis: DVec3| {
            let along = corners.map(|corner| corner.dot(axis));
            let reach = half.dot(axis.abs());
            let (least, most) = (
                along.iter().copied().fold(f64::INFINITY, f64::min),
                along.iter().copied().fold(f64::NEG_INFINITY, f64::max),
            );
            least > reach || most < -reach
        };
        let crossed = edges.into_iter().flat_map(|edge| DVec3::AXES.map(|axis| edge.cross(axis)));
        !DVec3::AXES.into_iter().chain([edges[0].cross(edges[1])]).chain(crossed).any(separates)
    }

    /// Whether the device must have it in a voxel, and whether it may; none where it may not.
    pub(crate) fn in_voxel(&self, voxel: [u32; 3]) -> Option<bool> {
        let low = DVec3::from(voxel.map(f64::from));
        let within = |wider| self.touches(low, low + 1.0, wider);
        within(SLACK + ROUNDING).then(|| !self.thin && within(SLACK - ROUNDING))
    }
}

/// A node or leaf of the tree by its place: `depth` below the root, of so many along each axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct CellPosition {
    pub depth: u32,
    /// Of all at its depth, along Morton's curve.
    pub key: u32,
}

impl CellPosition {
    pub(crate) const ROOT: Self = Self { depth: 0, key: 0 };

    pub(crate) fn child(self, part: u32) -> Self {
        Self { depth: self.depth + 1, key: self.key << 3 | part }
    }

    /// Where it is along every axis.
    pub(crate) fn cell(self) -> [u32; 3] {
        [0, 1, 2].map(|axis| (0..self.depth).map(|level| (self.key >> (3 * level + axis) & 1) << level).sum())
    }
}

/// Calls back for every voxel that a triangle may be in and that lies in a part which `wanted` wants, with whether it must be.
pub(crate) fn voxels_of(
    triangle: &Triangle,
    levels: u32,
    wanted: &dyn Fn(CellPosition) -> bool,
    place: CellPosition,
    found: &mut dyn FnMut(u32, bool),
) {
    if !wanted(place) {
        return;
    }
    if place.depth == levels {
        if let Some(must) = triangle.in_voxel(place.cell()) {
            found(place.key, must);
        }
        return;
    }
    let size = f64::from(1_u32 << (levels - place.depth));
    let low = DVec3::from(place.cell().map(f64::from)) * size;
    if triangle.touches(low, low + size, SLACK + ROUNDING) {
        (0..8).for_each(|part| voxels_of(triangle, levels, wanted, place.child(part), found));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Keys interleave x, y, z from the lowest bit on, a level every three bits.
    #[test]
    fn places_are_found_from_keys() {
        let place = [5, 0, 7].into_iter().fold(CellPosition::ROOT, CellPosition::child);
        assert_eq!((place.key, place.cell()), (0o507, [0b101, 0b001, 0b101]));
    }

    /// A triangle touches what it lies in, passes through or comes near, and not what it only has in its bounds.
    #[test]
    fn triangles_touch_what_they_come_near() {
        let corners = [[0.2, 0.2, 0.2], [7.8, 0.2, 0.2], [0.2, 7.8, 0.2]].map(DVec3::from);
        let triangle = Triangle { corners, normal: DVec3::Z, thin: false };
        let in_voxel = |x, y, z| triangle.in_voxel([x, y, z]);
        assert_eq!([in_voxel(0, 0, 0), in_voxel(3, 3, 0), in_voxel(7, 0, 0)], [Some(true); 3]);
        assert_eq!([in_voxel(6, 6, 0), in_voxel(0, 0, 1), in_voxel(5, 4, 0)], [None; 3]);
        let near =
            |z: f64| Triangle { corners: corners.map(|corner| corner.with_z(z)), ..triangle }.in_voxel([0, 0, 1]);
        assert_eq!(
            [near(1.0 - 0.5 * SLACK + 1e-4), near(1.0 - SLACK), near(1.0 - 2.0 * SLACK)],
            [Some(true), Some(false), None]
        );
    }
}
