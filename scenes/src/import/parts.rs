//! Primitives opened for reading: their triangles are known by number before any is made.

use gltf::json::Root;
use gltf::json::mesh::{Mode, Semantic};
use gltf::json::validation::Checked;

use super::accessor::{Elements, Kind, buffers_of};
use super::buffers::Buffers;
use crate::error::SceneError;
use crate::scene::ImportNotes;

/// A primitive that holds triangles.
pub(super) struct Part<'a> {
    /// How messages call it: mesh, its name, primitive.
    pub(super) label: String,
    /// Vertex positions.
    pub(super) positions: Elements<'a>,
    /// Indices into `positions`, if it is indexed.
    pub(super) indices: Option<Elements<'a>>,
    /// Index of the document's material, if it has one.
    pub(super) material: Option<u32>,
    /// Number of triangles.
    pub(super) triangles: usize,
    /// One more than the greatest index used.
    pub(super) vertices: usize,
    mode: Mode,
}

impl Part<'_> {
    /// The three vertex indices of triangle `at`, in the winding that glTF defines for its mode.
    pub(super) fn corners(&self, at: usize) -> [u32; 3] {
        let slots = match self.mode {
            // Every other triangle of a strip runs the other way round.
            Mode::TriangleStrip => [at, at + 1 + at % 2, at + 2 - at % 2],
            Mode::TriangleFan => [at + 1, at + 2, 0],
            _ => [3 * at, 3 * at + 1, 3 * at + 2],
        };
        slots.map(|slot| match &self.indices {
            Some(indices) => indices.index(slot),
            // Checked when the part was opened: there are at most 2^32 vertices.
            None => slot as u32,
        })
    }
}

/// Loads the buffers that the meshes marked in `used` read geometry from.
pub(super) fn load_buffers(root: &Root, used: &[bool], buffers: &mut Buffers<'_>) -> Result<(), SceneError> {
    for (mesh, _) in root.meshes.iter().zip(used).filter(|(_, used)| **used) {
        for primitive in &mesh.primitives {
            let positions = primitive.attributes.get(&POSITION);
            for accessor in positions.into_iter().chain(&primitive.indices) {
                for buffer in buffers_of(root, accessor.value()) {
                    buffers.load(root, buffer)?;
                }
            }
        }
    }
    Ok(())
}

const POSITION: Checked<Semantic> = Checked::Valid(Semantic::Positions);

/// Opens the primitives of one mesh that hold triangles.
///
/// Points and lines are counted in `notes`. `total` counts the triangles of all meshes opened so far: indices are read
/// through only while it is within the limit, however many primitives share them.
pub(super) fn open<'a>(
    root: &Root,
    buffers: &'a Buffers<'_>,
    mesh_index: usize,
    total: &mut u64,
    notes: &mut ImportNotes,
) -> Result<Vec<Part<'a>>, String> {
    let mut parts = Vec::new();
    let Some(mesh) = root.meshes.get(mesh_index) else {
        return Ok(parts);
    };
    for (primitive_index, primitive) in mesh.primitives.iter().enumerate() {
        let name = mesh.name.as_deref().unwrap_or("unnamed");
        let label = format!("mesh {mesh_index} ('{name}') primitive {primitive_index}");
        let mode = match primitive.mode {
            Checked::Valid(mode @ (Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan)) => mode,
            _ => {
                notes.skipped_primitives += 1;
                continue;
            }
        };
        let fail = |problem: String| format!("{label}: {problem}; export the file again");
        let accessor = primitive.attributes.get(&POSITION).ok_or_else(|| fail("it has no positions".to_owned()))?;
        let positions = Elements::open(root, buffers, accessor.value(), Kind::Position).map_err(fail)?;
        let indices = primitive
            .indices
            .map(|accessor| Elements::open(root, buffers, accessor.value(), Kind::Index))
            .transpose()
            .map_err(fail)?;
        let length = indices.as_ref().unwrap_or(&positions).count();
        if u32::try_from(positions.count()).is_err() || length as u64 > 3 * super::MAX_TRIANGLES {
            return Err(format!(
                "{label} has {} vertices and {length} corners, which is too much: split it or reduce it",
                positions.count()
            ));
        }
        let triangles = match mode {
            Mode::Triangles => {
                if length % 3 != 0 {
                    notes.warnings.push(format!(
                        "{label}: {length} corners are no whole number of triangles; the last {} are left out",
                        length % 3
                    ));
                }
                length / 3
            }
            _ => length.saturating_sub(2),
        };
        if triangles == 0 {
            continue;
        }
        *total = total.saturating_add(triangles as u64);
        super::check_total(*total)?;
        let vertices = match &indices {
            Some(indices) => greatest_index(indices, positions.count()).map_err(fail)?,
            None => length,
        };
        parts.push(Part {
            label,
            positions,
            indices,
            material: primitive.material.map(|material| material.value() as u32),
            triangles,
            vertices,
            mode,
        });
    }
    Ok(parts)
}

/// One more than the greatest index, all of which must be below `vertices`.
fn greatest_index(indices: &Elements<'_>, vertices: usize) -> Result<usize, String> {
    let mut end = 0;
    for at in 0..indices.count() {
        let index = indices.index(at) as usize;
        if index >= vertices {
            return Err(format!("index {at} is {index}, out of range: there are {vertices} vertices"));
        }
        end = end.max(index + 1);
    }
    Ok(end)
}
