//! From a document and its bytes to the mesh: what is used, how much of it there is, and where it stands.

use gltf::json::Root;

use super::MAX_TRIANGLES;
use super::accessor::Accessors;
use super::gather::Gathered;
use super::motion::Instance;
use super::nodes::Placed;
use super::parts::{self, Part};
use super::rig::{self, Pose, Rig};
use super::{degenerate, materials};
use crate::scene::{ImportNotes, Mesh};

/// Most triangles, each counted once for every morph target and set of joints that its corners are computed from.
const MAX_DEFORMED: u64 = 500_000_000;

/// For each mesh whether a node that holds it has a skin; none if no node of the scene holds it.
pub(super) fn used_meshes(root: &Root, placed: &[Placed]) -> Vec<Option<bool>> {
    let mut uses = vec![None; root.meshes.len()];
    for node in placed.iter().filter_map(|place| root.nodes.get(place.node)) {
        if let Some(skinned) = node.mesh.and_then(|mesh| uses.get_mut(mesh.value())) {
            *skinned = Some(skinned.unwrap_or(false) || node.skin.is_some());
        }
    }
    uses
}

/// Accessors that are read: of meshes, skins and the animation.
pub(super) fn used_accessors(root: &Root, placed: &[Placed], used: &[Option<bool>]) -> Vec<usize> {
    let mut accessors = Vec::new();
    for (mesh, skinned) in root.meshes.iter().zip(used).filter_map(|(mesh, skinned)| Some((mesh, (*skinned)?))) {
        for primitive in &mesh.primitives {
            accessors.extend(parts::accessors_of(primitive, skinned));
        }
    }
    for skin in rig::used_skins(root, placed).into_iter().filter_map(|skin| root.skins.get(skin)) {
        accessors.extend(skin.inverse_bind_matrices.map(|matrices| matrices.value()));
    }
    for animation in &root.animations {
        let samplers = animation.channels.iter().filter_map(|channel| animation.samplers.get(channel.sampler.value()));
        accessors.extend(samplers.flat_map(|sampler| [sampler.input.value(), sampler.output.value()]));
    }
    accessors
}

fn mesh_of(root: &Root, place: &Placed) -> Option<usize> {
    root.nodes.get(place.node)?.mesh.map(|mesh| mesh.value())
}

/// Nodes with what moves them, and primitives.
pub(super) struct Geometry {
    pub(super) rig: Rig,
    /// By mesh of the document; empty where no node of the scene holds it.
    pub(super) parts: Vec<Vec<Part>>,
}

impl Geometry {
    pub(super) fn open(
        accessors: &Accessors<'_>,
        placed: Vec<Placed>,
        used: &[Option<bool>],
        notes: &mut ImportNotes,
    ) -> Result<Self, String> {
        let mut parts = Vec::with_capacity(used.len());
        let mut distinct = 0;
        for (mesh, skinned) in used.iter().enumerate() {
            parts.push(match *skinned {
                Some(skinned) => parts::open(accessors, mesh, skinned, &mut distinct, notes)?,
                None => Vec::new(),
            });
        }
        let rig = Rig::open(accessors, placed, notes)?;
        Ok(Self { rig, parts })
    }

    fn parts_of(&self, root: &Root, place: &Placed) -> &[Part] {
        mesh_of(root, place).and_then(|mesh| self.parts.get(mesh)).map_or(&[], Vec::as_slice)
    }

    /// Length of the animation; none if there is none that moves a triangle.
    pub(super) fn duration_s(&self, root: &Root, warnings: &mut Vec<String>) -> Option<f64> {
        root.animations.first()?;
        let mut moving = self.rig.moving(root).into_iter().zip(&self.rig.placed);
        if !moving.any(|(moves, place)| moves && !self.parts_of(root, place).is_empty()) {
            warnings.push("the animation moves no triangles: the scene stands still".to_owned());
            return None;
        }
        let duration_s = self.rig.duration_s();
        if duration_s > 0.0 {
            return Some(duration_s);
        }
        warnings.push("the animation has no length: the scene stands still in its pose".to_owned());
        None
    }

    /// The mesh in a pose, the instances with the ends of their vertices, and, if wanted, where each vertex is from.
    #[allow(clippy::type_complexity)]
    pub(super) fn assemble(
        &self,
        root: &Root,
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
        let shared = root.extensions_used.iter().any(|name| name == super::SHARED_VERTICES);
        let mut gathered = Gathered::new(usize::try_from(total).unwrap_or(0), keep_sources, shared);
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
                let form = instance.form(part, pose)?;
                gathered.add(part, &form, material, objects.len() as u32)?;
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
        let mut unused = vec![shared && !keep_sources; gathered.positions.len()];
        gathered.triangles.iter().flatten().for_each(|corner| unused[*corner as usize] = false);
        if unused.contains(&true) {
            return Err(format!(
                "with {} every vertex is in a triangle with an area; leave the others out",
                super::SHARED_VERTICES
            ));
        }
        let Gathered { positions, triangles, triangle_materials, triangle_objects, sources, .. } = gathered;
        let points = |triangle: &[u32; 3]| triangle.map(|corner| positions[corner as usize]);
        let solid: Vec<[u32; 3]> =
            triangles.iter().copied().filter(|triangle| !degenerate::has_zero_area(&points(triangle))).collect();
        notes.duplicate_triangles_kept = degenerate::count_duplicates(&positions, &solid);
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

pub(super) fn check_total(triangles: u64) -> Result<(), String> {
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
        "its meshes are empty, or have no POSITION".to_owned()
    };
    format!("there are no triangles: {why}; give a file with surfaces in it")
}
