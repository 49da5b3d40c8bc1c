//! Buffers from files and data URIs, cameras, extensions, and what is ignored with a word.
#![allow(missing_docs)]

use crate::support;

use std::fs;

use serde_json::json;
use support::{Doc, glb};
use tracebench_scenes::{Origin, import, import_bytes};

const TABLE: &[u8] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

fn base64(bytes: &[u8]) -> String {
    let mut out = String::new();
    for chunk in bytes.chunks(3) {
        let word = chunk.iter().enumerate().fold(0u32, |word, (at, &byte)| word | u32::from(byte) << (16 - 8 * at));
        for at in 0..4 {
            if at <= chunk.len() {
                out.push(TABLE[(word >> (18 - 6 * at)) as usize & 63] as char);
            } else {
                out.push('=');
            }
        }
    }
    out
}

/// Proves that data URIs are decoded: the scene is the one of the binary chunk.
#[test]
fn data_uri() {
    let mut doc = Doc::square();
    let expected = doc.import().unwrap().sha256;
    let data = format!("data:application/octet-stream;base64,{}", base64(&doc.bin));
    doc.json["buffers"][0]["uri"] = json!(data);
    let scene = import_bytes(doc.json.to_string().as_bytes(), None, "text").unwrap();
    assert_eq!(scene.sha256, expected);
    doc.json["buffers"][0]["uri"] = json!("data:;base64,@@@");
    let error = import_bytes(doc.json.to_string().as_bytes(), None, "text").unwrap_err();
    assert!(error.to_string().contains("data uri of buffers[0]"), "{error}");
}

/// Proves that a file beside the scene is found under its percent-decoded name, and that images are never looked for.
#[test]
fn external_file_with_a_space_in_its_name() {
    let folder = tempfile::tempdir().unwrap();
    let mut doc = Doc::square();
    let expected = doc.import().unwrap().sha256;
    doc.json["buffers"][0]["uri"] = json!("my%20mesh.bin");
    doc.json["images"] = json!([{"uri": "missing.png"}, {"bufferView": 12345}]);
    doc.json["textures"] = json!([{"source": 0}, {"extensions": {"EXT_texture_webp": {"source": 9}}}]);
    fs::write(folder.path().join("my mesh.bin"), &doc.bin).unwrap();
    let path = folder.path().join("a scene.gltf");
    fs::write(&path, doc.json.to_string()).unwrap();
    let scene = import(&path).unwrap();
    assert_eq!(scene.sha256, expected);
    assert_eq!(scene.name, "a scene");
    assert_eq!(scene.origin, Origin::File { path: path.clone() });

    // A byte order mark in front of the JSON does no harm.
    fs::write(&path, format!("\u{feff}{}", doc.json)).unwrap();
    assert_eq!(import(&path).unwrap().sha256, expected);

    // A buffer that no triangle needs may be missing.
    doc.push("buffers", json!({"byteLength": 10, "uri": "nowhere.bin"}));
    fs::write(&path, doc.json.to_string()).unwrap();
    assert_eq!(import(&path).unwrap().sha256, expected);
}

/// Proves that a scene is named by its folder where its file's own name says nothing, in any case of letters, and by its file
/// otherwise, as it is where there is no folder to name it.
#[test]
fn scenes_are_named_by_what_says_something() {
    let folder = tempfile::tempdir().unwrap();
    let mut doc = Doc::square();
    doc.json["buffers"][0]["uri"] = json!(format!("data:application/octet-stream;base64,{}", base64(&doc.bin)));
    for (file, name) in [
        ("drone/scene.gltf", "drone"),
        ("A drone.v2/Scene.GLTF", "A drone.v2"),
        ("drone/rotor.gltf", "rotor"),
        ("drone/scene2.gltf", "scene2"),
        ("model/untitled.gltf", "model"),
    ] {
        let path = folder.path().join(file);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(&path, doc.json.to_string()).unwrap();
        assert_eq!(import(&path).unwrap().name, name, "{file}");
    }
}

/// Proves that missing, short and remote buffers are told apart and named.
#[test]
fn bad_buffer_files() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.gltf");
    let mut doc = Doc::square();
    doc.json["buffers"][0]["uri"] = json!("gone%20away.bin");
    fs::write(&path, doc.json.to_string()).unwrap();
    let error = import(&path).unwrap_err();
    assert!(!error.is_argument());
    assert!(error.to_string().contains("gone away.bin"), "{error}");

    fs::write(folder.path().join("gone away.bin"), [0; 10]).unwrap();
    let error = import(&path).unwrap_err().to_string();
    assert!(error.contains("too short") && error.contains(" 10") && error.contains(" 60 "), "{error}");

    for uri in ["https://example.org/a.bin", "HTTP://example.org/a.bin"] {
        doc.json["buffers"][0]["uri"] = json!(uri);
        fs::write(&path, doc.json.to_string()).unwrap();
        let error = import(&path).unwrap_err().to_string();
        assert!(error.contains("nothing is downloaded"), "{error}");
    }
    let error = import(&folder.path().join("none.glb")).unwrap_err();
    assert!(!error.is_argument());
    assert!(error.to_string().contains("none.glb"), "{error}");
    let error = import(folder.path()).unwrap_err();
    assert!(error.to_string().contains("cannot read scene file"), "{error}");

    doc.json["buffers"][0]["uri"] = json!(".");
    fs::write(&path, doc.json.to_string()).unwrap();
    let error = import(&path).unwrap_err().to_string();
    assert!(error.contains("not a regular file"), "{error}");

    doc.json["buffers"][0].as_object_mut().unwrap().remove("uri");
    fs::write(&path, doc.json.to_string()).unwrap();
    let error = import(&path).unwrap_err().to_string();
    assert!(error.contains("no uri"), "{error}");
}

/// Proves that cameras look along -Z of their node with its scale taken out, in the order of the nodes, and that those
/// that cannot be looked through are told.
#[test]
fn cameras() {
    let mut doc = Doc::square();
    let half = std::f32::consts::FRAC_1_SQRT_2;
    doc.json["cameras"] = json!([
        {"type": "perspective", "name": "eye", "perspective": {"yfov": 0.75, "znear": 0.1}},
        {"type": "orthographic", "orthographic": {"xmag": 1.0, "ymag": 1.0, "zfar": 10.0, "znear": 0.1}},
        {"type": "perspective", "perspective": {"yfov": 4.0, "znear": 0.1}},
    ]);
    doc.json["nodes"] = json!([
        {"mesh": 0},
        {"camera": 0, "translation": [1.0, 2.0, 3.0], "scale": [2.0, 3.0, 5.0]},
        {"camera": 1},
        {"camera": 2},
        {"camera": 0, "rotation": [0.0, half, 0.0, half]},
        {"camera": 0, "scale": [0.0, 0.0, 0.0]},
    ]);
    doc.json["scenes"][0]["nodes"] = json!([0, 1, 2, 3, 4, 5]);
    let scene = doc.import().unwrap();
    let names: Vec<&str> = scene.cameras.iter().map(|camera| camera.name.as_str()).collect();
    assert_eq!(names, ["eye", "eye-2"]);
    assert_eq!(scene.cameras[0].eye, [1.0, 2.0, 3.0]);
    assert_eq!(scene.cameras[0].target, [1.0, 2.0, 2.0]);
    assert_eq!(scene.cameras[0].up, [0.0, 1.0, 0.0]);
    assert_eq!(scene.cameras[0].vertical_fov_radians, 0.75);
    // A quarter turn about y brings -Z to -X.
    assert!((scene.cameras[1].target[0] + 1.0).abs() < 1e-6);
    assert_eq!(scene.notes.warnings.len(), 3, "{:?}", scene.notes.warnings);
}

/// Proves that names of cameras are made unique by the first free number, and that ten thousand nodes with one camera take
/// no time to speak of: searching from the start for each would take hours.
#[test]
fn names_of_cameras() {
    let named = |count: usize| {
        let mut doc = Doc::square();
        doc.json["cameras"] = json!([
            {"type": "perspective", "name": "eye", "perspective": {"yfov": 0.75, "znear": 0.1}},
            {"type": "perspective", "name": "eye-3", "perspective": {"yfov": 0.75, "znear": 0.1}},
        ]);
        let mut nodes = vec![json!({"mesh": 0}), json!({"camera": 1}), json!({"camera": 1})];
        nodes.extend(vec![json!({"camera": 0}); count]);
        doc.json["scenes"][0]["nodes"] = json!((0..nodes.len()).collect::<Vec<_>>());
        doc.json["nodes"] = json!(nodes);
        doc.import().unwrap().cameras.into_iter().map(|camera| camera.name).collect::<Vec<String>>()
    };
    assert_eq!(named(4), ["eye-3", "eye-3-2", "eye", "eye-2", "eye-4", "eye-5"]);
    let many = named(10_000);
    let unique: std::collections::BTreeSet<&String> = many.iter().collect();
    assert_eq!((unique.len(), many[10_001].as_str()), (10_002, "eye-10001"));
}

/// Proves that a file is not read that is larger than all buffers may be, and that the size of the file counts rather than
/// what the document says. (The file has a hole: it takes no space.)
#[test]
fn endless_files_are_not_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.gltf");
    let mut doc = Doc::square();
    doc.json["buffers"][0]["uri"] = json!("hole.bin");
    doc.json["buffers"][0]["byteLength"] = json!(1u64 << 33);
    let hole = fs::File::create(folder.path().join("hole.bin")).unwrap();
    hole.set_len(1 << 33).unwrap();
    fs::write(&path, doc.json.to_string()).unwrap();
    let error = import(&path).unwrap_err().to_string();
    assert!(error.contains("hole.bin") && error.contains("more than 4294967296 bytes"), "{error}");
    hole.set_len(100).unwrap();
    let error = import(&path).unwrap_err().to_string();
    assert!(error.contains("too short"), "{error}");
}

/// Proves that required extensions are judged by what they concern, and used ones only told.
#[test]
fn extensions() {
    for extension in [
        "KHR_materials_transmission",
        "KHR_materials_variants",
        "KHR_texture_transform",
        "KHR_texture_basisu",
        "EXT_texture_webp",
        "MSFT_texture_dds",
        "KHR_lights_punctual",
        "KHR_xmp_json_ld",
    ] {
        let mut doc = Doc::square();
        doc.json["extensionsRequired"] = json!([extension]);
        assert!(doc.import().is_ok(), "{extension}");
    }
    for extension in ["KHR_draco_mesh_compression", "EXT_meshopt_compression", "EXT_mesh_gpu_instancing", "ACME_voxels"]
    {
        let mut doc = Doc::square();
        doc.json["extensionsRequired"] = json!([extension]);
        let error = doc.error();
        assert!(error.contains(extension) && error.contains("export the scene again"), "{error}");
    }
    let mut doc = Doc::square();
    doc.json["extensionsUsed"] = json!(["EXT_mesh_gpu_instancing", "ACME_colours"]);
    let warnings = doc.import().unwrap().notes.warnings;
    assert_eq!(warnings.len(), 1);
    assert!(warnings[0].contains("EXT_mesh_gpu_instancing"));

    let mut doc = Doc::square();
    doc.json["meshes"][0]["primitives"][0]["extensions"] = json!({"KHR_draco_mesh_compression": {}});
    assert!(doc.import().is_ok(), "with a fallback the triangles are there");
    doc.json["accessors"][0].as_object_mut().unwrap().remove("bufferView");
    assert!(doc.error().contains("without Draco"), "{}", doc.error());
}

/// Proves that custom attributes, skins that no mesh has and animations that do not play do no harm.
#[test]
fn what_moves_nothing_is_not_read() {
    let mut doc = Doc::square();
    doc.json["animations"] = json!([{"channels": [], "samplers": []}, {"channels": "nonsense", "name": "walk"}, 7]);
    doc.json["skins"] = json!([{"joints": [99]}]);
    doc.json["meshes"][0]["primitives"][0]["targets"] = json!([{"NORMAL": 99}]);
    doc.json["meshes"][0]["primitives"][0]["attributes"]["_CUSTOM"] = json!(99);
    doc.json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = json!(99);
    doc.json["meshes"][0]["primitives"][0]["attributes"]["JOINTS_0"] = json!(99);
    doc.json["nodes"] = json!([{"mesh": 0}, {"skin": 99, "weights": "none"}]);
    let scene = doc.import().unwrap();
    assert_eq!(scene.mesh.triangles.len(), 2);
    assert!(scene.animation.is_none());
    let warnings = &scene.notes.warnings;
    assert_eq!(warnings.len(), 2, "{warnings:?}");
    assert!(warnings[0].contains("(2): 'walk', 'unnamed'"), "{warnings:?}");
    assert!(warnings[1].contains("moves no triangles"), "{warnings:?}");

    // Where a mesh has that skin, the same is an error.
    doc.json["nodes"][0]["skin"] = json!(0);
    assert!(doc.error().contains("export"), "{}", doc.error());
}

/// Proves that a binary chunk longer than the buffer by its padding is accepted.
#[test]
fn padded_binary_chunk() {
    let doc = Doc::square();
    let mut bin = doc.bin.clone();
    bin.extend([1, 2, 3]);
    assert!(import_bytes(&glb(doc.json.to_string().as_bytes(), &bin), None, "padded").is_ok());
}
