//! `run`, and the verbs of studies: `need`, `pareto`, `frames`, `attack`, `explain` and `stability`.

use std::ffi::OsString;
use std::fmt::Display;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::time::Duration;

use clap::Args;
use serde_json::{Value, json};
use tracebench_api::TraceTo;

use super::arguments::{DeviceArguments, Selection, WorkArguments, within};
use super::output::{print, print_end};
use super::work::{Bench, OutputArguments, Work, all_measured};
use super::{CliError, fail, fail_for, names, open_device, refuse};
use crate::files;
use crate::judge::Rule;
use crate::measure::{self, MAX_RESIDENT, records};
use crate::progress::Progress;
use crate::registry::{self, Registration, TRACERS};
use crate::render::Effect;
use crate::report;
use crate::results::FramesRecord;
use crate::studies::attack::{self, AttackOptions, TRIAL_IMAGE};
use crate::studies::frames::{self, FramesRequest, MAX_FRAMES, Moves, PathsOf, Updates};
use crate::studies::pareto::{DEFAULT_POINTS, Extent, MAX_POINTS, Pareto, RAYS_PER_PIXEL};
use crate::studies::stability::{self, ExpectedShares, Stability};
use crate::studies::sweep::SweepError;
use crate::studies::{explain, need};

#[derive(Args)]
pub(super) struct RunArguments {
    /// Scenes: names from `list scenes`, or paths to .gltf or .glb files; several with commas. `all`: every listed one.
    #[arg(long, default_value = "room")]
    scene: OsString,
    /// Tracers: NAME or NAME:PRESET with commas, all, or all:improved. A plain name means the published preset.
    /// NAME@PARAMETER=VALUE is the tracer with a value of its own, so that one may stand there several times.
    #[arg(long, default_value = "all")]
    tracer: String,
    /// Ray sets: names from `list rays` with commas, file:DIR for a folder of rays, or all.
    #[arg(long, default_value = "all")]
    rays: String,
    #[command(flatten)]
    work: WorkArguments,
}

pub(super) fn run(arguments: &RunArguments, progress: &Progress) -> Result<(), CliError> {
    let RunArguments { scene, tracer, rays, work } = arguments;
    let selection = || Selection::of(scene, names::tracers(tracer, &work.common.settings), rays);
    let work = Work::prepare(work, selection, "run", progress)?;
    let plans = std::slice::from_ref(&work.plan);
    let record = work.bench.measure(plans, Value::Null, |context| measure::execute_all(plans, context))?;
    print_end(&report::run_table(&record), &work.bench.out.path().join("summary.md"))?;
    all_measured(&work.plan, &record)
}

#[derive(Args)]
pub(super) struct NeedArguments {
    /// Scenes: names from `list scenes`, or paths to .gltf or .glb files; several with commas. `all`: every listed one.
    #[arg(long, default_value = "room")]
    scene: OsString,
    /// Tracers: NAME or NAME:PRESET with commas, or all. Methods with nothing to shrink stand there with what they store and touch.
    #[arg(long, default_value = "all")]
    tracer: String,
    /// Ray sets: names from `list rays` with commas, file:DIR for a folder of rays, or all.
    #[arg(long, default_value = "diffuse,ao")]
    rays: String,
    #[command(flatten)]
    work: WorkArguments,
}

pub(super) fn need(arguments: &NeedArguments, progress: &Progress) -> Result<(), CliError> {
    let NeedArguments { scene, tracer, rays, work } = arguments;
    let selection = || {
        let of = Selection::of(scene, names::tracers(tracer, &work.common.settings), rays);
        of.map(|of| Selection { between_samples: true, ..of })
    };
    let work = Work::prepare(work, selection, "need", progress)?;
    work.study(Value::Null, (report::NEED_PAGE, None), |context| need::execute(&work.plan, context)).map(drop)
}

#[derive(Args)]
pub(super) struct ParetoArguments {
    /// Scenes: names from `list scenes`, or paths to .gltf or .glb files; several with commas. `all`: every listed one.
    #[arg(long, default_value = "room")]
    scene: OsString,
    /// Tracers: NAME or NAME:PRESET with commas, all, or all:improved. The presets of one tracer share its points.
    #[arg(long, default_value = "all,all:improved")]
    tracer: String,
    /// Ray sets: names from `list rays` with commas, file:DIR for a folder of rays, or all.
    #[arg(long, default_value = "diffuse,ao")]
    rays: String,
    /// The most points of a tracer, over its parameters and resolutions; fewer are the first of more.
    #[arg(long, value_name = "N", default_value_t = DEFAULT_POINTS as u32, allow_negative_numbers = true,
          value_parser = clap::value_parser!(u32).range(1..=MAX_POINTS as i64))]
    points: u32,
    /// Rays a pixel of which the time of a frame is told, with the build; several with commas.
    #[arg(long, value_name = "K,K", value_delimiter = ',', default_values_t = RAYS_PER_PIXEL,
          value_parser = within(0.001..=1e6, "a number of rays from 0.001 to 1000000"))]
    rays_per_pixel: Vec<f64>,
    #[command(flatten)]
    work: WorkArguments,
}

/// More frames than these have no room on a page.
const MOST_NUMBERS: usize = 3;

impl ParetoArguments {
    fn selection(&self) -> Result<Selection, CliError> {
        let tracers = names::tracers(&self.tracer, &self.work.common.settings);
        Ok(Selection { between_samples: true, ..Selection::of(&self.scene, tracers, &self.rays)? })
    }

    fn extent(&self) -> Result<Extent, CliError> {
        let mut rays_per_pixel = self.rays_per_pixel.clone();
        rays_per_pixel.sort_by(f64::total_cmp);
        rays_per_pixel.dedup();
        if rays_per_pixel.len() > MOST_NUMBERS {
            return refuse(format!("--rays-per-pixel: {MOST_NUMBERS} numbers are the most"));
        }
        Ok(Extent { max_points: self.points as usize, rays_per_pixel })
    }
}

pub(super) fn pareto(arguments: &ParetoArguments, progress: &Progress) -> Result<(), CliError> {
    // Arguments are checked before any device or file is touched.
    let extent = arguments.extent()?;
    let refused = |error: SweepError| CliError::Argument(error.to_string());
    Pareto::new(&arguments.work.plan(arguments.selection()?, || false)?, &extent).map_err(refused)?;
    let work = Work::prepare(&arguments.work, || arguments.selection(), "pareto", progress)?;
    // By the launch settings and the preset that it has here.
    let pareto = Pareto::new(&work.plan, &extent).map_err(refused).inspect_err(|_| work.bench.out.abandon())?;
    progress.say(&format!("{} points", pareto.size()));
    let words = json!({ "max_points": extent.max_points, "rays_per_pixel": extent.rays_per_pixel });
    work.study(words, (report::PARETO_PAGE, None), |context| pareto.execute(context)).map(drop)
}

#[derive(Args)]
pub(super) struct FramesArguments {
    /// Scenes: names from `list scenes`, or paths to .gltf or .glb files; several with commas. `all`: every listed one.
    #[arg(long, default_value = "room")]
    scene: OsString,
    /// Tracers: NAME or NAME:PRESET with commas, or all.
    #[arg(long, default_value = "all")]
    tracer: String,
    /// Effects to render, with commas: depth, normals, primary (direct light), ao, mirror, diffuse (one bounce), path; primary if neither
    /// these nor ray sets are given.
    #[arg(long, value_name = "E,...", conflicts_with = "rays")]
    effect: Option<String>,
    /// Ray sets to trace in place of effects: names from `list rays` with commas, or all.
    #[arg(long)]
    rays: Option<String>,
    /// Samples a pixel.
    #[arg(long, value_name = "N", default_value_t = 4, conflicts_with = "rays", value_parser = clap::value_parser!(u32).range(1..=256))]
    spp: u32,
    /// Whose hits the paths of an effect go on from. On own ones one of eight rays behind the first wave is judged, else all.
    #[arg(long, value_enum, default_value_t = PathsOf::Own, conflicts_with = "rays")]
    paths: PathsOf,
    /// Frames; 1 is a picture.
    #[arg(long, value_name = "N", default_value_t = 12, value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_FRAMES)))]
    frames: u32,
    /// Frames a second, of the animation and of the camera's path.
    #[arg(long, value_name = "F", default_value_t = 24.0, value_parser = within(1e-3..=1e6, "a number of frames a second from 0.001 to 1000000"))]
    fps: f64,
    /// What moves.
    #[arg(long = "move", value_enum, default_value_t = Moves::Both)]
    moves: Moves,
    /// How structures are brought up to date in every frame.
    #[arg(long, value_enum, default_value_t = Updates::Auto)]
    update: Updates,
    /// The camera jumps to another viewpoint in this frame, counted from 0, and stays there.
    #[arg(long, value_name = "FRAME", value_parser = clap::value_parser!(u32).range(1..))]
    cut: Option<u32>,
    /// Trace the rays of the first frame in every frame, judged from its eye: only the viewpoints of structures change.
    #[arg(long, requires = "rays")]
    fixed_rays: bool,
    #[command(flatten)]
    work: WorkArguments,
}

impl FramesArguments {
    fn selection(&self) -> Result<Selection, CliError> {
        let tracers = names::tracers(&self.tracer, &self.work.common.settings);
        let selection = Selection::of(&self.scene, tracers, self.rays.as_deref().unwrap_or("primary"))?;
        let ray_sets = if self.rays.is_some() { selection.ray_sets } else { Vec::new() };
        Ok(Selection { ray_sets, ..selection })
    }

    fn effects(&self) -> Result<Vec<Effect>, CliError> {
        let list = if self.rays.is_some() { "" } else { self.effect.as_deref().unwrap_or("primary") };
        let mut effects = Vec::new();
        for name in list.split(',').filter(|_| self.rays.is_none()) {
            let Some(effect) = Effect::ALL.into_iter().find(|effect| effect.name() == name) else {
                let known = Effect::ALL.map(Effect::name).join(", ");
                return refuse(format!("--effect: no effect '{name}'; there are: {known}"));
            };
            if effects.contains(&effect) {
                return refuse(format!("--effect: {name} is there twice"));
            }
            effects.push(effect);
        }
        Ok(effects)
    }

    fn request(&self) -> Result<FramesRequest, CliError> {
        if self.work.says_how_long() {
            return refuse("--samples, --ratio-precision, --time-limit: a round is a frame; give --frames");
        }
        if let Some(cut) = self.cut.filter(|cut| *cut >= self.frames) {
            return refuse(format!("--cut {cut}: the last frame is {}", self.frames.saturating_sub(1)));
        }
        if self.fixed_rays && self.moves != Moves::Camera {
            return refuse("--fixed-rays: the scene must stand still; take --move camera");
        }
        let Self { frames, fps, moves, update, paths, cut, fixed_rays, .. } = *self;
        let effects = self.effects()?;
        let spp = if effects.is_empty() { 1 } else { self.spp };
        Ok(FramesRequest { effects, frames, fps, spp, moves, update, paths, cut, fixed_rays })
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
    let page = (report::FRAMES_PAGE, None);
    let record = work.study(json!(request), page, |context| frames::execute(&work.plan, &request, context))?;
    all_measured(&work.plan, &record)?;
    record.frames.as_ref().and_then(FramesRecord::fault).map_or(Ok(()), fail)
}

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

pub(super) fn rule(text: &str) -> Result<Rule, String> {
    let found = Rule::ALL.into_iter().find(|rule| rule.name() == text);
    found.ok_or_else(|| Rule::ALL.map(Rule::name).join(" or "))
}

pub(super) fn attack(arguments: &AttackArguments, progress: &Progress) -> Result<(), CliError> {
    let AttackArguments { scene, tracer, rays, rule, trials, budget, brief, work: of_work } = arguments;
    if of_work.says_how_long() || of_work.trace_to != TraceTo::Hit {
        return refuse("--samples, --ratio-precision, --time-limit, --trace-to: attack takes no times and judges hits");
    }
    let selection = || Selection::of(scene, names::tracers(tracer, &of_work.common.settings), rays);
    let mut work = Work::prepare(of_work, selection, "attack", progress)?;
    work.plan.preset.ray_image = of_work.size.unwrap_or(TRIAL_IMAGE);
    let further = json!({ "rule": rule, "trials": trials, "brief": brief });
    let budget = budget.map(Duration::from_secs_f64);
    let options = AttackOptions { rule: *rule, trials: *trials, budget, is_brief: *brief };
    let page = (report::ATTACK_PAGE, None);
    let record = work.study(further, page, |context| attack::execute(&work.plan, &options, context))?;
    all_measured(&work.plan, &record)
}

#[derive(Args)]
pub(super) struct ExplainArguments {
    /// Scenes: names from `list scenes`, or paths to .gltf or .glb files; several with commas. `all`: every listed one.
    #[arg(long, default_value = "all")]
    scene: OsString,
    /// The tracer, NAME or NAME:PRESET: one whose weaknesses can be taken away.
    #[arg(long, default_value = registry::first(explainable).map(Registration::name))]
    tracer: String,
    /// Ray sets: names from `list rays` with commas, file:DIR for a folder of rays, or all.
    #[arg(long, default_value = "all")]
    rays: String,
    #[command(flatten)]
    work: WorkArguments,
}

fn explainable(tracer: &Registration) -> bool {
    !tracer.remedies.is_empty()
}

pub(super) fn explain(arguments: &ExplainArguments, progress: &Progress) -> Result<(), CliError> {
    let ExplainArguments { scene, tracer, rays, work } = arguments;
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
    let page = (report::EXPLAIN_PAGE, Some("## By scene"));
    let record = work.study(Value::Null, page, |context| explain::execute(plan, request, remedies, context))?;
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
    names::tracers_only(&arguments.settings)?;
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
    let written = bench.out.path().join(report::STABILITY_TABLE);
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
        let plan = line.pareto.selection().and_then(|selection| line.pareto.work.plan(selection, || false));
        let pareto = Pareto::new(&plan.map_err(|error| error.to_string())?, &extent);
        Ok((extent, pareto.map_err(|error| error.to_string())?.size()))
    }

    /// Proves that every tracer is there where none is named, that no tracer has more points than are asked for, and that what makes no
    /// sense is refused with what does.
    #[test]
    fn arguments_make_fronts() {
        let (extent, all) = parse(&[]).unwrap();
        assert_eq!(extent, Extent::default());
        let (_, few) = parse(&["--points", "1"]).unwrap();
        assert_eq!(few, TRACERS.len());
        assert!(few < all && all <= few * DEFAULT_POINTS);
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
