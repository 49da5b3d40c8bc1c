//! The judge's verdicts in `run.json`.

use std::collections::BTreeMap;

use serde::{Deserialize, Deserializer, Serialize, de};
use tracebench_api::{Query, named};

use crate::statistics::percentile;

named! {
    /// A rule by which t is judged.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
    #[serde(rename_all = "snake_case")]
    pub enum Rule {
        /// Only hit or miss.
        HitMiss = "hit_miss",
        /// |t - t*| <= 1e-4 t* + 1e-6 diagonal.
        Tight = "tight",
        /// Hit point within one pixel of the common reference camera.
        Footprint = "footprint",
    }
}

/// The verdict on one ray set.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
#[expect(clippy::large_enum_variant, reason = "a few dozen exist at a time")]
pub enum Judgement {
    /// On a closest-hit set.
    Closest(ClosestJudgement),
    /// On an any-hit set.
    Any(AnyJudgement),
}

impl<'de> Deserialize<'de> for Judgement {
    /// By its table: so that it is said what is wrong in it, and not that it is neither.
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let value = serde_json::Value::deserialize(deserializer)?;
        let judged = match value.get("occlusion") {
            Some(_) => AnyJudgement::deserialize(value).map(Self::Any),
            None => ClosestJudgement::deserialize(value).map(Self::Closest),
        };
        judged.map_err(de::Error::custom)
    }
}

/// What both kinds of verdicts have.
macro_rules! of_either {
    ($judgement:expr, $one:ident => $what:expr) => {
        match $judgement {
            Judgement::Closest($one) => $what,
            Judgement::Any($one) => $what,
        }
    };
}

impl Judgement {
    /// Ambiguous rays.
    pub fn ambiguous(&self) -> u64 {
        of_either!(self, one => one.ambiguous_rays)
    }

    /// Whether they exceed 1e-3 of the set.
    pub fn has_many_ambiguous(&self) -> bool {
        of_either!(self, one => one.many_ambiguous_rays)
    }

    /// Whether ambiguous rays are in its shares.
    pub fn has_ambiguous(&self) -> bool {
        matches!(self, Self::Closest(closest) if closest.truth.is_some())
    }

    /// Rays that are in no share.
    pub fn left_out(&self) -> u64 {
        match self {
            Self::Closest(closest) => closest.left_out(),
            Self::Any(any) => any.ambiguous_rays,
        }
    }

    /// The wrong rays that are kept.
    pub fn wrong_rays(&self) -> &[WrongRay] {
        of_either!(self, one => &one.wrong_rays)
    }

    /// The same, to be changed.
    pub fn wrong_rays_mut(&mut self) -> &mut Vec<WrongRay> {
        of_either!(self, one => &mut one.wrong_rays)
    }

    /// Why shares of right answers say nothing, where truth leaves a tracer that never hits, or always, nothing to get wrong: no ray
    /// hits anything, or no ray of an any-hit set misses everything.
    pub fn one_sided(&self) -> Option<&'static str> {
        let [hits, misses] = self.true_hits_and_misses();
        one_sided(if matches!(self, Self::Any(_)) { Query::Any } else { Query::Closest }, hits, misses)
    }

    /// Rays that truly hit and that truly miss, of those that have a class.
    pub fn true_hits_and_misses(&self) -> [u64; 2] {
        match self {
            Self::Closest(ClosestJudgement { classes: ByRule { tight, .. }, .. }) => {
                [tight.true_hit + tight.false_miss + tight.early + tight.late, tight.true_miss + tight.false_hit]
            }
            Self::Any(AnyJudgement { occlusion: of, .. }) => {
                [of.true_occluded + of.false_free, of.true_free + of.false_occluded]
            }
        }
    }

    /// How often its answers are right by every rule, on so many rays that count.
    pub fn accuracies(&self, trials: u64) -> Vec<Accuracy> {
        let one_sided = self.one_sided();
        match self {
            Self::Closest(closest) => {
                let (share, interval) = (&closest.agreement, &closest.interval);
                let (tight, footprint) = (&closest.classes.tight, &closest.classes.footprint);
                let of = |share: Option<f64>, interval, wrong| Accuracy { share, interval, wrong, trials, one_sided };
                vec![
                    of(share.hit_miss, interval.hit_miss, tight.false_hit + tight.false_miss),
                    of(share.tight, interval.tight, tight.wrong()),
                    of(share.footprint, interval.footprint, footprint.wrong()),
                ]
            }
            Self::Any(AnyJudgement { occlusion, .. }) => vec![Accuracy {
                share: occlusion.balanced_accuracy,
                interval: occlusion.balanced_accuracy_interval,
                wrong: occlusion.false_occluded + occlusion.false_free,
                trials,
                one_sided,
            }],
        }
    }

    /// Right answers by the status that the tracer gave; none in records from before they were counted.
    pub fn by_status(&self) -> &BTreeMap<String, StatusCounts> {
        of_either!(self, one => &one.by_status)
    }

    /// Why rays are wrong.
    pub fn causes(&self) -> &Causes {
        of_either!(self, one => &one.causes)
    }
}

/// A share of right answers; nothing where no ray is judged.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Accuracy {
    /// The share.
    pub share: Option<f64>,
    /// Its interval.
    pub interval: Option<[f64; 2]>,
    /// Wrong answers.
    pub wrong: u64,
    /// All that count.
    pub trials: u64,
    /// Why the share says nothing, if it does not.
    pub one_sided: Option<&'static str>,
}

/// As [`Judgement::one_sided`], of so many rays that hit and that miss.
pub(crate) fn one_sided(query: Query, hits: u64, misses: u64) -> Option<&'static str> {
    match (hits, misses) {
        (0, 1..) => Some("no ray hits anything"),
        (1.., 0) if query == Query::Any => Some("no ray misses everything"),
        _ => None,
    }
}

/// What the causes of an any-hit set stand under, which has no rules.
pub const OCCLUSION: &str = "occlusion";

/// Counts of causes by rule: rule -> cause -> rays.
pub type Causes = BTreeMap<String, BTreeMap<String, u64>>;

/// How often the answers of one status are right.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct StatusCounts {
    /// Judged rays that ended with it.
    pub rays: u64,
    /// Those that are right, by rule; of an any-hit set by `occlusion`.
    pub right: BTreeMap<String, u64>,
}

records! {
    /// The verdict on a closest-hit set.
    pub struct ClosestJudgement {
        /// Class counts under the two rules that look at t.
        pub classes: ByRule<Classes>,
        /// Ambiguous rays, whose truth depends on rounding.
        pub ambiguous_rays: u64,
        /// Whether they exceed 1e-3 of the set.
        pub many_ambiguous_rays: bool,
        /// Shares of right answers among all rays; `None` without rays. Records without `truth` leave ambiguous rays out.
        pub agreement: PerRule<Option<f64>>,
        /// The same shares without ambiguous rays; `None` if all are ambiguous.
        pub agreement_without_ambiguous: Option<PerRule<Option<f64>>> = default,
        /// What the truth says of the rays; `None` in records whose classes and shares leave ambiguous rays out.
        pub truth: Option<TrueCounts> = default,
        /// 95 % Wilson intervals of the agreements.
        pub interval: PerRule<Option<[f64; 2]>>,
        /// Pairs of tolerance (in scene diagonals) and agreement.
        pub curve: Vec<[f64; 2]>,
        /// |t - t*| of the rays that are rightly said to hit, scene units; of ambiguous ones from the nearest true hit.
        pub position_error: Percentiles,
        /// How far told hits are from the piece of mesh that is truly hit; `None` in records from before it was told.
        pub surface_distance: Option<SurfaceDistance> = default,
        /// Share of `tight` true hits that name the right triangle; `None` if the method names none.
        pub identity: Option<f64>,
        /// Right answers by the status that the tracer gave; empty in records from before they were counted.
        pub by_status: BTreeMap<String, StatusCounts> = default,
        /// Why rays are wrong, under `tight` and `footprint`.
        pub causes: Causes,
        /// Wrong rays under `tight`: of each cause at most four or as many as were asked for, evenly spaced; none of a control.
        pub wrong_rays: Vec<WrongRay>,
    }

    /// The verdict on an any-hit set.
    #[derive(Default)]
    pub struct AnyJudgement {
        /// The 2x2 table.
        pub occlusion: Occlusion,
        /// Ambiguous rays: either answer is right, so they are in no count.
        pub ambiguous_rays: u64,
        /// Whether they exceed 1e-3 of the set.
        pub many_ambiguous_rays: bool,
        /// As in [`ClosestJudgement`].
        pub by_status: BTreeMap<String, StatusCounts> = default,
        /// Why rays are wrong, under `occlusion`.
        pub causes: Causes,
        /// Wrong rays: of each cause at most four or as many as were asked for, evenly spaced; none of a control.
        pub wrong_rays: Vec<WrongRay>,
    }

    /// A ray that was answered wrongly.
    pub struct WrongRay {
        /// Its index in the set.
        pub index: u64,
        /// Origin.
        pub origin: [f32; 3],
        /// Direction.
        pub direction: [f32; 3],
        /// Least t.
        pub t_min: f32,
        /// Greatest t.
        pub t_max: f32,
        /// Truth: t, `None` for a miss; of an ambiguous ray the nearest true one.
        pub true_t: Option<f64>,
        /// Truth: triangle.
        pub true_primitive: Option<u32>,
        /// Answer: t, `None` for a miss.
        pub answered_t: Option<f32>,
        /// Answer: triangle, where named.
        pub answered_primitive: Option<u32>,
        /// Status of the answer.
        pub status: String,
        /// Class of the answer.
        pub class: String,
        /// Cause of the error.
        pub cause: String,
        /// Whether the ray is ambiguous.
        pub ambiguous: bool = default,
    }
}

impl ClosestJudgement {
    /// Rays that are in no share: the ambiguous ones of older records.
    pub fn left_out(&self) -> u64 {
        if self.truth.is_some() { 0 } else { self.ambiguous_rays }
    }

    /// The same of rays without an eye, of which no camera tells the size of a pixel.
    #[must_use]
    pub(crate) fn without_footprint(mut self) -> Self {
        self.classes.footprint = Classes::default();
        self.agreement.footprint = None;
        self.interval.footprint = None;
        if let Some(without) = &mut self.agreement_without_ambiguous {
            without.footprint = None;
        }
        self.causes.remove(Rule::Footprint.name());
        self
    }

    /// Whether `footprint` is judged, where anything is.
    pub(crate) fn has_footprint(&self) -> bool {
        self.agreement.footprint.is_some() || self.agreement.tight.is_none()
    }
}

/// What the truth says of a set's rays: a property of rays and scene, whoever traces them.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct TrueCounts {
    /// Rays that hit and are not ambiguous.
    pub hits: u64,
    /// Rays that miss and are not ambiguous.
    pub misses: u64,
    /// Ambiguous rays that hit themselves.
    pub ambiguous_hits: u64,
    /// Ambiguous rays that miss themselves.
    pub ambiguous_misses: u64,
    /// Ambiguous rays that miss, themselves or moved.
    pub ambiguous_may_miss: u64,
}

/// How far told hits are from the nearest point of the connected piece of mesh that the true hit lies on.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SurfaceDistance {
    /// Rays with a true hit, without ambiguous ones.
    pub rays: u64,
    /// The longest edge of the scene's bounds over 1280, scene units.
    pub common_texel: f64,
    /// Share of the rays that are told a hit within a common texel of the piece; a miss is not. `None` without rays.
    pub within_common_texel: Option<f64>,
    /// The greatest edge of a texel of the tracer's images along axes, scene units; `None` of tracers without.
    pub own_texel: Option<f64>,
    /// The share within such a texel.
    pub within_own_texel: Option<f64>,
    /// Of the rays that are told a hit, scene units.
    pub distance: Percentiles,
    /// The pieces with the most rays, at most 16.
    pub pieces: Vec<PieceDistance>,
}

/// The same of one piece of mesh.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PieceDistance {
    /// Its number, by lowest triangles.
    pub piece: u32,
    /// Its lowest triangle.
    pub first_triangle: u32,
    /// Its triangles.
    pub triangles: u64,
    /// Whether it has an edge of an odd number of triangles, so that it bounds no inside.
    pub open: bool,
    /// Of closed pieces twice the volume over the area, scene units: the thickness of a wall.
    pub mean_thickness: Option<f64>,
    /// Rays whose true hit lies on it.
    pub rays: u64,
    /// Those that are told a hit within a common texel of it.
    pub within_common_texel_rays: u64,
    /// Those within a texel of the tracer's own.
    pub within_own_texel_rays: Option<u64>,
}

/// A value for each rule that looks at t.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ByRule<T> {
    /// |t - t*| <= 1e-4 t* + 1e-6 diagonal.
    pub tight: T,
    /// Within one pixel of the common reference camera.
    pub footprint: T,
}

/// A value for each headline rule.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PerRule<T> {
    /// Only hit or miss must be right.
    pub hit_miss: T,
    /// See [`ByRule::tight`].
    pub tight: T,
    /// See [`ByRule::footprint`].
    pub footprint: T,
}

impl<T: Copy> PerRule<T> {
    /// The value under a rule.
    pub fn under(&self, rule: Rule) -> T {
        match rule {
            Rule::HitMiss => self.hit_miss,
            Rule::Tight => self.tight,
            Rule::Footprint => self.footprint,
        }
    }
}

impl<T> From<[T; 3]> for PerRule<T> {
    fn from([hit_miss, tight, footprint]: [T; 3]) -> Self {
        Self { hit_miss, tight, footprint }
    }
}

/// Class counts.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Classes {
    /// Both hit, t within tolerance.
    pub true_hit: u64,
    /// Both miss.
    pub true_miss: u64,
    /// Truth misses.
    pub false_hit: u64,
    /// Truth hits.
    pub false_miss: u64,
    /// Both hit, t too small.
    pub early: u64,
    /// Both hit, t too large.
    pub late: u64,
}

impl Classes {
    /// All rays that have a class.
    pub fn all(&self) -> u64 {
        self.true_hit + self.true_miss + self.wrong()
    }

    /// Wrong rays.
    pub fn wrong(&self) -> u64 {
        self.false_hit + self.false_miss + self.early + self.late
    }
}

/// The 2x2 table of an any-hit set.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Occlusion {
    /// Rightly occluded.
    pub true_occluded: u64,
    /// Rightly free.
    pub true_free: u64,
    /// Truth is free.
    pub false_occluded: u64,
    /// Truth is occluded.
    pub false_free: u64,
    /// Mean of the shares of right answers among occluded and among free rays; where truth has only one of the two, the
    /// share of that one; `None` if every ray is ambiguous.
    pub balanced_accuracy: Option<f64>,
    /// 95 % interval of the balanced accuracy, from the Wilson intervals of its two shares.
    pub balanced_accuracy_interval: Option<[f64; 2]>,
}

/// Percentiles, `None` without a single value.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Percentiles {
    /// Median.
    pub p50: Option<f64>,
    /// 95th percentile.
    pub p95: Option<f64>,
    /// 99th percentile.
    pub p99: Option<f64>,
}

impl Percentiles {
    /// Of values in any order.
    pub fn of(values: &[f64]) -> Self {
        let [p50, p95, p99] = [50.0, 95.0, 99.0].map(|share| percentile(values, share));
        Self { p50, p95, p99 }
    }
}

/// The verdict on a ray set's surfaces.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SurfaceJudgement {
    /// Rays whose surfaces were judged: true hits under `footprint`, of an any-hit set the rightly occluded rays;
    /// without ambiguous rays.
    pub judged: u64,
    /// Hits, judged or not, whose surfaces the tracer did not find; without ambiguous rays.
    pub lost: u64,
    /// Share of the judged whose surface was found and is right: its position within a pixel of the common reference camera,
    /// its normal within a degree, its material. `None` if none was judged.
    pub agreement: Option<f64>,
    /// 95 % Wilson interval of the agreement.
    pub interval: Option<[f64; 2]>,
    /// Of the judged surfaces that were found the share with the right material; `None` where none is known to be right.
    pub material: Option<f64>,
    /// The share whose normal is off by no more than a degree.
    pub normal: Option<f64>,
    /// The share whose position is off by no more than a pixel.
    pub position: Option<f64>,
    /// Angles between normals and the triangles' own, degrees.
    pub normal_error_degrees: Percentiles,
    /// Distances from the point that was truly hit, of an any-hit set from the ray's point at the answered t, scene units.
    pub position_error: Percentiles,
}
