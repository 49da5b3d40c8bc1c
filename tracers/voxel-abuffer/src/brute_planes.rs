//! The fragments that texels may and must have where fragments are oriented planes: triangle by triangle, on the host, in f64.

use tracebench_api::Geometry;
use tracebench_api::glam::{DVec2, DVec3};

use crate::brute_force::{Drawn, Placed, UNIT_SLACK, corners_of, place};
use crate::layout::{AXES, UnitSpace};

/// Bytes of an octagon are steps of so many texels: of its box, and of its diagonals. As in shaders/voxel-abuffer/plane_parts.wgsl.
pub(crate) const BOX_STEP: f64 = 1.125 / 255.0;
pub(crate) const DIAGONAL_STEP: f64 = 2.25 / 255.0;

/// How much slopes are off that are stored in 16 bits.
const SLOPE_STEP: f64 = 1.0 / 32_767.0;

/// Planes that rounding turns by more are noise.
const MAX_OFF: f64 = 1e-2;

/// By how much texels are grown, as `part_margin` there.
pub(crate) fn part_margin(image: u32) -> f64 {
    0.007_812_5 + f64::from(image) * 2.0_f64.powi(-20)
}

/// Places that f32 may be off by, texels: eight roundings, and a little.
fn place_loss(image: u32) -> f64 {
    1e-4 + f64::from(image) * 5e-7
}

/// Least and greatest places of a part relative to its texel's low corner: across, down, their sum and their difference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Octagon {
    pub low: [f64; 4],
    pub high: [f64; 4],
}

impl Octagon {
    fn of(places: impl IntoIterator<Item = DVec2>) -> Option<Self> {
        let mut found: Option<Self> = None;
        for place in places {
            let at = [place.x, place.y, place.x + place.y, place.x - place.y];
            let all = found.get_or_insert(Self { low: at, high: at });
            for (side, at) in at.into_iter().enumerate() {
                all.low[side] = all.low[side].min(at);
                all.high[side] = all.high[side].max(at);
            }
        }
        found
    }

    /// Whether it holds another that is smaller by `slack` on every side.
    fn holds(&self, other: &Self, slack: [f64; 4]) -> bool {
        (0..4).all(|side| {
            self.low[side] <= other.low[side] + slack[side] && self.high[side] >= other.high[side] - slack[side]
        })
    }
}

/// A stored fragment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PlaneFragment {
    /// At the texel's centre, in the cube.
    pub depth: f64,
    pub faces_along: bool,
    pub slopes: DVec2,
    pub part: Octagon,
    pub material: u32,
}

impl PlaneFragment {
    /// Of a node's code and its data.
    pub(crate) fn of(code: u32, data: [u32; 4]) -> Self {
        let [slopes, sides, diagonals, material] = data;
        let slope = |bits: u32| f64::from((bits as u16).cast_signed()).max(-32_767.0) * SLOPE_STEP;
        let [box_bytes, diagonal_bytes] = [sides, diagonals].map(|word| word.to_le_bytes().map(f64::from));
        let aside = |byte: usize| box_bytes[byte] * BOX_STEP - 0.0625;
        let sum = |byte: usize| diagonal_bytes[byte] * DIAGONAL_STEP - 0.125;
        let difference = |byte: usize| diagonal_bytes[byte] * DIAGONAL_STEP - 1.125;
        Self {
            depth: f64::from(f32::from_bits(code)),
            faces_along: code & 1 == 1,
            slopes: DVec2::new(slope(slopes), slope(slopes >> 16)),
            part: Octagon {
                low: [aside(0), aside(1), sum(0), difference(1)],
                high: [aside(2), aside(3), sum(2), difference(3)],
            },
            material,
        }
    }
}

/// A fragment that a texel may have.
#[derive(Clone, Copy, Debug)]
pub(crate) struct AllowedPlane {
    /// Whether the texel must have it.
    pub must: bool,
    depths: [f64; 2],
    faces_along: Option<bool>,
    pub slopes: DVec2,
    slope_slack: f64,
    /// What the part holds, if it must be there, and what holds it.
    inner: Option<Octagon>,
    outer: Octagon,
    slack: f64,
    material: u32,
    /// Least and greatest depth of what surely lies in the texel itself, in the cube.
    pub lies: Option<[f64; 2]>,
}

impl AllowedPlane {
    /// Whether a stored fragment can be it.
    pub(crate) fn fits(&self, fragment: &PlaneFragment) -> bool {
        let grown =
            [BOX_STEP + self.slack, BOX_STEP + self.slack, DIAGONAL_STEP + self.slack, DIAGONAL_STEP + self.slack];
        fragment.depth >= self.depths[0]
            && fragment.depth <= self.depths[1]
            && self.faces_along.is_none_or(|along| along == fragment.faces_along)
            && (fragment.slopes - self.slopes).abs().max_element() <= self.slope_slack
            && fragment.material == self.material
            && self.inner.is_none_or(|inner| fragment.part.holds(&inner, [self.slack; 4]))
            && self.outer.holds(&fragment.part, grown)
    }
}

/// What of a polygon lies on one side of a line: where the product with a normal is at least the offset (Sutherland, Hodgman, "Reentrant
/// Polygon Clipping", Communications of the ACM 17(1), 1974).
fn cut(polygon: &[DVec3], normal: DVec2, offset: f64) -> Vec<DVec3> {
    let inside = |point: DVec3| normal.dot(point.truncate()) - offset;
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    for (index, &point) in polygon.iter().enumerate() {
        let next = polygon[(index + 1) % polygon.len()];
        let (here, there) = (inside(point), inside(next));
        if here >= 0.0 {
            kept.push(point);
        }
        if (here >= 0.0) != (there >= 0.0) {
            kept.push(point + (next - point) * (here / (here - there)));
        }
    }
    kept
}

/// What of a triangle, places relative to a texel and depths, lies in the texel grown by a margin.
fn clipped(corners: [DVec3; 3], margin: f64) -> Vec<DVec3> {
    let sides =
        [(DVec2::X, -margin), (DVec2::NEG_X, -1.0 - margin), (DVec2::Y, -margin), (DVec2::NEG_Y, -1.0 - margin)];
    sides.into_iter().fold(corners.to_vec(), |polygon, (normal, offset)| cut(&polygon, normal, offset))
}

/// The corners of a grown texel that lie in a triangle, or so near to its sides' lines; of a sliver, whose turn may be rounded either way,
/// on either side of them.
fn corners_within(corners: [DVec3; 3], margin: f64, near: f64) -> impl Iterator<Item = DVec2> {
    let flat = corners.map(|corner| corner.truncate());
    let low = flat.iter().fold(DVec2::INFINITY, |low, at| low.min(*at)) - near;
    let high = flat.iter().fold(DVec2::NEG_INFINITY, |high, at| high.max(*at)) + near;
    let ends = [-margin, 1.0 + margin];
    let all = ends.into_iter().flat_map(move |y| ends.map(|x| DVec2::new(x, y)));
    all.filter(move |at| {
        let sides: [f64; 3] = std::array::from_fn(|side| {
            let along = (flat[(side + 1) % 3] - flat[side]).normalize_or_zero();
            along.perp_dot(*at - flat[side])
        });
        let is_within = [1.0, -1.0].into_iter().any(|turn| sides.iter().all(|side| turn * side >= -near));
        is_within && at.cmpge(low).all() && at.cmple(high).all()
    })
}

/// A triangle in the image that it is stored in.
struct Facing {
    drawn: Drawn,
    /// Texels across and down, depth in the cube.
    corners: [DVec3; 3],
    /// Whether its plane and its axis are what rounding makes them.
    unsure: bool,
    off: f64,
    material: u32,
}

impl Facing {
    /// None where another image has it.
    fn of(placed: &Placed, axis: usize, image: u32, material: u32) -> Option<Self> {
        let sizes = placed.across.abs();
        let noise = placed.off > MAX_OFF || sizes == DVec3::ZERO;
        let ahead =
            sizes[axis] - (0..AXES).filter(|other| *other != axis).map(|other| sizes[other]).fold(0.0, f64::max);
        let slack = 1e-6 + 4.0 * placed.off;
        if !noise && ahead < -slack {
            return None;
        }
        let drawn = placed.drawn(axis, image);
        let mut corners = placed.corners.map(|corner| DVec3::new(0.0, 0.0, corner[axis]));
        corners.iter_mut().zip(drawn.corners).for_each(|(corner, at)| (corner.x, corner.y) = (at.x, at.y));
        Some(Self { drawn, corners, unsure: noise || ahead <= slack, off: placed.off, material })
    }

    /// In a texel.
    fn allowed(&self, image: u32, texel: [u32; 2]) -> Option<AllowedPlane> {
        let (margin, slack) = (part_margin(image), place_loss(image));
        let corner = DVec2::new(f64::from(texel[0]), f64::from(texel[1]));
        let corners = self.corners.map(|at| at - corner.extend(0.0));
        let near = 0.5 * margin + 4.0 * slack;
        let flat = |polygon: Vec<DVec3>| polygon.into_iter().map(|at| at.truncate());
        let grown = flat(clipped(corners, margin + slack)).chain(corners_within(corners, margin, near));
        let outer = Octagon::of(grown)?;
        // A triangle that is all but a line may round to one, which is not stored.
        let inner = Octagon::of(flat(clipped(corners, margin - slack))).filter(|_| !self.unsure);
        let edge = f64::from(image);
        let noise = self.off > MAX_OFF;
        let slopes = (self.drawn.slope * edge).clamp(DVec2::NEG_ONE, DVec2::ONE);
        let slope_slack = if noise { 2.0 } else { SLOPE_STEP + 1e-5 + 8.0 * self.off };
        // As the device holds it, by its own slopes: which it does where a part lies beside the triangle, at a texel's corner near a tip.
        let reach = (slopes.abs().element_sum() + 2.0 * slope_slack) * (0.5 + margin) / edge;
        let at_centre = self.drawn.depth + self.drawn.slope.dot(corner + 0.5 - self.drawn.corners[0]);
        let off = self.drawn.depth_slack + self.off * 4.0 / edge;
        let held = |depth: f64| depth.clamp(self.drawn.least - reach, self.drawn.greatest + reach);
        let depths = match noise || self.unsure {
            true => [self.drawn.least - 1.1 / edge, self.drawn.greatest + 1.1 / edge],
            false => [held(at_centre - off), held(at_centre + off)],
        };
        let lies = clipped(corners, -slack).iter().map(|at| at.z).fold(None, |range: Option<[f64; 2]>, z| {
            Some(range.map_or([z, z], |[least, greatest]| [least.min(z), greatest.max(z)]))
        });
        Some(AllowedPlane {
            must: inner.is_some(),
            // Held within the cube.
            depths: [depths[0].min(1.0) - UNIT_SLACK, depths[1].max(0.0) + UNIT_SLACK],
            faces_along: self.drawn.faces_along.filter(|_| !noise),
            slopes,
            slope_slack,
            inner,
            outer,
            slack: 4.0 * slack,
            material: self.material,
            lies: lies.filter(|_| !self.unsure),
        })
    }
}

/// The fragments of every `step`-th texel along both edges of an image.
pub(crate) struct AllowedPlanes {
    pub step: u32,
    width: u32,
    texels: Vec<Vec<AllowedPlane>>,
}

impl AllowedPlanes {
    /// Those of a texel, whose coordinates are multiples of the step.
    pub(crate) fn of(&self, [x, y]: [u32; 2]) -> &[AllowedPlane] {
        &self.texels[(y / self.step * self.width + x / self.step) as usize]
    }
}

/// What every `step`-th texel of the image along an axis may and must have of a scene.
pub(crate) fn allowed_planes(space: UnitSpace, scene: &Geometry, axis: usize, step: u32) -> AllowedPlanes {
    let width = space.image.div_ceil(step);
    let mut texels = vec![Vec::new(); (width * width) as usize];
    for (triangle, material) in scene.triangles.iter().zip(scene.triangle_materials.iter()) {
        let placed = place(space, corners_of(scene, triangle));
        let Some(facing) = Facing::of(&placed, axis, space.image, *material) else { continue };
        let low = facing.corners.iter().fold(DVec3::INFINITY, |low, at| low.min(*at));
        let high = facing.corners.iter().fold(DVec3::NEG_INFINITY, |high, at| high.max(*at));
        let range = |low: f64, high: f64| {
            let cell = |at: f64| at / f64::from(step);
            let first = cell(low - 1.1).ceil().clamp(0.0, f64::from(width)) as u32;
            first..(cell(high + 0.1).floor() + 1.0).clamp(0.0, f64::from(width)) as u32
        };
        for row in range(low.y, high.y) {
            for column in range(low.x, high.x) {
                let allowed = facing.allowed(space.image, [column * step, row * step]);
                texels[(row * width + column) as usize].extend(allowed);
            }
        }
    }
    AllowedPlanes { step, width, texels }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Codes and data are read as the shader writes them, by hand: slopes of 1 and -1, a whole texel, and one cut along its diagonal.
    #[test]
    fn words_are_read_as_they_are_written() {
        let data = [0x8001_7fff, u32::from_le_bytes([14, 14, 241, 241]), u32::from_le_bytes([14, 14, 128, 241]), 7];
        let read = PlaneFragment::of(0.25_f32.to_bits() | 1, data);
        assert_eq!((read.faces_along, read.slopes, read.material), (true, DVec2::new(1.0, -1.0), 7));
        assert!((read.depth - 0.25).abs() < 1e-7);
        let whole = Octagon { low: [0.0, 0.0, 0.0, -1.0], high: [1.0, 1.0, 1.0, 1.0] };
        let step = [BOX_STEP, BOX_STEP, DIAGONAL_STEP, DIAGONAL_STEP];
        assert!(read.part.holds(&whole, step) && whole.holds(&read.part, step), "{read:?}");
    }

    /// The part of a triangle in a texel, by hand: half of it, the half beyond its diagonal.
    #[test]
    fn a_part_is_the_polygon_in_its_texel() {
        let corners = [DVec3::new(-4.0, 5.0, 0.0), DVec3::new(5.0, -4.0, 0.0), DVec3::new(6.0, 6.0, 0.0)];
        let part = Octagon::of(clipped(corners, 0.0).into_iter().map(|at| at.truncate())).unwrap();
        let expected = Octagon { low: [0.0, 0.0, 1.0, -1.0], high: [1.0, 1.0, 2.0, 1.0] };
        assert!(part.holds(&expected, [1e-12; 4]) && expected.holds(&part, [1e-12; 4]), "{part:?}");
        assert_eq!(corners_within(corners, 0.0, 0.1).collect::<Vec<_>>(), [DVec2::X, DVec2::Y, DVec2::ONE]);
        assert!(clipped(corners.map(|corner| corner + DVec3::X * 20.0), 0.0).is_empty());
    }
}
