//! What is expected of a tracer on a case, and whether it came.

pub use crate::judge::Rule;
use crate::results::{ExpectationRecord, Surprise, Wrong};
use tracebench_api::Rasterizer;

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
    /// Something else of these, and beside it what the device's rasterizer does, as its probe has found.
    Rasterized {
        /// Wrong rays by pixels that borders are drawn off, share.
        wrong_by_snapping: f64,
        /// Whether the knob says how far a triangle reaches, in heights of the eye: rasterizers lose such triangles.
        reaches_far: bool,
        /// Why.
        reason: &'static str,
        /// What is expected where rasterizers are exact.
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

/// Of a sampled method on plates that are at last 0.36 of a row high and lie along it.
pub(super) const fn of_plates_along_rows(otherwise: &'static Expectation) -> Expectation {
    let reason = "at last its plates are 0.36 of a row high and lie along it, so that by as much as the rasterizer snaps an edge off the \
                  row's centre it decides of whole plates";
    // Two long edges by both axes over 0.36 rows.
    Expectation::Rasterized { wrong_by_snapping: 8.0, reaches_far: false, reason, otherwise }
}

/// Of a sampled method on a triangle that is ever larger than the view.
pub(super) const fn of_huge_triangles(otherwise: &'static Expectation) -> Expectation {
    let reason = "a rasterizer that clips in f32 loses a triangle that reaches too far for it";
    Expectation::Rasterized { wrong_by_snapping: 0.0, reaches_far: true, reason, otherwise }
}

impl Expectation {
    /// The rule that it is about.
    pub fn rule(&self) -> Rule {
        match self {
            Self::Exact => Rule::Tight,
            Self::Bounded { rule, .. } | Self::KnownFailure { rule, .. } => *rule,
            Self::Refusable { otherwise, .. } | Self::Rasterized { otherwise, .. } => otherwise.rule(),
        }
    }

    /// Whether a device may be too small at one of a knob's values.
    pub fn may_be_refused(&self, values: &[f64], index: usize) -> bool {
        self.record(values, None).may_be_refused(values, index)
    }

    /// What is surprising about the wrong rays at one of a knob's values.
    pub fn surprise(&self, values: &[f64], index: usize, shares: &Wrong) -> Option<Surprise> {
        self.record(values, None).surprise(values, index, shares)
    }

    /// As records have it, on a knob's values, by a device's rasterizer; without one as if that were exact.
    pub fn record(&self, values: &[f64], rasterizer: Option<&Rasterizer>) -> ExpectationRecord {
        let record = |kind: &str, most_wrong, reason: &str| ExpectationRecord {
            kind: kind.to_owned(),
            rule: self.rule(),
            most_wrong,
            from: None,
            least_wrong: None,
            refusable_from: None,
            lost_from: None,
            reason: reason.to_owned(),
            source: String::new(),
        };
        match *self {
            Self::Refusable { from, otherwise } => {
                ExpectationRecord { refusable_from: Some(from), ..otherwise.record(values, rasterizer) }
            }
            Self::Rasterized { wrong_by_snapping, reaches_far, reason, otherwise } => {
                let exact = otherwise.record(values, rasterizer);
                let Some(rasterizer) = rasterizer else { return exact };
                ExpectationRecord {
                    most_wrong: exact.most_wrong + wrong_by_snapping * rasterizer.snap_pixels,
                    lost_from: values.iter().find(|value| reaches_far && **value > rasterizer.reach).copied(),
                    reason: format!("{}; {reason}", exact.reason),
                    ..exact
                }
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

    /// What a rasterizer spoils is expected of it by its probe: more wrong rays by what it snaps, and from the first value beyond its
    /// reach on nothing is judged; where nothing was probed it is taken for exact.
    #[test]
    fn rasterizers_are_judged_by_their_probe() {
        const EXACT: Expectation = Expectation::Bounded { rule: Rule::HitMiss, most_wrong: 0.01, reason: "edges" };
        const HUGE: Expectation =
            Expectation::Rasterized { wrong_by_snapping: 2.0, reaches_far: true, reason: "lost", otherwise: &EXACT };
        let values = [1.0, 10.0, 100.0];
        let device =
            |snap_pixels, reach| Rasterizer { snap_pixels, reach, depth_error: 0.0, depth_error_beyond_view: 0.0 };
        let fails = |device: Option<&Rasterizer>, index, share| {
            let wrong = Wrong { hit_miss: share, tight: share, footprint: share };
            HUGE.record(&values, device).surprise(&values, index, &wrong).is_some()
        };
        let (fine, coarse) = (device(0.0, 100.0), device(0.03, 10.0));
        assert_eq!([0.01, 0.02].map(|share| fails(None, 2, share)), [false, true]);
        assert_eq!([0.01, 0.02].map(|share| fails(Some(&fine), 2, share)), [false, true]);
        assert_eq!([0.06, 0.08].map(|share| fails(Some(&coarse), 1, share)), [false, true]);
        assert_eq!([0.06, 0.9].map(|share| fails(Some(&coarse), 2, share)), [false, false]);
        assert!(fails(Some(&fine), 2, 0.9));
    }
}
