//! `sweep`.

use std::ffi::OsString;

use clap::Args;
use serde_json::json;
use tracebench_api::Invalidation;

use super::arguments::{Matter, WorkArguments};
use super::output::print_page;
use super::work::{Clock, Work, described};
use super::{CliError, names};
use crate::plan::TracerRequest;
use crate::progress::Progress;
use crate::registry::{self, Registration, TRACERS};
use crate::report;
use crate::results::AxisRecord;
use crate::studies::sweep::{RESOLUTION, Sweep, SweepError, parameter_axis, resolution_axis};

#[derive(Args)]
pub(super) struct SweepArguments {
    /// Scenes: names from `list scenes`, or paths to .gltf or .glb files; several with commas. `all`: every listed one.
    #[arg(long, default_value = "room")]
    scene: OsString,
    /// The tracer: NAME, NAME:PRESET or NAME@PARAMETER=VALUE. Its values, with those of `--set`, are the ones round which
    /// parameters are swept.
    #[arg(long, default_value = registry::first(has_sweep).map(Registration::name))]
    tracer: String,
    /// Ray sets: names from `list rays` with commas, or all.
    #[arg(long, default_value = "diffuse")]
    rays: String,
    #[arg(long, value_name = "P[=V,V...],...", allow_hyphen_values = true, help = over_help())]
    over: Vec<String>,
    /// Sweeps all combinations of two, in place of one at a time: A,B, as in --over. Charts have A along the axis.
    #[arg(long, value_name = "A,B", conflicts_with = "over", allow_hyphen_values = true)]
    grid: Option<String>,
    #[command(flatten)]
    work: WorkArguments,
}

fn has_sweep(tracer: &Registration) -> bool {
    !tracer.sweep.is_empty()
}

/// The help of `--over`, with what rooms say is swept.
fn over_help() -> String {
    let list = |names: &[&str]| match names {
        [most @ .., last] if !most.is_empty() => format!("{} and {last}", most.join(", ")),
        _ => names.concat(),
    };
    let of = |each: &Registration| format!("{} {}", each.name(), list(each.sweep));
    let of: Vec<String> = TRACERS.iter().filter(|each| has_sweep(each)).map(of).collect();
    format!(
        "What is swept, with commas, and may be repeated: parameters of the tracer (NAME takes the values of `list \
         tracers`, NAME=V,V,... those given) and `resolution` (multiples N or 1/N of the edges of frame and faces; \
         1/4,1/2,1,2). The tracer's own value is always among them. Of {} if not given; of another tracer all that it has",
        of.join(", of ")
    )
}

impl SweepArguments {
    fn request(&self) -> Result<TracerRequest, CliError> {
        one_tracer(&self.tracer, &self.work.common.settings, "a sweep")
    }

    fn matter(&self) -> Result<Matter, CliError> {
        Matter::of(&self.scene, self.request().map(|request| vec![request]), &self.rays)
    }

    /// What is swept round a request's own values.
    fn axes(&self, request: &TracerRequest) -> Result<Vec<AxisRecord>, CliError> {
        let wanted = match &self.grid {
            Some(grid) => vec![grid.clone()],
            None if self.over.is_empty() => vec![default_axes(request)],
            None => self.over.clone(),
        };
        let option = if self.grid.is_some() { "--grid" } else { "--over" };
        let axes = axes(request, &wanted, option)?;
        match (&self.grid, axes.len()) {
            (Some(grid), count) if count != 2 => {
                Err(CliError::Argument(format!("--grid '{grid}' has {count} parameters, it takes two")))
            }
            _ => Ok(axes),
        }
    }
}

/// The only tracer that a verb takes.
pub(super) fn one_tracer(list: &str, settings: &[String], verb: &str) -> Result<TracerRequest, CliError> {
    let mut tracers = names::tracers(list, settings)?;
    match (tracers.pop(), tracers.as_slice()) {
        (Some(tracer), []) => Ok(tracer),
        _ => Err(CliError::Argument(format!("--tracer '{list}': {verb} takes one tracer"))),
    }
}

/// What is swept where nothing is said.
fn default_axes(request: &TracerRequest) -> String {
    let matters = |name: &&str| request.registration.can_matter(name, &request.parameters);
    if has_sweep(&request.registration) {
        return request.registration.sweep.iter().copied().filter(matters).collect::<Vec<_>>().join(",");
    }
    let description = (request.registration.describe)();
    let swept = description.parameters.iter().filter(|each| each.sweep.len() > 1).map(|each| each.name);
    let sized = description.invalidated_by.contains(&Invalidation::Resolution).then_some(RESOLUTION);
    swept.chain(sized).filter(matters).collect::<Vec<_>>().join(",")
}

/// Reads lists like `tile_size,buckets=1,4,8,resolution`: what is no parameter's name is a value of the one before.
pub(super) fn axes(request: &TracerRequest, lists: &[String], option: &str) -> Result<Vec<AxisRecord>, CliError> {
    let described = (request.registration.describe)().parameters;
    let mut known: Vec<&str> = described.iter().map(|each| each.name).collect();
    known.push(RESOLUTION);
    // Names with their values; `None` where none are given.
    let mut wanted: Vec<(String, Option<Vec<String>>)> = Vec::new();
    for list in lists {
        let mut values_may_follow = false;
        for part in list.split(',').map(str::trim) {
            if part.is_empty() {
                return Err(CliError::Argument(format!("{option} '{list}' has an empty name or value")));
            }
            let (name, value) = part.split_once('=').map_or((part, None), |(name, value)| (name, Some(value.trim())));
            if !known.contains(&name) {
                match wanted.last_mut() {
                    Some((_, Some(values))) if values_may_follow && value.is_none() => values.push(name.to_owned()),
                    _ => return Err(names::unknown(&format!("parameter of {}", request.name()), name, &known)),
                }
                continue;
            }
            if wanted.iter().any(|(other, _)| other == name) {
                return Err(CliError::Argument(format!("{option}: {name} is there twice")));
            }
            if value == Some("") {
                return Err(CliError::Argument(format!("{option} '{list}': {name}= has no values")));
            }
            values_may_follow = value.is_some();
            wanted.push((name.to_owned(), value.map(|value| vec![value.to_owned()])));
        }
    }
    let make = |(name, values): (String, Option<Vec<String>>)| match described.iter().find(|each| each.name == name) {
        Some(parameter) => parameter_axis(request, parameter, values.as_deref()),
        None => resolution_axis(values.as_deref()),
    };
    wanted.into_iter().map(make).collect::<Result<_, _>>().map_err(|error| refused(&error, option))
}

fn refused(error: &SweepError, option: &str) -> CliError {
    CliError::Argument(format!("{option}: {error}"))
}

pub(super) fn sweep(arguments: &SweepArguments, progress: &Progress) -> Result<(), CliError> {
    // Arguments are checked before any device or file is touched.
    let axes = arguments.axes(&arguments.request()?)?;
    let grid = arguments.grid.is_some();
    let option = if grid { "--grid" } else { "--over" };
    let checked = arguments.work.plan(arguments.matter()?, || false)?;
    Sweep::new(&checked, axes, grid).map_err(|error| refused(&error, option))?;
    let work = Work::prepare(&arguments.work, || arguments.matter(), Clock::Timed, progress)?;
    // By the means that it has here.
    let axes = arguments.axes(&work.plan.tracers[0])?;
    let sweep = Sweep::new(&work.plan, axes.clone(), grid).map_err(|error| {
        // The preset of the adapter's kind may have other edges.
        work.bench.out.abandon();
        refused(&error, option)
    })?;
    progress.say(&format!("{} points", sweep.len()));
    let required = work.plan.tracers.iter().any(TracerRequest::must_have_device);
    let plan = described("sweep", std::slice::from_ref(&work.plan), json!({ "axes": axes, "grid": grid }));
    work.bench.measure(&plan, progress, |context| sweep.execute(required, context))?;
    print_page(&work.bench.out.path().join(report::SWEEP_PAGE))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(lists: &[&str]) -> Result<Vec<AxisRecord>, CliError> {
        let request = names::tracers("dirt", &[]).unwrap().remove(0);
        let lists: Vec<String> = lists.iter().map(|list| (*list).to_owned()).collect();
        axes(&request, &lists, "--over")
    }

    /// Names and values share the comma: a value belongs to the name before it, a name without values has those of its
    /// description, and what is wrong is said with what would be right.
    #[test]
    fn lists_of_names_and_values() {
        let found = parse(&["tile_size,buckets=1,4,8,resolution", "coverage,clip=plane"]).unwrap();
        let found: Vec<_> = found.iter().map(|axis| (axis.name.as_str(), axis.values.join(" "))).collect();
        let expected = [
            ("tile_size", "1 2 4 8"),
            ("buckets", "1 4 8 24"),
            ("resolution", "1/4 1/2 1 2"),
            ("coverage", "conservative standard"),
            ("clip", "polygon plane"),
        ];
        assert_eq!(found, expected.map(|(name, values)| (name, values.to_owned())));
        for (list, part) in [
            ("bucket", "'buckets'"),
            ("buckets,4", "no parameter of dirt '4'"),
            ("buckets=", "no values"),
            ("buckets=,4", "no values"),
            ("buckets=4,,8", "empty"),
            ("", "empty"),
            (",", "empty"),
            ("buckets=0", "1 to 256"),
            ("buckets=1e9", "1 to 256"),
            ("buckets=4,clp=plane", "'clip'"),
            ("buckets,buckets=4", "twice"),
            ("resolution=0", "1/N"),
            ("resolution=2/3", "1/N"),
            ("buckets=1,2,3,4,5,6,7,8,9,10,11,12,13,14,15,16", "16 are the most"),
        ] {
            let message = parse(&[list]).map(|_| String::new()).unwrap_or_else(|error| error.to_string());
            assert!(message.contains(part), "{list}: {message}");
        }
    }

    /// What is swept where nothing is said can be swept, and no value of any parameter reads like a parameter's name.
    #[test]
    fn every_tracer_can_be_swept() {
        for registration in TRACERS {
            let request = TracerRequest::of(registration, tracebench_api::Preset::Published);
            let described = (registration.describe)().parameters;
            let found = axes(&request, &[default_axes(&request)], "--over").unwrap();
            assert!(!found.is_empty() && found.iter().all(|axis| axis.values.contains(&axis.own)));
            for value in described.iter().flat_map(|each| &each.sweep) {
                assert!(described.iter().all(|each| each.name != value.to_string()), "{value}");
            }
        }
    }
}
