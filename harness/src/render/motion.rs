//! Where surface points of a frame are in the next one, and how much an image's error changes there.

use glam::DVec3;
use rayon::prelude::*;
use tracebench_api::Viewpoint;

use crate::rays::{image_view, primary_rays};
use crate::truth::{Ray64, Truth, tight_tolerance};

/// Of every pixel the pixel of the next frame that shows the same point of the same triangle, or of the sky; `None` where it is hidden
/// or outside of the image there. Exact: truth tells. Both truths hold the same triangles, with their vertices moved.
pub fn motion(now: (&Truth, &Viewpoint), next: (&Truth, &Viewpoint), size: [u32; 2]) -> Vec<Option<u32>> {
    let view = image_view(next.1, size);
    let moved = |ray: Ray64| {
        let hit = now.0.closest(&ray);
        let point = match hit {
            Some(hit) => moved_point(now.0, next.0, hit.primitive, ray.at(hit.t)),
            // The sky is the same wherever one stands.
            None => view.eye + ray.direction,
        };
        let at = view.project(point)?;
        let inside = (0.0..f64::from(size[0])).contains(&at.x) && (0.0..f64::from(size[1])).contains(&at.y);
        let way = point - view.eye;
        let distance = way.length();
        let back = Ray64 { origin: view.eye, direction: way / distance, ..ray };
        let seen = || match (hit, next.0.closest(&back)) {
            (None, seen) => seen.is_none(),
            (Some(_), None) => false,
            (Some(hit), Some(seen)) => {
                seen.primitive == hit.primitive
                    || (seen.t - distance).abs() <= tight_tolerance(distance, next.0.diagonal())
            }
        };
        (inside && seen()).then(|| at.x as u32 + at.y as u32 * size[0])
    };
    primary_rays(now.1, size).par_iter().map(|ray| moved(Ray64::from(ray))).collect()
}

/// A point of a triangle after the triangle has moved.
fn moved_point(now: &Truth, next: &Truth, triangle: u32, point: DVec3) -> DVec3 {
    let corners = |truth: &Truth| truth.geometry().corners(triangle).map(|corner| corner.as_dvec3());
    let ([a, b, c], [to_a, to_b, to_c]) = (corners(now), corners(next));
    let (first, second, way) = (b - a, c - a, point - a);
    let normal = first.cross(second);
    let area2 = normal.length_squared();
    let (u, v) = (way.cross(second).dot(normal) / area2, first.cross(way).dot(normal) / area2);
    to_a + (to_b - to_a) * u + (to_c - to_a) * v
}

/// How much an image's error flickers: the mean change of the error from a frame to the next at points that both show, by pixel and
/// channel, in units of the errors. `None` where no point is in both.
pub fn image_flicker(now: &[[f32; 3]], next: &[[f32; 3]], motion: &[Option<u32>]) -> Option<f64> {
    let pairs = now.iter().zip(motion).filter_map(|(now, to)| Some((now, next.get((*to)? as usize)?)));
    let change = |(now, next): (&[f32; 3], &[f32; 3])| -> f64 {
        now.iter().zip(next).map(|(now, next)| f64::from((next - now).abs())).sum::<f64>() / 3.0
    };
    let (count, sum) = pairs.fold((0_u64, 0.0), |(count, sum), pair| (count + 1, sum + change(pair)));
    (count > 0).then(|| sum / count as f64)
}
