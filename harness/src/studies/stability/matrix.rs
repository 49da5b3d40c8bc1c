//! What follows from the rows of cases: what every tracer got wrong at every difficulty level, and a verdict on it.

use super::{Verdict, verdict};
use crate::results::{
    AnyJudgement, CaseRecord, CaseTracer, ClosestJudgement, ExpectationRecord, Judgement, NoAnswer, Provenance, Record,
    Skipped, UNEXPLAINED, Wrong,
};

/// A run of cases.
#[derive(Clone, Debug)]
pub struct Stability {
    /// Where, by which program and when.
    pub provenance: Provenance,
    /// Whether verdicts count: no parameter was changed.
    pub counts: bool,
    /// The cases.
    pub cases: Vec<CaseMatrix>,
    /// Tracers that did not run, and why.
    pub skipped: Vec<Skipped>,
}

/// A case with what came of it.
#[derive(Clone, Debug)]
pub struct CaseMatrix {
    /// The case.
    pub case: CaseRecord,
    /// The tracers, in the order of columns.
    pub cells: Vec<Cell>,
}

/// A tracer on a case.
#[derive(Clone, Debug)]
pub struct Cell {
    /// The tracer's label.
    pub tracer: String,
    /// What is expected of it; `None` if nothing is stated.
    pub expectation: Option<ExpectationRecord>,
    /// What came of it over all difficulty levels.
    pub verdict: Verdict,
    /// The verdict in words.
    pub text: String,
    /// What was measured at each difficulty level.
    pub measured: Vec<Measured>,
}

/// A tracer on a case at one difficulty level.
#[derive(Clone, Debug)]
pub struct Measured {
    /// The difficulty parameter's value.
    pub difficulty_level: f64,
    /// Shares of wrong rays; `None` if it gave no answers or no ray is judged.
    pub wrong: Option<Wrong>,
    /// The greatest share of rays, by any rule, whose wrong answers have no cause.
    pub unexplained: f64,
    /// Why there are no answers.
    pub no_answer: Option<NoAnswer>,
    /// Whether it came as expected; `None` if nothing is.
    pub as_expected: Option<bool>,
}

impl Stability {
    /// What a record says of cases, with verdicts; `None` if it is of none.
    pub fn of(record: &Record) -> Option<Self> {
        let cases = &record.cases.as_ref()?.cases;
        let unchanged = |case: &CaseRecord| case.tracers.iter().all(|each| each.tracer.changed.is_empty());
        Some(Self {
            provenance: record.provenance.clone(),
            counts: cases.iter().all(unchanged),
            cases: cases.iter().map(|case| CaseMatrix::of(record, case)).collect(),
            skipped: record.skipped.clone(),
        })
    }

    /// What came otherwise than expected: case, tracer, what.
    pub fn surprises(&self) -> Vec<String> {
        let mut surprises = Vec::new();
        for CaseMatrix { case, cells } in &self.cases {
            surprises.extend(case.invalid.iter().map(|reason| format!("{}: invalid, {reason}", case.name)));
            let cells = cells.iter().filter(|cell| cell.verdict.is_unexpected());
            surprises.extend(cells.map(|cell| format!("{}, {}: {}", case.name, cell.tracer, cell.text)));
        }
        surprises
    }

    /// Labels of the tracers, in the order of columns.
    pub fn tracers(&self) -> Vec<String> {
        let cells = self.cases.first().map_or(&[][..], |case| &case.cells);
        cells.iter().map(|cell| cell.tracer.clone()).collect()
    }
}

impl Measured {
    /// Whether there are no answers for such a reason.
    pub(super) fn is(&self, why: fn(&NoAnswer) -> bool) -> bool {
        self.no_answer.as_ref().is_some_and(why)
    }
}

impl CaseMatrix {
    fn of(record: &Record, case: &CaseRecord) -> Self {
        let cell = |of: &CaseTracer| {
            let values = case.difficulty_parameter.values.iter().filter(|_| !of.unavailable);
            verdict::cell(case, of, values.map(|value| measured(record, case, of, *value)).collect())
        };
        Self { case: case.clone(), cells: case.tracers.iter().map(cell).collect() }
    }
}

fn measured(record: &Record, case: &CaseRecord, of: &CaseTracer, difficulty_level: f64) -> Measured {
    let is_row = |row: &&crate::results::Row| {
        row.scene.name == case.name && row.difficulty_level == Some(difficulty_level) && row.tracer == of.tracer
    };
    let trace = record.rows.iter().find(is_row).and_then(|row| row.traces.first());
    let said = of.no_answers.iter().find(|each| each.difficulty_level == difficulty_level).cloned();
    let not_measured = || {
        let error = "not measured".to_owned();
        NoAnswer { difficulty_level, error, refused: false, unavailable: false, unserved: false }
    };
    Measured {
        difficulty_level,
        wrong: trace.and_then(|trace| wrong(&trace.judgement)),
        unexplained: trace.map_or(0.0, |trace| unexplained(&trace.judgement, trace.count)),
        no_answer: if trace.is_none() { Some(said.unwrap_or_else(not_measured)) } else { None },
        as_expected: None,
    }
}

fn wrong(judgement: &Judgement) -> Option<Wrong> {
    let right = match judgement {
        Judgement::Closest(ClosestJudgement { agreement: of, .. }) => [of.hit_miss?, of.tight?, of.footprint?],
        Judgement::Any(AnyJudgement { occlusion: of, .. }) => {
            let (right, wrong) = (of.true_occluded + of.true_free, of.false_occluded + of.false_free);
            [(right + wrong > 0).then(|| right as f64 / (right + wrong) as f64)?; 3]
        }
    };
    let [hit_miss, tight, footprint] = right.map(|share| 1.0 - share);
    Some(Wrong { hit_miss, tight, footprint })
}

fn unexplained(judgement: &Judgement, rays: u64) -> f64 {
    let most = judgement.causes().values().filter_map(|of_rule| of_rule.get(UNEXPLAINED)).max();
    most.map_or(0.0, |most| *most as f64 / rays as f64)
}
