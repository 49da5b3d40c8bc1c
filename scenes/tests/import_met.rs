//! Files as exporters write them: what nothing here depends on is no reason to refuse one, and what is wrong is told with its place.
#![allow(missing_docs)]

use crate::support;

use serde_json::{Value, json};
use support::{Doc, SQUARE};
use tracebench_scenes::{Scene, import_bytes};

/// Type and contents.
type Chunk<'a> = (&'a [u8; 4], &'a [u8]);

/// A `.glb` of chunks.
fn chunks(list: &[Chunk<'_>]) -> Vec<u8> {
    let mut bytes = Vec::new();
    for (kind, contents) in list {
        let padding = contents.len().next_multiple_of(4) - contents.len();
        bytes.extend(((contents.len() + padding) as u32).to_le_bytes());
        bytes.extend(*kind);
        bytes.extend(*contents);
        bytes.extend(&[b' '; 3][..padding]);
    }
    let mut glb = [b"glTF".as_slice(), &2_u32.to_le_bytes(), &(bytes.len() as u32 + 12).to_le_bytes()].concat();
    glb.extend(bytes);
    glb
}

/// Proves that chunks of unknown types are ignored wherever they stand behind the first one (glTF 2.0, section 4.4.3.1), and that a
/// chunk that reaches beyond the file is none.
#[test]
fn unknown_chunks_are_ignored() {
    let doc = Doc::square();
    let expected = doc.import().unwrap().sha256;
    let json = doc.json.to_string();
    let (json, bin): (Chunk<'_>, Chunk<'_>) = ((b"JSON", json.as_bytes()), (b"BIN\0", &doc.bin));
    let odd: Chunk<'_> = (b"XVIZ", &[7; 8]);
    for list in [&[json, bin, odd][..], &[json, odd, bin], &[json, odd, odd, bin, bin]] {
        assert_eq!(import_bytes(&chunks(list), None, "odd").unwrap().sha256, expected);
    }
    for list in [&[odd, json, bin][..], &[bin, json], &[]] {
        let error = import_bytes(&chunks(list), None, "odd").unwrap_err().to_string();
        assert!(error.contains("first chunk is no JSON"), "{error}");
    }
    let mut long = chunks(&[json, odd, bin]);
    let start = long.len() - doc.bin.len() - 8 - 16;
    long[start..start + 4].copy_from_slice(&200_u32.to_le_bytes());
    assert!(import_bytes(&long, None, "odd").unwrap_err().to_string().contains("beyond its end"));
}

/// Proves that a primitive without positions is left out with a word, and that one which has them is still read.
#[test]
fn primitives_without_positions_are_left_out() {
    let mut doc = Doc::square();
    let expected = doc.import().unwrap().sha256;
    let bare = json!({"attributes": {"_CUSTOM": 0}});
    doc.json["meshes"][0]["primitives"].as_array_mut().unwrap().splice(0..0, [bare.clone(), bare.clone()]);
    let scene = doc.import().unwrap();
    assert_eq!((scene.sha256, scene.notes.warnings.len()), (expected, 1));
    assert!(scene.notes.warnings[0].contains("meshes[0] without POSITION are left out (2)"), "{:?}", scene.notes);
    doc.json["meshes"][0]["primitives"] = json!([bare]);
    assert!(doc.error().contains("have no POSITION"), "{}", doc.error());
}

/// Proves that a stride of 0 is none, with a word, and that any other is what it says or is refused.
#[test]
fn strides_of_zero_are_none() {
    let mut doc = Doc::square();
    let expected = doc.import().unwrap().sha256;
    doc.json["bufferViews"][0]["byteStride"] = json!(0);
    let scene = doc.import().unwrap();
    assert_eq!(scene.sha256, expected);
    assert!(scene.notes.warnings.concat().contains("byteStride of 0") && scene.notes.warnings.len() == 1);
    doc.json["bufferViews"][0]["byteStride"] = json!(3);
    assert!(doc.error().contains("bufferViews[0].byteStride is 3, and must be a whole number from 4 to 252"));
}

/// Proves that whole numbers are read however they are written, with the same scene for it.
#[test]
fn whole_numbers_may_be_written_as_floats() {
    fn as_floats(value: &mut Value) {
        match value {
            Value::Number(number) => *value = json!(number.as_f64().unwrap()),
            Value::Array(values) => values.iter_mut().for_each(as_floats),
            Value::Object(object) => object.values_mut().for_each(as_floats),
            _ => {}
        }
    }
    let mut doc = moving();
    let at = |scene: &Scene| scene.animation.as_ref().unwrap().positions_at(0.5).unwrap();
    let expected = doc.import().unwrap();
    as_floats(&mut doc.json);
    assert!(doc.json.to_string().contains("5126.0"));
    let found = doc.import().unwrap();
    assert_eq!((&found.sha256, at(&found)), (&expected.sha256, at(&expected)));
}

/// A square that moves, has a material and a camera, and stands beside things that the scene does not use.
fn moving() -> Doc {
    let mut doc = Doc::square();
    doc.json["materials"] = json!([{"pbrMetallicRoughness": {"metallicFactor": 0.5}, "alphaMode": "MASK"}]);
    doc.json["meshes"][0]["primitives"][0]["material"] = json!(0);
    doc.json["cameras"] = json!([{"type": "perspective", "perspective": {"yfov": 0.7, "znear": 0.1}}]);
    doc.json["nodes"] = json!([{"mesh": 0, "children": [1]}, {"camera": 0, "name": "eye"}]);
    doc.channel(0, "translation", "LINEAR", &[0.0, 1.0], &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0]);
    doc
}

/// Proves of many fields that nothing here depends on that whatever stands there the scene is the same; the same values where
/// something does depend on them are refused.
#[test]
fn what_nothing_depends_on_refuses_no_file() {
    let expected = moving().import().unwrap();
    let odd = [json!("odd"), json!(-1), json!(1e300), json!(null), json!([7]), json!({"a": "b"})];
    let free = [
        ("/materials/0", "alphaMode"),
        ("/materials/0", "doubleSided"),
        ("/materials/0", "emissiveFactor"),
        ("/cameras/0", "type"),
        ("/cameras/0", "orthographic"),
        ("/cameras/0/perspective", "znear"),
        ("/cameras/0/perspective", "aspectRatio"),
        ("/cameras/0/perspective", "zfar"),
        ("/asset", "generator"),
        ("/asset", "extras"),
        ("/accessors/0", "min"),
        ("/accessors/0", "name"),
        ("/bufferViews/0", "target"),
        ("", "images"),
        ("", "textures"),
        ("", "extensions"),
        ("", "extensionsUsed"),
        ("/nodes/1", "skin"),
        ("/meshes/0/primitives/0/attributes", "NORMAL"),
        ("/buffers/0", "name"),
        ("/scenes/0", "extras"),
    ];
    for (place, key) in free {
        for value in &odd {
            let mut doc = moving();
            doc.json.pointer_mut(place).unwrap()[key] = value.clone();
            let found = doc.import().unwrap_or_else(|error| panic!("{place}/{key} = {value}: {error}"));
            assert_eq!((found.sha256, &found.cameras), (expected.sha256.clone(), &expected.cameras), "{place}/{key}");
        }
    }
    // Whole elements that the scene does not use, then used.
    for list in ["accessors", "bufferViews", "buffers", "cameras", "materials", "meshes", "nodes", "scenes", "skins"] {
        for value in &odd {
            let mut doc = moving();
            if list == "skins" {
                doc.json["skins"] = json!([]);
            }
            doc.push(list, value.clone());
            let found = doc.import().unwrap_or_else(|error| panic!("{list}: {value}: {error}")).mesh;
            let (mesh, materials) = (&expected.mesh, &expected.mesh.materials);
            assert_eq!((&found.positions, &found.triangles), (&mesh.positions, &mesh.triangles));
            assert_eq!(&found.materials[..materials.len()], &materials[..]);
            if list == "skins" {
                doc.json["nodes"][0]["skin"] = json!(0);
            }
            doc.json[list] = json!([value]);
            // A camera may lack everything, and so may a material.
            let may_be_empty = value.is_object() || list == "materials";
            assert!(may_be_empty || doc.import().is_err(), "{list}: {value}");
        }
    }
    let mut doc = moving();
    let sampler = json!({"input": 99, "output": 99, "interpolation": "BEZIER"});
    doc.json["animations"][0]["samplers"].as_array_mut().unwrap().insert(0, sampler);
    assert!(doc.import().unwrap_err().to_string().contains("animations[0].samplers[0]"));
    doc.json["animations"][0]["channels"][0]["sampler"] = json!(1);
    assert_eq!(doc.import().unwrap().sha256, expected.sha256);
}

/// Proves that what is wrong in the document is told with its JSON path, what is there, and what must be.
#[test]
fn errors_have_place_value_and_rule() {
    for (place, value, path, rule) in [
        ("/accessors/0/count", json!(3.5), "accessors[0].count", "a whole number"),
        ("/accessors/0/count", json!(-1), "accessors[0].count", "a whole number"),
        ("/accessors/0/count", json!("4"), "accessors[0].count", "a whole number"),
        ("/accessors/0/componentType", json!(5127), "accessors[0].componentType", "one of [5120,"),
        ("/accessors/0/type", json!("VEC9"), "accessors[0].type", "\"VEC3\""),
        (
            "/accessors/0/bufferView",
            json!(9),
            "accessors[0].bufferView",
            "an index into bufferViews, of which there are 4",
        ),
        ("/bufferViews/0/buffer", json!(1), "bufferViews[0].buffer", "an index into buffers, of which there are 1"),
        ("/meshes/0/primitives/0/mode", json!(7), "meshes[0].primitives[0].mode", "one of [0,"),
        ("/meshes/0/primitives/0/indices", json!(0.5), "meshes[0].primitives[0].indices", "an index into accessors"),
        (
            "/meshes/0/primitives/0/attributes/POSITION",
            json!(4_294_967_296_u64),
            "meshes[0].primitives[0].attributes.POSITION",
            "an index into accessors, of which there are 4",
        ),
        ("/meshes/0/primitives", json!({"a": 1}), "meshes[0].primitives", "schema"),
        ("/nodes/0/children/0", json!(2), "nodes[0].children[0]", "an index into nodes, of which there are 2"),
        ("/nodes/0/mesh", json!(1), "nodes[0].mesh", "an index into meshes, of which there are 1"),
        ("/nodes/0/name", json!([]), "", ""),
        ("/scene", json!(3), "scene", "an index into scenes, of which there are 1"),
        ("/cameras/0/perspective/yfov", json!("wide"), "cameras[0].perspective.yfov", "schema"),
        ("/materials/0/pbrMetallicRoughness/metallicFactor", json!([]), "metallicFactor", "schema"),
        (
            "/animations/0/samplers/0/interpolation",
            json!("BEZIER"),
            "animations[0].samplers[0].interpolation",
            "LINEAR",
        ),
        ("/animations/0/channels/0/sampler", json!(1), "animations[0].channels[0].sampler", "of which there are 1"),
        ("/animations/0/channels/0/target/node", json!(2), "animations[0].channels[0].target.node", "into nodes"),
    ] {
        let mut doc = moving();
        doc.json["nodes"][0]["name"] = json!("square");
        doc.json["meshes"][0]["primitives"][0]["mode"] = json!(4);
        *doc.json.pointer_mut(place).unwrap() = value.clone();
        if path.is_empty() {
            assert!(doc.import().is_ok());
            continue;
        }
        let error = doc.error();
        for part in [format!("{path} is {value}, "), rule.to_owned()] {
            assert!(error.contains(&part), "{place} = {value}: {error}");
        }
    }
    // What is missing, and a long value.
    let mut doc = moving();
    doc.json["meshes"][0].as_object_mut().unwrap().remove("primitives");
    assert!(doc.error().contains("meshes[0] is {") && doc.error().contains("primitives"), "{}", doc.error());
    doc.json["nodes"][0]["matrix"] = json!(vec![0.125; 100]);
    doc.json["meshes"][0]["primitives"] = json!([]);
    let error = doc.error();
    assert!(error.contains("nodes[0].matrix") && error.len() < 250, "{error}");
    assert_eq!(SQUARE.len(), 4);
}
