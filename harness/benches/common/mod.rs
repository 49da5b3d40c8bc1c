//! What the benches share: the device, the harness's own measurement, and criterion's samples of the same work through the
//! harness's clock, for criterion's own statistics and its comparison with the last time.

use std::hint::black_box;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use criterion::{BenchmarkId, Criterion, Throughput};
use tracebench_api::{AdapterChoice, Gpu, Timing};
use tracebench_harness::measure::session::Session;
use tracebench_harness::measure::{Contender, Context, Crew, Journal};
use tracebench_harness::plan::{Plan, RunPreset, TracerRequest};
use tracebench_harness::progress::Progress;
use tracebench_harness::registry::Device;
use tracebench_harness::results::{MeansRecord, Sampling};
use tracebench_harness::truth::Cache;
use tracebench_harness::{means, measure, report, tables};

/// Rounds of the harness's own measurement, at most: too few for verdicts, which are no bench's.
const MOST_ROUNDS: u32 = 9;

pub type Failure = Box<dyn std::error::Error>;

/// Runs a bench: plans, given the run preset, one a resolution, by the harness, which judges them and writes its files below
/// target/tracebench/`name`/, then by criterion. `TRACEBENCH_PRESET` chooses the run preset.
pub fn run(name: &str, plans: impl Fn(RunPreset) -> Result<Vec<Plan>, Failure>) -> Result<(), Failure> {
    // Test runners start benches without this flag: they must not measure or write.
    if !std::env::args().any(|argument| argument == "--bench") {
        println!("not measuring: run by `cargo bench`");
        return Ok(());
    }
    let device = device()?;
    let preset = match std::env::var("TRACEBENCH_PRESET") {
        Ok(name) => RunPreset::named(&name).ok_or_else(|| format!("TRACEBENCH_PRESET: there is no preset '{name}'"))?,
        Err(_) => RunPreset::for_adapter(device.as_ref().is_ok_and(|gpu| !gpu.is_software())),
    };
    // Criterion samples, too: what runs at every push does not wait for narrow intervals.
    let sampling = Sampling::rounds(preset.sampling.least_rounds.min(MOST_ROUNDS));
    let mut plans = plans(RunPreset { sampling, ..preset })?;
    let means = means::probe(&device)?;
    for request in plans.iter_mut().flat_map(|plan| &mut plan.tracers) {
        means.iter().for_each(|record| request.take_means(&record.means));
    }
    // A smoke run only shows that things work.
    let (warm_up_ms, measurement_ms) = if preset.name == "smoke" { (20, 100) } else { (200, 800) };
    let mut criterion = Criterion::default()
        .sample_size(10)
        .warm_up_time(Duration::from_millis(warm_up_ms))
        .measurement_time(Duration::from_millis(measurement_ms))
        .configure_from_args();
    if !std::env::args().any(|argument| argument == "--list") {
        measure(name, &plans, &device, means)?;
    }
    for plan in &plans {
        let resolution = if plans.len() > 1 { format!(", faces of {}", plan.preset.face) } else { String::new() };
        sample(&format!("{name}{resolution}"), plan, &device, &mut criterion)?;
    }
    criterion.final_summary();
    Ok(())
}

fn device() -> Result<Device, Failure> {
    let choice = AdapterChoice::from_environment(None, None)?;
    let device = Gpu::open(&choice).map(Arc::new);
    if let Err(error) = &device {
        // Named in the environment, it is wanted.
        if choice.wanted.is_some() {
            return Err(error.clone().into());
        }
        eprintln!("{error}");
    }
    Ok(device)
}

/// The harness's own measurement, interleaved and judged.
fn measure(name: &str, plans: &[Plan], device: &Device, means: Option<MeansRecord>) -> Result<(), Failure> {
    let folder = folder(name);
    let (cache, progress, journal) = (Cache::of_user(), Progress::new(false), Journal::none());
    let run = measure::execute_all(plans, &Context::new(device, &cache, &progress, &journal).with_means(means))?;
    let written = report::write_run(&run, &folder, tables::of_run)?;
    for skipped in &run.skipped {
        println!("skipped {}: {}", skipped.tracer.as_deref().unwrap_or("all tracers"), skipped.reason);
    }
    print!("{}", report::run_table(&run));
    println!("{} files, run.json and summary.md among them: {}", written.len(), folder.display());
    Ok(())
}

/// Below the target folder, whose `tmp` cargo names.
fn folder(name: &str) -> PathBuf {
    let temporary = Path::new(env!("CARGO_TARGET_TMPDIR"));
    temporary.parent().unwrap_or(temporary).join("tracebench").join(name)
}

/// Criterion's statistics over the same work, by the same clock.
fn sample(name: &str, plan: &Plan, device: &Device, criterion: &mut Criterion) -> Result<(), Failure> {
    let mut crew = Crew::default();
    for scene in measure::load(plan, &Progress::new(true))? {
        // Criterion compares with the last time by name: another preset is other work.
        let title = format!("{} {name} {}", plan.preset.name, scene.name);
        let loaded = measure::prepare(plan, scene, device, &Cache::of_user(), &Progress::new(true))?;
        let session = &loaded.session;
        let mut contenders = Vec::new();
        for request in &plan.tracers {
            // What this machine cannot run has been named as skipped by the measurement.
            let Ok(mut contender) = crew.contender(request, device) else { continue };
            session.sample_build(&mut contender)?;
            contenders.push((label(request), contender));
        }
        sample_builds(session, &title, &mut contenders, criterion);
        sample_traces(session, &title, &contenders, criterion)?;
    }
    Ok(())
}

/// The tracer with what is changed of it.
fn label(request: &TracerRequest) -> String {
    let changed = request.parameters.iter().filter(|(name, _)| request.changed.iter().any(|changed| changed == name));
    changed.fold(request.name().to_owned(), |label, (name, value)| format!("{label} {name}={value}"))
}

fn sample_builds(session: &Session, title: &str, contenders: &mut [(String, Contender)], criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group(format!("{title} build"));
    group.throughput(Throughput::Elements(session.geometry().triangles.len() as u64));
    for (label, contender) in contenders {
        group.bench_function(label.as_str(), |bencher| {
            bencher.iter_custom(|iterations| {
                (0..iterations).map(|_| duration(session.sample_build(contender).expect("it was built before"))).sum()
            });
        });
    }
    group.finish();
}

fn sample_traces(
    session: &Session,
    title: &str,
    contenders: &[(String, Contender)],
    criterion: &mut Criterion,
) -> Result<(), Failure> {
    for rays in &session.rays {
        let mut group = criterion.benchmark_group(format!("{title} {}", rays.set.name));
        group.throughput(Throughput::Elements(rays.buffer.host.len() as u64));
        for (label, contender) in contenders {
            let mut hits = session.hit_buffer(contender, rays)?;
            group.bench_function(BenchmarkId::from_parameter(label), |bencher| {
                bencher.iter_custom(|iterations| {
                    let mut trace =
                        || session.sample_trace(contender, rays, &mut hits, 1).expect("it was traced before");
                    (0..iterations).map(|_| duration(black_box(trace()))).sum()
                });
            });
        }
        group.finish();
    }
    Ok(())
}

fn duration(timing: Timing) -> Duration {
    let believed = Timing::believable(std::slice::from_ref(&timing));
    let timing = if believed { timing } else { timing.by_submission() };
    Duration::from_secs_f64(timing.total_ms / 1e3)
}
