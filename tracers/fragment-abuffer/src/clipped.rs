//! What pixels may and must have of triangles that are clipped to them, in f64.
//!
//! The device grows pixels by [`margin`] when it clips. What it stores must lie between what f64 finds for pixels grown by half of that and
//! by one and a half, with what f32 loses of coordinates on either side. A triangle with an edge through a view's eye is let off there:
//! which pixels it touches is noise.

use tracebench_api::glam::{DVec2, DVec3, Vec3};
use tracebench_api::{Geometry, View};
use tracebench_kit::{TileBounds, clipped_depths, clipped_polygon, eye_space, touched_tiles};

/// As `DEPTH_SLACK` in shaders/fragment-abuffer/fill.wgsl.
const DEPTH_SLACK: f64 = 9.536_743_164_062_5e-7;

/// What f32 loses of a coordinate that goes through a difference and a rotation, relative to the greatest one: eight roundings.
const COORDINATE_LOSS: f64 = 4.768_371_582_031_25e-7;

/// By how much the product of two edges of size 1 is off in f32: of edges that are differences of one rounding, divided by their sizes, a
/// sum of two products in every component.
const NORMAL_LOSS: f64 = 2e-6;

/// Sines of the angle between edges below which f32 may take a triangle to have no area.
const NO_AREA: f64 = 1e-6;

/// As `OUTLINE_PARTS` in shaders/fragment-abuffer/layout.wgsl, and all of their bits.
const PARTS: [u32; 2] = [6, 5];
const WHOLE: u32 = (1 << (PARTS[0] * PARTS[1])) - 1;

/// Twice `OUTLINE_MARGIN` in shaders/fragment-abuffer/fill.wgsl, pixels.
const OUTLINE_SLACK: f64 = 1.0 / 32.0;

/// As `tile_margin` in shaders/shared/tile_clip.wgsl, in pixels.
fn margin(size: [u32; 2]) -> f64 {
    9.765_625e-4 + f64::from(size[0].max(size[1])) * 4.768_371_58e-7
}

/// What is stored of a triangle in a pixel.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Part {
    /// Least and greatest eye depth; of a point both are its depth.
    pub depths: [f32; 2],
    pub normal: Vec3,
    /// How far the plane lies from the eye along the normal; none of a point.
    pub offset: Option<f32>,
    /// Bits of the parts of the pixel that it touches; none of a fragment that fills its pixel.
    pub outline: Option<u32>,
    pub material: u32,
}

/// What a pixel may have of a triangle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct AllowedPart {
    /// Whether it must have it.
    pub must: bool,
    /// Eye depths that the part may reach to.
    pub outer: [f64; 2],
    /// Eye depths that it must reach to, where that can be told.
    pub inner: Option<[f64; 2]>,
    /// Bits that an outline must have, and those that it may have.
    outlines: [u32; 2],
    normal: DVec3,
    normal_slack: f64,
    /// From the eye.
    corners: [DVec3; 3],
    offset_slack: f64,
    material: u32,
}

impl AllowedPart {
    /// Whether what is stored can be this one.
    pub(crate) fn fits(&self, part: &Part) -> bool {
        let (depths, normal) = (part.depths.map(f64::from), part.normal.as_dvec3());
        let is_part = match (part.offset, self.inner) {
            (Some(_), Some(inner)) => depths[0] <= inner[0] && depths[1] >= inner[1],
            _ => true,
        };
        let on_plane = |corner: &DVec3| {
            part.offset.is_none_or(|offset| (normal.dot(*corner) - f64::from(offset)).abs() <= self.offset_slack)
        };
        let [must, may] = self.outlines;
        is_part
            && part.outline.is_none_or(|outline| outline & must == must && (outline & !may == 0 || outline == WHOLE))
            && depths[0] >= self.outer[0]
            && depths[1] <= self.outer[1]
            && (normal - self.normal).length() <= self.normal_slack
            && self.corners.iter().all(on_plane)
            && part.material == self.material
    }
}

/// A triangle in a view, in eye space.
struct Seen<'a> {
    view: &'a View,
    corners: [DVec3; 3],
    /// What f32 loses of its coordinates, scene units.
    loss: f64,
}

impl<'a> Seen<'a> {
    fn new(view: &'a View, corners: [DVec3; 3]) -> Self {
        let size = corners.iter().map(|corner| corner.abs().max_element()).fold(view.eye.abs().max_element(), f64::max);
        Self { view, corners: corners.map(|corner| eye_space(view, corner)), loss: size * COORDINATE_LOSS }
    }

    /// Whether an edge passes the eye within what f32 may be wrong by.
    fn meets_eye(&self) -> bool {
        let [a, b, c] = self.corners;
        let distance = |from: DVec3, to: DVec3| {
            let along = to - from;
            let share = (-from.dot(along) / along.length_squared()).clamp(0.0, 1.0);
            (from + along * if share.is_nan() { 0.0 } else { share }).length()
        };
        [distance(a, b), distance(b, c), distance(c, a)].into_iter().any(|near| near < 64.0 * self.loss)
    }

    /// How far a border may be off, pixels, for what lies at least so deep.
    fn border_loss(&self, depth: f64) -> f64 {
        let tangent = self.view.tan_half_width.min(self.view.tan_half_height);
        let pixels = f64::from(self.view.size[0].max(self.view.size[1]));
        self.loss / depth.max(self.view.near) * pixels / (2.0 * tangent)
    }

    /// The depths in a pixel: those that a part may reach to, and those that one must, if there must be one.
    fn depths_in(&self, pixel: [u32; 2]) -> Option<([f64; 2], Option<[f64; 2]>)> {
        let slack = |depth: f64| depth * 4.0 * DEPTH_SLACK + 2.0 * self.loss;
        let within = |margin: f64, near: f64, far: f64| {
            let view = View { near, far, ..*self.view };
            clipped_depths(&view, TileBounds::of_tile(pixel, 1.0, margin), self.corners)
        };
        let (near, far) = (self.view.near, self.view.far);
        let (min_near, max_far) = (f64::max(near - slack(near), 0.5 * near), far + slack(far));
        let grown = |by: f64| within(1.5 * margin(self.view.size) + by, min_near, max_far);
        // The loss is least where the triangle is farthest: grown by that of near first, to learn how near it comes.
        let [nearest, _] = grown(self.border_loss(near))?;
        let by = self.border_loss(nearest);
        let [least, greatest] = grown(by)?;
        let shrunk = if by < 0.25 {
            within(0.5 * margin(self.view.size) - by, near + slack(near), far - slack(far))
        } else {
            None
        };
        // Where a corner of the pixel shows the triangle, its depth is that of a plane which is turned, within the triangle's own depths.
        let turned = self.turned_by(pixel);
        let inner = shrunk.map(|[least, greatest]| {
            [least * (1.0 + turned) + slack(least), greatest * (1.0 - turned) - slack(greatest)]
        });
        let depths = self.corners.map(|corner| corner.z);
        let lowest = f64::max(depths.into_iter().fold(f64::INFINITY, f64::min), near);
        let highest = f64::min(depths.into_iter().fold(0.0, f64::max), far);
        let least = f64::min(least, f64::max(least * (1.0 - turned), lowest));
        let greatest = f64::max(greatest, f64::min(greatest * (1.0 + turned), highest));
        Some(([least - slack(least), greatest + slack(greatest)], inner))
    }

    /// The parts of a pixel that an outline must have, and those that it may have: those within the rectangle about the triangle.
    fn outlines_in(&self, pixel: [u32; 2], nearest: f64) -> [u32; 2] {
        let (view, by) = (self.view, self.border_loss(nearest));
        let size = DVec2::new(f64::from(view.size[0]), f64::from(view.size[1]));
        // The rectangle is that of all of the triangle between near and far, however far beyond the image.
        let image = TileBounds { low: DVec2::splat(-1e30), high: DVec2::splat(1e30) };
        let scale = DVec2::new(0.5 * size.x / view.tan_half_width, -0.5 * size.y / view.tan_half_height);
        let seen = clipped_polygon(view, image, self.corners);
        let places = seen.iter().map(|point| 0.5 * size + DVec2::new(point.x, point.y) / point.z * scale);
        let nothing = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        let (first, last) = places.fold(nothing, |(low, high), at| (low.min(at), high.max(at)));
        let edges = DVec2::new(f64::from(PARTS[0]), f64::from(PARTS[1]));
        let slack = OUTLINE_SLACK + by;
        let mut outlines = [0; 2];
        for bit in 0..PARTS[0] * PARTS[1] {
            let part = DVec2::new(f64::from(bit % PARTS[0]), f64::from(bit / PARTS[0]));
            let low = DVec2::new(f64::from(pixel[0]), f64::from(pixel[1])) + part / edges;
            let high = low + 1.0 / edges;
            let may = (low - slack).cmple(last).all() && (high + slack).cmpge(first).all();
            let shrunk = TileBounds { low: low + by, high: high - by };
            let must = may && by < 0.05 && clipped_depths(view, shrunk, self.corners).is_some();
            outlines[0] |= u32::from(must) << bit;
            outlines[1] |= u32::from(may) << bit;
        }
        outlines
    }

    /// By how much, relative, a depth of the triangle's plane in a pixel may be off where corners are off by the loss: the thinner the
    /// triangle, the more its plane turns; the more slanted, the more that moves depths.
    fn turned_by(&self, pixel: [u32; 2]) -> f64 {
        let across = across(self.corners);
        let edges = [0, 1, 2].map(|at| (self.corners[at] - self.corners[(at + 1) % 3]).length());
        // A triangle is as wide as its shortest edge times a sine.
        let shortest = edges.into_iter().fold(f64::INFINITY, f64::min);
        let turn = 4.0 * self.loss / (0.25 * shortest * across.length()).max(1e-300);
        let [x, y] = pixel.map(f64::from);
        let line = |x: f64, y: f64| {
            let at = self.view.direction_through(x, y);
            DVec3::new(at.dot(self.view.right), at.dot(self.view.up), 1.0)
        };
        let normal = across.normalize_or_zero();
        let slopes = [(x, y), (x + 1.0, y), (x, y + 1.0), (x + 1.0, y + 1.0)].map(|(x, y)| normal.dot(line(x, y)));
        let is_one_sided = slopes.iter().all(|slope| *slope > 0.0) || slopes.iter().all(|slope| *slope < 0.0);
        let least = slopes.iter().map(|slope| slope.abs()).fold(f64::INFINITY, f64::min);
        let reach = line(x + 0.5, y + 0.5).length() + 1.0;
        if is_one_sided { (2.0 * turn * reach / least).min(1.0) } else { 1.0 }
    }
}

/// The parts that every `step`-th pixel of a view may and must have.
pub(crate) struct AllowedParts {
    step: u32,
    width: u32,
    pixels: Vec<Vec<AllowedPart>>,
}

impl AllowedParts {
    pub(crate) fn new(view: &View, scene: &Geometry, step: u32, masked: bool) -> Self {
        let [width, height] = view.size.map(|edge| edge.div_ceil(step));
        let mut all = Self { step, width, pixels: vec![Vec::new(); (width * height) as usize] };
        for (triangle, material) in scene.triangles.iter().zip(scene.triangle_materials.iter()) {
            let corners = triangle.map(|vertex| Vec3::from(scene.positions[vertex as usize]).as_dvec3());
            all.add(&Seen::new(view, corners), corners, *material, masked);
        }
        all
    }

    /// Those of a pixel, whose coordinates are multiples of the step.
    pub(crate) fn of(&self, [x, y]: [u32; 2]) -> &[AllowedPart] {
        &self.pixels[(y / self.step * self.width + x / self.step) as usize]
    }

    fn add(&mut self, seen: &Seen<'_>, corners: [DVec3; 3], material: u32, masked: bool) {
        let view = seen.view;
        let across = across(corners);
        let longest =
            [0, 1, 2].map(|at| (corners[at] - corners[(at + 1) % 3]).length()).into_iter().fold(0.0, f64::max);
        let normal_slack = NORMAL_LOSS / across.length().max(1e-30) + NORMAL_LOSS;
        let from_eye = corners.map(|corner| corner - view.eye);
        let reach = from_eye.iter().map(|corner| corner.length()).fold(view.eye.length(), f64::max);
        let part = AllowedPart {
            must: false,
            outer: [0.0, view.far * 1.01],
            inner: None,
            outlines: [0, WHOLE],
            normal: across.normalize_or_zero(),
            normal_slack,
            corners: from_eye,
            // The plane is right in one corner but for the loss, and turned round that by what its normal is off.
            offset_slack: normal_slack * longest + COORDINATE_LOSS * reach,
            material,
        };
        let noise = seen.meets_eye();
        let beyond = if noise { f64::from(view.size[0].max(view.size[1])) } else { seen.border_loss(view.near) };
        let Some([low, high]) = touched_tiles(view, view.size, 1.0, 2.0 + beyond, seen.corners) else { return };
        let first = low.map(|at| at.div_ceil(self.step) * self.step);
        for y in (first[1]..=high[1]).step_by(self.step as usize) {
            for x in (first[0]..=high[0]).step_by(self.step as usize) {
                let allowed = match (noise, seen.depths_in([x, y])) {
                    (true, _) => part,
                    (false, None) => continue,
                    (false, Some((outer, inner))) => {
                        let must = inner.is_some() && across.length() > NO_AREA;
                        let outlines = if masked { seen.outlines_in([x, y], outer[0]) } else { part.outlines };
                        AllowedPart { must, outer, inner, outlines, ..part }
                    }
                };
                self.pixels[(y / self.step * self.width + x / self.step) as usize].push(allowed);
            }
        }
    }
}

/// As `facet` in shaders/shared/plane_depth.wgsl: the product of the two shorter edges, each of size 1.
fn across([a, b, c]: [DVec3; 3]) -> DVec3 {
    let size = |edge: DVec3| edge.abs().max_element();
    let (ab, bc, ca) = (b - a, c - b, a - c);
    let (first, second) = match [size(ab), size(bc), size(ca)] {
        [ab_size, bc_size, ca_size] if ab_size >= bc_size.max(ca_size) => (bc, ca),
        [_, bc_size, ca_size] if bc_size >= ca_size => (ca, ab),
        _ => (ab, bc),
    };
    let across = (first / size(first)).cross(second / size(second));
    if across.is_finite() { across } else { DVec3::ZERO }
}

/// Holds what is stored in a pixel against what may and what must be there.
pub(crate) fn compare(stored: &[Part], allowed: &[AllowedPart], one_layer: bool) -> Result<(), String> {
    if let Some(part) = stored.iter().find(|part| !allowed.iter().any(|each| each.fits(part))) {
        let off = |each: &AllowedPart| (part.normal.as_dvec3() - each.normal).length();
        let nearest = allowed.iter().min_by(|a, b| off(a).total_cmp(&off(b)));
        return Err(format!("no triangle gives {part:?}, the one that it comes nearest to {nearest:?}"));
    }
    if stored.len() > allowed.len() {
        return Err(format!("{} fragments, {} triangles may give one", stored.len(), allowed.len()));
    }
    if one_layer {
        // What lies surely before the nearest fragment is missing.
        let nearest = stored.first().map_or(f64::INFINITY, |part| f64::from(part.depths[0]));
        let nearer = allowed.iter().find(|each| each.must && each.inner.is_some_and(|inner| inner[0] < nearest));
        return nearer.map_or(Ok(()), |each| Err(format!("{each:?} is nearer than {nearest}")));
    }
    let required = || allowed.iter().filter(|each| each.must);
    if let Some(missing) = required().find(|each| !stored.iter().any(|part| each.fits(part))) {
        return Err(format!("{missing:?} is not stored"));
    }
    let least = required().count();
    if stored.len() < least { Err(format!("{} fragments instead of {least}", stored.len())) } else { Ok(()) }
}
