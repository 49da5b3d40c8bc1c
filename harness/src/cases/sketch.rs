//! What cases are drawn with: triangles, a camera, seeded rays.

use glam::{DQuat, DVec3, Vec3, dvec3};
use tracebench_api::{Geometry, Query, Ray, Viewpoint};

use super::Setup;
use crate::rays::sampling::Stream;
use crate::viewpoint::Pose;

/// Rays of a case where nothing else is said.
pub(super) const RAYS: usize = 1200;

/// A case in the making: triangles, a camera and rays.
pub(super) struct Sketch {
    pub(super) camera: Camera,
    /// What is asked of the rays.
    pub(super) query: Query,
    /// What tells the cases' numbers apart.
    pub(super) seed: u64,
    positions: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
    rays: Vec<Ray>,
    numbers: Stream,
}

impl Sketch {
    /// Nothing, seen by the default camera.
    pub(super) fn new(seed: u64) -> Self {
        let (camera, query, numbers) = (Camera::default(), Query::Closest, Stream::new(1, 0x100, seed));
        Self { camera, query, seed, positions: Vec::new(), triangles: Vec::new(), rays: Vec::new(), numbers }
    }

    pub(super) fn triangle(&mut self, corners: [DVec3; 3]) {
        let first = self.positions.len() as u32;
        self.positions.extend(corners.map(|corner| corner.as_vec3().to_array()));
        self.triangles.push([first, first + 1, first + 2]);
    }

    /// A parallelogram of two triangles: a corner and the two edges that start there.
    pub(super) fn plate(&mut self, corner: DVec3, along: DVec3, upward: DVec3) {
        let first = self.positions.len() as u32;
        let corners = [corner, corner + along, corner + along + upward, corner + upward];
        self.positions.extend(corners.map(|corner| corner.as_vec3().to_array()));
        self.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
    }

    /// A parallelogram round its centre, by its half edges.
    pub(super) fn plate_around(&mut self, centre: DVec3, half_along: DVec3, half_upward: DVec3) {
        self.plate(centre - half_along - half_upward, 2.0 * half_along, 2.0 * half_upward);
    }

    /// A triangle so small that nothing meets it: it only widens the scene's bounds.
    pub(super) fn speck(&mut self, at: DVec3) {
        let edge = 1e-6 * at.length().max(1.0);
        self.triangle([at, at + DVec3::X * edge, at + DVec3::Y * edge]);
    }

    /// Widens the scene to bounds that no difficulty parameter changes.
    pub(super) fn widen(&mut self, ends: [DVec3; 2]) {
        ends.into_iter().for_each(|end| self.speck(end));
    }

    /// A closed block round its centre by its three half edges: twelve triangles that share their corners, with their fronts
    /// outward where the half edges are right-handed, else inward.
    pub(super) fn block(&mut self, centre: DVec3, half_edges: [DVec3; 3]) {
        let first = self.positions.len() as u32;
        for corner in 0..8 {
            let side = |axis: usize| if corner >> axis & 1 == 1 { half_edges[axis] } else { -half_edges[axis] };
            self.positions.push((centre + side(0) + side(1) + side(2)).as_vec3().to_array());
        }
        // Bit by bit a corner is on the far side of each half edge.
        let sides = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
        for [a, b, c, d] in sides.map(|side: [u32; 4]| side.map(|corner| first + corner)) {
            self.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }

    /// A sphere of 12 `cells`² triangles that share their vertices, turned off the axes so that none of its edges lies
    /// along one; `keep` says which triangles stay.
    pub(super) fn sphere(&mut self, centre: DVec3, radius: f64, cells: u32, keep: impl Fn(&mut Stream) -> bool) {
        let turn = DQuat::from_xyzw(0.17, 0.31, -0.23, 0.9).normalize();
        for face in 0..6 {
            let first = self.positions.len() as u32;
            let side = if face % 2 == 0 { 1.0 } else { -1.0 };
            for row in 0..=cells {
                for column in 0..=cells {
                    let place = |step: u32| 2.0 * f64::from(step) / f64::from(cells) - 1.0;
                    let (across, upward) = (place(column) * side, place(row));
                    let on_cube = match face / 2 {
                        0 => dvec3(side, across, upward),
                        1 => dvec3(upward, side, across),
                        _ => dvec3(across, upward, side),
                    };
                    let point = centre + turn * on_cube.normalize() * radius;
                    self.positions.push(point.as_vec3().to_array());
                }
            }
            for row in 0..cells {
                for column in 0..cells {
                    let corner = first + row * (cells + 1) + column;
                    let (right, up) = (corner + 1, corner + cells + 1);
                    for triangle in [[corner, right, up + 1], [corner, up + 1, up]] {
                        if keep(&mut self.numbers) {
                            self.triangles.push(triangle);
                        }
                    }
                }
            }
        }
    }

    /// In [0, 1).
    pub(super) fn unit(&mut self) -> f64 {
        self.numbers.unit()
    }

    /// In [-1, 1).
    pub(super) fn signed(&mut self) -> f64 {
        2.0 * self.unit() - 1.0
    }

    /// In the cube from -1 to 1.
    pub(super) fn point(&mut self) -> DVec3 {
        dvec3(self.signed(), self.signed(), self.signed())
    }

    /// A unit vector.
    pub(super) fn direction(&mut self) -> DVec3 {
        self.numbers.sphere()
    }

    /// A ray without an end; the direction is made a unit vector from the origin as f32 has it.
    pub(super) fn towards(&mut self, origin: DVec3, target: DVec3) {
        let origin = origin.as_vec3();
        let direction = (target - origin.as_dvec3()).normalize_or(DVec3::NEG_Z).as_vec3();
        self.rays.push(Ray { origin: origin.into(), t_min: 0.0, direction: direction.into(), t_max: Ray::UNBOUNDED });
    }

    /// A ray that ends at its target.
    pub(super) fn until(&mut self, origin: DVec3, target: DVec3) {
        self.towards(origin, target);
        if let Some(ray) = self.rays.last_mut() {
            ray.t_max = (target - Vec3::from(ray.origin).as_dvec3()).length() as f32;
        }
    }

    /// From the eye through the centres of random pixels: what a sampled method knows best.
    pub(super) fn through_centres(&mut self, count: usize) {
        let view = self.viewpoint().frame_view();
        for _ in 0..count {
            let place = |edge: u32, part: f64| (part * f64::from(edge)).floor() + 0.5;
            let (x, y) = (place(view.size[0], self.unit()), place(view.size[1], self.unit()));
            self.towards(view.eye, view.eye + view.direction_through(x, y));
        }
    }

    /// The eye of its camera.
    pub(super) fn eye(&self) -> DVec3 {
        self.camera.eye.as_dvec3()
    }

    /// The diagonal of what is drawn.
    pub(super) fn diagonal(&self) -> f64 {
        self.geometry().diagonal()
    }

    /// What its camera sees of what is drawn.
    pub(super) fn viewpoint(&self) -> Viewpoint {
        let Camera { eye, target, vertical_fov, frame, face, near } = self.camera;
        let pose = Pose { name: "case".to_owned(), eye, target, up: Vec3::Y, vertical_fov };
        let viewpoint = pose.viewpoint(&self.geometry(), frame, face);
        Viewpoint { near: near.unwrap_or(viewpoint.near), ..viewpoint }
    }

    fn geometry(&self) -> Geometry {
        let (positions, triangles) = (self.positions.clone(), self.triangles.clone());
        Geometry::new(positions, triangles, None).expect("a case draws triangles before anything is asked of it")
    }

    /// What was drawn. Without other rays it has its ordinary ones: from the eye through pixel centres.
    pub(super) fn setup(mut self) -> Setup {
        if self.rays.is_empty() {
            self.through_centres(RAYS);
        }
        Setup { geometry: self.geometry(), viewpoint: self.viewpoint(), rays: self.rays, query: self.query }
    }
}

/// Where a case is seen from.
#[derive(Clone, Copy)]
pub(super) struct Camera {
    pub(super) eye: Vec3,
    pub(super) target: Vec3,
    /// Radians.
    pub(super) vertical_fov: f32,
    /// Pixels.
    pub(super) frame: [u32; 2],
    /// Edge of the cube faces, pixels.
    pub(super) face: u32,
    /// Near distance, scene units; a thousandth of the diagonal if `None`.
    pub(super) near: Option<f32>,
}

impl Default for Camera {
    /// From the coordinates' origin along -z, 60 degrees over 256 x 256 pixels.
    fn default() -> Self {
        let vertical_fov = crate::viewpoint::DEFAULT_VERTICAL_FOV_DEGREES.to_radians();
        Self { eye: Vec3::ZERO, target: Vec3::NEG_Z, vertical_fov, frame: [256, 256], face: 256, near: None }
    }
}

/// Edge of a pixel of the default camera at depth 1, scene units.
pub(super) const PIXEL: f64 = 2.0 * 0.577_350_269 / 256.0;
