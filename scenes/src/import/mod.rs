//! glTF 2.0 import: positions, indices, material factors and cameras, and no byte that is not checked first.
//!
//! The `gltf` crate splits, types and validates; its readers of buffers are not used, because they panic on data that
//! do not fit.

mod accessor;
mod buffers;
mod cameras;
mod degenerate;
mod document;
mod elements;
mod extensions;
mod form;
mod gather;
mod materials;
mod motion;
mod nodes;
mod parts;
mod rig;
mod sampler;
mod strip;

use std::path::Path;

use gltf::json::Root;

use self::accessor::{Accessors, buffers_of};
use self::buffers::{Buffers, Bytes};
use self::document::Document;
use self::gather::Gathered;
use self::motion::{Instance, Motion};
use self::nodes::Placed;
use self::parts::Part;
use self::rig::{Pose, Rig};
use self::strip::Facts;
use crate::error::SceneError;
use crate::scene::{ImportNotes, Mesh, Origin, Scene};

/// Most triangles of an imported scene, each mesh counted once for every node that holds it.
pub const MAX_TRIANGLES: u64 = 50_000_000;

/// Greatest magnitude of an imported coordinate in world space: beyond it, squared lengths come near the end of f32.
pub const MAX_COORDINATE: f64 = 1e15;

/// Most triangles, each counted once for every morph target and set of joints that its corners are computed from.
const MAX_DEFORMED: u64 = 500_000_000;

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
/// - Skins and morph targets move vertices, and the first animation plays: [`Scene::animation`]. The mesh is the state
///   at time 0, and the triangles that are dropped are those that have zero area then.
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
    let used = used_meshes(&root, &placed);
    let mut buffers = Buffers::new(label, base_dir, blob.as_deref(), root.buffers.len());
    for accessor in used_accessors(&root, &placed, &used) {
        for buffer in buffers_of(&root, accessor) {
            buffers.load(&root, buffer)?;
        }
    }
    let bytes = buffers.finish();
    let geometry = Geometry::open(&root, &bytes, placed, &used, &mut notes).map_err(invalid)?;
    let pose = geometry.rig.pose(&bytes, 0.0);
    let duration_s = geometry.duration_s(&root, &bytes, &mut notes.warnings);
    let (mesh, instances, sources) =
        geometry.assemble(&root, &bytes, &pose, duration_s.is_some(), &mut notes).map_err(invalid)?;
    let cameras = cameras::collect(&root, &geometry.rig.placed, &pose.worlds, &mut notes.warnings);
    let origin = Origin::File { path: name.into() };
    let Geometry { rig, parts } = geometry;
    let mut scene = Scene::assemble(name.to_owned(), origin, mesh, cameras, notes);
    scene.animation = duration_s.map(|duration_s| {
        Motion { label: label.to_owned(), bytes: bytes.into_owned(), rig, parts, instances, sources }
            .animation(duration_s)
    });
    Ok(scene)
}

fn warn_facts(facts: &Facts, warnings: &mut Vec<String>) {
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

/// Whether nodes of the scene hold a mesh, and whether one of them has a skin.
#[derive(Clone, Copy, Default)]
struct MeshUse {
    used: bool,
    skinned: bool,
}

fn used_meshes(root: &Root, placed: &[Placed]) -> Vec<MeshUse> {
    let mut uses = vec![MeshUse::default(); root.meshes.len()];
    for node in placed.iter().filter_map(|place| root.nodes.get(place.node)) {
        if let Some(mesh) = node.mesh.and_then(|mesh| uses.get_mut(mesh.value())) {
            mesh.used = true;
            mesh.skinned |= node.skin.is_some();
        }
    }
    uses
}

/// Accessors that are read: of meshes, skins and the animation.
fn used_accessors(root: &Root, placed: &[Placed], used: &[MeshUse]) -> Vec<usize> {
    let mut accessors = Vec::new();
    for (mesh, mesh_use) in root.meshes.iter().zip(used).filter(|(_, mesh_use)| mesh_use.used) {
        for primitive in &mesh.primitives {
            accessors.extend(parts::accessors_of(primitive, mesh_use.skinned));
        }
    }
    for skin in rig::used_skins(root, placed).into_iter().filter_map(|skin| root.skins.get(skin)) {
        accessors.extend(skin.inverse_bind_matrices.map(|matrices| matrices.value()));
    }
    for sampler in root.animations.iter().flat_map(|animation| &animation.samplers) {
        accessors.extend([sampler.input.value(), sampler.output.value()]);
    }
    accessors
}

fn mesh_of(root: &Root, place: &Placed) -> Option<usize> {
    root.nodes.get(place.node)?.mesh.map(|mesh| mesh.value())
}

/// Nodes with what moves them, and primitives: all that is needed beside the bytes.
struct Geometry {
    rig: Rig,
    /// By mesh of the document; empty where no node of the scene holds it.
    parts: Vec<Vec<Part>>,
}

impl Geometry {
    fn open(
        root: &Root,
        bytes: &Bytes<'_>,
        placed: Vec<Placed>,
        used: &[MeshUse],
        notes: &mut ImportNotes,
    ) -> Result<Self, String> {
        let accessors = Accessors::new(root, bytes);
        let mut parts = Vec::with_capacity(used.len());
        let mut distinct = 0;
        for (mesh, mesh_use) in used.iter().enumerate() {
            parts.push(if mesh_use.used {
                parts::open(&accessors, mesh, mesh_use.skinned, &mut distinct, notes)?
            } else {
                Vec::new()
            });
        }
        let rig = Rig::open(&accessors, placed, notes)?;
        Ok(Self { rig, parts })
    }

    fn parts_of(&self, root: &Root, place: &Placed) -> &[Part] {
        mesh_of(root, place).and_then(|mesh| self.parts.get(mesh)).map_or(&[], Vec::as_slice)
    }

    /// Length of the animation; none if there is none that moves a triangle.
    fn duration_s(&self, root: &Root, bytes: &Bytes<'_>, warnings: &mut Vec<String>) -> Option<f64> {
        root.animations.first()?;
        let mut moving = self.rig.moving(root).into_iter().zip(&self.rig.placed);
        if !moving.any(|(moves, place)| moves && !self.parts_of(root, place).is_empty()) {
            warnings.push("the animation moves no triangles: the scene stands still".to_owned());
            return None;
        }
        let duration_s = self.rig.duration_s(bytes);
        if duration_s > 0.0 {
            return Some(duration_s);
        }
        warnings.push("the animation has no length: the scene stands still in its pose".to_owned());
        None
    }

    /// The mesh in a pose, the instances with the ends of their vertices, and, if wanted, where each vertex is from.
    #[allow(clippy::type_complexity)]
    fn assemble(
        &self,
        root: &Root,
        bytes: &Bytes<'_>,
        pose: &Pose,
        keep_sources: bool,
        notes: &mut ImportNotes,
    ) -> Result<(Mesh, Vec<(Instance, usize)>, Vec<u32>), String> {
        let all = || self.rig.placed.iter().flat_map(|place| self.parts_of(root, place));
        // Counted before anything is allocated: a small file can place a large mesh a million times.
        let total = all().map(|part| part.triangles as u64).fold(0u64, u64::saturating_add);
        check_total(total)?;
        check_deformed(all())?;
        let mut materials = materials::collect(root, &mut notes.warnings);
        let default_material = materials.len() as u32;
        if all().any(|part| part.material.is_none()) || materials.is_empty() {
            materials.push(materials::DEFAULT);
        }
        let mut gathered = Gathered::new(usize::try_from(total).unwrap_or(0), keep_sources);
        let mut objects: Vec<String> = Vec::new();
        let mut instances = Vec::new();
        for (place, placed) in self.rig.placed.iter().enumerate() {
            let Some(node) = root.nodes.get(placed.node) else {
                continue;
            };
            for (slot, part) in self.parts_of(root, placed).iter().enumerate() {
                let mesh = node.mesh.map_or(0, |mesh| mesh.value());
                let instance = Instance { place, part: (mesh, slot), skin: node.skin.map(|skin| skin.value()) };
                let material = part.material.unwrap_or(default_material);
                let form = instance.form(part, bytes, pose)?;
                gathered.add(part, bytes, &form, material, objects.len() as u32)?;
                instances.push((instance, gathered.positions.len()));
            }
            if !self.parts_of(root, placed).is_empty() {
                objects.push(node.name.clone().unwrap_or_default());
            }
        }
        notes.zero_area_triangles_dropped = gathered.zero_area;
        if gathered.weightless > 0 {
            notes.warnings.push(format!(
                "vertices whose joints have no weight follow the first of them ({})",
                gathered.weightless
            ));
        }
        if gathered.triangles.is_empty() {
            return Err(no_triangles(root, &self.rig.placed, notes));
        }
        let Gathered { positions, triangles, triangle_materials, triangle_objects, sources, .. } = gathered;
        notes.duplicate_triangles_kept = degenerate::count_duplicates(&positions, &triangles);
        let mesh = Mesh { positions, triangles, triangle_materials, materials, triangle_objects, objects };
        Ok((mesh, instances, sources.unwrap_or_default()))
    }
}

fn check_deformed<'a>(parts: impl Iterator<Item = &'a Part>) -> Result<(), String> {
    let deformed = parts
        .map(|part| (part.triangles as u64).saturating_mul(part.deformers() as u64))
        .fold(0u64, u64::saturating_add);
    if deformed > MAX_DEFORMED {
        return Err(format!(
            "triangles times morph targets and sets of joints are {deformed}, and at most {MAX_DEFORMED} are supported: reduce them"
        ));
    }
    Ok(())
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
