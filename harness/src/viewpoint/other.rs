//! Another viewpoint of the same scene, by a rule that knows no scene.
//!
//! 1. Of the scene's cameras the next after the own one, cyclic (from the first, where the own pose is none of them), that
//!    will do.
//! 2. Without one: an eye inside the scene's bounds moves. Of eight horizontal headings it takes the one with the longest
//!    free way, within the bounds, goes half of it, and looks at what the own viewpoint looks at.
//! 3. An eye outside of the bounds is turned with its target by 90° (180°, 270°) about the vertical through the bounds' centre.
//!
//! A viewpoint will do if its eye is at least a hundredth of the diagonal from the own one, if a tenth of the rays through a
//! square field of view hit something, and if it lies inside the bounds where the own one does.

use glam::{DMat3, DVec3, Vec3};
use tracebench_scenes::Camera;

use super::{Pose, look};
use crate::truth::Truth;

/// The least distance from the own eye, in scene diagonals.
const APART_DIAGONALS: f64 = 0.01;
/// Rays along each edge of the square field of view.
const SIGHT_RAYS: u32 = 16;
/// Share of these that must hit something.
const SIGHT_SHARE: f64 = 0.1;
/// Headings into which an eye inside may move.
const UPDATE_MODES: u32 = 8;
/// Turns of an eye outside, degrees.
const TURNS: [f64; 3] = [90.0, 180.0, 270.0];

/// Another viewpoint by the rule in this module's documentation; `None` where none will do.
pub fn other(own: &Pose, cameras: &[Camera], truth: &Truth) -> Option<Pose> {
    let next = cameras.iter().position(|camera| Pose::from(camera) == *own).map_or(0, |place| place + 1);
    let listed = (0..cameras.len()).map(|step| Pose::from(&cameras[(next + step) % cameras.len()]));
    let found: Vec<Pose> = if inside(truth, own.eye) { moved(own, truth) } else { turned(own, truth) };
    listed.chain(found).find(|pose| will_do(own, pose, truth))
}

fn will_do(own: &Pose, other: &Pose, truth: &Truth) -> bool {
    let apart = f64::from(own.eye.distance(other.eye)) >= APART_DIAGONALS * truth.diagonal();
    let within = inside(truth, other.eye) || !inside(truth, own.eye);
    apart && within && sampling_model(other, truth) >= SIGHT_SHARE
}

fn inside(truth: &Truth, eye: Vec3) -> bool {
    let geometry = truth.geometry();
    eye.cmpge(geometry.bounds_min).all() && eye.cmple(geometry.bounds_max).all()
}

/// The share of a square of rays round the line of sight that hits something.
fn sampling_model(pose: &Pose, truth: &Truth) -> f64 {
    let (forward, right, up) = frame(pose);
    let reach = f64::from(pose.vertical_fov / 2.0).tan();
    let across = |step: u32| reach * (2.0 * (f64::from(step) + 0.5) / f64::from(SIGHT_RAYS) - 1.0);
    let rays = (0..SIGHT_RAYS).flat_map(|row| (0..SIGHT_RAYS).map(move |column| (row, column)));
    let direction = |(row, column)| (forward + right * across(column) + up * across(row)).normalize();
    let hits = rays.filter(|ray| look(truth, pose.eye.as_dvec3(), direction(*ray)).is_some()).count();
    hits as f64 / f64::from(SIGHT_RAYS * SIGHT_RAYS)
}

/// Forward, right and up of a pose, of unit length.
fn frame(pose: &Pose) -> (DVec3, DVec3, DVec3) {
    let forward = (pose.target - pose.eye).as_dvec3().normalize_or(DVec3::NEG_Z);
    let vertical = vertical(pose);
    // Straight up and down every heading is as good as another.
    let right = forward.cross(vertical).try_normalize().unwrap_or_else(|| forward.any_orthonormal_vector());
    (forward, right, right.cross(forward))
}

fn vertical(pose: &Pose) -> DVec3 {
    pose.up.as_dvec3().normalize_or(DVec3::Y)
}

/// Half the free way into every heading, the longest first; of equal ones the first to the right.
fn moved(own: &Pose, truth: &Truth) -> Vec<Pose> {
    let eye = own.eye.as_dvec3();
    let (forward, right, _) = frame(own);
    let seen = look(truth, eye, forward).map_or(truth.diagonal() / 2.0, |(distance, _)| distance);
    let target = eye + forward * seen;
    let heading = |way: u32| {
        DMat3::from_axis_angle(vertical(own), std::f64::consts::TAU * f64::from(way) / f64::from(UPDATE_MODES)) * right
    };
    let half = |direction: DVec3| {
        let free = look(truth, eye, direction).map_or(f64::INFINITY, |(distance, _)| distance);
        free.min(to_bounds(truth, eye, direction)) / 2.0
    };
    let mut ways: Vec<(f64, DVec3)> =
        (0..UPDATE_MODES).map(heading).map(|direction| (half(direction), direction)).collect();
    ways.sort_by(|a, b| b.0.total_cmp(&a.0));
    let pose = |(way, direction): (f64, DVec3)| Pose {
        name: "found: moved".to_owned(),
        eye: (eye + direction * way).as_vec3(),
        target: target.as_vec3(),
        ..own.clone()
    };
    ways.into_iter().map(pose).filter(|pose| pose.eye != pose.target).collect()
}

/// How far it is from a point within the bounds to their edge.
fn to_bounds(truth: &Truth, eye: DVec3, direction: DVec3) -> f64 {
    let (low, high) = (truth.geometry().bounds_min.as_dvec3(), truth.geometry().bounds_max.as_dvec3());
    let along = |axis: usize| {
        let edge = if direction[axis] > 0.0 { high[axis] } else { low[axis] };
        if direction[axis] == 0.0 { f64::INFINITY } else { (edge - eye[axis]) / direction[axis] }
    };
    (0..3).map(along).fold(f64::INFINITY, f64::min).max(0.0)
}

/// The own pose about the vertical through the bounds' centre.
fn turned(own: &Pose, truth: &Truth) -> Vec<Pose> {
    let geometry = truth.geometry();
    let centre = geometry.bounds_min.as_dvec3().midpoint(geometry.bounds_max.as_dvec3());
    let turn = |degrees: &f64| {
        let turn = DMat3::from_axis_angle(vertical(own), degrees.to_radians());
        let about = |point: Vec3| (centre + turn * (point.as_dvec3() - centre)).as_vec3();
        let name = format!("found: turned {degrees}°");
        Pose { name, eye: about(own.eye), target: about(own.target), ..own.clone() }
    };
    TURNS.iter().map(turn).collect()
}

#[cfg(test)]
mod tests {
    use glam::Vec3Swizzles as _;
    use tracebench_api::Geometry;
    use tracebench_scenes::Scene;

    use super::*;

    /// Triangles of every scene, small; brute force looks at each.
    const SCALE: f64 = 0.01;

    fn truth(scene: &Scene) -> Truth {
        let mesh = &scene.mesh;
        Truth::new(&Geometry::new(mesh.positions.clone(), mesh.triangles.clone(), None).unwrap(), "")
    }

    /// Whether a ray meets any triangle, by the volumes of tetrahedra and nothing of the truth's.
    fn meets(scene: &Scene, eye: DVec3, direction: DVec3) -> bool {
        let corner = |index: u32| Vec3::from(scene.mesh.positions[index as usize]).as_dvec3() - eye;
        scene.mesh.triangles.iter().any(|triangle| {
            let [a, b, c] = triangle.map(corner);
            let sides = [b.cross(c), c.cross(a), a.cross(b)].map(|normal| normal.dot(direction));
            let one_side = sides.iter().all(|side| *side >= 0.0) || sides.iter().all(|side| *side <= 0.0);
            one_side && a.dot(b.cross(c)) * sides.iter().sum::<f64>() > 0.0
        })
    }

    /// Seen by brute force: of a coarse grid of rays within the field of view.
    fn seen(scene: &Scene, pose: &Pose) -> usize {
        let forward = (pose.target - pose.eye).as_dvec3().normalize();
        let right = forward.cross(pose.up.as_dvec3()).normalize();
        let up = right.cross(forward);
        let steps = [-0.75, -0.25, 0.25, 0.75].map(|step: f64| step * f64::from(pose.vertical_fov / 2.0).tan());
        let rays = steps.into_iter().flat_map(|x| steps.map(|y| forward + right * x + up * y));
        rays.filter(|ray| meets(scene, pose.eye.as_dvec3(), *ray)).count()
    }

    fn bounds(scene: &Scene) -> (Vec3, Vec3) {
        let points = scene.mesh.positions.iter().map(|point| Vec3::from(*point));
        points.fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), point| (low.min(point), high.max(point)))
    }

    /// Proves that every catalogue scene has another viewpoint, listed or, when its list is withheld, found: elsewhere,
    /// inside the bounds where the own one is, with something to see, the same every time.
    #[test]
    fn every_scene_has_another_viewpoint() {
        for entry in tracebench_scenes::catalogue() {
            let scene = tracebench_scenes::procedural(entry.name, SCALE).unwrap();
            let truth = truth(&scene);
            let (low, high) = bounds(&scene);
            let inside = |eye: Vec3| eye.cmpge(low).all() && eye.cmple(high).all();
            for (place, camera) in scene.cameras.iter().enumerate() {
                let own = Pose::from(camera);
                let listed = other(&own, &scene.cameras, &truth).unwrap();
                assert!(scene.cameras.iter().any(|camera| Pose::from(camera) == listed), "{listed:?}");
                let found = other(&own, &[], &truth).unwrap();
                assert!(found.name.starts_with("found: "), "{found:?}");
                assert_eq!(other(&own, &[], &truth), Some(found.clone()));
                // Looking at the same from elsewhere is another pose; turning on the spot is none.
                for other in [listed, found].into_iter().take(if place == 0 { 2 } else { 1 }) {
                    let (name, eye) = (entry.name, other.eye);
                    assert!(own.eye.distance(eye) >= 0.0099 * low.distance(high), "{name}: {own:?} {other:?}");
                    assert!(inside(eye) || !inside(own.eye), "{name}: {other:?} in {low} to {high}");
                    assert!(seen(&scene, &other) > 0, "{name}: {other:?} sees nothing");
                }
            }
        }
    }

    /// A wall of unit squares about the z axis, at a height of z.
    fn wall(z: f32, edge: f32) -> Scene {
        let mut scene = tracebench_scenes::procedural("room", 0.001).unwrap();
        scene.mesh.positions = vec![[-edge, -edge, z], [edge, -edge, z], [edge, edge, z], [-edge, edge, z]];
        scene.mesh.triangles = vec![[0, 1, 2], [0, 2, 3]];
        scene
    }

    fn camera(name: &str, eye: [f32; 3], target: [f32; 3]) -> Camera {
        Camera { name: name.to_owned(), eye, target, up: [0.0, 1.0, 0.0], vertical_fov_radians: 1.0 }
    }

    /// Proves the order: the next listed one, round the end; those that see nothing or stand where the own one stands are
    /// passed over; without any the eye is turned about the centre, and where nothing is ever seen there is none.
    #[test]
    fn the_next_that_will_do() {
        let scene = wall(-4.0, 3.0);
        let truth = truth(&scene);
        let ahead = |name: &str, x: f32| camera(name, [x, 0.0, 0.0], [x, 0.0, -1.0]);
        let cameras = [
            ahead("first", 0.0),
            camera("turned away", [1.0, 0.0, 0.0], [1.0, 0.0, 1.0]),
            camera("on the spot", [0.0, 0.0, 0.0], [0.1, 0.0, -1.0]),
            ahead("third", 2.0),
        ];
        assert!(seen(&scene, &Pose::from(&cameras[0])) > 0 && seen(&scene, &Pose::from(&cameras[1])) == 0);
        let name = |own: &Camera, cameras: &[Camera]| other(&Pose::from(own), cameras, &truth).map(|pose| pose.name);
        assert_eq!(name(&cameras[0], &cameras).as_deref(), Some("third"));
        assert_eq!(name(&cameras[3], &cameras).as_deref(), Some("first"));
        assert_eq!(name(&ahead("of nobody", 1.0), &cameras).as_deref(), Some("first"));
        // The wall has no thickness: at 90° it is seen edge on, at 180° from behind.
        assert_eq!(name(&cameras[0], &cameras[..3]).as_deref(), Some("found: turned 180°"));
        let away = camera("away", [0.0, 0.0, 0.0], [0.0, 0.0, 1.0]);
        assert_eq!(name(&away, std::slice::from_ref(&away)), None);
        let far = wall(-4000.0, 3.0);
        assert_eq!(other(&Pose::from(&cameras[0]), &cameras, &self::truth(&far)), None);
    }

    /// Proves the way that is gone inside: half of the longest, towards what was looked at.
    #[test]
    fn half_the_longest_way() {
        let mut scene = wall(0.0, 1.0);
        // The six sides of a box of 8 x 2 x 4, as two triangles each.
        let corner = |i: u32| [(i & 1) as f32 * 8.0, (i >> 1 & 1) as f32 * 2.0, (i >> 2) as f32 * 4.0];
        scene.mesh.positions = (0..8).map(corner).collect();
        let sides = [[0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]];
        scene.mesh.triangles = sides.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
        let truth = truth(&scene);
        let own = Pose::from(&camera("own", [2.0, 1.0, 2.0], [2.0, 1.0, 0.5]));
        let found = other(&own, &[], &truth).unwrap();
        assert!(found.eye.distance(Vec3::new(5.0, 1.0, 2.0)) < 1e-5, "{found:?}");
        assert!(found.target.xz().distance(glam::Vec2::new(2.0, 0.0)) < 1e-5, "{found:?}");
    }
}
