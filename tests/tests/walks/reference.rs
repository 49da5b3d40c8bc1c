//! Rays and planes in f64, and how far f32 may be from them.

use tracebench_api::glam::{DVec2, DVec3};
use tracebench_kit::ViewUniform;

/// Half ulps between a value and f64's, over the sum of what it is made of, with room for a driver that contracts or reorders:
/// the tangent of a line, its products with origin and direction, their sums, a division.
const ROUNDINGS: f64 = 24.0;
const HALF_ULP: f64 = f32::EPSILON as f64 / 2.0;

/// A part of a ray; begin > end for none.
#[derive(Clone, Copy, Debug)]
pub struct Span {
    pub begin: f64,
    pub end: f64,
}

/// Points are inside where the product with the normal is at least the offset. `made_of` is what the normal's components were
/// computed from, as large as they may be.
#[derive(Clone, Copy, Debug)]
pub struct Plane {
    normal: DVec3,
    made_of: DVec3,
    offset: f64,
}

/// A ray in eye space.
#[derive(Clone, Copy, Debug)]
pub struct EyeRay {
    pub origin: DVec3,
    pub direction: DVec3,
}

impl EyeRay {
    pub fn at(&self, t: f64) -> DVec3 {
        self.origin + self.direction * t
    }

    fn value(&self, plane: &Plane, t: f64) -> f64 {
        plane.normal.dot(self.at(t)) - plane.offset
    }

    fn slope(&self, plane: &Plane) -> f64 {
        plane.normal.dot(self.direction)
    }

    fn slack(&self, plane: &Plane, t: f64) -> f64 {
        let size = self.origin.abs() + self.direction.abs() * t.abs();
        ROUNDINGS * HALF_ULP * (plane.made_of.dot(size) + plane.offset.abs()) + f64::from(f32::MIN_POSITIVE)
    }

    /// Beyond what rounding explains.
    pub fn is_outside(&self, plane: &Plane, t: f64) -> bool {
        self.value(plane, t) < -self.slack(plane, t)
    }

    /// As near to a plane as rounding can tell.
    pub fn is_at(&self, plane: &Plane, t: f64) -> bool {
        self.value(plane, t).abs() <= self.slack(plane, t)
    }

    /// The part inside of all planes.
    fn clipped(&self, planes: &[Plane], whole: Span) -> Span {
        planes.iter().fold(whole, |Span { begin, end }, plane| {
            let (value, slope) = (self.value(plane, 0.0), self.slope(plane));
            match slope {
                0.0 if value < 0.0 => Span { begin, end: f64::NEG_INFINITY },
                0.0 => Span { begin, end },
                _ if slope > 0.0 => Span { begin: begin.max(-value / slope), end },
                _ => Span { begin, end: end.min(-value / slope) },
            }
        })
    }

    /// A parameter at which the ray is inside of all planes, by more than rounding.
    pub fn surely_inside(&self, planes: &[Plane], whole: Span) -> Option<f64> {
        let Span { begin, end } = self.clipped(planes, whole);
        let middle = begin.midpoint(end);
        let inside = |plane: &Plane| self.value(plane, middle) > self.slack(plane, middle);
        (begin < end && planes.iter().all(inside)).then_some(middle)
    }

    /// The relative rounding of a point's place in the image and of its depth, no less than at near.
    pub fn relative_rounding(&self, t: f64, tangents: DVec2, near: f64) -> f64 {
        let (size, depth) = (self.origin.abs() + self.direction.abs() * t, self.at(t).z.max(near));
        ROUNDINGS * HALF_ULP * (1.0 + (size.z + (size.truncate() / tangents).max_element()) / depth)
    }
}

/// The planes through the eye and lines of the image, `low` and `high` from its top left corner: what lies left of right, right
/// of left, below the upper and above the lower one is inside.
fn image_planes(view: &ViewUniform, low: DVec2, high: DVec2, slack: f64) -> [Plane; 4] {
    let size = DVec2::from(view.size.map(f64::from));
    let tangents = DVec2::new(f64::from(view.tan_half_width), f64::from(view.tan_half_height)) * slack;
    let (low, high) = ((low * 2.0 / size - 1.0) * tangents, (high * 2.0 / size - 1.0) * tangents);
    // Rows count downwards, eye space upwards.
    [
        (DVec3::new(-1.0, 0.0, high.x), tangents.x),
        (DVec3::new(1.0, 0.0, -low.x), tangents.x),
        (DVec3::new(0.0, -1.0, -low.y), tangents.y),
        (DVec3::new(0.0, 1.0, high.y), tangents.y),
    ]
    .map(|(normal, tangent)| Plane { normal, made_of: normal.abs().with_z(tangent), offset: 0.0 })
}

/// Right, left, upper and lower side, far, near.
pub fn frustum(view: &ViewUniform, slack: f64) -> [Plane; 6] {
    let [right, left, upper, lower] = image_planes(view, DVec2::ZERO, DVec2::from(view.size.map(f64::from)), slack);
    let across = |normal: DVec3, offset: f32| Plane { normal, made_of: DVec3::Z, offset: f64::from(offset) };
    [right, left, upper, lower, across(DVec3::NEG_Z, -view.far), across(DVec3::Z, view.near)]
}

/// The sides of a cell of a level; those that are the image's reach as far as the last cell does.
pub fn pixel_planes(view: &ViewUniform, cell: [i32; 2], level: u32) -> [Plane; 4] {
    let corner = |add: i32| DVec2::from(cell.map(|at| f64::from((at + add) << level)));
    image_planes(view, corner(0), corner(1), 1.0)
}

/// Says what is wrong with a span that was found for the part of a ray inside of some planes: it must lie within them, end where
/// the whole or a plane ends it, and be there where the ray is surely inside.
pub fn stray_span(ray: &EyeRay, planes: &[Plane], whole: Span, found: Span) -> Option<String> {
    let Span { begin, end } = found;
    if begin > end {
        let inside = ray.surely_inside(planes, whole)?;
        return Some(format!("{ray:?} is inside at {inside}, and no span was found but {found:?}"));
    }
    let outside = |t: f64| t < whole.begin || t > whole.end || planes.iter().any(|plane| ray.is_outside(plane, t));
    if outside(begin) || outside(end) {
        return Some(format!("{ray:?} is not inside all over {found:?} of {whole:?}"));
    }
    let bound = |t: f64, rising: f64| {
        planes.iter().any(|plane| ray.slope(plane) * rising >= -ray.slack(plane, 1.0) && ray.is_at(plane, t))
    };
    let tight = (begin == whole.begin || bound(begin, 1.0)) && (end == whole.end || bound(end, -1.0));
    (!tight).then(|| format!("{ray:?} is inside beyond {found:?}"))
}

/// Whether a ray that is inside of all planes at `inside` leaves them by the one of this number; by none for a greater number.
pub fn leaves_by(ray: &EyeRay, planes: &[Plane], side: usize, inside: f64) -> bool {
    let whole = Span { begin: inside, end: 1e38 };
    let Span { end, .. } = ray.clipped(planes, whole);
    match planes.get(side) {
        Some(plane) => end < 1e38 && ray.is_at(plane, end),
        None => end >= 1e37,
    }
}
