//! The controls that bracket every scale: one that knows the truth, one that always misses, one that always hits.

use std::sync::Arc;

use glam::Vec3;
use tracebench_api::{
    Counter, Description, EndPoint, Geometry, Hit, HitBuffer, MemoryReport, NO_PRIMITIVE, Parameters, PhaseClock,
    Query, Ray, Residency, Status, Structure, Surface, SurfaceStatus, TraceJob, Tracer, TracerError, Update, Viewpoint,
};

use crate::results::{AnyJudgement, Classes, ClosestJudgement, Judgement, SurfaceJudgement};
use crate::truth::{Answer, Ray64};

/// A control.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Control {
    /// Answers the truth; its agreements must be 1.
    Oracle,
    /// Never hits.
    AlwaysMiss,
    /// Always hits.
    AlwaysHit,
}

/// A ray set with its truth: what the oracle answers from.
pub type KnownAnswers = Vec<(Arc<Vec<Ray>>, Arc<Vec<Answer>>)>;

impl Control {
    /// Every control.
    pub const ALL: [Control; 3] = [Self::Oracle, Self::AlwaysMiss, Self::AlwaysHit];

    /// What it is.
    pub fn description(self) -> Description {
        let (name, summary) = match self {
            Self::Oracle => ("oracle", "answers the ground truth: must score 1"),
            Self::AlwaysMiss => ("always-miss", "never hits: scores the share of rays that miss"),
            Self::AlwaysHit => ("always-hit", "always hits, half the scene's diagonal away"),
        };
        Description {
            name,
            citation: "",
            summary,
            residency: Residency::Host,
            invalidated_by: &[],
            names_primitives: self == Self::Oracle,
            ends: &EndPoint::ALL,
            queries: &Query::ALL,
            no_refit: None,
            parameters: Vec::new(),
            layouts: Vec::new(),
        }
    }

    /// As a tracer, with the truth of every ray set that it will be given.
    pub fn tracer(self, known: KnownAnswers, diagonal: f64) -> Box<dyn Tracer> {
        Box::new(Answering { control: self, known: Arc::new(known), diagonal, geometry: None })
    }

    /// Checks what the judge made of the control. `occluded` and `free` are the numbers of rays, without ties, that
    /// truth says hit and miss.
    ///
    /// # Errors
    /// What the control scored wrongly; the run is void then.
    pub fn check(self, judgement: &Judgement, occluded: u64, free: u64) -> Result<(), String> {
        let passed = match judgement {
            Judgement::Closest(closest) => self.passes_closest(closest, occluded, free),
            Judgement::Any(any) => self.passes_any(any, occluded, free),
        };
        if passed {
            return Ok(());
        }
        let name = self.description().name;
        Err(format!("control '{name}' scored what it must not over {occluded} hits and {free} misses: {judgement:?}"))
    }

    /// Checks what the judge made of the control's surfaces, as [`Control::check`] does of its hits.
    ///
    /// # Errors
    /// What the control scored wrongly; the run is void then.
    pub fn check_surfaces(self, judgement: &SurfaceJudgement, occluded: u64, free: u64) -> Result<(), String> {
        let SurfaceJudgement { judged, lost, agreement, material, normal, position, .. } = judgement;
        let all_right = (occluded > 0).then_some(1.0);
        let passed = match self {
            Self::Oracle => {
                *judged == occluded
                    && *lost == 0
                    && [*agreement, *material, *position] == [all_right; 3]
                    && normal.is_none_or(|share| share == 1.0)
            }
            Self::AlwaysMiss => *judged + *lost == 0 && agreement.is_none(),
            Self::AlwaysHit => *lost == occluded + free && agreement.is_none_or(|share| share == 0.0),
        };
        if passed {
            return Ok(());
        }
        let name = self.description().name;
        Err(format!("control '{name}' has surfaces that it must not have over {occluded} hits: {judgement:?}"))
    }

    fn passes_closest(self, judgement: &ClosestJudgement, occluded: u64, free: u64) -> bool {
        let share = |right: u64| (occluded + free > 0).then(|| right as f64 / (occluded + free) as f64);
        let agreement = &judgement.agreement;
        [&judgement.classes.tight, &judgement.classes.footprint].into_iter().all(|classes| {
            let Classes { true_hit, true_miss, false_hit, false_miss, early, late } = *classes;
            match self {
                Self::Oracle => true_hit == occluded && true_miss == free && false_hit + false_miss + early + late == 0,
                Self::AlwaysMiss => {
                    true_miss == free && false_miss == occluded && true_hit + false_hit + early + late == 0
                }
                Self::AlwaysHit => {
                    false_hit == free && true_hit + early + late == occluded && true_miss + false_miss == 0
                }
            }
        }) && match self {
            Self::Oracle => {
                let whole = share(occluded + free);
                [agreement.hit_miss, agreement.tight, agreement.footprint].into_iter().all(|each| each == whole)
                    && judgement.identity.is_none_or(|identity| identity == 1.0)
            }
            Self::AlwaysMiss => agreement.hit_miss == share(free),
            Self::AlwaysHit => agreement.hit_miss == share(occluded),
        }
    }

    fn passes_any(self, judgement: &AnyJudgement, occluded: u64, free: u64) -> bool {
        let table = &judgement.occlusion;
        let found = [table.true_occluded, table.true_free, table.false_occluded, table.false_free];
        let expected = match self {
            Self::Oracle => [occluded, free, 0, 0],
            Self::AlwaysMiss => [0, free, 0, occluded],
            Self::AlwaysHit => [occluded, 0, free, 0],
        };
        let accuracy = match (self, occluded > 0, free > 0) {
            (_, false, false) => None,
            (Self::Oracle, ..) | (Self::AlwaysMiss, false, true) | (Self::AlwaysHit, true, false) => Some(1.0),
            (_, true, true) => Some(0.5),
            _ => Some(0.0),
        };
        found == expected && table.balanced_accuracy == accuracy
    }
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
    fn answer(&self, ray: &Ray, truth: &Answer) -> Hit {
        let hit = |t: f32, primitive: u32| Hit { t, primitive, u: 0.0, v: 0.0, status: Status::Hit as u32 };
        match (self.control, truth.hit) {
            (Control::AlwaysMiss, _) | (Control::Oracle, None) => Hit::miss(Status::Miss),
            (Control::Oracle, Some(truth)) => hit(truth.t as f32, truth.primitive),
            (Control::AlwaysHit, _) => hit(ray.t_max.min((self.diagonal / 2.0) as f32), NO_PRIMITIVE),
        }
    }
}

impl Answering {
    /// The surface that goes with an answer: the oracle's is computed in f64, the others know none.
    fn surface(&self, ray: &Ray, truth: &Answer, hit: &Hit) -> Surface {
        match (self.control, truth.hit, &self.geometry) {
            _ if !hit.is_hit() => Surface::none(SurfaceStatus::NoHit),
            (Control::Oracle, Some(truth), Some(geometry)) => {
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
        _clock: &mut PhaseClock<'_>,
    ) -> Result<(), TracerError> {
        Ok(())
    }

    fn trace(&self, job: TraceJob<'_>, hits: &mut HitBuffer, clock: &mut PhaseClock<'_>) -> Result<(), TracerError> {
        let known = self.known.iter().find(|(rays, _)| Arc::ptr_eq(rays, &job.rays.host));
        let (rays, answers) =
            known.ok_or_else(|| TracerError::Failed("a control was given rays that it does not know".to_owned()))?;
        let of_hits = hits.host_mut(rays.len())?;
        clock.host_phase("answer", || {
            for ((hit, ray), truth) in of_hits.iter_mut().zip(rays.iter()).zip(answers.iter()) {
                *hit = self.answer(ray, truth);
            }
        });
        if job.end == EndPoint::Surface {
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
