//! The fragments that pixels may and must have, by a rasterizer on the host, in f64, triangle by triangle.

use tracebench_api::glam::{DVec2, DVec3, Vec3};
use tracebench_api::{Geometry, Rasterizer, View};

use crate::{TileBounds, clipped_polygon, eye_space};

/// A fragment that a structure stores.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fragment {
    /// Eye depth, scene units.
    pub depth: f32,
    /// The triangle's unit normal.
    pub normal: Vec3,
    /// The triangle's material.
    pub material: u32,
}

/// Within which distance of a triangle's border the device may decide either way, pixels, beside what it snaps: positions of corners
/// are f32.
const BORDER_SLACK: f64 = 1.0 / 64.0;

/// Within which distance of a triangle's border a device may decide either way, pixels, with what it was found to snap.
pub fn undecided_border(rasterizer: &Rasterizer) -> f64 {
    rasterizer.border_pixels() + BORDER_SLACK
}

/// Relative difference of depths that planes in f32 may make.
const DEPTH_SLACK: f64 = 2e-5;

/// Length by which a normal in f32 may be off, over the sine of the triangle's angle.
const NORMAL_SLACK: f64 = 1e-4;

/// By how much the normal of a plane in f32 may be off, over the sine between the two shorter edges that it is made of.
const PLANE_SLACK: f64 = 2e-6;

/// A fragment that a pixel may have.
#[derive(Clone, Copy, Debug)]
pub struct Allowed {
    /// Whether the pixel must have it: its centre lies well inside of the triangle.
    pub must: bool,
    /// Least and greatest eye depth, scene units.
    pub depths: [f64; 2],
    /// Whether the eye lies behind the triangle: its corners run clockwise in the view.
    pub faces_away: bool,
    normal: DVec3,
    normal_slack: f64,
    material: u32,
}

impl Allowed {
    /// Whether a stored fragment can be this one.
    pub fn fits(&self, fragment: &Fragment) -> bool {
        let depth = f64::from(fragment.depth);
        depth >= self.depths[0]
            && depth <= self.depths[1]
            && (fragment.normal.as_dvec3() - self.normal).length() <= self.normal_slack
            && fragment.material == self.material
    }
}

/// The fragments of every `step`-th pixel along both axes of a view.
#[derive(Clone, Debug)]
pub struct AllowedFragments {
    step: u32,
    width: u32,
    pixels: Vec<Vec<Allowed>>,
}

impl AllowedFragments {
    /// Those of a pixel, whose coordinates are multiples of the step.
    pub fn of(&self, [x, y]: [u32; 2]) -> &[Allowed] {
        &self.pixels[(y / self.step * self.width + x / self.step) as usize]
    }
}

/// A triangle on the image: a convex polygon, and its 1/depth as a function of the place.
struct Drawn {
    corners: Vec<DVec2>,
    /// Least and greatest eye depth of the clipped triangle.
    depths: [f64; 2],
    /// The same of all of it.
    own_depths: [f64; 2],
    /// By how much 1/depth is off along a line of length 1 for what f32 makes of the plane, and how far the triangle reaches: much of a
    /// sliver.
    turn: f64,
    reach: f64,
    /// 1/depth = (x, y, 1) . plane, pixels; none for a triangle edge-on.
    plane: Option<DVec3>,
}

fn draw(view: &View, triangle: [DVec3; 3]) -> Option<Drawn> {
    let size = DVec2::new(f64::from(view.size[0]), f64::from(view.size[1]));
    // A little beyond the image, so that clipping adds no border that pixels' centres come near.
    let whole = TileBounds { low: DVec2::splat(-2.0), high: size + 2.0 };
    // What lies in the near plane or the far one may be drawn.
    let grown = View { near: view.near * (1.0 - DEPTH_SLACK), far: view.far * (1.0 + DEPTH_SLACK), ..*view };
    let polygon = clipped_polygon(&grown, whole, triangle);
    let scale = DVec2::new(0.5 * size.x / view.tan_half_width, -0.5 * size.y / view.tan_half_height);
    let place = |point: &DVec3| 0.5 * size + DVec2::new(point.x, point.y) / point.z * scale;
    let corners: Vec<DVec2> = polygon.iter().map(place).collect();
    let depths_of = |points: &[DVec3]| {
        let around = |[least, greatest]: [f64; 2], point: &DVec3| [least.min(point.z), greatest.max(point.z)];
        points.iter().fold([f64::INFINITY, 0.0], around)
    };
    let (depths, own_depths) = (depths_of(&polygon), depths_of(&triangle));
    // A point on the line through (x, y, 1) has depth 1/(n . (x, y, 1) / n . a).
    let normal = (triangle[1] - triangle[0]).cross(triangle[2] - triangle[0]);
    let offset = normal.dot(triangle[0]);
    let plane = (offset != 0.0).then(|| {
        let slope = DVec2::new(normal.x, normal.y) / scale;
        DVec3::new(slope.x, slope.y, normal.z - slope.dot(0.5 * size)) / offset
    });
    let mut edges: [DVec3; 3] = std::array::from_fn(|edge| triangle[(edge + 1) % 3] - triangle[edge]);
    edges.sort_by(|a, b| a.length().total_cmp(&b.length()));
    let sine = edges[0].normalize_or_zero().cross(edges[1].normalize_or_zero()).length();
    let distance = offset.abs() / normal.length();
    let turn = PLANE_SLACK / (sine * distance).max(1e-300);
    let reach = triangle.iter().map(|corner| corner.length()).fold(0.0, f64::max);
    (corners.len() > 2).then_some(Drawn { corners, depths, own_depths, turn, reach, plane })
}

impl Drawn {
    /// How far a point lies inside of the polygon, pixels; negative outside.
    fn inside(&self, at: DVec2) -> f64 {
        let count = self.corners.len();
        let edge = |index: usize| (self.corners[index], self.corners[(index + 1) % count]);
        let area: f64 = (0..count).map(|index| edge(index).0.perp_dot(edge(index).1)).sum();
        let distance = |(a, b): (DVec2, DVec2)| {
            let along = b - a;
            // Equal corners make no border.
            if along.length() > 0.0 { along.perp_dot(at - a) * area.signum() / along.length() } else { f64::INFINITY }
        };
        (0..count).map(|index| distance(edge(index))).fold(f64::INFINITY, f64::min)
    }

    /// The eye depths that a fragment at a pixel's centre may have, where corners are off by the border's width.
    fn depths_at(&self, view: &View, at: DVec2, border: f64) -> [f64; 2] {
        let grown = |[least, greatest]: [f64; 2]| [least * (1.0 - DEPTH_SLACK), greatest * (1.0 + DEPTH_SLACK)];
        let Some(plane) = self.plane else { return grown(self.depths) };
        let inverse = plane.dot(at.extend(1.0));
        let off = (plane.x.abs() + plane.y.abs()) * border;
        let depth = |inverse: f64| if inverse * view.far > 1.0 { 1.0 / inverse } else { view.far };
        let within = |off: f64| grown([depth(inverse + off), depth(inverse - off)]);
        let [near, far] = within(off);
        // What rounding makes of the plane is held between the triangle's own depths.
        let turned = self.turn * (view.direction_through(at.x, at.y).length() + inverse.abs() * self.reach);
        let ([nearest, farthest], [least, greatest]) = (within(off + turned), grown(self.own_depths));
        [near.min(nearest.max(least)), far.max(farthest.min(greatest))]
    }
}

/// What every `step`-th pixel of a view may and must have of a scene, where the device decides within `border` of borders.
pub fn allowed_fragments(view: &View, scene: &Geometry, step: u32, border: f64) -> AllowedFragments {
    let [width, height] = view.size.map(|edge| edge.div_ceil(step));
    let mut pixels = vec![Vec::new(); (width * height) as usize];
    for (triangle, material) in scene.triangles.iter().zip(scene.triangle_materials.iter()) {
        let corners = triangle.map(|vertex| Vec3::from(scene.positions[vertex as usize]).as_dvec3());
        let Some(drawn) = draw(view, corners.map(|corner| eye_space(view, corner))) else { continue };
        let (first, second) = (corners[1] - corners[0], corners[2] - corners[0]);
        let across = first.normalize_or_zero().cross(second.normalize_or_zero());
        let low = drawn.corners.iter().fold(DVec2::INFINITY, |low, at| low.min(*at));
        let high = drawn.corners.iter().fold(DVec2::NEG_INFINITY, |high, at| high.max(*at));
        let range = |low: f64, high: f64, count: u32| {
            let cell = |at: f64| at / f64::from(step);
            let first = cell(low - 1.0).ceil().clamp(0.0, f64::from(count)) as u32;
            let end = (cell(high + 1.0).floor() + 1.0).clamp(0.0, f64::from(count)) as u32;
            first..end
        };
        for row in range(low.y, high.y, height) {
            for column in range(low.x, high.x, width) {
                let at = DVec2::new(f64::from(column * step) + 0.5, f64::from(row * step) + 0.5);
                let inside = drawn.inside(at);
                if inside > -border {
                    let depths = drawn.depths_at(view, at, border);
                    // In the near plane or the far one rounding decides.
                    let in_range = depths[0] > view.near && depths[1] < view.far;
                    pixels[(row * width + column) as usize].push(Allowed {
                        must: inside > border && in_range,
                        depths,
                        faces_away: across.dot(corners[0] - view.eye) > 0.0,
                        normal: across.normalize_or_zero(),
                        normal_slack: NORMAL_SLACK / across.length().max(1e-30),
                        material: *material,
                    });
                }
            }
        }
    }
    AllowedFragments { step, width, pixels }
}
