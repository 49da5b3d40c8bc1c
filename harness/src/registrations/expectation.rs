//! What is expected of a tracer on a case.

pub use crate::judge::Rule;
use crate::results::{EXACT, ExpectationRecord, UNSERVED};
use tracebench_api::Rasterizer;

/// What is expected of a tracer with one of its presets on a case. Shares are of the rays that are judged. How many rays are wrong was
/// measured and is in `studies/stability/expected.csv`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Expectation {
    /// No wrong ray under `tight`, at every difficulty level.
    Exact,
    /// The method can do it, and few rays are wrong.
    Bounded {
        /// The rule by which they are wrong.
        rule: Rule,
        /// Why so many are.
        reason: &'static str,
    },
    /// The method cannot do it.
    KnownFailure {
        /// The rule by which rays are wrong.
        rule: Rule,
        /// Why the method fails.
        reason: &'static str,
        /// Which paper says so, with section, or where it follows from.
        source: &'static str,
    },
    /// No answers: the method does not serve such rays.
    Unserved {
        /// Which those are.
        reason: &'static str,
    },
    /// Something else is expected where the tracer answers; from a difficulty level on a device may be too small for it, which it then
    /// says.
    Refusable {
        /// The value of the difficulty parameter from which on it may refuse.
        from: f64,
        /// What is expected of its answers.
        otherwise: &'static Expectation,
    },
    /// Something else of these, and beside it what the device's rasterizer does, as its probe has found.
    Rasterized {
        /// More or fewer wrong rays by pixels that borders are drawn off, share.
        wrong_by_snapping: f64,
        /// Whether the difficulty parameter says how far a triangle reaches, in heights of the eye: rasterizers lose such triangles.
        reaches_far: bool,
        /// Why.
        reason: &'static str,
        /// What is expected where rasterizers are exact.
        otherwise: &'static Expectation,
    },
}

/// What is expected, by cases: their names, with spaces between.
pub type Column = &'static [(&'static str, Expectation)];

/// What is expected on a case: what the first of these columns says that names it.
pub(super) fn expected(columns: &[Column], case: &str) -> Option<Expectation> {
    let names_it = |(cases, _): &&(&str, Expectation)| cases.split(' ').any(|name| name == case);
    columns.iter().copied().flatten().find(names_it).map(|(_, expected)| *expected)
}

/// Few wrong rays by a rule.
pub(super) const fn few(rule: Rule, reason: &'static str) -> Expectation {
    Expectation::Bounded { rule, reason }
}

/// A failure by a rule.
pub(super) const fn fails(rule: Rule, reason: &'static str, source: &'static str) -> Expectation {
    Expectation::KnownFailure { rule, reason, source }
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

// What is said of several sampled methods.
pub(super) const BETWEEN: &str = "what covers no pixel's centre is not stored, and what covers one fills its pixel";
pub(super) const SAMPLES_SOURCE: &str =
    "VVP16, section 4.2, limitations: what is stored is bounded by resolution and pixel samples";
pub(super) const NEAR_SOURCE: &str = "VVP16, section 3.2, which pulls its views back by near to cover what is clipped";
pub(super) const ASIDE: &str = "rays from beside the view, onto a plane that is at last no more than a line in it";
pub(super) const LEAVE_VIEW: &str = "most of the directions between cube faces leave the one view that there is";
pub(super) const TILED: &str =
    "needles that tile a plate leave no pixel centre uncovered, and neighbours have almost one depth";
pub(super) const NO_BORDERS: &str = "no borders of its own frame: the wall is seen, its rim by a pixel more or less";

/// Rays through the frame's own pixel centres find the depth that is stored there.
const AT_DEPTHS: Expectation = few(
    Rule::Footprint,
    "eye rays through pixel centres get the very depth that was sampled there; only where an edge runs through a centre does the \
     rasterizer's rounding of vertices decide otherwise",
);
const CLIPPED: &str = "what is nearer than near is clipped away when depth is rasterized";
const ASIDE_SOURCE: &str = "VVP16, section 2, on surfaces outside of the primary view";
pub(super) const FROM_EYE: &str =
    "what is projected is taken from the eye first: how far both are from the coordinates' origin changes nothing";
const SHORT_IMAGE: &str =
    "the closer a ray runs to a line of sight the shorter its image, at last one pixel, whose depth it hits";

/// Of methods that store depths at the pixel centres of one view.
pub(super) const OF_ONE_VIEW: Column = &[
    ("open-mesh coplanar-copies depth-range flat-tile equal-triangles long-scene", AT_DEPTHS),
    ("huge-triangle", of_huge_triangles(&AT_DEPTHS)),
    ("wide-frame", of_plates_along_rows(&AT_DEPTHS)),
    ("wires leaves crowded-pixel", fails(Rule::HitMiss, BETWEEN, SAMPLES_SOURCE)),
    ("coarse-frame half-resolution", fails(Rule::Footprint, BETWEEN, SAMPLES_SOURCE)),
    ("off-origin", few(Rule::HitMiss, FROM_EYE)),
    ("eye-on-surface eye-at-vertex before-near", fails(Rule::Footprint, CLIPPED, NEAR_SOURCE)),
    ("needles", few(Rule::Footprint, TILED)),
    ("plane-through-eye", fails(Rule::Footprint, ASIDE, ASIDE_SOURCE)),
    ("cube-borders", fails(Rule::HitMiss, LEAVE_VIEW, ASIDE_SOURCE)),
    ("face-cell-borders", few(Rule::HitMiss, NO_BORDERS)),
    ("through-view-centre away-from-camera", few(Rule::HitMiss, SHORT_IMAGE)),
];

impl Expectation {
    /// The rule that it is about.
    pub fn rule(&self) -> Rule {
        match self {
            Self::Exact | Self::Unserved { .. } => Rule::Tight,
            Self::Bounded { rule, .. } | Self::KnownFailure { rule, .. } => *rule,
            Self::Refusable { otherwise, .. } | Self::Rasterized { otherwise, .. } => otherwise.rule(),
        }
    }

    /// As records have it, on a difficulty parameter's values, by a device's rasterizer; without one as if that were exact. The expected
    /// shares are added.
    pub fn record(&self, values: &[f64], rasterizer: Option<&Rasterizer>) -> ExpectationRecord {
        let record = |kind: &str, reason: &str, source: &str| ExpectationRecord {
            kind: kind.to_owned(),
            rule: self.rule(),
            wrong_shares: Vec::new(),
            rasterizer_tolerance: 0.0,
            refusable_from: None,
            lost_from: None,
            reason: reason.to_owned(),
            source: source.to_owned(),
        };
        match *self {
            Self::Refusable { from, otherwise } => {
                ExpectationRecord { refusable_from: Some(from), ..otherwise.record(values, rasterizer) }
            }
            Self::Rasterized { wrong_by_snapping, reaches_far, reason, otherwise } => {
                let exact = otherwise.record(values, rasterizer);
                let Some(rasterizer) = rasterizer else { return exact };
                ExpectationRecord {
                    rasterizer_tolerance: wrong_by_snapping * rasterizer.snap_pixels,
                    lost_from: values.iter().find(|value| reaches_far && **value > rasterizer.reach).copied(),
                    reason: format!("{}; {reason}", exact.reason),
                    ..exact
                }
            }
            Self::Exact => record(EXACT, "", ""),
            Self::Unserved { reason } => record(UNSERVED, reason, ""),
            Self::Bounded { reason, .. } => record("bounded", reason, ""),
            Self::KnownFailure { reason, source, .. } => record("known_failure", reason, source),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::results::{UnexpectedOutcome, Wrong};

    const FEW: Expectation = few(Rule::HitMiss, "edges");

    /// Whether wrong rays of a share surprise at one of the difficulty parameter's values 1, 10 and 100, and if so by too many.
    fn fails(
        of: Expectation,
        shares: &[Option<f64>],
        device: Option<&Rasterizer>,
        index: usize,
        wrong: f64,
    ) -> Option<bool> {
        let values = [1.0, 10.0, 100.0];
        let record = ExpectationRecord { wrong_shares: shares.to_vec(), ..of.record(&values, device) };
        let found = record.unexpected_outcome(&values, index, &Wrong { hit_miss: wrong, tight: 1.0, footprint: 1.0 });
        found.map(|unexpected_outcome| matches!(unexpected_outcome, UnexpectedOutcome::Failure { .. }))
    }

    /// Every difficulty level has its own share, with room to both sides of a percentage point or a third of it, whichever is more; where
    /// no share is stated nothing surprises.
    #[test]
    fn shares_have_room_to_both_sides() {
        for expectation in [FEW, super::fails(Rule::HitMiss, "", "")] {
            let judge = |index, wrong| fails(expectation, &[Some(0.0), Some(0.3), None], None, index, wrong);
            assert_eq!([0.0, 0.01, 0.011, 1.0].map(|wrong| judge(0, wrong)), [None, None, Some(true), Some(true)]);
            let found = [0.0, 0.199, 0.201, 0.399, 0.401].map(|wrong| judge(1, wrong));
            assert_eq!(found, [Some(false), Some(false), None, None, Some(true)]);
            assert_eq!([0.0, 1.0].map(|wrong| judge(2, wrong)), [None, None]);
        }
    }

    /// What is exact has no room at all.
    #[test]
    fn exact_has_no_room() {
        let record = Expectation::Exact.record(&[1.0], None);
        let wrong = |share| Wrong { hit_miss: 0.0, tight: share, footprint: 0.0 };
        assert_eq!(record.unexpected_outcome(&[1.0], 0, &wrong(0.0)), None);
        assert!(matches!(record.unexpected_outcome(&[1.0], 0, &wrong(1e-4)), Some(UnexpectedOutcome::Failure { .. })));
    }

    /// What may be refused may be so from its difficulty level on alone, and is judged like what it stands for where it answers.
    #[test]
    fn refusals_are_expected_from_their_strength_on() {
        const REFUSABLE: Expectation = Expectation::Refusable { from: 10.0, otherwise: &FEW };
        let values = [1.0, 10.0, 100.0];
        let record = REFUSABLE.record(&values, None);
        assert_eq!([0, 1, 2].map(|index| record.may_be_refused(&values, index)), [false, true, true]);
        assert!(!FEW.record(&values, None).may_be_refused(&values, 2));
        assert_eq!(REFUSABLE.rule(), FEW.rule());
        let shares = [Some(0.0); 3];
        assert_eq!([0.0, 0.1].map(|wrong| fails(REFUSABLE, &shares, None, 2, wrong)), [None, Some(true)]);
    }

    /// What a rasterizer spoils is expected of it by its probe: room for what it snaps, to both sides, and from the first value beyond its
    /// reach on nothing is judged; where nothing was probed it is taken for exact.
    #[test]
    fn rasterizers_are_judged_by_their_probe() {
        const HUGE: Expectation =
            Expectation::Rasterized { wrong_by_snapping: 2.0, reaches_far: true, reason: "lost", otherwise: &FEW };
        let device =
            |snap_pixels, reach| Rasterizer { snap_pixels, reach, depth_error: 0.0, depth_error_beyond_view: 0.0 };
        let (fine, coarse) = (device(0.0, 100.0), device(0.03, 10.0));
        let judge = |device, index, wrong| fails(HUGE, &[Some(0.15); 3], device, index, wrong);
        let wrong = [0.0, 0.05, 0.11, 0.19, 0.21, 0.25, 0.27];
        let (low, high) = (Some(false), Some(true));
        assert_eq!(wrong.map(|wrong| judge(None, 2, wrong)), [low, low, None, None, high, high, high]);
        assert_eq!(wrong.map(|wrong| judge(Some(&fine), 2, wrong)), [low, low, None, None, high, high, high]);
        assert_eq!(wrong.map(|wrong| judge(Some(&coarse), 1, wrong)), [low, None, None, None, None, None, high]);
        assert_eq!(wrong.map(|wrong| judge(Some(&coarse), 2, wrong)), [None; 7]);
    }
}
