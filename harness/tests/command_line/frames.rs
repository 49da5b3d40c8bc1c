//! What `frames` leaves.

use std::process::Stdio;
use std::thread::sleep;
use std::time::Duration;

use data_encoding::BASE64;
use sha2::{Digest as _, Sha256};

use super::resume::interleaved_sets;
use super::*;

/// A glTF file of a square that bends about a joint and bulges by a morph target, seen by a camera that moves; all for two seconds.
fn moving() -> String {
    let mut bytes: Vec<u8> = Vec::new();
    let (mut views, mut accessors) = (Vec::new(), Vec::new());
    let mut add = |data: Vec<u8>, component: u32, shape: &str, count: usize| {
        views.push(json!({"buffer": 0, "byteOffset": bytes.len(), "byteLength": data.len()}));
        let mut accessor =
            json!({"bufferView": views.len() - 1, "componentType": component, "type": shape, "count": count});
        if shape == "VEC3" {
            (accessor["min"], accessor["max"]) = (json!([-9.0, -9.0, -9.0]), json!([9.0, 9.0, 9.0]));
        }
        accessors.push(accessor);
        bytes.extend(data);
        accessors.len() - 1
    };
    let floats = |values: &[f32]| values.iter().flat_map(|value| value.to_le_bytes()).collect::<Vec<u8>>();
    let corners =
        [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0], [2.0, 0.0, 0.0], [2.0, 1.0, 0.0_f32]];
    let positions = add(floats(corners.as_flattened()), 5126, "VEC3", 6);
    let bulge = add(floats([[0.0, 0.0, 0.25_f32]; 6].as_flattened()), 5126, "VEC3", 6);
    // The right half follows the second joint.
    let joints = add([0_u8, 0, 0, 0, 1, 1].iter().flat_map(|joint| [*joint, 0, 0, 0]).collect(), 5121, "VEC4", 6);
    let weights = add(floats([[1.0, 0.0, 0.0, 0.0_f32]; 6].as_flattened()), 5126, "VEC4", 6);
    let triangles: [u16; 12] = [0, 1, 2, 0, 2, 3, 1, 4, 5, 1, 5, 2];
    let indices = add(triangles.iter().flat_map(|index| index.to_le_bytes()).collect(), 5123, "SCALAR", 12);
    let times = add(floats(&[0.0, 2.0]), 5126, "SCALAR", 2);
    let half = 0.5_f32.sqrt();
    let turn = add(floats(&[0.0, 0.0, 0.0, 1.0, 0.0, half, 0.0, half]), 5126, "VEC4", 2);
    let morph = add(floats(&[0.0, 1.0]), 5126, "SCALAR", 2);
    let walk = add(floats(&[1.0, 0.5, 3.0, 1.4, 0.5, 3.0]), 5126, "VEC3", 2);
    let sampler = |output: usize| json!({"input": times, "output": output, "interpolation": "LINEAR"});
    let channel =
        |sampler: u32, node: u32, path: &str| json!({"sampler": sampler, "target": {"node": node, "path": path}});
    let uri = format!("data:application/octet-stream;base64,{}", BASE64.encode(&bytes));
    json!({
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0, 1, 3]}],
        "nodes": [{"mesh": 0, "skin": 0}, {"children": [2]}, {}, {"camera": 0, "translation": [1.0, 0.5, 3.0]}],
        "cameras": [{"type": "perspective", "perspective": {"yfov": 0.9, "znear": 0.1}}],
        "meshes": [{"weights": [0.0], "primitives": [{
            "attributes": {"POSITION": positions, "JOINTS_0": joints, "WEIGHTS_0": weights}, "indices": indices,
            "targets": [{"POSITION": bulge}],
        }]}],
        "skins": [{"joints": [1, 2]}],
        "animations": [{"samplers": [sampler(turn), sampler(morph), sampler(walk)],
                        "channels": [channel(0, 2, "rotation"), channel(1, 0, "weights"), channel(2, 3, "translation")]}],
        "buffers": [{"byteLength": bytes.len(), "uri": uri}],
        "bufferViews": views,
        "accessors": accessors,
    })
    .to_string()
}

/// A glTF file of sixteen squares behind one another, which fill the view of a camera at two seconds, and little of it before and after.
fn growing() -> String {
    let corners = [[-0.5, -0.5, 0.0], [0.5, -0.5, 0.0], [0.5, 0.5, 0.0], [-0.5, 0.5, 0.0_f32]];
    let times = [0.0, 1.0, 2.0, 3.0_f32];
    let scales = [0.15, 0.15, 1.0, 0.15_f32].map(|scale| [scale; 3]);
    let floats = [corners.as_flattened(), &times, scales.as_flattened()].concat();
    let mut bytes: Vec<u8> = floats.iter().flat_map(|value| value.to_le_bytes()).collect();
    bytes.extend([0_u16, 1, 2, 0, 2, 3].iter().flat_map(|index| index.to_le_bytes()));
    let view = |[offset, length]: [u32; 2]| json!({"buffer": 0, "byteOffset": offset, "byteLength": length});
    let views = [[0, 48], [48, 16], [64, 48], [112, 12]].map(view);
    let squares = (0..16).map(|place| json!({"mesh": 0, "translation": [0.0, 0.0, -0.02 * f64::from(place)]}));
    let camera = json!({"camera": 0, "translation": [0.0, 0.0, 0.7]});
    let nodes: Vec<Value> = squares.chain([camera, json!({"children": (0..16).collect::<Vec<u32>>()})]).collect();
    json!({
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [16, 17]}],
        "nodes": nodes,
        "cameras": [{"type": "perspective", "perspective": {"yfov": 0.9, "znear": 0.1}}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 3}]}],
        "animations": [{"samplers": [{"input": 1, "output": 2, "interpolation": "LINEAR"}],
                        "channels": [{"sampler": 0, "target": {"node": 17, "path": "scale"}}]}],
        "buffers": [{"byteLength": bytes.len(),
                     "uri": format!("data:application/octet-stream;base64,{}", BASE64.encode(&bytes))}],
        "bufferViews": views,
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 4,
             "min": [-0.5, -0.5, 0.0], "max": [0.5, 0.5, 0.0]},
            {"bufferView": 1, "componentType": 5126, "type": "SCALAR", "count": 4},
            {"bufferView": 2, "componentType": 5126, "type": "VEC3", "count": 4},
            {"bufferView": 3, "componentType": 5123, "type": "SCALAR", "count": 6},
        ],
    })
    .to_string()
}

const SMALL: [&str; 6] = ["frames", "--quiet", "--preset", "smoke", "--size", "24x16"];

/// Proves that a file whose mesh is skinned and morphed and whose camera moves is rendered in every frame, another one each; that pictures
/// lie beside the record under their hashes; that `report` makes the same files again, and a page of the record holds its frames.
#[test]
fn a_skinned_and_morphed_file_is_rendered() {
    let bench = Bench::new();
    std::fs::write(bench.path("bend.gltf"), moving()).unwrap();
    let words =
        ["--scene", "bend.gltf", "--tracer", "bvh-cpu", "--effect", "primary,normals", "--frames", "3", "--fps", "1"];
    let outcome = bench.call(&[&SMALL[..], &words, &["--spp", "2", "--out", "out"]].concat());
    assert_eq!((outcome.status, outcome.stderr.as_str()), (0, ""), "{outcome:?}");
    let found = bench.result("out");
    let scene = &found["frames"]["scenes"][0];
    assert_eq!(scene["path"], "along the scene's path");
    let hashes: BTreeSet<&str> =
        scene["scene_sha256"].as_array().unwrap().iter().map(|hash| hash.as_str().unwrap()).collect();
    assert_eq!(hashes.len(), 3);
    assert_eq!(scene["viewpoints"][2]["eye"][0].as_f64().unwrap() as f32, 1.4);
    let rows = found["frames"]["rows"].as_array().unwrap();
    let bvh: Vec<&Value> = rows.iter().filter(|row| row["tracer"]["name"] == "bvh-cpu").collect();
    assert_eq!(bvh.len(), 2);
    for (row, work) in bvh.iter().zip(["primary", "normals"]) {
        assert_eq!(row["floor_holds"], true, "{work}");
        for frame in row["frames"].as_array().unwrap() {
            let [work, image] = [&frame["works"][work], &frame["works"][work]["image"]];
            assert!(work["waves"][0]["trace_ms"].as_f64().unwrap() > 0.0 && work["waves"][0]["rays"] == 24 * 16 * 2);
            assert!(image["ssim"].as_f64().unwrap() > 0.9, "{image}");
        }
    }
    let named: BTreeSet<String> = (bvh.iter().map(|row| &row["pictures"]).chain([&scene["pictures"]]))
        .flat_map(|pictures| pictures.as_object().unwrap().values())
        .flat_map(|of| [&of["sheet"], &of["animation"]].map(|name| name.as_str().unwrap().to_owned()))
        .collect();
    assert_eq!(named, names(&bench.path("out/pictures")).into_iter().collect());
    for name in &named {
        let hash = Sha256::digest(std::fs::read(bench.path("out/pictures").join(name)).unwrap());
        assert!(name.starts_with(&data_encoding::HEXLOWER.encode(&hash)[..32]));
    }
    let files = ["out/frames.md", "out/frames.csv"].map(|name| bench.path(name));
    let before = files.clone().map(|file| std::fs::read(file).unwrap());
    files.iter().for_each(|file| std::fs::remove_file(file).unwrap());
    assert_eq!(bench.call(&["--quiet", "report", "out"]).status, 0);
    assert!(files.map(|file| std::fs::read(file).unwrap()) == before);
    assert_eq!(bench.call(&["--quiet", "report", "--html", "page.html", "out"]).status, 0);
    let page = std::fs::read_to_string(bench.path("page.html")).unwrap();
    assert!(page.contains("Frames of moving scenes"));
}

/// Proves that the rays and answers of frames are those of `run` at the same times, by hash and by count; and that the frame before has others.
#[test]
fn frames_are_those_of_runs() {
    let bench = Bench::new();
    let common = ["--scene", "cloth", "--tracer", "bvh-cpu,screen-dda", "--rays", "diffuse"];
    let words = ["--move", "geometry", "--update", "rebuild", "--frames", "3", "--fps", "2", "--out", "out"];
    let outcome = bench.call(&[&SMALL[..], &common, &words].concat());
    assert_eq!((outcome.status, outcome.stderr.as_str()), (0, ""), "{outcome:?}");
    let found = bench.result("out");
    let run = |time: &'static str, out: &'static str| {
        let words = ["--samples", "1", "--animation-time", time, "--out", out];
        let run = bench.call(&[&["run"], &SMALL[1..], &common, &words].concat());
        assert_eq!(run.status, 0, "{run:?}");
        bench.result(out)
    };
    let runs = [run("0", "first"), run("0.5", "second"), run("1", "third")];
    for tracer in ["bvh-cpu", "screen-dda"] {
        let rows = found["frames"]["rows"].as_array().unwrap();
        let series = rows.iter().find(|row| row["tracer"]["name"] == tracer).unwrap();
        for (frame, run) in runs.iter().enumerate() {
            let row = run["rows"].as_array().unwrap().iter().find(|row| row["tracer"]["name"] == tracer).unwrap();
            let (trace, own) = (&row["traces"][0], &series["frames"][frame]);
            let answers = &own["works"]["diffuse"]["waves"][0]["answers"];
            for name in ["rays_sha256", "hits_sha256"] {
                assert_eq!(answers[name], trace[name], "{tracer}, frame {frame}");
            }
            for (name, counter) in trace["counters"].as_object().unwrap() {
                assert_eq!(answers["counters"][name], counter["total"], "{tracer}, {name}");
            }
            // Drivers pad textures as they come to lie.
            let [bytes, of_run] =
                [&own["structure_bytes"], &row["memory"]["structure_bytes"]].map(|bytes| bytes.as_u64().unwrap());
            let padding = if tracer == "bvh-cpu" { 0 } else { 64 };
            assert!(bytes.abs_diff(of_run) <= padding, "{tracer}, frame {frame}: {bytes} {of_run}");
        }
        let hits = |frame: usize| &series["frames"][frame]["works"]["diffuse"]["waves"][0]["answers"]["hits_sha256"];
        assert!(hits(0) != hits(1) && hits(1) != hits(2));
    }
}

/// A record's value without times.
fn untimed(value: &Value) -> Value {
    match value {
        Value::Object(fields) => {
            let kept = fields.iter().filter(|(name, _)| !["trace_ms", "update_ms"].contains(&name.as_str()));
            kept.map(|(name, value)| (name.clone(), untimed(value))).collect()
        }
        Value::Array(all) => all.iter().map(untimed).collect(),
        other => other.clone(),
    }
}

/// Proves that frames which are killed three times and gone on with have what those have that ran through, but for times, pictures too; and
/// that each effect of a scene that has ended stays as it was.
#[test]
fn effects_that_ended_survive_being_killed() {
    let bench = Bench::new();
    let words = ["--scene", "cloth,room", "--tracer", "bvh-cpu", "--effect", "depth,normals,primary", "--frames", "3"];
    let call = |more: &[&'static str]| [&SMALL[..], &words, more].concat();
    assert_eq!(bench.call(&call(&["--out", "through"])).status, 0);
    let out = bench.path("out");
    let mut asked = vec!["--out", "out"];
    for wanted in 1..=3 {
        let before = interleaved_sets(&out);
        let mut child = bench.command(&call(&asked)).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
        while interleaved_sets(&out).len() <= before.len() && child.try_wait().unwrap().is_none() {
            sleep(Duration::from_millis(2));
        }
        assert!(child.try_wait().unwrap().is_none(), "it ended before it was killed for the {wanted}th time");
        child.kill().unwrap();
        child.wait().unwrap();
        let after = interleaved_sets(&out);
        assert!(before.iter().all(|(name, contents)| after.get(name) == Some(contents)), "{wanted}");
        asked = vec!["--out", "out", "--resume"];
    }
    let kept: Vec<String> = interleaved_sets(&out).into_keys().collect();
    assert!(kept.len() >= 3 && kept[..2] == ["000-frames-depth.json", "000-frames-normals.json"], "{kept:?}");
    let outcome = bench.call(&call(&asked));
    assert_eq!((outcome.status, outcome.stderr.as_str()), (0, ""), "{outcome:?}");
    let [through, found] = ["through", "out"].map(|folder| untimed(&bench.result(folder)["frames"]));
    assert!(found == through && found["rows"].as_array().unwrap().len() > 12);
    assert_eq!(names(&bench.path("out/pictures")), names(&bench.path("through/pictures")));
    // The comparison can fail.
    let mut other = found.clone();
    other["rows"][0]["frames"][1]["turned"] = json!([0, 9]);
    assert_ne!(other, through);
}

/// Proves that shards of scenes are joined, with their places; that a complete record is left as it is; and that a scene which does not
/// move is left out beside one that does.
#[test]
fn frames_are_spread_and_joined() {
    let bench = Bench::new();
    let words = [
        "--scene",
        "cloth,room,foliage",
        "--tracer",
        "bvh-cpu",
        "--rays",
        "primary",
        "--move",
        "geometry",
        "--frames",
        "2",
    ];
    for shard in ["1/3", "2/3", "3/3"] {
        let out = format!("out{}", &shard[..1]);
        let outcome = bench.call(&[&SMALL[..], &words, &["--shard", shard, "--out", &out]].concat());
        assert_eq!((outcome.status, outcome.stderr.as_str()), (0, ""), "{outcome:?}");
    }
    let merged = bench.call(&["--quiet", "merge", "out1", "out2", "out3", "--out", "whole"]);
    assert_eq!(merged.status, 0, "{merged:?}");
    let whole = bench.call(&[&SMALL[..], &words, &["--out", "out"]].concat());
    assert_eq!(whole.status, 0, "{whole:?}");
    let told = |out: &str| {
        let found = bench.result(out);
        let rows = found["frames"]["rows"].as_array().unwrap().iter();
        let hits = |row: &Value| row["frames"][1]["works"]["primary"]["waves"][0]["answers"]["hits_sha256"].clone();
        let rows: Vec<_> = rows.map(|row| (row["scene"].clone(), row["tracer"]["name"].clone(), hits(row))).collect();
        (rows, found["skipped"].clone())
    };
    assert_eq!(told("whole"), told("out"));
    assert!(told("out").1[0]["reason"].as_str().unwrap().contains("room has no animation"));
    let before = std::fs::read(bench.path("out/run.json")).unwrap();
    let again = bench.call(&[&SMALL[..], &words, &["--out", "out", "--resume"]].concat());
    assert!(again.status == 0 && again.stderr.contains("is complete"), "{again:?}");
    assert!(std::fs::read(bench.path("out/run.json")).unwrap() == before);
}

/// Proves that a structure which the device cannot hold in one of the frames takes its tracer out, with an error that names the frame; that all
/// of the others is kept, also of a run that is killed and gone on with; and that the complete record is left as it is, with the same error.
/// Negative control: the frames before fit.
#[test]
fn a_structure_that_does_not_fit_names_its_frame() {
    let bench = Bench::new();
    std::fs::write(bench.path("grow.gltf"), growing()).unwrap();
    let words = ["--scene", "grow.gltf", "--tracer", "fragment-abuffer,bvh-cpu", "--effect", "depth,normals"];
    // A fragment has 16 bytes of data: sixteen squares are a quarter of a GiB.
    let size = ["--limits", "webgpu", "--frame-size", "1024x1024", "--face-size", "16", "--fps", "1"];
    let call = |more: &[&'static str]| [&SMALL[..], &words, &size, &["--move", "geometry"], more].concat();
    let whole = ["--frames", "4", "--out", "out"];
    let resumed = [&whole[..], &["--resume"]].concat();
    let out = bench.path("out");
    let mut child = bench.command(&call(&whole)).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    while interleaved_sets(&out).is_empty() && child.try_wait().unwrap().is_none() {
        sleep(Duration::from_millis(2));
    }
    assert!(child.try_wait().unwrap().is_none(), "it ended before it was killed");
    child.kill().unwrap();
    child.wait().unwrap();
    let kept: Value = serde_json::from_slice(&interleaved_sets(&out)["000-frames-depth.json"]).unwrap();
    let parts = [
        "not measured, the rest is kept: fragment-abuffer in grow: frame 2: ",
        " bytes, the device allows 134217728: turn down --face-size, --frame-size",
    ];
    let is_refused = |outcome: &Outcome| outcome.status == 1 && parts.iter().all(|part| outcome.stderr.contains(part));
    let outcome = bench.call(&call(&resumed));
    assert!(is_refused(&outcome), "{outcome:?}");
    let found = bench.result("out");
    let skipped = found["skipped"].as_array().unwrap();
    assert!(skipped.len() == 1 && skipped[0]["reason"].as_str().unwrap().starts_with("frame 2: "), "{skipped:?}");
    assert!(std::fs::read_to_string(out.join("frames.md")).unwrap().contains("frame 2: "));
    let frames = |of: &Value, name: &str| -> Vec<Value> {
        let rows = of["rows"].as_array().unwrap().iter().filter(|row| row["tracer"]["name"] == name);
        rows.map(|row| row["frames"].clone()).collect()
    };
    let bvh = frames(&found["frames"], "bvh-cpu");
    assert!(bvh.len() == 2 && bvh.iter().all(|frames| frames.as_array().unwrap().len() == 4));
    assert_eq!(frames(&found["frames"], "fragment-abuffer"), Vec::<Value>::new());
    // With their times: what had ended was not measured again.
    assert_eq!(bvh[..1], frames(&kept["ended"], "bvh-cpu"));
    let before = std::fs::read(out.join("run.json")).unwrap();
    let again = bench.call(&call(&resumed));
    assert!(is_refused(&again) && again.stderr.contains("is complete"), "{again:?}");
    assert!(std::fs::read(out.join("run.json")).unwrap() == before);
    let fits = bench.call(&call(&["--frames", "2", "--out", "fits"]));
    assert_eq!((fits.status, fits.stderr.as_str()), (0, ""), "{fits:?}");
    assert_eq!(frames(&bench.result("fits")["frames"], "fragment-abuffer").len(), 2);
}
