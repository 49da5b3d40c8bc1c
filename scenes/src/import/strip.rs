//! Takes out of the JSON what rays do not need, before it is typed.

use gltf::json::Value;

/// What was stripped and may change what the user sees.
#[derive(Debug, Default)]
pub(super) struct Facts {
    /// Names of the animations after the first, which is the one that is played.
    pub(super) other_animations: Vec<String>,
    /// Channels of the first animation that move no property of a node.
    pub(super) foreign_channels: usize,
}

/// Keys whose numbers are indices or enumerations of 32 bits. The typed form would cut off higher bits in silence.
const NARROW: &[&str] = &[
    "POSITION",
    "buffer",
    "bufferView",
    "camera",
    "children",
    "componentType",
    "indices",
    "input",
    "inverseBindMatrices",
    "joints",
    "material",
    "mesh",
    "mode",
    "node",
    "nodes",
    "output",
    "sampler",
    "scene",
    "skin",
];

/// Strips `document` in place.
pub(super) fn strip(document: &mut Value) -> Result<Facts, String> {
    keep(
        document,
        &[
            "accessors",
            "animations",
            "asset",
            "bufferViews",
            "buffers",
            "cameras",
            "extensionsRequired",
            "extensionsUsed",
            "materials",
            "meshes",
            "nodes",
            "scene",
            "scenes",
            "skins",
        ],
    );
    let facts = strip_animations(document);
    if let Some(asset) = document.get_mut("asset") {
        keep(asset, &["version"]);
    }
    let skinned = strip_nodes(document);
    if skinned {
        items(document, "skins").for_each(|skin| keep(skin, &["inverseBindMatrices", "joints", "name"]));
    } else {
        remove(document, "skins");
    }
    for scene in items(document, "scenes") {
        keep(scene, &["name", "nodes"]);
        if let Some(scene) = scene.as_object_mut() {
            scene.entry("nodes").or_insert_with(|| Value::Array(Vec::new()));
        }
    }
    for camera in items(document, "cameras") {
        keep(camera, &["name", "orthographic", "perspective", "type"]);
        for kind in ["orthographic", "perspective"] {
            if let Some(projection) = camera.get_mut(kind) {
                keep(projection, &["aspectRatio", "xmag", "yfov", "ymag", "zfar", "znear"]);
            }
        }
    }
    strip_meshes(document, skinned)?;
    for material in items(document, "materials") {
        strip_material(material);
    }
    strip_data(document);
    check_narrow(document, "document")?;
    Ok(facts)
}

/// Keeps the first animation, and of that the channels that move a property of a node.
fn strip_animations(document: &mut Value) -> Facts {
    let mut facts = Facts::default();
    let Some(animations) = document.get_mut("animations").and_then(Value::as_array_mut) else {
        return facts;
    };
    facts.other_animations = animations
        .iter()
        .skip(1)
        .map(|animation| animation.get("name").and_then(Value::as_str).unwrap_or("unnamed").to_owned())
        .collect();
    animations.truncate(1);
    for animation in animations {
        keep(animation, &["channels", "name", "samplers"]);
        items(animation, "samplers").for_each(|sampler| keep(sampler, &["input", "interpolation", "output"]));
        if let Some(channels) = animation.get_mut("channels").and_then(Value::as_array_mut) {
            let all = channels.len();
            channels.retain(moves_a_node);
            facts.foreign_channels += all - channels.len();
        }
        for channel in items(animation, "channels") {
            keep(channel, &["sampler", "target"]);
            if let Some(target) = channel.get_mut("target") {
                keep(target, &["node", "path"]);
            }
        }
    }
    facts
}

/// Whether the target is a property of a node. One that is no object is left for the schema to refuse.
fn moves_a_node(channel: &Value) -> bool {
    channel.get("target").and_then(Value::as_object).is_none_or(|target| {
        let path = target.get("path").and_then(Value::as_str);
        target.contains_key("node") && matches!(path, Some("translation" | "rotation" | "scale" | "weights"))
    })
}

/// Returns whether a mesh is skinned.
fn strip_nodes(document: &mut Value) -> bool {
    let mut skinned = false;
    for node in items(document, "nodes") {
        keep(
            node,
            &["camera", "children", "matrix", "mesh", "name", "rotation", "scale", "skin", "translation", "weights"],
        );
        if node.get("mesh").is_some() {
            skinned |= node.get("skin").is_some();
        } else {
            remove(node, "skin");
            remove(node, "weights");
        }
    }
    skinned
}

/// Joints and weights of vertices are kept where there are skins.
fn strip_meshes(document: &mut Value, skinned: bool) -> Result<(), String> {
    // Accessors whose data are in no buffer view.
    let hollow: Vec<bool> = items(document, "accessors")
        .map(|accessor| accessor.get("bufferView").is_none() && accessor.get("sparse").is_none())
        .collect();
    for (mesh_index, mesh) in items(document, "meshes").enumerate() {
        keep(mesh, &["name", "primitives", "weights"]);
        for (primitive_index, primitive) in items(mesh, "primitives").enumerate() {
            let compressed = primitive
                .get("extensions")
                .is_some_and(|extensions| extensions.get("KHR_draco_mesh_compression").is_some());
            keep(primitive, &["attributes", "indices", "material", "mode", "targets"]);
            items(primitive, "targets").for_each(|target| keep(target, &["POSITION"]));
            let Some(attributes) = primitive.get_mut("attributes") else {
                continue;
            };
            if let Some(attributes) = attributes.as_object_mut() {
                attributes.retain(|key, _| key == "POSITION" || (skinned && is_influence(key)));
            }
            let position = attributes.get("POSITION").and_then(Value::as_u64);
            let is_hollow = position
                .and_then(|index| usize::try_from(index).ok())
                .and_then(|index| hollow.get(index))
                .copied()
                .unwrap_or(false);
            if compressed && is_hollow {
                return Err(format!(
                    "meshes[{mesh_index}].primitives[{primitive_index}] has its triangles only in KHR_draco_mesh_compression, which is not supported: export the scene again without Draco compression"
                ));
            }
        }
    }
    Ok(())
}

/// Keeps the factors. Where there is only the older specular-glossiness form, its diffuse colour and glossiness stand in.
fn strip_material(material: &mut Value) {
    let older = material
        .get_mut("extensions")
        .and_then(|extensions| extensions.get_mut("KHR_materials_pbrSpecularGlossiness"))
        .map(Value::take);
    keep(material, &["alphaMode", "name", "pbrMetallicRoughness"]);
    let Some(object) = material.as_object_mut() else {
        return;
    };
    if let (Some(older), false) = (older, object.contains_key("pbrMetallicRoughness")) {
        let glossiness = older.get("glossinessFactor").and_then(Value::as_f64);
        let mut factors = gltf::json::serialize::to_value(std::collections::BTreeMap::from([
            ("metallicFactor", 0.0),
            ("roughnessFactor", 1.0 - glossiness.unwrap_or(1.0)),
        ]))
        .unwrap_or_default();
        if let (Some(factors), Some(diffuse)) = (factors.as_object_mut(), older.get("diffuseFactor")) {
            factors.insert("baseColorFactor".to_owned(), diffuse.clone());
        }
        object.insert("pbrMetallicRoughness".to_owned(), factors);
    }
    if let Some(factors) = material.get_mut("pbrMetallicRoughness") {
        keep(factors, &["baseColorFactor", "metallicFactor", "roughnessFactor"]);
    }
}

fn strip_data(document: &mut Value) {
    for accessor in items(document, "accessors") {
        keep(accessor, &["bufferView", "byteOffset", "componentType", "count", "name", "normalized", "sparse", "type"]);
        if let Some(sparse) = accessor.get_mut("sparse") {
            keep(sparse, &["count", "indices", "values"]);
            for part in ["indices", "values"] {
                if let Some(part) = sparse.get_mut(part) {
                    keep(part, &["bufferView", "byteOffset", "componentType"]);
                }
            }
        }
    }
    for view in items(document, "bufferViews") {
        keep(view, &["buffer", "byteLength", "byteOffset", "byteStride", "name"]);
    }
    for buffer in items(document, "buffers") {
        keep(buffer, &["byteLength", "name", "uri"]);
    }
}

/// The elements of the array at `key`; none if there is no array.
fn items<'a>(value: &'a mut Value, key: &str) -> impl Iterator<Item = &'a mut Value> + use<'a> {
    value.get_mut(key).and_then(Value::as_array_mut).into_iter().flatten()
}

/// Whether an attribute has joints or their weights.
fn is_influence(key: &str) -> bool {
    ["JOINTS_", "WEIGHTS_"].iter().any(|family| {
        let set = key.strip_prefix(family);
        set.is_some_and(|set| !set.is_empty() && set.len() < 9 && set.bytes().all(|byte| byte.is_ascii_digit()))
    })
}

fn remove(value: &mut Value, key: &str) {
    if let Some(object) = value.as_object_mut() {
        object.remove(key);
    }
}

/// Keeps only `keys` of an object. A name that is no string is dropped, since nothing depends on it.
fn keep(value: &mut Value, keys: &[&str]) {
    if let Some(object) = value.as_object_mut() {
        object.retain(|key, value| keys.contains(&key.as_str()) && (key != "name" || value.is_string()));
    }
}

/// Refuses numbers beyond 32 bits where the typed form keeps only 32. The JSON parser bounds the depth.
fn check_narrow(value: &Value, key: &str) -> Result<(), String> {
    match value {
        Value::Number(number) if NARROW.contains(&key) || is_influence(key) => match number.as_u64() {
            Some(wide) if wide > u64::from(u32::MAX) => {
                Err(format!("{key} is {wide}, which is out of range; export the file again"))
            }
            _ => Ok(()),
        },
        Value::Array(values) => values.iter().try_for_each(|value| check_narrow(value, key)),
        Value::Object(object) => object.iter().try_for_each(|(key, value)| check_narrow(value, key)),
        _ => Ok(()),
    }
}
