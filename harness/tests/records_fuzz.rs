//! Damaged records without end: each is refused or read within its promises, and what is read goes through every verb that reads records.
//!
//! The driver is that of the importer (`scenes/tests/import_fuzz.rs`). A long run is
//!
//! ```text
//! FUZZ_EXECUTIONS=1000000 cargo test --release -p tracebench-harness --test records_fuzz -- --ignored --nocapture many_reads
//! FUZZ_EXECUTIONS=20000 cargo test --release -p tracebench-harness --test records_fuzz -- --ignored --nocapture many_reports
//! ```
//!
//! from execution `FUZZ_FROM` (0) on. What is found is mended and becomes a file in `harness/fuzz/findings`, which the short run takes too.
//! Seeds are records of small runs of every verb, with fewer rows than they had.
#![allow(missing_docs)]

#[path = "exchange/mod.rs"]
mod exchange;

use std::io::Read as _;
use std::ops::Range;
use std::path::Path;
use std::sync::Mutex;
use std::time::Duration;

use peak_alloc::PeakAlloc;
use serde_json::{Value, json};
use tracebench_harness::report::{self, MAX_BYTES, Makers};
use tracebench_harness::results::{CHOOSE, Record, merge};
use tracebench_harness::statistics::median;
use tracebench_harness::{compare, papers, tables};
use tracebench_tests::fuzz::{self, Execution, Random, Tally, Vocabulary};

#[global_allocator]
static ALLOCATOR: PeakAlloc = PeakAlloc;

/// One execution at a time: memory is counted for the whole process.
static ALONE: Mutex<()> = Mutex::new(());

/// Most processor time of an execution.
const MAX_TIME: Duration = Duration::from_secs(2);

/// Most memory of reading, in bytes of the document, and beyond that of reporting: pages and charts of a small record are larger than it.
const MAX_OF_READING: usize = 8;
const MAX_OF_REPORTING: usize = 64;
/// Memory that is free to every execution, bytes, and beside pages: they hold their scripts, the font and the rules.
const FREE: usize = 1 << 20;
const FREE_OF_REPORTING: usize = 32 << 20;

const RECORDS: Vocabulary = Vocabulary {
    numbers: &[
        0.0,
        1.0,
        -1.0,
        0.5,
        -0.5,
        2.0,
        3.0,
        7.0,
        1e-300,
        5e-324,
        1e-30,
        1e-9,
        0.999,
        1.001,
        100.0,
        65_536.0,
        1e6,
        1e9,
        1e12,
        1e15,
        4_294_967_295.0,
        4_294_967_296.0,
        9_007_199_254_740_992.0,
        1.8e19,
        1e30,
        3.4e38,
        1e39,
        1e300,
        1.7e308,
    ],
    words: &[
        "",
        "room",
        "a/b",
        "../../x",
        "C:\\x",
        "|",
        "<script>",
        "`",
        "NaN",
        "1e999",
        "-1",
        "primary",
        "ao",
        "closest",
        "any",
        "hit",
        "surface",
        "host",
        "device_timestamps",
        "submit_to_done",
        "published",
        "improved",
        "control",
        "fresh build",
        "reuse",
        "refit, standing still",
        "bvh-cpu",
        "bvh-gpu",
        "screen-dda",
        "dirt",
        "oracle",
        "\u{2713}\u{1F600}",
        "tight",
        "smoke",
        "bvh",
        "dirt-table1",
        "known_failure",
    ],
    keys: &[
        ("invalid", "\"why\""),
        ("interleaved_set", "0"),
        ("interleaved_set", "4294967295"),
        ("resident_batch", "1"),
        ("machine", "3"),
        ("difficulty_level", "1"),
        ("surfaces", "null"),
        ("samples_ms", "[]"),
        ("samples_ms", "[1,2]"),
        ("wrong_by_remedy", "[]"),
        ("count", "0"),
        ("count", "9007199254740992"),
        ("skipped", "{}"),
        ("skipped", "[]"),
        ("table", "\"bvh\""),
        ("table", "\"dirt-table1\""),
        ("table", "null"),
        ("stale_by", "[\"geometry\"]"),
        ("frame", "[0,0]"),
        ("frame", "3"),
        ("held_out", "null"),
        ("traces", "[]"),
        ("rows", "[]"),
        ("controls", "[]"),
        ("points", "[]"),
        ("scenes", "[]"),
        ("values", "{}"),
        ("values", "[]"),
        ("own", "\"1\""),
        ("times_s", "[0]"),
        ("shard", "null"),
        ("expectation", "null"),
        ("agreement", "null"),
        ("identity", "0.5"),
        ("own_texel", "1e-30"),
        ("anchors", "[]"),
        ("interleaved_sets", "[]"),
        ("face", "0"),
        ("ray_image", "[1,4294967295]"),
        ("rays_per_pixel", "[0]"),
        ("rays_per_pixel", "[1e30]"),
        ("name", "\"../x\""),
        ("sweep", "null"),
        ("frames", "null"),
        ("pareto", "null"),
        ("need", "null"),
        ("cases", "null"),
        ("tuning", "null"),
    ],
    repeats: &[1, 1, 1, 1, 2, 2, 20, 20, 300],
};

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Outcome {
    Refused,
    Read,
    Merged,
}

fn files(name: &str) -> Vec<(String, Vec<u8>)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz").join(name);
    let entries = std::fs::read_dir(folder).into_iter().flatten();
    let mut paths: Vec<_> = entries.map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    let unpacked = |path: &Path| {
        let mut text = Vec::new();
        liblzma::read::XzDecoder::new(std::fs::File::open(path).unwrap()).read_to_end(&mut text).unwrap();
        text
    };
    paths.into_iter().map(|path| (path.display().to_string(), unpacked(&path))).collect()
}

fn seeds() -> Vec<Value> {
    files("seeds").iter().map(|(_, bytes)| serde_json::from_slice(bytes).unwrap()).collect()
}

/// Makes figures again that hang on others, so that damage gets past the first check.
fn adjust(json: &mut Value) {
    match json {
        Value::Array(items) => items.iter_mut().for_each(adjust),
        Value::Object(fields) => {
            fields.values_mut().for_each(adjust);
            let list =
                |value: Option<&Value>| -> Option<Vec<f64>> { value?.as_array()?.iter().map(Value::as_f64).collect() };
            let count = fields.get("count").and_then(Value::as_f64);
            for (samples, middle) in
                [("samples_ms", "median_ms"), ("submit_to_done_samples_ms", "submit_to_done_median_ms")]
            {
                let Some(samples) = list(fields.get(samples)).filter(|samples| !samples.is_empty()) else { continue };
                if !fields.contains_key(middle) {
                    continue;
                }
                let found = median(&samples);
                fields.insert(middle.to_owned(), json!(found));
                if middle == "median_ms" && fields.contains_key("interval_ms") {
                    fields.insert("interval_ms".to_owned(), json!([found, found]));
                }
                if let Some(count) = count.filter(|_| middle == "median_ms" && fields.contains_key("mrays_per_s")) {
                    fields.insert("mrays_per_s".to_owned(), json!(count / found / 1e3));
                }
            }
            if let (Some(count), true) = (count, fields.contains_key("statuses")) {
                fields.insert("statuses".to_owned(), json!({ "hit": count as u64 }));
            }
            for (parts, sum) in [("structure", "structure_bytes"), ("per_trace", "per_trace_bytes")] {
                let Some(parts) = fields.get(parts).and_then(Value::as_array) else { continue };
                let bytes: u64 =
                    parts.iter().filter_map(|part| part["allocated_bytes"].as_u64()).fold(0, u64::saturating_add);
                fields.insert(sum.to_owned(), json!(bytes));
            }
        }
        _ => {}
    }
}

/// The document of execution `number`.
fn damaged(seeds: &[Value], number: u64) -> Vec<u8> {
    let mut random = Random::of_execution(number);
    let (mut json, donor) = (random.pick(seeds).clone(), random.below(seeds.len()));
    let rounds = if random.once_in(8) { 3 + random.below(9) } else { 1 + random.below(2) };
    for _ in 0..rounds {
        RECORDS.mutate(&mut random, &mut json, &seeds[donor]);
    }
    if !random.once_in(4) {
        adjust(&mut json);
    }
    let mut text = json.to_string().into_bytes();
    if random.once_in(30) {
        RECORDS.duplicate_key(&mut random, &mut text);
    }
    if random.once_in(30) {
        let at = random.below(text.len());
        if random.once_in(2) { text.truncate(at) } else { text[at] ^= 1 << random.below(8) }
    }
    text
}

/// Reads a document; what is refused is refused with a reason that names a field, or says that there is no whole document.
fn read(text: &[u8]) -> Result<Result<Record, Outcome>, String> {
    match Record::read(text) {
        Ok(run) => Ok(Ok(run)),
        Err(reason) if reason.contains('`') || reason.len() > 10 => Ok(Err(Outcome::Refused)),
        Err(reason) => Err(format!("refused without a reason: {reason}")),
    }
}

fn reads(text: &[u8]) -> Execution<Outcome> {
    fuzz::execute(&ALLOCATOR, MAX_TIME, FREE + MAX_OF_READING * text.len(), || {
        Ok(read(text)?.map_or_else(|outcome| outcome, |_| Outcome::Read))
    })
}

/// Takes a record that is read through every verb that reads records; `whole` stands beside it in pages, comparisons and merges.
fn reports(text: &[u8], whole: &[(String, Record)]) -> Execution<Outcome> {
    let most = FREE_OF_REPORTING + MAX_OF_REPORTING * text.len();
    fuzz::execute(&ALLOCATOR, MAX_TIME, most, || report::without_images(|| through_every_verb(text, whole)))
}

fn through_every_verb(text: &[u8], whole: &[(String, Record)]) -> Result<Outcome, String> {
    let run = match read(text)? {
        Ok(run) => run,
        Err(outcome) => return Ok(outcome),
    };
    for (name, _) in report::contents(&run, tables::of_run).into_iter().flatten() {
        if name.is_empty() || name.contains(['/', '\\', '\0']) || name.starts_with('.') {
            return Err(format!("a file would be called {name:?}"));
        }
    }
    let mut beside: Vec<(String, Record)> = vec![("damaged".to_owned(), run.clone())];
    beside.extend(whole.iter().filter(|(_, other)| other.verb() == run.verb()).take(1).cloned());
    let makers: Makers = (tables::of_run, papers::claims_of);
    let _ = report::html_page(&beside, &[], makers, "tracebench report", MAX_BYTES).map(|page| page.html.len());
    for (_, other) in &beside {
        let found = compare::compare(("a", &run), ("b", other), 0.05);
        let _ = (report::comparison_text(&found), serde_json::to_string(&found), found.regressions());
    }
    let shards = whole.iter().filter(|(_, other)| other.provenance.shard.is_some()).map(|(_, other)| other);
    let other = |other: &&Record| {
        let index = |run: &Record| run.provenance.shard.as_ref().map(|shard| shard.index);
        index(other) != index(&run)
    };
    let joined =
        shards.filter(other).take(1).map(|other| merge(vec![beside[0].clone(), ("b".to_owned(), other.clone())]));
    match joined.flatten().next() {
        None => Ok(Outcome::Read),
        Some(whole) => {
            let _ = report::contents(&whole, tables::of_run).map(|files| files.len());
            Ok(Outcome::Merged)
        }
    }
}

fn alone() -> std::sync::MutexGuard<'static, ()> {
    ALONE.lock().unwrap_or_else(|poisoned| poisoned.into_inner())
}

fn read_all(numbers: Range<u64>) -> Tally<Outcome> {
    let (_alone, seeds) = (alone(), seeds());
    fuzz::run(numbers, |number| damaged(&seeds, number), reads)
}

fn report_all(numbers: Range<u64>) -> Tally<Outcome> {
    let (_alone, seeds) = (alone(), seeds());
    let whole: Vec<(String, Record)> =
        files("seeds").into_iter().map(|(name, text)| (name, Record::read(&text).unwrap())).collect();
    // Of each number the first that is read.
    let accepted = |number: u64| {
        let tries = (0..).map(|turn| damaged(&seeds, number * 1_000 + turn));
        tries.into_iter().find(|text| Record::read(text).is_ok()).unwrap_or_default()
    };
    fuzz::run(numbers, accepted, |text| reports(text, &whole))
}

/// Proves that every seed is read, that there is one of every verb, and that all go through every verb that reads.
#[test]
fn seeds_are_sound() {
    let _alone = alone();
    let whole: Vec<(String, Record)> =
        files("seeds").into_iter().map(|(name, text)| (name, Record::read(&text).unwrap())).collect();
    for verb in ["run", "sweep", CHOOSE, "stability", "explain", "pareto", "need", "table", "judge"] {
        assert!(whole.iter().any(|(_, run)| run.verb() == verb), "{verb}");
    }
    for (name, text) in files("seeds") {
        let execution = reports(&text, &whole);
        assert!(
            execution.outcome.is_ok(),
            "{name}: {:?}, {} bytes of {}",
            execution.outcome,
            execution.bytes,
            text.len()
        );
    }
}

/// Proves that what once was found stays mended.
#[test]
fn findings_stay_mended() {
    let _alone = alone();
    for (name, text) in files("findings") {
        let execution = reports(&text, &[]);
        assert!(execution.outcome.is_ok(), "{name}: {:?}", execution.outcome);
    }
}

/// Proves on the first executions that no promise is broken, and that the damage is of the right difficulty level: a good part is refused,
/// and a good part is read.
#[test]
fn first_reads() {
    let tally = read_all(0..1_000);
    assert_eq!(tally.findings, [] as [u64; 0]);
    assert!(tally.count(&Outcome::Refused) > 100 && tally.count(&Outcome::Read) > 200, "{tally:?}");
}

/// The same of the verbs that read records, by the first that are read.
#[test]
fn first_reports() {
    let tally = report_all(0..100);
    assert_eq!(tally.findings, [] as [u64; 0]);
    assert!(tally.count(&Outcome::Read) > 50 && tally.count(&Outcome::Merged) > 2, "{tally:?}");
}

/// Proves that the driver is not blind: a panic and memory beyond the multiple are findings.
#[test]
fn limits_are_noticed() {
    let _alone = alone();
    let mut tally = Tally::default();
    let execute = |work: fn() -> Result<Outcome, String>| fuzz::execute(&ALLOCATOR, MAX_TIME, FREE, work);
    tally.add(0, execute(|| Ok(Outcome::Read)));
    tally.add(1, execute(|| panic!("as wanted by the test")));
    tally.add(
        2,
        execute(|| {
            drop(std::hint::black_box(Vec::<u8>::with_capacity(FREE + 1)));
            Ok(Outcome::Read)
        }),
    );
    assert_eq!((tally.findings.clone(), tally.count(&Outcome::Read)), (vec![1, 2], 1));
}

/// As [`first_reads`], for as long as one likes.
#[test]
#[ignore = "wider set: a million executions, or as many as FUZZ_EXECUTIONS says"]
fn many_reads() {
    assert_eq!(read_all(fuzz::numbers(1_000_000)).findings, [] as [u64; 0]);
}

/// As [`first_reports`], for as long as one likes.
#[test]
#[ignore = "wider set: 20,000 executions, or as many as FUZZ_EXECUTIONS says"]
fn many_reports() {
    assert_eq!(report_all(fuzz::numbers(20_000)).findings, [] as [u64; 0]);
}
