//! `stability.json`: everything that a run of the cases found. Table and chart derive from it.

use serde::Serialize;
use tracebench_api::{Query, TracerError};

use super::Verdict;
use crate::cases::Knob;
use crate::contenders::Expectation;
use crate::contenders::expectation::Wrong;
use crate::results::{AnyJudgement, ByRule, Causes, Classes, Judgement, Occlusion, Provenance, Skipped};
use crate::session::SessionError;

/// The schema that this program writes.
pub const SCHEMA: u32 = 1;

/// A run of cases.
#[derive(Clone, Debug, Serialize)]
pub struct Stability {
    /// [`SCHEMA`].
    pub schema: u32,
    /// Where, by which program and when; its fields stand among these.
    #[serde(flatten)]
    pub provenance: Provenance,
    /// Whether verdicts count: no parameter was changed.
    pub counts: bool,
    /// The cases.
    pub cases: Vec<CaseRecord>,
    /// Tracers that did not run, and why.
    pub skipped: Vec<Skipped>,
}

impl Stability {
    /// What came otherwise than expected: case, tracer, what.
    pub fn surprises(&self) -> Vec<String> {
        let mut surprises = Vec::new();
        for case in &self.cases {
            surprises.extend(case.void.iter().map(|reason| format!("{}: void, {reason}", case.name)));
            let cells = case.tracers.iter().filter(|cell| cell.verdict.is_unexpected());
            surprises.extend(cells.map(|cell| format!("{}, {}: {}", case.name, cell.tracer, cell.text)));
        }
        surprises
    }

    /// Labels of the tracers, in the order of columns.
    pub fn tracers(&self) -> Vec<String> {
        let cells = self.cases.first().map_or(&[][..], |case| &case.tracers);
        cells.iter().map(|cell| cell.tracer.clone()).collect()
    }
}

/// A case.
#[derive(Clone, Debug, Serialize)]
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
    /// The tracers.
    pub tracers: Vec<Cell>,
}

/// A knob.
#[derive(Clone, Debug, Serialize)]
pub struct KnobRecord {
    /// What is turned.
    pub name: String,
    /// Unit; empty for counts and ratios.
    pub unit: String,
    /// Its values from harmless to hard.
    pub values: Vec<f64>,
}

impl From<&Knob> for KnobRecord {
    fn from(knob: &Knob) -> Self {
        Self { name: knob.name.to_owned(), unit: knob.unit.to_owned(), values: knob.values.to_vec() }
    }
}

/// A case at one strength.
#[derive(Clone, Debug, Serialize)]
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
#[derive(Clone, Debug, Serialize)]
pub struct Cell {
    /// The tracer's label.
    pub tracer: String,
    /// What is expected of it; `None` if nothing is stated.
    pub expectation: Option<ExpectationRecord>,
    /// What came of it over all strengths.
    pub verdict: Verdict,
    /// The verdict in words.
    pub text: String,
    /// What was measured at each strength.
    pub measured: Vec<Measured>,
}

/// An expectation.
#[derive(Clone, Debug, Serialize)]
pub struct ExpectationRecord {
    /// `exact`, `bounded` or `known_failure`.
    pub kind: &'static str,
    /// The rule by which rays are wrong.
    pub rule: &'static str,
    /// Most wrong rays, share: at every strength, or below `from`.
    pub most_wrong: f64,
    /// The strength from which a known failure fails.
    pub from: Option<f64>,
    /// Least wrong rays of a known failure at the hardest strength, share.
    pub least_wrong: Option<f64>,
    /// The strength from which on a device may be too small.
    pub refusable_from: Option<f64>,
    /// Why.
    pub reason: &'static str,
    /// Where that is written.
    pub source: &'static str,
}

impl From<&Expectation> for ExpectationRecord {
    fn from(expectation: &Expectation) -> Self {
        let bounded = Self {
            kind: "exact",
            rule: expectation.rule().name(),
            most_wrong: 0.0,
            from: None,
            least_wrong: None,
            refusable_from: None,
            reason: "",
            source: "",
        };
        match *expectation {
            Expectation::Refusable { from, otherwise } => Self { refusable_from: Some(from), ..Self::from(otherwise) },
            Expectation::Exact => bounded,
            Expectation::Bounded { most_wrong, reason, .. } => Self { kind: "bounded", most_wrong, reason, ..bounded },
            Expectation::KnownFailure { from, below, least_wrong, reason, source, .. } => Self {
                kind: "known_failure",
                most_wrong: below,
                from: Some(from),
                least_wrong: Some(least_wrong),
                reason,
                source,
                ..bounded
            },
        }
    }
}

/// A tracer on a case at one strength.
#[derive(Clone, Debug, Serialize)]
pub struct Measured {
    /// The knob's value.
    pub strength: f64,
    /// Shares of wrong rays; `None` if it gave no answers or every ray is a tie.
    pub wrong: Option<Wrong>,
    /// Shares of right rays under the three rules, of those that are no tie.
    pub agreement: Option<Wrong>,
    /// Class counts of closest-hit rays.
    pub classes: Option<ByRule<Classes>>,
    /// The 2x2 table of any-hit rays.
    pub occlusion: Option<Occlusion>,
    /// Ties.
    pub ties: Option<u64>,
    /// Why rays are wrong, by rule.
    pub causes: Causes,
    /// Why there are no answers.
    pub error: Option<String>,
    /// Whether that is because the device is too small.
    pub refused: bool,
    /// Whether it came as expected; `None` if nothing is.
    pub as_expected: Option<bool>,
}

impl Measured {
    /// What was measured, or why nothing was.
    pub fn new(strength: f64, judged: Result<Judgement, SessionError>) -> Self {
        let none = Self {
            strength,
            wrong: None,
            agreement: None,
            classes: None,
            occlusion: None,
            ties: None,
            causes: Causes::new(),
            error: None,
            refused: false,
            as_expected: None,
        };
        let agreement =
            |right: Option<[f64; 3]>| right.map(|[hit_miss, tight, footprint]| Wrong { hit_miss, tight, footprint });
        match judged {
            Err(error) => {
                let refused = matches!(error, SessionError::Tracer(TracerError::TooLarge { .. }));
                Self { error: Some(error.to_string()), refused, ..none }
            }
            Ok(Judgement::Closest(closest)) => {
                let right = &closest.agreement;
                let shares = right.hit_miss.zip(right.tight.zip(right.footprint));
                let agreement = agreement(shares.map(|(hit_miss, (tight, footprint))| [hit_miss, tight, footprint]));
                Self {
                    wrong: agreement.map(complement),
                    agreement,
                    classes: Some(closest.classes),
                    ties: Some(closest.ties),
                    causes: closest.causes,
                    ..none
                }
            }
            Ok(Judgement::Any(any)) => {
                let agreement = agreement(right_of_any(&any).map(|share| [share; 3]));
                Self {
                    wrong: agreement.map(complement),
                    agreement,
                    occlusion: Some(any.occlusion),
                    ties: Some(any.ties),
                    causes: any.causes,
                    ..none
                }
            }
        }
    }
}

fn complement(right: Wrong) -> Wrong {
    Wrong { hit_miss: 1.0 - right.hit_miss, tight: 1.0 - right.tight, footprint: 1.0 - right.footprint }
}

fn right_of_any(any: &AnyJudgement) -> Option<f64> {
    let Occlusion { true_occluded, true_free, false_occluded, false_free, .. } = any.occlusion;
    let (right, all) = (true_occluded + true_free, true_occluded + true_free + false_occluded + false_free);
    (all > 0).then(|| right as f64 / all as f64)
}
