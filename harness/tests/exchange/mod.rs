//! Damaged arrays, manifests and answers without end: each is refused by the name of a file, or read within its promises.

use std::cell::RefCell;
use std::fs;
use std::path::Path;
use std::sync::Arc;

use serde_json::{Map, Value, json};
use tempfile::TempDir;
use tracebench_api::{Geometry, Query, Ray};
use tracebench_harness::exchange::{self, ExchangeError, Manifest, answers, npy};
use tracebench_harness::files::OutputFolder;
use tracebench_harness::hash::sha256_of;
use tracebench_harness::progress::Progress;
use tracebench_harness::rays::primary_rays;
use tracebench_harness::results::{SceneRecord, ViewpointRecord};
use tracebench_harness::truth::{Cache, Truth};
use tracebench_harness::viewpoint::Pose;
use tracebench_tests::fuzz::{self, Execution, Random, Tally};

use super::{ALLOCATOR, MAX_TIME, RECORDS, alone};

/// Most memory, in bytes of all files that are read, and bytes that are free.
const MAX_OF_FILES: usize = 4;
const FREE: usize = 1 << 18;

/// The bytes of headers that are written.
const HEADER: usize = 128;

/// The arrays of a set and of answers; to any-hit rays these are [`OCCLUDED`] alone.
const ARRAYS: [&str; 12] = [
    "origin",
    "direction",
    "t_min",
    "t_max",
    "pixel",
    "t",
    "triangle",
    "ambiguous",
    "perturbed_t",
    "perturbed_triangle",
    "answers/t",
    "answers/triangle",
];

const OCCLUDED: &str = "answers/occluded.npy";

/// Whole files by name.
type Files = Vec<(String, Vec<u8>)>;

/// A set of rays with truth and answers.
fn whole(query: Query) -> Files {
    let positions = vec![[-2.0, -2.0, 0.0], [2.0, -2.0, 0.0], [0.0, 0.5, 0.0]];
    let geometry = Geometry::new(positions, vec![[0, 1, 2]], None).unwrap();
    let truth = Truth::new(&geometry, "scene");
    let viewpoint = Pose::parse("0,0,3:0,0,0").unwrap().viewpoint(&geometry, [8, 8], 8);
    let rays = Arc::new(primary_rays(&viewpoint, [16, 12]));
    let told = truth.answer(&rays, query, &Cache::none(), &Progress::new(true)).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let out = OutputFolder::open(folder.path()).unwrap();
    let scene = SceneRecord {
        name: "one".to_owned(),
        sha256: "scene".to_owned(),
        triangles: 1,
        diagonal: 4.7,
        ..SceneRecord::default()
    };
    let manifest = Manifest::new("set", query, (&rays, &told), scene, Some(ViewpointRecord::default()), 1);
    exchange::write(&out, "", &manifest, (&rays, &told), &[[0; 2]; 192]).unwrap();
    let t: Vec<f32> = told.iter().map(|answer| answer.hit.map_or(f32::INFINITY, |hit| hit.t as f32)).collect();
    let triangle: Vec<u32> = told.iter().map(|answer| answer.hit.map_or(u32::MAX, |_| 0)).collect();
    let index: Vec<u32> = (0..192).collect();
    let read = |name: &str| (name.to_owned(), fs::read(folder.path().join(name)).unwrap());
    let mut files: Files = ARRAYS[..10].iter().map(|name| read(&format!("{name}.npy"))).collect();
    if query == Query::Any {
        let occluded: Vec<bool> = told.iter().map(|answer| answer.hit.is_some()).collect();
        files.push((OCCLUDED.to_owned(), npy::write(None, &occluded)));
    } else {
        files.push(("answers/t.npy".to_owned(), npy::write(None, &t)));
        files.push(("answers/triangle.npy".to_owned(), npy::write(None, &triangle)));
    }
    files.push(("answers/index.npy".to_owned(), npy::write(None, &index)));
    files.push(("answers/rays_sha256".to_owned(), manifest.rays_sha256.into_bytes()));
    files.push(("answers/times.json".to_owned(), br#"{"build_ms": 1, "trace_ms": 2}"#.to_vec()));
    files.push(read("manifest.json"));
    files
}

/// The files of execution `number`: one is damaged, and hashes are mostly made anew, so that damage gets past them.
fn damaged(whole: &Files, number: u64) -> Files {
    let mut random = Random::of_execution(number);
    let mut files = whole.clone();
    let at = random.below(files.len());
    let other = random.pick(whole).1.clone();
    let (name, bytes) = &mut files[at];
    if name.ends_with(".json") {
        let mut json: Value = serde_json::from_slice(bytes).unwrap();
        let donor = json.clone();
        RECORDS.mutate(&mut random, &mut json, &donor);
        *bytes = json.to_string().into_bytes();
    }
    for _ in 0..1 + random.below(3) {
        let (length, place) = (bytes.len(), random.below(bytes.len()));
        match random.below(if name.ends_with(".json") { 12 } else { 8 }) {
            0 => bytes.truncate(place),
            1 => bytes.extend_from_slice(&other[..random.below(other.len())]),
            2 => bytes.clone_from(&other),
            3 => bytes[place] = random.bits() as u8,
            4 => bytes[place.min(HEADER - 1).min(length - 1)] = *random.pick(b"0123456789(),[]{}'<>|fiuObFT \n\xff"),
            5 => {
                let text = String::from_utf8_lossy(&bytes[..HEADER.min(length)]).into_owned();
                let shape = *random.pick(&["(192,", "(192, 3", "'<f4'", "'<f8'", "False", "shape"]);
                let instead = *random.pick(&[
                    "(9999999999999,",
                    "(191,",
                    "(0, 3",
                    "'>f4'",
                    "'|O'",
                    "True",
                    "((((",
                    "(-1,",
                    "(18446744073709551615, 9",
                ]);
                let header = text.replacen(shape, instead, 1);
                if text.is_ascii() {
                    bytes.splice(..HEADER.min(length), header.into_bytes());
                }
            }
            6 => {
                let value = *random.pick(&[f32::NAN, f32::INFINITY, -1.0, -0.0, 1e30, 3e38, f32::MIN_POSITIVE / 4.0]);
                let place = HEADER + 4 * random.below(length.saturating_sub(HEADER) / 4);
                if let Some(slot) = bytes.get_mut(place..place + 4) {
                    slot.copy_from_slice(&value.to_le_bytes());
                }
            }
            _ => {}
        }
        if bytes.is_empty() {
            break;
        }
    }
    if !random.once_in(4) && !files[at].0.ends_with(".json") {
        rehash(&mut files);
    }
    files
}

/// Makes the hashes of rays and truth anew, of data behind headers of the common length.
fn rehash(files: &mut Files) {
    let data = |name: &str| {
        let bytes = &files.iter().find(|(found, _)| found.strip_suffix(".npy") == Some(name)).unwrap().1;
        bytes.get(HEADER..).unwrap_or_default().to_vec()
    };
    let floats = |name: &str| {
        data(name).chunks_exact(4).map(|part| f32::from_le_bytes(part.try_into().unwrap())).collect::<Vec<f32>>()
    };
    let [origin, direction, t_min, t_max] = ["origin", "direction", "t_min", "t_max"].map(floats);
    let of = |list: &[f32], at: usize| list.get(at).copied().unwrap_or_default();
    let vector = |list: &[f32], at: usize| [0, 1, 2].map(|axis| of(list, 3 * at + axis));
    let ray = |at| Ray {
        origin: vector(&origin, at),
        t_min: of(&t_min, at),
        direction: vector(&direction, at),
        t_max: of(&t_max, at),
    };
    let rays_sha256 = sha256_of(&(0..192).map(ray).collect::<Vec<Ray>>());
    let of_file =
        |name: &str| files.iter().find(|(found, _)| found == name).map(|(_, bytes)| sha256_of(bytes)).unwrap();
    let truth: Map<String, Value> = ARRAYS[5..10]
        .iter()
        .map(|name| format!("{name}.npy"))
        .map(|name| (name.clone(), json!(of_file(&name))))
        .collect();
    for (name, bytes) in files {
        if name == "manifest.json" {
            let mut manifest: Value = serde_json::from_slice(bytes).unwrap();
            manifest["rays_sha256"] = json!(rays_sha256);
            manifest["truth_sha256"] = json!(truth);
            *bytes = manifest.to_string().into_bytes();
        } else if name == "answers/rays_sha256" && bytes.len() == 64 {
            *bytes = rays_sha256.clone().into_bytes();
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Outcome {
    Refused,
    Read,
}

fn read(folder: &Path) -> Result<(), ExchangeError> {
    let set = exchange::read(folder)?;
    let told = answers::read(&folder.join("answers"), &set);
    drop(exchange::read_truth(folder, &set.manifest)?);
    told.map(drop)
}

/// Reads files, of which those are written that lie there otherwise.
fn reads(folder: &TempDir, there: &mut Files, files: &Files) -> Execution<Outcome> {
    fs::create_dir_all(folder.path().join("answers")).unwrap();
    for file in files.iter().filter(|file| !there.contains(file)) {
        fs::write(folder.path().join(&file.0), &file.1).unwrap();
    }
    there.clone_from(files);
    let size: usize = files.iter().map(|(_, bytes)| bytes.len()).sum();
    fuzz::execute(&ALLOCATOR, MAX_TIME, FREE + MAX_OF_FILES * size, || match read(folder.path()) {
        Ok(()) => Ok(Outcome::Read),
        Err(error) => {
            let text = error.to_string();
            let is_named = files.iter().any(|(name, _)| text.contains(name.rsplit('/').next().unwrap_or(name)));
            if is_named { Ok(Outcome::Refused) } else { Err(format!("refused without a field: {text}")) }
        }
    })
}

fn read_all(numbers: std::ops::Range<u64>) -> Tally<Outcome> {
    // Each query has a folder of its own, and every other set is of any-hit rays.
    let (_alone, sets) = (alone(), [Query::Closest, Query::Any].map(whole));
    let folders = sets.each_ref().map(|_| (tempfile::tempdir().unwrap(), RefCell::new(Vec::new())));
    // What is kept of a finding is its number.
    let of = |number: &[u8]| {
        let number = u64::from_le_bytes(number.try_into().unwrap());
        let place = (number % 2) as usize;
        let (folder, there) = &folders[place];
        reads(folder, &mut there.borrow_mut(), &damaged(&sets[place], number))
    };
    fuzz::run(numbers, |number| number.to_le_bytes().to_vec(), of)
}

/// Proves that a set is read as it was written, within the memory that is promised.
#[test]
fn whole_sets_are_read() {
    let (_alone, folder) = (alone(), tempfile::tempdir().unwrap());
    assert_eq!(reads(&folder, &mut Vec::new(), &whole(Query::Closest)).outcome, Ok(Outcome::Read));
    let other = tempfile::tempdir().unwrap();
    assert_eq!(reads(&other, &mut Vec::new(), &whole(Query::Any)).outcome, Ok(Outcome::Read));
}

/// Proves that of 2,000 damaged sets every one is refused by the name of a file or read, without a panic and within four times the bytes of
/// its files and 256 KiB; that many of either kind are among them.
#[test]
fn damaged_sets_are_refused_or_read() {
    let tally = read_all(0..2_000);
    assert_eq!(tally.findings, Vec::<u64>::new(), "{tally:?}");
    assert!(tally.count(&Outcome::Refused) > 800 && tally.count(&Outcome::Read) > 150, "{tally:?}");
}

/// The same without end: see the driver's own page.
#[test]
#[ignore = "wider set: it runs as long as it is told to"]
fn many_damaged_sets() {
    let tally = read_all(fuzz::numbers(20_000));
    assert_eq!(tally.findings, Vec::<u64>::new(), "{tally:?}");
}
