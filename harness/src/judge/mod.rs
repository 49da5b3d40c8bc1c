//! The judge: every ray one class, by the tracer's own t against the f64 truth.

mod causes;
mod distances;
mod march;
mod scores;
mod sides;
mod surfaces;
mod voxels;

use std::collections::BTreeMap;

use glam::DVec3;
use rayon::prelude::*;
use tracebench_api::{Hit, NO_PRIMITIVE, Query, Ray, SampledImage, Status, Surface, VoxelGrid};

pub use distances::{COMMON_TEXELS, MAX_PIECES};
pub use scores::CURVE_TOLERANCES;
pub use surfaces::NORMAL_TOLERANCE_DEGREES;

use crate::results::{Judgement, TrueCounts, WrongRay};
use crate::truth::{Answer, Ray64, TrueHit, Truth, tight_tolerance};
use voxels::Voxels;

/// Pixels of the common reference camera along its 90 degrees.
pub const REFERENCE_PIXELS: f64 = 1024.0;

/// Share of ambiguous rays above which a set says so.
pub const MANY_AMBIGUOUS: f64 = 1e-3;

/// Wrong rays of each cause that a row keeps where nothing else is said.
pub const WRONG_RAYS_PER_CAUSE: usize = 4;

/// One ray set with its truth, and what a tracer's answers are judged by.
#[derive(Clone, Copy)]
pub struct Judge<'a> {
    /// The scene.
    pub truth: &'a Truth,
    /// The viewpoint's eye: footprints are those of a camera there. Rays without one are not judged by them.
    pub eye: Option<DVec3>,
    /// The rays.
    pub rays: &'a [Ray],
    /// Their truth.
    pub answers: &'a [Answer],
    /// What was asked.
    pub query: Query,
    /// The images that the tracer sees the scene through; empty if it holds the scene itself.
    pub samplings: &'a [SampledImage],
    /// The voxels that it knows the scene by.
    pub voxels: Option<VoxelGrid>,
    /// Whether the tracer names the triangle that it hits.
    pub names_primitives: bool,
    /// How many wrong rays of each cause the judgement keeps, evenly spaced among all of that cause.
    pub wrong_rays_per_cause: usize,
}

/// The class of an answer. For any-hit queries `Early` and `Late` do not occur. An ambiguous closest-hit ray has several true answers: the
/// class is by the one that the answer agrees with, else by the nearest.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Class {
    /// Both hit, t within tolerance.
    TrueHit,
    /// Both miss.
    TrueMiss,
    /// Truth misses.
    FalseHit,
    /// Truth hits.
    FalseMiss,
    /// Both hit, t too small.
    Early,
    /// Both hit, t too large.
    Late,
}

impl Class {
    /// Whether the answer is right.
    pub fn is_right(self) -> bool {
        matches!(self, Self::TrueHit | Self::TrueMiss)
    }

    /// The name in results; for any-hit queries the words of the 2x2 table.
    pub fn name(self, query: Query) -> &'static str {
        match (self, query) {
            (Self::TrueHit, Query::Closest) => "true_hit",
            (Self::TrueMiss, Query::Closest) => "true_miss",
            (Self::FalseHit, Query::Closest) => "false_hit",
            (Self::FalseMiss, Query::Closest) => "false_miss",
            (Self::Early, _) => "early",
            (Self::Late, _) => "late",
            (Self::TrueHit, Query::Any) => "true_occluded",
            (Self::TrueMiss, Query::Any) => "true_free",
            (Self::FalseHit, Query::Any) => "false_occluded",
            (Self::FalseMiss, Query::Any) => "false_free",
        }
    }
}

/// A ray that was answered wrongly: its index, class and cause.
type WrongAnswer = (usize, Class, &'static str);

pub use crate::results::Rule;

/// Answers that no judge can take.
#[derive(Debug, thiserror::Error)]
pub enum JudgeError {
    /// Another number of answers than rays.
    #[error("{hits} answers for {rays} rays")]
    Count {
        /// Answers.
        hits: usize,
        /// Rays.
        rays: usize,
    },
    /// A hit that was never written, has an unknown status, or a t that is no number.
    #[error(
        "{count} answers are not answers (unwritten, unknown status or t not finite); the first is ray {first}: {hit:?}"
    )]
    Malformed {
        /// How many.
        count: usize,
        /// The first.
        first: usize,
        /// Its content.
        hit: Hit,
    },
    /// A surface that was never written, has an unknown status or one that its ray's answer cannot have, or is no number.
    #[error(
        "{count} surfaces are not those of their rays' answers (unwritten, a hit without or a miss with one, not finite); \
         the first is that of ray {first}: {surface:?}"
    )]
    Surface {
        /// How many.
        count: usize,
        /// The first.
        first: usize,
        /// Its content.
        surface: Surface,
    },
}

impl Judge<'_> {
    /// Judges one answer for each ray.
    ///
    /// # Errors
    /// [`JudgeError`] if the answers are not answers.
    pub fn judge(&self, hits: &[Hit]) -> Result<Judgement, JudgeError> {
        self.check(hits)?;
        Ok(match self.query {
            Query::Closest => Judgement::Closest(self.judge_closest(hits)),
            Query::Any => Judgement::Any(self.judge_any(hits)),
        })
    }

    /// The class of every answer under a rule, `None` for ambiguous any-hit rays; of any-hit sets always under `hit_miss`.
    ///
    /// # Errors
    /// [`JudgeError`] if the answers are not answers.
    pub fn classes(&self, rule: Rule, hits: &[Hit]) -> Result<Vec<Option<Class>>, JudgeError> {
        self.check(hits)?;
        let rule = if self.query == Query::Any { Rule::HitMiss } else { rule };
        let class = |index: usize| self.is_judged(index).then(|| self.class(rule, index, &hits[index]));
        Ok((0..hits.len()).into_par_iter().map(class).collect())
    }

    fn check(&self, hits: &[Hit]) -> Result<(), JudgeError> {
        if self.answers.len() != self.rays.len() {
            return Err(JudgeError::Count { hits: hits.len(), rays: self.rays.len() });
        }
        Self::are_answers(self.rays.len(), hits)
    }

    /// That all are answers to so many rays, right or wrong.
    ///
    /// # Errors
    /// [`JudgeError`] if not.
    pub fn are_answers(rays: usize, hits: &[Hit]) -> Result<(), JudgeError> {
        if hits.len() != rays {
            return Err(JudgeError::Count { hits: hits.len(), rays });
        }
        let malformed = |hit: &Hit| match Status::from_code(hit.status) {
            None | Some(Status::Unwritten) => true,
            Some(status) => status.is_hit() && !hit.t.is_finite(),
        };
        match hits.iter().position(malformed) {
            None => Ok(()),
            Some(first) => Err(JudgeError::Malformed {
                count: hits.iter().filter(|hit| malformed(hit)).count(),
                first,
                hit: hits[first],
            }),
        }
    }

    /// The class of one answer under a rule.
    pub fn class(&self, rule: Rule, index: usize, hit: &Hit) -> Class {
        match (self.truth_for(index, hit), hit.is_hit()) {
            (None, false) => Class::TrueMiss,
            (None, true) => Class::FalseHit,
            (Some(_), false) => Class::FalseMiss,
            (Some(truth), true) => {
                let (answer, t) = (&self.answers[index], f64::from(hit.t));
                let agrees = |truth: TrueHit| (t - truth.t).abs() <= self.tolerance(rule, index, truth.t);
                if agrees(truth)
                    || answer.is_ambiguous() && (answer.has_between(t) || answer.all().flatten().any(agrees))
                {
                    Class::TrueHit
                } else if t < truth.t {
                    Class::Early
                } else {
                    Class::Late
                }
            }
        }
    }

    /// What an answer is compared with: the true hit; of an ambiguous ray the nearest of its true hits, or its true miss for a miss.
    pub(super) fn truth_for(&self, index: usize, hit: &Hit) -> Option<TrueHit> {
        let answer = &self.answers[index];
        if !answer.is_ambiguous() || !hit.is_hit() && answer.all().all(|truth| truth.is_some()) {
            return answer.hit;
        }
        let off = |truth: &TrueHit| (f64::from(hit.t) - truth.t).abs();
        answer.all().flatten().filter(|_| hit.is_hit()).min_by(|one, other| off(one).total_cmp(&off(other)))
    }

    fn tolerance(&self, rule: Rule, index: usize, true_t: f64) -> f64 {
        match (rule, self.eye) {
            (Rule::HitMiss, _) => f64::INFINITY,
            (Rule::Footprint, Some(_)) => {
                let ray = Ray64::from(&self.rays[index]);
                // Distance along the ray is t times the direction's length, which is 1 to f32 rounding.
                let pixel = self.footprint(ray.at(true_t)) / ray.direction.length();
                // Close to the eye a pixel shrinks below what a t in f32 can tell.
                pixel.max(f64::from(f32::EPSILON) * true_t)
            }
            (Rule::Tight | Rule::Footprint, _) => tight_tolerance(true_t, self.truth.diagonal()),
        }
    }

    /// Edge of a reference pixel at a point, scene units: 90 degrees span twice the distance. 0 without an eye.
    pub fn footprint(&self, point: DVec3) -> f64 {
        self.eye.map_or(0.0, |eye| 2.0 * point.distance(eye) / REFERENCE_PIXELS)
    }

    /// Whether an answer can be wrong: of ambiguous any-hit rays both are right.
    fn is_judged(&self, index: usize) -> bool {
        self.query == Query::Closest || !self.answers[index].is_ambiguous()
    }

    fn judged(&self) -> impl ParallelIterator<Item = usize> + '_ {
        (0..self.rays.len()).into_par_iter().filter(|index| self.is_judged(*index))
    }

    /// Rays of which one surface alone is right.
    fn unambiguous(&self) -> impl ParallelIterator<Item = usize> + '_ {
        (0..self.rays.len()).into_par_iter().filter(|index| !self.answers[*index].is_ambiguous())
    }

    fn ambiguous(&self) -> (u64, bool) {
        let rays = self.answers.iter().filter(|answer| answer.is_ambiguous()).count();
        (rays as u64, rays as f64 > MANY_AMBIGUOUS * self.rays.len() as f64)
    }

    /// The causes of what is wrong under a rule: by ray, in ray order. `known`: those under another rule, which are the same.
    fn wrong(&self, rule: Rule, hits: &[Hit], known: &[WrongAnswer]) -> Vec<WrongAnswer> {
        let voxels = Voxels::new(self);
        let cause = |index: usize, class| match known.binary_search_by_key(&index, |(known, ..)| *known) {
            Ok(place) => known[place].2,
            Err(_) => self.cause(index, &hits[index], class, voxels.as_ref()),
        };
        self.judged()
            .filter_map(|index| {
                let class = self.class(rule, index, &hits[index]);
                (!class.is_right()).then(|| (index, class, cause(index, class)))
            })
            .collect()
    }

    fn wrong_rays(&self, wrong: &[WrongAnswer], hits: &[Hit]) -> Vec<WrongRay> {
        let mut of_cause = BTreeMap::<&str, Vec<&WrongAnswer>>::new();
        for answer in wrong {
            of_cause.entry(answer.2).or_default().push(answer);
        }
        let spaced = |all: &Vec<&'_ WrongAnswer>| {
            let kept = all.len().min(self.wrong_rays_per_cause);
            (0..kept).map(|position| *all[position * all.len() / kept]).collect::<Vec<_>>()
        };
        let mut kept: Vec<WrongAnswer> = of_cause.values().flat_map(spaced).collect();
        kept.sort_unstable_by_key(|(index, ..)| *index);
        let record = |(index, class, cause): WrongAnswer| {
            let (ray, hit, truth) = (&self.rays[index], &hits[index], self.truth_for(index, &hits[index]));
            let named = |primitive: u32| (primitive != NO_PRIMITIVE).then_some(primitive);
            WrongRay {
                index: index as u64,
                origin: ray.origin,
                direction: ray.direction,
                t_min: ray.t_min,
                t_max: ray.t_max,
                true_t: truth.map(|hit| hit.t),
                true_primitive: truth.map(|hit| hit.primitive),
                answered_t: hit.is_hit().then_some(hit.t),
                answered_primitive: if hit.is_hit() { named(hit.primitive) } else { None },
                status: Status::from_code(hit.status).unwrap_or(Status::Unwritten).name().to_owned(),
                class: class.name(self.query).to_owned(),
                cause: cause.to_owned(),
                ambiguous: self.answers[index].is_ambiguous(),
            }
        };
        kept.into_iter().map(record).collect()
    }
}

/// What the truth says of rays.
pub fn true_counts(answers: &[Answer]) -> TrueCounts {
    let count = |ambiguous: bool, is: fn(&Answer) -> bool| {
        answers.iter().filter(|answer| answer.is_ambiguous() == ambiguous && is(answer)).count() as u64
    };
    TrueCounts {
        hits: count(false, |answer| answer.hit.is_some()),
        misses: count(false, |answer| answer.hit.is_none()),
        ambiguous_hits: count(true, |answer| answer.hit.is_some()),
        ambiguous_misses: count(true, |answer| answer.hit.is_none()),
        ambiguous_may_miss: count(true, |answer| answer.all().any(|truth| truth.is_none())),
    }
}

fn count_causes(wrong: &[WrongAnswer]) -> BTreeMap<String, u64> {
    let mut counts = BTreeMap::new();
    for (_, _, cause) in wrong {
        *counts.entry((*cause).to_owned()).or_insert(0) += 1;
    }
    counts
}
