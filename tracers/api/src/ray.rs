//! Rays, hits and their statuses, in the layout that host and device share.

use crate::named;
use bytemuck::{Pod, Zeroable};

/// A ray: `origin + t * direction` for `t_min <= t <= t_max`. 32 bytes, the same layout on the device.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Ray {
    /// Where the ray starts, scene units.
    pub origin: [f32; 3],
    /// Smallest `t` that counts, scene units, >= 0.
    pub t_min: f32,
    /// Unit direction (to f32 rounding).
    pub direction: [f32; 3],
    /// Largest `t` that counts, scene units; [`Ray::UNBOUNDED`] where the ray has no end.
    pub t_max: f32,
}

impl Ray {
    /// `t_max` of a ray without an end: large, yet its products with unit vectors and scene coordinates (at most 1e15)
    /// stay finite in f32; WGSL does not promise infinities.
    pub const UNBOUNDED: f32 = 1e30;
}

/// The primitive of a hit that names none, and of every miss.
pub const NO_PRIMITIVE: u32 = u32::MAX;

/// A tracer's answer for one ray. 20 bytes, the same layout on the device. All zeros is "not written" (poison).
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Hit {
    /// Ray parameter of the hit, scene units; 0 for a miss.
    pub t: f32,
    /// Index of the triangle in the scene, or [`NO_PRIMITIVE`] where the method does not know it.
    pub primitive: u32,
    /// Barycentric weight of the triangle's second vertex, or 0 where the method does not know it.
    pub u: f32,
    /// Barycentric weight of the triangle's third vertex, or 0 where the method does not know it.
    pub v: f32,
    /// A [`Status`] code.
    pub status: u32,
}

impl Hit {
    /// A miss with the given status.
    pub const fn miss(status: Status) -> Self {
        Self { t: 0.0, primitive: NO_PRIMITIVE, u: 0.0, v: 0.0, status: status as u32 }
    }

    /// Whether the tracer says that the ray hit something.
    pub fn is_hit(&self) -> bool {
        Status::from_code(self.status).is_some_and(Status::is_hit)
    }
}

named! {
    /// What a method saw when it ended a ray. The *cause* of a wrong answer is not told here: the judge finds it.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
    #[serde(rename_all = "snake_case")]
    #[repr(u32)]
    pub enum Status {
        /// The poison: no answer was written.
        Unwritten = "unwritten",
        /// A hit.
        Hit = "hit",
        /// The whole ray was searched and nothing found.
        Miss = "miss",
        /// Nothing found before the ray left (or without its ever entering) the views that the method holds.
        LeftViews = "left_views",
        /// The step limit was reached.
        StepCap = "step_cap",
        /// Nothing found; the ray passed behind at least one stored surface by more than the thickness, or came to one from behind where that
        /// is no hit.
        ThicknessRejected = "thickness_rejected",
        /// Nothing found; the ray passed through space that the method's last layer hides, and what lies there it does not know.
        BehindLastLayer = "behind_last_layer",
        /// A hit that the method made up where the ray entered space that its layers hide: on what its image shows just before.
        Inpainted = "inpainted",
    }
}

impl Status {
    /// The status of a code, `None` for a code that does not exist.
    pub fn from_code(code: u32) -> Option<Self> {
        Self::ALL.get(code as usize).copied()
    }

    /// Whether it says that something was hit; what was made up counts.
    pub fn is_hit(self) -> bool {
        matches!(self, Self::Hit | Self::Inpainted)
    }
}

/// What is asked of a ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Query {
    /// The nearest hit.
    Closest,
    /// Whether there is any hit.
    Any,
}

impl Query {
    /// Every query.
    pub const ALL: [Query; 2] = [Self::Closest, Self::Any];
}

named! {
    /// How far a trace goes.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
    #[serde(rename_all = "snake_case")]
    pub enum TraceTo {
        /// `t`, identity and status are resident.
        #[default]
        Hit = "hit",
        /// Position, normal and material of what was hit are resident too, as [`Surface`]s.
        Surface = "surface",
    }
}

impl TraceTo {
    /// The end point of a name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|end| end.name() == name)
    }
}

/// What a ray hit, for shading. 32 bytes, the same layout on the device. All zeros is "not written" (poison).
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Surface {
    /// Where the triangle was hit, scene units: by the hit's barycentric weights where the method knows them, else the
    /// ray's point at the hit's `t`. 0 where nothing was hit.
    pub position: [f32; 3],
    /// Index of the scene's material.
    pub material: u32,
    /// The triangle's geometric normal, of unit length, on the side from which its corners run counter-clockwise: scenes
    /// have no normals of their own. 0 where nothing was hit, and of a triangle without an area.
    pub normal: [f32; 3],
    /// A [`SurfaceStatus`] code.
    pub status: u32,
}

impl Surface {
    /// A record without a surface.
    pub const fn none(status: SurfaceStatus) -> Self {
        Self { position: [0.0; 3], material: 0, normal: [0.0; 3], status: status as u32 }
    }
}

named! {
    /// How a [`Surface`] came about.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
    #[serde(rename_all = "snake_case")]
    #[repr(u32)]
    pub enum SurfaceStatus {
        /// The poison: nothing was written.
        Unwritten = "unwritten",
        /// The surface that the ray hit.
        Written = "written",
        /// The ray has no hit.
        NoHit = "no_hit",
        /// The ray has a hit, and what fetches surfaces did not find it.
        Lost = "lost",
    }
}

impl SurfaceStatus {
    /// The status of a code, `None` for a code that does not exist.
    pub fn from_code(code: u32) -> Option<Self> {
        Self::ALL.get(code as usize).copied()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The codes in `Status` are the positions in `ALL`; shaders rely on the numbers.
    #[test]
    fn status_codes_round_trip() {
        for (code, status) in Status::ALL.iter().enumerate() {
            assert_eq!(*status as u32, code as u32);
            assert_eq!(Status::from_code(code as u32), Some(*status));
        }
        assert_eq!(Status::from_code(99), None);
        // Those of a hit are hits, and no other.
        let hits: Vec<_> = Status::ALL.into_iter().filter(|status| Hit::miss(*status).is_hit()).collect();
        assert_eq!(hits, [Status::Hit, Status::Inpainted]);
        for (code, status) in SurfaceStatus::ALL.iter().enumerate() {
            assert_eq!(*status as u32, code as u32);
            assert_eq!(SurfaceStatus::from_code(code as u32), Some(*status));
        }
        assert_eq!(SurfaceStatus::from_code(4), None);
    }

    /// Names of end points lead back to them.
    #[test]
    fn end_points_are_found_by_name() {
        assert_eq!(TraceTo::ALL.map(|end| TraceTo::named(end.name())), TraceTo::ALL.map(Some));
        assert_eq!(TraceTo::named("shade"), None);
    }
}
