//! Single hits against triangles in f64.

use super::*;
use tracebench_api::Status;

pub(super) fn corners(triangle: &[[f32; 3]; 3]) -> [DVec3; 3] {
    triangle.map(|corner| Vec3::from(corner).as_dvec3())
}

/// The least parameter at which a ray goes through a triangle (Möller, Trumbore 1997), in f64.
pub(super) fn true_hit(triangles: &[[[f32; 3]; 3]], ray: &Ray) -> Option<f64> {
    let (origin, direction) = (Vec3::from(ray.origin).as_dvec3(), Vec3::from(ray.direction).as_dvec3());
    let through = |triangle: &[[f32; 3]; 3]| {
        let [a, b, c] = corners(triangle);
        let (first, second) = (b - a, c - a);
        let across = direction.cross(second);
        let whole = first.dot(across);
        let (from, other) = (origin - a, (origin - a).cross(first));
        let (u, v, t) = (from.dot(across) / whole, direction.dot(other) / whole, second.dot(other) / whole);
        let inside = u >= 0.0 && v >= 0.0 && u + v <= 1.0;
        (inside && t >= f64::from(ray.t_min) && t <= f64::from(ray.t_max)).then_some(t)
    };
    triangles.iter().filter_map(through).min_by(f64::total_cmp)
}

/// How far a point is from a triangle (Ericson, "Real-Time Collision Detection", 2005, section 5.1.5, by its edges and its plane).
pub(super) fn distance_to(triangle: &[[f32; 3]; 3], point: DVec3) -> f64 {
    let [a, b, c] = corners(triangle);
    let to_edge = |(from, to): (DVec3, DVec3)| {
        let along = to - from;
        let share = ((point - from).dot(along) / along.length_squared().max(1e-300)).clamp(0.0, 1.0);
        (from + along * share - point).length()
    };
    let rims = [(a, b), (b, c), (c, a)].map(to_edge).into_iter().fold(f64::INFINITY, f64::min);
    let normal = (b - a).cross(c - a).normalize_or_zero();
    let above = [(a, b), (b, c), (c, a)].map(|(from, to)| (to - from).cross(point - from).dot(normal) >= 0.0);
    if normal != DVec3::ZERO && above == [true; 3] { rims.min((point - a).dot(normal).abs()) } else { rims }
}

/// What is wrong with a hit: the ray passed a triangle, or it ends `near` or further from all of them.
pub(super) fn fault(
    triangles: &[[[f32; 3]; 3]],
    ray: &Ray,
    hit: &Hit,
    truth: Option<f64>,
    near: f64,
) -> Option<String> {
    let (origin, direction) = (Vec3::from(ray.origin).as_dvec3(), Vec3::from(ray.direction).as_dvec3());
    // A ray along a plane is met where rounding has it.
    let passed = |t: f64| !(hit.is_hit() && (f64::from(hit.t) - t) * direction.length() < near);
    if truth.is_some_and(passed) {
        return Some(format!("goes through {truth:?}"));
    }
    let point = origin + direction * f64::from(hit.t);
    let nearest = triangles.iter().map(|triangle| distance_to(triangle, point)).fold(f64::INFINITY, f64::min);
    let close = nearest < near;
    (hit.is_hit() && !close).then(|| format!("ends {} of what it may off", nearest / near))
}

/// Negative control of what holds hits: one at the truth passes, with what f32 takes from it; a miss, one behind the truth, one before it
/// in empty space and one where nothing is are noticed.
#[test]
fn wrong_hits_are_noticed() {
    let triangles = [
        [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 1.0, 0.0]],
        [[-1.0, -1.0, 1.0], [1.0, -1.0, 1.0], [0.0, 1.0, 1.0]],
    ];
    let (through, past) = (ray(DVec3::new(0.1, 0.0, -2.0), DVec3::Z), ray(DVec3::new(9.0, 0.0, -2.0), DVec3::Z));
    let miss = Hit::miss(Status::Miss);
    let at = |t: f32| Hit { t, status: Status::Hit as u32, ..miss };
    let noticed = |ray: &Ray, hit: Hit| fault(&triangles, ray, &hit, true_hit(&triangles, ray), 0.01).is_some();
    assert_eq!([&through, &past].map(|ray| true_hit(&triangles, ray)), [Some(2.0), None]);
    assert!(!noticed(&through, at(2.0)) && !noticed(&through, at(2.000_001)) && !noticed(&past, miss));
    assert!(noticed(&through, miss) && noticed(&through, at(3.0)) && noticed(&through, at(1.9)));
    assert!(noticed(&through, at(f32::NAN)) && noticed(&past, at(2.0)));
}
