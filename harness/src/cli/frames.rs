//! `frames`.

use std::ffi::OsString;

use clap::Args;

use super::arguments::{Selection, WorkArguments, within};
use super::work::{Clock, Work, all_measured};
use super::{CliError, names};
use crate::measure::{Context, MAX_RESIDENT};
use crate::progress::Progress;
use crate::render::Effect;
use crate::report;
use crate::studies::frames::{self, FramesRequest, MAX_FRAMES, Moves, PathsOf, Updates};

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
                return Err(CliError::Argument(format!("--effect: no effect '{name}'; there are: {known}")));
            };
            if effects.contains(&effect) {
                return Err(CliError::Argument(format!("--effect: {name} is there twice")));
            }
            effects.push(effect);
        }
        Ok(effects)
    }

    fn request(&self) -> Result<FramesRequest, CliError> {
        let refused = |why: &str| Err(CliError::Argument(why.to_owned()));
        if self.work.says_how_long() {
            return refused("--samples, --ratio-precision, --time-limit: a round is a frame; give --frames");
        }
        if let Some(cut) = self.cut.filter(|cut| *cut >= self.frames) {
            return refused(&format!("--cut {cut}: the last frame is {}", self.frames.saturating_sub(1)));
        }
        if self.fixed_rays && self.moves != Moves::Camera {
            return refused("--fixed-rays: the scene must stand still; take --move camera");
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
    let work = Work::prepare(&arguments.work, || arguments.selection(), Clock::Timed, progress)?;
    let tracers = work.plan.tracers.len();
    if tracers > MAX_RESIDENT {
        work.bench.out.abandon();
        return Err(CliError::Argument(format!(
            "--tracer: {tracers} tracers, at most {MAX_RESIDENT} follow at a time"
        )));
    }
    let execute = |context: &Context<'_>| frames::execute(&work.plan, &request, context);
    let record = work.study("frames", request.describe(), report::FRAMES_PAGE, progress, execute)?;
    all_measured(&work.plan, &record)
}
