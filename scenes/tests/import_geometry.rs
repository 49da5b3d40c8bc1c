//! Every form in which glTF may hold triangles comes out as the same triangles.
#![allow(missing_docs)]

use crate::support;

use serde_json::json;
use support::{Doc, SQUARE, facing, float_bytes, triangles};

fn square_area(doc: &Doc) -> f32 {
    let scene = doc.import().unwrap();
    triangles(&scene).iter().map(facing).sum::<f32>() / 2.0
}

/// Proves that indices of all three widths, and none at all, give the same square, all wound counter-clockwise.
#[test]
fn lists_of_any_index_width() {
    let expected = triangles(&Doc::square().import().unwrap());
    assert_eq!(expected, [[SQUARE[0], SQUARE[1], SQUARE[2]], [SQUARE[0], SQUARE[2], SQUARE[3]]]);
    for component in [5121, 5123, 5125] {
        let mut doc = Doc::new();
        let positions = doc.positions(&SQUARE);
        let indices = doc.indices(&[0, 1, 2, 0, 2, 3], component);
        doc.mesh(json!([{"attributes": {"POSITION": positions}, "indices": indices}]));
        assert_eq!(triangles(&doc.import().unwrap()), expected, "component type {component}");
    }
    let mut doc = Doc::new();
    let corners = [0, 1, 2, 0, 2, 3].map(|index: usize| SQUARE[index]);
    let positions = doc.positions(&corners);
    doc.mesh(json!([{"attributes": {"POSITION": positions}}]));
    let scene = doc.import().unwrap();
    assert_eq!(triangles(&scene), expected);
    assert_eq!(scene.name, "test");
    assert_eq!((scene.bounds_min, scene.bounds_max), ([0.0; 3], [1.0, 1.0, 0.0]));
    assert!((scene.diagonal() - 2f64.sqrt()).abs() < 1e-12);
}

/// Proves that strips alternate their winding and fans keep it: every triangle faces the same way.
#[test]
fn strips_and_fans_keep_their_winding() {
    let zigzag = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0], [0.0, 2.0, 0.0]];
    let ring = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0], [-1.0, 0.5, 0.0]];
    for (mode, points, area) in [(5, &zigzag, 1.5), (6, &ring, 1.5)] {
        for indexed in [false, true] {
            let mut doc = Doc::new();
            let positions = doc.positions(points);
            let mut primitive = json!({"attributes": {"POSITION": positions}, "mode": mode});
            if indexed {
                primitive["indices"] = json!(doc.indices(&[0, 1, 2, 3, 4], 5121));
            }
            doc.mesh(json!([primitive]));
            let scene = doc.import().unwrap();
            assert_eq!(scene.mesh.triangles.len(), 3, "mode {mode}");
            assert!(triangles(&scene).iter().all(|triangle| facing(triangle) > 0.0), "mode {mode}");
            assert_eq!(square_area(&doc), area, "mode {mode}");
        }
    }
}

/// Proves that a stride is honoured: the bytes between positions would be wild if they were read.
#[test]
fn interleaved_positions() {
    let mut bytes = Vec::new();
    for position in SQUARE {
        bytes.extend([0xff; 8]);
        bytes.extend(float_bytes(&[position]));
    }
    let mut doc = Doc::new();
    let view = doc.view(&bytes, Some(20));
    let positions = doc.push(
        "accessors",
        json!({"bufferView": view, "byteOffset": 8, "componentType": 5126, "type": "VEC3", "count": 4}),
    );
    let indices = doc.indices(&[0, 1, 2, 0, 2, 3], 5123);
    doc.mesh(json!([{"attributes": {"POSITION": positions}, "indices": indices}]));
    assert_eq!(square_area(&doc), 1.0);
}

/// Proves that parents act on children, and translation, rotation and scale in glTF's order.
#[test]
fn nested_transforms() {
    let mut doc = Doc::square();
    let half = std::f32::consts::FRAC_1_SQRT_2;
    doc.json["nodes"] = json!([
        {"children": [1], "translation": [10.0, 0.0, 0.0], "scale": [2.0, 2.0, 2.0]},
        // A quarter turn about z, then one unit along x before it.
        {"children": [2], "rotation": [0.0, 0.0, half, half]},
        {"mesh": 0, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 1, 0, 0, 1]},
    ]);
    let scene = doc.import().unwrap();
    let expected = [[10.0, 2.0, 0.0], [10.0, 4.0, 0.0], [8.0, 4.0, 0.0], [8.0, 2.0, 0.0]];
    for (got, wanted) in scene.mesh.positions.iter().zip(expected) {
        for axis in 0..3 {
            assert!((got[axis] - wanted[axis]).abs() < 1e-5, "{got:?} for {wanted:?}");
        }
    }
}

/// Proves that a mirroring transform turns the winding over, and that one that mirrors twice does not.
#[test]
fn mirrored_transforms_keep_the_outside_outside() {
    for (scale, sign) in [([-1.0, 1.0, 1.0], 1.0), ([-1.0, -1.0, 1.0], 1.0), ([1.0, 1.0, -1.0], -1.0)] {
        let mut doc = Doc::square();
        doc.json["nodes"][0]["scale"] = json!(scale);
        // The square faces +z; mirrored along x it must face +z still, mirrored along z it must face -z.
        assert_eq!(square_area(&doc), sign, "{scale:?}");
    }
}

/// Proves that primitives keep their own material, and one without gets the default.
#[test]
fn many_primitives_and_materials() {
    let mut doc = Doc::new();
    let positions = doc.positions(&SQUARE);
    let first = doc.indices(&[0, 1, 2], 5123);
    let second = doc.indices(&[0, 2, 3], 5125);
    doc.mesh(json!([
        {"attributes": {"POSITION": positions}, "indices": first, "material": 1},
        {"attributes": {"POSITION": positions}, "indices": second},
    ]));
    doc.json["materials"] = json!([
        {"name": "unused", "alphaMode": "MASK"},
        {"pbrMetallicRoughness": {
            "baseColorFactor": [0.25, 0.5, 0.75, 1.0], "metallicFactor": 1.0, "roughnessFactor": 0.05,
            "baseColorTexture": {"index": 77}}},
        {"extensions": {"KHR_materials_pbrSpecularGlossiness": {
            "diffuseFactor": [0.1, 0.2, 0.3, 1.0], "glossinessFactor": 0.75}}},
        {"extensions": {"KHR_materials_transmission": {"transmissionFactor": 0.9}, "KHR_materials_ior": {"ior": 1.25}}},
        {"extensions": {"KHR_materials_transmission": {"transmissionFactor": 1.0, "transmissionTexture": {"index": 77}}}},
        {"extensions": {"KHR_materials_transmission": {"transmissionFactor": 0.25}, "KHR_materials_ior": {"ior": 1.25}}},
    ]);
    let scene = doc.import().unwrap();
    assert_eq!(scene.mesh.triangle_materials, [1, 6]);
    assert_eq!(scene.mesh.materials.len(), 7);
    let indices: Vec<_> = scene.mesh.materials.iter().map(|material| material.refractive_index).collect();
    assert_eq!(indices, [None, None, None, Some(1.25), Some(1.5), None, None]);
    assert_eq!(scene.mesh.materials[1].base_color, [0.25, 0.5, 0.75]);
    assert!(scene.mesh.materials[1].is_mirror());
    assert!(!scene.mesh.materials[6].is_mirror());
    assert_eq!(scene.mesh.materials[2].base_color, [0.1, 0.2, 0.3]);
    assert_eq!(scene.mesh.materials[2].roughness, 0.25);
    assert!(scene.notes.warnings.iter().any(|warning| warning.contains("alpha masks are ignored")));
    // Each primitive keeps only the three vertices that it uses.
    assert_eq!(scene.mesh.positions.len(), 6);
}

/// Proves that sparse accessors replace elements, over data and over zeros.
#[test]
fn sparse_positions() {
    for over_data in [true, false] {
        let mut doc = Doc::new();
        let base = doc.view(&float_bytes(&SQUARE), None);
        let indices = doc.view(&[1, 0, 2, 0, 3, 0], None);
        let values = doc.view(&float_bytes(&[[2.0, 0.0, 0.0], [2.0, 1.0, 0.0], [0.0, 1.0, 0.0]]), None);
        let mut accessor = json!({
            "componentType": 5126, "type": "VEC3", "count": 4,
            "sparse": {"count": 3, "indices": {"bufferView": indices, "componentType": 5123},
                       "values": {"bufferView": values}},
        });
        if over_data {
            accessor["bufferView"] = json!(base);
        }
        let positions = doc.push("accessors", accessor);
        let list = doc.indices(&[0, 1, 2, 0, 2, 3], 5123);
        doc.mesh(json!([{"attributes": {"POSITION": positions}, "indices": list}]));
        assert_eq!(square_area(&doc), 2.0);
    }
}

/// Proves that integer positions are read as they are and, if normalised, as shares of their range.
#[test]
fn quantized_positions() {
    for (component, bytes, normalized, area) in [
        (5121, vec![0, 0, 0, 0, 255, 0, 0, 0, 255, 255, 0, 0], true, 0.5),
        (5121, vec![0, 0, 0, 0, 2, 0, 0, 0, 2, 2, 0, 0], false, 2.0),
        (5120, vec![0x80, 0, 0, 0, 127, 0, 0, 0, 127, 127, 0, 0], true, 1.0),
        (5120, vec![0xff, 0, 0, 0, 1, 0, 0, 0, 1, 2, 0, 0], false, 2.0),
        (5122, [0i16, 0, 0, 0, 32767, 0, 0, 0, 32767, 32767, 0, 0].map(i16::to_le_bytes).concat(), true, 0.5),
        (5123, [0u16, 0, 0, 0, 300, 0, 0, 0, 300, 2, 0, 0].map(u16::to_le_bytes).concat(), false, 300.0),
    ] {
        let mut doc = Doc::new();
        let view = doc.view(&bytes, Some(bytes.len() / 3));
        let positions = doc.push(
            "accessors",
            json!({"bufferView": view, "componentType": component, "normalized": normalized, "type": "VEC3", "count": 3}),
        );
        doc.mesh(json!([{"attributes": {"POSITION": positions}}]));
        doc.json["extensionsUsed"] = json!(["KHR_mesh_quantization"]);
        doc.json["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
        assert_eq!(square_area(&doc), area, "component type {component}, normalised {normalized}");
    }
}

/// Proves the rule for degenerate and duplicate triangles, and that only used vertices are kept.
#[test]
fn degenerate_and_duplicate_triangles() {
    let mut doc = Doc::new();
    let positions = doc.positions(&[SQUARE[0], SQUARE[1], SQUARE[2], SQUARE[0], [2.0, 0.0, 0.0], [f32::NAN; 3]]);
    let list = doc.indices(
        &[
            0, 1, 2, // kept
            2, 3, 1, // the same positions in another order: kept and counted
            0, 0, 2, // repeated index
            0, 3, 2, // identical positions
            0, 1, 4, // on one line
        ],
        5123,
    );
    doc.mesh(json!([{"attributes": {"POSITION": positions}, "indices": list}]));
    let scene = doc.import().unwrap();
    assert_eq!(scene.mesh.triangles.len(), 2);
    assert_eq!(scene.notes.zero_area_triangles_dropped, 3);
    assert_eq!(scene.notes.duplicate_triangles_kept, 1);
    assert_eq!(scene.mesh.positions.len(), 4);
}

/// Proves that points and lines are counted, and corners beyond the last triangle left out with a word.
#[test]
fn what_is_no_triangle_is_told() {
    let mut doc = Doc::square();
    let positions = 0;
    let five = doc.indices(&[0, 1, 2, 0, 2], 5123);
    doc.json["meshes"][0]["primitives"] = json!([
        {"attributes": {"POSITION": positions}, "mode": 0},
        {"attributes": {"POSITION": positions}, "mode": 1},
        {"attributes": {"POSITION": positions}, "indices": five},
    ]);
    let scene = doc.import().unwrap();
    assert_eq!(scene.mesh.triangles.len(), 1);
    assert_eq!(scene.notes.skipped_primitives, 2);
    assert!(scene.notes.warnings.iter().any(|warning| warning.contains("no whole number of triangles")));
}

/// Proves which scene is taken: the default, else the first, else all nodes without a parent.
#[test]
fn choice_of_scene() {
    let mut doc = Doc::square();
    doc.json["nodes"] = json!([{"mesh": 0}, {"mesh": 0, "children": [2]}, {"mesh": 0}]);
    doc.json["scenes"] = json!([{"nodes": [0]}, {"nodes": [1]}]);
    for (scene, count) in [(json!(1), 4), (json!(0), 2), (json!(null), 2)] {
        doc.json["scene"] = scene;
        assert_eq!(doc.import().unwrap().mesh.triangles.len(), count);
    }
    doc.json.as_object_mut().unwrap().remove("scenes");
    assert_eq!(doc.import().unwrap().mesh.triangles.len(), 6);
}

/// Proves that a scene of which f32 keeps few steps, since it is far from the origin for its size, says how many and what to do, and that
/// one which is as far but larger, or as small but near, says nothing.
#[test]
fn far_scenes_say_what_is_left_of_them() {
    for (scale, offset, steps) in
        [(1.0_f32, 1e7_f32, Some("keep only 1 steps")), (1.0, 0.0, None), (1e6, 1e7, None), (1e-6, 0.0, None)]
    {
        let mut doc = Doc::new();
        let square = SQUARE.map(|corner| corner.map(|at| at * scale + offset));
        let positions = doc.positions(&square);
        let indices = doc.indices(&[0, 1, 2, 0, 2, 3], 5121);
        doc.mesh(json!([{"attributes": {"POSITION": positions}, "indices": indices}]));
        let warnings = doc.import().unwrap().notes.warnings;
        match steps {
            Some(steps) => {
                assert!(warnings[0].contains(steps) && warnings[0].contains("towards the origin"), "{warnings:?}");
            }
            None => assert_eq!(warnings, Vec::<String>::new(), "{scale} {offset}"),
        }
    }
}
