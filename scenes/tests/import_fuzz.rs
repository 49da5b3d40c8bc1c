//! Damaged files without end: the import answers each within its promises, in bounded processor time and memory.
//!
//! The driver is an ordinary test with numbered executions: execution `n` is the same file on every machine, so that a
//! finding is a number. A long run is
//!
//! ```text
//! FUZZ_EXECUTIONS=1000000 cargo test --release -p tracebench-scenes --test import_fuzz -- --ignored --nocapture
//! ```
//!
//! from execution `FUZZ_FROM` (0) on. It says every few seconds how far it is; a run that was cut off goes on from there.
//! What it finds is printed and written to the folder for temporary files; it is mended and becomes a file in
//! `scenes/fuzz/findings`, which the short run imports too.
#![allow(missing_docs)]

mod support;

use std::fs;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::time::Duration;

use peak_alloc::PeakAlloc;
use serde_json::Value;
use support::glb;
use support::mutate::{Parts, mutate};
use support::promises::{self, Outcome};
use tracebench_tests::fuzz::{self, Execution, Random, Tally, processor_time};

#[global_allocator]
static ALLOCATOR: PeakAlloc = PeakAlloc;

/// One execution at a time: memory is counted for the whole process.
static ALONE: Mutex<()> = Mutex::new(());

/// Most processor time of an execution, import and all questions about it: what else the machine does is not in it.
const MAX_TIME: Duration = Duration::from_secs(2);

/// Most memory of an execution in bytes.
const MAX_BYTES: usize = 1 << 30;

fn execute(work: impl FnOnce() -> Result<Outcome, String>) -> Execution<Outcome> {
    fuzz::execute(&ALLOCATOR, MAX_TIME, MAX_BYTES, work)
}

fn folder(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz").join(name)
}

/// The files of a folder in the order of their names.
fn files(name: &str) -> Vec<(PathBuf, Vec<u8>)> {
    let Ok(entries) = fs::read_dir(folder(name)) else {
        return Vec::new();
    };
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    paths.into_iter().map(|path| (path.clone(), fs::read(&path).unwrap())).collect()
}

/// The seeds with their buffers taken out of the data URIs.
fn seeds() -> Vec<Parts> {
    let take_apart = |(_, bytes): (PathBuf, Vec<u8>)| {
        let mut json: Value = serde_json::from_slice(&bytes).unwrap();
        let uri = json["buffers"][0].as_object_mut().unwrap().remove("uri").unwrap();
        let bin = data_url::DataUrl::process(uri.as_str().unwrap()).unwrap().decode_to_vec().unwrap().0;
        Parts { json, bin }
    };
    files("seeds").into_iter().map(take_apart).collect()
}

/// The file of execution `number`.
fn damaged(seeds: &[Parts], number: u64) -> Vec<u8> {
    let mut random = Random::of_execution(number);
    let (seed, donor) = (random.below(seeds.len()), random.below(seeds.len()));
    mutate(&mut random, &seeds[seed], &seeds[donor])
}

/// Runs executions.
fn run(numbers: Range<u64>) -> Tally<Outcome> {
    let _alone = ALONE.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
    let seeds = seeds();
    fuzz::run(numbers, |number| damaged(&seeds, number), |file| execute(|| promises::check(file)))
}

/// Proves that every seed is imported as it is, and that some of them move: damage starts from sound files.
#[test]
fn seeds_are_sound() {
    let outcomes: Vec<Outcome> = files("seeds").iter().map(|(_, bytes)| promises::check(bytes).unwrap()).collect();
    assert!(outcomes.len() >= 7 && !outcomes.contains(&Outcome::Refused), "{outcomes:?}");
    assert!(outcomes.iter().filter(|&&outcome| outcome == Outcome::Moving).count() >= 4, "{outcomes:?}");
    for seed in seeds() {
        assert_ne!(promises::check(&glb(seed.json.to_string().as_bytes(), &seed.bin)), Ok(Outcome::Refused));
    }
}

/// Proves that what once was found stays mended.
#[test]
fn findings_stay_mended() {
    let _alone = ALONE.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
    for (path, bytes) in files("findings") {
        let execution = execute(|| promises::check(&bytes));
        assert!(execution.outcome.is_ok(), "{}: {:?}", path.display(), execution.outcome);
    }
}

/// Proves on the first executions that no promise is broken, and that the damage is of the right strength: a good part
/// is refused, a good part is still imported.
#[test]
fn first_executions() {
    let tally = run(0..20_000);
    assert_eq!(tally.findings, [] as [u64; 0]);
    for outcome in [Outcome::Refused, Outcome::Still, Outcome::Moving] {
        assert!(tally.count(&outcome) > 1_000, "{tally:?}");
    }
}

/// Proves that the driver is not blind: panics, time and memory beyond the limits, and broken promises are findings.
#[test]
fn limits_are_noticed() {
    let _alone = ALONE.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
    let mut tally = Tally::default();
    tally.add(0, execute(|| Ok(Outcome::Still)));
    tally.add(1, execute(|| panic!("as wanted by the test")));
    tally.add(
        2,
        execute(|| {
            let begin = processor_time();
            while processor_time().zip(begin).is_some_and(|(now, begin)| now <= begin + MAX_TIME) {}
            Ok(Outcome::Still)
        }),
    );
    tally.add(
        3,
        execute(|| {
            drop(std::hint::black_box(Vec::<u8>::with_capacity(MAX_BYTES + 1)));
            Ok(Outcome::Still)
        }),
    );
    let mut scene = support::Doc::square().import().unwrap();
    scene.mesh.triangles[0][0] = 99;
    tally.add(4, execute(|| promises::check_scene(&scene)));
    // Without a clock of the processor no execution takes too long.
    let timed = processor_time().is_some();
    let expected = if timed { (vec![1, 2, 3, 4], 1) } else { (vec![1, 3, 4], 2) };
    assert_eq!((tally.findings.clone(), tally.count(&Outcome::Still)), expected);
}

/// As [`first_executions`], for as long as one likes.
#[test]
#[ignore = "wider set: a million executions, or as many as FUZZ_EXECUTIONS says"]
fn many_executions() {
    let tally = run(fuzz::numbers(1_000_000));
    assert_eq!(tally.findings, [] as [u64; 0]);
}
