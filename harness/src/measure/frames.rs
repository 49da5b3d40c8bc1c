//! Structures that follow a moving scene frame by frame, in turn. What is asked of them in a frame is the caller's ([`FrameWork`]).

use tracebench_api::{
    Geometry, Gpu, HitBuffer, Invalidation, PhaseClock, RayBuffer, Surface, Timing, TraceJob, TraceTo, TracerError,
    Update,
};
use tracebench_scenes::Scene;

use super::interleaved_set::{Setting, order_seed, record_of, rounds_of};
use super::run::Context;
use super::workload::Refusal;
use super::{BuildSample, RunError, TracerConfig, sound};
use crate::plan::{Plan, Resolution, TracerRequest};
use crate::results::{InterleavedSetRecord, SAH_COST, SampleSchedule};
use crate::viewpoint::Pose;

/// What the interleaved set is called.
const FRAMES: &str = "frames";

/// A hierarchy is refitted while its cost is below so many times that of its last build.
pub const MAX_SAH_GROWTH: f64 = 1.5;

/// How structures are brought up to date.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum UpdatePolicy {
    /// Reused where nothing that changed invalidates it, refitted where the method can while its cost is below [`MAX_SAH_GROWTH`] times that
    /// of its last build, else rebuilt.
    Auto,
    /// In this way, whatever comes of it.
    Always(Update),
}

/// A scene that moves, and the eye at every frame.
pub(crate) struct MovingFrames {
    /// At the time of the frame that was last gone to.
    pub scene: Scene,
    /// Animation times, seconds.
    pub times_s: Vec<f64>,
    /// As many.
    pub poses: Vec<Pose>,
}

/// What was done to a structure in a frame.
#[derive(Clone, Debug, Default)]
pub(crate) struct Updated {
    /// `build` at the first frame, else the name of an [`Update`].
    pub update: &'static str,
    /// What has moved since it was built and makes it stale.
    pub stale_by: Vec<&'static str>,
    /// None of a reuse.
    pub timing: Option<Timing>,
    /// Cost of a hierarchy that can be refitted.
    pub sah_cost: Option<f64>,
    pub structure_bytes: u64,
    pub build_peak_bytes: u64,
}

/// A tracer's turn in a frame.
pub(crate) struct Turn<'a> {
    pub frame: usize,
    /// Its place among the requests.
    pub follower: usize,
    pub config: &'a TracerConfig,
    pub updated: Updated,
    /// Whether it counts; else it warms up.
    pub counts: bool,
}

/// What is asked in every frame.
pub(crate) trait FrameWork {
    /// Before the turns of a frame.
    fn begin(&mut self, frame: usize, film: &MovingFrames, geometry: &Geometry) -> Result<(), RunError>;
    /// A tracer's turn; the inner error takes it out from this frame on.
    fn turn(&mut self, turn: Turn<'_>) -> Result<Result<(), TracerError>, RunError>;
    /// After the turns of a frame that counts.
    fn end(&mut self, frame: usize) -> Result<(), RunError>;
}

/// What came of the followers.
pub(crate) struct Followed {
    /// By request, why it was taken out.
    pub refused: Vec<Option<Refusal>>,
    pub interleaved_set: Option<InterleavedSetRecord>,
}

/// One that follows.
struct Follower {
    config: TracerConfig,
    resolution: Option<Resolution>,
    out: Option<Refusal>,
    /// The scene and the eye that the structure is of.
    is_of: Option<(String, Pose)>,
    built_sah: Option<f64>,
    sah: Option<f64>,
}

/// One trace.
pub(crate) struct Traced {
    pub timing: Timing,
    pub hits: Vec<tracebench_api::Hit>,
    pub surfaces: Vec<Surface>,
}

/// Traces once, into poisoned buffers of its own; these and reading them back are in no time.
///
/// # Errors
/// What the tracer says.
pub(crate) fn trace_once(
    config: &TracerConfig,
    rays: &RayBuffer,
    trace_to: TraceTo,
    gpu: Option<&Gpu>,
) -> Result<Traced, TracerError> {
    let mut hits = HitBuffer::tracing_to(trace_to, rays.host.len(), config.description.residency, gpu)?;
    hits.poison(gpu)?;
    let mut clock = PhaseClock::new(gpu);
    config.structure()?.trace(TraceJob { rays, trace_to, parameters: &config.parameters }, &mut hits, &mut clock)?;
    let timing = clock.finish()?;
    Ok(Traced { timing, hits: hits.read(gpu)?, surfaces: hits.read_surfaces(gpu)? })
}

/// Lets tracers follow: one pass to warm up, in which the first frame alone is traced, then one that counts. A round is a frame.
///
/// # Errors
/// [`RunError`] as its variants say.
pub(crate) fn follow(
    film: &mut MovingFrames,
    requests: &[TracerRequest],
    policy: UpdatePolicy,
    plan: &Plan,
    work: &mut dyn FrameWork,
    context: &Context<'_>,
) -> Result<Followed, RunError> {
    let gpu = context.device.as_deref().ok();
    let mut followers =
        requests.iter().map(|request| Follower::new(request, requests, context)).collect::<Result<Vec<_>, _>>()?;
    let setting = Setting {
        scene: film.scene.name.clone(),
        viewpoint: film.poses[0].name.clone(),
        resident_batch: 0,
        kernels: Some(context.kernels()?),
        turn: 0,
    };
    let frames = film.times_s.len();
    let seed = order_seed(plan.seed, &setting, FRAMES, 0);
    let sides: Vec<_> = followers.iter().map(|follower| follower.config.description.residency).collect();
    let sampling = Some(SampleSchedule::rounds(frames as u32));
    let mut rounds = rounds_of(&setting, seed, followers.len(), sides.into_iter(), sampling);
    let mesh = &film.scene.mesh;
    let (triangles, materials) = (mesh.triangles.clone(), mesh.triangle_materials.clone());
    let mut geometry = Geometry::with_materials(mesh.positions.clone(), triangles, materials, gpu)?;
    let bar = context.progress.bar(FRAMES, (2 * frames * followers.len()) as u64);
    for pass in 0..2 {
        for frame in 0..frames {
            film.scene.set_time(film.times_s[frame])?;
            geometry = geometry.with_positions(film.scene.mesh.positions.clone(), gpu)?;
            let counts = pass == 1;
            let traces = counts || frame == 0;
            if traces {
                work.begin(frame, film, &geometry)?;
            }
            let round = if traces { rounds.next(gpu, || [Vec::new()])? } else { None };
            let order = round.map_or_else(|| (0..followers.len()).collect(), |round| round.order);
            for place in order {
                bar.inc(1);
                let follower = &mut followers[place];
                if follower.out.is_some() {
                    continue;
                }
                let is_last = counts && frame + 1 == frames;
                let updated = follower.bring(policy, (frame, is_last), film, &geometry, plan, gpu);
                let done = match updated {
                    Ok(updated) if traces => {
                        work.turn(Turn { frame, follower: place, config: &follower.config, updated, counts })?
                    }
                    other => other.map(drop),
                };
                if let Err(error) = done {
                    let refusal = Refusal::of(&error, false);
                    follower.out = Some(Refusal { reason: format!("frame {frame}: {}", refusal.reason), ..refusal });
                }
                context.check_device()?;
            }
            if counts {
                work.end(frame)?;
            }
        }
    }
    rounds.next(gpu, || [Vec::new()])?;
    bar.finish_and_clear();
    let labels = requests.iter().map(|request| super::records::request_record(request).label()).collect();
    let interleaved_set = record_of(&setting, FRAMES, "the next frame", seed, &rounds, labels);
    Ok(Followed { refused: followers.into_iter().map(|follower| follower.out).collect(), interleaved_set })
}

impl Follower {
    fn new(request: &TracerRequest, all: &[TracerRequest], context: &Context<'_>) -> Result<Self, RunError> {
        let created = context.tracer_cache.borrow_mut().config(request, context.device);
        let (config, out) = match created {
            Ok(config) => (config, None),
            Err(error) if request.required && all.iter().all(|other| other.name() == request.name()) => {
                return Err(RunError::Tracer(request.name().to_owned(), error));
            }
            Err(error) => (context.absent(request), Some(Refusal::of(&error, false))),
        };
        Ok(Self { config, resolution: request.resolution, out, is_of: None, built_sah: None, sah: None })
    }

    /// Builds over the first frame, brings the structure to every other; the frame, and whether it is the last that counts.
    fn bring(
        &mut self,
        policy: UpdatePolicy,
        (frame, is_last): (usize, bool),
        film: &MovingFrames,
        geometry: &Geometry,
        plan: &Plan,
        gpu: Option<&Gpu>,
    ) -> Result<Updated, TracerError> {
        let Resolution { frame: size, face } =
            self.resolution.unwrap_or(Resolution { frame: plan.preset.frame, face: plan.preset.face });
        let pose = &film.poses[frame];
        let viewpoint = pose.viewpoint(geometry, size, face);
        let can_refit = self.config.description.serves(Update::Refit).is_ok();
        let invalid = self.invalid(&film.scene.sha256, pose);
        let update = (frame > 0).then(|| self.choose(policy, &invalid, can_refit));
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
            self.sah = found.into_iter().find(|(name, _)| can_refit && *name == SAH_COST).map(|(_, cost)| cost);
        }
        if matches!(update, None | Some(Update::Rebuild)) {
            self.built_sah = self.sah;
        }
        let memory = self.config.structure()?.memory();
        Ok(Updated {
            update: update.map_or("build", Update::name),
            stale_by: if is_stale { invalid.into_iter().map(|(_, name)| name).collect() } else { Vec::new() },
            timing: sample.map(|sample| sample.whole),
            sah_cost: self.sah,
            structure_bytes: memory.structure_bytes(),
            build_peak_bytes: memory.build_peak_bytes,
        })
    }

    /// What has changed since the structure was brought to its scene and eye, and invalidates it.
    fn invalid(&self, sha256: &str, pose: &Pose) -> Vec<(Invalidation, &'static str)> {
        let Some((scene, eye)) = &self.is_of else { return Vec::new() };
        let unnamed = |pose: &Pose| Pose { name: String::new(), ..pose.clone() };
        let changes = [
            (scene != sha256, Invalidation::Geometry, "geometry"),
            (unnamed(eye) != unnamed(pose), Invalidation::Viewpoint, "viewpoint"),
        ];
        let by = self.config.description.invalidated_by;
        let invalid = changes.into_iter().filter(|(changed, change, _)| *changed && by.contains(change));
        invalid.map(|(_, change, name)| (change, name)).collect()
    }

    fn choose(&self, policy: UpdatePolicy, invalid: &[(Invalidation, &'static str)], can_refit: bool) -> Update {
        let costs = self.sah.zip(self.built_sah);
        let is_cheap = costs.is_none_or(|(sah, built)| sah < MAX_SAH_GROWTH * built);
        match policy {
            UpdatePolicy::Always(update) => update,
            UpdatePolicy::Auto if invalid.is_empty() => Update::Reuse,
            UpdatePolicy::Auto
                if can_refit && is_cheap && invalid.iter().all(|(by, _)| *by == Invalidation::Geometry) =>
            {
                Update::Refit
            }
            UpdatePolicy::Auto => Update::Rebuild,
        }
    }
}
