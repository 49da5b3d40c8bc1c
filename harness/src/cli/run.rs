//! `run`, `report` and `picture`.

use std::path::{Path, PathBuf};

use clap::Args;

use super::arguments::{PictureArguments, RunArguments};
use super::output::{print, print_end, print_written};
use super::work::{Clock, Work, all_measured, refuse_others};
use super::{CliError, names, open_device};
use crate::files::OutputFolder;
use crate::picture;
use crate::plan::RunPreset;
use crate::progress::Progress;
use crate::rays::RAY_SETS;
use crate::results::SampleSchedule;
use crate::{report as reports, tables};

#[derive(Args)]
pub(super) struct ReportArguments {
    /// Records: run.json files, plain or compressed by xz, of whatever verb, or the folders that hold them.
    #[arg(required = true, value_name = "RECORD")]
    paths: Vec<PathBuf>,
    /// Write one page of all records here, which needs no other file: which to choose, fronts, tables, claims, causes. Nothing else is made
    /// then.
    #[arg(long, value_name = "FILE")]
    html: Option<PathBuf>,
}

pub(super) fn run(arguments: &RunArguments, progress: &Progress) -> Result<(), CliError> {
    let work = Work::prepare(&arguments.work, || arguments.selection(), Clock::Timed, progress)?;
    let record = work.measure("run", progress)?;
    print_end(&reports::run_table(&record), &work.bench.out.path().join("summary.md"))?;
    all_measured(&work.plan, &record)
}

pub(super) fn report(arguments: &ReportArguments, progress: &Progress) -> Result<(), CliError> {
    let Some(file) = &arguments.html else {
        for path in &arguments.paths {
            let record = reports::read_run(path)?;
            let folder = OutputFolder::open(&folder_of(path))?;
            refuse_others(folder.path(), std::iter::once(path))?;
            print_written(&reports::write_derived(&record, &folder, tables::of_run)?)?;
        }
        return Ok(());
    };
    let (folder, name) = OutputFolder::of_file(file)?;
    super::page::write(file, (&folder, &name), &arguments.paths, Vec::new(), progress)
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
    let (size, sampling) = (arguments.size, SampleSchedule::rounds(1));
    let preset = RunPreset { ray_image: size, frame: size, sampling, ..RunPreset::for_adapter(false) };
    let primary = RAY_SETS.iter().filter(|set| set.name == "primary").copied().collect();
    let plan = arguments.common.plan_of_one(&arguments.scene, tracer, primary, preset)?;
    let needed = tracer.registration.needs_device();
    let device = open_device(&arguments.common.device, needed, needed)?;
    let legend = picture::draw(&plan, arguments.what, &device, &arguments.out, progress)?;
    print(&legend.iter().map(|line| format!("{line}\n")).collect::<String>())
}
