//! What is wrong with a file ends in a message that says so, never in a panic, and never in a huge allocation.
#![allow(missing_docs)]

use crate::support;

use serde_json::{Value, json};
use support::{Doc, SQUARE, promises};
use tracebench_scenes::import_bytes;
use tracebench_tests::fuzz::Random;

#[track_caller]
fn refused(bytes: &[u8], part: &str) {
    let error = import_bytes(bytes, None, "bad").expect_err("this must be refused");
    assert!(!error.is_argument());
    let message = error.to_string();
    assert!(message.starts_with("bad: ") && message.contains(part), "{message}");
}

/// Proves that each kind of file that is not glTF 2.0 is called what it is.
#[test]
fn not_gltf() {
    refused(b"", "empty");
    refused(b"\x89PNG\r\n", "not a glTF file");
    refused(b"{}", "no asset.version");
    refused(b"[1, 2, 3]", "no asset.version");
    refused(b"3", "no asset.version");
    refused(br#"{"asset": {"version": "1.0"}}"#, "glTF version 1.0");
    refused(br#"{"asset": {"version": 2}}"#, "asset.version is 2, ");
    refused(br#"{"asset": {"version": 2.0}}"#, "asset.version is 2.0, ");
    refused(br#"{"asset": {"version": "two"}}"#, "asset.version is \"two\", ");
    refused(br#"{"asset": {"version": "2.0", "minVersion": "2.1"}}"#, "asset.minVersion is \"2.1\"");
    refused(br#"{"asset": {"version": "2.0", "minVersion": 2.0}}"#, "asset.minVersion is 2.0, ");
    refused(br#"{"asset": {"version": "2.1", "minVersion": "2.0"}}"#, "no triangles");
    refused(br#"{"asset": {"version": "2.0"}}"#, "no triangles");
    refused(br#"{"asset": {"version": "2.0"}, "nodes": {"a": 1}}"#, "schema");
    refused(b"glTF", "12-byte header");
    refused(b"glTF\x01\0\0\0\x14\0\0\0________", "version 1");
    refused(b"glTF\x02\0\0\0\x04\0\0\0________", "header says 4 bytes");
    refused(b"glTF\x02\0\0\0\x14\0\0\0\xff\xff\xff\xffJSON", "damaged");
    let deep = format!("{}{}", "[".repeat(100_000), "]".repeat(100_000));
    refused(deep.as_bytes(), "not a glTF file");
}

/// Proves that a `.glb` cut off anywhere is refused.
#[test]
fn truncated_at_every_length() {
    let whole = Doc::square().glb();
    assert!(import_bytes(&whole, None, "whole").is_ok());
    for length in 0..whole.len() {
        let error = import_bytes(&whole[..length], None, "cut").expect_err("cut off");
        assert!(!error.is_argument());
    }
    // Also with a header that knows of the cut.
    for length in 12..whole.len() - 4 {
        let mut cut = whole[..length].to_vec();
        cut[8..12].copy_from_slice(&(length as u32).to_le_bytes());
        assert!(import_bytes(&cut, None, "cut").is_err(), "{length}");
    }
}

/// Proves that files without any triangle say why.
#[test]
fn no_triangles() {
    let mut doc = Doc::square();
    doc.json["nodes"] = json!([{}]);
    assert!(doc.error().contains("no node of its scene holds a mesh"), "{}", doc.error());
    let mut doc = Doc::square();
    doc.json["meshes"][0]["primitives"][0]["mode"] = json!(1);
    assert!(doc.error().contains("only points and lines"), "{}", doc.error());
    let mut doc = Doc::new();
    let positions = doc.positions(&[[1.0; 3]; 6]);
    doc.mesh(json!([{"attributes": {"POSITION": positions}}]));
    assert!(doc.error().contains("all 2 of the file have exactly zero area"), "{}", doc.error());
    doc.json["accessors"][0]["count"] = json!(0);
    assert!(doc.error().contains("its meshes are empty"), "{}", doc.error());
}

/// Proves that an index out of range names mesh, primitive, index and number of vertices, in each width.
#[test]
fn index_out_of_range() {
    for component in [5121, 5123, 5125] {
        let mut doc = Doc::new();
        let positions = doc.positions(&SQUARE);
        let list = doc.indices(&[0, 1, 2, 0, 2, 4], component);
        doc.mesh(json!([{"attributes": {"POSITION": positions}, "indices": list}]));
        let error = doc.error();
        for part in ["meshes[0].primitives[0] ('thing')", "index 5 is 4", "4 vertices"] {
            assert!(error.contains(part), "{error}");
        }
    }
}

/// Proves that positions that are not finite, before or after the transform, or too far out, are refused by name.
#[test]
fn positions_out_of_range() {
    for (value, part) in [(f32::NAN, "not finite"), (f32::NEG_INFINITY, "not finite"), (2e15, "scale the scene down")] {
        let mut doc = Doc::new();
        let mut square = SQUARE;
        square[2][1] = value;
        let positions = doc.positions(&square);
        let list = doc.indices(&[0, 1, 2], 5123);
        doc.mesh(json!([{"attributes": {"POSITION": positions}, "indices": list}]));
        let error = doc.error();
        assert!(error.contains("meshes[0].primitives[0] ('thing') vertex 2") && error.contains(part), "{error}");
    }
    let mut doc = Doc::square();
    doc.json["nodes"][0]["translation"] = json!([0.0, 1e39, 0.0]);
    assert!(doc.error().contains("after its node's transform"), "{}", doc.error());
    doc.json["nodes"][0]["translation"] = json!([0.0, 1e20, 0.0]);
    assert!(doc.error().contains("scale the scene down"), "{}", doc.error());
    doc.json["nodes"][0]["translation"] = json!([0.0, 1e14, 0.0]);
    assert!(doc.error().contains("zero area"), "{}", doc.error());
}

/// Proves that scenes too small for f32's products are refused with what to do, and ones just large enough are not.
#[test]
fn scenes_too_small() {
    let side = Doc::square().import().unwrap().diagonal();
    for (diagonal, fine) in [(1e-38, false), (9e-16, false), (1.1e-15, true), (1e-12, true)] {
        let mut doc = Doc::square();
        doc.json["nodes"][0]["scale"] = json!(vec![diagonal / side; 3]);
        match doc.import() {
            Ok(scene) => assert!(fine && scene.diagonal() >= 1e-15, "{diagonal}"),
            Err(error) => assert!(!fine && error.to_string().contains("scale the scene up"), "{diagonal}: {error}"),
        }
    }
}

/// Proves that nodes that are no tree are refused rather than walked for ever.
#[test]
fn nodes_that_are_no_tree() {
    let cycles: [Value; 3] = [
        json!([{"mesh": 0, "children": [0]}]),
        json!([{"children": [1]}, {"mesh": 0, "children": [0]}]),
        json!([{"children": [1, 2]}, {"mesh": 0, "children": [2]}, {"mesh": 0}]),
    ];
    for nodes in cycles {
        let mut doc = Doc::square();
        doc.json["nodes"] = nodes;
        assert!(doc.error().contains("must form a tree"), "{}", doc.error());
    }
    let mut doc = Doc::square();
    doc.json["nodes"] = json!([{"mesh": 0, "children": [1]}, {"children": [0]}]);
    doc.json.as_object_mut().unwrap().remove("scenes");
    doc.json.as_object_mut().unwrap().remove("scene");
    assert!(doc.error().contains("must form a tree"), "{}", doc.error());
    // A long chain is no cycle, and is not walked by recursion.
    let mut doc = Doc::square();
    let chain: Vec<Value> =
        (0..200_000).map(|at| if at < 199_999 { json!({"children": [at + 1]}) } else { json!({"mesh": 0}) }).collect();
    doc.json["nodes"] = json!(chain);
    assert!(doc.import().is_ok());
}

/// Proves that every reference to something that is not there is refused, also where 32 bits would wrap around.
#[test]
fn references_out_of_range() {
    for (pointer, value) in [
        ("/scene", json!(7)),
        ("/scenes/0/nodes/0", json!(7)),
        ("/nodes/0/mesh", json!(7)),
        ("/nodes/0/mesh", json!(1u64 << 32)),
        ("/meshes/0/primitives/0/attributes/POSITION", json!(7)),
        ("/meshes/0/primitives/0/attributes/POSITION", json!(1u64 << 32)),
        ("/meshes/0/primitives/0/indices", json!(7)),
        ("/meshes/0/primitives/0/mode", json!(7)),
        ("/accessors/0/bufferView", json!(7)),
        ("/accessors/0/componentType", json!(1)),
        ("/accessors/0/type", json!("VEC9")),
        ("/accessors/0/count", json!(-1)),
        ("/bufferViews/0/buffer", json!(7)),
        ("/nodes/0", json!(null)),
    ] {
        let mut doc = Doc::square();
        doc.json["meshes"][0]["primitives"][0]["mode"] = json!(4);
        *doc.json.pointer_mut(pointer).unwrap() = value.clone();
        let error = doc.error();
        assert!(error.contains("export"), "{pointer} = {value}: {error}");
    }
    let mut doc = Doc::square();
    doc.json["meshes"][0]["primitives"][0]["material"] = json!(0);
    assert!(doc.error().contains("material"), "{}", doc.error());
}

/// Proves that accessors and views that reach beyond their bytes are refused with the numbers, whatever overflows.
#[test]
fn data_out_of_range() {
    let huge = u64::MAX;
    for (pointer, value, part) in [
        ("/accessors/0/count", json!(5), "bufferViews[0] has 48 bytes"),
        ("/accessors/0/count", json!(huge), "bufferViews[0] has 48 bytes"),
        ("/accessors/0/count", json!(huge / 12 + 2), "bufferViews[0] has 48 bytes"),
        ("/accessors/1/count", json!(huge), "bufferViews[1] has 12 bytes"),
        ("/accessors/0/byteOffset", json!(1), "bufferViews[0] has 48 bytes"),
        ("/accessors/0/byteOffset", json!(huge), "bufferViews[0] has 48 bytes"),
        ("/bufferViews/0/byteLength", json!(61), "buffers[0] has 60"),
        ("/bufferViews/0/byteLength", json!(huge), "buffers[0] has 60"),
        ("/bufferViews/0/byteOffset", json!(huge), "buffers[0] has 60"),
        ("/bufferViews/0/byteStride", json!(8), "stride of 8"),
        ("/bufferViews/0/byteStride", json!(252), "bufferViews[0] has 48 bytes"),
        ("/buffers/0/byteLength", json!(huge), "too short"),
        ("/buffers/0/byteLength", json!(64), "too short"),
        ("/accessors/0/componentType", json!(5125), "not positions"),
        ("/accessors/0/type", json!("VEC2"), "not positions"),
        ("/accessors/1/componentType", json!(5122), "not indices"),
    ] {
        let mut doc = Doc::square();
        let (list, rest) = pointer[1..].split_once('/').unwrap();
        let (index, key) = rest.split_once('/').unwrap();
        doc.json[list][index.parse::<usize>().unwrap()][key] = value.clone();
        let error = doc.error();
        assert!(error.contains(part), "{pointer} = {value}: {error}");
    }
}

/// Proves that counts that no bytes back, and instances without end, are refused before memory is taken.
#[test]
fn absurd_counts() {
    let mut doc = Doc::square();
    doc.json["accessors"][0] = json!({"componentType": 5126, "type": "VEC3", "count": u64::MAX});
    assert!(doc.error().contains("without data"), "{}", doc.error());
    let mut doc = Doc::square();
    doc.json["accessors"][1] = json!({"componentType": 5125, "type": "SCALAR", "count": 1_000_000_000_000u64});
    assert!(doc.error().contains("without data"), "{}", doc.error());

    // A megabyte that asks for 60 million triangles: 1,000 nodes with one mesh of 60,000.
    let mut doc = Doc::new();
    let positions = doc.positions(&SQUARE);
    let list: Vec<u32> = (0..60_000).flat_map(|_| [0, 1, 2]).collect();
    let list = doc.indices(&list, 5121);
    doc.mesh(json!([{"attributes": {"POSITION": positions}, "indices": list}]));
    doc.json["nodes"] = json!(vec![json!({"mesh": 0}); 1000]);
    doc.json["scenes"][0]["nodes"] = json!((0..1000).collect::<Vec<_>>());
    assert!(doc.error().contains("60000000 triangles"), "{}", doc.error());
    // The same by primitives that share one list.
    let primitive = json!({"attributes": {"POSITION": positions}, "indices": list});
    doc.json["meshes"][0]["primitives"] = json!(vec![primitive; 1000]);
    doc.json["nodes"] = json!([{"mesh": 0}]);
    doc.json["scenes"][0]["nodes"] = json!([0]);
    assert!(doc.error().contains("at most 50000000"), "{}", doc.error());
}

/// Proves that sparse parts that do not fit are refused.
#[test]
fn bad_sparse_parts() {
    for (indices, count, part) in
        [([2u8, 1], 2, "do not increase"), ([1, 4], 2, "replaces element 4"), ([1, 2], 9, "replaces 9 elements")]
    {
        let mut doc = Doc::square();
        let at = doc.view(&indices, None);
        let values = doc.view(&[0; 24], None);
        doc.json["accessors"][0]["sparse"] = json!({
            "count": count,
            "indices": {"bufferView": at, "componentType": 5121},
            "values": {"bufferView": values},
        });
        assert!(doc.error().contains(part), "{}", doc.error());
    }
}

/// Proves on 2,000 damaged files that the import answers, and that what it accepts keeps the promises of a mesh.
#[test]
fn damaged_bytes_never_panic() {
    let whole = rich().glb();
    for number in 0..2000 {
        let mut random = Random::of_execution(number);
        let mut bytes = whole.clone();
        let digits = random.once_in(2);
        for _ in 0..=random.below(5) {
            let (at, value) = (random.below(bytes.len()), random.bits() as u8);
            // Digits for digits keep the JSON whole, so that the damage gets past its parser.
            if digits && bytes[at].is_ascii_digit() {
                bytes[at] = b'0' + value % 10;
            } else if !digits || at >= bytes.len() / 2 {
                bytes[at] = value;
            }
        }
        if let Err(broken) = promises::check(&bytes) {
            panic!("file {number}: {broken}");
        }
    }
}

/// A file with something of everything.
fn rich() -> Doc {
    let mut doc = Doc::square();
    let at = doc.view(&[1, 3], None);
    let values = doc.view(&support::float_bytes(&[[1.5, 0.0, 0.0], [0.0, 1.5, 0.0]]), None);
    doc.json["accessors"][0]["sparse"] = json!({
        "count": 2,
        "indices": {"bufferView": at, "componentType": 5121},
        "values": {"bufferView": values},
    });
    doc.json["materials"] = json!([{"pbrMetallicRoughness": {"metallicFactor": 0.5}}]);
    doc.json["cameras"] = json!([{"type": "perspective", "perspective": {"yfov": 0.7, "znear": 0.1}}]);
    doc.json["nodes"] = json!([
        {"children": [1, 2], "scale": [1, -2, 3]},
        {"mesh": 0, "rotation": [0, 0, 0, 1]},
        {"camera": 0, "translation": [1, 2, 3]},
    ]);
    doc.json["meshes"][0]["primitives"][0]["material"] = json!(0);
    let strip = json!({"attributes": {"POSITION": 0}, "mode": 5});
    doc.json["meshes"][0]["primitives"].as_array_mut().unwrap().push(strip);
    assert!(doc.json["nodes"].is_array());
    doc
}
