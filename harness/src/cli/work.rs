//! What every measuring verb does round its work: device, folder, lock, journal, record.

use std::fs::File;
use std::io::Error;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::Args;
use serde_json::{Value, json};

use super::arguments::{Selection, WorkArguments};
use super::output::print_page;
use super::{CliError, fail_for, open_device, refuse, stop};
use crate::files::{FileError, OutputFolder};
use crate::launch;
use crate::machine;
use crate::measure::{Context, Journal, RunError, records};
use crate::plan::{Plan, RunPreset, TracerRequest};
use crate::progress::{self, Progress};
use crate::registry::Device;
use crate::report::{self, ReportError, format::edges};
use crate::results::{LaunchRecord, LaunchSettings, Provenance, Record, ShardRecord, Skipped, UNTIMED};
use crate::tables;
use crate::truth::Cache;

/// Where results go, and how a long run is spread and gone on with.
#[derive(Args)]
pub(super) struct OutputArguments {
    /// Folder for the results; a new one below tracebench-out/ if not given. Results of the same verb that ended there before are replaced,
    /// those of another are not; nor is what was broken off there, see --resume.
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Go on with the run that was broken off in --out: what had ended there is not measured again. Everything else must be
    /// said as it was then. A run that is complete is left as it is; where there is none one begins.
    #[arg(long, requires = "out")]
    pub resume: bool,
    /// Measure the I-th of N parts, by whole scenes, for `merge` to join. Several machines may each take one.
    #[arg(long, value_name = "I/N", value_parser = shard)]
    pub shard: Option<[u32; 2]>,
    /// What searches on the device read from and how many rays a lane answers, where --set does not say: buffer,1 or texture,32 and
    /// the like. A short probe of the adapter tells if it is not given, here or as TRACEBENCH_LAUNCH.
    #[arg(long, value_name = "MEMORY_ACCESS,RAYS", value_parser = launch::parse)]
    pub launch: Option<LaunchSettings>,
}

fn shard(text: &str) -> Result<[u32; 2], String> {
    let parts = text.split_once('/').and_then(|(index, count)| Some([index.parse().ok()?, count.parse().ok()?]));
    let sound = parts.filter(|[index, count]: &[u32; 2]| (1..=*count).contains(index) && *count <= 10_000);
    sound.ok_or_else(|| "I/N with I from 1 to N, and N at most 10000, like 2/8".to_owned())
}

/// What is to be measured, on which device, and where the results go.
pub(super) struct Work<'a> {
    pub(super) plan: Plan,
    pub(super) bench: Bench<'a>,
}

impl<'a> Work<'a> {
    /// Checks the arguments before any device or file is touched, then opens both.
    pub(super) fn prepare(
        arguments: &'a WorkArguments,
        selection: impl Fn() -> Result<Selection, CliError>,
        verb: &'static str,
        progress: &'a Progress,
    ) -> Result<Self, CliError> {
        let checked = arguments.plan(selection()?, || false)?;
        let device = open_device(&arguments.common.device, &checked.tracers)?;
        let mut plan = arguments.plan(selection()?, || device.as_ref().is_ok_and(|gpu| !gpu.is_software()))?;
        let bench = Bench::open(device, &arguments.output, verb, &mut plan.tracers, progress)?;
        say_plan(&plan, bench.device.as_ref().ok().map(|gpu| gpu.listing.name.as_str()), progress);
        Ok(Self { plan, bench })
    }

    /// Measures what a study asks of the plan, with further words of it, and prints the answer of its page, which is named after the verb,
    /// from a heading on if one is given.
    pub(super) fn study(
        &self,
        words: Value,
        heading: Option<&str>,
        execute: impl FnOnce(&Context<'_>) -> Result<Record, RunError>,
    ) -> Result<Record, CliError> {
        let record = self.bench.measure(std::slice::from_ref(&self.plan), words, execute)?;
        let page = format!("{}.md", self.bench.verb.split(' ').next().unwrap_or_default());
        print_page(&self.bench.out.path().join(page), heading)?;
        Ok(record)
    }
}

/// That all was measured that was asked for by name: what could not be is no reason to lose the rest, but the run did not
/// go well.
pub(super) fn all_measured(plan: &Plan, record: &Record) -> Result<(), CliError> {
    let named = plan.tracers.iter().filter(|request| request.required);
    let named: Vec<String> = named.map(|request| records::request_record(request).label()).collect();
    let refused = |one: &&Skipped| one.rays.is_none() && one.tracer.as_ref().is_some_and(|label| named.contains(label));
    let told =
        |one: &Skipped| format!("{} in {}: {}", one.tracer.as_deref().unwrap_or_default(), one.scene, one.reason);
    let refused: Vec<String> = record.skipped.iter().filter(refused).map(told).collect();
    fail_for(&refused, "; ", |refused| {
        format!("not measured, the rest is kept: {refused}; leave it out of --tracer if that cannot be helped")
    })
}

/// A device and a folder.
pub(super) struct Bench<'a> {
    pub(super) device: Device,
    pub(super) out: Arc<OutputFolder>,
    verb: &'static str,
    progress: &'a Progress,
    launch: Option<LaunchRecord>,
    arguments: &'a OutputArguments,
}

impl<'a> Bench<'a> {
    /// Opens both, and gives requests their launch settings.
    pub(super) fn open(
        device: Device,
        arguments: &'a OutputArguments,
        verb: &'static str,
        requests: &mut [TracerRequest],
        progress: &'a Progress,
    ) -> Result<Self, CliError> {
        let out = Arc::new(match &arguments.out {
            Some(path) => OutputFolder::open(path)?,
            None => fresh_folder()?,
        });
        stop::keeps(Some(stop::Kept { folder: out.clone(), named: arguments.out.is_some() }));
        let mut bench = Self { device, out, verb, progress, launch: None, arguments };
        bench.launch = bench.launch_of(requests).inspect_err(|_| bench.out.abandon())?;
        bench.give_launch_settings(requests);
        Ok(bench)
    }

    /// The means of requests where nothing is set: those that are given, those that the run was begun with, or what a probe says.
    fn launch_of(&self, requests: &[TracerRequest]) -> Result<Option<LaunchRecord>, CliError> {
        if !requests.iter().any(TracerRequest::has_launch_settings) {
            return Ok(None);
        }
        let told = std::env::var(launch::VARIABLE).ok().filter(|text| !text.is_empty());
        let told = told.map(|text| {
            launch::parse(&text).map_err(|error| CliError::Argument(format!("{}: {error}", launch::VARIABLE)))
        });
        if let Some(launch) = self.arguments.launch.clone().map(Ok).or(told).transpose()? {
            return Ok(Some(LaunchRecord { launch, probe: None }));
        }
        let begun = self.arguments.out.as_deref().filter(|_| self.arguments.resume).and_then(|out| {
            Journal::launch_of(out).or_else(|| report::read_run(out).ok().and_then(|record| record.provenance.launch))
        });
        if begun.is_some() {
            return Ok(begun);
        }
        let probed = {
            // Like everything that is timed, where times are taken.
            let _turn = (self.is_timed() && self.device.is_ok()).then(wait_for_turn);
            launch::probe(&self.device)?
        };
        if let Some(LaunchRecord { launch, probe: Some(probe) }) = &probed {
            self.progress.say(&format!(
                "launch settings: {launch} (in the probe textures are {:.2} times as fast, {} rays a lane {:.2} times)",
                probe.texture_gain(),
                probe.many_rays,
                probe.many_rays_gain()
            ));
        }
        Ok(probed)
    }

    /// Whether its verb takes times: only one process of a machine may.
    fn is_timed(&self) -> bool {
        !UNTIMED.contains(&self.verb)
    }

    /// Gives requests the launch settings of all, where nothing is set.
    pub(super) fn give_launch_settings(&self, requests: &mut [TracerRequest]) {
        if let Some(LaunchRecord { launch, .. }) = &self.launch {
            requests.iter_mut().for_each(|request| request.use_launch_settings(launch));
        }
    }

    /// Measures by plans and further words, keeps what ends, and writes the record with what derives from it. The same words mean the same
    /// work.
    pub(super) fn measure(
        &self,
        plans: &[Plan],
        further: Value,
        work: impl FnOnce(&Context<'_>) -> Result<Record, RunError>,
    ) -> Result<Record, CliError> {
        let plans: Vec<Value> = plans.iter().map(Plan::describe).collect();
        let plan = json!({ "verb": self.verb, "plans": plans, "adaptive": further });
        let plan_sha256 = crate::hash::sha256_of(plan.to_string().as_bytes());
        let of_plan = |[index, count]: [u32; 2]| ShardRecord::here(index, count, plan_sha256.clone());
        let shard = self.arguments.shard.map(of_plan);
        let is_begun = self.arguments.resume && Journal::is_in(self.out.path());
        if self.arguments.resume
            && !is_begun
            && let Some(record) = self.complete(&plan_sha256)?
        {
            stop::keeps(None);
            return Ok(record);
        }
        self.out.check_all(report::may_be_written).inspect_err(|_| self.out.abandon())?;
        if !self.arguments.resume {
            refuse_another(self.out.path(), Some(self.verb))?;
        }
        let machine = machine::this_machine(self.device.as_deref().ok());
        let words = json!({ "plan": plan, "shard": self.arguments.shard });
        let begun = match is_begun {
            true => Journal::resume(&self.out, &words, &machine),
            false => Journal::begin(&self.out, &words, &machine, self.launch.as_ref()),
        };
        let journal = begun.map_err(|error| CliError::Run(error.into())).inspect_err(|_| self.out.abandon())?;
        // Held until the work is done.
        let _turn = self.is_timed().then(wait_for_turn);
        let cache = Cache::of_user();
        let mut context = Context::new(&self.device, &cache, self.progress, &journal);
        (context.shard, context.launch) = (shard, self.launch.clone());
        let mut record = work(&context).inspect_err(|error| {
            // Where nothing could run there is nothing to go on with.
            if matches!(error, RunError::Nothing(_)) {
                journal.finish();
            } else {
                journal.abandon();
            }
            self.out.abandon();
            if journal.holds() && !matches!(error, RunError::Journal(_)) {
                let folder = self.out.path().display();
                progress::to_stderr(&format!("what had ended is kept in {folder}; go on with --out {folder} --resume"));
            }
        })?;
        if let Some([index, count]) = self.arguments.shard {
            let what = "what follows tells of this part alone; `merge` joins all";
            self.progress.say(&format!("shard {index} of {count}: {what}"));
        }
        say_skipped(&record.skipped, self.progress);
        record.provenance.plan_sha256 = Some(plan_sha256);
        report::write_run(&record, &self.out, tables::of_run)?;
        super::records::beside(&record, &self.out)?;
        if journal.recorded() {
            let folder = self.out.path().display();
            progress::to_stderr(&format!("not all that was asked for was done; go on with --out {folder} --resume"));
        }
        stop::keeps(None);
        Ok(record)
    }

    /// The record of a complete run that is to be gone on with; `None` where there is no record.
    fn complete(&self, plan_sha256: &str) -> Result<Option<Record>, CliError> {
        let record = match report::read_run(self.out.path()) {
            Err(ReportError::Missing(..)) => return Ok(None),
            record => record?,
        };
        let Provenance { started, commit, shard, plan_sha256: own, .. } = &record.provenance;
        let folder = self.out.path().display();
        let part = shard.as_ref().map(|shard| [shard.index, shard.count]);
        if own.as_deref() != Some(plan_sha256) || part != self.arguments.shard {
            return refuse(format!(
                "{folder} holds a complete record of another plan, begun {started}: leave --resume out to replace it, or choose another folder \
                 with --out"
            ));
        }
        progress::to_stderr(&format!(
            "the record in {folder} is complete, begun {started} by commit {commit}: nothing is measured"
        ));
        Ok(Some(record))
    }
}

/// The file that is locked while times are taken; nothing is where this is set to nothing.
const LOCK: &str = "TRACEBENCH_LOCK";

/// Waits until no other process takes times here: two at once would measure one another.
pub(super) fn wait_for_turn() -> Option<File> {
    let path = match std::env::var_os(LOCK) {
        Some(path) if path.is_empty() => return None,
        Some(path) => PathBuf::from(path),
        None => std::env::temp_dir().join("tracebench.lock"),
    };
    let opened = File::options().read(true).write(true).create(true).truncate(false).open(&path);
    let warn = |error: &Error, end: &str| progress::to_stderr(&format!("cannot lock {}: {error}{end}", path.display()));
    // Another user's file can be locked all the same.
    let file = opened.or_else(|_| File::open(&path));
    let file = file.inspect_err(|error| warn(error, "; another run may be timed beside this one")).ok()?;
    if file.try_lock().is_err() {
        let what = format!("another tracebench takes times on this machine ({} is locked)", path.display());
        progress::to_stderr(&format!("waiting: {what}"));
        stop::waits(Some(what));
        if let Err(error) = file.lock() {
            warn(&error, "");
        }
        stop::waits(None);
    }
    Some(file)
}

/// A new folder, named after the time; two runs that begin in the same second get one each.
pub(super) fn fresh_folder() -> Result<OutputFolder, FileError> {
    OutputFolder::fresh(Path::new("tracebench-out"), &machine::utc_now().replace(':', ""))
}

/// Refuses a folder with a record of another verb than `own`: it would be written over, and its pages left without it.
pub(super) fn refuse_another(out: &Path, own: Option<&str>) -> Result<(), CliError> {
    let what = match report::read_run(out) {
        Ok(record) if own == Some(record.verb()) => return Ok(()),
        Ok(record) => format!("what `{}` measured", record.verb()),
        // The journal itself says whose work it is.
        Err(ReportError::Missing(..)) if own.is_none() && Journal::is_in(out) => {
            "a record that was broken off".to_owned()
        }
        Err(ReportError::Missing(..)) => return Ok(()),
        Err(_) => format!("a {}", report::RUN_FILE),
    };
    refuse(format!("{} holds {what}: choose another folder with --out", out.display()))
}

/// Refuses a folder with another record than those that are given: what derives from these would pass for what derives from it.
pub(super) fn refuse_others<'p>(folder: &Path, mut given: impl Iterator<Item = &'p PathBuf>) -> Result<(), CliError> {
    let contents = |path: &Path| std::fs::read(report::record_file(path)).ok();
    let there = contents(folder);
    if there.is_none() || given.any(|path| contents(path) == there) {
        return Ok(());
    }
    let (folder, file) = (folder.display(), report::record_file(folder));
    refuse(format!("{folder} holds the record of another run, {}: choose another folder", file.display()))
}

fn say_plan(plan: &Plan, adapter: Option<&str>, progress: &Progress) {
    let RunPreset { name, ray_image, frame, face, sampling, .. } = plan.preset;
    let (rays, frame, sampling) = (edges(ray_image), edges(frame), sampling.describe());
    progress.say(&format!(
        "preset {name}: rays from {rays} pixels, frame {frame}, faces {face}, {sampling}; adapter: {}",
        adapter.unwrap_or("none")
    ));
}

pub(super) fn say_skipped(skipped: &[Skipped], progress: &Progress) {
    for skipped in skipped {
        let parts = [skipped.tracer.as_deref(), Some(skipped.scene.as_str()), skipped.rays.as_deref()];
        let what: Vec<&str> = parts.into_iter().flatten().collect();
        progress.say(&format!("skipped {}: {}", what.join(" "), skipped.reason));
    }
}
