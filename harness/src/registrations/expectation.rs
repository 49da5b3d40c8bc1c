//! What is expected of a tracer on cases.

use std::collections::BTreeMap;
use std::sync::LazyLock;

use serde::Deserialize;
use tracebench_api::Rasterizer;

use crate::results::{ExpectationKind, ExpectationRecord, Rule};

/// What is expected of a tracer with one of its presets on cases. Shares are of the rays that are judged. How many rays are wrong was
/// measured and is in `studies/stability/expected.csv`.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Expectation {
    /// The cases: their names, with spaces between; without any all.
    #[serde(default)]
    pub cases: &'static str,
    /// What answers are like.
    pub kind: ExpectationKind,
    /// The rule by which rays are wrong; of what is exact, by which none is.
    pub rule: Rule,
    /// Why so many are, why the method fails, or which rays it does not serve.
    #[serde(default)]
    pub reason: &'static str,
    /// Which paper says that the method fails, with section, or where it follows from.
    #[serde(default)]
    pub source: &'static str,
    /// By case the value of the difficulty parameter from which on a device may be too small for the tracer, which it then says.
    #[serde(default)]
    pub refusable_from: BTreeMap<&'static str, f64>,
    /// By case what the device's rasterizer does beside that.
    #[serde(default)]
    pub rasterized: BTreeMap<&'static str, Rasterized>,
    /// What else is to be known.
    #[serde(default)]
    pub note: &'static str,
}

/// What a rasterizer does to what a sampled method stores, as its probe has found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Rasterized {
    /// Of plates that are at last 0.36 of a row high and lie along it, more or fewer rays are wrong by pixels that borders are drawn off.
    PlatesAlongRows,
    /// It loses triangles that reach too far. The difficulty parameter says how far they do, in heights of the eye.
    HugeTriangles,
}

/// What is expected of methods that store depths at the pixel centres of one view.
pub(super) fn of_one_view() -> &'static [Expectation] {
    static EXPECTATIONS: LazyLock<Vec<Expectation>> =
        LazyLock::new(|| super::embedded(include_str!("of_one_view.json")));
    &EXPECTATIONS
}

impl Expectation {
    /// Whether it is of a case.
    pub fn is_of(&self, case: &str) -> bool {
        self.cases.is_empty() || self.cases.split(' ').any(|name| name == case)
    }

    /// As records have it, of a case with a difficulty parameter's values, by a device's rasterizer; without one as if that were exact. The
    /// expected shares are added.
    pub fn record(&self, case: &str, values: &[f64], rasterizer: Option<&Rasterizer>) -> ExpectationRecord {
        let mut record = ExpectationRecord {
            kind: self.kind,
            rule: self.rule,
            wrong_shares: Vec::new(),
            rasterizer_tolerance: 0.0,
            refusable_from: self.refusable_from.get(case).copied(),
            lost_from: None,
            reason: self.reason.to_owned(),
            source: self.source.to_owned(),
        };
        match self.rasterized.get(case).zip(rasterizer) {
            None => {}
            Some((Rasterized::PlatesAlongRows, rasterizer)) => {
                // Two long edges by both axes over 0.36 rows.
                record.rasterizer_tolerance = 8.0 * rasterizer.snap_pixels;
                record.reason += "; at last its plates are 0.36 of a row high and lie along it, so that by as much as the rasterizer snaps \
                                  an edge off the row's centre it decides of whole plates";
            }
            Some((Rasterized::HugeTriangles, rasterizer)) => {
                record.lost_from = values.iter().find(|value| **value > rasterizer.reach).copied();
                record.reason += "; a rasterizer that clips in f32 loses a triangle that reaches too far for it";
            }
        }
        record
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::results::{UnexpectedOutcome, Wrong};

    const CASE: &str = "tiny";
    const FEW: &str = r#"{"kind": "bounded", "rule": "hit_miss", "reason": "edges"}"#;

    fn told(text: &'static str) -> Expectation {
        serde_json::from_str(text).unwrap()
    }

    /// Whether wrong rays of a share surprise at one of the difficulty parameter's values 1, 10 and 100, and if so by too many.
    fn fails(
        of: &Expectation,
        shares: &[Option<f64>],
        device: Option<&Rasterizer>,
        index: usize,
        wrong: f64,
    ) -> Option<bool> {
        let values = [1.0, 10.0, 100.0];
        let record = ExpectationRecord { wrong_shares: shares.to_vec(), ..of.record(CASE, &values, device) };
        let found = record.unexpected_outcome(&values, index, &Wrong { hit_miss: wrong, tight: 1.0, footprint: 1.0 });
        found.map(|unexpected_outcome| matches!(unexpected_outcome, UnexpectedOutcome::Failure { .. }))
    }

    /// Every difficulty level has its own share, with room to both sides of a percentage point or a third of it, whichever is more; where
    /// no share is stated nothing surprises.
    #[test]
    fn shares_have_room_to_both_sides() {
        for expectation in [told(FEW), told(r#"{"kind": "known_failure", "rule": "hit_miss"}"#)] {
            let judge = |index, wrong| fails(&expectation, &[Some(0.0), Some(0.3), None], None, index, wrong);
            assert_eq!([0.0, 0.01, 0.011, 1.0].map(|wrong| judge(0, wrong)), [None, None, Some(true), Some(true)]);
            let found = [0.0, 0.199, 0.201, 0.399, 0.401].map(|wrong| judge(1, wrong));
            assert_eq!(found, [Some(false), Some(false), None, None, Some(true)]);
            assert_eq!([0.0, 1.0].map(|wrong| judge(2, wrong)), [None, None]);
        }
    }

    /// What is exact has no room at all.
    #[test]
    fn exact_has_no_room() {
        let record = told(r#"{"kind": "exact", "rule": "tight"}"#).record(CASE, &[1.0], None);
        let wrong = |share| Wrong { hit_miss: 0.0, tight: share, footprint: 0.0 };
        assert_eq!(record.unexpected_outcome(&[1.0], 0, &wrong(0.0)), None);
        assert!(matches!(record.unexpected_outcome(&[1.0], 0, &wrong(1e-4)), Some(UnexpectedOutcome::Failure { .. })));
    }

    /// What may be refused on a case may be so from its difficulty level on alone, and is judged like what is told beside it where it
    /// answers; on other cases it may not be refused.
    #[test]
    fn refusals_are_expected_from_their_strength_on() {
        let refusable = r#"{"kind": "bounded", "rule": "hit_miss", "reason": "edges", "refusable_from": {"tiny": 10}}"#;
        let (refusable, values) = (told(refusable), [1.0, 10.0, 100.0]);
        let record = refusable.record(CASE, &values, None);
        assert_eq!([0, 1, 2].map(|index| record.may_be_refused(&values, index)), [false, true, true]);
        assert!(!refusable.record("other", &values, None).may_be_refused(&values, 2));
        let shares = [Some(0.0); 3];
        assert_eq!([0.0, 0.1].map(|wrong| fails(&refusable, &shares, None, 2, wrong)), [None, Some(true)]);
    }

    /// What a rasterizer spoils is expected of it by its probe: room for what it snaps, to both sides, or from the first value beyond its
    /// reach on nothing is judged; where nothing was probed it is taken for exact.
    #[test]
    fn rasterizers_are_judged_by_their_probe() {
        let [along_rows, huge] = [
            r#"{"kind": "bounded", "rule": "hit_miss", "rasterized": {"tiny": "plates_along_rows"}}"#,
            r#"{"kind": "bounded", "rule": "hit_miss", "rasterized": {"tiny": "huge_triangles"}}"#,
        ]
        .map(told);
        let device =
            |snap_pixels, reach| Rasterizer { snap_pixels, reach, depth_error: 0.0, depth_error_beyond_view: 0.0 };
        let (fine, coarse) = (device(0.0, 100.0), device(0.0075, 10.0));
        let judge = |of, device, index, wrong| fails(of, &[Some(0.15); 3], device, index, wrong);
        let wrong = [0.0, 0.05, 0.11, 0.19, 0.21, 0.25, 0.27];
        let (low, high) = (Some(false), Some(true));
        for of in [&along_rows, &huge] {
            for device in [None, Some(&fine)] {
                let found = wrong.map(|wrong| judge(of, device, 2, wrong));
                assert_eq!(found, [low, low, None, None, high, high, high]);
            }
        }
        let found = wrong.map(|wrong| judge(&along_rows, Some(&coarse), 2, wrong));
        assert_eq!(found, [low, None, None, None, None, None, high]);
        let found = wrong.map(|wrong| judge(&huge, Some(&coarse), 1, wrong));
        assert_eq!(found, [low, low, None, None, high, high, high]);
        assert_eq!(wrong.map(|wrong| judge(&huge, Some(&coarse), 2, wrong)), [None; 7]);
    }
}
