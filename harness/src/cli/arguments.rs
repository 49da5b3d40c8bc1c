//! The arguments of `table` and those that verbs share, and the plan that they make.

use std::ffi::{OsStr, OsString};
use std::path::PathBuf;

use clap::Args;

use tracebench_api::{DeviceLimits, TraceTo};
use tracebench_scenes::{SCALE_MAX, SCALE_MIN};

use super::work::OutputArguments;
use super::{CliError, names};
use crate::judge::WRONG_RAYS_PER_CAUSE;
use crate::papers;
use crate::plan::{
    LARGEST_EDGE, LARGEST_FACE, Plan, RUN_PRESETS, RunPreset, SAMPLING, SceneSource, TracerRequest, ViewRequest, within,
};
use crate::rays::{BETWEEN_SAMPLES, MAX_RAYS, RaySet, between_samples as image_between_samples};
use crate::results::{Adaptive, SampleSchedule};
use crate::tables::{self, Table, exact};

#[derive(Args)]
pub(super) struct TableArguments {
    /// The table: a name from `list tables`.
    pub name: String,
    /// Scenes: names from `list scenes`, or paths to .gltf or .glb files; several with commas. If not given, all listed ones
    /// (for a paper's table those that stand for the paper's).
    #[arg(long)]
    pub scene: Option<OsString>,
    #[arg(long, help = tables::tracer_help())]
    pub tracer: Option<String>,
    /// Ray sets: names from `list rays` with commas, file:DIR for a folder of rays, or all; the table's own if not given.
    #[arg(long)]
    pub rays: Option<String>,
    /// Few rows of a paper's table, too few to test its claims, in seconds: in room, of an eighth of its triangles, at half the resolution.
    #[arg(long, conflicts_with_all = ["scene", "rays", "only", "tuned", "size", "frame_size", "face_size", "scale"])]
    pub few_rows: bool,
    /// Of a paper's table the rows alone of this tracer that have one of these values, and all of other tracers. May be repeated.
    #[arg(long, value_name = "T.P=V,V")]
    pub only: Vec<String>,
    /// Of a paper's table the rows that say nothing of a parameter which this run tuned (a file of `sweep --choose` or the folder that
    /// holds it): they have the value that is best from another viewpoint of the same scene.
    #[arg(long, value_name = "RUN")]
    pub tuned: Option<PathBuf>,
    /// Measures nothing: tells how long the table would take, by the rows of a run that have the same parameters; a file or the folder
    /// that holds it.
    #[arg(long, value_name = "RUN", conflicts_with_all = ["from", "resume", "shard", "out"])]
    pub estimate: Option<PathBuf>,
    /// Measures nothing: makes the table of what was measured before, a file or the folder that holds it. Claims are judged by any number
    /// of runs of their paper's tables; those that none measures are listed with the table that would.
    #[arg(long, value_name = "RUN", num_args = 1.., conflicts_with_all = [
        "scene", "tracer", "rays", "size", "frame_size", "face_size", "view", "animation_time", "scale", "settings", "adapter", "limits",
        "preset", "samples", "ratio_precision", "time_limit", "seed", "resume", "shard", "only", "tuned", "few_rows", "launch",
    ])]
    pub from: Vec<PathBuf>,
    #[command(flatten)]
    pub work: WorkArguments,
}

/// What `run` and `table` share.
#[derive(Args)]
pub(super) struct WorkArguments {
    /// Image from whose pixels rays start.
    #[arg(long, value_name = "WxH", value_parser = ray_image)]
    pub size: Option<[u32; 2]>,
    /// Resolution of the viewpoint's frame, from which structures take theirs.
    #[arg(long, value_name = "WxH", value_parser = frame)]
    pub frame_size: Option<[u32; 2]>,
    /// Edge of the viewpoint's cube faces, pixels.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=i64::from(LARGEST_FACE)))]
    pub face_size: Option<u32>,
    #[command(flatten)]
    pub common: CommonArguments,
    /// Sets rays, resolutions, samples and scene scale: smoke, quick (default without a GPU) or paper (default on one).
    #[arg(long, value_parser = RUN_PRESETS.map(|preset| preset.name))]
    pub preset: Option<String>,
    /// Counted samples of every time, so many whatever comes of them. With fewer than 12 no verdict rests on times.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=10_000),
          conflicts_with_all = ["ratio_precision", "time_limit"])]
    pub samples: Option<u32>,
    /// Sample in whole rounds, at least 12, until every two tracers' ratio is known within so many percent; 15 if not given, but
    /// with --preset smoke.
    #[arg(long, value_name = "PERCENT", value_parser = within(0.1..=1000.0, "a number of percent from 0.1 to 1000"))]
    pub ratio_precision: Option<f64>,
    /// The longest that an interleaved set (the builds, or one ray set, from one viewpoint) goes on for that, seconds; 20 if not given, but
    /// with
    /// --preset smoke.
    #[arg(long, value_name = "SECONDS", value_parser = within(0.0..=86_400.0, "a number of seconds from 0 to 86400"))]
    pub time_limit: Option<f64>,
    /// Seed of the ray sets.
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// How far traces go: hit (t, triangle and status of every ray) or surface (position, normal and material of what it
    /// hit, too).
    #[arg(long, value_name = "hit|surface", default_value = "hit",
          value_parser = |text: &str| TraceTo::named(text).ok_or("hit or surface"))]
    pub trace_to: TraceTo,
    /// How many wrong rays of each cause a row keeps, evenly spaced among all of that cause.
    #[arg(long, value_name = "N", default_value_t = WRONG_RAYS_PER_CAUSE)]
    pub wrong_rays: usize,
    #[command(flatten)]
    pub output: OutputArguments,
}

/// What a run is about, beside [`WorkArguments`].
#[derive(Default)]
pub(super) struct Selection {
    pub(super) scenes: Vec<SceneSource>,
    pub(super) tracers: Vec<TracerRequest>,
    pub(super) ray_sets: Vec<RaySet>,
    pub(super) table: Option<&'static str>,
    /// Whether rays keep off the samples of frames where no image is given for them: for studies over resolutions.
    pub(super) between_samples: bool,
    /// How many rounds there are, where that is not asked.
    pub(super) rounds: Option<u32>,
}

impl Selection {
    /// What the options of a verb name.
    pub(super) fn of(
        scenes: &OsStr,
        tracers: Result<Vec<TracerRequest>, CliError>,
        ray_sets: &str,
    ) -> Result<Self, CliError> {
        let (scenes, tracers, ray_sets) = (names::scenes(scenes)?, tracers?, names::ray_sets(ray_sets)?);
        Ok(Self { scenes, tracers, ray_sets, ..Self::default() })
    }
}

/// What all verbs that measure share.
#[derive(Args)]
pub(super) struct CommonArguments {
    /// Viewpoint: a name from `list scenes`, or eye and target as ex,ey,ez:tx,ty,tz.
    #[arg(long, value_name = "NAME|POSE", allow_hyphen_values = true)]
    pub view: Option<String>,
    /// Animation time; scenes that do not move are the same at every time.
    #[arg(long, value_name = "SECONDS", default_value_t = 0.0, allow_hyphen_values = true,
          value_parser = within(f64::MIN..=f64::MAX, "a number of seconds"))]
    pub animation_time: f64,
    /// Factor on the triangles of procedural scenes, in place of the run preset's.
    #[arg(long, value_name = "FACTOR",
          value_parser = within(SCALE_MIN..=SCALE_MAX, format!("a number from {SCALE_MIN} to {SCALE_MAX}")))]
    pub scale: Option<f64>,
    /// A parameter on top of the preset: tracer.parameter=value, as in `list tracers`, or rays.parameter=value, as in
    /// `list rays`. May be repeated.
    #[arg(long = "set", value_name = "T.P=V", allow_hyphen_values = true)]
    pub settings: Vec<String>,
    #[command(flatten)]
    pub device: DeviceArguments,
}

/// Which device serves.
#[derive(Args)]
pub(super) struct DeviceArguments {
    /// Adapter: part of its name, or its number in `doctor`.
    #[arg(long, value_name = "NAME", value_parser = clap::builder::NonEmptyStringValueParser::new())]
    pub adapter: Option<String>,
    /// Within which limits the device is opened: those of the adapter (default), or webgpu, the ones that every browser grants,
    /// with no feature beyond WebGPU's core.
    #[arg(long, value_name = "adapter|webgpu",
          value_parser = |text: &str| DeviceLimits::named(text).ok_or_else(|| DeviceLimits::NAMES.join(" or ")))]
    pub limits: Option<DeviceLimits>,
}

fn frame(text: &str) -> Result<[u32; 2], String> {
    let edge = |part: &str| part.parse::<u32>().ok().filter(|edge| (1..=LARGEST_EDGE).contains(edge));
    let edges = text.split_once(['x', 'X']).and_then(|(width, height)| Some([edge(width)?, edge(height)?]));
    edges.ok_or_else(|| format!("WxH with both from 1 to {LARGEST_EDGE}, like 256x128"))
}

pub(super) fn ray_image(text: &str) -> Result<[u32; 2], String> {
    let [width, height] = frame(text)?;
    let rays = u64::from(width) * u64::from(height);
    if rays > MAX_RAYS {
        return Err(format!("{rays} rays, {MAX_RAYS} are the most"));
    }
    Ok([width, height])
}

impl CommonArguments {
    /// The plan of tracers and ray sets in some scenes.
    pub(super) fn plan_of(&self, selection: Selection, preset: RunPreset) -> Result<Plan, CliError> {
        let Selection { scenes, tracers, ray_sets, table, .. } = selection;
        Ok(Plan {
            scenes,
            tracers,
            ray_sets,
            ray_parameters: names::ray_values(&self.settings)?,
            preset: RunPreset { scene_scale: self.scale.unwrap_or(preset.scene_scale), ..preset },
            view: self.view.clone().map_or(ViewRequest::Default, ViewRequest::Named),
            time_s: self.animation_time,
            seed: 1,
            trace_to: TraceTo::Hit,
            builds_timed: true,
            wrong_rays_per_cause: WRONG_RAYS_PER_CAUSE,
            table,
        })
    }
}

impl TableArguments {
    /// What a table is about: its own scenes, tracers and ray sets where nothing else is said.
    pub(super) fn selection(&self, table: Table) -> Result<Selection, CliError> {
        let settings = &self.work.common.settings;
        let listed = |name: &str| SceneSource::Catalogue(name.to_owned());
        let scenes = match (&self.scene, table) {
            (Some(list), _) => names::scenes(list)?,
            (None, Table::Settings(_) | Table::Exact) => names::scenes(OsStr::new("all"))?,
            (None, Table::Claims(_)) => Vec::new(),
            (None, Table::Paper(_, experiment)) => experiment.scenes.iter().map(|each| listed(each.scene)).collect(),
        };
        let tracers = match table {
            Table::Settings(peers) => names::peers(peers, settings)?,
            Table::Claims(_) => Vec::new(),
            Table::Exact => names::tracers(self.tracer.as_deref().unwrap_or(&exact::tracer()), settings)?,
            Table::Paper(_, experiment) => {
                let mut steps = names::steps(experiment, settings)?;
                names::only(&mut steps, &self.only)?;
                steps.concat()
            }
        };
        let ray_sets = match self.rays.as_deref().unwrap_or(table.rays()) {
            "" => Vec::new(),
            list => names::ray_sets(list)?,
        };
        Ok(Selection { scenes, tracers, ray_sets, table: Some(table.name()), ..Selection::default() })
    }
}

impl WorkArguments {
    /// Whether it says how long times are sampled.
    pub(super) fn says_how_long(&self) -> bool {
        self.samples.is_some() || self.ratio_precision.is_some() || self.time_limit.is_some()
    }

    /// How long times are sampled, in place of the preset's.
    fn sampling(&self, preset: SampleSchedule) -> SampleSchedule {
        match (self.samples, SAMPLING.adaptive) {
            (Some(samples), _) => SampleSchedule::rounds(samples),
            (None, Some(adaptive)) if self.ratio_precision.is_some() || self.time_limit.is_some() => {
                let Adaptive { ratio_precision, time_limit_s } = preset.adaptive.unwrap_or(adaptive);
                let adaptive = Adaptive {
                    ratio_precision: self.ratio_precision.map_or(ratio_precision, |percent| percent / 100.0),
                    time_limit_s: self.time_limit.unwrap_or(time_limit_s),
                };
                SampleSchedule { min_rounds: SAMPLING.min_rounds, adaptive: Some(adaptive) }
            }
            _ => preset,
        }
    }

    /// The plan, but for the preset, which waits for the adapter if it is not given.
    pub(super) fn plan(&self, selection: Selection, hardware: impl FnOnce() -> bool) -> Result<Plan, CliError> {
        let Selection { table, between_samples, rounds, .. } = selection;
        let preset = self.preset.as_deref().and_then(RunPreset::named);
        let preset = preset.unwrap_or_else(|| RunPreset::for_adapter(hardware()));
        let preset = table.and_then(papers::find).map_or(preset, |(paper, _)| paper.resolved(preset));
        let is_exact = table == Some(exact::NAME);
        // Nobody asks it for times.
        let rounds = if is_exact { Some(1) } else { rounds };
        let preset = RunPreset { sampling: rounds.map_or(preset.sampling, SampleSchedule::rounds), ..preset };
        let own = exact::SETTINGS.iter().filter(|_| is_exact).map(|setting| (*setting).to_owned());
        let settings: Vec<String> = own.chain(self.common.settings.iter().cloned()).collect();
        let frame = self.frame_size.unwrap_or(preset.frame);
        let own_image = match between_samples {
            true => image_between_samples(preset.ray_image, frame, BETWEEN_SAMPLES),
            false => preset.ray_image,
        };
        let preset = RunPreset {
            ray_image: self.size.unwrap_or(own_image),
            frame,
            face: self.face_size.unwrap_or(preset.face),
            sampling: self.sampling(preset.sampling),
            ..preset
        };
        Ok(Plan {
            ray_parameters: names::ray_values(&settings)?,
            seed: self.seed,
            trace_to: self.trace_to,
            wrong_rays_per_cause: self.wrong_rays,
            ..self.common.plan_of(selection, preset)?
        })
    }
}
