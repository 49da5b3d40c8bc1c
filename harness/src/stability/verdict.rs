//! From what was measured to a verdict.

use serde::Serialize;

use super::{Cell, ExpectationRecord, Measured};
use crate::cases::Case;
use crate::contenders::expectation::Surprise;
use crate::contenders::{Expectation, Rule};

/// What came of a tracer on a case.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// Nothing wrong, as expected.
    Exact,
    /// As little wrong as expected.
    Bounded,
    /// Fails as it is known to.
    KnownFailure,
    /// More is wrong than expected, or there are no answers.
    UnexpectedFailure,
    /// Less is wrong than a known failure must have: the expectation is out of date.
    UnexpectedSuccess,
    /// Nothing is expected.
    Unstated,
    /// This machine cannot run the tracer; the reason stands with what was skipped.
    Unavailable,
}

impl Verdict {
    /// Whether somebody must look.
    pub fn is_unexpected(self) -> bool {
        matches!(self, Self::UnexpectedFailure | Self::UnexpectedSuccess)
    }
}

/// A share in percent, as short as it can be without saying 0 or 100 of what is neither.
pub(crate) fn percent(share: f64) -> String {
    let percent = share * 100.0;
    let decimals = match percent {
        _ if share == 0.0 || share == 1.0 => 0,
        _ if percent > 99.0 => 2,
        _ if percent >= 10.0 => 0,
        _ if percent >= 1.0 => 1,
        _ => 2,
    };
    format!("{percent:.decimals$} %")
}

/// Judges one tracer on one case.
pub(super) fn cell(case: &Case, tracer: &str, expected: Option<&Expectation>, mut measured: Vec<Measured>) -> Cell {
    let (verdict, text) = match expected {
        None => (Verdict::Unstated, unstated(&measured)),
        Some(expected) => stated(case, expected, &mut measured),
    };
    let expectation = expected.map(ExpectationRecord::from);
    Cell { tracer: tracer.to_owned(), expectation, verdict, text, measured }
}

/// The cell of a tracer that this machine cannot run: nothing is measured and nothing can be surprising.
pub(super) fn unavailable(tracer: &str, expected: Option<&Expectation>) -> Cell {
    Cell {
        tracer: tracer.to_owned(),
        expectation: expected.map(ExpectationRecord::from),
        verdict: Verdict::Unavailable,
        text: "unavailable".to_owned(),
        measured: Vec::new(),
    }
}

/// The greatest share of wrong rays over all strengths.
fn worst(measured: &[Measured], rule: Rule) -> f64 {
    measured.iter().filter_map(|each| each.wrong).map(|wrong| wrong.under(rule)).fold(0.0, f64::max)
}

fn unstated(measured: &[Measured]) -> String {
    if let Some(error) = measured.iter().find_map(|each| each.error.as_ref()) {
        return format!("unstated, no answers: {error}");
    }
    let [tight, footprint] = [Rule::Tight, Rule::Footprint].map(|rule| percent(worst(measured, rule)));
    format!("unstated: at most {tight} (tight), {footprint} (footprint)")
}

fn stated(case: &Case, expected: &Expectation, measured: &mut [Measured]) -> (Verdict, String) {
    let values = case.knob.values;
    let mut surprises: Vec<(Verdict, String)> = Vec::new();
    for (index, each) in measured.iter_mut().enumerate() {
        let at = format!("at {} {}", each.strength, case.knob.unit);
        let at = at.trim_end();
        let surprise = match each.wrong {
            None if each.refused && expected.may_be_refused(values, index) => None,
            None => {
                let reason = each.error.as_deref().unwrap_or("every ray is a tie");
                Some((Verdict::UnexpectedFailure, format!("UNEXPECTED failure {at}: {reason}")))
            }
            Some(wrong) => expected.surprise(values, index, &wrong).map(|surprise| in_words(surprise, at)),
        };
        each.as_expected = Some(surprise.is_none());
        surprises.extend(surprise);
    }
    if let Some(failure) = surprises.iter().find(|(verdict, _)| *verdict == Verdict::UnexpectedFailure) {
        return failure.clone();
    }
    // Of successes the one at the hardest strength says most.
    if let Some(success) = surprises.pop() {
        return success;
    }
    let (verdict, text) = as_expected(expected, measured);
    // Where the device was too small the text says so.
    match measured.iter().find(|each| each.refused) {
        None => (verdict, text),
        Some(first) => {
            let at = format!("{} {}", first.strength, case.knob.unit);
            (verdict, format!("{text}, refused from {} on: too large for the device", at.trim_end()))
        }
    }
}

/// The verdict where nothing is surprising.
fn as_expected(expected: &Expectation, measured: &[Measured]) -> (Verdict, String) {
    match expected {
        Expectation::Refusable { otherwise, .. } => as_expected(otherwise, measured),
        Expectation::Exact => (Verdict::Exact, "exact".to_owned()),
        Expectation::Bounded { rule, most_wrong, .. } => {
            let text =
                format!("bounded {} ≤ {} ({})", percent(worst(measured, *rule)), percent(*most_wrong), rule.name());
            (Verdict::Bounded, text)
        }
        Expectation::KnownFailure { rule, .. } => {
            let hardest = measured.iter().rev().find_map(|each| each.wrong).map_or(1.0, |wrong| wrong.under(*rule));
            (Verdict::KnownFailure, format!("known failure {} ({})", percent(hardest), rule.name()))
        }
    }
}

fn in_words(surprise: Surprise, at: &str) -> (Verdict, String) {
    match surprise {
        Surprise::Failure { wrong, rule, allowed } => {
            let (wrong, allowed, rule) = (percent(wrong), percent(allowed), rule.name());
            let text = format!("UNEXPECTED failure {at}: {wrong} wrong under {rule}, at most {allowed} expected");
            (Verdict::UnexpectedFailure, text)
        }
        Surprise::Success { wrong, rule, expected } => {
            let (wrong, expected, rule) = (percent(wrong), percent(expected), rule.name());
            let text = format!("UNEXPECTED success {at}: {wrong} wrong under {rule}, at least {expected} expected");
            (Verdict::UnexpectedSuccess, text)
        }
    }
}
