//! Which glTF extensions are accepted, and what is said about the others.

/// Families that concern materials and textures only.
const ACCEPTED_PREFIXES: &[&str] =
    &["KHR_materials_", "KHR_texture_", "EXT_materials_", "EXT_texture_", "ADOBE_materials_", "MSFT_packing_"];

/// Single extensions that change no triangle, quantised positions, which are read, and pointers of animations, about
/// which the channels that use them are told.
const ACCEPTED: &[&str] = &[
    "KHR_mesh_quantization",
    "KHR_lights_punctual",
    "KHR_animation_pointer",
    "KHR_techniques_webgl",
    "KHR_xmp",
    "KHR_xmp_json_ld",
    "EXT_lights_ies",
    "EXT_lights_image_based",
    "EXT_mesh_features",
    "EXT_structural_metadata",
    "MSFT_texture_dds",
];

const EXPORT_WITHOUT_MESHOPT: &str = "export the scene again without meshopt compression";
const FALLBACK: &str = "its uncompressed fallback is read";

/// Extensions that change geometry: name, what to do where one is required, what is done where it is only used.
const GEOMETRY: &[(&str, &str, &str)] = &[
    ("KHR_draco_mesh_compression", "export the scene again without Draco compression", FALLBACK),
    ("EXT_meshopt_compression", EXPORT_WITHOUT_MESHOPT, FALLBACK),
    ("KHR_meshopt_compression", EXPORT_WITHOUT_MESHOPT, FALLBACK),
    (
        "EXT_mesh_gpu_instancing",
        "turn the instances into separate nodes and export the scene again",
        "the instances are missing and each mesh stands once, at its node",
    ),
    ("MSFT_lod", "export the scene again with one level of detail", "the first level of detail is read"),
    (
        "KHR_node_visibility",
        "delete the hidden nodes and export the scene again",
        "hidden nodes are read like visible ones",
    ),
];

/// What to do about any other extension.
const OTHER: &str =
    "export the scene again without it, or, if it concerns materials only, take it out of extensionsRequired";

/// Refuses required extensions that would change geometry.
pub(super) fn check_required(required: &[String]) -> Result<(), String> {
    for name in required {
        let accepted =
            ACCEPTED.contains(&name.as_str()) || ACCEPTED_PREFIXES.iter().any(|prefix| name.starts_with(prefix));
        if !accepted {
            let advice = GEOMETRY.iter().find(|known| known.0 == name).map_or(OTHER, |known| known.1);
            return Err(format!("the file requires extension {name}, which is not supported: {advice}"));
        }
    }
    Ok(())
}

/// One warning for each extension that is used, not required, and concerns geometry.
pub(super) fn warn_used(used: &[String], warnings: &mut Vec<String>) {
    for (name, _, effect) in GEOMETRY {
        if used.iter().any(|extension| extension == name) {
            warnings.push(format!("extension {name} is not supported: {effect}"));
        }
    }
}
