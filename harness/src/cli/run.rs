//! `run`, `report` and `picture`.

use std::path::{Path, PathBuf};

use clap::Args;

use super::arguments::{PictureArguments, RunArguments};
use super::{CliError, names, open_device};
use crate::picture;
use crate::plan::{Plan, RunPreset, TracerRequest};
use crate::progress::Progress;
use crate::rays::RAY_SETS;
use crate::results::Run;
use crate::truth::Cache;
use crate::{report as reports, runner};

#[derive(Args)]
pub(super) struct ReportArguments {
    /// A run.json, or the folder that holds it.
    path: PathBuf,
}

fn needs_device(requests: &[TracerRequest]) -> bool {
    requests.iter().any(|request| request.registration.needs_device())
}

pub(super) fn run(arguments: &RunArguments, progress: &Progress) -> Result<(), CliError> {
    // Arguments are checked before any device or file is touched.
    let requests = names::tracers(&arguments.tracer, &arguments.common.settings)?;
    arguments.plan(|| false)?;
    let gpu = open_device(
        arguments.common.adapter.as_deref(),
        needs_device(&requests),
        requests.iter().any(TracerRequest::must_have_device),
    )?;
    let plan = arguments.plan(|| gpu.as_ref().is_some_and(|gpu| !gpu.is_software()))?;
    let out = arguments
        .out
        .clone()
        .unwrap_or_else(|| Path::new("tracebench-out").join(crate::machine::utc_now().replace(':', "")));
    let is_new = prepare_directory(&out)?;
    say_plan(&plan, gpu.as_ref().map(|gpu| gpu.listing.name.as_str()), progress);
    let run = runner::execute(&plan, gpu.as_ref(), &Cache::of_user(), progress).inspect_err(|_| {
        // A run that failed leaves nothing; a folder that is not empty stays, whatever happens here.
        if is_new {
            let _ = std::fs::remove_dir(&out);
        }
    })?;
    say_skipped(&run, progress);
    reports::write_run(&run, &out)?;
    for line in run.headlines() {
        println!("{line}");
    }
    println!("{}", out.join("summary.md").display());
    Ok(())
}

/// Refuses a folder that cannot be written before the work is done, not after. Says whether it was made just now.
fn prepare_directory(path: &Path) -> Result<bool, CliError> {
    let fail = |reason: std::io::Error| {
        CliError::Other(format!(
            "cannot write to the output folder {}: {reason}; choose another with --out",
            path.display()
        ))
    };
    let is_new = !path.exists();
    std::fs::create_dir_all(path).map_err(fail)?;
    tempfile::NamedTempFile::new_in(path).map_err(fail)?;
    Ok(is_new)
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

fn say_skipped(run: &Run, progress: &Progress) {
    for skipped in &run.skipped {
        let parts = [skipped.tracer.as_deref(), Some(skipped.scene.as_str()), skipped.rays.as_deref()];
        let what: Vec<&str> = parts.into_iter().flatten().collect();
        progress.say(&format!("skipped {}: {}", what.join(" "), skipped.reason));
    }
}

pub(super) fn report(arguments: &ReportArguments, progress: &Progress) -> Result<(), CliError> {
    let run = reports::read_run(&arguments.path)?;
    let directory = if arguments.path.is_dir() {
        arguments.path.clone()
    } else {
        arguments.path.parent().map(Path::to_path_buf).unwrap_or_default()
    };
    for path in reports::write_derived(&run, &directory)? {
        progress.say(&path.display().to_string());
    }
    Ok(())
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
        preset: RunPreset { ray_image: arguments.size, frame: arguments.size, samples: 1, ..quick },
        view: arguments.common.view()?,
        time_s: arguments.common.time,
        seed: 1,
    };
    let needed = tracer.registration.needs_device();
    let gpu = open_device(arguments.common.adapter.as_deref(), needed, needed)?;
    let legend = picture::draw(&plan, arguments.what, gpu.as_ref(), &arguments.out, progress)?;
    for line in legend {
        println!("{line}");
    }
    Ok(())
}
