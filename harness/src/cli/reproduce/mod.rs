//! `reproduce`: every step by a process of its own, so that one which fails or is out of time takes nothing with it.

mod steps;
mod turn;

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use clap::Args;
use itertools::Itertools as _;
use serde::{Deserialize, Serialize};
use tracebench_api::{AdapterChoice, Gpu};

use super::output::print;
use super::work::{fresh_folder, refuse_another};
use super::{CliError, fail, fail_for, records, refuse, stop};
use crate::files::{self, OutputFolder};
use crate::launch;
use crate::plan::{RUN_PRESETS, RunPreset};
use crate::progress::{self, Progress};
use crate::report::{self, PAGE_FILE, sheet::Sheet};
use turn::{Turn, wait_while};

#[derive(Args)]
pub(super) struct ReproduceArguments {
    /// How long it may take, the report and all: like 90s, 8m or 2h; or whole: every table whole, however long it takes.
    #[arg(long, value_name = "TIME|whole", default_value = "8m", value_parser = budget)]
    budget: Budget,
    /// Sets rays, resolutions, samples and scene scale: smoke, quick (default without a GPU) or paper (default on one).
    #[arg(long, value_parser = RUN_PRESETS.map(|preset| preset.name))]
    preset: Option<String>,
    /// Folder for the results, one of its own in it for every step; a new one below tracebench-out/ if not given.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Go on in --out: what had ended there is not measured again. The time that is given counts anew. Where nothing was begun it begins.
    #[arg(long, requires = "out")]
    resume: bool,
}

/// How long all may take.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Budget {
    Within(Duration),
    Whole,
}

fn budget(text: &str) -> Result<Budget, String> {
    if text == "whole" {
        return Ok(Budget::Whole);
    }
    let units = [("s", 1.0), ("m", 60.0), ("h", 3600.0)];
    let seconds =
        units.iter().find_map(|(unit, seconds)| Some(text.strip_suffix(unit)?.parse::<f64>().ok()? * seconds));
    let sound = seconds.filter(|seconds| (1.0..=1e7).contains(seconds));
    sound
        .map(|seconds| Budget::Within(Duration::from_secs_f64(seconds)))
        .ok_or_else(|| "a time from one second on, like 90s, 8m or 2h, or whole".to_owned())
}

/// What came of a step.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(rename_all = "snake_case")]
enum State {
    /// All of it was measured.
    Done,
    /// It was out of time or stopped; what had ended is kept, and `--resume` goes on with it.
    BrokenOff,
    /// It ended otherwise than well, for this reason; what it wrote is there.
    Failed(String),
    /// There was no time left.
    LeftOut,
}

/// A measurement by one of the program's own verbs, and what came of it.
#[derive(Clone, Debug, Deserialize, Serialize)]
struct Step {
    /// Its folder.
    name: String,
    /// The program's arguments, without the folder.
    arguments: Vec<String>,
    state: State,
    /// Over all that it was gone on with.
    took_s: f64,
}

impl Step {
    /// One that was not reached yet.
    fn new(name: &str, words: &str) -> Self {
        let arguments = words.split(' ').map(str::to_owned).collect();
        Self { name: name.to_owned(), arguments, state: State::LeftOut, took_s: 0.0 }
    }
}

/// What is in the folder of all.
#[derive(Debug, Deserialize, Serialize)]
struct Reproduction {
    preset: Option<String>,
    steps: Vec<Step>,
}

/// The file of [`Reproduction`].
const FILE: &str = "reproduce.json";

/// Kept for the report, share of the time that is given, and at most.
const REPORT_SHARE: f64 = 0.05;
const MAX_REPORT: Duration = Duration::from_secs(15);

/// How long pages may be behind what was measured: whoever breaks off has those of the steps until then.
const PAGES_EVERY: Duration = Duration::from_secs(120);

pub(super) fn reproduce(arguments: &ReproduceArguments, progress: &Progress) -> Result<(), CliError> {
    let begun = Instant::now();
    let ends = match arguments.budget {
        Budget::Within(time) => Some(begun + time - MAX_REPORT.min(time.mul_f64(REPORT_SHARE))),
        Budget::Whole => None,
    };
    let is_over = || ends.is_some_and(|ends| Instant::now() >= ends);
    stop::take_over();
    // Held until all is written.
    let folder = match &arguments.out {
        Some(path) => own(path, progress)?,
        None => fresh_folder()?,
    };
    let out = folder.path();
    let is_begun = out.join(FILE).exists();
    if is_begun && !arguments.resume {
        let out = out.display();
        return fail(format!(
            "{out} holds what was measured before: go on with it by --resume, or choose another folder with --out"
        ));
    }
    let earlier = if is_begun { Some(read(out)?) } else { None };
    folder.check_all(|name| [FILE, PAGE_FILE, PAGE].contains(&name)).inspect_err(|_| folder.abandon())?;
    if !is_begun {
        refuse_another(out, None)?;
    }
    let preset = preset_of(arguments.preset.as_deref(), earlier.as_ref(), out)?;
    let steps = with_preset(steps::steps(ends.is_none(), on_hardware(preset.as_deref())), preset.as_deref());
    let before = earlier.map_or_else(Vec::new, |earlier| earlier.steps);
    // There from the start: what is broken off in the first step can be gone on with.
    let mut found = Reproduction { preset, steps: as_left(steps, &before) };
    if found.steps.iter().all(|step| step.state == State::Done) {
        progress::to_stderr(&format!("the reproduction in {} is complete: nothing is measured", out.display()));
    }
    write(&folder, &found)?;
    let mut pages_written: Option<Instant> = None;
    let mut busy = None;
    for index in 0..found.steps.len() {
        // What was broken off, failed or was left out has another turn.
        let step = found.steps[index].clone();
        let state = step.state.clone();
        if state == State::Done || is_over() || stop::asked() {
            continue;
        }
        // Whoever ends this process now leaves a step that was begun.
        if state == State::LeftOut {
            found.steps[index].state = State::BrokenOff;
            write(&folder, &found)?;
        }
        let turn = Turn { step: &step, folder: out.join(&step.name), ends, launch: launch_of(out), progress };
        let (passed, count) = (begun.elapsed().as_secs(), found.steps.len());
        let what = format!("{} of {count}, after {passed} s: {}", index + 1, step.arguments.join(" "));
        let Some((now, seconds)) = turn.take(&what)? else {
            found.steps[index].state = state;
            write(&folder, &found)?;
            busy = Some(turn.folder);
            break;
        };
        found.steps[index].state = now;
        found.steps[index].took_s += seconds;
        write(&folder, &found)?;
        if !is_over() && !stop::asked() && pages_written.is_none_or(|written| written.elapsed() >= PAGES_EVERY) {
            pages(&found, &folder, begun.elapsed(), &Progress::new(true))?;
            pages_written = Some(Instant::now());
        }
    }
    let stopped = stop::hand_back();
    for path in pages(&found, &folder, begun.elapsed(), progress)? {
        print(&format!("{}\n", path.display()))?;
    }
    if let Some(signal) = stopped {
        progress::to_stderr(&stop::kept_line(&folder, arguments.out.is_some()));
        stop::end(signal);
    }
    match busy {
        Some(folder) => fail(format!(
            "another process still measures into {}; wait for it or end it, then go on with --resume",
            folder.display()
        )),
        None => outcome(&found),
    }
}

/// The folder of all, which keeps other reproductions out; one that is about to end is waited for.
fn own(out: &Path, progress: &Progress) -> Result<OutputFolder, CliError> {
    wait_while(|| OutputFolder::is_busy(out), out, None, progress);
    if let Some(signal) = if stop::asked() { stop::hand_back() } else { None } {
        stop::end(signal);
    }
    Ok(OutputFolder::open(out)?)
}

/// What is missing of the steps, for the page of what is there.
fn missing(found: &Reproduction) -> Vec<String> {
    let told = |one: &Step| match &one.state {
        State::Done => None,
        State::BrokenOff => Some(format!("{}: broken off", one.name)),
        State::Failed(reason) => Some(format!("{}: failed, {reason}", one.name)),
        State::LeftOut => Some(format!("{}: not reached", one.name)),
    };
    found.steps.iter().filter_map(told).collect()
}

/// Writes the list of steps, and the one page of what was measured of them, if anything was.
fn pages(of: &Reproduction, out: &OutputFolder, took: Duration, progress: &Progress) -> Result<Vec<PathBuf>, CliError> {
    let list = list(of, &out.path().display().to_string(), took, |step| pages_in(&out.path().join(&step.name)));
    let mut written = vec![out.write(PAGE, list.as_bytes())?];
    let folders = of.steps.iter().map(|one| out.path().join(&one.name));
    let records: Vec<PathBuf> = folders.filter(|folder| report::read_run(folder).is_ok()).collect();
    if !records.is_empty() {
        let answer = out.path().join(PAGE_FILE);
        records::write_page(&answer, (out, PAGE_FILE), &records, missing(of), progress)?;
        written.push(answer);
    }
    Ok(written)
}

/// The file of the list of steps.
const PAGE: &str = "reproduce.md";

/// The pages in a step's folder, in the order of their names.
fn pages_in(folder: &Path) -> Vec<String> {
    let names = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let names = names.map(|entry| entry.file_name().to_string_lossy().into_owned());
    names.filter(|name| name.ends_with(".md")).sorted().collect()
}

/// The list of steps, with what was measured, where it stands and what was left out.
fn list(found: &Reproduction, out: &str, took: Duration, pages: impl Fn(&Step) -> Vec<String>) -> String {
    let done = found.steps.iter().filter(|step| step.state == State::Done).count();
    let mut text = format!(
        "# Reproduction: {done} of {} steps, this time in {} s\n\nEvery page names its machine, and how much of its table was measured.\n\n",
        found.steps.len(),
        took.as_secs()
    );
    let sheet = Sheet::<&Step>::new()
        .column("step", |step| step.name.clone())
        .column("state", |step| match &step.state {
            State::Done => "measured".to_owned(),
            State::BrokenOff => "broken off, gone on with by `--resume`".to_owned(),
            State::Failed(reason) => format!("failed: {reason}"),
            State::LeftOut => "left out".to_owned(),
        })
        .column("took (s)", |step| format!("{:.0}", step.took_s))
        .column("pages", |step| {
            let link = |page: String| format!("[{page}]({}/{page})", step.name);
            pages(step).into_iter().map(link).join(", ")
        })
        .column("by itself", |step| command(step));
    let (left, taken): (Vec<&Step>, _) = found.steps.iter().partition(|step| step.state == State::LeftOut);
    text += &sheet.table(&taken).markdown();
    if !left.is_empty() {
        text += "\n## Left out\n\nThese were not reached. With more time `reproduce` goes on:\n\n```sh\n";
        let _ = writeln!(text, "tracebench reproduce --out {out} --resume --budget 1h\n```\n");
        for step in left {
            let _ = writeln!(text, "- {}: {}", step.name, command(step));
        }
    }
    text
}

fn command(step: &Step) -> String {
    format!("`tracebench {}`", step.arguments.join(" "))
}

/// The preset of all steps: the one that the folder was begun with, where it is gone on with.
fn preset_of(asked: Option<&str>, earlier: Option<&Reproduction>, out: &Path) -> Result<Option<String>, CliError> {
    let asked = asked.map(str::to_owned);
    let Some(earlier) = earlier else { return Ok(asked) };
    if asked.is_none() || asked == earlier.preset {
        return Ok(earlier.preset.clone());
    }
    let begun = earlier.preset.as_ref().map_or("without --preset".to_owned(), |name| format!("with --preset {name}"));
    let out = out.display();
    refuse(format!("{out} was begun {begun}: leave --preset out to go on with it, or choose another folder with --out"))
}

/// Whether times are those of hardware: by the preset that is meant for it, else by the adapter that would be taken.
fn on_hardware(preset: Option<&str>) -> bool {
    let by_adapter = || {
        let gpu = AdapterChoice::from_environment(None, None).and_then(|choice| Gpu::open(&choice));
        gpu.is_ok_and(|gpu| !gpu.is_software())
    };
    preset.map_or_else(by_adapter, |name| RunPreset::for_adapter(true).name == name)
}

/// Steps as they were left.
fn as_left(steps: Vec<Step>, before: &[Step]) -> Vec<Step> {
    let left = |step: &Step| before.iter().find(|one| one.arguments == step.arguments).cloned();
    steps.into_iter().map(|step| left(&step).unwrap_or(step)).collect()
}

/// Out of time is as it was asked for; steps that failed are not.
fn outcome(found: &Reproduction) -> Result<(), CliError> {
    let told = |one: &Step| match &one.state {
        State::Failed(reason) => Some(format!("{}: {reason}", one.name)),
        _ => None,
    };
    let failed: Vec<String> = found.steps.iter().filter_map(told).collect();
    fail_for(&failed, "; ", |all| format!("{} failed, the rest is kept: {all}", failed.len()))
}

/// The steps at a run preset; stability has none.
fn with_preset(mut steps: Vec<Step>, preset: Option<&str>) -> Vec<Step> {
    let Some(preset) = preset else { return steps };
    for step in steps.iter_mut().filter(|step| step.arguments[0] != "stability") {
        step.arguments.extend(["--preset".to_owned(), preset.to_owned()]);
    }
    steps
}

/// The means of the first step that has ended: all others take the same, and none probes again.
fn launch_of(out: &Path) -> Option<String> {
    if std::env::var_os(launch::VARIABLE).is_some_and(|text| !text.is_empty()) {
        return None;
    }
    let found = read(out).ok()?;
    let done = found.steps.iter().filter(|one| one.state == State::Done);
    done.filter_map(|one| report::read_run(&out.join(&one.name)).ok()?.provenance.launch)
        .map(|record| record.launch.describe())
        .next()
}

fn write(out: &OutputFolder, found: &Reproduction) -> Result<(), CliError> {
    out.write(FILE, &files::json(FILE, found)?)?;
    Ok(())
}

fn read(out: &Path) -> Result<Reproduction, CliError> {
    let path = out.join(FILE);
    let broken = |reason: String| {
        CliError::Other(format!(
            "cannot read {}: {reason}; remove it and leave --resume out: what was measured below {} is kept and gone on with",
            path.display(),
            out.display()
        ))
    };
    let text = std::fs::read(&path).map_err(|error| broken(error.to_string()))?;
    serde_json::from_slice(&text).map_err(|error| broken(error.to_string()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn begun_with(preset: Option<&str>) -> Reproduction {
        Reproduction { preset: preset.map(str::to_owned), steps: Vec::new() }
    }

    /// Proves that a folder is gone on with by the preset that it was begun with, and that another one is refused.
    #[test]
    fn presets_stay_as_they_were_begun() {
        let of =
            |asked: Option<&str>, earlier: Option<Reproduction>| preset_of(asked, earlier.as_ref(), Path::new("out"));
        assert_eq!(of(Some("smoke"), None).unwrap().as_deref(), Some("smoke"));
        assert_eq!(of(None, Some(begun_with(Some("smoke")))).unwrap().as_deref(), Some("smoke"));
        assert_eq!(of(Some("smoke"), Some(begun_with(Some("smoke")))).unwrap().as_deref(), Some("smoke"));
        assert!(of(Some("quick"), Some(begun_with(Some("smoke")))).is_err());
        assert!(of(Some("quick"), Some(begun_with(None))).is_err());
    }

    /// Proves that steps which were not reached are kept as they were left, and new ones as left out.
    #[test]
    fn steps_are_kept_as_they_were_left() {
        let all = with_preset(steps::steps(false, false), Some("smoke"));
        let failed = Step { state: State::Failed("no room".to_owned()), took_s: 3.0, ..all[1].clone() };
        let rest = as_left(all[..3].to_vec(), std::slice::from_ref(&failed));
        assert_eq!(
            rest.iter().map(|one| &one.state).collect::<Vec<_>>(),
            [&State::LeftOut, &failed.state, &State::LeftOut]
        );
    }

    fn step(name: &str, state: State) -> Step {
        Step { name: name.to_owned(), arguments: vec!["table".to_owned(), name.to_owned()], state, took_s: 1.6 }
    }

    /// Proves that the page counts what was measured, links its pages, tells why a step failed, and lists what was left out and nothing
    /// else there.
    #[test]
    fn the_page_tells_what_is_there_and_what_is_not() {
        let steps = vec![
            step("first", State::Done),
            step("second", State::Failed("no | room".to_owned())),
            step("third", State::BrokenOff),
            step("fourth", State::LeftOut),
        ];
        let found = Reproduction { preset: None, steps };
        let text = list(&found, "here", Duration::from_secs(9), |step| vec![format!("{}.md", step.name)]);
        assert!(text.starts_with("# Reproduction: 1 of 4 steps, this time in 9 s"));
        let line = |name: &str| text.lines().find(|line| line.contains(name)).unwrap().to_owned();
        assert!(line("| first").contains("measured | 2 | [first.md](first/first.md)"), "{text}");
        assert!(line("| second").contains("no \\| room"), "{text}");
        assert!(line("| third").contains("broken off"));
        let (before, after) = text.split_once("## Left out").unwrap();
        assert!(
            after.contains("- fourth: `tracebench table fourth`")
                && !after.contains("third")
                && !before.contains("fourth")
        );
        assert!(after.contains("--out here --resume"));
    }
}
