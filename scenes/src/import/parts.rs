//! Primitives opened for reading: their triangles are known by number before any is made.

use gltf::json::mesh::{Mode, Primitive, Semantic};
use gltf::json::validation::Checked;

use super::accessor::{Accessor, Accessors, Kind};
use crate::scene::ImportNotes;

/// A primitive that holds triangles.
pub(super) struct Part {
    /// How messages call it: mesh, its name, primitive.
    pub(super) label: String,
    /// Vertex positions.
    pub(super) positions: Accessor,
    /// Indices into `positions`, if it is indexed.
    pub(super) indices: Option<Accessor>,
    /// Displacements of the vertices by each morph target; none where it displaces nothing.
    pub(super) targets: Vec<Option<Accessor>>,
    /// Joints and their weights, four influences a vertex each. Empty where no skin needs them.
    pub(super) influences: Vec<(Accessor, Accessor)>,
    /// Index of the document's material, if it has one.
    pub(super) material: Option<u32>,
    /// Number of triangles.
    pub(super) triangles: usize,
    /// One more than the greatest index used.
    pub(super) vertices: usize,
    mode: Mode,
}

impl Part {
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

    /// Morph targets and sets of influences that each vertex is computed from.
    pub(super) fn deformers(&self) -> usize {
        self.targets.len() + self.influences.len()
    }
}

/// Accessors of a primitive that say where its triangles are, of its skin only if it is `skinned`.
pub(super) fn accessors_of(primitive: &Primitive, skinned: bool) -> impl Iterator<Item = usize> + '_ {
    let attributes = primitive.attributes.iter().filter(move |(semantic, _)| match semantic {
        Checked::Valid(Semantic::Positions) => true,
        Checked::Valid(Semantic::Joints(_) | Semantic::Weights(_)) => skinned,
        _ => false,
    });
    let targets = primitive.targets.iter().flatten().filter_map(|target| target.positions);
    attributes.map(|(_, accessor)| *accessor).chain(primitive.indices).chain(targets).map(|index| index.value())
}

/// Opens the primitives of one mesh that hold triangles, with joints and weights if it is `skinned`.
///
/// Points and lines are counted in `notes`. `total` counts the triangles of all meshes opened so far: indices are read
/// through only while it is within the limit, however many primitives share them.
pub(super) fn open(
    accessors: &Accessors<'_>,
    mesh_index: usize,
    skinned: bool,
    total: &mut u64,
    notes: &mut ImportNotes,
) -> Result<Vec<Part>, String> {
    let mut parts = Vec::new();
    let mut without_positions = 0;
    let Some(mesh) = accessors.root.meshes.get(mesh_index) else {
        return Ok(parts);
    };
    for (primitive_index, primitive) in mesh.primitives.iter().enumerate() {
        let name = mesh.name.as_deref().unwrap_or("unnamed");
        let label = format!("meshes[{mesh_index}].primitives[{primitive_index}] ('{name}')");
        let mode = match primitive.mode {
            Checked::Valid(mode @ (Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan)) => mode,
            _ => {
                notes.skipped_primitives += 1;
                continue;
            }
        };
        if !primitive.attributes.contains_key(&Checked::Valid(Semantic::Positions)) {
            without_positions += 1;
            continue;
        }
        let part = open_part(accessors, primitive, mode, label, skinned, total, &mut notes.warnings)?;
        parts.extend(part);
    }
    if without_positions > 0 {
        notes
            .warnings
            .push(format!("primitives of meshes[{mesh_index}] without POSITION are left out ({without_positions})"));
    }
    Ok(parts)
}

/// None if there is no triangle.
fn open_part(
    accessors: &Accessors<'_>,
    primitive: &Primitive,
    mode: Mode,
    label: String,
    skinned: bool,
    total: &mut u64,
    warnings: &mut Vec<String>,
) -> Result<Option<Part>, String> {
    let fail = |problem: String| format!("{label}: {problem}; export the file again");
    let positions = attribute(accessors, primitive, Semantic::Positions, Kind::POSITION)
        .map_err(fail)?
        .ok_or_else(|| fail("it has no positions".to_owned()))?;
    let indices = accessors.open_some(primitive.indices, Kind::INDEX).map_err(fail)?;
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
                warnings.push(format!(
                    "{label}: {length} corners are no whole number of triangles; the last {} are left out",
                    length % 3
                ));
            }
            length / 3
        }
        _ => length.saturating_sub(2),
    };
    if triangles == 0 {
        return Ok(None);
    }
    *total = total.saturating_add(triangles as u64);
    super::geometry::check_total(*total)?;
    let vertices = match &indices {
        Some(indices) => max_index(indices, positions.count()).map_err(fail)?,
        None => length,
    };
    let mut targets = Vec::new();
    for (slot, target) in primitive.targets.iter().flatten().enumerate() {
        let opened = accessors.open_some(target.positions, Kind::POSITION).map_err(fail)?;
        check_count(&format!("morph target {slot}"), opened.as_ref(), vertices).map_err(fail)?;
        targets.push(opened);
    }
    let influences = if skinned { open_influences(accessors, primitive, vertices).map_err(fail)? } else { Vec::new() };
    let material = primitive.material.map(|material| material.value() as u32);
    Ok(Some(Part { label, positions, indices, targets, influences, material, triangles, vertices, mode }))
}

fn attribute(
    accessors: &Accessors<'_>,
    primitive: &Primitive,
    semantic: Semantic,
    kind: Kind,
) -> Result<Option<Accessor>, String> {
    accessors.open_some(primitive.attributes.get(&Checked::Valid(semantic)).copied(), kind)
}

fn open_influences(
    accessors: &Accessors<'_>,
    primitive: &Primitive,
    vertices: usize,
) -> Result<Vec<(Accessor, Accessor)>, String> {
    let mut influences = Vec::new();
    for set in 0.. {
        let joints = attribute(accessors, primitive, Semantic::Joints(set), Kind::JOINTS)?;
        let weights = attribute(accessors, primitive, Semantic::Weights(set), Kind::JOINT_WEIGHTS)?;
        check_count(&format!("JOINTS_{set}"), joints.as_ref(), vertices)?;
        check_count(&format!("WEIGHTS_{set}"), weights.as_ref(), vertices)?;
        match (joints, weights) {
            (Some(joints), Some(weights)) => influences.push((joints, weights)),
            (None, None) => break,
            _ => return Err(format!("it has one of JOINTS_{set} and WEIGHTS_{set}, and they come together")),
        }
    }
    Ok(influences)
}

/// Whether there are elements for all vertices.
fn check_count(what: &str, accessor: Option<&Accessor>, vertices: usize) -> Result<(), String> {
    match accessor.map(Accessor::count) {
        Some(count) if count < vertices => Err(format!("its {what} has {count} elements for {vertices} vertices")),
        _ => Ok(()),
    }
}

/// One more than the greatest index, all of which must be below `vertices`.
fn max_index(indices: &Accessor, vertices: usize) -> Result<usize, String> {
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
