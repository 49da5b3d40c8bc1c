//! Files of rays and scenes, there and back.

use std::fs;
use std::sync::Arc;

use tempfile::TempDir;
use tracebench_api::{Geometry, Hit, NO_PRIMITIVE, Query, Ray, Status};
use tracebench_scenes::{catalogue, procedural};

use super::*;
use crate::files::OutputFolder;
use crate::measure::records;
use crate::progress::Progress;
use crate::rays::primary_rays;
use crate::truth::{Answer, Cache, Ray64, Truth};
use crate::viewpoint::Pose;

/// Proves that every scene of the catalogue, at two sizes, is read back from its .glb as the same arrays with the same hash; one whose
/// vertices are in another order has another hash.
#[test]
fn scenes_come_back_as_they_were() {
    for entry in catalogue() {
        for scale in [0.02, 0.1] {
            let mut scene = procedural(entry.name, scale).unwrap();
            let (_, back) = glb(&scene.mesh, &scene.name).unwrap();
            assert_eq!(back.sha256, scene.sha256, "{} at {scale}", entry.name);
            assert!(back.notes.warnings.is_empty(), "{:?}", back.notes.warnings);
            scene.mesh.triangles.swap(0, 1);
            assert_ne!(glb(&scene.mesh, &scene.name).unwrap().1.sha256, scene.sha256);
            scene.mesh.positions.push([0.0; 3]);
            assert!(glb(&scene.mesh, &scene.name).unwrap_err().to_string().contains("every vertex is in a triangle"));
        }
    }
}

/// A small room with rays and truth, written, and where.
struct Written {
    folder: TempDir,
    rays: Vec<Ray>,
    answers: Vec<Answer>,
    truth: Truth,
}

impl Written {
    fn new(query: Query) -> Self {
        let scene = procedural("room", 0.02).unwrap();
        let geometry = Geometry::new(scene.mesh.positions.clone(), scene.mesh.triangles.clone(), None).unwrap();
        let truth = Truth::new(&geometry, &scene.sha256);
        let viewpoint = Pose::from(&scene.cameras[0]).viewpoint(&geometry, [64, 64], 64);
        let mut rays = primary_rays(&viewpoint, [12, 8]);
        // One past an edge, which is ambiguous.
        let towards = |[x, y, z]: &[f32; 3]| {
            let direction = (glam::Vec3::new(*x, *y, *z) - viewpoint.eye).normalize().into();
            Ray { direction, ..rays[0] }
        };
        let is_ambiguous = |ray: &Ray| truth.answer_one(&Ray64::from(ray), query).is_ambiguous();
        if let Some(ray) = scene.mesh.positions.iter().map(towards).find(is_ambiguous) {
            rays[0] = ray;
        }
        let shared = Arc::new(rays.clone());
        let answers = truth.answer(&shared, query, &Cache::none(), &Progress::new(true)).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let out = OutputFolder::open(folder.path()).unwrap();
        write_scene(&out, &scene.mesh, "room").unwrap();
        let place = records::viewpoint_of("eye", &viewpoint, [12, 8], 0.0);
        let known = (rays.as_slice(), answers.as_slice());
        let manifest = Manifest::new("set", query, known, records::scene_record(&scene), Some(place), 1);
        let pixels: Vec<[u32; 2]> = (0..96).map(|pixel| [pixel % 12, pixel / 12]).collect();
        write(&out, "set", &manifest, known, &pixels).unwrap();
        Self { folder, rays, answers, truth }
    }

    fn set(&self) -> PathBuf {
        self.folder.path().join("set")
    }

    /// The right answers, written with triangles.
    fn answered(&self) -> PathBuf {
        let path = self.folder.path().join("answers");
        fs::create_dir_all(&path).unwrap();
        let t: Vec<f32> =
            self.answers.iter().map(|answer| answer.hit.map_or(f32::INFINITY, |hit| hit.t as f32)).collect();
        let triangle: Vec<u32> =
            self.answers.iter().map(|answer| answer.hit.map_or(NO_TRIANGLE, |hit| hit.primitive)).collect();
        fs::write(path.join("t.npy"), npy::write(None, &t)).unwrap();
        fs::write(path.join("triangle.npy"), npy::write(None, &triangle)).unwrap();
        fs::write(path.join("rays_sha256"), format!("{}\n", crate::hash::sha256_of(&self.rays))).unwrap();
        path
    }
}

fn refusal<T>(outcome: Result<T, ExchangeError>) -> String {
    outcome.err().map_or_else(String::new, |error| error.to_string())
}

/// Proves that rays, truth (with ambiguous rays) and scene come back as they were written, and that a changed byte in any array, a truth
/// of other rays, and another scene are noticed by the field's name.
#[test]
fn sets_come_back_and_changes_are_noticed() {
    let written = Written::new(Query::Closest);
    assert!(written.answers.iter().any(Answer::is_ambiguous));
    let set = read(&written.set()).unwrap();
    let truth = read_truth(&written.set(), &set.manifest).unwrap();
    assert_eq!(
        (bytemuck::cast_slice::<Ray, u8>(&set.rays), &truth),
        (bytemuck::cast_slice(&written.rays), &written.answers)
    );
    check_truth(&written.set(), &written.truth, &set, &truth, 1).unwrap();
    scene(&written.set(), &set.manifest).unwrap();
    let pixels = npy::read::<u32>(&written.set().join("pixel.npy"), Some(2), 96).unwrap();
    assert_eq!(pixels[2 * 13..2 * 14], [1, 1]);
    let mut moved = truth.clone();
    moved.rotate_left(1);
    assert!(
        refusal(check_truth(&written.set(), &written.truth, &set, &moved, 1))
            .contains("t.npy: is not the truth of ray")
    );
    for name in ["origin", "direction", "t_min", "t_max", "t", "triangle", "perturbed_t", "perturbed_triangle"] {
        let path = written.set().join(format!("{name}.npy"));
        let whole = fs::read(&path).unwrap();
        let mut changed = whole.clone();
        let last = changed.len() - 1;
        changed[last - 3] ^= 1;
        fs::write(&path, &changed).unwrap();
        let outcome = read(&written.set()).and_then(|set| read_truth(&written.set(), &set.manifest)).map(drop);
        let found = refusal(outcome);
        assert!(found.contains("_sha256` ") || found.contains("t_max.npy: must be from"), "{name}: {found}");
        fs::write(&path, &changed[..last]).unwrap();
        let outcome = read(&written.set()).and_then(|set| read_truth(&written.set(), &set.manifest)).map(drop);
        assert!(refusal(outcome).contains(&format!("{name}.npy: ")), "{name}");
        fs::write(&path, &whole).unwrap();
    }
    let mut other = procedural("room", 0.02).unwrap();
    other.mesh.triangles.swap(0, 1);
    fs::write(written.set().join(SCENE_FILE), glb(&other.mesh, "room").unwrap().0).unwrap();
    assert!(refusal(scene(&written.set(), &set.manifest)).contains("`scene.sha256` is not that of scene.glb"));
}

/// Proves that NumPy's other forms are read as what they mean (Fortran order, big-endian, version 2 headers), and that pickles, other
/// types and shapes, headers that promise terabytes or nest without end, and pipes are refused by what is wrong.
#[test]
fn arrays_are_read_in_every_form_and_hostile_ones_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.npy");
    let file = |text: &str, data: &[u8]| {
        let mut bytes = b"\x93NUMPY\x02\x00".to_vec();
        bytes.extend((text.len() as u32).to_le_bytes());
        bytes.extend(text.as_bytes());
        bytes.extend(data);
        fs::write(&path, bytes).unwrap();
    };
    let header = |descr: &str, fortran: &str, shape: &str| {
        format!("{{'descr': '{descr}', 'fortran_order': {fortran}, 'shape': {shape}}}\n")
    };
    let big: Vec<u8> = [1.0_f32, 4.0, 2.0, 5.0, 3.0, 6.0].iter().flat_map(|value| value.to_be_bytes()).collect();
    file(&header(">f4", "True", "(2, 3)"), &big);
    assert_eq!(npy::read::<f32>(&path, Some(3), 2).unwrap(), [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
    let vector = [0.5_f64, f64::INFINITY];
    fs::write(&path, npy::write(None, &vector)).unwrap();
    assert_eq!(npy::read::<f64>(&path, None, 2).unwrap(), vector);
    assert!(refusal(npy::read::<f64>(&path, None, 3)).contains("has shape [2] and must have [3]"));
    assert!(refusal(npy::read::<f32>(&path, None, 2)).contains("must be one of '<f4'"));
    assert!(refusal(npy::read::<f64>(&path, Some(2), 1)).contains("must have [1, 2]"));
    let nested = format!("{}{}", "(".repeat(400), ")".repeat(400));
    for (text, wrong) in [
        (header("|O", "False", "(1,)"), "holds pickled objects"),
        (header("<f4", "False", "(1000000000000,)"), "has shape [1000000000000]"),
        (header("<f4", "False", "(4611686018427387904, 3)"), "of more than any file has"),
        (header("<f4", "False", "(-1,)"), "is no .npy file that can be read"),
        (header("<f4", "False", &nested), "a type with fields"),
        (header("<f4", "False", "(1,)").replace("'<f4'", "[('a', '<f4')]"), "a type with fields"),
        ("x".repeat(2000), "at most 1024 bytes"),
        (String::new(), "is no .npy file that can be read"),
    ] {
        file(&text, &[0; 8]);
        let found = refusal(npy::read::<f32>(&path, Some(3), 1)) + &refusal(npy::read::<f32>(&path, None, 1));
        assert!(found.contains(wrong) && found.contains("x.npy"), "{text}: {found}");
    }
    assert!(refusal(npy::read::<f32>(folder.path(), None, 1)).contains("no regular file"));
}

/// Changes a manifest and gives what is said of it.
fn with(written: &Written, field: &str, value: serde_json::Value) -> String {
    let path = written.set().join(MANIFEST);
    let whole = fs::read(&path).unwrap();
    let mut manifest: serde_json::Value = serde_json::from_slice(&whole).unwrap();
    manifest[field] = value;
    fs::write(&path, manifest.to_string()).unwrap();
    let found = refusal(read(&written.set()).and_then(|set| read_truth(&written.set(), &set.manifest)));
    fs::write(&path, whole).unwrap();
    found
}

/// Proves that answers are read by ray, in whatever order they are given, and that other rays, missing and repeated ones, no numbers, a t
/// out of its ray's span, a triangle that is not there, and times that are none are refused by the name of the field.
#[test]
fn answers_are_read_and_wrong_ones_refused_by_field() {
    let written = Written::new(Query::Closest);
    let (set, path) = (read(&written.set()).unwrap(), written.answered());
    let read_back = answers::read(&path, &set).unwrap();
    let right = |answer: &Answer| match answer.hit {
        Some(hit) => Hit { t: hit.t as f32, primitive: hit.primitive, u: 0.0, v: 0.0, status: Status::Hit as u32 },
        None => Hit::miss(Status::Miss),
    };
    let expected: Vec<Hit> = written.answers.iter().map(right).collect();
    assert_eq!(bytemuck::cast_slice::<Hit, u8>(&read_back.hits), bytemuck::cast_slice::<Hit, u8>(&expected));
    assert!(read_back.names_triangles && read_back.self_reported.is_none());
    // In reverse, as f64, without triangles, with times.
    let t: Vec<f64> =
        written.answers.iter().rev().map(|answer| answer.hit.map_or(f64::INFINITY, |hit| hit.t)).collect();
    let order: Vec<u32> = (0..96).rev().collect();
    fs::remove_file(path.join("triangle.npy")).unwrap();
    fs::write(path.join("t.npy"), npy::write(None, &t)).unwrap();
    fs::write(path.join("index.npy"), npy::write(None, &order)).unwrap();
    fs::write(path.join("times.json"), r#"{"trace_ms": 1.5}"#).unwrap();
    let reversed = answers::read(&path, &set).unwrap();
    assert!(reversed.hits.iter().zip(&expected).all(|(one, other)| one.t == other.t && one.primitive == NO_PRIMITIVE));
    assert_eq!(reversed.self_reported.unwrap().trace_ms, Some(1.5));
    let refused = |name: &str, contents: Vec<u8>| {
        let path = written.answered();
        let _ = (fs::remove_file(path.join("index.npy")), fs::remove_file(path.join("times.json")));
        fs::write(path.join(name), contents).unwrap();
        let found = refusal(answers::read(&path, &set));
        assert!(found.contains(name), "{name}: {found}");
        found
    };
    let of_t = |value: f32| {
        let mut t: Vec<f32> = expected.iter().map(|hit| if hit.is_hit() { hit.t } else { f32::INFINITY }).collect();
        t[5] = value;
        npy::write(None, &t)
    };
    for value in [f32::NAN, f32::NEG_INFINITY, -1.0, 2e30] {
        assert!(refused("t.npy", of_t(value)).contains("answer 5 is"), "{value}");
    }
    assert!(refused("t.npy", npy::write(None, &[1.0_f32; 95])).contains("has shape [95] and must have [96]"));
    assert!(refused("t.npy", npy::write(None, &[1_u32; 96])).contains("must be one of"));
    assert!(refused("triangle.npy", npy::write(None, &[4_000_000_000_u32; 96])).contains("is triangle 4000000000 of"));
    assert!(refused("triangle.npy", npy::write(None, &[0.0_f64; 96])).contains("must be one of '<u4'"));
    let mut twice: Vec<u32> = (0..96).collect();
    twice[7] = 6;
    assert!(refused("index.npy", npy::write(None, &twice)).contains("ray 6 is answered twice"));
    twice[7] = 96;
    assert!(refused("index.npy", npy::write(None, &twice)).contains("is to ray 96 of 96"));
    assert!(refused("rays_sha256", b"0000".to_vec()).contains("answers to other rays"));
    for times in [r#"{"trace_ms": -1}"#, r#"{"trace_ms": "1"}"#, r#"{"speed": 1}"#, "7", r#"{"trace_ms": 1e300}"#] {
        refused("times.json", times.into());
    }
    for (field, value) in [
        ("count", serde_json::json!(95)),
        ("count", serde_json::json!(1_u64 << 60)),
        ("query", serde_json::json!("some")),
        ("format", serde_json::json!("other")),
        ("version", serde_json::json!(2)),
        ("name", serde_json::json!("../x")),
        ("rules_version", serde_json::json!(1)),
        ("rays_sha256", serde_json::json!("0")),
        ("truth_sha256", serde_json::json!(null)),
        ("perturbed", serde_json::json!([])),
        ("reference_pixels", serde_json::json!(512)),
        ("units", serde_json::json!("inches")),
        ("scene", serde_json::json!(7)),
    ] {
        let found = with(&written, field, value.clone());
        assert!(found.contains(field) || found.contains("must have [95, 3]"), "{field} {value}: {found}");
    }
    assert_eq!(with(&written, "seed", serde_json::json!(7)), "");
}

/// Proves that answers to any-hit rays are read from `occluded`.
#[test]
fn occlusion_is_read() {
    let written = Written::new(Query::Any);
    let (set, path) = (read(&written.set()).unwrap(), written.answered());
    assert!(refusal(answers::read(&path, &set)).contains("occluded.npy"));
    let occluded: Vec<bool> = written.answers.iter().map(|answer| answer.hit.is_some()).collect();
    fs::write(path.join("occluded.npy"), npy::write(None, &occluded)).unwrap();
    let hits = answers::read(&path, &set).unwrap().hits;
    assert!(hits.iter().zip(&occluded).all(|(hit, occluded)| hit.is_hit() == *occluded));
    let mut bytes = npy::write(None, &occluded);
    *bytes.last_mut().unwrap() = 2;
    fs::write(path.join("occluded.npy"), bytes).unwrap();
    assert!(refusal(answers::read(&path, &set)).contains("occluded.npy"));
}
