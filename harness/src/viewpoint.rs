//! Choosing a viewpoint.
//!
//! A scene's first camera is its default. An imported scene without one gets a viewpoint by this rule. Points of a
//! 7 x 5 x 7 grid inside the bounds look into 128 directions each. A point is *interior* if at least three quarters of
//! its directions hit something, at least 60 % of the hits show their front (counter-clockwise) side, and nothing lies
//! nearer than a hundredth of the diagonal: inside a room one sees walls from the front, inside a solid one sees backs.
//! If there are interior points, the eye is the one with the longest mean free distance, and it looks along the most
//! open of 16 horizontal directions. Otherwise the scene is an object: the eye stands outside, up and to the right in
//! front of it, far enough that the bounding sphere fits the vertical field of view.

mod other;

use glam::{DQuat, DVec3, Vec3};
use rayon::prelude::*;
use tracebench_api::{Geometry, Viewpoint};
use tracebench_scenes::Camera;

pub use other::other;

use crate::truth::{Ray64, Truth};

/// Vertical field of view where nothing else is said.
pub const DEFAULT_VERTICAL_FOV_DEGREES: f32 = 60.0;

/// Near distance, in scene diagonals.
pub const NEAR_DIAGONALS: f64 = 1e-3;

/// Grid points along each axis.
const GRID: [u32; 3] = [7, 5, 7];
/// Directions that each grid point looks into.
const DIRECTIONS: u32 = 128;
const INTERIOR_HIT_SHARE: f64 = 0.75;
const INTERIOR_FRONT_SHARE: f64 = 0.6;
const INTERIOR_CLEARANCE_DIAGONALS: f64 = 0.01;
/// Horizontal directions among which an interior eye looks along the most open one.
const HEADINGS: u32 = 16;
/// Where the eye of an object stands, from the centre of its bounds.
const OUTSIDE: DVec3 = DVec3::new(0.5, 0.35, 1.0);

/// A pose with a name.
#[derive(Clone, Debug, PartialEq)]
pub struct Pose {
    /// Name, or how it was found.
    pub name: String,
    /// The eye.
    pub eye: Vec3,
    /// A point that it looks at.
    pub target: Vec3,
    /// Roughly up.
    pub up: Vec3,
    /// Whole vertical field of view, radians.
    pub vertical_fov: f32,
}

/// What is wrong with a pose.
#[derive(Debug, thiserror::Error, PartialEq)]
pub enum PoseError {
    /// Not two points.
    #[error("'{0}' is no viewpoint: give a name, or ex,ey,ez:tx,ty,tz (eye and target)")]
    Syntax(String),
    /// Eye and target coincide, or are not finite.
    #[error("the eye {0} and the target {1} must be finite and apart")]
    Degenerate(Vec3, Vec3),
}

impl From<&Camera> for Pose {
    fn from(camera: &Camera) -> Self {
        Self {
            name: camera.name.clone(),
            eye: camera.eye.into(),
            target: camera.target.into(),
            up: camera.up.into(),
            vertical_fov: camera.vertical_fov_radians,
        }
    }
}

impl Pose {
    /// Reads `ex,ey,ez:tx,ty,tz`.
    ///
    /// # Errors
    /// [`PoseError`] if it is not that.
    pub fn parse(text: &str) -> Result<Self, PoseError> {
        let syntax = || PoseError::Syntax(text.to_owned());
        let point = |part: &str| -> Option<Vec3> {
            let numbers: Vec<f32> =
                part.split(',').map(|number| number.trim().parse()).collect::<Result<_, _>>().ok()?;
            <[f32; 3]>::try_from(numbers).ok().map(Vec3::from)
        };
        let (eye, target) = text.split_once(':').ok_or_else(syntax)?;
        let (eye, target) = point(eye).zip(point(target)).ok_or_else(syntax)?;
        if !eye.is_finite() || !target.is_finite() || eye == target {
            return Err(PoseError::Degenerate(eye, target));
        }
        Ok(Self {
            name: "given".to_owned(),
            eye,
            target,
            up: Vec3::Y,
            vertical_fov: DEFAULT_VERTICAL_FOV_DEGREES.to_radians(),
        })
    }

    /// Another eye on the circle through this one, level round what lies half a diagonal before it, by so many parts of the circle further.
    pub fn turned(&self, diagonal: f64, parts: usize, of: usize) -> Self {
        let (eye, target) = (self.eye.as_dvec3(), self.target.as_dvec3());
        let centre = eye + (target - eye).normalize_or(DVec3::NEG_Z) * (diagonal / 2.0);
        let turn = DQuat::from_rotation_y(std::f64::consts::TAU * parts as f64 / of as f64);
        let name = format!("{}, {parts}/{of} further", self.name);
        Self { name, eye: (centre + turn * (eye - centre)).as_vec3(), target: centre.as_vec3(), ..self.clone() }
    }

    /// The viewpoint at given resolutions. Near is a thousandth of the scene's diagonal; far lies behind everything.
    pub fn viewpoint(&self, geometry: &Geometry, frame: [u32; 2], face: u32) -> Viewpoint {
        let forward = (self.target.as_dvec3() - self.eye.as_dvec3()).normalize_or(DVec3::NEG_Z);
        let hint = self.up.as_dvec3().normalize_or(DVec3::Y);
        // Looking straight up or down, another axis has to say what is up in the image.
        let hint = if forward.cross(hint).length() < 1e-6 { forward.any_orthonormal_vector() } else { hint };
        let right = forward.cross(hint).normalize();
        let near = NEAR_DIAGONALS * geometry.diagonal();
        let far = (geometry.farthest_corner(self.eye) * 1.01).max(near * 10.0);
        Viewpoint {
            eye: self.eye,
            forward: forward.as_vec3(),
            up: right.cross(forward).as_vec3(),
            vertical_fov: self.vertical_fov,
            near: near as f32,
            far: far as f32,
            frame,
            face,
        }
    }
}

/// The pose for a scene without a camera, by the rule in this module's documentation.
pub fn find(truth: &Truth) -> Pose {
    let geometry = truth.geometry();
    let (low, high) = (geometry.bounds_min.as_dvec3(), geometry.bounds_max.as_dvec3());
    let place = |index: u32| {
        let steps = [index % GRID[0], index / GRID[0] % GRID[1], index / (GRID[0] * GRID[1])];
        let fraction = |axis: usize| f64::from(steps[axis] + 1) / f64::from(GRID[axis] + 1);
        low + (high - low) * DVec3::new(fraction(0), fraction(1), fraction(2))
    };
    let openness = |index: u32| interior_openness(truth, place(index)).map(|openness| (openness, index));
    let found: Vec<(f64, u32)> = (0..GRID[0] * GRID[1] * GRID[2]).into_par_iter().filter_map(openness).collect();
    // Equal openness goes to the first, so that the choice is the same on every run.
    let best = found.into_iter().reduce(|best, next| if next.0 > best.0 { next } else { best });
    let vertical_fov = DEFAULT_VERTICAL_FOV_DEGREES.to_radians();
    let (name, eye, target) = match best {
        Some((_, index)) => {
            let eye = place(index);
            ("found: interior", eye, eye + most_open_heading(truth, eye))
        }
        None => {
            let centre = (low + high) / 2.0;
            let distance = geometry.diagonal() / 2.0 / (f64::from(vertical_fov) / 2.0).sin();
            ("found: outside", centre + OUTSIDE.normalize() * distance * 1.05, centre)
        }
    };
    Pose { name: name.to_owned(), eye: eye.as_vec3(), target: target.as_vec3(), up: Vec3::Y, vertical_fov }
}

fn look(truth: &Truth, eye: DVec3, direction: DVec3) -> Option<(f64, bool)> {
    let ray = Ray64 { origin: eye, direction, t_min: 0.0, t_max: f64::INFINITY };
    truth.closest(&ray).map(|hit| (hit.t, truth.normal(hit.primitive).dot(direction) < 0.0))
}

/// Mean free distance of an interior point, `None` for any other.
fn interior_openness(truth: &Truth, eye: DVec3) -> Option<f64> {
    let seen: Vec<(f64, bool)> = (0..DIRECTIONS).filter_map(|index| look(truth, eye, sphere(index))).collect();
    let hits = seen.len() as f64;
    let fronts = seen.iter().filter(|(_, front)| *front).count() as f64;
    let nearest = seen.iter().map(|(distance, _)| *distance).fold(f64::INFINITY, f64::min);
    let interior = hits >= INTERIOR_HIT_SHARE * f64::from(DIRECTIONS)
        && fronts >= INTERIOR_FRONT_SHARE * hits
        && nearest >= INTERIOR_CLEARANCE_DIAGONALS * truth.diagonal();
    interior.then(|| seen.iter().map(|(distance, _)| distance).sum::<f64>() / hits)
}

/// The i-th of evenly spread directions (a Fibonacci lattice on the sphere).
fn sphere(index: u32) -> DVec3 {
    let golden_angle = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
    let height = 1.0 - 2.0 * (f64::from(index) + 0.5) / f64::from(DIRECTIONS);
    let (sin, cos) = (golden_angle * f64::from(index)).sin_cos();
    let radius = (1.0 - height * height).sqrt();
    DVec3::new(radius * cos, height, radius * sin)
}

/// The horizontal direction with the longest free distance, averaged with its neighbours'.
fn most_open_heading(truth: &Truth, eye: DVec3) -> DVec3 {
    let heading = |index: u32| {
        let (sin, cos) = (std::f64::consts::TAU * f64::from(index) / f64::from(HEADINGS)).sin_cos();
        DVec3::new(sin, 0.0, -cos)
    };
    let free: Vec<f64> = (0..HEADINGS)
        .map(|index| look(truth, eye, heading(index)).map_or(truth.diagonal(), |(distance, _)| distance))
        .collect();
    let count = free.len();
    let smoothed = |index: usize| free[index] + 0.5 * (free[(index + 1) % count] + free[(index + count - 1) % count]);
    let best = (0..count).reduce(|best, next| if smoothed(next) > smoothed(best) { next } else { best });
    heading(best.unwrap_or(0) as u32)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The corners of an axis-aligned box, wound outward, or inward for a room.
    fn boxed(inward: bool) -> Truth {
        let positions: Vec<[f32; 3]> =
            (0..8_u8).map(|i| [i & 1, i >> 1 & 1, i >> 2 & 1].map(|bit| f32::from(bit) * 4.0)).collect();
        let outward = [
            [0, 2, 1],
            [1, 2, 3],
            [4, 5, 6],
            [5, 7, 6],
            [0, 1, 4],
            [1, 5, 4],
            [2, 6, 3],
            [3, 6, 7],
            [0, 4, 2],
            [2, 4, 6],
            [1, 3, 5],
            [3, 7, 5],
        ];
        let triangles = outward.map(|[a, b, c]| if inward { [a, c, b] } else { [a, b, c] }).to_vec();
        Truth::new(&Geometry::new(positions, triangles, None).unwrap(), "box")
    }

    /// A room gets an eye inside, the same box wound outward gets one outside that sees it.
    #[test]
    fn rooms_are_entered_and_objects_are_not() {
        let inside = |pose: &Pose| pose.eye.cmpgt(Vec3::ZERO).all() && pose.eye.cmplt(Vec3::splat(4.0)).all();
        let room = find(&boxed(true));
        assert!(inside(&room) && room.name == "found: interior", "{room:?}");
        let truth = boxed(false);
        let object = find(&truth);
        assert!(!inside(&object), "{object:?}");
        let direction = (object.target - object.eye).as_dvec3().normalize();
        assert!(look(&truth, object.eye.as_dvec3(), direction).is_some());
    }

    /// How much of the surroundings makes an interior: from the middle of a room without a roof five sixths of all
    /// directions hit a wall, which is enough; without a wall as well it is two thirds, which is not. Walls seen from
    /// behind make no interior either.
    #[test]
    fn interiors_are_mostly_closed() {
        let without = |sides: &[usize], inward: bool| {
            let whole = boxed(inward);
            let kept = |(index, triangle): (usize, &[u32; 3])| (!sides.contains(&(index / 2))).then_some(*triangle);
            let triangles = whole.geometry().triangles.iter().enumerate().filter_map(kept).collect();
            Truth::new(&Geometry::new(whole.geometry().positions.to_vec(), triangles, None).unwrap(), "open box")
        };
        // In the order of `boxed`, a pair of triangles each: z-, z+, y-, y+, x-, x+.
        assert_eq!(find(&without(&[3], true)).name, "found: interior");
        assert_eq!(find(&without(&[3], false)).name, "found: outside");
        let centre = |truth: &Truth| interior_openness(truth, DVec3::splat(2.0));
        assert!(centre(&without(&[3], true)).is_some());
        assert!(centre(&without(&[1, 3], true)).is_none());
    }

    /// Negative numbers are read; what is not two finite, separate points is refused.
    #[test]
    fn poses_are_parsed() {
        let pose = Pose::parse("-1,2,-3.5:0,0,1e1").unwrap();
        assert_eq!((pose.eye, pose.target), (Vec3::new(-1.0, 2.0, -3.5), Vec3::new(0.0, 0.0, 10.0)));
        for bad in ["", "1,2,3", "1,2:3,4,5", "1,2,3:1,2,3", "a,b,c:1,2,3", "NaN,0,0:1,1,1", "1,2,3:4,5,inf"] {
            assert!(Pose::parse(bad).is_err(), "{bad}");
        }
    }

    /// Looking straight down gives an orthonormal pose.
    #[test]
    fn straight_down_is_a_pose() {
        let truth = boxed(true);
        let viewpoint = Pose::parse("2,3,2:2,0,2").unwrap().viewpoint(truth.geometry(), [8, 8], 8);
        assert!(viewpoint.up.is_finite() && viewpoint.up.dot(viewpoint.forward).abs() < 1e-6);
        assert!((viewpoint.up.length() - 1.0).abs() < 1e-6);
    }
}
