//! What every measuring verb does round its work: device, folder, lock, journal, record.

use std::fs::File;
use std::path::{Path, PathBuf};

use clap::Args;
use serde_json::{Value, json};

use super::arguments::{Matter, WorkArguments};
use super::{CliError, open_device};
use crate::machine;
use crate::measure::{self, Context, Journal, RunError};
use crate::plan::{Plan, RunPreset, Shard, TracerRequest};
use crate::progress::{self, Progress};
use crate::registry::Device;
use crate::results::{Run, Skipped};
use crate::truth::Cache;
use crate::{report, tables};

/// Where results go, and how a long run is spread and gone on with.
#[derive(Args)]
pub(super) struct OutputArguments {
    /// Folder for the results; a new one below tracebench-out/ if not given.
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Go on with the run that was broken off in --out: what had ended there is not measured again. Everything else must be
    /// said as it was then.
    #[arg(long, requires = "out")]
    pub resume: bool,
    /// Measure the I-th of N parts, by whole scenes, for `merge` to join. Several machines may each take one.
    #[arg(long, value_name = "I/N", value_parser = shard)]
    pub shard: Option<[u32; 2]>,
}

fn shard(text: &str) -> Result<[u32; 2], String> {
    let parts = text.split_once('/').and_then(|(index, count)| Some([index.parse().ok()?, count.parse().ok()?]));
    let sound = parts.filter(|[index, count]: &[u32; 2]| (1..=*count).contains(index) && *count <= 10_000);
    sound.ok_or_else(|| "I/N with I from 1 to N, and N at most 10000, like 2/8".to_owned())
}

/// Whether a verb takes times: only one process of a machine may.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Clock {
    /// It does.
    Timed,
    /// It does not.
    Untimed,
}

pub(super) fn needs_device(requests: &[TracerRequest]) -> bool {
    requests.iter().any(|request| request.registration.needs_device())
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
        matter: impl Fn() -> Result<Matter, CliError>,
        progress: &Progress,
    ) -> Result<Self, CliError> {
        let checked = arguments.plan(matter()?, || false)?;
        let device = open_device(
            &arguments.common.device,
            needs_device(&checked.tracers),
            checked.tracers.iter().any(TracerRequest::must_have_device),
        )?;
        let plan = arguments.plan(matter()?, || device.as_ref().is_ok_and(|gpu| !gpu.is_software()))?;
        let bench = Bench::open(device, &arguments.output)?;
        say_plan(&plan, bench.device.as_ref().ok().map(|gpu| gpu.listing.name.as_str()), progress);
        Ok(Self { plan, bench })
    }

    /// Runs the plan and writes everything.
    pub(super) fn measure(&self, verb: &str, progress: &Progress) -> Result<Run, CliError> {
        let plan = described(verb, std::slice::from_ref(&self.plan), Value::Null);
        self.bench.measure(&plan, Clock::Timed, progress, |context| measure::execute(&self.plan, context))
    }
}

/// What a plan says, as the journal keeps it: the same words mean the same work.
pub(super) fn described(verb: &str, plans: &[Plan], further: Value) -> Value {
    let plans: Vec<Value> = plans.iter().map(Plan::describe).collect();
    json!({ "verb": verb, "plans": plans, "further": further })
}

/// A device and a folder.
pub(super) struct Bench<'a> {
    pub(super) device: Device,
    pub(super) out: OutputFolder,
    arguments: &'a OutputArguments,
}

impl<'a> Bench<'a> {
    pub(super) fn open(device: Device, arguments: &'a OutputArguments) -> Result<Self, CliError> {
        let out = match &arguments.out {
            Some(path) if arguments.resume && !path.is_dir() => {
                return Err(CliError::Other(format!("there is no run to go on with in {}: no folder", path.display())));
            }
            Some(path) => OutputFolder::open(path)?,
            None => OutputFolder::fresh()?,
        };
        Ok(Self { device, out, arguments })
    }

    /// Measures by the plan of these words, keeps what ends, and writes the record with what derives from it.
    pub(super) fn measure(
        &self,
        plan: &Value,
        clock: Clock,
        progress: &Progress,
        work: impl FnOnce(&Context<'_>) -> Result<Run, RunError>,
    ) -> Result<Run, CliError> {
        let shard = self.arguments.shard.map(|[index, count]| {
            let plan_sha256 = crate::hash::sha256_of(plan.to_string().as_bytes());
            Shard { index, count, plan_sha256 }
        });
        let machine = machine::this_machine(self.device.as_deref().ok());
        let words = json!({ "plan": plan, "shard": self.arguments.shard });
        let begun = if self.arguments.resume { Journal::resume } else { Journal::begin };
        let journal = begun(&self.out.path, &words, &machine)
            .map_err(|error| CliError::Run(error.into()))
            .inspect_err(|_| self.out.abandon())?;
        // Held until the work is done.
        let _turn = (clock == Clock::Timed).then(wait_for_turn);
        let cache = Cache::of_user();
        let context = Context::new(&self.device, &cache, progress, &journal).of_shard(shard);
        let run = work(&context).inspect_err(|error| {
            // Where nothing could run there is nothing to go on with.
            if matches!(error, RunError::Nothing(_)) {
                journal.finish();
            } else {
                journal.abandon();
            }
            self.out.abandon();
            if journal.holds() && !matches!(error, RunError::Journal(_)) {
                let folder = self.out.path.display();
                progress::to_stderr(&format!("what had ended is kept in {folder}; go on with --out {folder} --resume"));
            }
        })?;
        if let Some([index, count]) = self.arguments.shard {
            progress
                .say(&format!("shard {index} of {count}: what follows tells of this part alone; `merge` joins all"));
        }
        say_skipped(&run.skipped, progress);
        report::write_run(&run, &self.out.path, tables::of_run)?;
        journal.finish();
        Ok(run)
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
    // Another user's file can be locked all the same.
    let file = match opened.or_else(|_| File::open(&path)) {
        Ok(file) => file,
        Err(error) => {
            progress::to_stderr(&format!(
                "cannot lock {}: {error}; another run may be timed beside this one",
                path.display()
            ));
            return None;
        }
    };
    if file.try_lock().is_err() {
        progress::to_stderr(&format!(
            "waiting: another tracebench takes times on this machine ({} is locked)",
            path.display()
        ));
        if let Err(error) = file.lock() {
            progress::to_stderr(&format!("cannot lock {}: {error}", path.display()));
        }
    }
    Some(file)
}

/// The folder for results, made before the work is done: one that cannot be written is refused then.
pub(super) struct OutputFolder {
    pub(super) path: PathBuf,
    /// What was made for it, the outermost last; removed again, while empty, when the run fails.
    made: Vec<PathBuf>,
}

impl OutputFolder {
    pub(super) fn open(path: &Path) -> Result<Self, CliError> {
        let fail = |reason: std::io::Error| {
            CliError::Other(format!(
                "cannot write to the output folder {}: {reason}; choose another with --out",
                path.display()
            ))
        };
        let missing = |part: &&Path| !part.as_os_str().is_empty() && !part.exists();
        let made = path.ancestors().take_while(missing).map(Path::to_owned).collect();
        std::fs::create_dir_all(path).map_err(fail)?;
        let folder = Self { path: path.to_owned(), made };
        tempfile::NamedTempFile::new_in(path).map_err(fail).inspect_err(|_| folder.abandon())?;
        Ok(folder)
    }

    /// A new folder, named after the time; two runs that begin in the same second get one each.
    pub(super) fn fresh() -> Result<Self, CliError> {
        let parent = Self::open(Path::new("tracebench-out"))?;
        let stamp = machine::utc_now().replace(':', "");
        for attempt in 1..1000 {
            let name = if attempt == 1 { stamp.clone() } else { format!("{stamp}-{attempt}") };
            let path = parent.path.join(name);
            match std::fs::create_dir(&path) {
                Ok(()) => return Ok(Self { made: [vec![path.clone()], parent.made].concat(), path }),
                Err(error) if error.kind() == std::io::ErrorKind::AlreadyExists => {}
                Err(error) => return Err(CliError::Other(format!("cannot make {}: {error}", path.display()))),
            }
        }
        Err(CliError::Other(format!("{} is full of runs of this second", parent.path.display())))
    }

    /// A run that failed before anything ended leaves nothing; a folder that is not empty stays, whatever happens here.
    pub(super) fn abandon(&self) {
        for path in &self.made {
            if std::fs::remove_dir(path).is_err() {
                break;
            }
        }
    }
}

fn say_plan(plan: &Plan, adapter: Option<&str>, progress: &Progress) {
    let RunPreset { name, ray_image, frame, face, sampling, .. } = plan.preset;
    progress.say(&format!(
        "preset {name}: rays from {}x{} pixels, frame {}x{}, faces {face}, {}; adapter: {}",
        ray_image[0],
        ray_image[1],
        frame[0],
        frame[1],
        sampling.words(),
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
