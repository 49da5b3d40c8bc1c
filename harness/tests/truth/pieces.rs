//! Pieces of mesh, crossings along lines, nearest points and areas in boxes.

use glam::DVec3;
use tracebench_harness::truth::{Piece, Ray64, Truth, area_in_box, nearest_point};
use tracebench_tests::{Numbers, soup};

fn block(low: [f32; 3], high: [f32; 3]) -> Vec<[[f32; 3]; 3]> {
    let corners: [[f32; 3]; 8] = std::array::from_fn(|index| {
        std::array::from_fn(|axis| if index >> axis & 1 == 0 { low[axis] } else { high[axis] })
    });
    let sides = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let halves = sides.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]);
    halves.map(|half| half.map(|corner: usize| corners[corner])).collect()
}

fn pieces(triangles: &[[[f32; 3]; 3]]) -> Vec<Piece> {
    Truth::new(&soup(triangles, None), "pieces").pieces().all().to_vec()
}

/// Proves that triangles hang together by places, not by indices, that a piece is closed if every edge has two triangles, and what its
/// area, volume and thickness are; a triangle that is there twice opens nothing. As a negative control, one triangle less does.
#[test]
fn pieces_hang_together_by_places() {
    let mut triangles = block([-1.0, -1.0, 0.0], [1.0, 1.0, 0.5]);
    triangles.extend(block([2.0, -1.0, 0.0], [2.01, 1.0, 2.0]));
    triangles.push(triangles[5]);
    let found = pieces(&triangles);
    assert_eq!(
        found.iter().map(|piece| (piece.first_triangle, piece.triangles, piece.open)).collect::<Vec<_>>(),
        [(0, 13, false), (12, 12, false)]
    );
    let wall = &found[1];
    assert!((wall.volume - 0.04).abs() < 1e-6 && (wall.area - 8.08).abs() < 1e-5, "{wall:?}");
    assert!((wall.mean_thickness().unwrap() - 0.01).abs() < 2e-4);
    triangles.remove(15);
    let found = pieces(&triangles);
    assert_eq!(found.iter().map(|piece| piece.open).collect::<Vec<_>>(), [false, true]);
    assert_eq!(found[1].mean_thickness(), None);
}

/// Proves that an edge that two triangles share is crossed once, that both facings are told and counted, and that a surface that is
/// there twice is crossed once where it faces the same way, and twice where it does not.
#[test]
fn crossings_are_of_surfaces() {
    let block = block([-1.0, -1.0, 0.0], [1.0, 1.0, 0.5]);
    let crossings = |triangles: &[[[f32; 3]; 3]], x: f64, y: f64| {
        let line = Ray64 { origin: DVec3::new(x, y, -3.0), direction: DVec3::Z, t_min: 0.0, t_max: f64::INFINITY };
        let found = Truth::new(&soup(triangles, None), "crossings").crossings(&line);
        // To far less than what rounding leaves.
        found.into_iter().map(|each| ((each.t * 1e9).round() / 1e9, each.leaves)).collect::<Vec<_>>()
    };
    let through = [(3.0, false), (3.5, true)];
    // Through the diagonals of both sides, and aside of them.
    for (x, y) in [(0.25, 0.25), (0.25, 0.1), (0.0, 0.0)] {
        assert_eq!(crossings(&block, x, y), through, "{x} {y}");
    }
    assert_eq!(crossings(&block, 1.5, 0.25), []);
    let twice = [block.clone(), block.clone()].concat();
    assert_eq!(crossings(&twice, 0.3, 0.2), through);
    let turned: Vec<_> = block.iter().map(|[a, b, c]| [*a, *c, *b]).collect();
    assert_eq!(crossings(&[block, turned].concat(), 0.3, 0.2).len(), 4);
}

/// Proves over random triangles, thin ones and such without area among them, that the nearest point lies in the triangle, and that no point
/// of a fine raster over it is nearer.
#[test]
fn nearest_points_are_nearest() {
    let mut numbers = Numbers::new(5);
    for index in 0..300 {
        let [a, mut b, mut c] = [numbers.point(), numbers.point(), numbers.point()];
        match index % 4 {
            1 => c = a + (b - a) * 0.4 + numbers.point() * 1e-9,
            2 => c = a.lerp(b, 1.5),
            3 if index % 8 == 3 => (b, c) = (a, a),
            _ => {}
        }
        let point = numbers.point() * 1.5;
        let found = point.distance(nearest_point(point, [a, b, c]));
        let steps = 40;
        let mut least = f64::INFINITY;
        for v in 0..=steps {
            for w in 0..=steps - v {
                let (v, w) = (f64::from(v) / f64::from(steps), f64::from(w) / f64::from(steps));
                least = least.min(point.distance(a + (b - a) * v + (c - a) * w));
            }
        }
        let spacing = (b - a).length().max((c - a).length()).max((c - b).length()) / f64::from(steps);
        assert!(found <= least + 1e-9 && found >= least - spacing, "{index}: {found} {least}");
    }
}

/// Proves that the areas of triangles in the boxes of a grid add up to their own, and that what lies beside a box has none in it.
#[test]
fn areas_in_boxes_add_up() {
    let mut numbers = Numbers::new(9);
    for _ in 0..40 {
        let corners = [numbers.point(), numbers.point(), numbers.point()];
        let whole = (corners[1] - corners[0]).cross(corners[2] - corners[0]).length() / 2.0;
        let mut sum = 0.0;
        let cell = DVec3::new(0.7, 0.55, 0.9);
        for index in 0..6 * 6 * 6 {
            let place = DVec3::new(f64::from(index % 6), f64::from(index / 6 % 6), f64::from(index / 36)) - 3.0;
            sum += area_in_box(corners, place * cell, (place + 1.0) * cell);
        }
        assert!((sum - whole).abs() < 1e-9, "{sum} {whole}");
        let high = corners[0].max(corners[1]).max(corners[2]);
        assert_eq!(area_in_box(corners, high + 1e-6, high + 1.0), 0.0);
    }
}

/// Proves that the hierarchy's nearest triangle is that of a search over all, of the scene and of one piece, and that nothing is found
/// within less than its distance.
#[test]
fn nearest_triangles_are_those_of_a_search_over_all() {
    let mut numbers = Numbers::new(3);
    let mut triangles: Vec<[[f32; 3]; 3]> = Vec::new();
    for _ in 0..60 {
        let at = numbers.point() * 2.0;
        triangles.push([0, 1, 2].map(|_| (at + numbers.point() * 0.2).as_vec3().into()));
    }
    triangles.extend(block([-0.5, -0.5, -0.5], [0.5, 0.25, 0.5]));
    let geometry = soup(&triangles, None);
    let truth = Truth::new(&geometry, "nearest");
    let last = truth.pieces().all().len() as u32 - 1;
    assert_eq!(last, 60);
    for _ in 0..100 {
        let point = numbers.point() * 2.5;
        let to = |triangle: u32| {
            let corners = geometry.corners(triangle).map(|corner| corner.as_dvec3());
            point.distance(nearest_point(point, corners))
        };
        let all = (0..72).map(to).fold(f64::INFINITY, f64::min);
        let found = truth.nearest(point, f64::INFINITY).unwrap();
        assert!((found.distance - all).abs() < 1e-12 && (to(found.primitive) - all).abs() < 1e-12);
        assert_eq!(truth.nearest(point, all * 0.999), None);
        let of_block = (60..72).map(to).fold(f64::INFINITY, f64::min);
        let found = truth.nearest_of_piece(point, f64::INFINITY, last).unwrap();
        assert!((found.distance - of_block).abs() < 1e-12 && found.primitive >= 60);
    }
}
