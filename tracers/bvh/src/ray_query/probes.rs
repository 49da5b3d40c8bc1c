//! Rays by which a structure that cannot be read back is checked: one through the middle of every triangle.

use glam::DVec3;
use tracebench_api::Ray;

/// A triangle is fat enough to be found for certain if the largest circle in it has this radius, in units of its farthest
/// coordinate: rounding in f32 moves a ray by a hundredth of that.
const MIN_INRADIUS: f64 = 1e-5;

/// Distance at which a probe begins and ends off its triangle, in radii of the largest circle in it.
const REACH: f64 = 8.0;

/// A ray a triangle, in the order of the triangles, square to it through the centre of its largest circle; and whether the
/// triangle is looked for: if it is fat enough to be found for certain, and one of `most` evenly spread ones. Rays of others
/// run far from everything.
pub(super) fn probes(positions: &[[f32; 3]], triangles: &[[u32; 3]], most: usize) -> Vec<(Ray, bool)> {
    let step = triangles.len().div_ceil(most).max(1);
    let aside = Ray { origin: [1e15; 3], t_min: 0.0, direction: [0.0, 0.0, 1.0], t_max: 1.0 };
    let probe_of = |(index, corners): (usize, &[u32; 3])| {
        if index % step != 0 {
            return (aside, false);
        }
        probe(corners.map(|vertex| DVec3::from(positions[vertex as usize].map(f64::from))))
    };
    triangles.iter().enumerate().map(probe_of).collect()
}

fn probe([a, b, c]: [DVec3; 3]) -> (Ray, bool) {
    // Weights of the incentre: the lengths of the opposite edges.
    let [to_a, to_b, to_c] = [(c - b).length(), (a - c).length(), (b - a).length()];
    let around = to_a + to_b + to_c;
    let normal = (b - a).cross(c - a);
    let area_twice = normal.length();
    let radius = if around > 0.0 { area_twice / around } else { 0.0 };
    let farthest = [a, b, c].into_iter().map(|corner| corner.abs().max_element()).fold(0.0, f64::max);
    let fat = radius > MIN_INRADIUS * farthest;
    let (centre, normal) =
        if fat { ((a * to_a + b * to_b + c * to_c) / around, normal / area_twice) } else { (a, DVec3::Z) };
    let reach = radius * REACH;
    let ray = Ray {
        origin: (centre + normal * reach).as_vec3().into(),
        t_min: 0.0,
        direction: (-normal).as_vec3().into(),
        t_max: (2.0 * reach) as f32,
    };
    (ray, fat)
}
