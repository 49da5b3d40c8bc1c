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
mod far;
mod form;
mod gather;
mod geometry;
mod materials;
mod motion;
mod nodes;
mod parts;
mod rig;
mod rules;
mod sampler;
mod strip;

use std::path::Path;

use self::accessor::{Accessors, buffers_of};
use self::buffers::{Buffers, Bytes};
use self::document::Document;
use self::geometry::Geometry;
use self::motion::Motion;
use self::strip::StrippedParts;
use crate::error::SceneError;
use crate::scene::{ImportNotes, Origin, Scene};

pub(crate) use self::degenerate::has_zero_area;
pub use self::far::is_far;

/// The extension of files that keep a scene's arrays: all primitives have the vertices of one accessor, each is in a triangle, and they are
/// kept in their order and as they are stored, whatever the nodes' transforms. Files that move are read without it.
pub const SHARED_VERTICES: &str = "TRACEBENCH_shared_vertices";

/// Most triangles of an imported scene, each mesh counted once for every node that holds it.
const MAX_TRIANGLES: u64 = 50_000_000;

/// Greatest magnitude of an imported coordinate in world space. Tracers compute products of two lengths in f32, which leave its
/// range at 1e19, and of three only where one of them was brought to about 1: a test traces scenes up to here.
pub const MAX_COORDINATE: f64 = 1e15;

/// Least diagonal of an imported scene. Products of two lengths vanish in f32 at 1e-19: areas of a scene's fine triangles do not far
/// below.
pub const MIN_DIAGONAL: f64 = 1e-15;

/// Names of files, in whatever case, that exporters and archives give and that say nothing of what is in them.
const SAY_NOTHING: [&str; 8] = ["index", "main", "mesh", "model", "object", "scene", "source", "untitled"];

/// Imports a `.gltf` or `.glb` file; which of the two it is, its first bytes tell, not its name.
///
/// The scene is named after the stem of the file, or after its folder where the stem says nothing, like `scene`. See
/// [`import_bytes`] for what is kept.
///
/// # Errors
///
/// [`SceneError::Read`] if the file cannot be read, else as [`import_bytes`].
pub fn import(path: &Path) -> Result<Scene, SceneError> {
    let fail = |source| SceneError::Read { path: path.to_owned(), source };
    // A device or a pipe may never end.
    if !std::fs::metadata(path).map_err(fail)?.is_file() {
        return Err(fail(std::io::Error::new(std::io::ErrorKind::InvalidInput, "it is no regular file")));
    }
    let bytes = std::fs::read(path).map_err(fail)?;
    let mut scene = import_labelled(bytes, path.parent(), &name_of(path), &path.display().to_string())?;
    scene.origin = Origin::File { path: path.to_owned() };
    Ok(scene)
}

/// What the scene of a file is called.
pub fn name_of(path: &Path) -> String {
    let Some(stem) = path.file_stem() else { return path.to_string_lossy().into_owned() };
    let says_nothing = SAY_NOTHING.iter().any(|name| stem.eq_ignore_ascii_case(name));
    let folder = path.parent().and_then(Path::file_name).filter(|_| says_nothing);
    folder.unwrap_or(stem).to_string_lossy().into_owned()
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
///   triangles are kept and looked at. Of a scene that moves all are kept until the times are known at which it is traced:
///   [`Scene::drop_zero_area`].
/// - A scene so far from the origin that f32 has few places for its vertices is told of by a warning.
/// - Skins and morph targets move vertices, and the first animation plays: [`Scene::animation`]. The mesh is the state
///   at time 0.
/// - Of materials only base colour, metallic and roughness factors are kept. Images are never read.
/// - Perspective cameras are kept in the order of the nodes, as they stand at time 0; the first that moves gives
///   [`Scene::camera_path`].
///
/// # Errors
///
/// [`SceneError::Invalid`].
pub fn import_bytes(bytes: &[u8], base_dir: Option<&Path>, name: &str) -> Result<Scene, SceneError> {
    import_labelled(bytes.to_vec(), base_dir, name, name)
}

/// As [`import_bytes`]; errors call the scene `label`.
fn import_labelled(bytes: Vec<u8>, base_dir: Option<&Path>, name: &str, label: &str) -> Result<Scene, SceneError> {
    import_or_say(bytes.into(), base_dir, name, label)
        .map_err(|problem| SceneError::Invalid { scene: label.to_owned(), problem })
}

/// As [`import_labelled`]; an error says what is wrong.
fn import_or_say(file: Bytes, base_dir: Option<&Path>, name: &str, label: &str) -> Result<Scene, String> {
    let Document { root, blob, facts } = document::parse(&file)?;
    extensions::check_required(&root.extensions_required)?;

    let mut notes = ImportNotes::default();
    warn_facts(&facts, &mut notes.warnings);
    extensions::warn_used(&root.extensions_used, &mut notes.warnings);
    let placed = nodes::place(&root, &mut notes.warnings)?;
    let used = geometry::used_meshes(&root, &placed);
    let mut buffers = Buffers::new(base_dir, file, blob, root.buffers.len());
    for accessor in geometry::used_accessors(&root, &placed, &used) {
        for buffer in buffers_of(&root, accessor) {
            buffers.load(&root, buffer)?;
        }
    }
    let accessors = Accessors::new(&root, buffers.finish());
    let geometry = Geometry::open(&accessors, placed, &used, &mut notes)?;
    let pose = geometry.rig.pose(0.0);
    let duration_s = geometry.duration_s(&root, &mut notes.warnings);
    let (mesh, instances, sources) = geometry.assemble(&root, &pose, duration_s.is_some(), &mut notes)?;
    let cameras = cameras::collect(&root, &geometry.rig.placed, &pose.worlds, &mut notes.warnings);
    let camera_path = cameras::path(&root, &geometry.rig, &mut notes.warnings);
    let origin = Origin::File { path: name.into() };
    let mut scene = Scene::assemble(name.to_owned(), origin, mesh, cameras, notes);
    scene.camera_path = camera_path;
    // One that moves is looked at where it is asked for.
    let size = scene.check_size();
    if duration_s.is_none() {
        size.clone()?;
    }
    let greatest = scene.bounds_min.iter().chain(&scene.bounds_max).fold(0.0, |most: f32, at| most.max(at.abs()));
    scene.notes.warnings.extend(far::warning(scene.diagonal(), f64::from(greatest)).filter(|_| size.is_ok()));
    scene.animation = duration_s
        .map(|duration_s| Motion { label: label.to_owned(), geometry, instances, sources }.animation(duration_s));
    Ok(scene)
}

fn warn_facts(facts: &StrippedParts, warnings: &mut Vec<String>) {
    if facts.zero_strides > 0 {
        warnings.push(format!(
            "buffer views with a byteStride of 0 are read as if it were not given ({})",
            facts.zero_strides
        ));
    }
    if !facts.other_animations.is_empty() {
        let shown: Vec<String> = facts.other_animations.iter().take(5).map(|name| format!("'{name}'")).collect();
        let more = if facts.other_animations.len() > shown.len() { " and others" } else { "" };
        warnings.push(format!(
            "the first animation plays; the others are ignored ({}): {}{more}",
            facts.other_animations.len(),
            shown.join(", ")
        ));
    }
    if facts.foreign_channels > 0 {
        warnings.push(format!(
            "channels of the animation that move something else than a node's translation, rotation, scale or weights are ignored ({}); KHR_animation_pointer is one source of them",
            facts.foreign_channels
        ));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Without a folder that has a name a scene keeps the file's, whatever that says.
    #[test]
    fn only_folders_with_names_give_theirs() {
        for path in ["scene.gltf", "./scene.gltf", "../scene.gltf", "/scene.gltf"] {
            assert_eq!(name_of(Path::new(path)), "scene", "{path}");
        }
        assert_eq!(name_of(Path::new("drone/scene.gltf")), "drone");
    }
}
