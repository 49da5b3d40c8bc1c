//! Ray sets x tracers on `room`.
//!
//! First the harness measures all contenders interleaved, judges them and writes run.json, tables and charts below
//! target/. Then criterion samples the same work through the harness's clock, for its own statistics and its comparison
//! with the last time. `TRACEBENCH_PRESET` chooses the run preset.

use std::hint::black_box;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use criterion::{BenchmarkId, Criterion, Throughput};
use tracebench_api::{AdapterChoice, Gpu, Preset, Timing};
use tracebench_harness::plan::{Plan, RunPreset, SceneSource, TracerRequest, ViewRequest};
use tracebench_harness::progress::Progress;
use tracebench_harness::rays::{RAY_SETS, default_parameters};
use tracebench_harness::registry::{Device, TRACERS};
use tracebench_harness::session::{Contender, Session};
use tracebench_harness::truth::Cache;
use tracebench_harness::{report, runner};

type Failure = Box<dyn std::error::Error>;

fn main() -> Result<(), Failure> {
    // Test runners start benches without this flag: they must not measure or write.
    if !std::env::args().any(|argument| argument == "--bench") {
        println!("not measuring: run by `cargo bench`");
        return Ok(());
    }
    let mut criterion = Criterion::default()
        .sample_size(10)
        .warm_up_time(Duration::from_millis(300))
        .measurement_time(Duration::from_secs(1))
        .configure_from_args();
    let choice = AdapterChoice::from_environment(None)?;
    let device = Gpu::open(&choice).map(Arc::new);
    if let Err(error) = &device {
        // Named in the environment, it is wanted.
        if choice.wanted.is_some() {
            return Err(error.clone().into());
        }
        eprintln!("{error}");
    }
    let plan = plan(device.as_deref().ok())?;
    if !std::env::args().any(|argument| argument == "--list") {
        measure(&plan, &device)?;
    }
    sample(&plan, &device, &mut criterion)?;
    criterion.final_summary();
    Ok(())
}

fn plan(gpu: Option<&Gpu>) -> Result<Plan, Failure> {
    let preset = match std::env::var("TRACEBENCH_PRESET") {
        Ok(name) => RunPreset::named(&name).ok_or_else(|| format!("TRACEBENCH_PRESET: there is no preset '{name}'"))?,
        Err(_) => RunPreset::for_adapter(gpu.is_some_and(|gpu| !gpu.is_software())),
    };
    Ok(Plan {
        scenes: vec![SceneSource::Catalogue("room".to_owned())],
        tracers: TRACERS.iter().map(|each| TracerRequest::of(each, Preset::Published)).collect(),
        ray_sets: RAY_SETS.to_vec(),
        ray_parameters: default_parameters(),
        preset,
        view: ViewRequest::Default,
        time_s: 0.0,
        seed: 1,
        table: None,
    })
}

/// The harness's own measurement, interleaved and judged.
fn measure(plan: &Plan, device: &Device) -> Result<(), Failure> {
    let folder = folder();
    let run = runner::execute(plan, device, &Cache::of_user(), &Progress::new(false))?;
    report::write_run(&run, &folder)?;
    for skipped in &run.skipped {
        println!("skipped {}: {}", skipped.tracer.as_deref().unwrap_or("all tracers"), skipped.reason);
    }
    for line in run.headlines() {
        println!("{line}");
    }
    println!("run.json, summary.md, tables and charts: {}", folder.display());
    Ok(())
}

/// Below the target folder, whose `tmp` cargo names.
fn folder() -> PathBuf {
    let temporary = Path::new(env!("CARGO_TARGET_TMPDIR"));
    temporary.parent().unwrap_or(temporary).join("tracebench").join("ray_sets")
}

/// Criterion's statistics over the same work, by the same clock.
fn sample(plan: &Plan, device: &Device, criterion: &mut Criterion) -> Result<(), Failure> {
    let quiet = Progress::new(true);
    let scene = runner::load_scene(&plan.scenes[0], plan.preset.scene_scale)?;
    let loaded = runner::prepare(plan, scene, device, &Cache::of_user(), &quiet)?;
    let session = &loaded.session;
    let mut contenders = Vec::new();
    for request in &plan.tracers {
        let description = (request.registration.describe)();
        let created =
            Contender::create(description, request.parameters.clone(), || request.registration.create(device));
        // What this machine cannot run has been named as skipped by the measurement.
        let Ok(mut contender) = created else { continue };
        session.sample_build(&mut contender)?;
        contenders.push(contender);
    }
    // Criterion compares with the last time by name: another preset is other work.
    let preset = plan.preset.name;
    sample_builds(session, preset, &mut contenders, criterion);
    sample_traces(session, preset, &contenders, criterion)
}

fn sample_builds(session: &Session, preset: &str, contenders: &mut [Contender], criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group(format!("{preset} build"));
    for contender in contenders {
        group.bench_function(contender.description.name, |bencher| {
            bencher.iter_custom(|iterations| {
                (0..iterations).map(|_| duration(session.sample_build(contender).expect("it was built before"))).sum()
            });
        });
    }
    group.finish();
}

fn sample_traces(
    session: &Session,
    preset: &str,
    contenders: &[Contender],
    criterion: &mut Criterion,
) -> Result<(), Failure> {
    for rays in &session.rays {
        let mut group = criterion.benchmark_group(format!("{preset} {}", rays.set.name));
        group.throughput(Throughput::Elements(rays.buffer.host.len() as u64));
        for contender in contenders {
            let mut hits = session.hit_buffer(contender, rays)?;
            group.bench_function(BenchmarkId::from_parameter(contender.description.name), |bencher| {
                bencher.iter_custom(|iterations| {
                    let mut trace = || session.sample_trace(contender, rays, &mut hits).expect("it was traced before");
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
