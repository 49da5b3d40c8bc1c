//! The controls that bracket every scale: one that knows the truth, one that always misses, one that always hits, and one that is
//! wrong in a known share, which the judge must find to be just that.

use std::sync::Arc;

use glam::Vec3;
use tracebench_api::{
    Counter, Geometry, Hit, HitBuffer, MemoryReport, NO_PRIMITIVE, Parameters, PhaseClock, Query, Ray, Residency,
    Status, Structure, Surface, SurfaceStatus, TraceJob, TraceTo, Tracer, TracerDescription, TracerError, Update,
    Viewpoint, named,
};

use crate::judge::true_counts;
use crate::results::{AnyJudgement, Classes, ClosestJudgement, Judgement, PerRule, SurfaceJudgement, TrueCounts};
use crate::truth::{Answer, Ray64};

named! {
    /// A control.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum Control {
        /// Answers the truth; its agreements must be 1.
        Oracle = "oracle",
        /// Never hits.
        AlwaysMiss = "always-miss",
        /// Always hits.
        AlwaysHit = "always-hit",
        /// Answers the truth, but for a known share.
        Corrupted = "corrupted",
    }
}

/// Of so many rays that truly hit the corrupted control misses one, and of so many that truly miss it hits with one.
const CORRUPTED_ONE_OF: u64 = 8;

/// Which rays the corrupted control answers wrongly: the first of every eight that hit, and of every eight that miss; never an
/// ambiguous one.
pub fn corrupted(answers: &[Answer]) -> Vec<bool> {
    let mut seen = [0_u64; 2];
    let wrong = |answer: &Answer| {
        let seen = &mut seen[usize::from(answer.hit.is_some())];
        *seen += u64::from(!answer.is_ambiguous());
        !answer.is_ambiguous() && *seen % CORRUPTED_ONE_OF == 1
    };
    answers.iter().map(wrong).collect()
}

/// A ray set with its truth: what the oracle answers from.
pub type KnownAnswers = Vec<(Arc<Vec<Ray>>, Arc<Vec<Answer>>)>;

impl Control {
    /// What it is.
    pub fn description(self) -> TracerDescription {
        let summary = match self {
            Self::Oracle => "answers the ground truth: must score 1",
            Self::AlwaysMiss => "never hits: scores the share of rays that miss",
            Self::AlwaysHit => "always hits, half the scene's diagonal away",
            Self::Corrupted => "answers the truth but for one ray of eight: must score just that",
        };
        TracerDescription {
            name: self.name(),
            citation: "",
            summary,
            residency: Residency::Host,
            invalidated_by: &[],
            names_primitives: self.knows(),
            ends: &TraceTo::ALL,
            queries: &Query::ALL,
            no_refit: None,
            parameters: Vec::new(),
        }
    }

    /// Whether it answers from the truth.
    fn knows(self) -> bool {
        matches!(self, Self::Oracle | Self::Corrupted)
    }

    /// Of the rays that are not ambiguous, those that hit and those that miss, how many it answers wrongly.
    fn wrong(self, TrueCounts { hits, misses, .. }: &TrueCounts) -> [u64; 2] {
        match self {
            Self::Oracle => [0, 0],
            Self::AlwaysMiss => [*hits, 0],
            Self::AlwaysHit => [0, *misses],
            Self::Corrupted => [*hits, *misses].map(|rays| rays.div_ceil(CORRUPTED_ONE_OF)),
        }
    }

    /// How many ambiguous closest-hit rays it finds, rightly misses, and loses. Every such ray may hit.
    fn ambiguous(self, counts: &TrueCounts) -> [u64; 3] {
        let TrueCounts { ambiguous_hits, ambiguous_misses, ambiguous_may_miss, .. } = *counts;
        let all = ambiguous_hits + ambiguous_misses;
        match self {
            Self::Oracle | Self::Corrupted => [ambiguous_hits, ambiguous_misses, 0],
            Self::AlwaysMiss => [0, ambiguous_may_miss, all.saturating_sub(ambiguous_may_miss)],
            Self::AlwaysHit => [all, 0, 0],
        }
    }

    /// As a tracer, with the truth of every ray set that it will be given.
    pub fn tracer(self, known: KnownAnswers, diagonal: f64) -> Box<dyn Tracer> {
        Box::new(Answering { control: self, known: Arc::new(known), diagonal, geometry: None })
    }

    /// Its answers to rays whose truth is known, in a scene of such a diagonal.
    pub fn hits(self, rays: &[Ray], answers: &[Answer], diagonal: f64) -> Vec<Hit> {
        let answering = Answering { control: self, known: Arc::default(), diagonal, geometry: None };
        answering.answers(rays, answers).collect()
    }

    /// The same with their surfaces, in a scene.
    pub(crate) fn answered(self, geometry: &Geometry, rays: &[Ray], answers: &[Answer]) -> (Vec<Hit>, Vec<Surface>) {
        let (known, diagonal) = (Arc::default(), geometry.diagonal());
        let answering = Answering { control: self, known, diagonal, geometry: Some(geometry.clone()) };
        let hits: Vec<Hit> = answering.answers(rays, answers).collect();
        let each = rays.iter().zip(answers).zip(&hits);
        let surfaces = each.map(|((ray, truth), hit)| answering.surface(ray, truth, hit)).collect();
        (hits, surfaces)
    }

    /// Checks what the judge made of the control, by what the truth says of the rays.
    ///
    /// # Errors
    /// What the control scored wrongly; the run is invalid then.
    pub fn check(self, judgement: &Judgement, counts: &TrueCounts) -> Result<(), String> {
        let passed = match judgement {
            Judgement::Closest(closest) => self.passes_closest(closest, counts),
            Judgement::Any(any) => self.passes_any(any, counts),
        };
        if passed {
            return Ok(());
        }
        let name = self.description().name;
        Err(format!("control '{name}' scored what it must not over {counts:?}: {judgement:?}"))
    }

    /// Checks what the judge made of the control's surfaces, as [`Control::check`] does of its hits.
    ///
    /// # Errors
    /// What the control scored wrongly; the run is invalid then.
    pub fn check_surfaces(self, judgement: &SurfaceJudgement, counts: &TrueCounts) -> Result<(), String> {
        let SurfaceJudgement { judged, lost, agreement, material, normal, position, .. } = judgement;
        let TrueCounts { hits, misses, .. } = *counts;
        let [missed, invented] = self.wrong(counts);
        let all_right = (hits > missed).then_some(1.0);
        let passed = match self {
            Self::Oracle | Self::Corrupted => {
                *judged == hits - missed
                    && *lost == invented
                    && [*agreement, *material, *position] == [all_right; 3]
                    && normal.is_none_or(|share| share == 1.0)
            }
            Self::AlwaysMiss => *judged + *lost == 0 && agreement.is_none(),
            Self::AlwaysHit => *lost == hits + misses && agreement.is_none_or(|share| share == 0.0),
        };
        if passed {
            return Ok(());
        }
        let name = self.description().name;
        Err(format!("control '{name}' has surfaces that it must not have over {hits} hits: {judgement:?}"))
    }

    fn passes_closest(self, judgement: &ClosestJudgement, counts: &TrueCounts) -> bool {
        let share = |wrong: u64, of: u64| (of > 0).then(|| (of - wrong) as f64 / of as f64);
        let TrueCounts { hits, misses, .. } = *counts;
        let [missed, invented] = self.wrong(counts);
        let [found, passed, lost] = self.ambiguous(counts);
        let right = [hits - missed + found, misses - invented + passed, invented, missed + lost];
        let (agreement, without) = (&judgement.agreement, &judgement.agreement_without_ambiguous);
        let has_footprint = judgement.has_footprint();
        let footprint = has_footprint.then_some(&judgement.classes.footprint);
        let is_same =
            |of: &PerRule<Option<f64>>| of.tight == of.hit_miss && (!has_footprint || of.footprint == of.hit_miss);
        [&judgement.classes.tight].into_iter().chain(footprint).all(|classes| {
            let Classes { true_hit, true_miss, false_hit, false_miss, early, late } = *classes;
            // Always the same t is early or late, or right by chance.
            let found = if self == Self::AlwaysHit { true_hit + early + late } else { true_hit };
            (self == Self::AlwaysHit || early + late == 0) && [found, true_miss, false_hit, false_miss] == right
        }) && agreement.hit_miss == share(invented + missed + lost, right.iter().sum())
            && without.as_ref().is_none_or(|without| without.hit_miss == share(missed + invented, hits + misses))
            && (!self.knows()
                || is_same(agreement)
                    && without.as_ref().is_none_or(is_same)
                    && judgement.identity.is_none_or(|identity| identity == 1.0))
    }

    fn passes_any(self, judgement: &AnyJudgement, counts: &TrueCounts) -> bool {
        let (occluded, free) = (counts.hits, counts.misses);
        let table = &judgement.occlusion;
        let found = [table.true_occluded, table.true_free, table.false_occluded, table.false_free];
        let [missed, invented] = self.wrong(counts);
        let expected = [occluded - missed, free - invented, invented, missed];
        let share = |wrong: u64, of: u64| (of > 0).then(|| (of - wrong) as f64 / of as f64);
        let accuracy = match (share(missed, occluded), share(invented, free)) {
            (Some(one), Some(other)) => Some(f64::midpoint(one, other)),
            (one, other) => one.or(other),
        };
        found == expected && table.balanced_accuracy == accuracy
    }
}

/// Checks what the judge made of a control's hits, wherever they were traced.
///
/// # Errors
/// What the control scored wrongly; the run is invalid then.
pub(crate) fn checked(control: Control, judgement: &Judgement, answers: &[Answer]) -> Result<(), String> {
    control.check(judgement, &true_counts(answers))
}

/// Tracer and structure in one: a control has nothing to build.
#[derive(Clone)]
struct Answering {
    control: Control,
    known: Arc<KnownAnswers>,
    diagonal: f64,
    /// The scene; none before the build.
    geometry: Option<Geometry>,
}

impl Tracer for Answering {
    fn build(
        &self,
        geometry: &Geometry,
        _viewpoint: &Viewpoint,
        _parameters: &Parameters,
        clock: &mut PhaseClock<'_>,
    ) -> Result<Box<dyn Structure>, TracerError> {
        clock.host_phase("nothing", || ());
        Ok(Box::new(Self { geometry: Some(geometry.clone()), ..self.clone() }))
    }
}

impl Answering {
    fn answers(&self, rays: &[Ray], truth: &[Answer]) -> impl Iterator<Item = Hit> {
        let each = rays.iter().zip(truth).zip(corrupted(truth));
        each.map(|((ray, truth), wrong)| self.answer(ray, truth, wrong))
    }

    fn answer(&self, ray: &Ray, truth: &Answer, wrong: bool) -> Hit {
        let hit = |t: f32, primitive: u32| Hit { t, primitive, u: 0.0, v: 0.0, status: Status::Hit as u32 };
        let invented = || hit(ray.t_max.min((self.diagonal / 2.0) as f32), NO_PRIMITIVE);
        match (self.control, truth.hit) {
            (Control::AlwaysHit, _) => invented(),
            (Control::AlwaysMiss, _) => Hit::miss(Status::Miss),
            (Control::Corrupted, None) if wrong => invented(),
            (Control::Corrupted, Some(_)) if wrong => Hit::miss(Status::Miss),
            (Control::Oracle | Control::Corrupted, None) => Hit::miss(Status::Miss),
            (Control::Oracle | Control::Corrupted, Some(truth)) => hit(truth.t as f32, truth.primitive),
        }
    }

    /// The surface that goes with an answer: the oracle's is computed in f64, the others know none.
    fn surface(&self, ray: &Ray, truth: &Answer, hit: &Hit) -> Surface {
        match (self.control, truth.hit, &self.geometry) {
            _ if !hit.is_hit() => Surface::none(SurfaceStatus::NoHit),
            (Control::Oracle | Control::Corrupted, Some(truth), Some(geometry)) => {
                let [a, b, c] = geometry.corners(truth.primitive).map(Vec3::as_dvec3);
                Surface {
                    position: Ray64::from(ray).at(truth.t).as_vec3().into(),
                    material: geometry.triangle_materials[truth.primitive as usize],
                    normal: (b - a).cross(c - a).normalize_or_zero().as_vec3().into(),
                    status: SurfaceStatus::Written as u32,
                }
            }
            _ => Surface::none(SurfaceStatus::Lost),
        }
    }
}

impl Structure for Answering {
    fn update(
        &mut self,
        _update: Update,
        _geometry: &Geometry,
        _viewpoint: &Viewpoint,
        _parameters: &Parameters,
        clock: &mut PhaseClock<'_>,
    ) -> Result<(), TracerError> {
        clock.host_phase("nothing", || ());
        Ok(())
    }

    fn trace(&self, job: TraceJob<'_>, hits: &mut HitBuffer, clock: &mut PhaseClock<'_>) -> Result<(), TracerError> {
        let known = self.known.iter().find(|(rays, _)| Arc::ptr_eq(rays, &job.rays.host));
        let (rays, answers) =
            known.ok_or_else(|| TracerError::Failed("a control was given rays that it does not know".to_owned()))?;
        let of_hits = hits.host_mut(rays.len())?;
        clock.host_phase("answer", || {
            of_hits.iter_mut().zip(self.answers(rays, answers)).for_each(|(hit, answer)| *hit = answer);
        });
        if job.trace_to == TraceTo::Surface {
            let (hits, surfaces) = hits.host_surfaces_mut(rays.len())?;
            clock.host_phase("answer", || {
                for (index, surface) in surfaces.iter_mut().enumerate() {
                    *surface = self.surface(&rays[index], &answers[index], &hits[index]);
                }
            });
        }
        Ok(())
    }

    fn trace_counted(&self, job: TraceJob<'_>, hits: &mut HitBuffer) -> Result<Vec<Counter>, TracerError> {
        self.trace(job, hits, &mut PhaseClock::new(None))?;
        Ok(Vec::new())
    }

    fn memory(&self) -> MemoryReport {
        MemoryReport::default()
    }

    fn validate(&self, _geometry: &Geometry) -> Result<Vec<(&'static str, f64)>, TracerError> {
        Ok(Vec::new())
    }
}
