//! From bytes to a checked glTF document that holds only what rays need.
//!
//! The JSON is stripped before it is typed: textures, images, animations after the first, extensions and attributes
//! that move no vertex are never read here, so nothing that is missing or wrong in them can fail an import.

use std::ops::Range;

use gltf::json::validation::{Error as Violation, Validate};
use gltf::json::{Root, Value};

use super::rules::shown;
use super::strip::{StrippedParts, strip};

/// A document all of whose indices are in range, and what is needed beside it.
pub(super) struct Document {
    /// The typed JSON.
    pub(super) root: Root,
    /// Where the binary chunk of a `.glb` is.
    pub(super) blob: Option<Range<usize>>,
    /// What was stripped and is worth a word to the user.
    pub(super) facts: StrippedParts,
}

/// Parses `.gltf` or `.glb` bytes; the error says what is wrong and what to do.
pub(super) fn parse(bytes: &[u8]) -> Result<Document, String> {
    let (json, blob) = split(bytes)?;
    let mut value: Value = gltf::json::deserialize::from_slice(json).map_err(|error| {
        format!("not a glTF file: its JSON cannot be parsed ({error}); export or download it again")
    })?;
    check_version(&value)?;
    let facts = strip(&mut value)?;
    let root: Root = serde_path_to_error::deserialize(&value).map_err(|error| {
        let path = error.path().to_string();
        let found = value_at(&value, &path);
        format!("{path} is {found}, which breaks the glTF 2.0 schema ({}); export the file again", error.inner())
    })?;
    validate(&root, &value)?;
    Ok(Document { root, blob, facts })
}

/// JSON, and where the binary chunk is.
fn split(bytes: &[u8]) -> Result<(&[u8], Option<Range<usize>>), String> {
    if bytes.is_empty() {
        return Err("the file is empty; export or download it again".to_owned());
    }
    if !bytes.starts_with(b"glTF") {
        let json = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
        return Ok((json, None));
    }
    let (Some(version), Some(length)) = (word(bytes, 4), word(bytes, 8)) else {
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
    let whole = usize::try_from(length).unwrap_or(usize::MAX);
    let Some(contents) = bytes.get(..whole).filter(|contents| contents.len() >= 12) else {
        return Err(format!(
            "the .glb file is truncated or damaged: its header says {length} bytes and there are {}; download or export it again",
            bytes.len()
        ));
    };
    let first = chunk(contents, 12)?.filter(|(kind, _)| kind == b"JSON");
    let (_, json) = first.ok_or("the .glb file is damaged: its first chunk is no JSON; download or export it again")?;
    // Chunks of other types may follow and are ignored (glTF 2.0, section 4.4.3.1).
    let mut start = json.end;
    while let Some((kind, range)) = chunk(contents, start)? {
        start = range.end;
        if kind == b"BIN\0" {
            return Ok((&contents[json], Some(range)));
        }
    }
    Ok((&contents[json], None))
}

fn word(bytes: &[u8], at: usize) -> Option<u32> {
    bytes.get(at..)?.first_chunk().map(|word| u32::from_le_bytes(*word))
}

/// Type of a chunk, and where its contents are.
type Chunk<'a> = (&'a [u8], Range<usize>);

/// The chunk that starts at a byte; none at the end.
fn chunk(contents: &[u8], start: usize) -> Result<Option<Chunk<'_>>, String> {
    if start == contents.len() {
        return Ok(None);
    }
    let range = word(contents, start).and_then(|length| {
        let end = (start + 8).checked_add(usize::try_from(length).ok()?)?;
        (end <= contents.len()).then_some(start + 8..end)
    });
    let range = range.ok_or("the .glb file is damaged: a chunk reaches beyond its end; download or export it again")?;
    Ok(Some((&contents[start + 4..start + 8], range)))
}

fn check_version(value: &Value) -> Result<(), String> {
    let asset = value.get("asset");
    let Some(version) = asset.and_then(|asset| asset.get("version")) else {
        return Err("this is JSON but not glTF: there is no asset.version; give a .gltf or .glb file".to_owned());
    };
    let least = asset.and_then(|asset| asset.get("minVersion"));
    for (path, found) in
        std::iter::once(("asset.version", version)).chain(least.map(|least| ("asset.minVersion", least)))
    {
        let words =
            || format!("{path} is {}, and must be text like \"2.0\"; export the file as glTF 2.0", shown(found));
        let (major, minor) =
            found.as_str().ok_or_else(words)?.split_once('.').unwrap_or((found.as_str().unwrap_or_default(), "0"));
        let number = |part: &str| part.split('.').next().and_then(|part| part.parse::<u32>().ok()).ok_or_else(words);
        let (major, minor) = (number(major)?, number(minor)?);
        if major != 2 && path == "asset.version" {
            return Err(format!(
                "this is glTF version {major}.{minor} (asset.version is {}); only 2.x is supported, so export it as glTF 2.0",
                shown(found)
            ));
        }
        if (major, minor) > (2, 0) && path == "asset.minVersion" {
            return Err(format!(
                "{path} is {}, so readers of 2.0 must refuse the file; export it as glTF 2.0",
                shown(found)
            ));
        }
    }
    Ok(())
}

/// Checks what [`super::rules`] leave, above all what must not be missing; what glTF wants and rays do not is let pass.
fn validate(root: &Root, value: &Value) -> Result<(), String> {
    let mut count = 0usize;
    let mut shown = Vec::new();
    root.validate(root, gltf::json::Path::new, &mut |path, violation| {
        let path = path();
        if tolerated(path.as_str(), violation) {
            return;
        }
        count += 1;
        if shown.len() < 3 {
            let found = value_at(value, path.as_str());
            shown.push(format!("{path}, which is {found} ({})", violation.to_string().to_lowercase()));
        }
    });
    if count == 0 {
        return Ok(());
    }
    let more = if count > shown.len() { format!(" and {} more", count - shown.len()) } else { String::new() };
    Err(format!("the file breaks the rules of glTF 2.0 at {}{more}; export it again", shown.join(", ")))
}

/// The value at a JSON path, as text.
fn value_at(value: &Value, path: &str) -> String {
    let keys = path.split(['.', '[']).map(|key| key.trim_matches([']', '"'])).filter(|key| !key.is_empty());
    let found = keys.clone().try_fold(value, |value, key| match value {
        Value::Array(values) => values.get(key.parse::<usize>().ok()?),
        other => other.get(key),
    });
    found.map_or_else(|| "missing".to_owned(), shown)
}

/// Bounds of positions are not read, extensions have rules of their own, an accessor without data is all zeros, a primitive without
/// positions is left out, and indices were checked where anything depends on them.
fn tolerated(path: &str, violation: Violation) -> bool {
    match violation {
        Violation::Unsupported => true,
        Violation::IndexOutOfBounds => path.starts_with("bufferViews["),
        Violation::Missing | Violation::Invalid if path.ends_with(".min") || path.ends_with(".max") => true,
        Violation::Missing => {
            path.ends_with("attributes[\"POSITION\"]")
                || (path.starts_with("accessors[") && path.ends_with("].bufferView"))
        }
        _ => false,
    }
}
