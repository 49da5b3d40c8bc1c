//! `sweep`, and `sweep --choose`.

use clap::builder::ArgPredicate;
use clap::{Arg, Args};
use serde_json::json;
use tracebench_api::Invalidation;

use super::arguments::Selection;
use super::studies::{StudyArguments, rule};
use super::work::Work;
use super::{CliError, names, refuse};
use crate::judge::Rule;
use crate::plan::{Plan, TracerRequest};
use crate::progress::Progress;
use crate::registry::{self, Registration, TRACERS};
use crate::results::{AxisRecord, CHOOSE};
use crate::studies::sweep::{RESOLUTION, Sweep, SweepError, parameter_axis, resolution_axis};

#[derive(Args)]
#[command(
    mut_arg("scene", |arg| by_default(arg, "room", "all")),
    mut_arg("tracer", |arg| by_default(arg.help("The tracer: NAME, NAME:PRESET or NAME@PARAMETER=VALUE. Its values, with those of `--set`, are the ones round which parameters are swept"), tracer_of(has_sweep), tracer_of(|tracer| tracer.tune.is_some()))),
    mut_arg("rays", |arg| by_default(arg, "diffuse", "specular,diffuse")),
)]
pub(super) struct SweepArguments {
    #[arg(long, value_name = "P[=V,V...],...", allow_hyphen_values = true, help = over_help())]
    over: Vec<String>,
    /// Sweeps all combinations of two, in place of one at a time: A,B, as in --over. Charts have A along the axis.
    #[arg(long, value_name = "A,B", conflicts_with = "over", allow_hyphen_values = true)]
    grid: Option<String>,
    /// Shows what the choice of one parameter costs, in place of times: its default beside the values that are best by this rule here, from
    /// another viewpoint of the scene and on the other scenes. Any-hit sets are judged by balanced accuracy.
    #[arg(long, value_name = "RULE", value_parser = Rule::ALL.map(Rule::name), conflicts_with_all = ["grid", "samples", "ratio_precision", "time_limit"])]
    choose: Option<String>,
    #[command(flatten)]
    study: StudyArguments,
}

fn has_sweep(tracer: &Registration) -> bool {
    !tracer.sweep.is_empty()
}

/// The tracer that is swept, or whose parameter is chosen, where none is named.
fn tracer_of(is: fn(&Registration) -> bool) -> &'static str {
    registry::first(is).map_or("", Registration::name)
}

/// An option that is something else with `--choose` where it is not given.
fn by_default(arg: Arg, own: &'static str, chosen: &'static str) -> Arg {
    let help = arg.get_help().map(ToString::to_string).unwrap_or_default();
    let arg = arg.default_value(own).default_value_if("choose", ArgPredicate::IsPresent, chosen);
    arg.help(format!("{help}; with --choose {chosen} if not given"))
}

/// The help of `--over`, with what registrations say is swept or chosen.
fn over_help() -> String {
    let list = |names: &[&str]| match names {
        [most @ .., last] if !most.is_empty() => format!("{} and {last}", most.join(", ")),
        _ => names.concat(),
    };
    let of = |each: &Registration| format!("{} {}", each.name(), list(&each.sweep));
    let of: Vec<String> = TRACERS.iter().filter(|each| has_sweep(each)).map(of).collect();
    let chosen = TRACERS.iter().filter_map(|each| Some(format!("{} {}", each.name(), each.tune?)));
    format!(
        "What is swept, with commas, and may be repeated: parameters of the tracer (NAME takes the values of `list \
         tracers`, NAME=V,V,... those given) and `resolution` (multiples N or 1/N of the edges of frame and faces; \
         1/4,1/2,1,2). The tracer's own value is always among them. Of {} if not given; of another tracer all that it has. With --choose one parameter: of {} if not given",
        of.join(", of "),
        chosen.collect::<Vec<_>>().join(", of ")
    )
}

impl SweepArguments {
    fn request(&self) -> Result<TracerRequest, CliError> {
        let StudyArguments { tracer, work, .. } = &self.study;
        names::one_tracer(tracer, &work.common.settings, &format!("--tracer '{tracer}': a sweep takes one tracer"))
    }

    fn selection(&self) -> Result<Selection, CliError> {
        Selection::of(&self.study.scene, self.request().map(|request| vec![request]), &self.study.rays)
    }

    /// What is swept round a request's own values.
    fn axes(&self, request: &TracerRequest) -> Result<Vec<AxisRecord>, CliError> {
        if self.choose.is_some() {
            return Ok(vec![self.axis(request)?]);
        }
        let wanted = match &self.grid {
            Some(grid) => vec![grid.clone()],
            None if self.over.is_empty() => vec![default_axes(request)],
            None => self.over.clone(),
        };
        let option = if self.grid.is_some() { "--grid" } else { "--over" };
        let axes = axes(request, &wanted, option)?;
        match (&self.grid, axes.len()) {
            (Some(grid), count) if count != 2 => {
                refuse(format!("--grid '{grid}' has {count} parameters, it takes two"))
            }
            _ => Ok(axes),
        }
    }

    /// The one parameter of which a value is chosen: the one that is named, or the one that the tracer's registration names.
    fn axis(&self, request: &TracerRequest) -> Result<AxisRecord, CliError> {
        let over = match (self.over.as_slice(), request.registration.tune) {
            ([], None) => return refuse(which(request)),
            ([], Some(own)) => vec![own.to_owned()],
            (over, _) => over.to_vec(),
        };
        let mut found = axes(request, &over, "--over")?;
        let (Some(axis), []) = (found.pop(), found.as_slice()) else {
            return refuse(format!("--over '{}': --choose takes one parameter", over.join(",")));
        };
        let name = &axis.name;
        let why = if name == RESOLUTION {
            format!("--over {name}: more is better, nobody has to choose it; leave --choose out to see what it costs")
        } else if request.changed.contains(name) {
            format!("--over {name}: it is set already, and its default is what the preset says; leave it to --choose")
        } else if axis.values.len() < 2 {
            format!("--over {name}: there is nothing to choose beside {}; give values as {name}=V,V,...", axis.own)
        } else {
            return Ok(axis);
        };
        refuse(why)
    }
}

/// Asks for the parameter of which a value is to be chosen.
fn which(request: &TracerRequest) -> String {
    let described = request.registration.describe().parameters;
    let worth: Vec<&str> = described.iter().filter(|each| each.sweep.len() > 1).map(|each| each.name).collect();
    let worth = if worth.is_empty() { "it has none with values to choose from".to_owned() } else { worth.join(", ") };
    format!("which parameter of {} is to be chosen? Name one with --over: {worth}", request.name())
}

/// What is swept where nothing is said.
fn default_axes(request: &TracerRequest) -> String {
    let matters = |name: &&str| request.registration.can_matter(name, &request.parameters);
    if has_sweep(&request.registration) {
        return request.registration.sweep.iter().copied().filter(matters).collect::<Vec<_>>().join(",");
    }
    let description = request.registration.describe();
    let swept = description.parameters.iter().filter(|each| each.sweep.len() > 1).map(|each| each.name);
    let sized = description.invalidated_by.contains(&Invalidation::Resolution).then_some(RESOLUTION);
    swept.chain(sized).filter(matters).collect::<Vec<_>>().join(",")
}

/// Reads lists like `tile_size,buckets=1,4,8,resolution`: what is no parameter's name is a value of the one before.
fn axes(request: &TracerRequest, lists: &[String], option: &str) -> Result<Vec<AxisRecord>, CliError> {
    let described = request.registration.describe().parameters;
    let mut known: Vec<&str> = described.iter().map(|each| each.name).collect();
    known.push(RESOLUTION);
    // Names with their values; `None` where none are given.
    let mut wanted: Vec<(String, Option<Vec<String>>)> = Vec::new();
    for list in lists {
        let mut values_may_follow = false;
        for part in list.split(',').map(str::trim) {
            if part.is_empty() {
                return refuse(format!("{option} '{list}' has an empty name or value"));
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
                return refuse(format!("{option}: {name} is there twice"));
            }
            if value == Some("") {
                return refuse(format!("{option} '{list}': {name}= has no values"));
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
    let (grid, by) = (arguments.grid.is_some(), arguments.choose.as_deref().and_then(|name| rule(name).ok()));
    let sweep = |plan: &Plan, axes: Vec<AxisRecord>| {
        let option = if grid { "--grid" } else { "--over" };
        let sweep = Sweep::new(plan, axes, grid).map_err(|error| refused(&error, option))?;
        Ok::<_, CliError>(if let Some(rule) = by { sweep.choosing(rule) } else { sweep })
    };
    sweep(&arguments.study.work.plan(arguments.selection()?, || false)?, axes)?;
    let verb = if by.is_some() { CHOOSE } else { "sweep" };
    let work = Work::prepare(&arguments.study.work, || arguments.selection(), verb, progress)?;
    // By the means that it has here; and the preset of the adapter's kind may have other edges.
    let axes = arguments.axes(&work.plan.tracers[0])?;
    let sweep = sweep(&work.plan, axes.clone()).inspect_err(|_| work.bench.out.abandon())?;
    progress.say(&format!("{} points", sweep.size()));
    let words = match by {
        Some(rule) => json!({ "axis": axes.first(), "rule": rule }),
        None => json!({ "axes": axes, "grid": grid }),
    };
    work.study(words, None, |context| sweep.execute(context)).map(drop)
}

#[cfg(test)]
mod tests {
    use clap::Parser as _;

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
            let described = registration.describe().parameters;
            let found = axes(&request, &[default_axes(&request)], "--over").unwrap();
            assert!(!found.is_empty() && found.iter().all(|axis| axis.values.contains(&axis.own)));
            for value in described.iter().flat_map(|each| &each.sweep) {
                assert!(described.iter().all(|each| each.name != value.to_string()), "{value}");
            }
        }
    }

    #[derive(clap::Parser)]
    struct Line {
        #[command(flatten)]
        sweep: SweepArguments,
    }

    fn axis(arguments: &[&str]) -> Result<AxisRecord, CliError> {
        let line = Line::try_parse_from([&["sweep", "--choose", "footprint"], arguments].concat()).unwrap();
        line.sweep.axis(&line.sweep.request()?)
    }

    /// Proves that a value of one parameter is chosen, by the values of its description unless others are given, round the preset's value,
    /// and that anything else is refused with what to do.
    #[test]
    fn one_parameter_round_its_default() {
        let found = axis(&[]).unwrap();
        assert!(found.name == "thickness" && found.values.len() > 5 && found.values.contains(&found.own), "{found:?}");
        let found = axis(&["--tracer", "screen-dda", "--over", "thickness=0.3,0.1"]).unwrap();
        assert_eq!((found.values.join(" ").as_str(), found.own.as_str()), ("0.005 0.1 0.3", "0.005"));
        // Where nothing is said the tracer's own is meant.
        assert_eq!(axis(&["--tracer", "quadtree"]).unwrap().name, "gamma_dist");
        for (arguments, part) in [
            (&["--over", "thickness,start_bias"][..], "one parameter"),
            (&["--over", "resolution"], "leave --choose out"),
            (&["--tracer", "screen-dda", "--over", "thickness=0.005"], "nothing to choose"),
            (&["--over", "thicknes"], "'thickness'"),
            (&["--over", "thickness=-1e5"], "a number from -10000"),
            (&["--tracer", "screen-dda", "--over", "thickness=-1"], "a number from 0"),
            (&["--tracer", "screen-dda@thickness=0.1"], "set already"),
            (&["--tracer", "screen-dda", "--set", "screen-dda.thickness=0.1"], "set already"),
            (&["--tracer", "dirt"], "which parameter of dirt is to be chosen? Name one with --over: "),
            (&["--tracer", "ray-query"], "Name one with --over: prefer, equal_t"),
            (&["--tracer", "all"], "one tracer"),
        ] {
            let message = axis(arguments).map_or_else(|error| error.to_string(), |_| String::new());
            assert!(message.contains(part), "{arguments:?}: {message}");
        }
    }
}
