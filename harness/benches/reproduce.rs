//! What matters most, within six minutes, by `tracebench reproduce`; then criterion samples builds and diffuse rays in `room` through the
//! harness's clock, for its own statistics and its comparison with the last time.
//!
//! `TRACEBENCH_PRESET` chooses the run preset. `smoke` shows within two minutes that all works; `paper` takes every table whole, and goes
//! on where it was broken off. Words behind `--` filter criterion's part.

use std::error::Error;
use std::hint::black_box;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::time::Duration;

use criterion::{BenchmarkId, Criterion, Throughput};
use tracebench_api::{AdapterChoice, Gpu, Preset, Timing, TraceTo, TracerError};
use tracebench_harness::files::OutputFolder;
use tracebench_harness::judge::WRONG_RAYS_PER_CAUSE;
use tracebench_harness::measure::session::Session;
use tracebench_harness::measure::{self, TracerCache, TracerConfig};
use tracebench_harness::plan::{Plan, RunPreset, SceneSource, TracerRequest, ViewRequest};
use tracebench_harness::progress::Progress;
use tracebench_harness::rays::{RAY_SETS, default_parameters};
use tracebench_harness::registry::{Device, TRACERS};
use tracebench_harness::truth::Cache;

fn main() -> Result<(), Box<dyn Error>> {
    // Test runners start benches without this flag: they must not measure or write.
    if !std::env::args().any(|argument| argument == "--bench") {
        println!("not measuring: run by `cargo bench`");
        return Ok(());
    }
    let named = std::env::var("TRACEBENCH_PRESET").ok().filter(|name| !name.is_empty());
    let preset = named
        .as_deref()
        .map(|name| RunPreset::named(name).ok_or_else(|| format!("TRACEBENCH_PRESET: there is no preset '{name}'")));
    let preset = preset.transpose()?;
    let mut page = None;
    if !std::env::args().any(|argument| argument == "--list") {
        page = Some(reproduce(named.as_deref())?);
    }
    criterion_samples(preset)?;
    if let Some(page) = page {
        println!("\nopen {}", page.display());
    }
    Ok(())
}

/// Measures by the program, and tells where its page stands.
fn reproduce(preset: Option<&str>) -> Result<PathBuf, Box<dyn Error>> {
    let budget = match preset {
        Some("smoke") => "90s",
        Some("paper") => "whole",
        _ => "330s",
    };
    let out = folder();
    let mut command = Command::new(env!("CARGO_BIN_EXE_tracebench"));
    command.args(["reproduce", "--budget", budget, "--out"]).arg(&out);
    command.args(preset.iter().flat_map(|preset| ["--preset", preset]));
    // What is measured whole is worth being gone on with; else every bench is a new one.
    if budget == "whole" && out.join("reproduce.json").is_file() {
        command.arg("--resume");
    } else if out.exists() {
        OutputFolder::remove_all(&out)?;
    }
    // Ends with this process, however that ends.
    let mut child = command.arg("--until-stdin-ends").stdin(Stdio::piped()).spawn()?;
    let held = child.stdin.take();
    let status = child.wait()?;
    drop(held);
    if !status.success() {
        return Err("`tracebench reproduce` did not end well; its message stands above".into());
    }
    // Without time for a single step there is the list alone.
    let pages = ["report.html", "reproduce.md"].map(|name| out.join(name));
    pages.into_iter().find(|page| page.is_file()).ok_or_else(|| "`tracebench reproduce` left no page".into())
}

/// Below the target folder, whose `tmp` cargo names.
fn folder() -> PathBuf {
    let temporary = Path::new(env!("CARGO_TARGET_TMPDIR"));
    temporary.parent().unwrap_or(temporary).join("tracebench").join("reproduce")
}

/// Criterion's statistics of builds and diffuse rays in `room`.
fn criterion_samples(preset: Option<RunPreset>) -> Result<(), Box<dyn Error>> {
    let choice = AdapterChoice::from_environment(None, None)?;
    let device: Device = Gpu::open(&choice).map(Arc::new);
    if let (Err(error), Some(_)) = (&device, &choice.wanted) {
        return Err(error.clone().into());
    }
    let preset = preset.unwrap_or_else(|| RunPreset::for_adapter(device.as_ref().is_ok_and(|gpu| !gpu.is_software())));
    // Twice as many rows as tracers within a minute; a smoke run only shows that things work.
    let (warm_up_ms, measurement_ms) = if preset.name == "smoke" { (20, 100) } else { (200, 800) };
    let mut criterion = Criterion::default()
        .sample_size(10)
        .warm_up_time(Duration::from_millis(warm_up_ms))
        .measurement_time(Duration::from_millis(measurement_ms))
        .configure_from_args();
    sample(&plan(preset), &device, &mut criterion)?;
    criterion.final_summary();
    Ok(())
}

fn plan(preset: RunPreset) -> Plan {
    Plan {
        scenes: vec![SceneSource::Catalogue("room".to_owned())],
        tracers: TRACERS.iter().map(|each| TracerRequest::of(each, Preset::Published)).collect(),
        ray_sets: RAY_SETS.iter().filter(|set| set.name == "diffuse").copied().collect(),
        ray_parameters: default_parameters(),
        preset,
        view: ViewRequest::Default,
        time_s: 0.0,
        seed: 1,
        trace_to: TraceTo::Hit,
        builds_timed: true,
        wrong_rays_per_cause: WRONG_RAYS_PER_CAUSE,
        table: None,
    }
}

fn sample(plan: &Plan, device: &Device, criterion: &mut Criterion) -> Result<(), Box<dyn Error>> {
    let mut tracer_cache = TracerCache::default();
    for scene in measure::load(plan, &Progress::new(true))? {
        // Criterion compares with the last time by name: another preset is other work.
        let title = format!("{} {}", plan.preset.name, scene.name);
        let loaded = measure::prepare(plan, scene, device, &Cache::of_user(), &Progress::new(true))?;
        let session = &loaded.session;
        let mut configs = Vec::new();
        for request in &plan.tracers {
            // What this machine cannot run `reproduce` has named.
            let Ok(mut config) = tracer_cache.config(request, device) else { continue };
            session.sample_build(&mut config)?;
            configs.push((request.name(), config));
        }
        sample_builds(session, &title, &mut configs, criterion);
        sample_traces(session, &title, &configs, criterion)?;
    }
    Ok(())
}

fn sample_builds(session: &Session, title: &str, configs: &mut [(&str, TracerConfig)], criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group(format!("{title} build"));
    group.throughput(Throughput::Elements(session.geometry().triangles.len() as u64));
    for (label, config) in configs {
        group.bench_function(*label, |bencher| {
            bencher.iter_custom(|iterations| {
                let mut build = || session.sample_build(config).expect("it was built before");
                (0..iterations).map(|_| duration(build().whole)).sum()
            });
        });
    }
    group.finish();
}

fn sample_traces(
    session: &Session,
    title: &str,
    configs: &[(&str, TracerConfig)],
    criterion: &mut Criterion,
) -> Result<(), Box<dyn Error>> {
    for rays in &session.rays {
        let mut group = criterion.benchmark_group(format!("{title} {}", rays.set.name));
        group.throughput(Throughput::Elements(rays.buffer.host.len() as u64));
        for (label, config) in configs {
            let mut hits = session.hit_buffer(config, rays)?;
            match session.sample_trace(config, rays, &mut hits, 1) {
                // Rays that it does not serve, `reproduce` has named.
                Err(TracerError::Unsupported(_)) => continue,
                traced => traced?,
            };
            group.bench_function(BenchmarkId::from_parameter(label), |bencher| {
                bencher.iter_custom(|iterations| {
                    let mut trace = || session.sample_trace(config, rays, &mut hits, 1).expect("it was traced before");
                    (0..iterations).map(|_| duration(black_box(trace()))).sum()
                });
            });
        }
        group.finish();
    }
    Ok(())
}

fn duration(timing: Timing) -> Duration {
    let believed = Timing::plausible(std::slice::from_ref(&timing));
    let timing = if believed { timing } else { timing.by_submission() };
    Duration::from_secs_f64(timing.total_ms / 1e3)
}
