//! What a record says of cases: minimal scenes of one difficulty each, and what is expected of each tracer there. What was
//! measured is in the rows ([`super::Row::difficulty_level`]); whether it came as expected is derived.

use serde::{Deserialize, Serialize};
use tracebench_api::Query;

use super::{PerRule, Rule, TracerRecord};

records! {
    /// The cases of a stability matrix.
    pub struct CasesRecord {
        /// The cases, each the scene of rows that have its name.
        pub cases: Vec<CaseRecord>,
    }

    /// A case.
    pub struct CaseRecord {
        /// Name.
        pub name: String,
        /// What it is.
        pub summary: String,
        /// What makes it harder.
        pub difficulty_parameter: DifficultyParameterRecord,
        /// What rays must have for the case to measure anything.
        pub feature: String,
        /// Least share of rays that must have it at the hardest difficulty level.
        pub min_featured: f64,
        /// What the case was like at each difficulty level.
        pub difficulty_levels: Vec<DifficultyLevel>,
        /// Why nothing here may be believed: a control failed.
        pub invalid: Option<String>,
        /// The tracers, in the order of columns.
        pub tracers: Vec<CaseTracer>,
    }

    /// A difficulty parameter.
    pub struct DifficultyParameterRecord {
        /// What is turned.
        pub name: String,
        /// Unit; empty for counts and ratios.
        pub unit: String,
        /// Its values from harmless to hard.
        pub values: Vec<f64>,
    }

    /// A case at one difficulty level.
    pub struct DifficultyLevel {
        /// The difficulty parameter's value.
        pub difficulty_level: f64,
        /// Triangles.
        pub triangles: u64,
        /// What is asked.
        pub query: Query,
        /// Width and height of the frame, pixels.
        pub frame: [u32; 2],
        /// Rays.
        pub rays: u64,
        /// Rays that truly hit and are not ambiguous.
        pub true_hits: u64,
        /// Rays that truly miss and are not ambiguous.
        pub true_misses: u64,
        /// Ambiguous rays.
        pub ambiguous_rays: u64,
        /// Share of the rays that show the difficulty.
        pub featured: f64,
    }

    /// A tracer on a case.
    pub struct CaseTracer {
        /// The tracer.
        pub tracer: TracerRecord,
        /// What is expected of it; `None` if nothing is stated.
        pub expectation: Option<ExpectationRecord>,
        /// Whether this machine cannot run it; the reason stands with what was skipped.
        pub unavailable: bool,
        /// Where it gave no answers.
        pub no_answers: Vec<NoAnswer>,
    }

    /// Why a tracer gave no answers at a difficulty level.
    pub struct NoAnswer {
        /// The difficulty parameter's value.
        pub difficulty_level: f64,
        /// Why.
        pub error: String,
        /// Whether that is because the device is too small.
        pub refused: bool,
        /// Whether a limit of the device forbids it.
        #[serde(default)]
        pub unavailable: bool,
        /// Whether the method does not serve such rays.
        pub unserved: bool = default,
    }

    /// What is expected of a tracer on a case.
    pub struct ExpectationRecord {
        /// What kind of answers.
        pub kind: ExpectationKind,
        /// The rule by which rays are wrong.
        pub rule: Rule,
        /// The share of wrong rays at each of the difficulty parameter's values, as measured before; `None` where there were no answers. Empty
        /// of what is exact, and in records of before every difficulty level had its share.
        #[serde(default)]
        pub wrong_shares: Vec<Option<f64>>,
        /// What the device's rasterizer adds to the room on both sides of these, share.
        #[serde(default)]
        pub rasterizer_tolerance: f64,
        /// The difficulty level from which on a device may be too small.
        pub refusable_from: Option<f64>,
        /// The difficulty level from which on the device's rasterizer loses triangles, by its probe: whatever is wrong there is not the
        /// tracer's.
        pub lost_from: Option<f64>,
        /// Why.
        pub reason: String,
        /// Where that is written.
        pub source: String,
    }
}

/// What kind of answers are expected.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ExpectationKind {
    /// No wrong ray.
    Exact,
    /// The method can do it, and few rays are wrong.
    Bounded,
    /// The method cannot do it.
    KnownFailure,
    /// None at all: the method does not serve such rays.
    Unserved,
}

impl ExpectationKind {
    /// Whether it is stated how many rays are wrong.
    pub fn has_shares(self) -> bool {
        matches!(self, Self::Bounded | Self::KnownFailure)
    }
}

/// Room to both sides of an expected share: so much at least, share of all rays, and such a part of the share.
const MIN_ROOM: f64 = 0.01;
const ROOM_SHARE: f64 = 1.0 / 3.0;

/// Shares of wrong rays; of any-hit rays the same three times.
pub type Wrong = PerRule<f64>;

/// A surprise at one difficulty level: the share of wrong rays, the rule by which they are, and what was expected.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum UnexpectedOutcome {
    /// More rays are wrong than may be, a share at most.
    Failure(f64, Rule, f64),
    /// Fewer rays are wrong than must be, a share at least: what is stated is out of date.
    Success(f64, Rule, f64),
}

impl ExpectationRecord {
    /// Whether a device may be too small at one of a difficulty parameter's values.
    pub fn may_be_refused(&self, values: &[f64], index: usize) -> bool {
        is_from(self.refusable_from, values, index)
    }

    /// Whether the device's rasterizer loses triangles at one of a difficulty parameter's values.
    pub fn may_be_lost(&self, values: &[f64], index: usize) -> bool {
        is_from(self.lost_from, values, index)
    }

    /// The share of wrong rays that is expected at one of a difficulty parameter's values; `None` if none is stated.
    pub fn expected_share(&self, index: usize) -> Option<f64> {
        if self.kind == ExpectationKind::Exact { Some(0.0) } else { self.wrong_shares.get(index).copied().flatten() }
    }

    /// What is surprising about the wrong rays at one of a difficulty parameter's values.
    pub fn unexpected_outcome(&self, values: &[f64], index: usize, shares: &Wrong) -> Option<UnexpectedOutcome> {
        let expected = self.expected_share(index).filter(|_| !self.may_be_lost(values, index))?;
        let own_room = if self.kind == ExpectationKind::Exact { 0.0 } else { MIN_ROOM.max(expected * ROOM_SHARE) };
        let (rule, wrong, room) = (self.rule, shares.under(self.rule), own_room + self.rasterizer_tolerance);
        let (least, allowed) = (expected - room, expected + room);
        let failure = (wrong > allowed).then_some(UnexpectedOutcome::Failure(wrong, rule, allowed));
        failure.or((wrong < least).then_some(UnexpectedOutcome::Success(wrong, rule, least)))
    }
}

/// Whether a value's place is that of another one or behind it.
fn is_from(from: Option<f64>, values: &[f64], index: usize) -> bool {
    from.and_then(|from| values.iter().position(|value| *value == from)).is_some_and(|at| index >= at)
}
