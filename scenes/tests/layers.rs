//! What counts the depth layers of scenes.
#![allow(missing_docs)]

use crate::support::layers::{LayerCount, Layers, View, count_layers, rasterize, to_f64};
use glam::DVec3;
use tracebench_scenes::{Camera, Material, Mesh, Scene, procedural};

fn scene(triangles: &[[[f32; 3]; 3]]) -> Scene {
    let count = triangles.len() as u32;
    let mesh = Mesh {
        positions: triangles.iter().flatten().copied().collect(),
        triangles: (0..count).map(|at| [3 * at, 3 * at + 1, 3 * at + 2]).collect(),
        triangle_materials: vec![0; triangles.len()],
        materials: vec![Material { base_color: [0.5; 3], metallic: 0.0, roughness: 1.0, refractive_index: None }],
        triangle_objects: vec![0; triangles.len()],
        objects: vec!["scene".to_owned()],
    };
    let bound = |of: fn(f32, f32) -> f32, from: f32| {
        [0, 1, 2].map(|axis| mesh.positions.iter().fold(from, |bound, position| of(bound, position[axis])))
    };
    let (bounds_min, bounds_max) = (bound(f32::min, f32::INFINITY), bound(f32::max, f32::NEG_INFINITY));
    Scene { mesh, bounds_min, bounds_max, ..procedural("room", 0.001).unwrap() }
}

fn camera(eye: [f32; 3], target: [f32; 3]) -> Camera {
    let vertical_fov_radians = std::f32::consts::FRAC_PI_3;
    Camera { name: "test".to_owned(), eye, target, up: [0.0, 1.0, 0.0], vertical_fov_radians }
}

/// Where a ray meets a triangle's plane, if inside of it (Möller and Trumbore 1997), in multiples of `direction`.
fn meets(triangle: &[[f32; 3]; 3], origin: DVec3, direction: DVec3) -> Option<f64> {
    let [a, b, c] = triangle.map(to_f64);
    let (e, f, s) = (b - a, c - a, origin - a);
    let (p, q) = (direction.cross(f), s.cross(e));
    let scale = e.dot(p);
    let (u, v) = (s.dot(p) / scale, direction.dot(q) / scale);
    (u >= 0.0 && v >= 0.0 && u + v <= 1.0).then(|| f.dot(q) / scale)
}

/// Counts by a ray through each pixel's centre, built from angles rather than from the view's projection.
fn by_rays(triangles: &[[[f32; 3]; 3]], camera: &Camera, [width, height]: [u32; 2], near: f64) -> Vec<u32> {
    let (eye, target) = (to_f64(camera.eye), to_f64(camera.target));
    let forward = (target - eye).normalize();
    let right = forward.cross(DVec3::Y).normalize();
    let up = right.cross(forward);
    let tan = (f64::from(camera.vertical_fov_radians) * 0.5).tan();
    let mut counts = Vec::new();
    for y in 0..height {
        for x in 0..width {
            let to_right = (f64::from(x) + 0.5 - f64::from(width) / 2.0) * 2.0 / f64::from(height) * tan;
            let to_top = (f64::from(height) / 2.0 - f64::from(y) - 0.5) * 2.0 / f64::from(height) * tan;
            let direction = forward + right * to_right + up * to_top;
            let seen = |triangle: &&_| meets(triangle, eye, direction).is_some_and(|depth| depth >= near);
            counts.push(triangles.iter().filter(seen).count() as u32);
        }
    }
    counts
}

fn random_triangles(count: usize) -> Vec<[[f32; 3]; 3]> {
    let mut state = 7_u64;
    // SplitMix64.
    let mut between = |from: f64, to: f64| {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut bits = (state ^ (state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        from + (to - from) * ((bits ^ (bits >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    };
    (0..count)
        .map(|_| {
            let middle = [0; 3].map(|_| between(-2.0, 2.0));
            [0; 3].map(|_| middle.map(|at| (at + between(-1.5, 1.5)) as f32))
        })
        .collect()
}

/// Proves that each pixel of the camera's view, from amid triangles that also lie behind the eye and cross the near
/// plane, counts as many fragments as rays in f64 find. Without nine triangles counts differ.
#[test]
fn pixels_count_what_rays_find() {
    let triangles = random_triangles(300);
    let scene = scene(&triangles);
    let camera = camera([0.2, 0.1, 0.3], [-0.5, 0.4, 1.0]);
    let size = [96, 64];
    for near in [1e-3 * scene.diagonal(), 0.4] {
        let counts = rasterize(&scene, &View::of(&camera, size), near);
        let expected = by_rays(&triangles, &camera, size, near);
        assert!(expected.iter().max() > Some(&8), "{:?}", expected.iter().max());
        let differing = |other: &[u32]| counts.iter().zip(other).filter(|(count, other)| count != other).count();
        assert_eq!(differing(&expected), 0);
        assert_ne!(differing(&by_rays(&triangles[9..], &camera, size, near)), 0);
    }
    let layers = count_layers(&scene, &camera, size, None);
    let expected = LayerCount::of(&by_rays(&triangles, &camera, size, 1e-3 * scene.diagonal()));
    assert_eq!(layers.total(), expected);
}

/// Proves that the six faces see every direction once: fragments on faces of a fine cube, weighted by solid angle,
/// agree with rays in directions spread evenly over the sphere; a face that stands for another does not.
#[test]
fn faces_see_all_directions() {
    let triangles = random_triangles(40);
    let scene = scene(&triangles);
    let camera = camera([0.1, 0.2, -0.1], [0.3, 0.4, 1.0]);
    let side = 128;
    let near = 1e-3 * scene.diagonal();
    let weighted = |counts: &[u32]| -> f64 {
        let weight = |at: usize| {
            let [x, y] = [at as u32 % side, at as u32 / side].map(|at| (f64::from(at) + 0.5) / 64.0 - 1.0);
            (1.0 + x * x + y * y).powf(-1.5) / (64.0 * 64.0)
        };
        counts.iter().enumerate().map(|(at, &count)| f64::from(count) * weight(at)).sum()
    };
    let views = View::cube(&camera, side);
    let faces: Vec<f64> = views.iter().map(|view| weighted(&rasterize(&scene, view, near))).collect();
    let eye = to_f64(camera.eye);
    let mut expected = [0.0; 6];
    for at in 0..40_000 {
        let y = (f64::from(at) + 0.5) / 20_000.0 - 1.0;
        let (sin, cos) = (f64::from(at) * 2.399_963_229_728_653).sin_cos();
        let direction = DVec3::new((1.0 - y * y).sqrt() * cos, y, (1.0 - y * y).sqrt() * sin);
        let axis = if direction.x.abs() >= direction.y.abs().max(direction.z.abs()) {
            0
        } else {
            1 + usize::from(direction.z.abs() > direction.y.abs())
        };
        let face = 2 * axis + usize::from(direction[axis] < 0.0);
        let along = direction / direction[axis].abs();
        let seen = |triangle: &&_| meets(triangle, eye, along).is_some_and(|depth| depth >= near);
        expected[face] += triangles.iter().filter(seen).count() as f64 * std::f64::consts::PI * 4.0 / 40_000.0;
    }
    for face in 0..6 {
        assert!((faces[face] / expected[face] - 1.0).abs() < 0.02, "face {face}: {faces:?} {expected:?}");
        assert!((faces[face] / expected[face ^ 1] - 1.0).abs() > 0.02, "face {face}: {faces:?} {expected:?}");
    }
    let total = count_layers(&scene, &camera, [8, 8], Some(side)).total();
    assert_eq!(total.pixels, 64 + 6 * u64::from(side * side));
}

/// Proves that centres on an edge belong to one of the triangles that share it: squares whose edges and diagonals
/// run through pixel centres cover each pixel once, and as many a row as columns. A second square over it shows
/// that more would be counted.
#[test]
fn shared_edges_count_once() {
    let view = View { eye: DVec3::ZERO, axes: [DVec3::X, DVec3::Y, DVec3::Z], half: [1.0, 1.0], size: [16, 16] };
    // Pixel centres lie at odd sixteenths.
    let grid = |at: i32| (2 * at - 7) as f32 / 16.0;
    let mut triangles = Vec::new();
    for y in 0..7 {
        for x in 0..7 {
            let corner = |right: i32, up: i32| [grid(x + right), grid(y + up), 1.0];
            triangles.push([corner(0, 0), corner(1, 0), corner(1, 1)]);
            triangles.push([corner(0, 0), corner(1, 1), corner(0, 1)]);
        }
    }
    let counted = |triangles: &[_]| LayerCount::of(&rasterize(&scene(triangles), &view, 0.1));
    let once = counted(&triangles);
    assert_eq!((once.fragments, once.covered, once.max), (49, 49, 1));
    triangles.push([[-0.5, -0.5, 1.5], [0.5, -0.5, 1.5], [0.5, 0.5, 1.5]]);
    assert_eq!(counted(&triangles).max, 2);
}

/// Proves what averages and totals are; a pixel that is not covered counts in one average only.
#[test]
fn averages_are_of_covered_or_of_all() {
    let count = LayerCount::of(&[0, 4, 0, 2]);
    assert_eq!(count, LayerCount { pixels: 4, covered: 2, fragments: 6, max: 4 });
    assert_eq!((count.average_of_covered(), count.average_of_all()), (3.0, 1.5));
    let layers = Layers { view: count, faces: vec![LayerCount::of(&[1, 0])] };
    assert_eq!(layers.total(), LayerCount { pixels: 6, covered: 3, fragments: 7, max: 4 });
    assert_eq!((LayerCount::default().average_of_covered(), LayerCount::default().average_of_all()), (0.0, 0.0));
}
