//! From bytes to a checked glTF document that holds only what rays need.
//!
//! The JSON is stripped before it is typed: textures, images, animations after the first, extensions and attributes
//! that move no vertex are never read here, so nothing that is missing or wrong in them can fail an import.

use std::borrow::Cow;

use gltf::json::validation::{Error as Violation, Validate};
use gltf::json::{Root, Value};

use super::strip::{Facts, strip};

/// A document all of whose indices are in range, and what is needed beside it.
pub(super) struct Document<'a> {
    /// The typed JSON.
    pub(super) root: Root,
    /// The binary chunk of a `.glb`.
    pub(super) blob: Option<Cow<'a, [u8]>>,
    /// What was stripped and is worth a word to the user.
    pub(super) facts: Facts,
}

/// Parses `.gltf` or `.glb` bytes; the error says what is wrong and what to do.
pub(super) fn parse(bytes: &[u8]) -> Result<Document<'_>, String> {
    let (json, blob) = split(bytes)?;
    let mut value: Value = gltf::json::deserialize::from_slice(&json).map_err(|error| {
        format!("not a glTF file: its JSON cannot be parsed ({error}); export or download it again")
    })?;
    check_version(&value)?;
    let facts = strip(&mut value)?;
    let root: Root = gltf::json::deserialize::from_value(value)
        .map_err(|error| format!("the JSON breaks the glTF 2.0 schema ({error}); export the file again"))?;
    validate(&root)?;
    Ok(Document { root, blob, facts })
}

/// JSON and binary chunk.
#[allow(clippy::type_complexity)]
fn split(bytes: &[u8]) -> Result<(Cow<'_, [u8]>, Option<Cow<'_, [u8]>>), String> {
    if bytes.is_empty() {
        return Err("the file is empty; export or download it again".to_owned());
    }
    if !bytes.starts_with(b"glTF") {
        let json = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
        return Ok((Cow::Borrowed(json), None));
    }
    let field = |at: usize| -> Option<u32> {
        let word = bytes.get(at..at + 4)?;
        Some(u32::from_le_bytes(word.try_into().ok()?))
    };
    let (Some(version), Some(length)) = (field(4), field(8)) else {
        return Err(format!(
            "the .glb file ends within its 12-byte header ({} bytes); download or export it again",
            bytes.len()
        ));
    };
    if version != 2 {
        return Err(format!(
            "this is binary glTF version {version}; only version 2 is supported, so export it as glTF 2.0"
        ));
    }
    // The crate's splitter subtracts the header from this length unchecked.
    let whole = usize::try_from(length).unwrap_or(usize::MAX);
    let Some(contents) = bytes.get(..whole).filter(|contents| contents.len() >= 12) else {
        return Err(format!(
            "the .glb file is truncated or damaged: its header says {length} bytes and there are {}; download or export it again",
            bytes.len()
        ));
    };
    let glb = gltf::Glb::from_slice(contents)
        .map_err(|error| format!("the .glb file is damaged ({error}); download or export it again"))?;
    Ok((glb.json, glb.bin))
}

fn check_version(value: &Value) -> Result<(), String> {
    let version = value.get("asset").and_then(|asset| asset.get("version")).and_then(Value::as_str);
    match version {
        Some(version) if version == "2" || version.starts_with("2.") => Ok(()),
        Some(version) => {
            Err(format!("this is glTF version {version}; only 2.x is supported, so export it as glTF 2.0"))
        }
        None => Err("this is JSON but not glTF: there is no asset.version; give a .gltf or .glb file".to_owned()),
    }
}

/// Checks every index and enumeration; what glTF wants and rays do not is let pass.
fn validate(root: &Root) -> Result<(), String> {
    // The crate's own check of a primitive indexes the accessors with POSITION before it looks whether that is in
    // range, so this comes first.
    for (mesh_index, mesh) in root.meshes.iter().enumerate() {
        for (primitive_index, primitive) in mesh.primitives.iter().enumerate() {
            for accessor in primitive.attributes.values() {
                if accessor.value() >= root.accessors.len() {
                    return Err(format!(
                        "meshes[{mesh_index}].primitives[{primitive_index}] names accessor {accessor}, and there are {}; export the file again",
                        root.accessors.len()
                    ));
                }
            }
        }
    }
    let mut count = 0usize;
    let mut shown = Vec::new();
    root.validate(root, gltf::json::Path::new, &mut |path, violation| {
        let path = path();
        if tolerated(path.as_str(), violation) {
            return;
        }
        count += 1;
        if shown.len() < 3 {
            shown.push(format!("{path}: {}", violation.to_string().to_lowercase()));
        }
    });
    if count == 0 {
        return Ok(());
    }
    let more = if count > shown.len() { format!(" and {} more", count - shown.len()) } else { String::new() };
    Err(format!("the file breaks the rules of glTF 2.0 at {}{more}; export it again", shown.join(", ")))
}

/// Bounds of positions are not read, extensions have rules of their own, and an accessor without data is all zeros.
fn tolerated(path: &str, violation: Violation) -> bool {
    match violation {
        Violation::Unsupported => true,
        Violation::Missing | Violation::Invalid if path.ends_with(".min") || path.ends_with(".max") => true,
        Violation::Missing => path.starts_with("accessors[") && path.ends_with("].bufferView"),
        _ => false,
    }
}
