//! One scene from one viewpoint: its rays and truth made once, every configuration built and sampled through the one clock.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Instant;

use glam::DVec3;
use tracebench_api::{
    Geometry, Gpu, Hit, HitBuffer, MemoryEntry, Parameters, PhaseClock, Query, Ray, RayBuffer, SampledImage, Surface,
    Timing, TraceJob, TraceTo, TracerError, Viewpoint, VoxelGrid,
};

use crate::judge::{Class, Judge, JudgeError, Rule, WRONG_RAYS_PER_CAUSE, true_counts};
use crate::measure::controls::{Control, KnownAnswers};
use crate::measure::workload::Observations;
use crate::measure::{BuildSample, TracerConfig};
use crate::progress::Progress;
use crate::rays::{self, GeneratedRays, Pixel, RayError, RayScene, RaySet, Starts};
use crate::results::{Judgement, OCCLUSION, Skipped, SurfaceJudgement, TrueCounts, one_sided};
use crate::truth::{Answer, Cache, Truth, TruthError};

/// Why a scene could not be measured.
#[derive(Debug, thiserror::Error)]
pub enum SessionError {
    /// The truth failed its audit.
    #[error(transparent)]
    Truth(#[from] TruthError),
    /// Rays of a folder are not of the scene.
    #[error(transparent)]
    Rays(RayError),
    /// Rays do not fit the device.
    #[error(transparent)]
    Tracer(#[from] TracerError),
    /// A tracer gave answers to a ray set that are none.
    #[error("{0} on ray set {1}: {2}; where they are unwritten, `--launch texture,1` may help")]
    Judge(String, String, JudgeError),
}

/// A ray set with its truth.
pub struct PreparedRays {
    /// The set.
    pub set: RaySet,
    /// The rays, resident.
    pub buffer: RayBuffer,
    /// Their truth.
    pub answers: Arc<Vec<Answer>>,
    /// The eye whose pixels `footprint` is of; none of rays that have none.
    pub eye: Option<DVec3>,
    /// Hash of the rays.
    pub sha256: String,
    /// Of every ray the pixel that it started from; empty for rays that were made elsewhere.
    pub pixels: Arc<Vec<Pixel>>,
}

impl PreparedRays {
    pub(crate) fn new(
        set: RaySet,
        (rays, answers): (Arc<Vec<Ray>>, Arc<Vec<Answer>>),
        eye: Option<DVec3>,
        gpu: Option<&Gpu>,
    ) -> Self {
        let sha256 = crate::hash::sha256_of(&rays);
        Self { set, buffer: RayBuffer::new(rays, set.query, gpu), answers, eye, sha256, pixels: Arc::default() }
    }
}

/// What a tracer sees the scene through, as the judge is told.
#[derive(Default)]
pub struct SamplingModel {
    /// The images.
    pub samplings: Vec<SampledImage>,
    /// The voxels.
    pub voxels: Option<VoxelGrid>,
}

/// One scene from one viewpoint.
pub struct Session {
    /// The device.
    pub gpu: Option<Arc<Gpu>>,
    /// The truth.
    pub truth: Arc<Truth>,
    /// The viewpoint.
    pub viewpoint: Viewpoint,
    /// How far traces go.
    pub trace_to: TraceTo,
    /// How many wrong rays of each cause judgements keep.
    pub wrong_rays_per_cause: usize,
    /// The host's clock, by which traces are timed.
    pub now: fn() -> Instant,
    /// The ray sets that are not empty.
    pub rays: Vec<PreparedRays>,
    /// The ray sets that are, with the reason.
    pub skipped: Vec<Skipped>,
}

impl Session {
    /// Makes the rays of some sets, uploads them and tells their truth. `scene_name` is for messages.
    ///
    /// # Errors
    /// [`SessionError`] if the truth fails its audit or the device cannot hold the rays.
    pub fn new(
        scene_name: &str,
        truth: Arc<Truth>,
        sets: &[RaySet],
        scene: &RayScene<'_>,
        gpu: Option<Arc<Gpu>>,
        cache: &Cache,
        progress: &Progress,
    ) -> Result<Self, SessionError> {
        let viewpoint = *scene.viewpoint;
        let primary = Arc::new(rays::primary_rays(&viewpoint, scene.image));
        // Most other sets start from the primary hits, so these are always told.
        let answers = Arc::new(truth.answer(&primary, Query::Closest, cache, progress)?);
        let primary = Starts::primary(primary, answers);
        let (mut prepared, mut skipped) = (Vec::new(), Vec::new());
        let tell = |rays: &Arc<Vec<Ray>>| truth.answer(rays, Query::Closest, cache, progress);
        for set in sets {
            let GeneratedRays { rays, pixels } = match rays::make(set, scene, &primary, tell) {
                Ok(made) => made,
                Err(RayError::Truth(error)) => return Err(error.into()),
                Err(error @ RayError::OtherScene(_)) => return Err(SessionError::Rays(error)),
                Err(error) => {
                    let (scene, rays, reason) = (scene_name.to_owned(), Some(set.name.to_owned()), error.to_string());
                    skipped.push(Skipped { tracer: None, scene, rays, reason });
                    continue;
                }
            };
            progress.say(&format!("  rays {}: {}", set.name, rays.len()));
            let answers = if Arc::ptr_eq(&rays, &primary.rays) {
                Arc::clone(&primary.answers)
            } else {
                Arc::new(truth.answer(&rays, set.query, cache, progress)?)
            };
            let TrueCounts { hits, misses, ambiguous_hits, ambiguous_misses, .. } = true_counts(&answers);
            let [may_hit, may_miss] = if set.query == Query::Any { [0; 2] } else { [ambiguous_hits, ambiguous_misses] };
            if let Some(why) = one_sided(set.query, hits + may_hit, misses + may_miss) {
                progress.say(&format!("  warning: rays {}: {why}, so shares of right answers say nothing", set.name));
            }
            let eye = set.saved().map_or(Some(viewpoint.eye.as_dvec3()), |saved| saved.eye);
            prepared.push(PreparedRays { pixels, ..PreparedRays::new(*set, (rays, answers), eye, gpu.as_deref()) });
        }
        Ok(Self::with(truth, viewpoint, gpu, prepared, skipped))
    }

    /// Takes rays that were made elsewhere, uploads them and tells their truth.
    ///
    /// # Errors
    /// [`SessionError`] if the truth fails its audit.
    pub fn of_rays(
        truth: impl Into<Arc<Truth>>,
        viewpoint: Viewpoint,
        set: RaySet,
        rays: Vec<Ray>,
        gpu: Option<Arc<Gpu>>,
    ) -> Result<Self, SessionError> {
        let (truth, rays) = (truth.into(), Arc::new(rays));
        let answers = Arc::new(truth.answer(&rays, set.query, &Cache::none(), &Progress::new(true))?);
        let eye = Some(viewpoint.eye.as_dvec3());
        let rays = vec![PreparedRays::new(set, (rays, answers), eye, gpu.as_deref())];
        Ok(Self::with(truth, viewpoint, gpu, rays, Vec::new()))
    }

    /// One that has such rays.
    pub(crate) fn with(
        truth: Arc<Truth>,
        viewpoint: Viewpoint,
        gpu: Option<Arc<Gpu>>,
        rays: Vec<PreparedRays>,
        skipped: Vec<Skipped>,
    ) -> Self {
        let (trace_to, wrong_rays_per_cause) = (TraceTo::Hit, WRONG_RAYS_PER_CAUSE);
        Self { gpu, truth, viewpoint, trace_to, wrong_rays_per_cause, now: Instant::now, rays, skipped }
    }

    /// The scene's triangles.
    pub fn geometry(&self) -> &Geometry {
        self.truth.geometry()
    }

    /// The device.
    pub fn gpu(&self) -> Option<&Gpu> {
        self.gpu.as_deref()
    }

    /// The controls as configurations.
    pub fn controls(&self) -> Vec<(Control, TracerConfig)> {
        let known: KnownAnswers =
            self.rays.iter().map(|rays| (Arc::clone(&rays.buffer.host), Arc::clone(&rays.answers))).collect();
        let config = |control: Control| {
            let parameters = Parameters::preset(&[], tracebench_api::Preset::Published);
            let tracer = control.tracer(known.clone(), self.truth.diagonal());
            (control, TracerConfig::ready(control.description(), parameters, tracer))
        };
        Control::ALL.into_iter().map(config).collect()
    }

    /// Builds once over the scene and gives the times, as [`TracerConfig::build`].
    ///
    /// # Errors
    /// What the tracer says.
    pub fn sample_build(&self, config: &mut TracerConfig) -> Result<BuildSample, TracerError> {
        config.build(self.geometry(), &self.viewpoint, self.gpu())
    }

    /// Room for a configuration's answers to a ray set.
    ///
    /// # Errors
    /// [`TracerError::TooLarge`] if the device cannot hold them.
    pub fn hit_buffer(&self, config: &TracerConfig, rays: &PreparedRays) -> Result<HitBuffer, TracerError> {
        HitBuffer::tracing_to(self.trace_to, rays.buffer.host.len(), config.description.residency, self.gpu())
    }

    /// Poisons the hits, traces so many times (once, but for the control of the clock) and gives the time of all together.
    ///
    /// # Errors
    /// What the tracer says.
    pub fn sample_trace(
        &self,
        config: &TracerConfig,
        rays: &PreparedRays,
        hits: &mut HitBuffer,
        repeats: usize,
    ) -> Result<Timing, TracerError> {
        hits.poison(self.gpu())?;
        let mut clock = PhaseClock::read_by(self.gpu(), self.now);
        for _ in 0..repeats {
            config.structure()?.trace(self.job(config, rays), hits, &mut clock)?;
        }
        clock.finish()
    }

    /// Traces once by the counting variant, whose hits and surfaces must be those of the timed one.
    ///
    /// # Errors
    /// [`TracerError::Failed`] if they differ, or what the tracer says.
    pub fn count(
        &self,
        config: &TracerConfig,
        rays: &PreparedRays,
        timed: &[Hit],
        surfaces: &[Surface],
    ) -> Result<Vec<tracebench_api::Counter>, TracerError> {
        let mut hits = self.hit_buffer(config, rays)?;
        hits.poison(self.gpu())?;
        let counters = config.structure()?.trace_counted(self.job(config, rays), &mut hits)?;
        let (counted, of_counted) = (hits.read(self.gpu())?, hits.read_surfaces(self.gpu())?);
        let same_hits = bytemuck::cast_slice::<Hit, u8>(&counted) == bytemuck::cast_slice::<Hit, u8>(timed);
        let same_surfaces =
            bytemuck::cast_slice::<Surface, u8>(&of_counted) == bytemuck::cast_slice::<Surface, u8>(surfaces);
        if !same_hits || !same_surfaces {
            return Err(TracerError::Failed(format!(
                "{} gives other hits or surfaces to ray set {} when it counts than when it is timed",
                config.description.name, rays.set.name
            )));
        }
        Ok(counters)
    }

    /// A trace's own buffers, by name.
    ///
    /// # Errors
    /// [`TracerError::Failed`] before the first build.
    pub fn trace_memory(&self, config: &TracerConfig, rays: &PreparedRays) -> Result<Vec<MemoryEntry>, TracerError> {
        config.structure()?.trace_memory(self.job(config, rays))
    }

    fn job<'a>(&self, config: &'a TracerConfig, rays: &'a PreparedRays) -> TraceJob<'a> {
        TraceJob { rays: &rays.buffer, trace_to: self.trace_to, parameters: &config.parameters }
    }

    /// What a configuration sees the scene through.
    ///
    /// # Errors
    /// [`TracerError::Failed`] before the first build, or what the tracer says.
    pub fn sampling_model(&self, config: &TracerConfig) -> Result<SamplingModel, TracerError> {
        let (structure, parameters) = (config.structure()?, &config.parameters);
        Ok(SamplingModel { samplings: structure.samplings(parameters)?, voxels: structure.voxels(parameters)? })
    }

    /// Judges a configuration's answers.
    ///
    /// # Errors
    /// [`SessionError::Judge`] if they are no answers.
    pub fn judge(&self, config: &TracerConfig, rays: &PreparedRays, hits: &[Hit]) -> Result<Judgement, SessionError> {
        let SamplingModel { samplings, voxels } = self.sampling_model(config)?;
        let names_primitives = config.description.names_primitives;
        let judge = Judge { names_primitives, voxels, ..self.judge_of(rays, &samplings) };
        judge.judge(hits).map_err(|error| no_answers(config.description.name, rays.set.name, error))
    }

    /// The judge's causes of wrong answers among some of them, and how many have each; of an any-hit set whatever the rule.
    ///
    /// # Errors
    /// [`SessionError::Judge`] if they are no answers.
    pub(crate) fn causes(
        &self,
        tracer: &str,
        rays: &PreparedRays,
        rule: Rule,
        told: &Observations,
        of: &[usize],
    ) -> Result<BTreeMap<String, u64>, SessionError> {
        let hosts: Vec<Ray> = of.iter().map(|ray| rays.buffer.host[*ray]).collect();
        let answers: Vec<Answer> = of.iter().map(|ray| rays.answers[*ray].clone()).collect();
        let hits: Vec<Hit> = of.iter().map(|ray| told.hits[*ray]).collect();
        let judge = self.judge_of(rays, &told.sampling_model.samplings);
        let judge = Judge { rays: &hosts, answers: &answers, voxels: told.sampling_model.voxels, ..judge };
        let judged = judge.judge(&hits).map_err(|error| no_answers(tracer, rays.set.name, error))?;
        let rule = if rays.set.query == Query::Any { OCCLUSION } else { rule.name() };
        Ok(judged.causes().get(rule).cloned().unwrap_or_default())
    }

    /// Judges a configuration's surfaces; nothing where traces do not go that far.
    ///
    /// # Errors
    /// [`SessionError::Judge`] if they are not those of the hits.
    pub fn judge_surfaces(
        &self,
        config: &TracerConfig,
        rays: &PreparedRays,
        hits: &[Hit],
        surfaces: &[Surface],
    ) -> Result<Option<SurfaceJudgement>, SessionError> {
        if self.trace_to == TraceTo::Hit || rays.eye.is_none() {
            return Ok(None);
        }
        let judged = self.judge_of(rays, &[]).judge_surfaces(hits, surfaces);
        judged.map(Some).map_err(|error| no_answers(config.description.name, rays.set.name, error))
    }

    /// The class of every answer under a rule, as [`Judge::classes`].
    ///
    /// # Errors
    /// [`SessionError::Judge`] if they are no answers.
    pub fn classes(
        &self,
        tracer: &str,
        rays: &PreparedRays,
        rule: Rule,
        hits: &[Hit],
    ) -> Result<Vec<Option<Class>>, SessionError> {
        self.judge_of(rays, &[]).classes(rule, hits).map_err(|error| no_answers(tracer, rays.set.name, error))
    }

    pub(crate) fn judge_of<'a>(&'a self, rays: &'a PreparedRays, samplings: &'a [SampledImage]) -> Judge<'a> {
        Judge {
            truth: &self.truth,
            eye: rays.eye,
            rays: &rays.buffer.host,
            answers: &rays.answers,
            query: rays.set.query,
            samplings,
            voxels: None,
            names_primitives: false,
            wrong_rays_per_cause: self.wrong_rays_per_cause,
        }
    }
}

/// What a tracer gave to rays of a name is no answers.
pub(crate) fn no_answers(tracer: &str, rays: &str, error: JudgeError) -> SessionError {
    SessionError::Judge(tracer.to_owned(), rays.to_owned(), error)
}
