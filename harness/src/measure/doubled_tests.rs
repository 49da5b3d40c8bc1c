//! From where the range of the control of doubled work comes: true doublings, measured, and the faults that it must catch.
//!
//! doubled.csv was measured by
//!
//! ```text
//! DOUBLED=$PWD/harness/src/measure/doubled.csv cargo test --release -p tracebench-harness --lib doublings_are_measured -- --ignored
//! --nocapture
//! ```
//!
//! on a machine that did nothing else: a line a round has the work, the clock and the times of the work done once and twice, in turn,
//! milliseconds. Work takes as little as is judged, where what every sample costs once weighs most, and finds caches as an interleaved set
//! leaves them.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::time::Instant;

use tracebench_api::{ClockKind, Gpu, PhaseClock, Preset, Timing, TraceTo, TracerError};
use tracebench_kit::FixedWork;

use super::doubled_work::{MIN_JUDGED_MS, takes, times_as_long};
use super::kernels::{MIN_MS, on_host};
use super::run::placed;
use super::*;
use crate::plan::{Plan, RunPreset, SceneSource, TracerRequest, ViewRequest};
use crate::progress::Progress;
use crate::rays::sampling::Stream;
use crate::rays::{RAY_SETS, default_parameters};
use crate::registry;
use crate::results::{ClockTicks, MIN_ROUNDS};
use crate::statistics::{median, percentile};
use crate::truth::Cache;

/// Rounds of each kind of work.
const ROUNDS: usize = 240;
/// Work of a queue that nobody waits for: a fault, measured.
const NOT_AWAITED: &str = "kernel, not awaited";
/// Bytes that are touched before every sample, as other configurations of an interleaved set do: what a sample finds of its own in caches
/// is gone.
const OTHERS: usize = 64 << 20;
/// The share of either end that the range leaves out: what is right fails twice in a row, which voids times, in one interleaved set of a
/// thousand.
const TAIL_PERCENT: f64 = 1.58;
/// Ends of the range are multiples of this.
const STEP: f64 = 0.05;

/// Work done once and twice by a clock, by round.
struct Doubled {
    work: String,
    clock: ClockKind,
    once: Vec<f64>,
    doubled_work: Vec<f64>,
}

fn clock_name(clock: ClockKind) -> String {
    serde_json::to_value(clock).unwrap().as_str().unwrap().to_owned()
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

fn measured(table: &[u8]) -> Vec<Doubled> {
    let mut all: Vec<Doubled> = Vec::new();
    for row in csv::Reader::from_reader(table).deserialize::<(String, ClockKind, f64, f64)>() {
        let (work, clock, once, doubled_work) = row.unwrap();
        if all.last().is_none_or(|last| (&last.work, last.clock) != (&work, clock)) {
            all.push(Doubled { work, clock, once: Vec::new(), doubled_work: Vec::new() });
        }
        let last = all.last_mut().unwrap();
        last.once.push(once);
        last.doubled_work.push(doubled_work);
    }
    all
}

impl Doubled {
    /// The least, middle and greatest of what the control would find of as many rounds as it needs at least, drawn by a fixed lot from
    /// those that were measured.
    fn found(&self, fault: impl Fn(f64, f64) -> (f64, f64)) -> [f64; 3] {
        let rounds: Vec<(f64, f64)> =
            self.once.iter().zip(&self.doubled_work).map(|(once, doubled_work)| fault(*once, *doubled_work)).collect();
        let mut stream = Stream::new(1, 0xd0b, 0);
        let mut draw = || rounds[(stream.unit() * rounds.len() as f64) as usize];
        let mut samples = || {
            let (once, doubled_work): (Vec<f64>, Vec<f64>) = (0..MIN_ROUNDS).map(|_| draw()).unzip();
            times_as_long(&once, &doubled_work).unwrap()
        };
        let found: Vec<f64> = (0..10_000).map(|_| samples()).collect();
        [TAIL_PERCENT, 50.0, 100.0 - TAIL_PERCENT].map(|percent| percentile(&found, percent).unwrap())
    }

    fn truly(&self) -> [f64; 3] {
        self.found(|once, doubled_work| (once, doubled_work))
    }

    /// What clocks with a fault would find, by fault.
    fn faults(&self) -> Vec<(&'static str, [f64; 3])> {
        let constant = median(&self.once);
        vec![
            (
                "adds a constant as large as the work",
                self.found(|once, doubled_work| (once + constant, doubled_work + constant)),
            ),
            ("counts half of the second", self.found(|once, doubled_work| (once, 0.75 * doubled_work))),
            ("counts the first alone", self.found(|once, doubled_work| (once, 0.5 * doubled_work))),
            ("counts the second twice", self.found(|once, doubled_work| (once, 1.5 * doubled_work))),
        ]
    }
}

/// The range of a clock by the rule: from the least of all true doublings to the greatest, each rounded away from two.
fn range(all: &[Doubled], clock: ClockKind) -> [f64; 2] {
    let of_clock = all.iter().filter(|each| each.clock == clock && each.work != NOT_AWAITED);
    let found: Vec<[f64; 3]> = of_clock.map(Doubled::truly).collect();
    let least = found.iter().map(|[least, ..]| *least).fold(f64::INFINITY, f64::min);
    let greatest = found.iter().map(|[.., greatest]| *greatest).fold(0.0, f64::max);
    [(least / STEP).floor() * STEP, (greatest / STEP).ceil() * STEP]
}

/// What was measured, as the table of docs/clock.md.
fn table(all: &[Doubled]) -> String {
    let mut text =
        "| work | clock | once, ms | twice over once | faults: least to greatest |\n| --- | --- | --- | --- | --- |\n"
            .to_owned();
    let words = |[least, middle, greatest]: [f64; 3]| format!("{middle:.2} ({least:.2} to {greatest:.2})");
    for each in all {
        let faults: Vec<String> = match each.work.as_str() {
            NOT_AWAITED => Vec::new(),
            _ => each.faults().iter().map(|(_, [least, _, greatest])| format!("{least:.2} to {greatest:.2}")).collect(),
        };
        let (work, clock, once) = (&each.work, clock_name(each.clock), median(&each.once));
        let _ = writeln!(text, "| {work} | `{clock}` | {once:.1} | {} | {} |", words(each.truly()), faults.join("; "));
    }
    text
}

/// Proves that the range of every clock follows by the rule from what was measured, that RULES.md and docs/clock.md say it, and that
/// every fault lies outside of it for every kind of work: clocks that add a constant, count a part or wait for nothing; one whose ticks are
/// 10 ms is ruled out by its ticks.
#[test]
fn the_range_follows_from_true_doublings() {
    let all = measured(&std::fs::read(root().join("harness/src/measure/doubled.csv")).unwrap());
    let rules = std::fs::read_to_string(root().join("RULES.md")).unwrap();
    let page = std::fs::read_to_string(root().join("docs/clock.md")).unwrap();
    assert!(page.contains(&table(&all)), "docs/clock.md does not have\n{}", table(&all));
    for clock in [ClockKind::Host, ClockKind::DeviceTimestamps, ClockKind::SubmitToDone] {
        let [least, most] = range(&all, clock);
        let [from, to] = takes(clock);
        assert!(
            (least - from).abs() < 1e-9 && (most - to).abs() < 1e-9,
            "{clock:?}: {from} to {to}, by the rule {least:.2} to {most:.2}\n{}",
            table(&all)
        );
        let said = format!("| `{}` | {from:.2} to {to:.2} |", clock_name(clock));
        assert!(rules.contains(&said), "RULES.md does not say {said}");
        let works: Vec<&Doubled> = all.iter().filter(|each| each.clock == clock).collect();
        assert!(works.iter().filter(|each| each.work != NOT_AWAITED).count() >= 3, "three kinds of work");
        for each in works {
            assert!(each.once.len() >= ROUNDS && each.once.len() == each.doubled_work.len());
            let faults = match each.work.as_str() {
                NOT_AWAITED => vec![("does not wait", each.truly())],
                _ => each.faults(),
            };
            for (fault, [low, _, high]) in faults {
                // Where nobody waits no kernel takes long enough, which is an error.
                let is_error = each.work == NOT_AWAITED && median(&each.once) < MIN_MS;
                let caught = high < from || low > to || is_error;
                assert!(caught, "{} by {clock:?} of a clock that {fault}: {low:.2} to {high:.2}", each.work);
            }
            let coarse = ClockTicks { host_ms: Some(10.0), device_ms: Some(10.0) };
            assert!(coarse.is_too_coarse(clock, median(&each.once)), "{}: 20 ticks of 10 ms are 200 ms", each.work);
        }
    }
}

type Sample<'a> = Box<dyn FnMut(usize) -> Result<Timing, TracerError> + 'a>;

/// Measures work done so often and twice as often, in turn.
fn double(work: &str, mut sample: Sample<'_>, text: &mut String) {
    // As little as is judged.
    let single = (0..5).map(|_| sample(1).unwrap().total_ms).fold(f64::INFINITY, f64::min);
    let repeats = (MIN_JUDGED_MS * 1.2 / single).ceil().clamp(1.0, 12.0) as usize;
    let mut others = vec![0_u8; OTHERS];
    let mut rounds: [Vec<Timing>; 2] = Default::default();
    for round in 0..ROUNDS {
        for turn in [round % 2, 1 - round % 2] {
            others.iter_mut().step_by(64).for_each(|byte| *byte = byte.wrapping_add(1));
            rounds[turn].push(sample(repeats * (turn + 1)).unwrap());
        }
    }
    let mut write = |clock: ClockKind, time: &dyn Fn(&Timing) -> Option<f64>| {
        for (once, doubled_work) in rounds[0].iter().zip(&rounds[1]) {
            if let Some((once, doubled_work)) = time(once).zip(time(doubled_work)) {
                let _ = writeln!(text, "\"{work}\",{},{once:.4},{doubled_work:.4}", clock_name(clock));
            }
        }
    };
    let own = rounds[0][0].clock;
    // Timestamps that are not believed time nothing.
    if rounds.iter().all(|samples| Timing::plausible(samples)) {
        write(own, &|timing| Some(timing.total_ms));
    }
    if own == ClockKind::DeviceTimestamps {
        write(ClockKind::SubmitToDone, &|timing| timing.submit_to_done_ms);
    }
}

/// Measures true doublings: a kernel, traces of a hierarchy and builds, on the host and on the device, where builds are a raster pass.
#[test]
#[ignore = "wider set: it measures, and takes a minute of a machine that does nothing else; the range is tested by what it has measured"]
fn doublings_are_measured() {
    let gpu = tracebench_tests::gpu();
    let mut text = "work,clock,once_ms,doubled_work_ms\n".to_owned();
    for name in ["bvh-cpu", "bvh-gpu", "screen-dda"] {
        let request = TracerRequest::of(registry::find(name).unwrap(), Preset::Published);
        let on_device = request.registration.needs_device();
        let plan = Plan {
            scenes: vec![SceneSource::Catalogue("room".to_owned())],
            tracers: vec![request.clone()],
            ray_sets: RAY_SETS[..1].to_vec(),
            ray_parameters: default_parameters(),
            preset: RunPreset { scene_scale: 0.3, ..RunPreset::named("quick").unwrap() },
            view: ViewRequest::Default,
            time_s: 0.0,
            seed: 1,
            trace_to: TraceTo::Hit,
            builds_timed: true,
            wrong_rays_per_cause: crate::judge::WRONG_RAYS_PER_CAUSE,
            table: None,
        };
        let device = Ok(gpu.clone());
        let (cache, quiet, journal) = (Cache::none(), Progress::new(true), Journal::none());
        let context = Context::new(&device, &cache, &quiet, &journal);
        let scene = load(&plan, &quiet).unwrap().remove(0);
        let session = placed(&plan, scene, &context).unwrap().session;
        let tracer = request.registration.create(&device).unwrap();
        let build = |repeats: usize| {
            let mut clock = PhaseClock::new(session.gpu());
            let (geometry, viewpoint) = (session.geometry(), &session.viewpoint);
            let built = (0..repeats).map(|_| tracer.build(geometry, viewpoint, &request.parameters, &mut clock));
            let built = built.collect::<Result<Vec<_>, _>>()?;
            let timing = clock.finish();
            drop(built);
            timing
        };
        double(&format!("builds of {name}"), Box::new(build), &mut text);
        let mut config = TracerConfig::ready(
            request.registration.describe(),
            request.parameters.clone(),
            request.registration.create(&device).unwrap(),
        );
        session.sample_build(&mut config).unwrap();
        let rays = &session.rays[0];
        let mut hits = session.hit_buffer(&config, rays).unwrap();
        let trace = |repeats: usize| session.sample_trace(&config, rays, &mut hits, repeats);
        double(&format!("traces of {name}"), Box::new(trace), &mut text);
        if name == "bvh-gpu" {
            kernels(&gpu, &mut text);
        } else if !on_device {
            let kernel = |repeats: usize| {
                let mut clock = PhaseClock::new(None);
                (0..repeats).for_each(|_| on_host(&mut clock, 1 << 13));
                clock.finish()
            };
            double("kernel on the host", Box::new(kernel), &mut text);
        }
    }
    let all = measured(text.as_bytes());
    println!("{}", table(&all));
    for clock in [ClockKind::Host, ClockKind::DeviceTimestamps, ClockKind::SubmitToDone] {
        println!("{}: {:?} by the rule", clock_name(clock), range(&all, clock));
    }
    assert!(all.iter().all(|each| each.once.len() == ROUNDS && each.once.len() == each.doubled_work.len()));
    if let Ok(out) = std::env::var("DOUBLED") {
        std::fs::write(out, text).unwrap();
    }
}

/// The kernel of the device, awaited and not.
fn kernels(gpu: &Gpu, text: &mut String) {
    let work = FixedWork::new(gpu).unwrap();
    let plan = work.plan(gpu, 1 << 13).unwrap();
    let awaited = |repeats: usize| {
        let mut clock = PhaseClock::new(Some(gpu));
        for _ in 0..repeats {
            clock.device_phase("work", |encoder| work.record(encoder, &plan))?;
        }
        clock.finish()
    };
    double("kernel on the device", Box::new(awaited), text);
    let not_awaited = |repeats: usize| {
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        (0..repeats).for_each(|_| work.record(&mut encoder, &plan));
        let commands = encoder.finish();
        let begin = Instant::now();
        gpu.queue.submit([commands]);
        let total_ms = begin.elapsed().as_secs_f64() * 1e3;
        gpu.wait()?;
        let clock = ClockKind::SubmitToDone;
        Ok(Timing { clock, total_ms, phases: Vec::new(), submit_to_done_ms: Some(total_ms), grown: false })
    };
    double(NOT_AWAITED, Box::new(not_awaited), text);
}
