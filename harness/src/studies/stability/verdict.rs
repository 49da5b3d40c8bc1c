//! From what was measured to a verdict.

use super::{Cell, Measured};
use crate::results::{
    CaseRecord, CaseTracer, ExpectationKind, ExpectationRecord, MAX_UNEXPLAINED, NoAnswer, Rule, UnexpectedOutcome,
};

/// What came of a tracer on a case.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// Nothing wrong, as expected.
    Exact,
    /// Few are wrong, as many as expected.
    Bounded,
    /// Fails as it is known to.
    KnownFailure,
    /// More is wrong than expected, or there are no answers.
    UnexpectedFailure,
    /// Less is wrong than expected: the expectation is out of date.
    UnexpectedSuccess,
    /// Nothing is expected.
    Unstated,
    /// The method does not serve such rays, as it is known not to.
    Unserved,
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

/// Judges one tracer on one case. Of one that this machine cannot run nothing is measured and nothing can be surprising.
pub(super) fn cell(case: &CaseRecord, of: &CaseTracer, mut measured: Vec<Measured>) -> Cell {
    let (verdict, text) = match &of.expectation {
        _ if of.unavailable => (Verdict::Unavailable, "unavailable".to_owned()),
        Some(expected) if expected.kind == ExpectationKind::Unserved => unserved(expected, &mut measured),
        Some(expected) if (0..measured.len()).any(|index| expected.expected_share(index).is_some()) => {
            stated(case, expected, &mut measured)
        }
        _ => (Verdict::Unstated, unstated(&measured)),
    };
    let unexplained = measured.iter().map(|each| each.unexplained).fold(0.0, f64::max);
    let text = match unexplained > MAX_UNEXPLAINED {
        true => format!("{text}, of {} the cause is not known", percent(unexplained)),
        false => text,
    };
    Cell { tracer: of.tracer.label(), expectation: of.expectation.clone(), verdict, text, measured }
}

/// The greatest share of wrong rays over all difficulty levels.
fn worst(measured: &[Measured], rule: Rule) -> f64 {
    measured.iter().filter_map(|each| each.wrong).map(|wrong| wrong.under(rule)).fold(0.0, f64::max)
}

fn unstated(measured: &[Measured]) -> String {
    if let Some(NoAnswer { error, .. }) = measured.iter().find_map(|each| each.no_answer.as_ref()) {
        return format!("unstated, no answers: {error}");
    }
    let [tight, footprint] = [Rule::Tight, Rule::Footprint].map(|rule| percent(worst(measured, rule)));
    format!("unstated: at most {tight} (tight), {footprint} (footprint)")
}

fn unserved(expected: &ExpectationRecord, measured: &mut [Measured]) -> (Verdict, String) {
    measured.iter_mut().for_each(|each| each.as_expected = Some(each.is(|why| why.unserved)));
    match measured.iter().find(|each| !each.is(|why| why.unserved)) {
        None => (Verdict::Unserved, format!("not served: {}", expected.reason)),
        Some(Measured { no_answer: Some(NoAnswer { error, .. }), .. }) => {
            (Verdict::UnexpectedFailure, format!("UNEXPECTED failure: {error}"))
        }
        Some(_) => (Verdict::UnexpectedSuccess, "UNEXPECTED success: these rays are served".to_owned()),
    }
}

fn stated(case: &CaseRecord, expected: &ExpectationRecord, measured: &mut [Measured]) -> (Verdict, String) {
    let values = &case.difficulty_parameter.values;
    let mut surprises: Vec<(Verdict, String)> = Vec::new();
    for (index, each) in measured.iter_mut().enumerate() {
        let at = format!("at {} {}", each.difficulty_level, case.difficulty_parameter.unit);
        let at = at.trim_end();
        let unexpected_outcome = match each.wrong {
            None if each.is(|why| why.refused) && expected.may_be_refused(values, index) => None,
            // A limit of the device forbids it: which one depends on the device.
            None if each.is(|why| why.unavailable) && expected.refusable_from.is_some() => None,
            None => {
                let reason = each.no_answer.as_ref().map_or("every ray is ambiguous", |why| &why.error);
                Some((Verdict::UnexpectedFailure, format!("UNEXPECTED failure {at}: {reason}")))
            }
            Some(wrong) => expected
                .unexpected_outcome(values, index, &wrong)
                .map(|unexpected_outcome| in_words(unexpected_outcome, at)),
        };
        // Answers where none were before are judged by nothing.
        let judged = each.wrong.is_none() || expected.expected_share(index).is_some();
        each.as_expected = judged.then_some(unexpected_outcome.is_none());
        surprises.extend(unexpected_outcome);
    }
    if let Some(failure) = surprises.iter().find(|(verdict, _)| *verdict == Verdict::UnexpectedFailure) {
        return failure.clone();
    }
    // Of successes the one at the hardest difficulty level says most.
    if let Some(success) = surprises.pop() {
        return success;
    }
    let lost = (0..measured.len()).find(|index| expected.may_be_lost(values, *index));
    let (verdict, mut text) = as_expected(expected, &measured[..lost.unwrap_or(measured.len())]);
    // What the device does to it the text says.
    let mut say = |first: Option<&Measured>, what: &str, why: &str| {
        if let Some(first) = first {
            let at = format!("{} {}", first.difficulty_level, case.difficulty_parameter.unit);
            text.push_str(&format!(", {what} from {} on: {why}", at.trim_end()));
        }
    };
    say(measured.iter().find(|each| each.is(|why| why.refused)), "refused", "too large for the device");
    let unavailable = measured.iter().find(|each| each.is(|why| why.unavailable));
    say(unavailable, "unavailable", "the device's limits forbid it");
    let unstated = measured.iter().find(|each| each.wrong.is_some() && each.as_expected.is_none());
    say(unstated, "not judged", "no share is stated");
    let beyond = percent(worst(&measured[lost.unwrap_or(measured.len())..], expected.rule));
    say(lost.map(|lost| &measured[lost]), "not judged", &format!("the rasterizer loses triangles, {beyond} wrong"));
    (verdict, text)
}

/// The verdict where nothing is surprising.
fn as_expected(expected: &ExpectationRecord, measured: &[Measured]) -> (Verdict, String) {
    let rule = expected.rule;
    match expected.kind {
        ExpectationKind::Exact => (Verdict::Exact, "exact".to_owned()),
        ExpectationKind::Bounded => {
            (Verdict::Bounded, format!("at most {} ({})", percent(worst(measured, rule)), rule.name()))
        }
        _ => {
            let hardest = measured.iter().rev().find_map(|each| each.wrong).map_or(1.0, |wrong| wrong.under(rule));
            (Verdict::KnownFailure, format!("known failure {} ({})", percent(hardest), rule.name()))
        }
    }
}

fn in_words(unexpected_outcome: UnexpectedOutcome, at: &str) -> (Verdict, String) {
    let (verdict, what, end, [wrong, expected], rule) = match unexpected_outcome {
        UnexpectedOutcome::Failure(wrong, rule, at_most) => {
            (Verdict::UnexpectedFailure, "failure", "most", [wrong, at_most], rule.name())
        }
        UnexpectedOutcome::Success(wrong, rule, at_least) => {
            (Verdict::UnexpectedSuccess, "success", "least", [wrong, at_least], rule.name())
        }
    };
    let [wrong, expected] = [wrong, expected].map(percent);
    (verdict, format!("UNEXPECTED {what} {at}: {wrong} wrong under {rule}, at {end} {expected} expected"))
}
