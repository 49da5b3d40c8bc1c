//! `run`, `report` and `picture`.

use std::path::{Path, PathBuf};

use clap::Args;
use tracebench_api::EndPoint;

use super::arguments::{Matter, PictureArguments, RunArguments, WorkArguments};
use super::output::print;
use super::{CliError, names, open_device};
use crate::picture;
use crate::plan::{Plan, RunPreset, TracerRequest};
use crate::progress::Progress;
use crate::rays::RAY_SETS;
use crate::registry::Device;
use crate::report::Measured;
use crate::results::{Run, Skipped};
use crate::truth::Cache;
use crate::{report as reports, runner};

#[derive(Args)]
pub(super) struct ReportArguments {
    /// A run.json, an updates.json or a tune.json, or the folder that holds it.
    path: PathBuf,
}

pub(super) fn needs_device(requests: &[TracerRequest]) -> bool {
    requests.iter().any(|request| request.registration.needs_device())
}

pub(super) fn run(arguments: &RunArguments, progress: &Progress) -> Result<(), CliError> {
    let work = Work::prepare(&arguments.work, || arguments.matter(), progress)?;
    let run = work.measure(progress)?;
    print(&format!("{}{}\n", reports::run_table(&run), work.out.path.join("summary.md").display()))
}

/// What is to be measured, on which device, and where the results go.
pub(super) struct Work {
    pub(super) plan: Plan,
    pub(super) device: Device,
    pub(super) out: OutputFolder,
}

impl Work {
    /// Checks the arguments before any device or file is touched, then opens both.
    pub(super) fn prepare(
        arguments: &WorkArguments,
        matter: impl Fn() -> Result<Matter, CliError>,
        progress: &Progress,
    ) -> Result<Self, CliError> {
        let checked = arguments.plan(matter()?, || false)?;
        let device = open_device(
            arguments.common.adapter.as_deref(),
            needs_device(&checked.tracers),
            checked.tracers.iter().any(TracerRequest::must_have_device),
        )?;
        let plan = arguments.plan(matter()?, || device.as_ref().is_ok_and(|gpu| !gpu.is_software()))?;
        let out = match &arguments.out {
            Some(path) => OutputFolder::open(path)?,
            None => OutputFolder::fresh()?,
        };
        say_plan(&plan, device.as_ref().ok().map(|gpu| gpu.listing.name.as_str()), progress);
        Ok(Self { plan, device, out })
    }

    /// Runs the plan and writes everything.
    pub(super) fn measure(&self, progress: &Progress) -> Result<Run, CliError> {
        let run = runner::execute(&self.plan, &self.device, &Cache::of_user(), progress)
            .inspect_err(|_| self.out.abandon())?;
        say_skipped(&run.skipped, progress);
        reports::write_run(&run, &self.out.path)?;
        Ok(run)
    }
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
        let stamp = crate::machine::utc_now().replace(':', "");
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

    /// A run that failed leaves nothing; a folder that is not empty stays, whatever happens here.
    pub(super) fn abandon(&self) {
        for path in &self.made {
            if std::fs::remove_dir(path).is_err() {
                break;
            }
        }
    }
}

fn say_plan(plan: &Plan, adapter: Option<&str>, progress: &Progress) {
    let RunPreset { name, ray_image, frame, face, samples, .. } = plan.preset;
    progress.say(&format!(
        "preset {name}: rays from {}x{} pixels, frame {}x{}, faces {face}, {samples} samples; adapter: {}",
        ray_image[0],
        ray_image[1],
        frame[0],
        frame[1],
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

pub(super) fn report(arguments: &ReportArguments, progress: &Progress) -> Result<(), CliError> {
    let directory = folder_of(&arguments.path);
    let written = match reports::read_any(&arguments.path)? {
        Measured::Run(run) => reports::write_derived(&run, &directory)?,
        Measured::Updates(updates) => reports::write_updates_table(&updates, &directory)?,
        Measured::Tuning(tuning) => reports::write_tuning_derived(&tuning, &directory)?,
    };
    for path in written {
        progress.say(&path.display().to_string());
    }
    Ok(())
}

/// The folder that a file is in, or that is one.
pub(super) fn folder_of(path: &Path) -> PathBuf {
    if path.is_dir() { path.to_owned() } else { path.parent().map(Path::to_path_buf).unwrap_or_default() }
}

pub(super) fn picture(arguments: &PictureArguments, progress: &Progress) -> Result<(), CliError> {
    let tracers = names::tracers(&arguments.tracer, &arguments.common.settings)?;
    let [tracer] = tracers.as_slice() else {
        return Err(CliError::Argument("picture takes one tracer".to_owned()));
    };
    let scene = names::scene(&arguments.scene)?;
    let quick = RunPreset::for_adapter(false);
    let plan = Plan {
        scenes: vec![scene],
        tracers: vec![TracerRequest { required: true, ..tracer.clone() }],
        ray_sets: RAY_SETS.iter().filter(|set| set.name == "primary").copied().collect(),
        ray_parameters: names::ray_values(&arguments.common.settings)?,
        preset: RunPreset {
            ray_image: arguments.size,
            frame: arguments.size,
            samples: 1,
            scene_scale: arguments.common.scale.unwrap_or(quick.scene_scale),
            ..quick
        },
        view: arguments.common.view()?,
        time_s: arguments.common.time,
        seed: 1,
        end: EndPoint::Hit,
        table: None,
    };
    let needed = tracer.registration.needs_device();
    let device = open_device(arguments.common.adapter.as_deref(), needed, needed)?;
    let legend = picture::draw(&plan, arguments.what, &device, &arguments.out, progress)?;
    print(&legend.iter().map(|line| format!("{line}\n")).collect::<String>())
}
