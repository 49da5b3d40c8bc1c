//! Takes out of the JSON what rays do not need, before it is typed.

use std::collections::HashSet;

use gltf::json::Value;

use super::rules::{self, Rule};

/// What was stripped and may change what the user sees.
#[derive(Debug, Default)]
pub(super) struct StrippedParts {
    /// Names of the animations after the first, which is the one that is played.
    pub(super) other_animations: Vec<String>,
    /// Channels of the first animation that move no property of a node.
    pub(super) foreign_channels: usize,
    /// Buffer views with a stride of zero, which old exporters write where they mean none.
    pub(super) zero_strides: usize,
}

/// Lists of the document whose elements name each other, each with what stands for an element that nothing names: it is in nobody's way.
const LISTS: &[(&str, &str)] = &[
    ("accessors", r#"{"componentType": 5126, "count": 1, "type": "SCALAR"}"#),
    ("bufferViews", r#"{"buffer": 0, "byteLength": 1}"#),
    ("buffers", r#"{"byteLength": 1}"#),
    ("cameras", ORTHOGRAPHIC),
    ("materials", "{}"),
    ("meshes", r#"{"primitives": []}"#),
    ("nodes", "{}"),
    ("scenes", r#"{"nodes": []}"#),
    ("skins", r#"{"joints": []}"#),
];

/// A camera that is no perspective one.
const ORTHOGRAPHIC: &str = r#"{"type": "orthographic", "orthographic": {"xmag": 1, "ymag": 1, "zfar": 1, "znear": 0}}"#;

/// Where objects are, by the keys that lead to them (those in a list with `[]`), and what is kept of them. A name that is no string is dropped, since
/// nothing depends on it.
const KEPT: &[(&str, &[&str])] = &[
    ("accessors[]", &["bufferView", "byteOffset", "componentType", "count", "name", "normalized", "sparse", "type"]),
    ("accessors[].sparse", &["count", "indices", "values"]),
    ("accessors[].sparse.indices", &["bufferView", "byteOffset", "componentType"]),
    ("accessors[].sparse.values", &["bufferView", "byteOffset", "componentType"]),
    ("animations[]", &["channels", "name", "samplers"]),
    ("animations[].channels[]", &["sampler", "target"]),
    ("animations[].channels[].target", &["node", "path"]),
    ("animations[].samplers[]", &["input", "interpolation", "output"]),
    ("asset", &["version"]),
    ("bufferViews[]", &["buffer", "byteLength", "byteOffset", "byteStride", "name"]),
    ("buffers[]", &["byteLength", "name", "uri"]),
    ("cameras[]", &["name", "perspective"]),
    ("cameras[].perspective", &["yfov"]),
    ("materials[]", &["alphaMode", "extensions", "name", "pbrMetallicRoughness"]),
    ("materials[].extensions", &["KHR_materials_ior", "KHR_materials_transmission"]),
    ("materials[].extensions.KHR_materials_ior", &["ior"]),
    ("materials[].extensions.KHR_materials_transmission", &["transmissionFactor"]),
    ("materials[].pbrMetallicRoughness", &["baseColorFactor", "metallicFactor", "roughnessFactor"]),
    ("meshes[]", &["name", "primitives", "weights"]),
    ("meshes[].primitives[]", &["attributes", "indices", "material", "mode", "targets"]),
    ("meshes[].primitives[].targets[]", &["POSITION"]),
    (
        "nodes[]",
        &["camera", "children", "matrix", "mesh", "name", "rotation", "scale", "skin", "translation", "weights"],
    ),
    ("scenes[]", &["name", "nodes"]),
    ("skins[]", &["inverseBindMatrices", "joints", "name"]),
];

/// What is kept of the document itself.
const DOCUMENT: &[&str] = &[
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
];

/// Strips `document` in place.
pub(super) fn strip(document: &mut Value) -> Result<StrippedParts, String> {
    check_compressed(document)?;
    items(document, "materials").for_each(replace_older_form);
    keep(document, DOCUMENT, "");
    let mut facts = strip_animations(document);
    // Only told of.
    let used = document.get("extensionsUsed").and_then(Value::as_array);
    if !used.is_some_and(|names| names.iter().all(Value::is_string)) {
        remove(document, "extensionsUsed");
    }
    for material in items(document, "materials") {
        if !matches!(material.get("alphaMode").and_then(Value::as_str), Some("OPAQUE" | "MASK" | "BLEND")) {
            remove(material, "alphaMode");
        }
    }
    let mut skinned = false;
    for node in items(document, "nodes") {
        if node.get("mesh").is_some() {
            skinned |= node.get("skin").is_some();
        } else {
            remove(node, "skin");
            remove(node, "weights");
        }
    }
    if !skinned {
        remove(document, "skins");
    }
    for scene in items(document, "scenes").filter_map(Value::as_object_mut) {
        scene.entry("nodes").or_insert_with(|| Value::Array(Vec::new()));
    }
    // Joints and weights of vertices are kept where there are skins.
    for primitive in items(document, "meshes").flat_map(|mesh| items(mesh, "primitives")) {
        if let Some(attributes) = primitive.get_mut("attributes").and_then(Value::as_object_mut) {
            attributes.retain(|key, _| key == "POSITION" || (skinned && is_influence(key)));
        }
    }
    let reached = reached(document);
    let unreached = |(name, index): (&'static str, usize)| !reached.contains(&(name, index));
    for (name, _) in LISTS {
        let all = items(document, name).enumerate();
        let others = all.filter(|(index, item)| unreached((name, *index)) && !is_material(name, item));
        others.for_each(|(_, item)| *item = Value::Null);
    }
    for view in items(document, "bufferViews").filter(|view| view.get("byteStride").and_then(rules::whole) == Some(0)) {
        remove(view, "byteStride");
        facts.zero_strides += 1;
    }
    rules::check(document)?;
    // What the schema wants, and nothing here depends on.
    for camera in items(document, "cameras") {
        if let Some(projection) = camera.get_mut("perspective").and_then(Value::as_object_mut) {
            projection.insert("znear".to_owned(), 1.into());
            camera["type"] = "perspective".into();
        } else if let (Some(camera), Value::Object(other)) = (camera.as_object_mut(), parsed(ORTHOGRAPHIC)) {
            camera.extend(other);
        }
    }
    for (name, placeholder) in LISTS {
        let all = items(document, name).enumerate();
        let nulls = all.filter(|(index, item)| item.is_null() && unreached((name, *index)));
        nulls.for_each(|(_, item)| *item = parsed(placeholder));
    }
    Ok(facts)
}

/// Whether an element is a material that can be read: a scene keeps all of them.
fn is_material(list: &str, item: &Value) -> bool {
    list == "materials" && gltf::json::deserialize::from_value::<gltf::json::Material>(item.clone()).is_ok()
}

/// The value of a constant text.
fn parsed(json: &str) -> Value {
    gltf::json::deserialize::from_str(json).unwrap_or_default()
}

/// What the scene and the animation need, directly or through others: lists with the indices of their elements.
fn reached(document: &Value) -> HashSet<(&'static str, usize)> {
    let mut reached = HashSet::new();
    let mut open: Vec<(&str, &Value)> =
        document.get("animations").map(|value| ("animations", value)).into_iter().collect();
    let scenes = document.get("scenes").and_then(Value::as_array).map_or(0, Vec::len);
    let mut named: Vec<(&'static str, usize)> =
        match document.get("scene").filter(|scene| !scene.is_null()).map_or(Some(0), rules::whole) {
            _ if scenes == 0 => (0..document.get("nodes").and_then(Value::as_array).map_or(0, Vec::len))
                .map(|node| ("nodes", node))
                .collect(),
            Some(scene) => vec![("scenes", usize::try_from(scene).unwrap_or(usize::MAX))],
            None => Vec::new(),
        };
    loop {
        while let Some((list, index)) = named.pop() {
            if let Some(item) =
                document.get(list).and_then(|list| list.get(index)).filter(|_| reached.insert((list, index)))
            {
                open.push((list, item));
            }
        }
        match open.pop() {
            Some((key, Value::Array(values))) => open.extend(values.iter().map(|value| (key, value))),
            Some((_, Value::Object(object))) => open.extend(object.iter().map(|(key, value)| (key.as_str(), value))),
            Some((key, value)) => {
                if let (Some(Rule::Index(list)), Some(index)) = (rules::rule(key), rules::whole(value)) {
                    named.push((list, usize::try_from(index).unwrap_or(usize::MAX)));
                }
            }
            None => return reached,
        }
    }
}

/// Keeps the first animation, and of that the channels that move a property of a node.
fn strip_animations(document: &mut Value) -> StrippedParts {
    let mut facts = StrippedParts::default();
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
        if let Some(channels) = animation.get_mut("channels").and_then(Value::as_array_mut) {
            let all = channels.len();
            channels.retain(moves_a_node);
            facts.foreign_channels += all - channels.len();
        }
        let named = |channel: &mut Value| channel.get("sampler").and_then(rules::whole);
        let used: HashSet<Option<u64>> = items(animation, "channels").map(named).collect();
        // What no channel uses is in nobody's way as a copy of what one uses.
        let stand_in = items(animation, "samplers").zip(0..).find(|(_, at)| used.contains(&Some(*at)));
        let stand_in = stand_in.map(|(sampler, _)| sampler.clone()).unwrap_or_default();
        for (sampler, _) in items(animation, "samplers").zip(0..).filter(|(_, at)| !used.contains(&Some(*at))) {
            *sampler = stand_in.clone();
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

/// Refuses triangles that are in no buffer view, but compressed.
fn check_compressed(document: &Value) -> Result<(), String> {
    let accessors = document.get("accessors");
    for (mesh_index, mesh) in listed(document, "meshes").enumerate() {
        for (primitive_index, primitive) in listed(mesh, "primitives").enumerate() {
            let compressed = primitive.get("extensions").and_then(|used| used.get("KHR_draco_mesh_compression"));
            let position = primitive.get("attributes").and_then(|attributes| attributes.get("POSITION")?.as_u64());
            let accessor = position.and_then(|index| accessors?.get(usize::try_from(index).ok()?));
            let hollow =
                accessor.is_some_and(|accessor| accessor.get("bufferView").or(accessor.get("sparse")).is_none());
            if compressed.is_some() && hollow {
                return Err(format!(
                    "meshes[{mesh_index}].primitives[{primitive_index}] has its triangles only in KHR_draco_mesh_compression, which is not supported: export the scene again without Draco compression"
                ));
            }
        }
    }
    Ok(())
}

/// Where a material has only the older specular-glossiness form, its diffuse colour and glossiness stand in.
fn replace_older_form(material: &mut Value) {
    let extension = |extensions: &mut Value| extensions.get_mut("KHR_materials_pbrSpecularGlossiness").map(Value::take);
    let older = material.get_mut("extensions").and_then(extension);
    let (Some(older), Some(object)) = (older, material.as_object_mut()) else {
        return;
    };
    object.entry("pbrMetallicRoughness").or_insert_with(|| {
        let glossiness = older.get("glossinessFactor").and_then(Value::as_f64).unwrap_or(1.0);
        let mut factors = serde_json::json!({ "metallicFactor": 0.0, "roughnessFactor": 1.0 - glossiness });
        if let Some(diffuse) = older.get("diffuseFactor") {
            factors["baseColorFactor"] = diffuse.clone();
        }
        factors
    });
}

fn listed<'a>(value: &'a Value, key: &str) -> impl Iterator<Item = &'a Value> + use<'a> {
    value.get(key).and_then(Value::as_array).into_iter().flatten()
}

/// The elements of the array at `key`; none if there is no array.
pub(super) fn items<'a>(value: &'a mut Value, key: &str) -> impl Iterator<Item = &'a mut Value> + use<'a> {
    value.get_mut(key).and_then(Value::as_array_mut).into_iter().flatten()
}

/// Whether an attribute has joints or their weights.
pub(super) fn is_influence(key: &str) -> bool {
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

/// Keeps only `keys` of the object at `path`, and of those in it what [`KEPT`] says.
fn keep(value: &mut Value, keys: &[&str], path: &str) {
    let Some(object) = value.as_object_mut() else {
        return;
    };
    object.retain(|key, value| keys.contains(&key.as_str()) && (key != "name" || value.is_string()));
    for (key, value) in object {
        let dot = if path.is_empty() { "" } else { "." };
        let (suffix, values) = match value {
            Value::Array(values) => ("[]", values.as_mut_slice()),
            Value::Object(_) => ("", std::slice::from_mut(value)),
            _ => continue,
        };
        let path = format!("{path}{dot}{key}{suffix}");
        if let Some((_, keys)) = KEPT.iter().find(|(kept, _)| *kept == path) {
            values.iter_mut().for_each(|value| keep(value, keys, &path));
        }
    }
}
