//! Random animated files: whatever they hold, the import answers within its promises.
#![allow(missing_docs)]

use crate::support;

use serde_json::{Value, json};
use support::promises::{self, Outcome};
use support::{Doc, SQUARE};
use tracebench_tests::fuzz::Random;

/// Mostly ordinary numbers, now and then one that is none or at the end of the range.
fn number(random: &mut Random, wild: bool) -> f32 {
    if wild && random.once_in(12) {
        *random.pick(&[f32::NAN, f32::INFINITY, f32::MAX, -f32::MAX, f32::MIN_POSITIVE, 1e-45, 1e15, 0.0, -0.0])
    } else {
        random.below(4001) as f32 / 1000.0 - 2.0
    }
}

fn numbers(random: &mut Random, count: usize, wild: bool) -> Vec<f32> {
    (0..count).map(|_| number(random, wild)).collect()
}

/// A tree of nodes with meshes, a skin over some of them, morph targets and channels for everything. A tame file breaks
/// no rule; a wild one has numbers and references that may break any.
fn random_file(random: &mut Random, wild: bool) -> Doc {
    let mut doc = Doc::square();
    let nodes = 2 + random.below(5);
    let spill = usize::from(wild && random.once_in(8));
    let targets = random.below(3);
    let primitive = &mut doc.json["meshes"][0]["primitives"][0];
    primitive["targets"] = json!([]);
    for _ in 0..targets {
        let displacements: Vec<[f32; 3]> = SQUARE.iter().map(|_| [0; 3].map(|_| number(random, wild))).collect();
        let accessor = doc.positions(&displacements);
        doc.json["meshes"][0]["primitives"][0]["targets"].as_array_mut().unwrap().push(json!({"POSITION": accessor}));
    }
    let joints: Vec<usize> = (0..1 + random.below(3)).map(|_| random.below(nodes + spill)).collect();
    let of_vertices: Vec<[u8; 4]> =
        SQUARE.iter().map(|_| [0; 4].map(|_| random.below(joints.len() + spill) as u8)).collect();
    let influences = doc.joints(&of_vertices);
    let weights: Vec<f32> =
        numbers(random, 16, wild).iter().map(|weight| if wild { *weight } else { weight.abs() }).collect();
    let weights = doc.floats("VEC4", &weights);
    let attributes = &mut doc.json["meshes"][0]["primitives"][0]["attributes"];
    attributes["JOINTS_0"] = json!(influences);
    attributes["WEIGHTS_0"] = json!(weights);
    let mut skin = json!({"joints": joints});
    if random.once_in(2) {
        let matrices = numbers(random, 16 * (joints.len() - spill.min(1)), wild);
        skin["inverseBindMatrices"] = json!(doc.floats("MAT4", &matrices));
    }
    doc.json["skins"] = json!([skin]);

    let mut tree: Vec<Value> = vec![json!({"mesh": 0, "children": []})];
    for node in 1..nodes {
        let parent = random.below(node);
        tree[parent]["children"].as_array_mut().unwrap().push(json!(node));
        tree.push(
            json!({"children": [], "translation": numbers(random, 3, false), "rotation": numbers(random, 4, false)}),
        );
        if random.once_in(2) {
            tree[node]["mesh"] = json!(0);
        }
        if tree[node].get("mesh").is_some() && random.once_in(2) {
            tree[node]["skin"] = json!(0);
        }
    }
    tree.iter_mut().for_each(|node| {
        if node["children"].as_array().is_some_and(Vec::is_empty) {
            node.as_object_mut().unwrap().remove("children");
        }
    });
    doc.json["nodes"] = json!(tree);
    for _ in 0..1 + random.below(5) {
        add_channel(random, &mut doc, nodes, targets, wild);
    }
    doc
}

fn add_channel(random: &mut Random, doc: &mut Doc, nodes: usize, targets: usize, wild: bool) {
    let node = random.below(nodes);
    let has_targets = doc.json["nodes"][node].get("mesh").is_some() && targets > 0;
    let (path, width) = match random.below(4) {
        0 => ("translation", 3),
        1 => ("rotation", 4),
        2 => ("scale", 3),
        _ if has_targets => ("weights", targets),
        _ => ("translation", 3),
    };
    let (interpolation, per_key) = *random.pick(&[("LINEAR", 1), ("STEP", 1), ("CUBICSPLINE", 3)]);
    let keys = 1 + random.below(5);
    let mut time = random.below(3) as f32 * 0.25;
    let mut times = Vec::new();
    for _ in 0..keys {
        times.push(time);
        time += 0.125 + random.below(8) as f32 * 0.25;
        if wild && random.once_in(20) {
            time = number(random, true);
        }
    }
    let short = usize::from(wild && random.once_in(20));
    let values = numbers(random, width * per_key * (keys - short.min(keys - 1)), wild);
    doc.channel(node, path, interpolation, &times, &values);
}

/// Proves that random files that break no rule are all imported and most of them move: this
/// is what the wild ones below are damaged forms of.
#[test]
fn tame_files_are_imported() {
    let mut moving = 0;
    for seed in 0..2_000 {
        let doc = random_file(&mut Random(seed), false);
        match promises::check(&doc.glb()) {
            Ok(Outcome::Refused) => panic!("seed {seed}: {}", doc.error()),
            Ok(outcome) => moving += u32::from(outcome == Outcome::Moving),
            Err(problem) => panic!("seed {seed}: {problem}"),
        }
    }
    assert!(moving > 1_500, "{moving}");
}

/// Proves that random files with numbers and references that break rules never break a promise, whether they are
/// refused or not; both happen often.
#[test]
fn wild_files_keep_the_promises() {
    let mut counts = [0u32; 2];
    for seed in 0..10_000 {
        let doc = random_file(&mut Random(1 << 32 | seed), true);
        let outcome = promises::check(&doc.glb()).unwrap_or_else(|problem| panic!("seed {seed}: {problem}"));
        counts[usize::from(outcome == Outcome::Moving)] += 1;
    }
    assert!(counts.iter().all(|&count| count > 300), "{counts:?}");
}
