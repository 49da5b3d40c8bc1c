//! `table`.

use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use super::arguments::TableArguments;
use super::output::{print, print_page};
use super::run::folder_of;
use super::work::{Clock, Work, described, refuse_others};
use super::{CliError, names};
use crate::files::OutputFolder;
use crate::measure::{self, Context};
use crate::papers::{self, Experiment, PART_SETTINGS, Paper};
use crate::peers::Subject;
use crate::plan::{Plan, SceneSource, TracerRequest};
use crate::progress::Progress;
use crate::report;
use crate::studies::tune::{Label, Tuning};
use crate::studies::updates::{self, DEFAULT_FRAMES};
use crate::tables::{self, Table};

pub(super) fn table(arguments: &TableArguments, progress: &Progress) -> Result<(), CliError> {
    let table = names::table(&arguments.name)?;
    let moving = table.is_moving();
    if !moving && arguments.frames.is_some() {
        return Err(CliError::Argument(format!("--frames: table {} is not over frames", table.name())));
    }
    if moving && arguments.work.common.time != 0.0 {
        return Err(CliError::Argument(format!("--time: table {} is over whole animations", table.name())));
    }
    let walked = matches!(table, Table::Peers(peers) if peers.subject == Subject::Walked);
    if walked && arguments.work.common.view.is_some() {
        return Err(CliError::Argument(format!("--view: table {} is along the camera's path", table.name())));
    }
    let of_papers =
        !arguments.only.is_empty() || arguments.estimate.is_some() || arguments.tuned.is_some() || arguments.part;
    if let (Table::Peers(_) | Table::Means | Table::Ablation(_), true) = (table, of_papers) {
        return Err(CliError::Argument(format!(
            "--only, --tuned, --part, --estimate: table {} is no paper's",
            table.name()
        )));
    }
    if let (Table::Paper(paper, experiment), Some(path)) = (table, &arguments.estimate) {
        return estimate(table, paper, experiment, arguments, path);
    }
    if let Some(path) = &arguments.from {
        return again(table, path, arguments.work.output.out.as_deref());
    }
    let mut work = Work::prepare(&arguments.work, || arguments.matter(table), Clock::Timed, progress)?;
    match table {
        Table::Peers(table) if moving => {
            let frames = arguments.frames.unwrap_or(DEFAULT_FRAMES);
            let plan = described("table", std::slice::from_ref(&work.plan), json!({ "frames": frames }));
            let execute = |context: &Context<'_>| updates::execute(table, &work.plan, frames, context);
            work.bench.measure(&plan, progress, execute)?;
        }
        Table::Peers(_) | Table::Means | Table::Ablation(_) => {
            work.measure("table", progress)?;
        }
        Table::Paper(paper, experiment) => measure(paper, experiment, arguments, &mut work, progress)?,
    }
    print_page(&report::table_page(table.name(), work.bench.out.path()))
}

/// Runs an experiment's steps into one run.
fn measure(
    paper: &Paper,
    experiment: &'static Experiment,
    arguments: &TableArguments,
    work: &mut Work<'_>,
    progress: &Progress,
) -> Result<(), CliError> {
    let mut plans = plans(paper, experiment, arguments, &mut work.plan).inspect_err(|_| work.bench.out.abandon())?;
    plans.iter_mut().for_each(|plan| work.bench.give_means(&mut plan.tracers));
    let words = described("table", &plans, Value::Null);
    work.bench.measure(&words, progress, |context| measure::execute_all(&plans, context))?;
    Ok(())
}

/// What an experiment runs over a base plan.
fn plans(
    paper: &Paper,
    experiment: &'static Experiment,
    arguments: &TableArguments,
    base: &mut Plan,
) -> Result<Vec<Plan>, CliError> {
    let settings = &arguments.work.common.settings;
    let of_part = PART_SETTINGS.iter().filter(|_| arguments.part);
    let own = of_part.chain(experiment.settings).map(|setting| (*setting).to_owned());
    // What the user says comes later and counts.
    base.ray_parameters = names::ray_values(&own.chain(settings.iter().cloned()).collect::<Vec<_>>())?;
    let mut steps = names::steps(experiment, settings)?;
    names::only(&mut steps, &arguments.only)?;
    if arguments.part {
        paper.take_part(experiment, base, &mut steps);
    }
    let plans = experiment.plans(base, &steps).map_err(|error| CliError::Argument(error.to_string()))?;
    let plans: Vec<Plan> = plans.into_iter().filter(|plan| !plan.tracers.is_empty()).collect();
    arguments.tuned.as_ref().map_or(Ok(plans.clone()), |path| tuned(&plans, path))
}

/// The plans by scene, with the value that a tuning found elsewhere in those rows that say nothing of its parameter.
fn tuned(plans: &[Plan], path: &Path) -> Result<Vec<Plan>, CliError> {
    let run = report::read_run(path)?;
    let tuning = Tuning::of(&run);
    let tuning =
        tuning.ok_or_else(|| CliError::Argument(format!("--tuned {}: the run is no tuning", path.display())))?;
    let (tracer, parameter) = (&tuning.tracer.name, &tuning.axis.name);
    let is_open = |request: &TracerRequest| request.name() == tracer && !request.changed.contains(parameter);
    let of_scene = |plan: &Plan, scene: &SceneSource| {
        let mut plan = Plan { scenes: vec![scene.clone()], ..plan.clone() };
        let name = scene.name();
        let rays = plan.ray_sets.first().map_or("", |set| set.name);
        for request in plan.tracers.iter_mut().filter(|request| is_open(request)) {
            let value = tuning.value_from_own_viewpoint(name, rays, Label::TunedElsewhere).ok_or_else(|| {
                CliError::Argument(format!(
                    "--tuned {}: it has no {parameter} for {rays} rays in {name} from another viewpoint; tune it with --scene {name} \
                     --rays {rays}, or leave the scene out",
                    path.display()
                ))
            })?;
            request.set(parameter, value).map_err(|error| CliError::Argument(format!("--tuned: {error}")))?;
        }
        Ok(plan)
    };
    plans.iter().flat_map(|plan| plan.scenes.iter().map(move |scene| of_scene(plan, scene))).collect()
}

/// Tells how long a table would take.
fn estimate(
    table: Table,
    paper: &Paper,
    experiment: &'static Experiment,
    arguments: &TableArguments,
    path: &Path,
) -> Result<(), CliError> {
    let run = report::read_run(path)?;
    // On an adapter of the kind that the run had.
    let hardware = run.provenance.machine.adapter.as_ref().is_some_and(|adapter| adapter.kind != "software");
    let mut base = arguments.work.plan(arguments.matter(table)?, || hardware)?;
    let plans = plans(paper, experiment, arguments, &mut base)?;
    print(&format!("{}\n", papers::Duration::of(&plans, &run).words(table.name())))
}

/// Makes the table of what was measured before.
fn again(table: Table, path: &PathBuf, out: Option<&Path>) -> Result<(), CliError> {
    // Read before anything is written.
    let run = report::read_run(path)?;
    let folder = OutputFolder::open(&out.map_or_else(|| folder_of(path), Path::to_owned))?;
    refuse_others(folder.path(), std::iter::once(path))?;
    tables::write(table, &run, &folder)?;
    print_page(&report::table_page(table.name(), folder.path()))
}
