//! Structures that follow a moving scene frame by frame, in turn. What is asked of them in a frame is the caller's ([`FrameWork`]).

use tracebench_api::{
    Geometry, Gpu, HitBuffer, Invalidation, PhaseClock, RayBuffer, Surface, Timing, TraceJob, TraceTo, TracerError,
    Update,
};
use tracebench_scenes::Scene;

use super::doubled_work::{DoubledWork, firsts};
use super::interleaved_set::{FRAMES, Setting};
use super::run::Context;
use super::workload::Refusal;
use super::{BuildSample, RunError, TracerConfig, sound};
use crate::plan::{Plan, TracerRequest};
use crate::results::{FrameRow, InterleavedSetRecord, SAH_COST, SampleSchedule};
use crate::viewpoint::Pose;

/// A hierarchy is refitted while its cost is below so many times that of its last build.
const MAX_SAH_GROWTH: f64 = 1.5;

/// A scene that moves, and the eye at every frame.
pub(crate) struct MovingFrames {
    /// At the time of the frame that was last gone to.
    pub scene: Scene,
    /// Animation times, seconds.
    pub times_s: Vec<f64>,
    /// As many.
    pub poses: Vec<Pose>,
}

/// What is asked in every frame.
pub(crate) trait FrameWork {
    /// A frame as it is looked at.
    type Frame;

    /// Looks at a frame before the turns in it; `before` is the one that was looked at before.
    fn look(
        &mut self,
        frame: usize,
        film: &MovingFrames,
        geometry: &Geometry,
        before: Option<Self::Frame>,
    ) -> Result<Self::Frame, RunError>;

    /// The turn of the tracer of a place among the requests, which counts or warms up; the row is what was done to its structure, without
    /// works yet. [`RunError::Device`] is the tracer's, and takes it out from this frame on.
    fn turn(&mut self, here: &Self::Frame, of: (usize, &TracerConfig, bool), row: FrameRow) -> Result<(), RunError>;

    /// The first of its work, done twice in one sample: the control of the clock.
    fn twice(&mut self, here: &Self::Frame, config: &TracerConfig) -> Result<Timing, TracerError>;

    /// After the turns of a frame that counts.
    fn end(&mut self, here: &Self::Frame) -> Result<(), RunError>;
}

/// What came of the followers.
pub(crate) struct Followed {
    /// By request, why it was taken out.
    pub refused: Vec<Option<Refusal>>,
    /// Those who did their work twice, by their places among the requests.
    pub doubles: Vec<DoubledWork>,
    pub interleaved_set: Option<InterleavedSetRecord>,
}

/// One that follows.
struct Follower {
    config: TracerConfig,
    out: Option<Refusal>,
    /// The scene and the eye that the structure is of.
    is_of: Option<(String, Pose)>,
    built_sah: Option<f64>,
    sah: Option<f64>,
    /// The pass and the frame that it was last brought to, and what that took.
    brought: Option<(usize, usize)>,
    row: FrameRow,
}

/// One trace.
pub(crate) struct Traced {
    pub timing: Timing,
    pub hits: Vec<tracebench_api::Hit>,
    pub surfaces: Vec<Surface>,
}

/// Traces so many times (once, but for the control of the clock) into poisoned buffers of its own; these and reading them back are in no
/// time.
///
/// # Errors
/// What the tracer says.
pub(crate) fn trace_sample(
    config: &TracerConfig,
    rays: &RayBuffer,
    trace_to: TraceTo,
    gpu: Option<&Gpu>,
    repeats: usize,
) -> Result<Traced, TracerError> {
    let mut hits = HitBuffer::tracing_to(trace_to, rays.host.len(), config.description.residency, gpu)?;
    hits.poison(gpu)?;
    let mut clock = PhaseClock::new(gpu);
    let structure = config.structure()?;
    for _ in 0..repeats {
        structure.trace(TraceJob { rays, trace_to, parameters: &config.parameters }, &mut hits, &mut clock)?;
    }
    let timing = clock.finish()?;
    Ok(Traced { timing, hits: hits.read(gpu)?, surfaces: hits.read_surfaces(gpu)? })
}

/// Lets tracers follow: one pass to warm up, in which the first frame alone is traced, then one that counts. A round is a frame, in which the
/// first on each clock has two turns: one of its own, and one for the control of the clock, whichever comes first. Structures
/// are always brought up to date in one way, whatever comes of it; where none is given they are reused where nothing that changed invalidates
/// them, refitted where the method can while the cost is below [`MAX_SAH_GROWTH`] times that of the last build, else rebuilt.
///
/// # Errors
/// [`RunError`] as its variants say.
pub(crate) fn follow<W: FrameWork>(
    film: &mut MovingFrames,
    requests: &[TracerRequest],
    always: Option<Update>,
    plan: &Plan,
    work: &mut W,
    context: &Context<'_>,
) -> Result<Followed, RunError> {
    let gpu = context.device.as_deref().ok();
    let follower = |request: &TracerRequest| {
        let (config, out) = context.config_or_refusal(request, requests)?;
        let row = FrameRow::default();
        Ok::<_, RunError>(Follower { config, out, is_of: None, built_sah: None, sah: None, brought: None, row })
    };
    let mut followers = requests.iter().map(follower).collect::<Result<Vec<_>, _>>()?;
    let (scene, viewpoint) = (film.scene.name.clone(), film.poses[0].name.clone());
    let setting = Setting { scene, viewpoint, resident_batch: 0, kernels: Some(context.kernels()?), turn: 0 };
    let frames = film.times_s.len();
    let seed = setting.order_seed(plan.seed, FRAMES, 0);
    let sides: Vec<_> = followers.iter().map(|follower| follower.config.description.residency).collect();
    let able: Vec<_> = (followers.iter().zip(requests).enumerate())
        .filter(|(_, (follower, _))| follower.out.is_none())
        .map(|(place, (_, request))| (place, sides[place], request.registration.one_origin()))
        .collect();
    let double = |participant| DoubledWork { participant, ..DoubledWork::default() };
    let mut doubles: Vec<DoubledWork> = firsts(&able).map(double).collect();
    let turns = followers.len() + doubles.len();
    let mut rounds = setting.rounds(seed, turns, &sides, Some(SampleSchedule::rounds(frames as u32)));
    let mesh = &film.scene.mesh;
    let (triangles, materials) = (mesh.triangles.clone(), mesh.triangle_materials.clone());
    let mut geometry = Geometry::with_materials(mesh.positions.clone(), triangles, materials, gpu)?;
    let bar = context.progress.bar(FRAMES, (2 * frames * followers.len() + (frames + 1) * doubles.len()) as u64);
    let mut here: Option<(usize, W::Frame)> = None;
    for pass in 0..2 {
        for frame in 0..frames {
            film.scene.set_time(film.times_s[frame])?;
            geometry = geometry.with_positions(film.scene.mesh.positions.clone(), gpu)?;
            let counts = pass == 1;
            let traces = counts || frame == 0;
            if traces && here.as_ref().is_none_or(|(known, _)| *known != frame) {
                let before = here.take().map(|(_, before)| before);
                here = Some((frame, work.look(frame, film, &geometry, before)?));
            }
            let here = here.as_ref().filter(|_| traces).map(|(_, here)| here);
            let round = if traces { rounds.next(gpu, || [Vec::new()])? } else { None };
            let order = round.map_or_else(|| (0..followers.len()).collect(), |round| round.order);
            for place in order {
                bar.inc(1);
                let double = place.checked_sub(followers.len());
                let follower = &mut followers[double.map_or(place, |double| doubles[double].participant)];
                if follower.out.is_some() {
                    continue;
                }
                let at = (pass, frame, counts && frame + 1 == frames);
                let brought = follower.bring(always, at, film, &geometry, plan, gpu).map_err(RunError::Device);
                let done = brought.and_then(|()| match (here, double) {
                    (None, _) => Ok(()),
                    (Some(here), None) => {
                        work.turn(here, (place, &follower.config, counts), std::mem::take(&mut follower.row))
                    }
                    (Some(_), Some(double)) if doubles[double].not_judged.is_some() => Ok(()),
                    (Some(here), Some(double)) => {
                        doubles[double].keep(work.twice(here, &follower.config), counts);
                        Ok(())
                    }
                });
                match done {
                    Ok(()) => {}
                    Err(RunError::Device(error)) => {
                        let refusal = Refusal::of(&error, false);
                        let reason = format!("frame {frame}: {}", refusal.reason);
                        follower.out = Some(Refusal { reason, ..refusal });
                    }
                    Err(error) => return Err(error),
                }
                context.check_device()?;
            }
            if let Some(here) = here.filter(|_| counts) {
                work.end(here)?;
            }
        }
    }
    rounds.next(gpu, || [Vec::new()])?;
    bar.finish_and_clear();
    let label = |request| super::records::request_record(request).label();
    let doubled = doubles.iter().map(|double| format!("{} twice", label(&requests[double.participant])));
    let interleaved_set = setting.record(FRAMES, &rounds, requests.iter().map(label).chain(doubled).collect());
    Ok(Followed { refused: followers.into_iter().map(|follower| follower.out).collect(), doubles, interleaved_set })
}

impl Follower {
    /// Builds over the first frame, brings the structure to every other, once in each of a pass; the pass, the frame, and whether it is the
    /// last that counts.
    fn bring(
        &mut self,
        always: Option<Update>,
        (pass, frame, is_last): (usize, usize, bool),
        film: &MovingFrames,
        geometry: &Geometry,
        plan: &Plan,
        gpu: Option<&Gpu>,
    ) -> Result<(), TracerError> {
        if self.brought.replace((pass, frame)) == Some((pass, frame)) {
            return Ok(());
        }
        let pose = &film.poses[frame];
        let viewpoint = pose.viewpoint(geometry, plan.preset.frame, plan.preset.face);
        let can_refit = self.config.description.serves(Update::Refit).is_ok();
        let invalid = self.invalid(&film.scene.sha256, pose);
        let update = (frame > 0).then(|| always.unwrap_or_else(|| self.choose(&invalid, can_refit)));
        let sample: Option<BuildSample> = match update {
            None => Some(self.config.build(geometry, &viewpoint, gpu)?),
            Some(update) => self.config.update(update, geometry, &viewpoint, gpu)?,
        };
        let is_reused = update == Some(Update::Reuse);
        if !is_reused {
            self.is_of = Some((film.scene.sha256.clone(), pose.clone()));
        }
        let is_stale = is_reused && !invalid.is_empty();
        if !is_stale && (is_last || can_refit && !is_reused) {
            let found = sound::statistics(self.config.structure()?, geometry)?;
            // A hybrid names its parts' costs after them; of two that have one the first tells.
            let is_cost = |name: &str| name.rsplit('.').next() == Some(SAH_COST);
            self.sah = found.into_iter().find(|(name, _)| can_refit && is_cost(name)).map(|(_, cost)| cost);
        }
        if matches!(update, None | Some(Update::Rebuild)) {
            self.built_sah = self.sah;
        }
        let stale_by = invalid.into_iter().filter(|_| is_stale).map(str::to_owned);
        let memory = self.config.structure()?.memory();
        self.row = FrameRow {
            update: update.map_or("build", Update::name).to_owned(),
            stale_by: stale_by.collect(),
            update_ms: Some(sample.as_ref().map_or(0.0, |sample| sample.whole.total_ms)),
            grown: sample.is_some_and(|sample| sample.whole.grown),
            sah_cost: self.sah,
            structure_bytes: memory.structure_bytes(),
            build_peak_bytes: memory.build_peak_bytes,
            ..FrameRow::default()
        };
        Ok(())
    }

    /// What has changed since the structure was brought to its scene and eye, and invalidates it.
    fn invalid(&self, sha256: &str, pose: &Pose) -> Vec<&'static str> {
        let Some((scene, eye)) = &self.is_of else { return Vec::new() };
        let unnamed = |pose: &Pose| Pose { name: String::new(), ..pose.clone() };
        let changes = [
            (scene != sha256, Invalidation::Geometry, "geometry"),
            (unnamed(eye) != unnamed(pose), Invalidation::Viewpoint, "viewpoint"),
        ];
        let by = self.config.description.invalidated_by;
        let invalid = changes.into_iter().filter(|(changed, change, _)| *changed && by.contains(change));
        invalid.map(|(.., name)| name).collect()
    }

    fn choose(&self, invalid: &[&str], can_refit: bool) -> Update {
        let costs = self.sah.zip(self.built_sah);
        let is_cheap = costs.is_none_or(|(sah, built)| sah < MAX_SAH_GROWTH * built);
        if invalid.is_empty() {
            Update::Reuse
        } else if can_refit && is_cheap {
            Update::Refit
        } else {
            Update::Rebuild
        }
    }
}
