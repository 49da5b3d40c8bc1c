//! A scene as a `.glb` file that every importer of glTF 2.0 reads, and that this one reads back as the same arrays.

use serde_json::{Value, json};
use tracebench_scenes::{Material, Mesh, SHARED_VERTICES, Scene, SceneError, content_sha256, import_bytes};

use super::{ExchangeError, npy};
use crate::files::OutputFolder;

/// The scene beside sets of rays.
pub const SCENE_FILE: &str = "scene.glb";

/// A component of 32 bits in glTF: f32, u32.
const FLOAT: u32 = 5126;
const UNSIGNED: u32 = 5125;

/// The bytes of a `.glb` with a mesh as it stands, and the scene that is read from them: of the mesh's hash, which does not depend on names.
///
/// # Errors
/// [`ExchangeError::Scene`] if the mesh is none that can be read back, or is larger than the format allows.
pub fn glb(mesh: &Mesh, name: &str) -> Result<(Vec<u8>, Scene), ExchangeError> {
    let invalid = |problem: &str| SceneError::Invalid { scene: name.to_owned(), problem: problem.to_owned() };
    let mut bytes: Vec<u8> = bytemuck::cast_slice::<[f32; 3], u8>(&mesh.positions).to_vec();
    let of_positions = bytes.len();
    bytes.extend_from_slice(bytemuck::cast_slice::<[u32; 3], u8>(&mesh.triangles));
    let bound = |of: fn(f32, f32) -> f32| {
        let both = |one: [f32; 3], other: [f32; 3]| [0, 1, 2].map(|axis| of(one[axis], other[axis]));
        mesh.positions.iter().copied().reduce(both).map(|bound| bound.map(f64::from))
    };
    let mut accessors =
        vec![json!({ "bufferView": 0, "componentType": FLOAT, "count": mesh.positions.len(), "type": "VEC3",
                                     "min": bound(f32::min), "max": bound(f32::max) })];
    let mut primitives: Vec<Value> = Vec::new();
    let mut begin = 0;
    // The order of the triangles is kept, so each run of one material is a primitive.
    for run in mesh.triangle_materials.chunk_by(|one, other| one == other) {
        primitives.push(json!({ "attributes": { "POSITION": 0 }, "indices": accessors.len(), "material": run[0] }));
        accessors.push(
            json!({ "bufferView": 1, "byteOffset": 12 * begin, "componentType": UNSIGNED, "count": 3 * run.len(),
                               "type": "SCALAR" }),
        );
        begin += run.len();
    }
    let material = |Material { base_color: [red, green, blue], metallic, roughness, refractive_index }: &Material| {
        let [red, green, blue, metallic, roughness] =
            [red, green, blue, metallic, roughness].map(|part| f64::from(*part));
        let factors = json!({ "baseColorFactor": [red, green, blue, 1.0], "metallicFactor": metallic, "roughnessFactor": roughness });
        let mut material = json!({ "pbrMetallicRoughness": factors, "doubleSided": true });
        if let Some(index) = refractive_index {
            material["extensions"] = json!({ "KHR_materials_transmission": { "transmissionFactor": 1.0 }, "KHR_materials_ior": { "ior": f64::from(*index) } });
        }
        material
    };
    let document = json!({
        "asset": { "version": "2.0", "generator": "tracebench" },
        "extensionsUsed": [SHARED_VERTICES, "KHR_materials_transmission", "KHR_materials_ior"],
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "mesh": 0, "name": name }],
        "meshes": [{ "primitives": primitives }],
        "materials": mesh.materials.iter().map(material).collect::<Vec<_>>(),
        "accessors": accessors,
        "bufferViews": [
            { "buffer": 0, "byteLength": of_positions, "target": 34962 },
            { "buffer": 0, "byteOffset": of_positions, "byteLength": bytes.len() - of_positions, "target": 34963 },
        ],
        "buffers": [{ "byteLength": bytes.len() }],
    });
    let mut text = document.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let whole = u32::try_from(12 + 8 + text.len() + 8 + bytes.len())
        .map_err(|_| invalid("is larger than the 4 GiB that a .glb may have: take a smaller one"))?;
    let mut file = [&b"glTF"[..], &2_u32.to_le_bytes(), &whole.to_le_bytes()].concat();
    for (kind, chunk) in [(b"JSON", text), (b"BIN\0", bytes)] {
        // Each below the whole.
        file.extend_from_slice(&(chunk.len() as u32).to_le_bytes());
        file.extend_from_slice(kind);
        file.extend_from_slice(&chunk);
    }
    let scene = import_bytes(&file, None, name)?;
    if scene.sha256 == content_sha256(mesh) {
        Ok((file, scene))
    } else {
        Err(invalid("has triangles without area: leave them out").into())
    }
}

/// Writes a scene's `scene.glb`, `positions.npy` and `triangles.npy`, and gives the scene that is read from the first.
///
/// # Errors
/// As [`glb`], and if a file cannot be written.
pub fn write_scene(folder: &OutputFolder, mesh: &Mesh, name: &str) -> Result<Scene, ExchangeError> {
    let (bytes, scene) = glb(mesh, name)?;
    folder.write(SCENE_FILE, &bytes)?;
    folder.write("positions.npy", &npy::write(Some(3), mesh.positions.as_flattened()))?;
    folder.write("triangles.npy", &npy::write(Some(3), mesh.triangles.as_flattened()))?;
    Ok(scene)
}
