//! What is expected of a tracer on a case, and whether it came.

pub use crate::judge::Rule;

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

/// Shares of wrong rays under the three rules; of any-hit rays the same three times.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
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
        match self {
            Self::Refusable { from, .. } => values.iter().position(|value| value == from).is_some_and(|at| index >= at),
            _ => false,
        }
    }

    /// What is surprising about the wrong rays at one of a knob's values.
    pub fn surprise(&self, values: &[f64], index: usize, shares: &Wrong) -> Option<Surprise> {
        let rule = self.rule();
        let wrong = shares.under(rule);
        let at_most = |allowed: f64| (wrong > allowed).then_some(Surprise::Failure { wrong, rule, allowed });
        match *self {
            Self::Refusable { otherwise, .. } => otherwise.surprise(values, index, shares),
            Self::Exact => at_most(0.0),
            Self::Bounded { most_wrong, .. } => at_most(most_wrong),
            Self::KnownFailure { from, below, least_wrong, .. } => {
                let first = values.iter().position(|value| *value == from).unwrap_or(0);
                if index < first {
                    return at_most(below);
                }
                let expected = if index + 1 == values.len() { least_wrong } else { below };
                (wrong < expected || wrong <= below).then_some(Surprise::Success { wrong, rule, expected })
            }
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
