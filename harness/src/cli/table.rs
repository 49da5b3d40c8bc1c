//! `table`.

use std::path::{Path, PathBuf};

use itertools::Itertools as _;
use serde_json::json;

use super::arguments::TableArguments;
use super::output::{print, print_head, print_page};
use super::records::folder_of;
use super::work::{Work, all_measured, fresh_folder, refuse_others};
use super::{CliError, fail, names, refuse};
use crate::files::OutputFolder;
use crate::measure;
use crate::papers::{self, Experiment, PART_SETTINGS, Paper};
use crate::plan::{Plan, SceneSource, TracerRequest};
use crate::progress::Progress;
use crate::report;
use crate::results::Record;
use crate::studies::frames;
use crate::studies::tune::{Label, Tuning};
use crate::tables::{self, Table, exact};

pub(super) fn table(arguments: &TableArguments, progress: &Progress) -> Result<(), CliError> {
    let table = names::table(&arguments.name)?;
    if let Table::Claims(paper) = table {
        return claims(paper, &arguments.from, arguments.work.output.out.as_deref());
    }
    let is_exact = matches!(table, Table::Exact);
    let of_papers =
        !arguments.only.is_empty() || arguments.estimate.is_some() || arguments.tuned.is_some() || arguments.few_rows;
    let common = &arguments.work.common;
    let request = if let Table::Paper(_, experiment) = table { experiment.frames.as_ref() } else { None };
    let by_rounds = arguments.estimate.is_some() || arguments.tuned.is_some() || arguments.work.says_how_long();
    let options_of_rounds = "--tuned, --estimate, --samples, --ratio-precision, --time-limit";
    let refused = [
        (is_exact && common.view.is_some(), "--view", "has viewpoints of its own"),
        (!is_exact && arguments.tracer.is_some(), "--tracer", "has its own"),
        (!matches!(table, Table::Paper(..)) && of_papers, "--only, --tuned, --few-rows, --estimate", "is no paper's"),
        (request.is_some() && by_rounds, options_of_rounds, "is of frames, each a round"),
    ];
    if let Some((_, options, why)) = refused.into_iter().find(|(is_refused, ..)| *is_refused) {
        return refuse(format!("{options}: table {} {why}", table.name()));
    }
    if let (Table::Paper(paper, experiment), Some(path)) = (table, &arguments.estimate) {
        return arguments.estimate(table, paper, experiment, path);
    }
    match arguments.from.as_slice() {
        [] => {}
        [path] => return again(table, path, arguments.work.output.out.as_deref()),
        _ => return refuse(format!("--from: table {} is made of one record", table.name())),
    }
    let Work { mut plan, bench } = Work::prepare(&arguments.work, || arguments.selection(table), "table", progress)?;
    let plans = match table {
        Table::Paper(paper, experiment) => {
            let plans = arguments.plans(paper, experiment, &mut plan);
            let mut plans = plans.inspect_err(|_| bench.out.abandon())?;
            plans.iter_mut().for_each(|plan| bench.give_launch_settings(&mut plan.tracers));
            plans
        }
        Table::Exact => exact::plans(&plan),
        Table::Settings(_) | Table::Claims(_) => vec![plan.clone()],
    };
    let record = bench.measure(&plans, json!(request), |context| match (request, plans.as_slice()) {
        (Some(request), [plan]) => frames::execute(plan, request, context),
        _ => measure::execute_all(&plans, context),
    })?;
    print_table(table, bench.out.path())?;
    if is_exact {
        all_measured(&plan, &record)?;
    }
    all_right(table, &record)
}

impl TableArguments {
    /// What an experiment runs over a base plan.
    fn plans(&self, paper: &Paper, experiment: &'static Experiment, base: &mut Plan) -> Result<Vec<Plan>, CliError> {
        let settings = &self.work.common.settings;
        let of_part = PART_SETTINGS.iter().filter(|_| self.few_rows);
        let own = of_part.chain(&experiment.settings).map(|setting| (*setting).to_owned());
        // What the user says comes later and counts.
        base.ray_parameters = names::ray_values(&own.chain(settings.iter().cloned()).collect::<Vec<_>>())?;
        let mut steps = names::steps(experiment, settings)?;
        names::only(&mut steps, &self.only)?;
        if self.few_rows {
            paper.take_part(experiment, base, &mut steps);
        }
        let plans = experiment.plans(base, &steps).map_err(|error| CliError::Argument(error.to_string()))?;
        let plans: Vec<Plan> = plans.into_iter().filter(|plan| !plan.tracers.is_empty()).collect();
        self.tuned.as_ref().map_or(Ok(plans.clone()), |path| tuned(&plans, path))
    }

    /// Tells how long a table would take, by the rows of a run.
    fn estimate(&self, table: Table, of: &Paper, experiment: &'static Experiment, by: &Path) -> Result<(), CliError> {
        let record = report::read_run(by)?;
        // On an adapter of the kind that the run had.
        let hardware = record.provenance.machine.adapter.as_ref().is_some_and(|adapter| adapter.kind != "software");
        let mut base = self.work.plan(self.selection(table)?, || hardware)?;
        let plans = self.plans(of, experiment, &mut base)?;
        print(&format!("{}\n", papers::Duration::of(&plans, &record).describe(table.name())))
    }
}

/// The plans by scene, with the value that a tuning found elsewhere in those rows that say nothing of its parameter.
fn tuned(plans: &[Plan], path: &Path) -> Result<Vec<Plan>, CliError> {
    let record = report::read_run(path)?;
    let tuning = Tuning::of(&record);
    let tuning =
        tuning.ok_or_else(|| CliError::Argument(format!("--tuned {}: the record is no tuning", path.display())))?;
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

/// Makes the table of what was measured before.
fn again(table: Table, path: &PathBuf, out: Option<&Path>) -> Result<(), CliError> {
    // Read before anything is written.
    let record = report::read_run(path)?;
    let folder = OutputFolder::open(&out.map_or_else(|| folder_of(path), Path::to_owned))?;
    refuse_others(folder.path(), std::iter::once(path))?;
    tables::write(table, &record, &folder)?;
    print_table(table, folder.path())?;
    all_right(table, &record)
}

/// That nothing speaks against what was measured.
fn all_right(table: Table, record: &Record) -> Result<(), CliError> {
    let fault = if let Table::Exact = table { exact::fault(record) } else { None };
    fault.or_else(|| record.frames.as_ref()?.fault()).map_or(Ok(()), fail)
}

/// Of a paper's table the verdicts are the answer.
fn print_table(table: Table, folder: &Path) -> Result<(), CliError> {
    print_page(&folder.join(report::table_page(table.name())), matches!(table, Table::Paper(..)).then_some("## Claims"))
}

/// Sets what a paper claims beside what was measured of it.
fn claims(paper: &Paper, from: &[PathBuf], out: Option<&Path>) -> Result<(), CliError> {
    let place = |path: &PathBuf| std::fs::canonicalize(folder_of(path)).unwrap_or_else(|_| path.clone());
    if let Some(twice) = from.iter().duplicates_by(|path| place(path)).next() {
        return refuse(format!("{}: it is given twice", twice.display()));
    }
    let rows = from.iter().map(|path| report::read_run(path)).collect::<Result<Vec<_>, _>>()?;
    let of_paper = |record: &Record| record.table.as_deref().is_some_and(|table| paper.experiment(table).is_some());
    if !rows.is_empty() && !rows.iter().any(of_paper) {
        return refuse(format!(
            "none of these runs is of a table of {}: `tracebench list tables` names them, `tracebench table NAME` makes one",
            paper.name
        ));
    }
    let folder = out.map_or_else(fresh_folder, OutputFolder::open)?;
    refuse_others(folder.path(), from.iter())?;
    let written = report::write_all(&papers::claims_report(paper, &rows)?.contents()?, &folder)?;
    print_head(&written[0])
}
