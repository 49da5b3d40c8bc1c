//! Skins and morph targets against positions worked out by hand.
#![allow(missing_docs)]

use crate::support;

use serde_json::{Value, json};
use support::motion::{at, far, same};
use support::{Doc, SQUARE, facing, float_bytes, triangles};

/// A strip of two quads up the y axis, from 0 over 1 to 2, one unit wide.
const STRIP: [[f32; 3]; 6] =
    [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0], [0.0, 2.0, 0.0], [1.0, 2.0, 0.0]];

/// Moves the origin down by `y`, as columns.
fn down(y: f32) -> [f32; 16] {
    [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, -y, 0.0, 1.0]
}

/// An arm: [`STRIP`] on joint 0 at the ground (node 1) and joint 1 at y = 1 (node 2, a child of node 1). The middle row
/// hangs on both by halves, the top on joint 1. Node 0 holds the mesh and stands far away, which must not matter.
fn arm() -> Doc {
    let mut doc = Doc::new();
    let positions = doc.positions(&STRIP);
    let joints = doc.joints(&[[0, 0, 0, 0], [0, 0, 0, 0], [0, 1, 0, 0], [0, 1, 0, 0], [1, 0, 0, 0], [1, 0, 0, 0]]);
    let (lower, both) = ([1.0, 0.0, 0.0, 0.0], [0.5, 0.5, 0.0, 0.0]);
    let weights = doc.floats("VEC4", &[lower, lower, both, both, lower, lower].concat());
    let matrices = doc.floats("MAT4", &[down(0.0), down(1.0)].concat());
    let primitive = json!({"attributes": {"POSITION": positions, "JOINTS_0": joints, "WEIGHTS_0": weights}, "mode": 5});
    doc.mesh(json!([primitive]));
    doc.json["skins"] = json!([{"joints": [1, 2], "inverseBindMatrices": matrices}]);
    doc.json["nodes"] = json!([
        {"mesh": 0, "skin": 0, "translation": [100.0, 0.0, 0.0], "scale": [-3.0, 1.0, 1.0]},
        {"children": [2]},
        {"translation": [0.0, 1.0, 0.0]},
    ]);
    doc.json["scenes"][0]["nodes"] = json!([0, 1]);
    doc
}

/// Joint 1 turns by a quarter about z within a second.
fn bending_arm() -> Doc {
    let mut doc = arm();
    let half = 0.5f32.sqrt();
    doc.channel(2, "rotation", "LINEAR", &[0.0, 1.0], &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, half, half]);
    doc
}

/// Proves a skin of two joints: bent by 90 degrees about (0, 1, 0), joint 1 takes (x, y) to (1 - y, 1 + x); the middle
/// row is the mean of that and where it was. Also proves that the mesh's own node does not count.
#[test]
fn two_joints_bent_by_a_right_angle() {
    let scene = bending_arm().import().unwrap();
    assert!(scene.notes.warnings.is_empty(), "{:?}", scene.notes.warnings);
    let rest = STRIP.map(|p| p.map(f64::from));
    same(&scene.mesh.positions, &rest);
    same(&at(&scene, 0.0), &rest);
    let bent = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.5, 1.5, 0.0], [-1.0, 1.0, 0.0], [-1.0, 2.0, 0.0]];
    same(&at(&scene, 1.0), &bent);
    assert!(far(&at(&scene, 1.0), &rest) > 0.9);
    // The mesh's node mirrors, and is ignored: the strip still faces +z.
    assert!(triangles(&scene).iter().all(|triangle| facing(triangle) > 0.0));
}

/// Proves that without an animation a skin is shown in the pose of its joints, and that a mirrored skeleton turns the
/// winding over.
#[test]
fn a_skin_without_animation() {
    let mut doc = arm();
    let half = 0.5f32.sqrt();
    doc.json["nodes"][2]["rotation"] = json!([0.0, 0.0, half, half]);
    let scene = doc.import().unwrap();
    assert!(scene.animation.is_none());
    assert_eq!(scene.mesh.positions[4].map(|x| x.round()), [-1.0, 1.0, 0.0]);
    let mut doc = arm();
    doc.json["nodes"][1]["scale"] = json!([-1.0, 1.0, 1.0]);
    let scene = doc.import().unwrap();
    assert_eq!((scene.bounds_min, scene.bounds_max), ([-1.0, 0.0, 0.0], [0.0, 2.0, 0.0]));
    assert!(triangles(&scene).iter().all(|triangle| facing(triangle) > 0.0));
}

/// Proves that weights may be normalised integers in further sets, need not sum to 1, and that without inverse bind
/// matrices a joint is bound at its origin.
#[test]
fn weights_of_any_form() {
    let expected = at(&bending_arm().import().unwrap(), 1.0);
    // The same influences, in two sets: joint 0 in the first, joint 1 in the second, as u8 and u16 of any sum.
    let mut doc = bending_arm();
    let joints = doc.joints(&[[1, 0, 0, 0]; 6]);
    let first: Vec<u8> = [200u8, 200, 50, 50, 0, 0].iter().flat_map(|&weight| [weight, 0, 0, 0]).collect();
    let second: Vec<u8> = [0u16, 0, 12850, 12850, 65535, 65535]
        .iter()
        .flat_map(|&weight| [weight, 0, 0, 0])
        .flat_map(u16::to_le_bytes)
        .collect();
    for (set, bytes, component) in [(0, first, 5121), (1, second, 5123)] {
        let view = doc.view(&bytes, None);
        let accessor = doc.push(
            "accessors",
            json!({"bufferView": view, "componentType": component, "normalized": true, "type": "VEC4", "count": 6}),
        );
        doc.json["meshes"][0]["primitives"][0]["attributes"][format!("WEIGHTS_{set}")] = json!(accessor);
    }
    doc.json["meshes"][0]["primitives"][0]["attributes"]["JOINTS_1"] = json!(joints);
    let scene = doc.import().unwrap();
    let expected: Vec<[f64; 3]> = expected.iter().map(|p| p.map(f64::from)).collect();
    // 50 / 255 is exactly 12850 / 65535, so halves stay halves.
    same(&at(&scene, 1.0), &expected);

    let mut doc = bending_arm();
    doc.json["skins"][0].as_object_mut().unwrap().remove("inverseBindMatrices");
    let scene = doc.import().unwrap();
    assert_eq!(scene.mesh.positions[4], [0.0, 3.0, 0.0], "the joint's height comes on top");
}

/// Proves the rule for vertices without any weight: they follow their first joint, with a word.
#[test]
fn vertices_without_weight() {
    let mut doc = bending_arm();
    let weights = doc.floats("VEC4", &[0.0; 24]);
    doc.json["meshes"][0]["primitives"][0]["attributes"]["WEIGHTS_0"] = json!(weights);
    let scene = doc.import().unwrap();
    assert!(scene.notes.warnings[0].contains("no weight") && scene.notes.warnings[0].contains("(6)"));
    let bent = at(&scene, 1.0);
    assert_eq!(bent[2], [0.0, 1.0, 0.0]);
    assert_eq!(bent[4].map(|x| x.round()), [-1.0, 1.0, 0.0]);
}

/// Proves that skins that are wrong are refused with the reason.
#[test]
fn bad_skins() {
    for (pointer, value, part) in [
        ("/skins/0/joints", json!([1]), "follows joint 1, and its skin has 1"),
        ("/skins/0/joints", json!([]), "no joints"),
        ("/skins/0/joints", json!(vec![1; 1_000_001]), "more than 1000000 joints"),
        ("/skins/0/joints", json!([1, 9]), "export"),
        ("/skins/0/joints", json!([1, 1u64 << 32]), "an index into nodes"),
        ("/skins/0/joints", json!([1, 2, 2]), "3 joints and 2 inverse bind matrices"),
        ("/skins/0/inverseBindMatrices", json!(0), "not matrices"),
        ("/skins/0/inverseBindMatrices", json!(99), "export"),
        ("/nodes/0/skin", json!(1), "export"),
        ("/scenes/0/nodes", json!([0]), "not part of the scene"),
        ("/meshes/0/primitives/0/attributes/JOINTS_0", json!(0), "not joints"),
        ("/meshes/0/primitives/0/attributes/JOINTS_0", json!(1u64 << 32), "an index into accessors"),
        ("/meshes/0/primitives/0/attributes/WEIGHTS_0", json!(0), "not weights"),
        ("/accessors/1/count", json!(5), "JOINTS_0 has 5 elements for 6 vertices"),
        ("/accessors/2/count", json!(5), "WEIGHTS_0 has 5 elements for 6 vertices"),
    ] {
        let mut doc = arm();
        *doc.json.pointer_mut(pointer).unwrap() = value.clone();
        assert!(doc.error().contains(part), "{pointer}: {}", doc.error());
    }
    for missing in ["JOINTS_0", "WEIGHTS_0"] {
        let mut doc = arm();
        doc.json["meshes"][0]["primitives"][0]["attributes"].as_object_mut().unwrap().remove(missing);
        assert!(doc.error().contains("they come together"), "{}", doc.error());
    }
    let mut doc = arm();
    doc.json["meshes"][0]["primitives"][0]["attributes"] = json!({"POSITION": 0});
    assert!(doc.error().contains("no JOINTS_0"), "{}", doc.error());
    for weight in [f32::NAN, f32::INFINITY, -0.25] {
        let mut doc = arm();
        let mut all = [0.25f32; 24];
        all[17] = weight;
        let weights = doc.floats("VEC4", &all);
        doc.json["meshes"][0]["primitives"][0]["attributes"]["WEIGHTS_0"] = json!(weights);
        assert!(doc.error().contains("vertex 4 has a weight of"), "{}", doc.error());
    }
    let mut doc = arm();
    let mut matrices = [down(0.0), down(1.0)].concat();
    matrices[20] = f32::NAN;
    let matrices = doc.floats("MAT4", &matrices);
    doc.json["skins"][0]["inverseBindMatrices"] = json!(matrices);
    assert!(doc.error().contains("inverse bind matrix of joints[1] is not finite"), "{}", doc.error());
}

/// The square with two morph targets: one lifts its last two corners by 2, the other, sparse, moves corner 1 by 4.
fn morphing(weights: Value) -> Doc {
    let mut doc = Doc::square();
    let lift = doc.positions(&[[0.0; 3], [0.0; 3], [0.0, 0.0, 2.0], [0.0, 0.0, 2.0]]);
    let at = doc.view(&[1, 0, 0, 0], None);
    let by = doc.view(&float_bytes(&[[4.0, 0.0, 0.0]]), None);
    let pull = doc.push(
        "accessors",
        json!({"componentType": 5126, "type": "VEC3", "count": 4, "sparse": {
            "count": 1, "indices": {"bufferView": at, "componentType": 5121}, "values": {"bufferView": by}}}),
    );
    doc.json["meshes"][0]["primitives"][0]["targets"] = json!([{"POSITION": lift, "NORMAL": 77}, {"POSITION": pull}]);
    doc.json["meshes"][0]["weights"] = weights;
    doc
}

fn morphed(lift: f64, pull: f64) -> Vec<[f64; 3]> {
    let mut wanted: Vec<[f64; 3]> = SQUARE.iter().map(|corner| corner.map(f64::from)).collect();
    wanted[1][0] += 4.0 * pull;
    wanted[2][2] += 2.0 * lift;
    wanted[3][2] += 2.0 * lift;
    wanted
}

/// Proves that weights at rest displace: those of the mesh, those of the node before them, none as zero.
#[test]
fn morph_targets_at_rest() {
    let mut doc = morphing(json!([0.5, 0.0]));
    same(&doc.import().unwrap().mesh.positions, &morphed(0.5, 0.0));
    doc.json["nodes"][0]["weights"] = json!([-1.0, 0.25]);
    let scene = doc.import().unwrap();
    same(&scene.mesh.positions, &morphed(-1.0, 0.25));
    assert!(scene.animation.is_none() && scene.notes.warnings.is_empty(), "{:?}", scene.notes.warnings);
    same(&morphing(json!([])).import().unwrap().mesh.positions, &morphed(0.0, 0.0));
}

/// Proves that animated weights take the place of those at rest, for every interpolation, and come before the node's
/// transform. The spline's midpoint: 1/2 + 2 s * 1/8 * 2 a second = 1 for the first weight.
#[test]
fn morph_targets_over_time() {
    let mut doc = morphing(json!([9.0, 9.0]));
    doc.channel(0, "weights", "LINEAR", &[0.0, 2.0], &[0.0, 1.0, 1.0, 0.0]);
    let scene = doc.import().unwrap();
    for (time, lift, pull) in [(0.0, 0.0, 1.0), (0.5, 0.25, 0.75), (1.0, 0.5, 0.5), (2.0, 1.0, 0.0), (3.0, 1.0, 0.0)] {
        same(&at(&scene, time), &morphed(lift, pull));
    }
    let mut doc = morphing(json!([9.0, 9.0]));
    let spline = [[7.0, 7.0], [0.0, 0.0], [2.0, 0.0], [0.0, 0.0], [1.0, 0.0], [7.0, 7.0]].concat();
    doc.channel(0, "weights", "CUBICSPLINE", &[0.0, 2.0], &spline);
    doc.json["nodes"][0]["scale"] = json!([1.0, 1.0, 10.0]);
    let scene = doc.import().unwrap();
    same(&at(&scene, 1.0), &morphed(10.0, 0.0));
    let mut doc = morphing(json!(null));
    doc.channel(0, "weights", "STEP", &[0.0, 1.0], &[0.0, 0.0, 0.5, 0.0]);
    let scene = doc.import().unwrap();
    same(&at(&scene, 0.9), &morphed(0.0, 0.0));
    same(&at(&scene, 1.0), &morphed(0.5, 0.0));
}

/// Proves that a morphed shape goes through its skin: the arm's top is lifted by 1 before it is bent.
#[test]
fn morph_targets_before_skins() {
    let mut doc = bending_arm();
    let mut lift = [[0.0; 3]; 6];
    lift[4] = [0.0, 1.0, 0.0];
    let lift = doc.positions(&lift);
    doc.json["meshes"][0]["primitives"][0]["targets"] = json!([{"POSITION": lift}]);
    doc.json["nodes"][0]["weights"] = json!([1.0]);
    let scene = doc.import().unwrap();
    let bent = at(&scene, 1.0);
    // (0, 3) instead of (0, 2) goes to (1 - 3, 1 + 0).
    same(&bent[4..5].repeat(2), &[[-2.0, 1.0, 0.0]; 2]);
}

/// Proves that morph targets that are wrong are refused, and that weights without targets are told.
#[test]
fn bad_morph_targets() {
    let mut doc = morphing(json!([0.5, 0.0]));
    doc.json["accessors"][2]["count"] = json!(3);
    assert!(doc.error().contains("morph target 0 has 3 elements for 4 vertices"), "{}", doc.error());
    let doc = morphing(json!([1e39, 0.0]));
    assert!(doc.error().contains("not finite"), "{}", doc.error());
    let mut doc = morphing(json!([0.5, 0.0]));
    doc.json["meshes"][0]["primitives"][0]["targets"][0]["POSITION"] = json!(1u64 << 32);
    assert!(doc.error().contains("an index into accessors"), "{}", doc.error());
    let mut doc = morphing(json!([0.5, 0.0]));
    doc.channel(0, "weights", "LINEAR", &[0.0, 1.0], &[0.0; 2]);
    assert!(doc.error().contains("do not go together"), "{}", doc.error());
    let mut doc = morphing(json!([0.5, 0.0]));
    let primitive = doc.json["meshes"][0]["primitives"][0].clone();
    let mut fewer = primitive.clone();
    fewer["targets"].as_array_mut().unwrap().pop();
    doc.json["meshes"][0]["primitives"] = json!([primitive, fewer]);
    assert!(doc.import().is_ok());
    doc.channel(0, "weights", "LINEAR", &[0.0, 1.0], &[0.0; 4]);
    assert!(doc.error().contains("different numbers of morph targets"), "{}", doc.error());
    let mut doc = Doc::square();
    doc.channel(0, "weights", "LINEAR", &[0.0, 1.0], &[0.0; 2]);
    assert!(doc.import().unwrap().notes.warnings[0].contains("no morph targets"));

    // A displacement that is not finite matters once it has a weight.
    let mut doc = Doc::square();
    let wild = doc.positions(&[[f32::NAN; 3]; 4]);
    doc.json["meshes"][0]["primitives"][0]["targets"] = json!([{"POSITION": wild}]);
    assert!(doc.import().is_ok());
    doc.channel(0, "weights", "LINEAR", &[0.0, 1.0], &[0.0, 1.0]);
    let scene = doc.import().unwrap();
    let error = scene.animation.unwrap().positions_at(0.5).unwrap_err().to_string();
    assert!(error.contains("at 0.5 s") && error.contains("morph targets"), "{error}");
}

/// Proves that small files cannot ask for work without end: targets and keys that share their bytes are counted.
#[test]
fn absurd_sharing_is_refused() {
    let mut doc = Doc::square();
    let flat = doc.push("accessors", json!({"componentType": 5126, "type": "VEC3", "count": 4}));
    doc.json["meshes"][0]["primitives"][0]["targets"] = json!(vec![json!({"POSITION": flat}); 10_000]);
    doc.json["nodes"] = json!(vec![json!({"mesh": 0}); 30_000]);
    doc.json["scenes"][0]["nodes"] = json!((0..30_000).collect::<Vec<_>>());
    assert!(doc.error().contains("at most 500000000"), "{}", doc.error());

    let mut doc = Doc::square();
    let times: Vec<f32> = (0..100_000).map(|key| key as f32).collect();
    doc.channel(0, "translation", "LINEAR", &times, &vec![0.0; 300_000]);
    let channel = doc.json["animations"][0]["channels"][0].clone();
    doc.json["animations"][0]["channels"] = json!(vec![channel; 1000]);
    assert!(doc.error().contains("more than 200000000"), "{}", doc.error());
}
