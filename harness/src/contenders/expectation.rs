//! What is expected of a tracer on a case, and whether it came.

pub use crate::judge::Rule;
use crate::results::{ExpectationRecord, Surprise, Wrong};

/// What is expected of a tracer with its published preset on a case. Shares are of the rays that are no tie.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Expectation {
    /// No wrong ray under `tight`, at every strength.
    Exact,
    /// Few wrong rays at every strength.
    Bounded {
        /// The rule by which they are wrong.
        rule: Rule,
        /// Most of them, share.
        most_wrong: f64,
        /// Why so many may be.
        reason: &'static str,
    },
    /// The method cannot do it, and is expected not to.
    KnownFailure {
        /// The rule by which rays are wrong.
        rule: Rule,
        /// The value of the knob from which on it fails: more than `below` are wrong.
        from: f64,
        /// Most wrong rays at weaker values, share.
        below: f64,
        /// Least wrong rays at the hardest value, share.
        least_wrong: f64,
        /// Why the method fails.
        reason: &'static str,
        /// Which paper says so, with section, or where it follows from.
        source: &'static str,
    },
    /// Something else is expected where the tracer answers; from a strength on a device may be too small for it, which it then
    /// says.
    Refusable {
        /// The value of the knob from which on it may refuse.
        from: f64,
        /// What is expected of its answers.
        otherwise: &'static Expectation,
    },
}

/// What is expected of one tracer, by case.
pub type Column = &'static [(&'static str, Expectation)];

/// A failure by a rule from a strength on.
pub(super) const fn fails(
    rule: Rule,
    from: f64,
    below: f64,
    least_wrong: f64,
    reason: &'static str,
    source: &'static str,
) -> Expectation {
    Expectation::KnownFailure { rule, from, below, least_wrong, reason, source }
}

impl Expectation {
    /// The rule that it is about.
    pub fn rule(&self) -> Rule {
        match self {
            Self::Exact => Rule::Tight,
            Self::Bounded { rule, .. } | Self::KnownFailure { rule, .. } => *rule,
            Self::Refusable { otherwise, .. } => otherwise.rule(),
        }
    }

    /// Whether a device may be too small at one of a knob's values.
    pub fn may_be_refused(&self, values: &[f64], index: usize) -> bool {
        self.record().may_be_refused(values, index)
    }

    /// What is surprising about the wrong rays at one of a knob's values.
    pub fn surprise(&self, values: &[f64], index: usize, shares: &Wrong) -> Option<Surprise> {
        self.record().surprise(values, index, shares)
    }

    /// As records have it.
    pub fn record(&self) -> ExpectationRecord {
        let record = |kind: &str, most_wrong, reason: &str| ExpectationRecord {
            kind: kind.to_owned(),
            rule: self.rule(),
            most_wrong,
            from: None,
            least_wrong: None,
            refusable_from: None,
            reason: reason.to_owned(),
            source: String::new(),
        };
        match *self {
            Self::Refusable { from, otherwise } => {
                ExpectationRecord { refusable_from: Some(from), ..otherwise.record() }
            }
            Self::Exact => record("exact", 0.0, ""),
            Self::Bounded { most_wrong, reason, .. } => record("bounded", most_wrong, reason),
            Self::KnownFailure { from, below, least_wrong, reason, source, .. } => ExpectationRecord {
                from: Some(from),
                least_wrong: Some(least_wrong),
                source: source.to_owned(),
                ..record("known_failure", below, reason)
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A known failure is one from its strength on alone: before it its own bound holds, neither twice of it nor less,
    /// at the hardest strength the stated share at least is wrong, and in between more than the bound.
    #[test]
    fn known_failures_begin_where_they_are_said_to() {
        let known = Expectation::KnownFailure {
            rule: Rule::HitMiss,
            from: 3.0,
            below: 0.02,
            least_wrong: 0.4,
            reason: "",
            source: "",
        };
        let surprise = |index: usize, wrong: f64| {
            let found =
                known.surprise(&[1.0, 2.0, 3.0, 4.0], index, &Wrong { hit_miss: wrong, tight: 1.0, footprint: 1.0 });
            found.map(|surprise| matches!(surprise, Surprise::Failure { .. }))
        };
        for index in [0, 1] {
            assert_eq!(
                [0.0, 0.02, 0.021, 0.04].map(|wrong| surprise(index, wrong)),
                [None, None, Some(true), Some(true)]
            );
        }
        assert_eq!([0.0, 0.02, 0.021, 0.9].map(|wrong| surprise(2, wrong)), [Some(false), Some(false), None, None]);
        assert_eq!([0.1, 0.39, 0.4, 0.9].map(|wrong| surprise(3, wrong)), [Some(false), Some(false), None, None]);
    }

    /// What may be refused may be so from its strength on alone, and is judged like what it stands for where it answers.
    #[test]
    fn refusals_are_expected_from_their_strength_on() {
        const EXACT: Expectation = Expectation::Exact;
        let refusable = Expectation::Refusable { from: 3.0, otherwise: &EXACT };
        let values = [1.0, 2.0, 3.0, 4.0];
        assert_eq!([0, 1, 2, 3].map(|index| refusable.may_be_refused(&values, index)), [false, false, true, true]);
        assert!(!EXACT.may_be_refused(&values, 3));
        let wrong = |share| Wrong { hit_miss: share, tight: share, footprint: share };
        assert_eq!(refusable.rule(), EXACT.rule());
        assert!(refusable.surprise(&values, 3, &wrong(0.0)).is_none());
        assert!(matches!(refusable.surprise(&values, 3, &wrong(0.1)), Some(Surprise::Failure { .. })));
    }
}
