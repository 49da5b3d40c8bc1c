//! `rays` and `judge`.

use std::ffi::OsString;
use std::path::PathBuf;

use clap::Args;
use serde_json::json;
use tracebench_api::{Geometry, Query, TracerError};
use tracebench_scenes::Mesh;

use super::arguments::{CommonArguments, Selection, ray_image};
use super::output::{print, print_end};
use super::work::{Bench, OutputArguments, fresh_folder, say_skipped};
use super::{CliError, fail, fail_for, names, refuse};
use crate::exchange::{self, ExchangeError, Manifest, answers};
use crate::files::OutputFolder;
use crate::hash::sha256_of;
use crate::judge::WRONG_RAYS_PER_CAUSE;
use crate::measure::{self, PreparedWorkload, records};
use crate::plan::{Plan, RunPreset, SceneSource};
use crate::progress::Progress;
use crate::registry::{Device, TRACERS};
use crate::report as reports;
use crate::results::Record;
use crate::studies::judge as study;
use crate::truth::{Cache, Truth};

#[derive(Args)]
pub(super) struct RaysArguments {
    /// Scene: a name from `list scenes`, or a path to a .gltf or .glb file, which keeps its owner's licence in what is written.
    #[arg(long)]
    scene: OsString,
    /// Ray sets: names from `list rays` with commas, or all.
    #[arg(long)]
    rays: String,
    /// Image from whose pixels rays start.
    #[arg(long, value_name = "WxH", value_parser = ray_image, default_value = "256x128")]
    size: [u32; 2],
    /// Seed of the ray sets.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    #[command(flatten)]
    common: CommonArguments,
    /// Folder: the scene, and a folder a set of rays. A new one below tracebench-out/ if not given.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

#[derive(Args)]
pub(super) struct JudgeArguments {
    /// Folder of a set of rays, with a manifest.json.
    #[arg(value_name = "DIR")]
    rays: PathBuf,
    /// Folder of the answers to them.
    answers: PathBuf,
    /// What who answered is called.
    #[arg(long, default_value = "external")]
    name: String,
    /// End with 1 if the share of right answers by a rule (hit_miss, tight, footprint; of any-hit rays balanced) is less. May be repeated.
    #[arg(long, value_name = "RULE=SHARE", value_parser = least)]
    fail_under: Vec<(String, f64)>,
    /// Print the wrong rays that are kept, each with its class and cause.
    #[arg(long)]
    explain: bool,
    /// How many wrong rays of each cause are kept, evenly spaced among all of that cause.
    #[arg(long, value_name = "N", default_value_t = WRONG_RAYS_PER_CAUSE)]
    wrong_rays: usize,
    /// Seed of the choice of the 1,000 truths that are computed anew.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Folder for the record; a new one below tracebench-out/ if not given.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

const RULES: [&str; 4] = ["hit_miss", "tight", "footprint", "balanced"];

fn least(text: &str) -> Result<(String, f64), String> {
    let parts = text.split_once('=').and_then(|(rule, share)| Some((rule.to_owned(), share.parse().ok()?)));
    let sound = parts.filter(|(rule, share)| RULES.contains(&rule.as_str()) && (0.0..=1.0).contains(share));
    sound.ok_or_else(|| {
        format!("RULE=SHARE with a rule of {} and a share from 0 to 1, like tight=0.999", RULES.join(", "))
    })
}

/// Rays and truth are made on the host.
fn no_device() -> Device {
    Err(TracerError::Unavailable("rays, truth and judgements are made on the host".to_owned()))
}

pub(super) fn rays(arguments: &RaysArguments, progress: &Progress) -> Result<(), CliError> {
    let RaysArguments { scene, rays, size, seed, common, out } = arguments;
    let sets = names::ray_sets(rays)?;
    if sets.iter().any(|set| set.saved().is_some()) {
        return refuse("--rays: sets that were read are files already; copy their folders");
    }
    let preset = RunPreset { ray_image: *size, ..RunPreset::for_adapter(false) };
    let selection = Selection { scenes: vec![names::scene(scene)?], ray_sets: sets, ..Selection::default() };
    let plan = Plan { seed: *seed, ..common.plan_of(selection, preset)? };
    let folder = out.as_deref().map_or_else(fresh_folder, OutputFolder::open)?;
    let written = write(&plan, &folder, progress).inspect_err(|_| folder.abandon())?;
    print(&format!("{written}{}\n", folder.path().display()))
}

/// Writes the sets of a plan with their scene, and says which.
fn write(plan: &Plan, folder: &OutputFolder, progress: &Progress) -> Result<String, CliError> {
    let of_scene = [exchange::SCENE_FILE, "positions.npy", "triangles.npy"];
    folder.check_all(|name| of_scene.contains(&name) || plan.ray_sets.iter().any(|set| set.name == name))?;
    let scene = measure::load(plan, progress)?.pop().ok_or_else(|| CliError::Other("there is no scene".to_owned()))?;
    // Before the truth is told, which takes long.
    let name = scene.name.clone();
    exchange::write_scene(folder, &scene.mesh, &name)?;
    let PreparedWorkload { scene, viewpoint, session, .. } =
        measure::prepare(plan, scene, &no_device(), &Cache::of_user(), progress)?;
    let [width, _] = plan.preset.ray_image;
    let bar = progress.bar("write rays", session.rays.len() as u64);
    let mut text = String::new();
    for set in &session.rays {
        let known = (set.buffer.host.as_slice(), set.answers.as_slice());
        let viewpoint = set.eye.map(|_| viewpoint.clone());
        let mut manifest = Manifest::new(set.set.name, set.set.query, known, scene.clone(), viewpoint, plan.seed);
        manifest.ray_parameters = records::json_values(&plan.ray_parameters);
        let pixels: Vec<[u32; 2]> = set.pixels.iter().map(|pixel| [pixel % width, pixel / width]).collect();
        exchange::write(folder, set.set.name, &manifest, known, &pixels)?;
        text += &format!("{}: {} rays\n", set.set.name, manifest.count);
        bar.inc(1);
    }
    bar.finish_and_clear();
    say_skipped(&session.skipped, progress);
    if session.rays.is_empty() {
        let reasons: Vec<&str> = session.skipped.iter().map(|skipped| skipped.reason.as_str()).collect();
        return fail(format!("no rays were made: {}", reasons.join("; ")));
    }
    if matches!(plan.scenes[..], [SceneSource::File { .. }]) {
        text += "the scene keeps its owner's licence: pass it on only as that allows\n";
    }
    Ok(text)
}

pub(super) fn judge(arguments: &JudgeArguments, progress: &Progress) -> Result<(), CliError> {
    let JudgeArguments { rays, name, wrong_rays, .. } = arguments;
    let taken = TRACERS.iter().map(|tracer| tracer.name()).chain(crate::results::CONTROL_NAMES);
    if !exchange::is_name(name) || taken.into_iter().any(|taken| taken == name) {
        return refuse(format!(
            "--name '{name}': a name of 1 to 64 letters, digits and -_. +:=@ that no tracer of `list tracers` and no control has"
        ));
    }
    let set = exchange::read(rays)?;
    let told = answers::read(&arguments.answers, &set)?;
    progress.say(&format!("rays {}: {}", set.manifest.name, set.manifest.count));
    let truths = exchange::read_truth(rays, &set.manifest)?;
    let scene = exchange::scene(rays, &set.manifest)?;
    let Mesh { positions, triangles, triangle_materials, .. } = scene.mesh;
    let truth = Truth::new(&Geometry::with_materials(positions, triangles, triangle_materials, None)?, &scene.sha256);
    progress.say(&format!("computing {} truths anew", exchange::TRUTHS_CHECKED));
    exchange::check_truth(rays, &truth, &set, &truths, arguments.seed)?;
    let hits_sha256 = sha256_of(&told.hits);
    let words = json!({ "rays": set.manifest, "answers": hits_sha256, "name": name, "wrong_rays": wrong_rays });
    let output = OutputArguments { out: arguments.out.clone(), resume: false, shard: None, launch: None };
    let bench = Bench::open(no_device(), &output, "judge", &mut [], progress)?;
    let judged = (set, truths, truth);
    let record = bench.measure(&[], words, |context| study::execute(judged, &told, name, *wrong_rays, context))?;
    let explained = bench.out.path().join("wrong_rays.csv");
    let table = match arguments.explain {
        true => {
            let all = std::fs::read_to_string(&explained).map_err(|error| ExchangeError::Read(explained, error))?;
            // The header, and what is not of controls.
            let lines = all.lines().enumerate().filter(|(place, line)| *place == 0 || line.starts_with("tracer,"));
            lines.map(|(_, line)| format!("{line}\n")).collect()
        }
        false => reports::run_table(&record),
    };
    print_end(&table, &bench.out.path().join("summary.md"))?;
    check_least(&record, &arguments.fail_under)
}

/// Whether as many answers are right as is asked for.
fn check_least(record: &Record, least: &[(String, f64)]) -> Result<(), CliError> {
    let traces = record.rows.iter().flat_map(|row| &row.traces);
    let shares = traces.flat_map(|trace| {
        let rules = if trace.query == Query::Any { &RULES[3..] } else { &RULES[..3] };
        rules.iter().zip(trace.judgement.accuracies(0))
    });
    let shares: Vec<_> = shares.filter_map(|(rule, accuracy)| Some((*rule, accuracy.share?))).collect();
    let failed = least.iter().filter_map(|(rule, least)| match shares.iter().find(|(known, _)| known == rule) {
        Some((_, share)) if share >= least => None,
        Some((_, share)) => Some(format!("{rule} is {share}, under {least}")),
        None => Some(format!("{rule} is not judged of these rays")),
    });
    let failed: Vec<String> = failed.collect();
    fail_for(&failed, "; ", |failed| format!("--fail-under: {failed}"))
}
