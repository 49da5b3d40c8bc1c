//! The committed records: which of them are of another version than this program, and measuring these anew.
//!
//! `cargo run --release --example results` measures them by the commands of results/manifest.json, first those that README quotes, then
//! those of docs/, of claims, and others; `-- --budget 2h` ends before what would take longer, and the same command goes on. `-- --check`
//! lists them and fails where README quotes one. `-- --answers` traces once what is stale, measures nothing, and keeps in the manifest whose
//! answers are still the same. `-- FOLDER...` is about some folders alone, stale or not. What another machine measured is dated, and left to it.

use std::collections::{BTreeMap, BTreeSet};
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};
use std::time::{Duration, Instant};

use clap::Parser;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use sha2::Digest as _;
use tracebench_harness::machine;
use tracebench_harness::render::cut;
use tracebench_harness::report::unpacked;
use tracebench_harness::results::{RULES_VERSION, Record};

/// A committed record.
#[derive(Debug, Deserialize, Serialize)]
struct Entry {
    /// Its folder below results/.
    folder: String,
    /// Words of `tracebench`, without `--out`.
    command: String,
    /// How long it took; of one that was not measured by this tool what its interleaved sets took.
    minutes: f64,
    /// Makes what it needs, such as a mesh by a script; a line of the shell.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    before: Option<String>,
    /// By which versions of its tracers a re-run gave the same hits.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    answers: String,
    /// Of moving scenes which pictures are kept: scene, effect and frame.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    stills: Option<(String, String, u32)>,
    /// The machine that alone can measure it: one with a GPU.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    machine: Option<String>,
}

/// What needs a record, most important first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Need {
    Readme,
    Docs,
    Claim,
    Nothing,
}

/// Measures committed records anew by the commands of results/manifest.json.
#[derive(Parser)]
struct Asked {
    /// List them, and fail where README quotes one.
    #[arg(long)]
    check: bool,
    /// Trace once what is stale, measure nothing, and keep in the manifest whose answers are still the same.
    #[arg(long)]
    answers: bool,
    /// End before what would take longer, such as 2h.
    #[arg(long, value_name = "TIME", value_parser = humantime::parse_duration)]
    budget: Option<Duration>,
    /// Of some folders alone.
    folders: Vec<String>,
}

fn main() -> ExitCode {
    match work(&root(), Asked::parse()) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(reason) => {
            eprintln!("error: {reason}");
            ExitCode::from(2)
        }
    }
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// Lists or measures; false where README quotes what is stale, or a measurement failed.
fn work(root: &Path, mut asked: Asked) -> Result<bool, String> {
    for folder in &mut asked.folders {
        *folder = folder.trim_end_matches('/').trim_start_matches("results/").to_owned();
    }
    let path = root.join("results/manifest.json");
    let text = read(&path)?;
    let mut entries: Vec<Entry> =
        serde_json::from_str(&text).map_err(|error| format!("{}: {error}", path.display()))?;
    if let Some(unknown) = asked.folders.iter().find(|folder| !entries.iter().any(|entry| entry.folder == **folder)) {
        return Err(format!("results/manifest.json has no folder {unknown}"));
    }
    let needs = needs(root, &entries)?;
    let mut stale = Vec::new();
    for (place, entry) in entries.iter().enumerate() {
        let is_named = asked.folders.contains(&entry.folder);
        let is_asked = is_named || asked.folders.is_empty();
        // One that is named is measured in any case: its command may have changed.
        let named = (is_named && !asked.check).then(|| "asked for".to_owned());
        if let (true, Some(why)) = (is_asked, staleness(root, &entries, entry)?.or(named)) {
            stale.push((needs[&entry.folder], place, why));
        }
    }
    // Pages with claims come last of their kind: they are made of the others.
    stale.sort_by_key(|(need, place, _)| (*need, *place));
    for (need, place, why) in &stale {
        let Entry { folder, minutes, .. } = &entries[*place];
        println!("{folder}: {why}; needed by {}; {minutes:.0} min", format!("{need:?}").to_lowercase());
    }
    let minutes = stale.iter().fold(0.0, |sum, (_, place, _)| sum + entries[*place].minutes);
    println!("{} of {} records are stale, {:.1} hours", stale.len(), entries.len(), minutes / 60.0);
    if asked.check {
        return Ok(stale.iter().all(|(need, ..)| *need != Need::Readme));
    }
    // By the program of this source: one that was built before would name another commit.
    let build = ["build", "--release", "--quiet", "--bin", "tracebench"];
    let built =
        Command::new("cargo").args(build).current_dir(root).status().map_err(|error| format!("cargo: {error}"))?;
    if !built.success() {
        return Err("tracebench was not built, see above".to_owned());
    }
    let (begun, mut all_done) = (Instant::now(), true);
    for (_, place, _) in stale {
        let entry = &entries[place];
        let expected = Duration::from_secs_f64(60.0 * entry.minutes);
        if asked.budget.is_some_and(|budget| begun.elapsed() + expected > budget) {
            println!("{}: left for want of time", entry.folder);
            continue;
        }
        let done = if asked.answers { answer_again(root, entry) } else { measure(root, entry) };
        match done {
            Ok((minutes, answers)) => {
                (entries[place].minutes, entries[place].answers) = ((10.0 * minutes).round() / 10.0, answers);
                let text = serde_json::to_string_pretty(&entries).map_err(|error| error.to_string())?;
                std::fs::write(&path, text + "\n").map_err(|error| error.to_string())?;
            }
            Err(reason) => {
                all_done = false;
                eprintln!("error: {}: {reason}", entry.folder);
            }
        }
    }
    Ok(all_done)
}

fn read(path: &Path) -> Result<String, String> {
    std::fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()))
}

/// The record of a folder: that of a run, or of the clock.
fn record(folder: &Path) -> Result<Option<Value>, String> {
    let names = ["run.json", "run.json.xz", "clock.json", "clock.json.xz"].map(|name| folder.join(name));
    let Some(path) = names.iter().find(|path| path.exists()) else { return Ok(None) };
    let bytes = unpacked(path).map_err(|error| error.to_string())?;
    serde_json::from_slice(&bytes).map(Some).map_err(|error| format!("{}: {error}", path.display()))
}

/// Why a record is not of this program, if it is not. What is made of other records is stale where one of them is.
fn staleness(root: &Path, entries: &[Entry], entry: &Entry) -> Result<Option<String>, String> {
    if entry.command.contains(" --from ") {
        let of = mentioned(&entry.command, entries);
        let stale = of.into_iter().filter(|other| staleness(root, entries, other).is_ok_and(|why| why.is_some()));
        let stale: Vec<&str> = stale.map(|other| other.folder.as_str()).collect();
        return Ok((!stale.is_empty()).then(|| format!("made of {}", stale.join(", "))));
    }
    let Some(record) = record(&root.join("results").join(&entry.folder))? else {
        return Ok(Some("no record".to_owned()));
    };
    if let Some(machine) = &entry.machine {
        println!("{}: measured on {machine}, {}", entry.folder, record["started"].as_str().unwrap_or("undated"));
        return Ok(None);
    }
    let rules = record["rules_version"].as_u64().unwrap_or(0);
    if rules != u64::from(RULES_VERSION) {
        return Ok(Some(format!("rules version {rules}")));
    }
    if record["dirty"].as_bool() == Some(true) {
        return Ok(Some("of a changed tree, no commit".to_owned()));
    }
    let rows = if record["rows"].is_null() { vec![&record] } else { rows(&record).collect() };
    let is_other = |row: &&&Value| row["fingerprint"].as_str() != tracer_of(row).and_then(machine::fingerprint);
    let other: BTreeSet<&str> = rows.iter().filter(is_other).filter_map(|row| tracer_of(row)).collect();
    let is_answered = entry.answers == versions(&record);
    let has_times = |trace: &Value| trace["samples_ms"].as_array().is_some_and(|samples| !samples.is_empty());
    let is_timed = record["rows"].is_null() || !record["frames"].is_null() || traces(&record).any(has_times);
    if other.is_empty() || is_answered && !is_timed {
        return Ok(None);
    }
    let other = other.into_iter().collect::<Vec<_>>().join(", ");
    let answers = if is_answered { ", whose answers are the same" } else { "" };
    Ok(Some(format!("another version of {other}{answers}")))
}

fn tracer_of(row: &Value) -> Option<&str> {
    row["tracer"]["name"].as_str().or(row["tracer"].as_str())
}

/// Its rows, and its frames' but for controls.
fn rows(record: &Value) -> impl Iterator<Item = &Value> {
    let frames = record["frames"]["rows"].as_array().into_iter().flatten();
    let frames = frames.filter(|row| row["tracer"]["preset"] != "control");
    record["rows"].as_array().into_iter().flatten().chain(frames)
}

fn traces(record: &Value) -> impl Iterator<Item = &Value> {
    rows(record).flat_map(|row| row["traces"].as_array().into_iter().flatten())
}

/// What this program's versions of a record's tracers are called.
fn versions(record: &Value) -> String {
    let tracers: BTreeSet<&str> = rows(record).filter_map(tracer_of).collect();
    tracers.into_iter().filter_map(machine::fingerprint).map(|version| &version[..8]).collect::<Vec<_>>().join(" ")
}

/// The hits of each trace of a record, by place.
fn hits(record: &Value) -> Vec<[&str; 2]> {
    traces(record)
        .map(|trace| ["rays_sha256", "hits_sha256"].map(|key| trace[key].as_str().unwrap_or_default()))
        .collect()
}

/// The entries that a text names by files or folders below results/.
fn mentioned<'a>(text: &str, entries: &'a [Entry]) -> Vec<&'a Entry> {
    let ends = |next: char| !(next.is_ascii_alphanumeric() || "-_/.".contains(next));
    let paths = text.split("results/").skip(1).map(|rest| rest.split(ends).next().unwrap_or_default());
    let of = |path: &str| {
        let holds = |entry: &&Entry| {
            path.strip_prefix(&entry.folder).is_some_and(|rest| rest.is_empty() || rest.starts_with('/'))
        };
        entries.iter().filter(holds).max_by_key(|entry| entry.folder.len())
    };
    paths.filter_map(of).collect()
}

/// What needs each record: pages by links and by quoted figures, claims by what they are made of.
fn needs(root: &Path, entries: &[Entry]) -> Result<BTreeMap<String, Need>, String> {
    let figures: BTreeMap<String, String> =
        serde_json::from_str(&read(&root.join("results/figures.json"))?).map_err(|error| error.to_string())?;
    let mut needs: BTreeMap<String, Need> = entries.iter().map(|entry| (entry.folder.clone(), Need::Nothing)).collect();
    let mut note = |text: &str, need: Need| {
        for entry in mentioned(text, entries) {
            let known = needs.get_mut(&entry.folder).expect("every entry has one");
            *known = need.min(*known);
        }
    };
    let docs = std::fs::read_dir(root.join("docs")).map_err(|error| error.to_string())?;
    let docs = docs.filter_map(|entry| Some((entry.ok()?.path(), Need::Docs)));
    let docs = docs.filter(|(path, _)| path.extension().is_some_and(|ending| ending == "md"));
    for (path, need) in docs.chain([(root.join("README.md"), Need::Readme)]) {
        let text = read(&path)?;
        note(&text, need);
        let quoted = text.split("<!--").skip(1).filter_map(|rest| figures.get(rest.split("-->").next()?));
        quoted.for_each(|figure| note(figure, need));
    }
    for entry in entries.iter().filter(|entry| entry.command.contains(" --from ")) {
        note(&entry.command, Need::Claim);
    }
    Ok(needs)
}

/// Measures a record below target/results and puts it in the place of the committed one, with the pages that stood there. Gives minutes, and
/// the versions that answered.
fn measure(root: &Path, entry: &Entry) -> Result<(f64, String), String> {
    let (folder, scratch) = (root.join("results").join(&entry.folder), root.join("target/results").join(&entry.folder));
    let git = Command::new("git").args(["status", "--porcelain", "--"]).arg(&folder).current_dir(root).output();
    if git.is_ok_and(|output| !output.stdout.is_empty()) {
        return Err(format!("{} has changes that are not committed: commit them or take them back", folder.display()));
    }
    // One that is complete is of a measurement before, perhaps by another program.
    if record(&scratch)?.is_some() {
        std::fs::remove_dir_all(&scratch).map_err(|error| error.to_string())?;
    }
    prepare(root, entry)?;
    let (begun, others) = (Instant::now(), ticks_of_others());
    let words: Vec<&str> = entry.command.split(' ').collect();
    let goes_on = !words.contains(&"--from") && !["doctor", "judge"].contains(&words[0]);
    let more: &[&str] = if goes_on { &["--resume"] } else { &[] };
    let plan = || std::fs::read(scratch.join("interleaved_sets/plan.json")).ok();
    let begun_before = plan();
    if let Err(reason) = run(root, &words, &scratch, more) {
        // Who goes on with a plan writes so into it. One that is as before was refused: another machine or program began it.
        if begun_before.is_none() || plan() != begun_before {
            return Err(reason);
        }
        std::fs::remove_dir_all(&scratch).map_err(|error| error.to_string())?;
        run(root, &words, &scratch, &[])?;
    }
    let taken = (ticks_of_others() - others) / TICKS_PER_S / begun.elapsed().as_secs_f64();
    if taken > 0.1 {
        eprintln!("{}: another job took {taken:.1} cores: times are of a busy machine", entry.folder);
    }
    install(&scratch, &folder, words[0]).map_err(|error| format!("{}: {error}", folder.display()))?;
    if let Some(stills) = &entry.stills {
        keep_stills(&scratch, &folder, stills).map_err(|reason| format!("{}: {reason}", folder.display()))?;
    }
    let answered = record(&scratch)?.map(|record| versions(&record)).unwrap_or_default();
    Ok((begun.elapsed().as_secs_f64() / 60.0, answered))
}

/// Traces a record's rays once more, without times; gives the versions whose answers are those of the record.
fn answer_again(root: &Path, entry: &Entry) -> Result<(f64, String), String> {
    let scratch = root.join("target/results-answers").join(&entry.folder);
    if entry.command.contains(" --from ") {
        return Ok((entry.minutes, String::new()));
    }
    if scratch.exists() {
        std::fs::remove_dir_all(&scratch).map_err(|error| error.to_string())?;
    }
    prepare(root, entry)?;
    let mut words: Vec<&str> = entry.command.split(' ').collect();
    if let Some(place) = words.iter().position(|word| *word == "--samples") {
        words.drain(place..place + 2);
    }
    let is_timed = words[0] != "stability" && words[0] != "explain" && !words.contains(&"--choose");
    run(root, &words, &scratch, if is_timed { &["--samples", "1"] } else { &[] })?;
    let before = record(&root.join("results").join(&entry.folder))?;
    match (before, record(&scratch)?) {
        (Some(before), Some(now)) if !hits(&now).is_empty() && hits(&now) == hits(&before) => {
            Ok((entry.minutes, versions(&now)))
        }
        _ => Err("other answers than the record's: measure it anew".to_owned()),
    }
}

/// Makes what a record needs.
fn prepare(root: &Path, entry: &Entry) -> Result<(), String> {
    let Some(before) = &entry.before else { return Ok(()) };
    let ended = Command::new("sh").args(["-c", before]).current_dir(root).status();
    match ended.map_err(|error| error.to_string())? {
        ended if ended.success() => Ok(()),
        ended => Err(format!("{before}: {ended}")),
    }
}

fn run(root: &Path, words: &[&str], out: &Path, more: &[&str]) -> Result<(), String> {
    println!("tracebench {}", words.join(" "));
    let mut command = Command::new(root.join("target/release/tracebench"));
    command.args(words).arg("--out").arg(out).args(more).current_dir(root);
    let ended = command.status().map_err(|error| format!("target/release/tracebench: {error}"))?;
    if ended.success() { Ok(()) } else { Err(ended.to_string()) }
}

/// Of Linux's clock of processes.
const TICKS_PER_S: f64 = 100.0;

/// The time that cores have spent on other processes than this one and those that it has waited for; 0 where the system does not tell.
fn ticks_of_others() -> f64 {
    let numbers = |path: &str| -> Vec<f64> {
        let text = std::fs::read_to_string(path).unwrap_or_default();
        let line = text.lines().next().unwrap_or_default();
        // A process's name may have anything in it, in brackets.
        let after = line.rsplit_once(')').map_or(line, |(_, after)| after);
        after.split_whitespace().skip(1).filter_map(|number| number.parse().ok()).collect()
    };
    // user, nice, system, idle, iowait, irq, softirq, steal, and guests, which user has in it; of a process from its parent's number on.
    let (all, own) = (numbers("/proc/stat"), numbers("/proc/self/stat"));
    let sum = |all: &[f64], places: &[usize]| places.iter().filter_map(|place| all.get(*place)).sum::<f64>();
    sum(&all, &[0, 1, 2, 5, 6, 7]) - sum(&own, &[10, 11, 12, 13])
}

/// Takes over the record, of what derives from it the pages that were there before, or that of its verb, and the charts that these show. What
/// no longer derives from it goes.
fn install(scratch: &Path, folder: &Path, verb: &str) -> std::io::Result<()> {
    std::fs::create_dir_all(folder)?;
    let mut packed_files = String::new();
    for name in ["run.json", "clock.json"] {
        let Ok(bytes) = std::fs::read(scratch.join(name)) else { continue };
        let mut packed = liblzma::write::XzEncoder::new(Vec::new(), 9);
        packed.write_all(&bytes)?;
        let _ = std::fs::remove_file(folder.join(name));
        let packed = packed.finish()?;
        let hash = data_encoding::HEXLOWER.encode(&sha2::Sha256::digest(&packed));
        packed_files += &format!("{hash}  {name}.xz\n");
        std::fs::write(folder.join(format!("{name}.xz")), packed)?;
    }
    let mut names: BTreeSet<String> = BTreeSet::new();
    for before in std::fs::read_dir(folder)? {
        let before = before?;
        let name = before.file_name().to_string_lossy().into_owned();
        if before.path().is_dir() || name.ends_with(".json.xz") {
            continue;
        }
        if !scratch.join(&name).is_file() {
            println!("{} is no longer made", before.path().display());
            std::fs::remove_file(before.path())?;
        }
        names.insert(name);
    }
    if !names.iter().any(|name| name.ends_with(".md")) {
        names.insert(if verb == "run" { "scenes.md".to_owned() } else { format!("{verb}.md") });
    }
    for page in names.clone().into_iter().filter(|name| name.ends_with(".md")) {
        let text = std::fs::read_to_string(scratch.join(page)).unwrap_or_default();
        names.extend(text.split("](").skip(1).filter_map(|rest| Some(rest.split_once(')')?.0.to_owned())));
    }
    for name in names.into_iter().filter(|name| !name.contains('/') && scratch.join(name).is_file()) {
        std::fs::copy(scratch.join(&name), folder.join(name))?;
    }
    // Where the program's list of its files is kept, what was packed is on it, too.
    if let Ok(mut list) = std::fs::OpenOptions::new().append(true).open(folder.join("tracebench.sha256")) {
        list.write_all(packed_files.as_bytes())?;
    }
    Ok(())
}

/// Cuts one frame of an effect out of each tracer's sheet of pictures: `still_TRACER.png`, the answer above its error, and the truth alone.
fn keep_stills(scratch: &Path, folder: &Path, (scene, effect, frame): &(String, String, u32)) -> Result<(), String> {
    let record = record(scratch)?.ok_or("there is no record")?;
    let record: Record = serde_json::from_value(record).map_err(|error| error.to_string())?;
    let frames = record.frames.ok_or("the record has no frames")?;
    let place = frames.scenes.iter().position(|of| of.scene.name == *scene).ok_or(format!("no scene {scene}"))?;
    let truth = frames.scenes[place].pictures.get(effect).map(|pictures| ("truth".to_owned(), pictures, 1));
    let of_scene = frames.rows.iter().filter(|row| row.scene as usize == place);
    let answers = of_scene.filter_map(|row| Some((row.tracer.label(), row.pictures.get(effect)?, 2)));
    for (label, pictures, rows) in truth.into_iter().chain(answers) {
        let bytes = std::fs::read(scratch.join("pictures").join(&pictures.sheet)).map_err(|error| error.to_string())?;
        let place = [frame % pictures.columns, rows * (frame / pictures.columns)];
        let still = cut(&bytes, frames.size, place, rows);
        let stem: String = label.chars().map(|one| if one.is_ascii_alphanumeric() { one } else { '_' }).collect();
        let still = still.map_err(|error| format!("{}: {error}", pictures.sheet))?;
        std::fs::write(folder.join(format!("still_{stem}.png")), still).map_err(|error| error.to_string())?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entries() -> Vec<Entry> {
        serde_json::from_str(&read(&root().join("results/manifest.json")).unwrap()).unwrap()
    }

    fn entry(folder: &str, command: &str) -> Entry {
        serde_json::from_value(serde_json::json!({ "folder": folder, "command": command, "minutes": 1.0 })).unwrap()
    }

    /// Proves that every committed record is in the manifest, and that what README quotes is needed by it. The negative control is an entry
    /// that nothing needs.
    #[test]
    fn every_record_is_in_the_manifest() {
        let mut entries = entries();
        let (mut folders, mut records) = (vec![root().join("results")], 0);
        while let Some(folder) = folders.pop() {
            for path in std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
                if path.is_dir() {
                    folders.push(path);
                } else if ["run.json", "run.json.xz", "clock.json", "clock.json.xz"]
                    .iter()
                    .any(|name| path.ends_with(name))
                {
                    records += 1;
                    assert!(!mentioned(path.to_str().unwrap(), &entries).is_empty(), "{}", path.display());
                }
            }
        }
        assert!(records > entries.len() / 2, "{records}");
        entries.push(entry("no-such", "run"));
        let needs = needs(&root(), &entries).unwrap();
        assert_eq!((needs["software-pareto"], needs["no-such"]), (Need::Readme, Need::Nothing));
        assert_eq!(needs["software-wkp15/table2"], Need::Claim);
    }

    /// Proves that records without a fingerprint, of other rules, of another fingerprint and made of such are stale, and that those of this
    /// program are not.
    #[test]
    fn what_another_version_measured_is_stale() {
        let root = tempfile::tempdir().unwrap();
        let entries = vec![entry("a", "run"), entry("b", "table x-claims --from results/a")];
        let why = |place: usize| staleness(root.path(), &entries, &entries[place]).unwrap();
        let write = |rules: u32, fingerprint: Option<&str>| {
            let row = serde_json::json!({ "tracer": { "name": "dirt" }, "fingerprint": fingerprint });
            let record = serde_json::json!({ "rules_version": rules, "rows": [row] });
            std::fs::create_dir_all(root.path().join("results/a")).unwrap();
            std::fs::write(root.path().join("results/a/run.json"), record.to_string()).unwrap();
        };
        assert_eq!(why(0).as_deref(), Some("no record"));
        write(RULES_VERSION, machine::fingerprint("dirt"));
        assert_eq!((why(0), why(1)), (None, None));
        write(RULES_VERSION - 1, machine::fingerprint("dirt"));
        assert!(why(0).unwrap().starts_with("rules version"));
        for other in [None, Some("0")] {
            write(RULES_VERSION, other);
            assert_eq!(
                (why(0).unwrap(), why(1).unwrap()),
                ("another version of dirt".to_owned(), "made of a".to_owned())
            );
        }
        write(RULES_VERSION, machine::fingerprint("dirt"));
        let path = root.path().join("results/a/run.json");
        let mut record: Value = serde_json::from_str(&read(&path).unwrap()).unwrap();
        record["dirty"] = true.into();
        std::fs::write(&path, record.to_string()).unwrap();
        assert_eq!(why(0).as_deref(), Some("of a changed tree, no commit"));
    }

    /// Proves that what was broken off stays to be gone on with, and that what another program began is begun anew: by a program that writes
    /// into the plan, or refuses it, and fails.
    #[cfg(unix)]
    #[test]
    fn what_was_broken_off_is_kept() {
        use std::os::unix::fs::PermissionsExt as _;
        let root = tempfile::tempdir().unwrap();
        let sets = root.path().join("target/results/a/interleaved_sets");
        let program = root.path().join("target/release/tracebench");
        let measured = |script: &str| {
            std::fs::create_dir_all(&sets).unwrap();
            std::fs::write(sets.join("plan.json"), "begun").unwrap();
            std::fs::write(sets.join("0.json"), "ended").unwrap();
            std::fs::create_dir_all(program.parent().unwrap()).unwrap();
            std::fs::write(&program, format!("#!/bin/sh\n{script}\n")).unwrap();
            std::fs::set_permissions(&program, std::fs::Permissions::from_mode(0o755)).unwrap();
            (measure(root.path(), &entry("a", "run")).is_ok(), sets.join("0.json").exists())
        };
        assert_eq!(measured("echo resumed >> target/results/a/interleaved_sets/plan.json; exit 1"), (false, true));
        assert_eq!(measured("for word; do [ $word = --resume ] && exit 1; done; exit 0"), (true, false));
    }

    /// Proves that answers which a re-run gave again are fresh, times not; that a record of another machine is left to it; and that
    /// answers of yet another version are stale (the negative control).
    #[test]
    fn answers_stay_fresh_where_a_re_run_gives_the_same() {
        let root = tempfile::tempdir().unwrap();
        std::fs::create_dir_all(root.path().join("results/a")).unwrap();
        let write = |samples: &[f64]| {
            let trace = serde_json::json!({ "rays_sha256": "r", "hits_sha256": "h", "samples_ms": samples });
            let row = serde_json::json!({ "tracer": { "name": "dirt" }, "fingerprint": "0", "traces": [trace] });
            let record = serde_json::json!({ "rules_version": RULES_VERSION, "rows": [row] });
            std::fs::write(root.path().join("results/a/run.json"), record.to_string()).unwrap();
            record
        };
        let why = |entry: &Entry| staleness(root.path(), &[], entry).unwrap();
        let mut entry = entry("a", "run");
        entry.answers = versions(&write(&[]));
        assert_eq!(why(&entry), None);
        assert_eq!(hits(&write(&[1.0])), [["r", "h"]]);
        assert_eq!(why(&entry).unwrap(), "another version of dirt, whose answers are the same");
        entry.machine = Some("another".to_owned());
        assert_eq!(why(&entry), None);
        (entry.machine, entry.answers) = (None, "1".to_owned());
        write(&[]);
        assert_eq!(why(&entry).unwrap(), "another version of dirt");
    }
}
