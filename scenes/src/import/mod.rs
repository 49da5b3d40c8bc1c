//! glTF 2.0 import: positions, indices, material factors and cameras, and no byte that is not checked first.
//!
//! The `gltf` crate splits, types and validates; its readers of buffers are not used, because they panic on data that
//! do not fit.

mod accessor;
mod buffers;
mod cameras;
mod degenerate;
mod document;
mod extensions;
mod gather;
mod materials;
mod nodes;
mod parts;
mod strip;

use std::path::Path;

use gltf::json::Root;

use self::buffers::Buffers;
use self::document::Document;
use self::gather::Gathered;
use self::nodes::Placed;
use self::parts::Part;
use self::strip::Facts;
use crate::error::SceneError;
use crate::scene::{ImportNotes, Mesh, Origin, Scene};

/// Most triangles of an imported scene, each mesh counted once for every node that holds it.
pub const MAX_TRIANGLES: u64 = 50_000_000;

/// Greatest magnitude of an imported coordinate in world space: the products of three lengths that tracers compute in
/// f32 (a triangle's determinant) leave its range not far beyond, those of two at 1e19.
pub const MAX_COORDINATE: f64 = 1e15;

/// Least diagonal of an imported scene: areas and the products of lengths that tracers compute in f32 vanish not far
/// below.
pub const MIN_DIAGONAL: f64 = 1e-15;

/// Imports a `.gltf` or `.glb` file; which of the two it is, its first bytes tell, not its name.
///
/// The scene is named after the stem of the file. See [`import_bytes`] for what is kept.
///
/// # Errors
///
/// [`SceneError::Read`] if the file cannot be read, else as [`import_bytes`].
pub fn import(path: &Path) -> Result<Scene, SceneError> {
    let bytes = std::fs::read(path).map_err(|source| SceneError::Read { path: path.to_owned(), source })?;
    let name = path
        .file_stem()
        .map_or_else(|| path.to_string_lossy().into_owned(), |stem| stem.to_string_lossy().into_owned());
    let label = path.display().to_string();
    let mut scene = import_labelled(&bytes, path.parent(), &name, &label)?;
    scene.origin = Origin::File { path: path.to_owned() };
    Ok(scene)
}

/// Imports the bytes of a `.gltf` or `.glb` file as the scene `name`; relative buffer files are looked for in
/// `base_dir`.
///
/// - The scene is the default one, else the first, else all nodes that are nobody's child.
/// - Triangles are lists, strips and fans, indexed by 8, 16 or 32 bits or not at all, with positions as f32 or as
///   8 or 16-bit integers; points and lines are counted and skipped. Corners beyond the last whole triangle of a list
///   are left out with a warning.
/// - Transforms are accumulated and applied in f64, and positions rounded to f32 once. A transform that mirrors
///   reverses the winding, so that the outside stays outside.
/// - Triangles of exactly zero area are dropped and counted, duplicates are kept and counted. Only vertices of kept
///   triangles are kept and looked at.
/// - Skins, morph targets and animations are ignored with a warning: meshes stand where their nodes put them.
/// - Of materials only base colour, metallic and roughness factors are kept. Images are never read.
/// - Perspective cameras are kept in the order of the nodes.
///
/// # Errors
///
/// [`SceneError::ReadBuffer`], [`SceneError::RequiredExtension`] and [`SceneError::Invalid`]: never an argument error.
pub fn import_bytes(bytes: &[u8], base_dir: Option<&Path>, name: &str) -> Result<Scene, SceneError> {
    import_labelled(bytes, base_dir, name, name)
}

/// As [`import_bytes`]; errors call the scene `label`.
fn import_labelled(bytes: &[u8], base_dir: Option<&Path>, name: &str, label: &str) -> Result<Scene, SceneError> {
    let invalid = |problem: String| SceneError::Invalid { scene: label.to_owned(), problem };
    let Document { root, blob, facts } = document::parse(bytes).map_err(invalid)?;
    extensions::check_required(label, &root.extensions_required)?;

    let mut notes = ImportNotes::default();
    warn_facts(&facts, &mut notes.warnings);
    extensions::warn_used(&root.extensions_used, &mut notes.warnings);
    let placed = nodes::place(&root, &mut notes.warnings).map_err(invalid)?;
    let mut buffers = Buffers::new(label, base_dir, blob.as_deref(), root.buffers.len());
    let used = used_meshes(&root, &placed);
    parts::load_buffers(&root, &used, &mut buffers)?;
    let mesh = assemble_mesh(&root, &buffers, &placed, &used, &mut notes).map_err(invalid)?;
    let cameras = cameras::collect(&root, &placed, &mut notes.warnings);
    let origin = Origin::File { path: name.into() };
    let scene = Scene::assemble(name.to_owned(), origin, mesh, cameras, notes);
    let diagonal = scene.diagonal();
    if diagonal < MIN_DIAGONAL {
        return Err(invalid(format!(
            "the scene's diagonal is {diagonal:e}, and below {MIN_DIAGONAL:e} the areas of its triangles vanish in f32: \
             scale the scene up"
        )));
    }
    Ok(scene)
}

fn warn_facts(facts: &Facts, warnings: &mut Vec<String>) {
    for (there, what) in
        [(facts.animations, "animations"), (facts.skins, "skins"), (facts.morph_targets, "morph targets")]
    {
        if there {
            warnings.push(format!("{what} are ignored: meshes stand as their nodes place them"));
        }
    }
}

fn used_meshes(root: &Root, placed: &[Placed]) -> Vec<bool> {
    let mut used = vec![false; root.meshes.len()];
    for mesh in placed.iter().filter_map(|place| mesh_of(root, place)) {
        if let Some(used) = used.get_mut(mesh) {
            *used = true;
        }
    }
    used
}

fn mesh_of(root: &Root, place: &Placed) -> Option<usize> {
    root.nodes.get(place.node)?.mesh.map(|mesh| mesh.value())
}

fn assemble_mesh(
    root: &Root,
    buffers: &Buffers<'_>,
    placed: &[Placed],
    used: &[bool],
    notes: &mut ImportNotes,
) -> Result<Mesh, String> {
    let mut parts: Vec<Vec<Part<'_>>> = Vec::with_capacity(used.len());
    let mut distinct = 0;
    for (mesh, &used) in used.iter().enumerate() {
        parts.push(if used { parts::open(root, buffers, mesh, &mut distinct, notes)? } else { Vec::new() });
    }
    let parts_of = |place: &Placed| -> &[Part<'_>] {
        mesh_of(root, place).and_then(|mesh| parts.get(mesh)).map_or(&[], Vec::as_slice)
    };

    // Counted before anything is allocated: a small file can place a large mesh a million times.
    let total = placed.iter().flat_map(parts_of).map(|part| part.triangles as u64).fold(0u64, u64::saturating_add);
    check_total(total)?;
    let mut materials = materials::collect(root, &mut notes.warnings);
    let without_material = placed.iter().flat_map(parts_of).any(|part| part.material.is_none());
    let default_material = materials.len() as u32;
    if without_material || materials.is_empty() {
        materials.push(materials::DEFAULT);
    }
    let mut gathered = Gathered::with_capacity(usize::try_from(total).unwrap_or(0));
    let mut objects: Vec<String> = Vec::new();
    for place in placed {
        for part in parts_of(place) {
            let material = part.material.unwrap_or(default_material);
            gathered.add(part, &place.world, material, objects.len() as u32)?;
        }
        if !parts_of(place).is_empty() {
            objects.push(root.nodes.get(place.node).and_then(|node| node.name.clone()).unwrap_or_default());
        }
    }
    notes.zero_area_triangles_dropped = gathered.zero_area;
    if gathered.triangles.is_empty() {
        return Err(no_triangles(root, placed, notes));
    }
    let Gathered { positions, triangles, triangle_materials, triangle_objects, .. } = gathered;
    notes.duplicate_triangles_kept = degenerate::count_duplicates(&positions, &triangles);
    Ok(Mesh { positions, triangles, triangle_materials, materials, triangle_objects, objects })
}

fn check_total(triangles: u64) -> Result<(), String> {
    if triangles > MAX_TRIANGLES {
        return Err(format!(
            "the scene has {triangles} triangles or more over all its nodes, and at most {MAX_TRIANGLES} are supported: reduce it"
        ));
    }
    Ok(())
}

fn no_triangles(root: &Root, placed: &[Placed], notes: &ImportNotes) -> String {
    let why = if notes.zero_area_triangles_dropped > 0 {
        format!("all {} of the file have exactly zero area", notes.zero_area_triangles_dropped)
    } else if notes.skipped_primitives > 0 {
        format!("the file has only points and lines ({} primitives)", notes.skipped_primitives)
    } else if !placed.iter().any(|place| mesh_of(root, place).is_some()) {
        "no node of its scene holds a mesh".to_owned()
    } else {
        "its meshes are empty".to_owned()
    };
    format!("there are no triangles: {why}; give a file with surfaces in it")
}
