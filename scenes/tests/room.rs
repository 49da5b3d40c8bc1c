//! The procedural scene `room` and the catalogue.
#![allow(missing_docs)]

use crate::support;

use std::collections::{BTreeMap, HashSet};

use glam::DVec3;
use support::triangles;
use tracebench_scenes::{Origin, Scene, catalogue, procedural};

fn corners(scene: &Scene) -> Vec<[DVec3; 3]> {
    triangles(scene).into_iter().map(|triangle| triangle.map(to_f64)).collect()
}

fn to_f64(point: [f32; 3]) -> DVec3 {
    DVec3::from_array(point.map(f64::from))
}

/// Proves that the scene is the same on every machine and in every version: what changes it must change this.
#[test]
fn content_is_pinned() {
    for (scale, sha256) in [
        (1.0, "dd1eee74e17d5e58eccad933aebc3664391436e4de827809c4cab9ee151a5aec"),
        (0.05, "ef04f93362cd2fb50bb9c8891ad1ddbe92a166fa0582380d7876ca3b6dfb9030"),
    ] {
        assert_eq!(procedural("room", scale).unwrap().sha256, sha256, "scale {scale}");
    }
}

/// Proves that the catalogue tells the truth about its scenes.
#[test]
fn catalogue_counts_are_exact() {
    for entry in catalogue() {
        let scene = procedural(entry.name, 1.0).unwrap();
        assert_eq!(scene.mesh.triangles.len() as u64, entry.triangles_at_scale_1, "{}", entry.name);
        assert_eq!(scene.name, entry.name);
        assert_eq!(scene.origin, Origin::Procedural { scale: 1.0 });
    }
    let room = procedural("room", 1.0).unwrap();
    assert!((154_000..=158_000).contains(&room.mesh.triangles.len()));
    assert!(room.mesh.materials[room.mesh.triangle_materials[0] as usize].base_color.iter().all(|&c| c <= 1.0));
    assert!(room.mesh.materials.iter().any(|material| material.is_mirror() && material.roughness == 0.0));
}

/// Proves that the scale multiplies the triangles, never takes any away, and is refused outside its range.
#[test]
fn scale_is_a_factor_on_triangles() {
    let count = |scale: f64| procedural("room", scale).unwrap().mesh.triangles.len() as f64;
    let one = count(1.0);
    for scale in [0.25, 0.5, 2.0, 4.0] {
        let ratio = count(scale) / one / scale;
        assert!((0.9..1.2).contains(&ratio), "scale {scale} gives {ratio} times what it should");
    }
    let mut last = 0.0;
    for scale in [0.001, 0.002, 0.01, 0.05, 0.051, 0.2, 0.9, 1.0, 1.01, 1.5] {
        let now = count(scale);
        assert!(now >= last, "scale {scale}");
        last = now;
    }
    for scale in [0.0, -1.0, 0.000_99, 64.1, f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let error = procedural("room", scale).unwrap_err();
        assert!(error.is_argument());
        assert!(error.to_string().contains("0.001 to 64"), "{error}");
    }
    let error = procedural("rooom", 1.0).unwrap_err();
    assert!(error.is_argument() && error.to_string().contains("use one of room, "), "{error}");
}

/// Proves that no triangle is degenerate, none stands twice, all vertices are used and finite.
#[test]
fn triangles_are_sound() {
    for scale in [0.001, 0.05, 1.0, 5.0] {
        let scene = procedural("room", scale).unwrap();
        let mut used = vec![false; scene.mesh.positions.len()];
        for &index in scene.mesh.triangles.iter().flatten() {
            used[index as usize] = true;
        }
        assert!(used.iter().all(|&used| used), "scale {scale}");
        assert!(scene.mesh.positions.iter().flatten().all(|value| value.is_finite()));
        let mut seen = HashSet::new();
        for triangle in triangles(&scene) {
            let [a, b, c] = triangle.map(to_f64);
            assert!((b - a).cross(c - a).length() > 1e-14, "{triangle:?} at scale {scale}");
            let mut key = triangle.map(|point| point.map(|value| (value + 0.0).to_bits()));
            key.sort_unstable();
            assert!(seen.insert(key), "{triangle:?} stands twice at scale {scale}");
        }
    }
}

/// How often the surface winds around a point: a whole number wherever all surfaces are closed.
fn winding(triangles: &[[DVec3; 3]], point: DVec3) -> f64 {
    let mut sum = 0.0;
    for triangle in triangles {
        let [a, b, c] = triangle.map(|corner| corner - point);
        let (x, y, z) = (a.length(), b.length(), c.length());
        let below = x * y * z + a.dot(b) * z + b.dot(c) * x + c.dot(a) * y;
        sum += 2.0 * a.dot(b.cross(c)).atan2(below);
    }
    sum / (4.0 * std::f64::consts::PI)
}

/// Proves that every surface is closed and that the eyes are inside the room and outside of everything in it: the
/// shell, seen from inside, counts -1, an object +1 where one is inside of it. The middle of the table's top and a
/// point beyond the wall show that other numbers can come out; without one triangle no number is whole.
#[test]
fn surfaces_are_closed_and_eyes_in_the_open() {
    for scale in [0.001, 0.05, 0.3] {
        let scene = procedural("room", scale).unwrap();
        let mut triangles = corners(&scene);
        for camera in &scene.cameras {
            let number = winding(&triangles, to_f64(camera.eye));
            assert!((number + 1.0).abs() < 1e-6, "{} at scale {scale}: {number}", camera.name);
        }
        let mut state = 1u32;
        let mut random = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(state >> 8) / f64::from(1u32 << 24)
        };
        for _ in 0..40 {
            let point = DVec3::new(random() * 6.4 - 3.2, random() * 3.2 - 0.1, random() * 5.4 - 2.7);
            let number = winding(&triangles, point);
            assert!((number - number.round()).abs() < 1e-5, "{point} at scale {scale}: {number}");
        }
        assert!(winding(&triangles, DVec3::new(-0.9, 0.733, 0.3)).abs() < 1e-6);
        assert!(winding(&triangles, DVec3::new(0.0, 1.5, 3.5)).abs() < 1e-6);
        triangles.remove(0);
        let number = winding(&triangles, to_f64(scene.cameras[0].eye));
        assert!((number - number.round()).abs() > 1e-5);
    }
}

fn hits(triangles: &[[DVec3; 3]], origin: DVec3, direction: DVec3) -> bool {
    triangles.iter().any(|[a, b, c]| {
        let (e, f) = (*b - *a, *c - *a);
        let p = direction.cross(f);
        let scale = e.dot(p);
        if scale == 0.0 {
            return false;
        }
        let s = origin - *a;
        let u = s.dot(p) / scale;
        let q = s.cross(e);
        let v = direction.dot(q) / scale;
        u >= -1e-12 && v >= -1e-12 && u + v <= 1.0 + 1e-12 && f.dot(q) / scale > 0.0
    })
}

/// Proves that the room is closed for rays: 500 directions from each eye all hit; from outside, away from it, none do.
#[test]
fn every_ray_from_inside_hits() {
    let scene = procedural("room", 0.05).unwrap();
    let triangles = corners(&scene);
    let directions: Vec<DVec3> = (0..500)
        .map(|at| {
            let y = (f64::from(at) + 0.5) / 250.0 - 1.0;
            let (sin, cos) = (f64::from(at) * 2.399_963).sin_cos();
            let flat = (1.0 - y * y).sqrt();
            DVec3::new(flat * cos, y, flat * sin)
        })
        .collect();
    for camera in &scene.cameras {
        for &direction in &directions {
            assert!(hits(&triangles, to_f64(camera.eye), direction), "{} {direction}", camera.name);
        }
    }
    assert!(directions.iter().filter(|d| d.z > 0.1).all(|&d| !hits(&triangles, DVec3::new(0.0, 1.5, 3.5), d)));
}

/// Proves that the promised viewpoints are there, the default first, and that they look inwards.
#[test]
fn viewpoints() {
    let scene = procedural("room", 0.01).unwrap();
    let names: Vec<&str> = scene.cameras.iter().map(|camera| camera.name.as_str()).collect();
    assert_eq!(names, ["entrance", "corner", "statue", "floor", "chair_legs"]);
    for camera in &scene.cameras {
        let look = to_f64(camera.target) - to_f64(camera.eye);
        assert!(look.length() > 0.5 && look.cross(to_f64(camera.up)).length() > 0.3, "{}", camera.name);
        assert!((50f32.to_radians()..70f32.to_radians()).contains(&camera.vertical_fov_radians));
    }
}

/// Whether two triangles in one plane share more than their borders: no line along an edge of either parts them.
fn overlap(first: &[[f64; 2]; 3], second: &[[f64; 2]; 3]) -> bool {
    let parted_by = |edges: &[[f64; 2]; 3]| {
        (0..3).any(|at| {
            let (a, b) = (edges[at], edges[(at + 1) % 3]);
            let range = |triangle: &[[f64; 2]; 3]| {
                let across = triangle.map(|p| (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]));
                across.into_iter().fold((f64::MAX, f64::MIN), |(low, high), x| (low.min(x), high.max(x)))
            };
            let (one, other) = (range(first), range(second));
            one.1 <= other.0 + 1e-9 || other.1 <= one.0 + 1e-9
        })
    };
    !parted_by(first) && !parted_by(second)
}

/// Proves that no two faces of boxes and walls lie in one plane over one another, where the nearer is a matter of
/// rounding. The square of two triangles over its other half shows that overlaps are seen.
#[test]
fn no_faces_coincide() {
    let half = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]];
    assert!(!overlap(&half, &[[0.0, 0.0], [1.0, 1.0], [0.0, 1.0]]));
    assert!(overlap(&half, &[[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]));
    let scene = procedural("room", 0.05).unwrap();
    let mut planes: BTreeMap<(usize, u32), Vec<[[f64; 2]; 3]>> = BTreeMap::new();
    for triangle in triangles(&scene) {
        for axis in 0..3 {
            let level = triangle[0][axis];
            if triangle.iter().all(|point| point[axis] == level) {
                let flat = triangle.map(|p| [f64::from(p[(axis + 1) % 3]), f64::from(p[(axis + 2) % 3])]);
                planes.entry((axis, (level + 0.0).to_bits())).or_default().push(flat);
            }
        }
    }
    assert!(planes.len() > 50);
    for ((axis, level), flats) in planes {
        for (at, first) in flats.iter().enumerate() {
            for second in &flats[at + 1..] {
                assert!(!overlap(first, second), "axis {axis} at {}: {first:?} {second:?}", f32::from_bits(level));
            }
        }
    }
}
