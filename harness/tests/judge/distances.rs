//! Distances of told hits from the piece of mesh that is truly hit, against a search over every triangle.

use super::*;
use tracebench_harness::judge::{COMMON_TEXELS, MAX_PIECES};
use tracebench_harness::results::SurfaceDistance;

fn distance(case: &Case, hits: &[Hit]) -> SurfaceDistance {
    case.closest(hits).surface_distance.unwrap()
}

/// How far a point is from a triangle: the distance is convex in both weights, so thirds are cut off from either side.
fn by_thirds(point: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
    let least = |f: &dyn Fn(f64) -> f64| {
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..90 {
            let (one, other) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
            if f(one) < f(other) { high = other } else { low = one }
        }
        f((low + high) / 2.0)
    };
    least(&|v| {
        let from = a + (b - a) * v;
        let to = c + (b - c) * v;
        least(&|w| point.distance(from.lerp(to, w)))
    })
}

/// Two plates, the upper one over a part of the lower, and a third that hangs on to the lower by an edge.
fn plates() -> Vec<[[f32; 3]; 3]> {
    let mut triangles = plate();
    triangles.extend(rectangle([-0.5, -0.5, 0.4], [0.7, 0.0, 0.0], [0.0, 0.7, 0.1]));
    triangles.extend(rectangle([1.0, -1.0, 0.0], [0.5, 0.0, 0.5], [0.0, 2.0, 0.0]));
    triangles
}

/// Proves the percentiles and shares against a search over all triangles of the piece, whose triangles are told by hand; and that a
/// miss is not within a texel, while it is a ray.
#[test]
fn distances_are_those_of_all_triangles_of_the_piece() {
    let rays: Vec<Ray> = (0..24)
        .map(|index| {
            let along = index as f32 / 24.0;
            let direction = Vec3::new(0.3 - along * 0.5, 0.2, -1.0).normalize();
            ray([1.3 * along - 0.6, along * 0.9 - 0.55, 1.5], direction.into())
        })
        .collect();
    let case = Case::new(framed(plates()), rays, Query::Closest);
    let mut hits = case.right();
    for (index, hit) in hits.iter_mut().enumerate().filter(|(_, hit)| hit.is_hit()) {
        hit.t += [0.0, 0.002, -0.004, 0.3, -0.7, 2.0][index % 6];
    }
    let lost = hits.iter().position(|hit| hit.is_hit()).unwrap();
    hits[lost] = miss();
    let mut expected = Vec::new();
    let mut upper = 0;
    for ((ray, hit), answer) in case.rays.iter().zip(&hits).zip(&case.answers) {
        let Some(truth) = answer.hit.filter(|_| !answer.is_ambiguous()) else { continue };
        upper += u64::from(matches!(truth.primitive, 2 | 3));
        let piece: &[u32] = if matches!(truth.primitive, 2 | 3) { &[2, 3] } else { &[0, 1, 4, 5] };
        let told = Vec3::from(ray.origin).as_dvec3() + Vec3::from(ray.direction).as_dvec3() * f64::from(hit.t);
        let corners = |triangle: &u32| case.truth.geometry().corners(*triangle).map(|corner| corner.as_dvec3());
        let nearest = piece.iter().map(|triangle| by_thirds(told, corners(triangle))).fold(f64::INFINITY, f64::min);
        expected.push(hit.is_hit().then_some(nearest));
    }
    let found = distance(&case, &hits);
    assert!(expected.len() > 15 && upper > 3 && upper < expected.len() as u64 - 3, "{expected:?}");
    assert_eq!(found.rays, expected.len() as u64);
    let mut told: Vec<f64> = expected.iter().flatten().copied().collect();
    told.sort_by(f64::total_cmp);
    assert_eq!(told.len() + 1, expected.len());
    let rank = |share: f64| told[(share * told.len() as f64).ceil() as usize - 1];
    for (found, expected) in
        [(found.distance.p50, rank(0.5)), (found.distance.p95, rank(0.95)), (found.distance.p99, rank(0.99))]
    {
        assert!((found.unwrap() - expected).abs() < 1e-7, "{found:?} {expected}");
    }
    // The bounds' longest edge is 8.
    assert_eq!(found.common_texel, 8.0 / COMMON_TEXELS);
    let within = told.iter().filter(|distance| **distance <= found.common_texel).count();
    assert!(within > 3 && within < told.len() - 3);
    assert_eq!(found.within_common_texel, Some(within as f64 / expected.len() as f64));
    assert_eq!((found.own_texel, found.within_own_texel), (None, None));
    let by_piece: Vec<_> =
        found.pieces.iter().map(|piece| (piece.first_triangle, piece.triangles, piece.rays)).collect();
    let mut pieces = vec![(0, 4, found.rays - upper), (2, 2, upper)];
    pieces.sort_by_key(|(_, _, rays)| std::cmp::Reverse(*rays));
    assert_eq!(by_piece, pieces);
    assert_eq!(found.pieces.iter().map(|piece| piece.within_common_texel_rays).sum::<u64>(), within as u64);
    assert!(found.pieces.iter().all(|piece| piece.open && piece.mean_thickness.is_none()));
}

/// Proves that another piece's nearness does not count: a hit told on the plate above is as far as the plate below is; and that grazing
/// rays, whose t is far off, are near. As a negative control, told right both are at no distance.
#[test]
fn other_pieces_do_not_count() {
    let case = Case::new(framed(plates()), vec![down(0.8, 0.8, 2.0), towards_plate()], Query::Closest);
    let right = distance(&case, &case.right());
    assert!(right.distance.p99.unwrap() < 1e-7 && right.within_common_texel == Some(1.0));
    let mut hits = case.right();
    // The upper plate ends at 0.2: this point is 0.4 over the lower one.
    hits[0].t = 1.6;
    let found = distance(&case, &hits);
    assert!((found.distance.p99.unwrap() - 0.4).abs() < 1e-6);
    assert_eq!(found.within_common_texel, Some(0.5));
    let mut hits = case.right();
    hits[1].t -= 0.3;
    let found = distance(&case, &hits);
    assert!(found.distance.p99.unwrap() < 0.004, "{found:?}");
    assert_eq!(found.within_common_texel, Some(1.0));
}

/// Falls by 1 on a way of 100.
fn towards_plate() -> Ray {
    ray([-0.9, 0.9, 0.01], Vec3::new(1.0, 0.0, -0.01).normalize().into())
}

/// Proves that a tracer's own texel is the greatest edge of its images along axes, that rays within it are counted by it, and that no more
/// pieces are distinguished than said, those with the most rays.
#[test]
fn own_texels_and_most_pieces() {
    use glam::DVec2;
    use tracebench_api::Orthographic;
    let image = |texel: DVec2| Orthographic {
        origin: DVec3::ZERO,
        right: DVec3::X,
        up: DVec3::Y,
        axis: DVec3::NEG_Z,
        texel,
        far: 4.0,
        size: [64, 64],
    };
    let count = MAX_PIECES + 4;
    let columns = || (0..count).map(|column| column as f32 / count as f32 * 4.0 - 2.0);
    let triangles: Vec<_> =
        columns().flat_map(|x| rectangle([x, -1.0, 0.0], [0.15, 0.0, 0.0], [0.0, 2.0, 0.0])).collect();
    // One ray onto each piece, and a second onto the last.
    let mut rays: Vec<Ray> = columns().map(|x| down(x + 0.06, 0.3, 1.0)).collect();
    rays.push(Ray { origin: [rays[count - 1].origin[0], 0.1, 1.0], ..rays[count - 1] });
    let mut case = Case::new(framed(triangles), rays, Query::Closest);
    let sampling = |texel| SampledImage::new(Projection::Orthographic(image(texel)), Layers::All);
    case.samplings = vec![sampling(DVec2::new(0.1, 0.2)), sampling(DVec2::new(0.25, 0.1))];
    let mut hits = case.right();
    hits[0].t = 0.76;
    hits[1].t = 0.74;
    let found = distance(&case, &hits);
    assert_eq!(found.own_texel, Some(0.25));
    assert_eq!(found.within_own_texel, Some((count as f64) / (count + 1) as f64));
    assert_eq!(found.within_common_texel, Some((count - 1) as f64 / (count + 1) as f64));
    assert_eq!(found.pieces.len(), MAX_PIECES);
    assert_eq!((found.pieces[0].rays, found.pieces[0].piece), (2, count as u32 - 1));
    assert_eq!(found.pieces[1].within_own_texel_rays, Some(1));
    assert_eq!(found.pieces[2].within_own_texel_rays, Some(0));
}
