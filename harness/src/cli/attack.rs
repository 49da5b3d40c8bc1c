//! `attack`.

use std::ffi::OsString;
use std::time::Duration;

use clap::Args;
use serde_json::json;
use tracebench_api::TraceTo;

use super::arguments::{Selection, WorkArguments, within};
use super::work::{Clock, Work, all_measured};
use super::{CliError, names};
use crate::judge::Rule;
use crate::measure::Context;
use crate::progress::Progress;
use crate::report;
use crate::studies::attack::{self, AttackOptions, TRIAL_IMAGE};

#[derive(Args)]
pub(super) struct AttackArguments {
    /// Scenes: names from `list scenes`, or paths to .gltf or .glb files; several with commas. `all`: every listed one.
    #[arg(long, default_value = "room")]
    scene: OsString,
    /// Tracers, each searched for by itself: NAME or NAME:PRESET with commas, all, or all:improved.
    #[arg(long)]
    tracer: String,
    /// Ray sets, each searched for by itself: names from `list rays` with commas, or all.
    #[arg(long, default_value = "diffuse")]
    rays: String,
    /// The rule by which rays are wrong: hit_miss, tight or footprint. Any-hit rays have none.
    #[arg(long, default_value = Rule::Footprint.name(), value_parser = rule)]
    rule: Rule,
    /// Poses that are tried, and as many random ones. A longer search begins with the shorter one.
    #[arg(long, value_name = "N", default_value_t = 256, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    trials: u32,
    /// Begin no new trial after so many seconds, of all searches together.
    #[arg(long, value_name = "SECONDS", value_parser = within(0.0..=1e9, "a number of seconds"))]
    budget: Option<f64>,
    /// Measure the worst pose alone anew, draw no pictures, and make nothing small.
    #[arg(long)]
    brief: bool,
    #[command(flatten)]
    work: WorkArguments,
}

fn rule(text: &str) -> Result<Rule, String> {
    let found = Rule::ALL.into_iter().find(|rule| rule.name() == text);
    found.ok_or_else(|| Rule::ALL.map(Rule::name).join(" or "))
}

pub(super) fn attack(arguments: &AttackArguments, progress: &Progress) -> Result<(), CliError> {
    let AttackArguments { scene, tracer, rays, rule, trials, budget, brief, work: of_work } = arguments;
    if of_work.says_how_long() || of_work.trace_to != TraceTo::Hit {
        let refused = "--samples, --ratio-precision, --time-limit, --trace-to: attack takes no times and judges hits";
        return Err(CliError::Argument(refused.to_owned()));
    }
    let selection = || Selection::of(scene, names::tracers(tracer, &of_work.common.settings), rays);
    let mut work = Work::prepare(of_work, selection, Clock::Untimed, progress)?;
    work.plan.preset.ray_image = of_work.size.unwrap_or(TRIAL_IMAGE);
    let further = json!({ "rule": rule, "trials": trials, "brief": brief });
    let budget = budget.map(Duration::from_secs_f64);
    let options = AttackOptions { rule: *rule, trials: *trials, budget, is_brief: *brief };
    let execute = |context: &Context<'_>| attack::execute(&work.plan, &options, context);
    let record = work.study("attack", further, report::ATTACK_PAGE, progress, execute)?;
    all_measured(&work.plan, &record)
}
