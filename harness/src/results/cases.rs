//! What a record says of cases: minimal scenes of one difficulty each, and what is expected of each tracer there. What was
//! measured is in the rows ([`super::TracerRun::strength`]); whether it came as expected is derived.

use serde::{Deserialize, Serialize};
use tracebench_api::Query;

use super::{Rule, TracerRecord};

/// The cases of a stability matrix.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CasesRecord {
    /// The cases, each the scene of rows that have its name.
    pub cases: Vec<CaseRecord>,
}

/// A case.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CaseRecord {
    /// Name.
    pub name: String,
    /// What it is.
    pub summary: String,
    /// What makes it harder.
    pub knob: KnobRecord,
    /// What rays must have for the case to measure anything.
    pub feature: String,
    /// Least share of rays that must have it at the hardest strength.
    pub least_featured: f64,
    /// What the case was like at each strength.
    pub strengths: Vec<Strength>,
    /// Why nothing here may be believed: a control failed.
    pub void: Option<String>,
    /// The tracers, in the order of columns.
    pub tracers: Vec<CaseTracer>,
}

/// A knob.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct KnobRecord {
    /// What is turned.
    pub name: String,
    /// Unit; empty for counts and ratios.
    pub unit: String,
    /// Its values from harmless to hard.
    pub values: Vec<f64>,
}

/// A case at one strength.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Strength {
    /// The knob's value.
    pub strength: f64,
    /// Triangles.
    pub triangles: u64,
    /// What is asked.
    pub query: Query,
    /// Width and height of the frame, pixels.
    pub frame: [u32; 2],
    /// Rays.
    pub rays: u64,
    /// Rays that truly hit and are no tie.
    pub true_hits: u64,
    /// Rays that truly miss and are no tie.
    pub true_misses: u64,
    /// Ties.
    pub ties: u64,
    /// Share of the rays that show the difficulty.
    pub featured: f64,
}

/// A tracer on a case.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
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

/// Why a tracer gave no answers at a strength.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct NoAnswer {
    /// The knob's value.
    pub strength: f64,
    /// Why.
    pub error: String,
    /// Whether that is because the device is too small.
    pub refused: bool,
    /// Whether a limit of the device forbids it.
    #[serde(default)]
    pub unavailable: bool,
}

/// What is expected of a tracer on a case.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ExpectationRecord {
    /// `exact`, `bounded` or `known_failure`.
    pub kind: String,
    /// The rule by which rays are wrong.
    pub rule: Rule,
    /// Most wrong rays, share: at every strength, or below `from`.
    pub most_wrong: f64,
    /// The strength from which a known failure fails.
    pub from: Option<f64>,
    /// Least wrong rays of a known failure at the hardest strength, share.
    pub least_wrong: Option<f64>,
    /// The strength from which on a device may be too small.
    pub refusable_from: Option<f64>,
    /// The strength from which on the device's rasterizer loses triangles, by its probe: whatever is wrong there is not the tracer's.
    #[serde(default)]
    pub lost_from: Option<f64>,
    /// Why.
    pub reason: String,
    /// Where that is written.
    pub source: String,
}

/// Shares of wrong rays under the three rules; of any-hit rays the same three times.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wrong {
    /// Hit or miss is wrong.
    pub hit_miss: f64,
    /// Under `tight`.
    pub tight: f64,
    /// Under `footprint`.
    pub footprint: f64,
}

impl Wrong {
    /// The share under a rule.
    pub fn under(&self, rule: Rule) -> f64 {
        match rule {
            Rule::HitMiss => self.hit_miss,
            Rule::Tight => self.tight,
            Rule::Footprint => self.footprint,
        }
    }
}

/// A surprise at one strength.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Surprise {
    /// More rays are wrong than may be.
    Failure {
        /// Share of wrong rays.
        wrong: f64,
        /// The rule.
        rule: Rule,
        /// Most that were allowed, share.
        allowed: f64,
    },
    /// Fewer rays are wrong than a known failure must have.
    Success {
        /// Share of wrong rays.
        wrong: f64,
        /// The rule.
        rule: Rule,
        /// Least that were expected, share.
        expected: f64,
    },
}

impl ExpectationRecord {
    /// Whether a device may be too small at one of a knob's values.
    pub fn may_be_refused(&self, values: &[f64], index: usize) -> bool {
        let from = self.refusable_from.and_then(|from| values.iter().position(|value| *value == from));
        from.is_some_and(|at| index >= at)
    }

    /// Whether the device's rasterizer loses triangles at one of a knob's values.
    pub fn may_be_lost(&self, values: &[f64], index: usize) -> bool {
        let from = self.lost_from.and_then(|from| values.iter().position(|value| *value == from));
        from.is_some_and(|at| index >= at)
    }

    /// What is surprising about the wrong rays at one of a knob's values.
    pub fn surprise(&self, values: &[f64], index: usize, shares: &Wrong) -> Option<Surprise> {
        if self.may_be_lost(values, index) {
            return None;
        }
        let (rule, most) = (self.rule, self.most_wrong);
        let wrong = shares.under(rule);
        let at_most = |allowed: f64| (wrong > allowed).then_some(Surprise::Failure { wrong, rule, allowed });
        let Some((from, least_wrong)) = self.from.zip(self.least_wrong) else { return at_most(most) };
        let first = values.iter().position(|value| *value == from).unwrap_or(0);
        if index < first {
            return at_most(most);
        }
        let expected = if index + 1 == values.len() { least_wrong } else { most };
        (wrong < expected || wrong <= most).then_some(Surprise::Success { wrong, rule, expected })
    }
}
