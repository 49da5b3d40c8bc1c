//! A step's turn: measured by this program in a process that ends when this one does, however that ends.

use std::fs::File;
use std::io::{Read as _, Seek as _, SeekFrom};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use super::{State, Step};
use crate::cli::{CliError, stop};
use crate::files::OutputFolder;
use crate::launch;
use crate::machine;
use crate::measure::Journal;
use crate::progress::{self, Progress};
use crate::report;
use crate::results::Record;

/// How often it is asked whether a step has ended.
const PATIENCE: Duration = Duration::from_millis(50);

/// How long another process that measures into the same folder is waited for.
const MAX_WAIT: Duration = Duration::from_secs(30);

/// How long a step has to end once it is told to.
const TO_END: Duration = Duration::from_secs(2);

/// What a turn needs.
pub(super) struct Turn<'a> {
    pub step: &'a Step,
    /// Where its results go.
    pub folder: PathBuf,
    pub ends: Option<Instant>,
    /// What searches read and how they are launched, if another step has found out.
    pub launch: Option<String>,
    pub progress: &'a Progress,
}

impl Turn<'_> {
    /// Measures the step until it ends, is out of time or is stopped; with the seconds that it took. `None` if another process
    /// measures it.
    pub fn take(&self, what: &str) -> Result<Option<(State, f64)>, CliError> {
        let (begun, earlier) = (Instant::now(), &self.step.state);
        let free = wait_while(|| OutputFolder::is_busy(&self.folder), &self.folder, self.ends, self.progress);
        let is_settled = !matches!(earlier, State::Failed(_)) && self.has_ended();
        let state = if is_settled {
            self.progress.say(&format!("{what}: it is there"));
            State::Done
        } else if stop::asked() || self.ends.is_some_and(|ends| Instant::now() >= ends) {
            earlier.clone()
        } else if !free {
            return Ok(None);
        } else {
            self.progress.say(what);
            self.measure()?
        };
        Ok(Some((state, begun.elapsed().as_secs_f64())))
    }

    /// Whether its folder holds the whole record of what it would measure, and nothing that was broken off.
    fn has_ended(&self) -> bool {
        !Journal::is_in(&self.folder) && report::read_run(&self.folder).is_ok_and(|run| is_of(&run, self.step))
    }

    fn measure(&self) -> Result<State, CliError> {
        let failed = |what: &str, error: std::io::Error| CliError::Other(format!("cannot {what}: {error}"));
        let program = std::env::current_exe().map_err(|error| failed("find this program", error))?;
        let mut errors = tempfile::tempfile().map_err(|error| failed("keep what a step says", error))?;
        let told = errors.try_clone().map_err(|error| failed("keep what a step says", error))?;
        let mut command = Command::new(program);
        command.args(["--quiet", "--until-stdin-ends"]).args(&self.step.arguments).arg("--out").arg(&self.folder);
        if Journal::is_in(&self.folder) {
            command.arg("--resume");
        }
        command.stdin(Stdio::piped()).stdout(Stdio::null()).stderr(told);
        if let Some(launch) = &self.launch {
            command.env(launch::VARIABLE, launch);
        }
        let mut child = command.spawn().map_err(|error| failed("start this program once more", error))?;
        loop {
            let is_over = stop::asked() || self.ends.is_some_and(|ends| Instant::now() >= ends);
            match child.try_wait().map_err(|error| failed("wait for a step", error))? {
                Some(status) if status.success() => return Ok(State::Done),
                // The terminal stops both.
                Some(_) if stop::asked() => {
                    tell_wait(&mut errors);
                    return Ok(State::BrokenOff);
                }
                Some(_) => return Ok(State::Failed(last_line(&mut errors))),
                None if is_over => {
                    // It may have ended just now.
                    let well = end(&mut child).map_err(|error| failed("end a step", error))?;
                    tell_wait(&mut errors);
                    return Ok(if well { State::Done } else { State::BrokenOff });
                }
                None => sleep(PATIENCE),
            }
        }
    }
}

/// Ends a step, by force if it must be; whether it had ended well.
fn end(child: &mut Child) -> std::io::Result<bool> {
    let told = Instant::now();
    drop(child.stdin.take());
    while told.elapsed() < TO_END {
        if let Some(status) = child.try_wait()? {
            return Ok(status.success());
        }
        sleep(PATIENCE);
    }
    // One that has ended by now cannot be killed.
    let _ = child.kill();
    Ok(child.wait()?.success())
}

/// Waits while something is so, within reason; whether it came to an end.
pub(super) fn wait_while(busy: impl Fn() -> bool, folder: &Path, ends: Option<Instant>, progress: &Progress) -> bool {
    let begun = Instant::now();
    let what = format!("another process measures into {}", folder.display());
    let most = begun + MAX_WAIT;
    let ends = ends.map_or(most, |ends| ends.min(most));
    let mut told = None;
    while busy() {
        if Instant::now() >= ends || stop::asked() {
            stop::waits(stop::asked().then(|| what.clone()));
            return false;
        }
        if told.is_none_or(|told: Instant| told.elapsed() >= Duration::from_secs(10)) {
            told = Some(Instant::now());
            let left = MAX_WAIT.saturating_sub(begun.elapsed()).as_secs();
            progress.say(&format!("waiting: {what}, {left} s are left to it"));
        }
        sleep(PATIENCE);
    }
    true
}

/// Whether a record is what a step measures: by this program on this machine, of the same verb, table and preset.
fn is_of(record: &Record, step: &Step) -> bool {
    let words = &step.arguments;
    let preset = words.iter().position(|word| word == "--preset").and_then(|at| words.get(at + 1));
    let is_same =
        if words[0] == "table" { record.table.as_ref() == Some(&words[1]) } else { record.verb() == words[0] };
    is_same && preset.is_none_or(|preset| *preset == record.preset) && record.provenance.commit == machine::COMMIT
}

fn last_line(errors: &mut File) -> String {
    let line = lines(errors).into_iter().rfind(|line| !line.trim().is_empty());
    line.map_or_else(|| "it said nothing".to_owned(), |line| line.trim_start_matches("error: ").to_owned())
}

/// Tells that a step was stopped while it waited, if it was.
fn tell_wait(errors: &mut File) {
    lines(errors).iter().filter(|line| line.starts_with(stop::WAITED)).for_each(|line| progress::to_stderr(line));
}

fn lines(errors: &mut File) -> Vec<String> {
    let mut text = Vec::new();
    // What cannot be read tells nothing.
    let _ = errors.seek(SeekFrom::Start(0)).and_then(|_| errors.read_to_end(&mut text));
    String::from_utf8_lossy(&text).lines().map(str::to_owned).collect()
}
