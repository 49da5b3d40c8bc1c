//! `run`, and the verbs of studies: `need`, `pareto`, `frames`, `attack`, `explain` and `stability`.

use std::ffi::OsString;
use std::fmt::Display;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::time::Duration;

use clap::Args;
use itertools::Itertools as _;
use serde_json::{Value, json};
use tracebench_api::TraceTo;

use super::arguments::{DeviceArguments, Selection, WorkArguments};
use super::output::{print, print_end};
use super::work::{Bench, OutputArguments, Work, all_measured};
use super::{CliError, fail, fail_for, names, open_device, refuse};
use crate::files;
use crate::judge::Rule;
use crate::measure::{self, MAX_RESIDENT, records};
use crate::plan::within;
use crate::progress::Progress;
use crate::rays::RaySet;
use crate::registry::{Registration, TRACERS};
use crate::render::Effect;
use crate::report;
use crate::results::FramesRecord;
use crate::studies::attack::{self, AttackOptions, TRIAL_IMAGE};
use crate::studies::frames::{self, FramesRequest, Moves};
use crate::studies::pareto::{Extent, Pareto};
use crate::studies::stability::{self, ExpectedShares, Stability};
use crate::studies::sweep::SweepError;
use crate::studies::{explain, need};

/// What is to be measured, and how; the verbs have defaults of their own.
#[derive(Args)]
pub(super) struct StudyArguments {
    /// Scenes: names from `list scenes`, or paths to .gltf or .glb files; several with commas. `all`: every listed one.
    #[arg(long, default_value = "room")]
    pub scene: OsString,
    /// Tracers: NAME or NAME:PRESET with commas, all, or all:improved. A plain name means the published preset.
    /// NAME@PARAMETER=VALUE is the tracer with a value of its own, so that one may stand there several times.
    #[arg(long, default_value = "all")]
    pub tracer: String,
    /// Ray sets: names from `list rays` with commas, file:DIR for a folder of rays, or all.
    #[arg(long, default_value = "all")]
    pub rays: String,
    #[command(flatten)]
    pub work: WorkArguments,
}

impl StudyArguments {
    fn selection(&self) -> Result<Selection, CliError> {
        Selection::of(&self.scene, names::tracers(&self.tracer, &self.work.common.settings), &self.rays)
    }

    /// The same for a study over resolutions.
    fn between_samples(&self) -> Result<Selection, CliError> {
        Ok(Selection { between_samples: true, ..self.selection()? })
    }
}

pub(super) fn run(arguments: &StudyArguments, progress: &Progress) -> Result<(), CliError> {
    let work = Work::prepare(&arguments.work, || arguments.selection(), "run", progress)?;
    let plans = std::slice::from_ref(&work.plan);
    let record = work.bench.measure(plans, Value::Null, |context| measure::execute_all(plans, context))?;
    print_end(&report::run_table(&record), &work.bench.out.path().join("summary.md"))?;
    all_measured(&work.plan, &record)
}

pub(super) fn need(arguments: &StudyArguments, progress: &Progress) -> Result<(), CliError> {
    let work = Work::prepare(&arguments.work, || arguments.between_samples(), "need", progress)?;
    work.study(Value::Null, None, |context| need::execute(&work.plan, context)).map(drop)
}

#[derive(Args)]
#[command(
    mut_arg("tracer", |arg| arg.default_value("all,all:improved").help("Tracers: NAME or NAME:PRESET with commas, all, or all:improved. The presets of one tracer share its points")),
    mut_arg("rays", |arg| arg.default_value("diffuse,ao")),
)]
pub(super) struct ParetoArguments {
    #[command(flatten)]
    extent: Extent,
    #[command(flatten)]
    study: StudyArguments,
}

/// More frames than these have no room on a page.
const MOST_NUMBERS: usize = 3;

impl ParetoArguments {
    fn extent(&self) -> Result<Extent, CliError> {
        let mut extent = self.extent.clone();
        extent.rays_per_pixel.sort_by(f64::total_cmp);
        extent.rays_per_pixel.dedup();
        if extent.rays_per_pixel.len() > MOST_NUMBERS {
            return refuse(format!("--rays-per-pixel: {MOST_NUMBERS} numbers are the most"));
        }
        Ok(extent)
    }
}

pub(super) fn pareto(arguments: &ParetoArguments, progress: &Progress) -> Result<(), CliError> {
    // Arguments are checked before any device or file is touched.
    let (study, extent) = (&arguments.study, arguments.extent()?);
    let refused = |error: SweepError| CliError::Argument(error.to_string());
    Pareto::new(&study.work.plan(study.between_samples()?, || false)?, &extent).map_err(refused)?;
    let work = Work::prepare(&study.work, || study.between_samples(), "pareto", progress)?;
    // By the launch settings and the preset that it has here.
    let pareto = Pareto::new(&work.plan, &extent).map_err(refused).inspect_err(|_| work.bench.out.abandon())?;
    progress.say(&format!("{} points", pareto.size()));
    work.study(json!(extent), None, |context| pareto.execute(context)).map(drop)
}

#[derive(Args)]
pub(super) struct FramesArguments {
    /// Scenes: names from `list scenes`, or paths to .gltf or .glb files; several with commas. `all`: every listed one.
    #[arg(long, default_value = "room")]
    scene: OsString,
    /// Tracers: NAME or NAME:PRESET with commas, or all.
    #[arg(long, default_value = "all")]
    tracer: String,
    /// Ray sets to trace in place of effects: names from `list rays` with commas, or all.
    #[arg(long)]
    rays: Option<String>,
    #[command(flatten)]
    request: FramesRequest,
    #[command(flatten)]
    work: WorkArguments,
}

impl FramesArguments {
    fn selection(&self) -> Result<Selection, CliError> {
        let tracers = names::tracers(&self.tracer, &self.work.common.settings);
        let selection = Selection::of(&self.scene, tracers, self.rays.as_deref().unwrap_or("primary"))?;
        let ray_sets = if self.rays.is_some() { selection.ray_sets } else { Vec::new() };
        Ok(Selection { ray_sets, rounds: Some(self.request.frames), ..selection })
    }

    fn request(&self) -> Result<FramesRequest, CliError> {
        if self.work.says_how_long() {
            return refuse("--samples, --ratio-precision, --time-limit: a round is a frame; give --frames");
        }
        let mut request = self.request.clone();
        if let Some(cut) = request.cut.filter(|cut| *cut >= request.frames) {
            return refuse(format!("--cut {cut}: the last frame is {}", request.frames.saturating_sub(1)));
        }
        if request.fixed_rays && request.moves != Moves::Camera {
            return refuse("--fixed-rays: the scene must stand still; take --move camera");
        }
        if let Some(twice) = request.effects.iter().duplicates().next() {
            return refuse(format!("--effect: {} is there twice", twice.name()));
        }
        if self.rays.is_some() {
            request.spp = 1;
        } else if request.effects.is_empty() {
            request.effects.push(Effect::Primary);
        }
        Ok(request)
    }
}

pub(super) fn frames(arguments: &FramesArguments, progress: &Progress) -> Result<(), CliError> {
    let request = arguments.request()?;
    request.check(&arguments.selection()?.tracers).map_err(CliError::Argument)?;
    let work = Work::prepare(&arguments.work, || arguments.selection(), "frames", progress)?;
    let tracers = work.plan.tracers.len();
    if tracers > MAX_RESIDENT {
        work.bench.out.abandon();
        return refuse(format!("--tracer: {tracers} tracers, at most {MAX_RESIDENT} follow at a time"));
    }
    let record = work.study(json!(request), None, |context| frames::execute(&work.plan, &request, context))?;
    all_measured(&work.plan, &record)?;
    record.frames.as_ref().and_then(FramesRecord::fault).map_or(Ok(()), fail)
}

#[derive(Args)]
#[command(
    mut_arg("tracer", |arg| arg.default_value(None::<&str>).required(true).help("Tracers, each searched for by itself: NAME or NAME:PRESET with commas, all, or all:improved")),
    mut_arg("rays", |arg| arg.default_value("diffuse").help("Ray sets, each searched for by itself: names from `list rays` with commas, or all")),
)]
pub(super) struct AttackArguments {
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
    study: StudyArguments,
}

pub(super) fn rule(text: &str) -> Result<Rule, String> {
    let found = Rule::ALL.into_iter().find(|rule| rule.name() == text);
    found.ok_or_else(|| Rule::ALL.map(Rule::name).join(" or "))
}

pub(super) fn attack(arguments: &AttackArguments, progress: &Progress) -> Result<(), CliError> {
    let AttackArguments { rule, trials, budget, brief, study } = arguments;
    let of_work = &study.work;
    if of_work.says_how_long() || of_work.trace_to != TraceTo::Hit {
        return refuse("--samples, --ratio-precision, --time-limit, --trace-to: attack takes no times and judges hits");
    }
    let has_no_eye = |set: &RaySet| set.saved().is_some_and(|saved| saved.eye.is_none());
    if *rule == Rule::Footprint && study.selection()?.ray_sets.iter().any(has_no_eye) {
        return refuse("--rule footprint: rays of --rays file: have no eye; give --rule tight or hit_miss");
    }
    let mut work = Work::prepare(of_work, || study.selection(), "attack", progress)?;
    work.plan.preset.ray_image = of_work.size.unwrap_or(TRIAL_IMAGE);
    let further = json!({ "rule": rule, "trials": trials, "brief": brief });
    let budget = budget.map(Duration::from_secs_f64);
    let options = AttackOptions { rule: *rule, trials: *trials, budget, is_brief: *brief };
    let record = work.study(further, None, |context| attack::execute(&work.plan, &options, context))?;
    all_measured(&work.plan, &record)
}

pub(super) fn explainable(tracer: &Registration) -> bool {
    !tracer.remedies.is_empty()
}

pub(super) fn explain(arguments: &StudyArguments, progress: &Progress) -> Result<(), CliError> {
    let StudyArguments { scene, tracer, rays, work } = arguments;
    let request = names::one_tracer(tracer, &work.common.settings, "explain takes one tracer")?;
    let remedies = &request.registration.remedies;
    if remedies.is_empty() {
        let known: Vec<_> = TRACERS.iter().filter(|each| explainable(each)).map(Registration::name).collect();
        let (name, known) = (request.name(), known.join(", "));
        return refuse(format!("--tracer: {name} has no remedy sequence; there is one of: {known}"));
    }
    if work.says_how_long() {
        return refuse("--samples, --ratio-precision, --time-limit: explain takes no times");
    }
    let work = Work::prepare(work, || Selection::of(scene, Ok(vec![request.clone()]), rays), "explain", progress)?;
    // By the means that it has here.
    let (plan, request) = (&work.plan, &work.plan.tracers[0]);
    let heading = Some("## By scene");
    let record = work.study(Value::Null, heading, |context| explain::execute(plan, request, remedies, context))?;
    let Some(found) = &record.explanation else { return Ok(()) };
    let open = found.left_open().into_iter();
    let open = open.map(|(scene, set)| format!("{} of {} {} in {scene}", set.unexplained, set.count, set.rays));
    let open: Vec<String> = open.collect();
    fail_for(&open, ", ", |open| format!("rays are wrong on the last step and no known cause explains them: {open}"))
}

#[derive(Args)]
pub(super) struct StabilityArguments {
    /// Tracers: NAME or NAME:PRESET with commas, or all.
    #[arg(long, default_value = "all")]
    tracer: String,
    /// Cases: names from `list cases` with commas, or all.
    #[arg(long, default_value = "all")]
    case: String,
    /// A parameter on top of the preset: tracer.parameter=value, as in `list tracers`. May be repeated. Verdicts are
    /// shown then but do not count.
    #[arg(long = "set", value_name = "T.P=V", allow_hyphen_values = true)]
    settings: Vec<String>,
    /// Measure nothing: put the shares of wrong rays of the records --from into FILE, as what is expected on adapters of their kind.
    #[arg(long, value_name = "FILE", requires = "from")]
    expect: Option<PathBuf>,
    /// A record of stability cases, for --expect. May be repeated; of two that measured the same the later counts.
    #[arg(long, value_name = "RUN", requires = "expect")]
    from: Vec<PathBuf>,
    #[command(flatten)]
    device: DeviceArguments,
    #[command(flatten)]
    output: OutputArguments,
}

pub(super) fn stability(arguments: &StabilityArguments, progress: &Progress) -> Result<(), CliError> {
    if let Some(path) = &arguments.expect {
        return expect(path, &arguments.from);
    }
    // Arguments are checked before any device or file is touched.
    let mut requests = names::tracers(&arguments.tracer, &arguments.settings)?;
    if let Some(setting) = arguments.settings.iter().find(|setting| setting.starts_with("rays.")) {
        return refuse(format!("--set {setting}: cases bring their own rays"));
    }
    if arguments.settings.is_empty() {
        // Tracers that `all` has in several forms are expected something of in their own.
        requests.retain(|request| request.required || request.changed.is_empty());
    }
    let cases = names::cases(&arguments.case)?;
    let device = open_device(&arguments.device, &requests)?;
    let bench = Bench::open(device, &arguments.output, "stability", &mut requests, progress)?;
    let tracers: Vec<_> = requests.iter().map(records::request_record).collect();
    let names: Vec<&str> = cases.iter().map(|case| case.name).collect();
    let words = json!({ "cases": names, "tracers": tracers });
    let record = bench.measure(&[], words, |context| stability::run(&cases, &requests, context))?;
    let Some(found) = Stability::of(&record) else { return Ok(()) };
    let written = bench.out.path().join("stability.md");
    let surprises = found.surprises().len();
    let said = if surprises == 0 { "All as expected.".to_owned() } else { format!("{surprises} unexpected.") };
    print_end(&format!("{said}\n{}", report::stability_matrix(&found)), &written)?;
    outcome(&found)
}

/// Puts what records measured into a file of expected shares. What stands there of other adapters, tracers and cases stays.
fn expect(path: &Path, from: &[PathBuf]) -> Result<(), CliError> {
    let fail = |path: &Path, error: &dyn Display| CliError::Other(format!("{}: {error}", path.display()));
    let mut shares = match std::fs::read_to_string(path) {
        Ok(text) => ExpectedShares::parse(&text).map_err(|error| fail(path, &format!("left as it is: {error}")))?,
        Err(error) if error.kind() == ErrorKind::NotFound => ExpectedShares::default(),
        Err(error) => return Err(fail(path, &error)),
    };
    for record in from {
        shares.take(&report::read_run(record)?).map_err(|error| fail(record, &error))?;
    }
    // What is there was read as such a file: it is a document that grows.
    let write = if path.exists() { files::edit } else { files::write };
    write(path, shares.text().as_bytes()).map_err(|error| fail(path, &error))?;
    print(&format!("{}\n", path.display()))
}

/// Whether all came as expected, where that counts.
fn outcome(found: &Stability) -> Result<(), CliError> {
    let surprises = if found.counts { found.surprises() } else { Vec::new() };
    fail_for(&surprises, "; ", |all| format!("{} unexpected: {all}", surprises.len()))
}

#[cfg(test)]
mod tests {
    use clap::Parser as _;

    use super::*;
    use crate::measure::{Context, Journal};
    use crate::studies::pareto::{DEFAULT_POINTS, RAYS_PER_PIXEL};
    use crate::studies::stability::Verdict;
    use crate::truth::Cache;

    #[derive(clap::Parser)]
    struct Line {
        #[command(flatten)]
        pareto: ParetoArguments,
    }

    fn parse(arguments: &[&str]) -> Result<(Extent, usize), String> {
        let line = Line::try_parse_from([&["pareto"], arguments].concat()).map_err(|error| error.to_string())?;
        let extent = line.pareto.extent().map_err(|error| error.to_string())?;
        let study = line.pareto.study;
        let plan = study.between_samples().and_then(|selection| study.work.plan(selection, || false));
        let pareto = Pareto::new(&plan.map_err(|error| error.to_string())?, &extent);
        Ok((extent, pareto.map_err(|error| error.to_string())?.size()))
    }

    /// Proves that every tracer is there where none is named, that no tracer has more points than are asked for, and that what makes no
    /// sense is refused with what does.
    #[test]
    fn arguments_make_fronts() {
        let (extent, all) = parse(&[]).unwrap();
        assert_eq!(extent, Extent { max_points: DEFAULT_POINTS, rays_per_pixel: RAYS_PER_PIXEL.to_vec() });
        let (_, few) = parse(&["--points", "1"]).unwrap();
        assert_eq!(few, TRACERS.len());
        assert!(few < all && all <= few * DEFAULT_POINTS as usize);
        let (extent, dirt) = parse(&["--tracer", "dirt", "--points", "5", "--rays-per-pixel", "8,2,8"]).unwrap();
        assert_eq!((extent.rays_per_pixel, dirt), (vec![2.0, 8.0], 5));
        for (arguments, part) in [
            (&["--points", "0"][..], "1..=256"),
            (&["--points", "-1"], "1..=256"),
            (&["--rays-per-pixel", "0"], "0.001"),
            (&["--rays-per-pixel", "1,2,3,4"], "3 numbers"),
            (&["--tracer", "dirtt"], "'dirt'"),
            (&["--scene", "rooom"], "'room'"),
        ] {
            let error = parse(arguments).unwrap_err();
            assert!(error.contains(part), "{arguments:?}: {error}");
        }
    }

    /// Surprises in either direction and invalid cases end with 1 and name case and tracer, unless parameters were changed.
    #[test]
    fn surprises_are_errors() {
        let requests = names::tracers("bvh-cpu", &[]).unwrap();
        let device = Err(tracebench_api::TracerError::Unavailable("none is needed".to_owned()));
        let cases = names::cases("edge-on").unwrap();
        let (cache, quiet, journal) = (Cache::none(), Progress::new(true), Journal::none());
        let record = stability::run(&cases, &requests, &Context::new(&device, &cache, &quiet, &journal)).unwrap();
        let found = Stability::of(&record).unwrap();
        assert!(outcome(&found).is_ok());
        for verdict in [Verdict::UnexpectedFailure, Verdict::UnexpectedSuccess] {
            let mut changed = found.clone();
            changed.cases[0].cells[0].verdict = verdict;
            let error = outcome(&changed).unwrap_err();
            assert!(error.to_string().contains("edge-on, bvh-cpu: exact"), "{error}");
            assert_eq!(error.exit_code(), std::process::ExitCode::from(1));
            changed.counts = false;
            assert!(outcome(&changed).is_ok());
        }
        let mut invalid = found;
        invalid.cases[0].case.invalid = Some("the oracle erred".to_owned());
        assert!(outcome(&invalid).unwrap_err().to_string().contains("the oracle erred"));
        assert!(report::stability_matrix(&invalid).contains("edge-on (VOID)"));
    }
}
