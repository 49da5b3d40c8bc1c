//! The layers that texels may and must have, and the voxels that may have anything: triangle by triangle, on the host, in f64.

use tracebench_api::Geometry;
use tracebench_api::glam::{DVec2, DVec3, Vec3};
use tracebench_kit::to_unit;

use crate::layout::{AXES, UnitSpace, across_and_down};

/// Difference of depths and places in the cube that f32 may make.
pub(crate) const UNIT_SLACK: f64 = 2e-6;

/// Length by which a plane's normal in f32 may be off, over the sine of the angle between the edges that it comes from.
const PLANE_SLACK: f64 = 2e-6;

/// The same of the stored normal, of other edges.
const NORMAL_SLACK: f64 = 1e-4;

/// A stored layer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Layer {
    /// In the cube.
    pub depth: f32,
    /// Whether its normal points along the axis.
    pub faces_along: bool,
    pub normal: Vec3,
    pub material: u32,
}

/// A layer that a texel may have.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Allowed {
    /// Whether the texel must have it: its centre lies well inside of the triangle.
    pub must: bool,
    /// Least and greatest depth.
    pub depths: [f64; 2],
    /// Whether the normal points along the axis; none where rounding may decide.
    faces_along: Option<bool>,
    normal: DVec3,
    normal_slack: f64,
    material: u32,
}

impl Allowed {
    /// Whether a stored layer may stand for this one: copies have one layer together.
    pub(crate) fn is_shown_by(&self, layer: &Layer) -> bool {
        let depth = f64::from(layer.depth);
        let in_range = depth >= self.depths[0] && depth <= self.depths[1];
        in_range && self.faces_along.is_none_or(|along| along == layer.faces_along)
    }

    /// Whether it can be this very one.
    pub(crate) fn fits(&self, layer: &Layer) -> bool {
        self.is_shown_by(layer)
            && (layer.normal.as_dvec3() - self.normal).length() <= self.normal_slack
            && layer.material == self.material
    }
}

/// A triangle in the cube.
pub(crate) struct Placed {
    pub corners: [DVec3; 3],
    /// The plane's normal, longest component 1, and by how much it may be off; 0 of a triangle without an area.
    pub across: DVec3,
    pub off: f64,
}

pub(crate) fn place(space: UnitSpace, corners: [DVec3; 3]) -> Placed {
    let corners = corners.map(|corner| to_unit(&space, corner));
    // As the device does, by the two shorter edges.
    let mut edges: [DVec3; 3] = std::array::from_fn(|edge| corners[(edge + 1) % 3] - corners[edge]);
    let longest = (0..3).max_by(|a, b| edges[*a].length().total_cmp(&edges[*b].length())).unwrap_or_default();
    edges.rotate_left(longest + 1);
    let across = edges[0].normalize_or_zero().cross(edges[1].normalize_or_zero());
    let size = across.abs().max_element();
    let off = PLANE_SLACK / across.length().max(1e-30);
    Placed { corners, across: if size > 0.0 { across / size } else { DVec3::ZERO }, off }
}

impl Placed {
    /// As the image along an axis has it, of so many texels along an edge.
    pub(crate) fn drawn(&self, axis: usize, image: u32) -> Drawn {
        let [across, down] = across_and_down(axis);
        let edge = f64::from(image);
        let flat = |vector: DVec3| DVec2::new(vector[across], vector[down]);
        let depths = self.corners.map(|corner| corner[axis]);
        let tilt = self.across[axis];
        let slope = if tilt == 0.0 { DVec2::ZERO } else { -flat(self.across) / tilt };
        let corners = self.corners.map(|corner| flat(corner) * edge);
        let reach = corners.iter().map(|corner| (*corner - corners[0]).length()).fold(0.0, f64::max) / edge;
        // The derivative of a slope by its normal's direction.
        let steepness = 1.0 + slope.length_squared();
        let depth_slack = match tilt == 0.0 {
            true => f64::INFINITY,
            false => UNIT_SLACK * (1.0 + slope.length()) + self.off * steepness * 2.0 * reach,
        };
        Drawn {
            corners,
            depth: depths[0],
            slope: slope / edge,
            least: depths.into_iter().fold(f64::INFINITY, f64::min),
            greatest: depths.into_iter().fold(f64::NEG_INFINITY, f64::max),
            depth_slack,
            faces_along: (tilt.abs() > 4.0 * self.off).then_some(tilt > 0.0),
        }
    }
}

/// A triangle in an image.
pub(crate) struct Drawn {
    /// Texels.
    pub corners: [DVec2; 3],
    /// At the first corner, and what it changes by a texel.
    pub depth: f64,
    pub slope: DVec2,
    pub least: f64,
    pub greatest: f64,
    pub depth_slack: f64,
    pub faces_along: Option<bool>,
}

impl Drawn {
    /// How far a point lies inside of the triangle, texels; negative outside.
    fn inside(&self, at: DVec2) -> f64 {
        let edge = |index: usize| (self.corners[index], self.corners[(index + 1) % 3]);
        let area = (self.corners[1] - self.corners[0]).perp_dot(self.corners[2] - self.corners[0]);
        let distance = |(a, b): (DVec2, DVec2)| {
            let along = b - a;
            // Equal corners make no border.
            if along.length() > 0.0 { along.perp_dot(at - a) * area.signum() / along.length() } else { f64::INFINITY }
        };
        let inside = (0..3).map(|index| distance(edge(index))).fold(f64::INFINITY, f64::min);
        // A triangle in a point has no inside.
        if inside.is_finite() { inside } else { f64::NEG_INFINITY }
    }

    /// The depths that a layer at a place may have.
    fn depths_at(&self, at: DVec2) -> [f64; 2] {
        let depth = self.depth + self.slope.dot(at - self.corners[0]);
        let held = |depth: f64| depth.clamp(self.least, self.greatest);
        [held(depth - self.depth_slack) - UNIT_SLACK, held(depth + self.depth_slack) + UNIT_SLACK]
    }
}

/// The layers of every `step`-th texel along both edges of an image.
pub(crate) struct AllowedLayers {
    pub step: u32,
    width: u32,
    texels: Vec<Vec<Allowed>>,
}

impl AllowedLayers {
    /// Those of a texel, whose coordinates are multiples of the step.
    pub(crate) fn of(&self, [x, y]: [u32; 2]) -> &[Allowed] {
        &self.texels[(y / self.step * self.width + x / self.step) as usize]
    }

    /// Every texel that is compared, with its layers.
    pub(crate) fn each(&self) -> impl Iterator<Item = ([u32; 2], &[Allowed])> {
        let place = |index: usize| [index as u32 % self.width, index as u32 / self.width].map(|at| at * self.step);
        self.texels.iter().enumerate().map(move |(index, allowed)| (place(index), allowed.as_slice()))
    }
}

pub(crate) fn corners_of(scene: &Geometry, triangle: &[u32; 3]) -> [DVec3; 3] {
    triangle.map(|vertex| Vec3::from(scene.positions[vertex as usize]).as_dvec3())
}

/// What every `step`-th texel of the image along an axis may and must have of a scene, where the device decides within `border` of
/// borders.
pub(crate) fn allowed_layers(space: UnitSpace, scene: &Geometry, axis: usize, step: u32, border: f64) -> AllowedLayers {
    let width = space.image.div_ceil(step);
    let mut texels = vec![Vec::new(); (width * width) as usize];
    for (triangle, material) in scene.triangles.iter().zip(scene.triangle_materials.iter()) {
        let corners = corners_of(scene, triangle);
        let drawn = place(space, corners).drawn(axis, space.image);
        let (first, second) = (corners[1] - corners[0], corners[2] - corners[0]);
        let across = first.normalize_or_zero().cross(second.normalize_or_zero());
        let low = drawn.corners.iter().fold(DVec2::INFINITY, |low, at| low.min(*at));
        let high = drawn.corners.iter().fold(DVec2::NEG_INFINITY, |high, at| high.max(*at));
        let range = |low: f64, high: f64| {
            let cell = |at: f64| at / f64::from(step);
            let first = cell(low - 1.0).ceil().clamp(0.0, f64::from(width)) as u32;
            first..(cell(high + 1.0).floor() + 1.0).clamp(0.0, f64::from(width)) as u32
        };
        for row in range(low.y, high.y) {
            for column in range(low.x, high.x) {
                let at = DVec2::new(f64::from(column * step) + 0.5, f64::from(row * step) + 0.5);
                let inside = drawn.inside(at);
                if inside > -border {
                    texels[(row * width + column) as usize].push(Allowed {
                        must: inside > border,
                        depths: drawn.depths_at(at),
                        faces_along: drawn.faces_along,
                        normal: across.normalize_or_zero(),
                        normal_slack: NORMAL_SLACK / across.length().max(1e-30),
                        material: *material,
                    });
                }
            }
        }
    }
    AllowedLayers { step, width, texels }
}

/// Whether normals of a thin triangle, from whichever two edges in f32, may differ by `most` of their length once axes
/// are scaled so: the product of nearly parallel edges is what rounding left of them.
pub(crate) fn normal_is_noise(scale: [f32; AXES], corners: [DVec3; 3], most: f64) -> bool {
    const ROUNDING: f64 = 8.0 / (1u64 << 24) as f64;
    let scale = Vec3::from(scale).as_dvec3();
    let edges: [DVec3; 3] = std::array::from_fn(|corner| {
        let edge = corners[(corner + 1) % 3] - corners[corner];
        edge / edge.abs().max_element()
    });
    (0..3).any(|corner| {
        let across = edges[corner].cross(edges[(corner + 1) % 3]) / scale;
        // Edges of no length give no number.
        across.is_nan() || across.length() * scale.min_element() * most < ROUNDING
    })
}

/// The voxels in which those of a scene's triangles that are asked for, by their corners, may have layers, where the device
/// decides within `border` texels of borders.
pub(crate) fn touched_voxels(
    space: UnitSpace,
    scene: &Geometry,
    border: f64,
    asked_for: impl Fn([DVec3; 3]) -> bool,
) -> Vec<bool> {
    let edge = f64::from(space.grid);
    let aside = border / f64::from(space.image);
    let mut touched = Touched { edge: space.grid, slack: (2.0 * aside + 4.0 * UNIT_SLACK) * edge, voxels: Vec::new() };
    touched.voxels = vec![false; (space.grid as usize).pow(3)];
    for triangle in scene.triangles.iter() {
        let corners = corners_of(scene, triangle);
        if !asked_for(corners) {
            continue;
        }
        let placed = place(space, corners);
        touched.add(&placed);
        for axis in 0..AXES {
            // A sample beside the border of a steep triangle has a depth far from it.
            let drawn = placed.drawn(axis, space.image);
            let off = drawn.depth_slack + drawn.slope.length() * border;
            if off.min(drawn.greatest - drawn.least) * edge > touched.slack {
                touched.add_columns(&placed, axis);
            }
        }
    }
    touched.voxels
}

/// Voxels that are touched, by triangles grown by so many voxels.
struct Touched {
    edge: u32,
    slack: f64,
    voxels: Vec<bool>,
}

impl Touched {
    fn range(&self, low: f64, high: f64) -> std::ops::RangeInclusive<u32> {
        let last = f64::from(self.edge) - 1.0;
        (low - self.slack).floor().clamp(0.0, last) as u32..=(high + self.slack).floor().clamp(0.0, last) as u32
    }

    fn mark(&mut self, centre: DVec3) {
        let [x, y, z] = centre.to_array().map(|at| at as usize);
        let edge = self.edge as usize;
        self.voxels[(z * edge + y) * edge + x] = true;
    }

    /// What a triangle touches.
    fn add(&mut self, placed: &Placed) {
        let edge = f64::from(self.edge);
        let corners = placed.corners.map(|corner| corner * edge);
        let axis = (0..AXES).max_by(|a, b| placed.across[*a].abs().total_cmp(&placed.across[*b].abs())).unwrap_or(2);
        let [across, down] = across_and_down(axis);
        let (low, high) = ends(corners);
        for row in self.range(low[down], high[down]) {
            for column in self.range(low[across], high[across]) {
                // Along the axis that it faces most a triangle is in few voxels of a column.
                let mut centre = DVec3::ZERO;
                (centre[across], centre[down]) = (f64::from(column) + 0.5, f64::from(row) + 0.5);
                let tilt = placed.across[axis];
                let (mut near, mut far) = (low[axis], high[axis]);
                if tilt != 0.0 {
                    let aside = centre - corners[0];
                    let slopes = [across, down].map(|axis| -placed.across[axis] / tilt);
                    let depth = corners[0][axis] + slopes[0] * aside[across] + slopes[1] * aside[down];
                    let reach = (slopes[0].abs() + slopes[1].abs()) * (0.5 + self.slack) + self.slack;
                    (near, far) = (near.max(depth - reach), far.min(depth + reach));
                }
                for layer in self.range(near, far.max(near)) {
                    centre[axis] = f64::from(layer) + 0.5;
                    if overlaps(corners.map(|corner| corner - centre), 0.5 + self.slack) {
                        self.mark(centre);
                    }
                }
            }
        }
    }

    /// All between a triangle's least and greatest depth in the columns that it covers in the image along an axis.
    fn add_columns(&mut self, placed: &Placed, axis: usize) {
        let mut corners = placed.corners.map(|corner| corner * f64::from(self.edge));
        let [across, down] = across_and_down(axis);
        let (low, high) = ends(corners);
        corners.iter_mut().for_each(|corner| corner[axis] = 0.0);
        for row in self.range(low[down], high[down]) {
            for column in self.range(low[across], high[across]) {
                let mut centre = DVec3::ZERO;
                (centre[across], centre[down]) = (f64::from(column) + 0.5, f64::from(row) + 0.5);
                if overlaps(corners.map(|corner| corner - centre), 0.5 + self.slack) {
                    for layer in self.range(low[axis], high[axis]) {
                        centre[axis] = f64::from(layer) + 0.5;
                        self.mark(centre);
                    }
                }
            }
        }
    }
}

fn ends(corners: [DVec3; 3]) -> (DVec3, DVec3) {
    let around = |(low, high): (DVec3, DVec3), corner: &DVec3| (low.min(*corner), high.max(*corner));
    corners.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), around)
}

/// Whether a triangle touches the cube of that half edge round the origin: no axis separates them (Akenine-Möller, "Fast 3D
/// Triangle-Box Overlap Testing", JGT 6(1), 2001).
fn overlaps(corners: [DVec3; 3], half: f64) -> bool {
    let edges: [DVec3; 3] = std::array::from_fn(|edge| corners[(edge + 1) % 3] - corners[edge]);
    let separates = |axis: DVec3| {
        let along = corners.map(|corner| corner.dot(axis));
        let reach = half * axis.abs().element_sum();
        let least = along.into_iter().fold(f64::INFINITY, f64::min);
        let greatest = along.into_iter().fold(f64::NEG_INFINITY, f64::max);
        least > reach || greatest < -reach
    };
    let crossed = edges.iter().flat_map(|edge| DVec3::AXES.map(|axis| edge.cross(axis)));
    !DVec3::AXES.into_iter().chain(crossed).chain([edges[0].cross(edges[1])]).any(separates)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Overlap is told by every kind of separating axis: a face of the cube, the triangle's plane, an edge of both.
    #[test]
    fn overlap_is_told_by_every_axis() {
        let triangle = |corners: [[f64; 3]; 3]| corners.map(DVec3::from);
        let through = triangle([[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.1]]);
        let beside = triangle([[0.6, -1.0, 0.0], [0.6, 1.0, 0.0], [2.0, 0.0, 0.0]]);
        let before = triangle([[3.2, -1.5, -0.0], [-1.5, 3.2, 0.0], [-0.3, -0.3, 2.3]]);
        let past_edge = triangle([[1.2, 0.0, -2.0], [0.0, 1.2, 2.0], [1.2, 1.2, 0.0]]);
        assert_eq!(
            [through, beside, before, past_edge].map(|corners| overlaps(corners, 0.5)),
            [true, false, false, false]
        );
        assert!(overlaps(beside, 0.61) && overlaps(before, 0.6) && overlaps(past_edge, 0.65));
    }
}
