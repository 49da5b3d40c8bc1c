//! Where a view-dependent structure is built from.

use glam::{DVec3, Vec3};

/// The pose and resolutions from which structures take their views.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Viewpoint {
    /// The eye, scene units.
    pub eye: Vec3,
    /// Unit direction of view.
    pub forward: Vec3,
    /// Unit vector up in the image, square to `forward`.
    pub up: Vec3,
    /// Whole vertical field of view of the frame, radians, between 0 and pi.
    pub vertical_fov: f32,
    /// Near distance, eye depth in scene units.
    pub near: f32,
    /// Far distance, eye depth in scene units.
    pub far: f32,
    /// Width and height of the frame, pixels.
    pub frame: [u32; 2],
    /// Edge of a cube face, pixels.
    pub face: u32,
}

impl Viewpoint {
    /// The camera's view at the frame's resolution.
    pub fn frame_view(&self) -> View {
        let tan_half_height = (f64::from(self.vertical_fov) / 2.0).tan();
        let (forward, up) = (self.forward.as_dvec3(), self.up.as_dvec3());
        View {
            eye: self.eye.as_dvec3(),
            right: forward.cross(up),
            up,
            forward,
            tan_half_width: tan_half_height * f64::from(self.frame[0]) / f64::from(self.frame[1]),
            tan_half_height,
            near: f64::from(self.near),
            far: f64::from(self.far),
            size: self.frame,
        }
    }

    /// Six views of 90 degrees along the world's axes (+x, -x, +y, -y, +z, -z) round the eye, `face` pixels along an
    /// edge. `pulled_back` (scene units) shifts each centre against its direction: by the near distance, the near planes
    /// meet in the eye and nothing is lost before them (VVP16, section 3.2).
    pub fn face_views(&self, pulled_back: f64) -> [View; 6] {
        let axes = [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z];
        axes.map(|forward| {
            let up = if forward.y == 0.0 { DVec3::Y } else { DVec3::NEG_Z * forward.y };
            View {
                eye: self.eye.as_dvec3() - forward * pulled_back,
                right: forward.cross(up),
                up,
                forward,
                tan_half_width: 1.0,
                tan_half_height: 1.0,
                near: f64::from(self.near),
                // The farthest point may lie straight ahead of a centre that was pulled back.
                far: f64::from(self.far) + pulled_back,
                size: [self.face; 2],
            }
        })
    }
}

/// One perspective view, in f64: the reference for the shaders' projection, and what the judge projects true hits into.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Centre of projection.
    pub eye: DVec3,
    /// Unit vector to the right in the image.
    pub right: DVec3,
    /// Unit vector up in the image.
    pub up: DVec3,
    /// Unit direction of view.
    pub forward: DVec3,
    /// Tangent of half the horizontal field of view.
    pub tan_half_width: f64,
    /// Tangent of half the vertical field of view.
    pub tan_half_height: f64,
    /// Near distance, eye depth.
    pub near: f64,
    /// Far distance, eye depth.
    pub far: f64,
    /// Width and height, pixels.
    pub size: [u32; 2],
}

/// A point in a view.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Projected {
    /// Pixels from the left edge; pixel `i` spans `[i, i + 1)`.
    pub x: f64,
    /// Pixels from the top edge.
    pub y: f64,
    /// Linear eye depth, scene units.
    pub depth: f64,
}

impl View {
    /// Projects a point; `None` if it is not in front of the eye.
    pub fn project(&self, point: DVec3) -> Option<Projected> {
        let offset = point - self.eye;
        let depth = offset.dot(self.forward);
        if depth <= 0.0 {
            return None;
        }
        let x = offset.dot(self.right) / (depth * self.tan_half_width);
        let y = offset.dot(self.up) / (depth * self.tan_half_height);
        Some(Projected {
            x: (x + 1.0) * 0.5 * f64::from(self.size[0]),
            y: (1.0 - y) * 0.5 * f64::from(self.size[1]),
            depth,
        })
    }

    /// Projects a point if it lies inside the view: on its pixels, between near and far.
    pub fn project_inside(&self, point: DVec3) -> Option<Projected> {
        self.project(point).filter(|at| {
            (0.0..f64::from(self.size[0])).contains(&at.x)
                && (0.0..f64::from(self.size[1])).contains(&at.y)
                && (self.near..=self.far).contains(&at.depth)
        })
    }

    /// Direction (not unit: its eye depth is 1) through a position in pixels.
    pub fn direction_through(&self, x: f64, y: f64) -> DVec3 {
        let across = (2.0 * x / f64::from(self.size[0]) - 1.0) * self.tan_half_width;
        let upward = (1.0 - 2.0 * y / f64::from(self.size[1])) * self.tan_half_height;
        self.forward + self.right * across + self.up * upward
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn view() -> View {
        Viewpoint {
            eye: Vec3::new(1.0, 2.0, 3.0),
            forward: Vec3::NEG_Z,
            up: Vec3::Y,
            vertical_fov: 1.0,
            near: 0.1,
            far: 100.0,
            frame: [200, 100],
            face: 64,
        }
        .frame_view()
    }

    /// A point on the line through a pixel position projects back to that position.
    #[test]
    fn projection_inverts_direction() {
        let view = view();
        for (x, y) in [(0.5, 0.5), (100.0, 50.0), (199.5, 0.25), (13.0, 77.0)] {
            let at = view.project(view.eye + view.direction_through(x, y) * 7.0).unwrap();
            assert!((at.x - x).abs() < 1e-9 && (at.y - y).abs() < 1e-9 && (at.depth - 7.0).abs() < 1e-9);
        }
    }

    /// Right of the image is +x for a camera that looks along -z with y up; top of the image is y = 0.
    #[test]
    fn image_axes_are_right_and_down() {
        let view = view();
        let at = view.project(view.eye + DVec3::new(0.5, 0.5, -5.0)).unwrap();
        assert!(at.x > 100.0 && at.y < 50.0);
    }

    /// Every direction lies in a face, in one alone where it is not on a border, and pulling the centres back leaves none of
    /// the points before near out.
    #[test]
    fn faces_cover_every_direction_once() {
        let viewpoint = Viewpoint {
            eye: Vec3::new(1.0, 2.0, 3.0),
            forward: Vec3::NEG_Z,
            up: Vec3::Y,
            vertical_fov: 1.0,
            near: 0.1,
            far: 100.0,
            frame: [200, 100],
            face: 64,
        };
        let eye = viewpoint.eye.as_dvec3();
        for step in 0..200 {
            let (turn, rise) = (f64::from(step) * 2.399, f64::from(step) / 100.0 - 0.995);
            let level = (1.0 - rise * rise).sqrt();
            let direction = DVec3::new(level * turn.cos(), rise, level * turn.sin());
            let inside = |distance: f64, pulled_back: f64| {
                let point = eye + direction * distance;
                viewpoint.face_views(pulled_back).iter().filter(|view| view.project_inside(point).is_some()).count()
            };
            assert_eq!(inside(5.0, 0.0), 1, "{direction}");
            assert!(inside(5.0, 0.1) >= 1 && inside(0.01, 0.1) >= 1, "{direction}");
            assert_eq!(inside(0.01, 0.0), 0, "{direction}");
        }
    }

    /// Points behind the eye, before near and off the frame are not inside.
    #[test]
    fn outside_is_outside() {
        let view = view();
        assert!(view.project(view.eye + DVec3::Z).is_none());
        assert!(view.project_inside(view.eye - DVec3::Z * 0.05).is_none());
        assert!(view.project_inside(view.eye + DVec3::new(50.0, 0.0, -1.0)).is_none());
        assert!(view.project_inside(view.eye - DVec3::Z).is_some());
    }
}
