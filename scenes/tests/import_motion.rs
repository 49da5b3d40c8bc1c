//! Node animation: positions over time against numbers worked out by hand from the glTF specification.
#![allow(missing_docs)]

use crate::support;

use serde_json::json;
use support::motion::{at, far, same};
use support::{Doc, SQUARE, promises};

/// The square under a map of its corners.
fn square(map: impl Fn([f64; 3]) -> [f64; 3]) -> Vec<[f64; 3]> {
    SQUARE.iter().map(|corner| map(corner.map(f64::from))).collect()
}

fn shifted(by: [f64; 3]) -> Vec<[f64; 3]> {
    square(|p| [p[0] + by[0], p[1] + by[1], p[2] + by[2]])
}

/// Proves linear interpolation of translations, clamped before the first and after the last key, and that time 0 of the
/// animation is the mesh, whatever the node says.
#[test]
fn linear_translation_and_both_ends() {
    let mut doc = Doc::square();
    doc.json["nodes"][0]["translation"] = json!([9.0, 9.0, 9.0]);
    doc.channel(0, "translation", "LINEAR", &[1.0, 2.0, 4.0], &[1.0, 0.0, 0.0, 2.0, 0.0, 0.0, 2.0, 8.0, 0.0]);
    let mut scene = doc.import().unwrap();
    let animation = scene.animation.clone().unwrap();
    assert_eq!(animation.duration_s, 4.0);
    for (time, by) in [
        (0.0, [1.0, 0.0, 0.0]),
        (1.0, [1.0, 0.0, 0.0]),
        (1.25, [1.25, 0.0, 0.0]),
        (2.0, [2.0, 0.0, 0.0]),
        (2.5, [2.0, 2.0, 0.0]),
        (4.0, [2.0, 8.0, 0.0]),
        (1e9, [2.0, 8.0, 0.0]),
        (-1.0, [1.0, 0.0, 0.0]),
    ] {
        same(&at(&scene, time), &shifted(by));
    }
    assert!(animation.positions_at(f64::NAN).is_err());
    let (before, hash) = (scene.mesh.clone(), scene.sha256.clone());
    scene.set_time(0.0).unwrap();
    assert_eq!((&scene.mesh, &scene.sha256), (&before, &hash));
    scene.set_time(4.0).unwrap();
    assert_ne!(scene.sha256, hash);
    assert_eq!((scene.bounds_min, scene.bounds_max), ([2.0, 8.0, 0.0], [3.0, 9.0, 0.0]));
    assert_eq!(scene.mesh.triangles, before.triangles);
    assert!(scene.notes.warnings.is_empty(), "{:?}", scene.notes.warnings);
}

/// Proves that steps hold the earlier key up to the next one.
#[test]
fn step_holds() {
    let mut doc = Doc::square();
    doc.channel(0, "scale", "STEP", &[0.0, 1.0, 2.0], &[1.0, 1.0, 1.0, 3.0, 1.0, 1.0, 1.0, 5.0, 1.0]);
    let scene = doc.import().unwrap();
    for (time, scale) in
        [(0.0, [1.0, 1.0]), (0.999, [1.0, 1.0]), (1.0, [3.0, 1.0]), (1.5, [3.0, 1.0]), (2.0, [1.0, 5.0])]
    {
        same(&at(&scene, time), &square(|p| [p[0] * scale[0], p[1] * scale[1], p[2]]));
    }
}

/// Proves slerp: halfway to a quarter turn is an eighth, a third of the way 30 degrees; with the second key negated
/// (the same rotation) the short way is taken still. Mixing the four numbers in a straight line would give 28.9 degrees.
#[test]
fn slerp_turns_evenly_and_the_short_way() {
    let half = 0.5f32.sqrt();
    for sign in [1.0, -1.0] {
        let mut doc = Doc::square();
        let keys = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, sign * half, sign * half];
        doc.channel(0, "rotation", "LINEAR", &[0.0, 3.0], &keys);
        let scene = doc.import().unwrap();
        for (time, degrees) in [(0.0, 0.0f64), (1.0, 30.0), (1.5, 45.0), (3.0, 90.0)] {
            let (sine, cosine) = degrees.to_radians().sin_cos();
            let wanted = square(|p| [cosine * p[0] - sine * p[1], sine * p[0] + cosine * p[1], p[2]]);
            same(&at(&scene, time), &wanted);
        }
        let (sine, cosine) = 28.9f64.to_radians().sin_cos();
        let chord = square(|p| [cosine * p[0] - sine * p[1], sine * p[0] + cosine * p[1], p[2]]);
        assert!(far(&at(&scene, 1.0), &chord) > 1e-3);
    }
}

/// Proves that rotations given as normalised integers are read as shares, and that keys without length are no rotation.
#[test]
fn rotations_of_integers_and_of_nothing() {
    let mut doc = Doc::square();
    doc.channel(0, "rotation", "LINEAR", &[0.0, 1.0], &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0]);
    let scene = doc.import().unwrap();
    same(&at(&scene, 1.0), &square(|p| p));
    // A half turn about y.
    let bytes: Vec<u8> = [0i16, 0, 0, 32767, 0, 32767, 0, 0].iter().flat_map(|value| value.to_le_bytes()).collect();
    let view = doc.view(&bytes, None);
    let output = doc.push(
        "accessors",
        json!({"bufferView": view, "componentType": 5122, "normalized": true, "type": "VEC4", "count": 2}),
    );
    doc.json["animations"][0]["samplers"][0]["output"] = json!(output);
    let scene = doc.import().unwrap();
    same(&at(&scene, 1.0), &square(|p| [-p[0], p[1], -p[2]]));
    same(&at(&scene, 0.5), &square(|p| [p[2], p[1], -p[0]]));
}

/// Proves the cubic spline against the specification's formula worked out by hand: over a span of 2 s from 0 to 1 with
/// an out-tangent of 3 a second and an in-tangent of -1 a second, at a quarter
/// 0 + 2 * 9/64 * 3 + 10/64 * 1 + 2 * (-3/64) * -1 = 70/64, and at half 2 * 1/8 * 3 + 1/2 + 2 * (-1/8) * -1 = 1.5.
#[test]
fn cubic_spline() {
    let mut doc = Doc::square();
    let unused = [7.0, 7.0, 7.0];
    let keys = [unused, [0.0; 3], [3.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [1.0, 0.0, 0.0], unused].concat();
    doc.channel(0, "translation", "CUBICSPLINE", &[1.0, 3.0], &keys);
    let scene = doc.import().unwrap();
    for (time, x) in [(0.5, 0.0), (1.0, 0.0), (1.5, 70.0 / 64.0), (2.0, 1.5), (3.0, 1.0), (3.5, 1.0)] {
        same(&at(&scene, time), &shifted([x, 0.0, 0.0]));
    }
    // Linear interpolation of the same values is something else.
    assert!(far(&at(&scene, 1.5), &shifted([0.25, 0.0, 0.0])) > 0.5);
}

/// Proves that a spline of rotations is brought to unit length: no scale comes of it. Halfway from 0 to a quarter turn
/// with flat tangents the mean of the two quaternions is an eighth of a turn, of length 0.92.
#[test]
fn cubic_spline_of_rotations_has_unit_length() {
    let mut doc = Doc::square();
    let half = 0.5f32.sqrt();
    let keys = [[0.0; 4], [0.0, 0.0, 0.0, 1.0], [0.0; 4], [0.0; 4], [0.0, 0.0, half, half], [0.0; 4]].concat();
    doc.channel(0, "rotation", "CUBICSPLINE", &[0.0, 2.0], &keys);
    let scene = doc.import().unwrap();
    let h = 0.5f64.sqrt();
    same(&at(&scene, 1.0), &square(|p| [h * (p[0] - p[1]), h * (p[0] + p[1]), p[2]]));
}

/// Proves that channels act in the order of translation, rotation, scale, that a parent carries its children, and that
/// properties without a channel keep their rest values.
#[test]
fn properties_and_parents_combine() {
    let mut doc = Doc::square();
    let half = 0.5f32.sqrt();
    doc.json["nodes"] = json!([
        {"children": [1], "scale": [2.0, 2.0, 2.0]},
        {"mesh": 0, "scale": [1.0, 3.0, 1.0]},
    ]);
    doc.channel(0, "translation", "LINEAR", &[0.0, 2.0], &[0.0, 0.0, 0.0, 10.0, 0.0, 0.0]);
    doc.channel(1, "rotation", "LINEAR", &[0.0, 1.0], &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, half, half]);
    let scene = doc.import().unwrap();
    // At 1 s: scaled by 3 along y, turned a quarter about z, doubled, moved by 5.
    same(&at(&scene, 1.0), &square(|p| [5.0 - 2.0 * 3.0 * p[1], 2.0 * p[0], 2.0 * p[2]]));
    assert_eq!(scene.animation.unwrap().duration_s, 2.0);
}

/// Proves that triangles are left out by the times that are asked for: of two squares, one that grows from nothing and one that
/// shrinks to nothing, each is there when it has an area, both are where several times are asked for, and what is left out is told.
#[test]
fn triangles_are_those_of_the_times_asked_for() {
    let mut doc = Doc::square();
    doc.json["nodes"] = json!([{"mesh": 0}, {"mesh": 0}]);
    doc.json["scenes"][0]["nodes"] = json!([0, 1]);
    doc.channel(0, "scale", "LINEAR", &[0.0, 1.0], &[0.0, 0.0, 0.0, 1.0, 1.0, 1.0]);
    doc.channel(1, "scale", "LINEAR", &[0.0, 1.0], &[1.0, 1.0, 1.0, 0.0, 0.0, 0.0]);
    let mut scene = doc.import().unwrap();
    for (times, left, warning) in [
        (&[0.0][..], 2, "at 0 s 2 of 4 triangles have zero area and are left out, 1 objects whole"),
        (&[7.0], 2, "at 1 s 2 of 4"),
        (&[0.5], 4, ""),
        (&[1.0, 0.0], 4, ""),
        (&[1.0, 1.0], 2, "at each of 2 times 2 of 4"),
    ] {
        scene.drop_zero_area(times).unwrap();
        assert_eq!(scene.mesh.triangles.len(), left, "{times:?}");
        assert_eq!(scene.notes.zero_area_triangles_dropped as usize, 4 - left);
        let warnings = &scene.notes.warnings;
        assert!(warnings.len() == usize::from(left < 4) && warnings.concat().starts_with(warning), "{warnings:?}");
        promises::check_mesh(&scene).unwrap();
        // Those that are there keep their object, and stand where the first time puts them.
        let object = u32::from(times[0] == 0.0);
        let whole = |index: &usize| scene.mesh.triangle_objects[*index] == object;
        let corners = (0..left).filter(whole).flat_map(|index| scene.mesh.triangles[index]);
        let greatest = corners.map(|corner| scene.mesh.positions[corner as usize][0]).fold(0.0, f32::max);
        assert_eq!(greatest, if times[0] == 0.5 { 0.5 } else { 1.0 }, "{times:?}");
    }
    // What is left out at one time alone moves on as what is there.
    scene.drop_zero_area(&[0.0]).unwrap();
    same(&at(&scene, 0.5), &square(|p| p.map(|x| 0.5 * x)));
    same(&at(&scene, 1.0), &square(|_| [0.0; 3]));
    assert!(scene.set_time(1.0).unwrap_err().to_string().contains("at 1 s the scene's diagonal is 0"));
    // Where nothing has an area at the time, that is said; the file is none the worse for it.
    doc.json["scenes"][0]["nodes"] = json!([0]);
    let mut scene = doc.import().unwrap();
    let error = scene.drop_zero_area(&[0.0]).unwrap_err().to_string();
    assert!(error.contains("at 0 s all 2 triangles have zero area"), "{error}");
    scene.drop_zero_area(&[1.0]).unwrap();
    assert_eq!((scene.mesh.triangles.len(), scene.notes.warnings.len()), (2, 0));
}

/// Proves that of the scenes of the catalogue that move nothing is left out: their records stay what they are.
#[test]
fn the_catalogue_has_an_area_at_all_times() {
    for entry in tracebench_scenes::catalogue() {
        let mut scene = tracebench_scenes::procedural(entry.name, 0.05).unwrap();
        for time in [0.0, 0.37, 100.0] {
            let mut moved = scene.clone();
            moved.set_time(time).unwrap();
            scene.drop_zero_area(&[time]).unwrap();
            assert_eq!((&scene.sha256, scene.notes.warnings.len()), (&moved.sha256, 0), "{}", entry.name);
        }
    }
}

/// Proves what is said about what does not play, and that a camera stands where time 0 puts it.
#[test]
fn what_does_not_play_is_told() {
    let mut doc = Doc::square();
    doc.channel(0, "translation", "LINEAR", &[0.0, 1.0], &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0]);
    let pointer = json!({"sampler": 0, "target": {"path": "pointer", "extensions": {"KHR_animation_pointer": {}}}});
    doc.json["animations"][0]["channels"].as_array_mut().unwrap().push(pointer);
    doc.json["animations"][0]["channels"]
        .as_array_mut()
        .unwrap()
        .push(json!({"sampler": 0, "target": {"path": "scale"}}));
    doc.json["extensionsUsed"] = json!(["KHR_animation_pointer"]);
    let scene = doc.import().unwrap();
    assert_eq!(scene.notes.warnings.len(), 1, "{:?}", scene.notes.warnings);
    assert!(scene.notes.warnings[0].contains("(2)") && scene.notes.warnings[0].contains("KHR_animation_pointer"));
    same(&at(&scene, 0.5), &shifted([0.5, 0.0, 0.0]));
    // What only such channels need may be missing.
    doc.push("buffers", json!({"byteLength": 10, "uri": "nowhere.bin"}));
    let view = doc.push("bufferViews", json!({"buffer": 1, "byteLength": 10}));
    let lost = doc.push("accessors", json!({"bufferView": view, "componentType": 5126, "type": "SCALAR", "count": 2}));
    let samplers = doc.json["animations"][0]["samplers"].as_array_mut().unwrap();
    samplers.push(json!({"input": lost, "output": lost}));
    doc.json["animations"][0]["channels"][1]["sampler"] = json!(1);
    assert!(doc.import().is_ok());
    doc.json["animations"][0]["channels"][0]["sampler"] = json!(1);
    assert!(doc.error().contains("nowhere.bin"), "{}", doc.error());

    // A pose without length: it counts, and nothing moves.
    let mut doc = Doc::square();
    doc.channel(0, "translation", "LINEAR", &[0.0], &[4.0, 0.0, 0.0]);
    let scene = doc.import().unwrap();
    assert!(scene.animation.is_none());
    same(&scene.mesh.positions, &shifted([4.0, 0.0, 0.0]));
    assert!(scene.notes.warnings[0].contains("no length"));

    // A camera that moves alone.
    let mut doc = Doc::square();
    doc.json["cameras"] = json!([{"type": "perspective", "perspective": {"yfov": 0.75, "znear": 0.1}}]);
    doc.json["nodes"] = json!([{"mesh": 0}, {"camera": 0}]);
    doc.json["scenes"][0]["nodes"] = json!([0, 1]);
    doc.channel(1, "translation", "LINEAR", &[0.0, 1.0], &[0.0, 0.0, 6.0, 0.0, 0.0, 9.0]);
    let scene = doc.import().unwrap();
    assert!(scene.animation.is_none());
    assert!(scene.notes.warnings[0].contains("moves no triangles"));
    assert_eq!(scene.cameras[0].eye, [0.0, 0.0, 6.0]);
}

/// Proves that a path out of the numbers is an error of its time, and that other times are none.
#[test]
fn too_far_at_a_later_time() {
    let mut doc = Doc::square();
    doc.channel(0, "translation", "LINEAR", &[0.0, 1.0], &[0.0, 0.0, 0.0, 1e16, 0.0, 0.0]);
    let mut scene = doc.import().unwrap();
    assert!(scene.set_time(0.01).is_ok());
    let error = scene.set_time(1.0).unwrap_err();
    assert!(!error.is_argument());
    for part in ["test: at 1 s: meshes[0].primitives[0] ('thing') vertex", "scale the scene down"] {
        assert!(error.to_string().contains(part), "{error}");
    }
    assert_eq!(scene.time_s, 0.01, "a failed move leaves the scene as it was");
    // Finite keys whose spline overflows.
    let mut doc = Doc::square();
    let keys = [[0.0; 3], [0.0; 3], [f32::MAX; 3], [0.0; 3], [0.0; 3], [0.0; 3]].concat();
    doc.channel(0, "translation", "CUBICSPLINE", &[0.0, f32::MAX], &keys);
    let scene = doc.import().unwrap();
    assert!(scene.animation.unwrap().positions_at(1e38).is_err());
}

/// Proves that keys that are wrong are refused with the reason.
#[test]
fn bad_keys() {
    type Case<'a> = (&'a str, &'a str, &'a [f32], &'a [f32], &'a str);
    let (nan, infinite) = (f32::NAN, f32::INFINITY);
    let cases: [Case<'_>; 11] = [
        ("translation", "LINEAR", &[0.0, 1.0], &[0.0; 3], "2 keys and 1 values"),
        ("translation", "LINEAR", &[0.0], &[0.0; 6], "1 keys and 2 values"),
        ("translation", "CUBICSPLINE", &[0.0, 1.0], &[0.0; 6], "2 keys and 2 values"),
        ("translation", "LINEAR", &[], &[], "no keys"),
        ("translation", "LINEAR", &[0.0, 0.0], &[0.0; 6], "key 1 is at 0 s, not later"),
        ("translation", "LINEAR", &[1.0, 0.5], &[0.0; 6], "key 1 is at 0.5 s, not later"),
        ("translation", "LINEAR", &[-1.0, 0.5], &[0.0; 6], "not negative"),
        ("translation", "LINEAR", &[0.0, nan], &[0.0; 6], "finite"),
        ("translation", "LINEAR", &[0.0, infinite], &[0.0; 6], "finite"),
        ("rotation", "LINEAR", &[0.0], &[0.0, nan, 0.0, 0.0], "number 1 of its values is NaN"),
        ("scale", "CUBIC", &[0.0], &[1.0; 3], "must be one of"),
    ];
    for (path, interpolation, times, values, part) in cases {
        let mut doc = Doc::square();
        doc.channel(0, path, interpolation, times, values);
        assert!(doc.error().contains(part), "{}", doc.error());
    }
    let mut sound = Doc::square();
    sound.channel(0, "translation", "LINEAR", &[0.0, 1.0], &[0.0; 6]);
    assert!(sound.import().is_ok());
    let mut doc = Doc::square();
    doc.json["nodes"][0]["matrix"] = json!([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]);
    doc.channel(0, "translation", "LINEAR", &[0.0], &[0.0; 3]);
    assert!(doc.error().contains("has a matrix"), "{}", doc.error());
    for (pointer, value) in [
        ("/animations/0/channels/0/sampler", json!(7)),
        ("/animations/0/channels/0/sampler", json!(1u64 << 32)),
        ("/animations/0/channels/0/target/node", json!(7)),
        ("/animations/0/channels/0/target/node", json!(1u64 << 32)),
        ("/animations/0/channels/0/target", json!(3)),
        ("/animations/0/samplers/0/input", json!(7)),
        ("/animations/0/samplers/0/output", json!(1u64 << 32)),
        ("/animations/0/samplers/0/output", json!(0)),
    ] {
        let mut doc = Doc::square();
        doc.channel(0, "rotation", "LINEAR", &[0.0], &[0.0, 0.0, 0.0, 1.0]);
        *doc.json.pointer_mut(pointer).unwrap() = value.clone();
        assert!(doc.error().contains("export"), "{pointer} = {value}: {}", doc.error());
    }
}

/// Proves that the first camera that moves gives the path: by itself and by its parent, with its roll, clamped at both ends and at frame
/// times where glTF's interpolation has it; that cameras stand where time 0 puts them, and that without such a camera there is no path.
#[test]
fn a_camera_that_moves_gives_the_path() {
    let mut doc = Doc::square();
    let camera = json!({"type": "perspective", "perspective": {"yfov": 0.8, "znear": 0.1}});
    doc.json["cameras"] = json!([camera, camera]);
    let still = doc.push("nodes", json!({"camera": 0}));
    let parent = doc.push("nodes", json!({}));
    let moving = doc.push("nodes", json!({"camera": 1}));
    doc.json["nodes"][parent]["children"] = json!([moving]);
    doc.json["scenes"] = json!([{"nodes": [0, still, parent]}]);
    doc.json["scene"] = json!(0);
    assert!(doc.import().unwrap().camera_path.is_none());
    doc.channel(parent, "translation", "LINEAR", &[0.0, 2.0], &[0.0, 0.0, 5.0, 4.0, 0.0, 5.0]);
    let half = 0.5f32.sqrt();
    // A quarter turn about the line of sight.
    doc.channel(moving, "rotation", "LINEAR", &[0.0, 1.0], &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, half, half]);
    let scene = doc.import().unwrap();
    assert!(scene.animation.is_none() && scene.cameras.len() == 2);
    assert_eq!(scene.cameras[1].eye, [0.0, 0.0, 5.0]);
    let path = scene.camera_path.unwrap();
    assert!((path.duration_s() - 2.0).abs() < 1e-6 && path.vertical_fov_radians == 0.8);
    for (time, x, degrees) in
        [(-1.0, 0.0, 0.0f32), (0.5, 1.0, 45.0), (1.0, 2.0, 90.0), (1.5, 3.0, 90.0), (9.0, 4.0, 90.0)]
    {
        let camera = path.at(time);
        let (sine, cosine) = degrees.to_radians().sin_cos();
        let off = |a: [f32; 3], b: [f32; 3]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(off(camera.eye, [x, 0.0, 5.0]) < 1e-6, "{camera:?}");
        assert!(off(camera.up, [-sine, cosine, 0.0]) < 1e-6, "{camera:?}");
        assert!(camera.target[2] < 5.0 && off(camera.target, [x, 0.0, camera.target[2]]) < 1e-6, "{camera:?}");
    }
    // Roll that is left out would be noticed.
    assert!(path.at(1.0).up[1].abs() < 1e-6);
}
