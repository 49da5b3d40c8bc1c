//! `tune`.

use std::ffi::OsString;

use clap::Args;
use serde_json::json;

use super::arguments::{Matter, WorkArguments};
use super::output::print;
use super::sweep::{axes, one_tracer};
use super::work::{Clock, Work, described};
use super::{CliError, names};
use crate::judge::Rule;
use crate::plan::TracerRequest;
use crate::progress::Progress;
use crate::registry::{self, Registration, TRACERS};
use crate::report;
use crate::results::AxisRecord;
use crate::studies::sweep::RESOLUTION;
use crate::studies::tune::{Tune, Tuning};

#[derive(Args)]
pub(super) struct TuneArguments {
    /// Scenes: names from `list scenes`, or paths to .gltf or .glb files; several with commas. `all`: every listed one.
    #[arg(long, default_value = "all")]
    scene: OsString,
    /// The tracer: NAME, NAME:PRESET or NAME@PARAMETER=VALUE.
    #[arg(long, default_value = tuned().map(Registration::name))]
    tracer: String,
    /// Ray sets: names from `list rays` with commas, or all.
    #[arg(long, default_value = "specular,diffuse")]
    rays: String,
    #[arg(long, value_name = "P[=V,V...]", allow_hyphen_values = true, help = over_help())]
    over: Option<String>,
    /// The rule by which the best value is chosen; any-hit sets are judged by balanced accuracy.
    #[arg(long, default_value = Rule::Footprint.name(), value_parser = Rule::ALL.map(Rule::name))]
    rule: String,
    #[command(flatten)]
    work: WorkArguments,
}

/// The tracer that is tuned where none is named.
fn tuned() -> Option<&'static Registration> {
    registry::first(|tracer| tracer.tune.is_some())
}

/// The help of `--over`, with what rooms say is tuned.
fn over_help() -> String {
    let of = TRACERS.iter().filter_map(|tracer| Some(format!("{} {}", tracer.name(), tracer.tune?)));
    format!(
        "The parameter, with the values of `list tracers` or with others (NAME=V,V,...); the preset's is always among them. Of {} if \
         not given; of another tracer one must be named",
        of.collect::<Vec<_>>().join(", of ")
    )
}

impl TuneArguments {
    /// What is tuned, and how: as it is said, or what the tracer's room says.
    fn over(&self, request: &TracerRequest) -> Result<String, CliError> {
        if let Some(over) = self.over.as_deref().or(request.registration.tune) {
            return Ok(over.to_owned());
        }
        let described = (request.registration.describe)().parameters;
        let worth: Vec<&str> = described.iter().filter(|each| each.sweep.len() > 1).map(|each| each.name).collect();
        let worth =
            if worth.is_empty() { "it has none with values to choose from".to_owned() } else { worth.join(", ") };
        Err(CliError::Argument(format!(
            "which parameter of {} is to be tuned? Name one with --over: {worth}",
            request.name()
        )))
    }

    fn request(&self) -> Result<TracerRequest, CliError> {
        one_tracer(&self.tracer, &self.work.common.settings, "tune")
    }

    fn matter(&self) -> Result<Matter, CliError> {
        Matter::of(&self.scene, self.request().map(|request| vec![request]), &self.rays)
    }

    fn rule(&self) -> Result<Rule, CliError> {
        let found = Rule::ALL.into_iter().find(|rule| rule.name() == self.rule);
        found.ok_or_else(|| names::unknown("rule", &self.rule, &Rule::ALL.map(Rule::name)))
    }

    fn axis(&self, request: &TracerRequest) -> Result<AxisRecord, CliError> {
        let over = self.over(request)?;
        let mut found = axes(request, std::slice::from_ref(&over), "--over")?;
        let (Some(axis), []) = (found.pop(), found.as_slice()) else {
            return Err(CliError::Argument(format!("--over '{over}': tune takes one parameter")));
        };
        let name = &axis.name;
        let why = if name == RESOLUTION {
            format!("--over {name}: more is better, nobody has to tune it; `sweep` shows what it costs")
        } else if request.changed.contains(name) {
            format!("--over {name}: it is set already, and its default is what the preset says; leave it to tune")
        } else if axis.values.len() < 2 {
            format!("--over {name}: there is nothing to choose beside {}; give values as {name}=V,V,...", axis.own)
        } else {
            return Ok(axis);
        };
        Err(CliError::Argument(why))
    }
}

pub(super) fn tune(arguments: &TuneArguments, progress: &Progress) -> Result<(), CliError> {
    // Arguments are checked before any device or file is touched.
    let request = arguments.request()?;
    let rule = arguments.rule()?;
    arguments.axis(&request)?;
    if arguments.work.samples.is_some() || arguments.work.interval.is_some() || arguments.work.time_limit.is_some() {
        return Err(CliError::Argument(
            "--samples, --interval, --time-limit: tune takes no times; `sweep` does".to_owned(),
        ));
    }
    let work = Work::prepare(&arguments.work, || arguments.matter(), Clock::Untimed, progress)?;
    // By the means that it has here.
    let request = work.plan.tracers[0].clone();
    let axis = arguments.axis(&request)?;
    let words = json!({ "axis": axis, "rule": rule });
    let tune = Tune::new(&work.plan, &request, axis, rule)
        .map_err(|error| CliError::Argument(format!("--over: {error}")))
        .inspect_err(|_| work.bench.out.abandon())?;
    let plan = described("tune", std::slice::from_ref(&work.plan), words);
    let run = work.bench.measure(&plan, progress, |context| tune.execute(context))?;
    let page = work.bench.out.path().join(report::TUNE_PAGE);
    let overview = Tuning::of(&run).map(|tuning| report::tuning_overview(&tuning)).unwrap_or_default();
    print(&format!("{overview}\n{}\n", page.display()))
}

#[cfg(test)]
mod tests {
    use clap::Parser as _;

    use super::*;

    #[derive(clap::Parser)]
    struct Line {
        #[command(flatten)]
        tune: TuneArguments,
    }

    fn axis(arguments: &[&str]) -> Result<AxisRecord, CliError> {
        let line = Line::try_parse_from([&["tune"], arguments].concat()).unwrap();
        line.tune.axis(&line.tune.request()?)
    }

    /// Proves that one parameter is tuned, by the values of its description unless others are given, round the preset's value,
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
            (&["--over", "resolution"], "sweep"),
            (&["--tracer", "screen-dda", "--over", "thickness=0.005"], "nothing to choose"),
            (&["--over", "thicknes"], "'thickness'"),
            (&["--over", "thickness=-1e5"], "a number from -10000"),
            (&["--tracer", "screen-dda", "--over", "thickness=-1"], "a number from 0"),
            (&["--tracer", "screen-dda@thickness=0.1"], "set already"),
            (&["--tracer", "screen-dda", "--set", "screen-dda.thickness=0.1"], "set already"),
            (&["--tracer", "dirt"], "which parameter of dirt is to be tuned? Name one with --over: "),
            (&["--tracer", "ray-query"], "Name one with --over: prefer, equal_t"),
            (&["--tracer", "all"], "one tracer"),
        ] {
            let message = axis(arguments).map_or_else(|error| error.to_string(), |_| String::new());
            assert!(message.contains(part), "{arguments:?}: {message}");
        }
    }
}
