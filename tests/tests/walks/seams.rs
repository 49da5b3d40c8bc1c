//! Views beside one another: a ray along their seams is lost by none of them.

use tracebench_api::glam::{DVec3, Vec3};
use tracebench_api::{Ray, Viewpoint};
use tracebench_kit::{ViewUniform, view_uniform};
use tracebench_tests::Numbers;

use super::tasks::{Task, enter};

const NEAR: f64 = 0.125;
const FAR: f64 = 64.0;

/// The six faces round a place, in the order of their axes.
fn faces(pulled_back: f64) -> [ViewUniform; 6] {
    let viewpoint = Viewpoint {
        eye: Vec3::ZERO,
        forward: Vec3::NEG_Z,
        up: Vec3::Y,
        vertical_fov: 1.0,
        near: NEAR as f32,
        far: FAR as f32,
        frame: [16, 16],
        face: 16,
    };
    viewpoint.face_views(pulled_back).map(|view| view_uniform(&view))
}

/// Rays in the planes between faces, along their lines, through their corners, across them at every angle; with an end beyond far.
fn rays() -> Vec<Ray> {
    let mut numbers = Numbers::new(62);
    let mut rays = Vec::new();
    for index in 0..1200 {
        let mut plane = |length: f64| {
            let (one, other) = (numbers.signed() * length, if numbers.unit() < 0.5 { 1.0 } else { -1.0 });
            let mut point = DVec3::new(one, one * other, numbers.signed() * length);
            point.as_mut().rotate_left(index % 3);
            match index % 4 {
                // Anywhere, in one of the planes, on one of the lines through the corners.
                0 => numbers.point() * length,
                1 => DVec3::splat(one) * DVec3::new(1.0, other, -other),
                _ => point,
            }
        };
        let (from, to) = (plane(2.0), plane(8.0));
        let direction = (to - from).as_vec3();
        if direction.length() > 0.1 {
            rays.push(Ray { origin: from.as_vec3().into(), t_min: 0.0, direction: direction.into(), t_max: 1e6 });
        }
    }
    rays
}

/// Rays that no face has somewhere between near and far.
fn lost(rays: &[Ray], faces: &[ViewUniform; 6], slack: f32) -> usize {
    let task = |ray: &Ray, view: &ViewUniform| Task { view: *view, ray: *ray, slack, levels: 1, seed: 1, pixels: 0.0 };
    let tasks: Vec<Task> = rays.iter().flat_map(|ray| faces.iter().map(|view| task(ray, view))).collect();
    let found = enter(&tasks);
    let is_lost = |(ray, spans): &(&Ray, &[[f32; 4]])| {
        let far_out = |t: f32| {
            let at = |axis: usize| f64::from(ray.origin[axis]) + f64::from(ray.direction[axis]) * f64::from(t);
            (0..3).map(|axis| at(axis).abs()).fold(0.0, f64::max)
        };
        let mut spans: Vec<_> = spans.iter().filter(|span| span[0] <= span[1]).collect();
        spans.sort_by(|a, b| a[0].total_cmp(&b[0]));
        let mut now = ray.t_min;
        for span in spans {
            // Nothing but what lies before near may be left out.
            let gap = span[0] > now && far_out(now.midpoint(span[0])) > NEAR * 1.000_01;
            if gap {
                return true;
            }
            now = now.max(span[1]);
        }
        far_out(now) < FAR * 0.999_99
    };
    rays.iter().zip(found.chunks(6)).filter(is_lost).count()
}

/// Proves that of six faces at least one has a ray, wherever between near and far: with centres in the eye and pulled back, where
/// views are widened as they are for walks. Negative control: with views that are as much too narrow rays are lost.
#[test]
fn no_ray_is_lost_on_a_seam() {
    let rays = rays();
    assert!(rays.len() > 1000);
    for pulled_back in [0.0, NEAR] {
        assert_eq!(lost(&rays, &faces(pulled_back), 1.000_002), 0);
    }
    assert!(lost(&rays, &faces(0.0), 0.999_998) > 100);
}
