//! What a scene is made of.

use std::path::PathBuf;

use serde::Serialize;

use crate::hash::content_sha256;

/// The factors of a surface that a renderer of pictures and a maker of secondary rays look at.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Material {
    /// Linear base colour, each component in [0, 1].
    pub base_color: [f32; 3],
    /// 0 is a dielectric, 1 a metal.
    pub metallic: f32,
    /// 0 is perfectly smooth, 1 fully rough.
    pub roughness: f32,
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

/// What an import dropped, kept in spite of doubt, or passed over.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct ImportNotes {
    /// Triangles of exactly zero area: no ray can hit them, so they are dropped.
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
    /// What the import has to say; empty for procedural scenes.
    pub notes: ImportNotes,
    /// SHA-256 of the mesh in lower-case hex: positions, triangles, triangle materials and materials, each after its
    /// length as a 64-bit integer, all little-endian. Cameras and names are not part of it.
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

    /// A scene from its parts, with hash and bounds computed.
    pub(crate) fn assemble(name: String, origin: Origin, mesh: Mesh, cameras: Vec<Camera>, notes: ImportNotes) -> Self {
        let mut bounds_min = [f32::INFINITY; 3];
        let mut bounds_max = [f32::NEG_INFINITY; 3];
        for position in &mesh.positions {
            for axis in 0..3 {
                bounds_min[axis] = bounds_min[axis].min(position[axis]);
                bounds_max[axis] = bounds_max[axis].max(position[axis]);
            }
        }
        let sha256 = content_sha256(&mesh);
        Self { name, origin, mesh, cameras, notes, sha256, bounds_min, bounds_max }
    }
}
