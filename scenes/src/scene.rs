//! What a scene is made of.

use std::collections::BTreeSet;
use std::fmt;
use std::path::PathBuf;
use std::sync::Arc;

use glam::Vec3;
use serde::Serialize;

use crate::error::SceneError;
use crate::hash::content_sha256;
use crate::import::{MIN_DIAGONAL, has_zero_area};

/// The factors of a surface that a renderer of pictures and a maker of secondary rays look at.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Material {
    /// Linear base colour, each component in [0, 1].
    pub base_color: [f32; 3],
    /// 0 is a dielectric, 1 a metal.
    pub metallic: f32,
    /// 0 is perfectly smooth, 1 fully rough.
    pub roughness: f32,
    /// Refractive index of what is behind its front, at least 1, where it lets light through; else none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub refractive_index: Option<f32>,
}

impl Material {
    /// Whether the surface is treated as a mirror: a metal (at least 0.9) that is smooth (roughness at most 0.1).
    pub fn is_mirror(&self) -> bool {
        self.metallic >= 0.9 && self.roughness <= 0.1
    }
}

/// Indexed triangles with one material each.
///
/// Every index is in range, every position finite, and no vertex is without a triangle.
#[derive(Clone, Debug, PartialEq)]
pub struct Mesh {
    /// Vertex positions in world space and scene units.
    pub positions: Vec<[f32; 3]>,
    /// Three indices into `positions` a triangle, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// One index into `materials` a triangle: as long as `triangles`.
    pub triangle_materials: Vec<u32>,
    /// At least one material.
    pub materials: Vec<Material>,
    /// One index into `objects` a triangle: as long as `triangles`.
    pub triangle_objects: Vec<u32>,
    /// Names of the objects: things that are placed, or move, as one. Not necessarily unique, at least one.
    pub objects: Vec<String>,
}

/// A perspective camera: a named place to look from.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Camera {
    /// Name, unique within its scene.
    pub name: String,
    /// Position of the eye in world space.
    pub eye: [f32; 3],
    /// A point that is looked at; never equal to `eye`.
    pub target: [f32; 3],
    /// Up direction, unit length, not parallel to the line of sight.
    pub up: [f32; 3],
    /// Full vertical field of view in radians, in (0, pi).
    pub vertical_fov_radians: f32,
}

/// A pose on a [`CameraPath`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct CameraKey {
    /// When, in seconds.
    pub time_s: f64,
    /// Position of the eye in world space.
    pub eye: [f32; 3],
    /// A point that is looked at.
    pub target: [f32; 3],
    /// Up direction, unit length.
    pub up: [f32; 3],
}

/// A walk through a scene: poses in the order of time.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CameraPath {
    /// At least two keys at rising times, the first at 0.
    pub keys: Vec<CameraKey>,
    /// Full vertical field of view in radians, in (0, pi).
    pub vertical_fov_radians: f32,
}

impl CameraPath {
    /// Time of the last key in seconds.
    pub fn duration_s(&self) -> f64 {
        self.keys.last().map_or(0.0, |key| key.time_s)
    }

    /// The camera at a time, by straight lines between the keys; before the first and after the last it stands still.
    pub fn at(&self, time_s: f64) -> Camera {
        let time_s = time_s.clamp(0.0, self.duration_s());
        let next = self.keys.iter().position(|key| key.time_s >= time_s).unwrap_or(0);
        let (from, to) = (&self.keys[next.saturating_sub(1)], &self.keys[next]);
        let span = to.time_s - from.time_s;
        let share = if span > 0.0 { (time_s - from.time_s) / span } else { 0.0 };
        let mix = |a: [f32; 3], b: [f32; 3]| {
            [0, 1, 2].map(|axis| (f64::from(a[axis]) + (f64::from(b[axis]) - f64::from(a[axis])) * share) as f32)
        };
        Camera {
            name: format!("path at {time_s} s"),
            eye: mix(from.eye, to.eye),
            target: mix(from.target, to.target),
            up: if from.up == to.up {
                from.up
            } else {
                Vec3::from(mix(from.up, to.up)).try_normalize().map_or(to.up, Vec3::into)
            },
            vertical_fov_radians: self.vertical_fov_radians,
        }
    }
}

/// Positions of a scene's vertices over time; the triangles stay the same.
#[derive(Clone)]
pub struct Animation {
    /// Length in seconds, greater than zero; later times stand still at its end.
    pub duration_s: f64,
    /// The positions at a time within the duration: as many as the mesh has with nothing left out.
    pub(crate) positions_at: Arc<PositionsAt>,
    /// What is left out of the mesh, if anything is.
    pub(crate) left_out: Option<Arc<LeftOut>>,
}

/// How a mesh is without the triangles that are left out of it.
pub(crate) struct LeftOut {
    /// The vertices that are kept, in rising order.
    vertices: Vec<u32>,
    /// All triangles with their materials and objects.
    triangles: Vec<([u32; 3], u32, u32)>,
    /// What is said about those that are left out.
    warning: String,
}

/// Computes the positions of all vertices at a time in seconds.
pub(crate) type PositionsAt = dyn Fn(f64) -> Result<Vec<[f32; 3]>, SceneError> + Send + Sync;

impl Animation {
    /// The positions at a time in seconds: as many as the mesh has, in its order. Times are clamped to the duration.
    ///
    /// # Errors
    ///
    /// [`SceneError::Invalid`] if a time is not a number, or if the animation of a file leads out of the numbers.
    pub fn positions_at(&self, time_s: f64) -> Result<Vec<[f32; 3]>, SceneError> {
        let all = (self.positions_at)(time_s.clamp(0.0, self.duration_s))?;
        Ok(match &self.left_out {
            Some(left_out) => left_out.vertices.iter().map(|&vertex| all[vertex as usize]).collect(),
            None => all,
        })
    }
}

impl fmt::Debug for Animation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Animation").field("duration_s", &self.duration_s).finish_non_exhaustive()
    }
}

/// What an import dropped, kept in spite of doubt, or passed over.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct ImportNotes {
    /// Triangles of exactly zero area: no ray can hit them, so they are dropped. Of a scene that moves see [`Scene::drop_zero_area`].
    pub zero_area_triangles_dropped: u64,
    /// Triangles with the same three positions, in any order, as an earlier one: they are kept.
    pub duplicate_triangles_kept: u64,
    /// Primitives made of points or lines, which have no surface.
    pub skipped_primitives: u64,
    /// Sentences for the user, in the order of discovery.
    pub warnings: Vec<String>,
}

/// Where a scene comes from.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Origin {
    /// From the catalogue.
    Procedural {
        /// Factor on the number of triangles.
        scale: f64,
    },
    /// From a glTF file.
    File {
        /// The path as it was given; for [`crate::import_bytes`] the name that was given.
        path: PathBuf,
    },
}

/// Triangles, cameras and how they came to be.
#[derive(Clone, Debug)]
pub struct Scene {
    /// Catalogue name, or the stem of the file's name.
    pub name: String,
    /// Where it comes from.
    pub origin: Origin,
    /// The triangles: at least one.
    pub mesh: Mesh,
    /// Named viewpoints, the default one first. Empty if a file has none.
    pub cameras: Vec<Camera>,
    /// A walk through the scene; every procedural scene has one, and files with a camera that moves.
    pub camera_path: Option<CameraPath>,
    /// How it moves, if it does. The mesh is its state at `time_s`.
    pub animation: Option<Animation>,
    /// The time at which the mesh stands, in seconds.
    pub time_s: f64,
    /// What the import has to say; empty for procedural scenes.
    pub notes: ImportNotes,
    /// SHA-256 of the mesh in lower-case hex: positions, triangles, triangle materials and materials, each after its
    /// length as a 64-bit integer, all little-endian; a refractive index only where there is one. Cameras and names are not part of it.
    pub sha256: String,
    /// Least coordinates over all positions.
    pub bounds_min: [f32; 3],
    /// Greatest coordinates over all positions.
    pub bounds_max: [f32; 3],
}

impl Scene {
    /// Length of the bounding box's diagonal in scene units, greater than zero.
    pub fn diagonal(&self) -> f64 {
        let mut sum = 0.0;
        for axis in 0..3 {
            let extent = f64::from(self.bounds_max[axis]) - f64::from(self.bounds_min[axis]);
            sum += extent * extent;
        }
        sum.sqrt()
    }

    /// Moves the scene to a time in seconds: positions, bounds and hash change, triangles do not. A scene without an
    /// animation stays as it is.
    ///
    /// # Errors
    ///
    /// As [`Animation::positions_at`]; [`SceneError::Invalid`] if the scene is too small at that time.
    pub fn set_time(&mut self, time_s: f64) -> Result<(), SceneError> {
        if let Some(animation) = &self.animation {
            self.mesh.positions = animation.positions_at(time_s)?;
            self.time_s = time_s.clamp(0.0, animation.duration_s);
            (self.bounds_min, self.bounds_max) = bounds(&self.mesh.positions);
            self.sha256 = content_sha256(&self.mesh);
            self.check_size().map_err(|problem| self.invalid(format!("at {} s {problem}", self.time_s)))?;
        }
        Ok(())
    }

    /// Leaves out of a scene that moves the triangles that have exactly zero area at every one of some times in seconds,
    /// brings others back, and moves it to the first of these times. What is left out is counted and told of in the notes.
    /// A scene without an animation stays as it is.
    ///
    /// # Errors
    ///
    /// As [`Scene::set_time`]; [`SceneError::Invalid`] if no triangle has an area at any of the times.
    pub fn drop_zero_area(&mut self, times_s: &[f64]) -> Result<(), SceneError> {
        let (Some(animation), Some(first)) = (&mut self.animation, times_s.first()) else { return Ok(()) };
        let mesh = &mut self.mesh;
        let all: Vec<([u32; 3], u32, u32)> = match &animation.left_out {
            Some(left_out) => left_out.triangles.clone(),
            None => {
                let each = mesh.triangles.iter().zip(&mesh.triangle_materials).zip(&mesh.triangle_objects);
                each.map(|((triangle, material), object)| (*triangle, *material, *object)).collect()
            }
        };
        let mut has_area = vec![false; all.len()];
        for time_s in times_s {
            let positions = (animation.positions_at)(time_s.clamp(0.0, animation.duration_s))?;
            for (has_area, (triangle, ..)) in has_area.iter_mut().zip(&all) {
                *has_area |= !has_zero_area(&triangle.map(|corner| positions[corner as usize]));
            }
        }
        let when = match times_s {
            [time_s] => format!("at {} s", time_s.clamp(0.0, animation.duration_s)),
            _ => format!("at each of {} times", times_s.len()),
        };
        let kept = || all.iter().zip(&has_area).filter(|(_, has_area)| **has_area).map(|(triangle, _)| *triangle);
        let dropped = all.len() - kept().count();
        if dropped == all.len() {
            return Err(self.invalid(format!("{when} all {dropped} triangles have zero area: give another time")));
        }
        let mut vertices: Vec<u32> = kept().flat_map(|(triangle, ..)| triangle).collect();
        vertices.sort_unstable();
        vertices.dedup();
        let mut place_of = vec![0; vertices.last().map_or(0, |last| *last as usize + 1)];
        vertices.iter().zip(0..).for_each(|(&vertex, place)| place_of[vertex as usize] = place);
        mesh.triangles = kept().map(|(triangle, ..)| triangle.map(|corner| place_of[corner as usize])).collect();
        mesh.triangle_materials = kept().map(|(_, material, _)| material).collect();
        mesh.triangle_objects = kept().map(|(.., object)| object).collect();
        let before = animation.left_out.take();
        self.notes.warnings.retain(|warning| before.as_ref().is_none_or(|before| *warning != before.warning));
        self.notes.zero_area_triangles_dropped = dropped as u64;
        if dropped > 0 {
            let gone: BTreeSet<u32> = all.iter().map(|(.., object)| *object).collect();
            let gone = gone.difference(&mesh.triangle_objects.iter().copied().collect()).count();
            let objects = if gone > 0 { format!(", {gone} objects whole") } else { String::new() };
            let warning =
                format!("{when} {dropped} of {} triangles have zero area and are left out{objects}", all.len());
            self.notes.warnings.push(warning.clone());
            animation.left_out = Some(Arc::new(LeftOut { vertices, triangles: all, warning }));
        }
        self.set_time(*first)
    }

    /// Whether tracers can compute with lengths of the scene in f32.
    pub(crate) fn check_size(&self) -> Result<(), String> {
        let diagonal = self.diagonal();
        if diagonal >= MIN_DIAGONAL {
            return Ok(());
        }
        Err(format!(
            "the scene's diagonal is {diagonal:e}, and below {MIN_DIAGONAL:e} the areas of its triangles vanish in f32: \
             scale the scene up"
        ))
    }

    fn invalid(&self, problem: String) -> SceneError {
        SceneError::Invalid { scene: self.name.clone(), problem }
    }

    /// A scene from its parts, with hash and bounds computed, without path and animation.
    pub(crate) fn assemble(name: String, origin: Origin, mesh: Mesh, cameras: Vec<Camera>, notes: ImportNotes) -> Self {
        let (bounds_min, bounds_max) = bounds(&mesh.positions);
        let sha256 = content_sha256(&mesh);
        Self {
            name,
            origin,
            mesh,
            cameras,
            camera_path: None,
            animation: None,
            time_s: 0.0,
            notes,
            sha256,
            bounds_min,
            bounds_max,
        }
    }
}

fn bounds(positions: &[[f32; 3]]) -> ([f32; 3], [f32; 3]) {
    let mut bounds_min = [f32::INFINITY; 3];
    let mut bounds_max = [f32::NEG_INFINITY; 3];
    for position in positions {
        for axis in 0..3 {
            bounds_min[axis] = bounds_min[axis].min(position[axis]);
            bounds_max[axis] = bounds_max[axis].max(position[axis]);
        }
    }
    (bounds_min, bounds_max)
}
