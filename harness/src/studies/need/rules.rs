//! What holds over all cases, a case being a scene, viewpoint and ray set; and rules of thumb, each tried in a scene that it was not made of.

use std::collections::BTreeMap;

use itertools::Itertools as _;
use tracebench_api::named;

use super::{Curve, Step};
use crate::results::{NeedCurve, Ratio};

named! {
    /// Whether a smaller structure's answers are as good as the whole one's.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
    pub enum Outcome {
        /// They are.
        Enough = "enough",
        /// The interval of what it loses holds the limit.
        Undecided = "undecided",
        /// It loses more for sure.
        NotEnough = "not enough",
    }
}

/// A tracer's structure with less of something, in several cases.
#[derive(Clone, Debug)]
pub struct Tried<'a> {
    /// What it has less of.
    pub values: &'a BTreeMap<String, String>,
    /// Every case with the structure there, if it was measured.
    cases: Vec<(&'a Curve<'a>, Option<&'a Step<'a>>)>,
}

/// A rule of thumb: the scene that it is tried in and was not made of, none where it was made of all; and there the smallest structure, by its
/// share of the whole one's bytes, that is enough in every case that it was made of, none where that is the whole one.
pub type Thumb<'a> = (Option<&'a NeedCurve>, Option<Tried<'a>>);

/// A tracer, its smaller structures in all cases, and its rules: of all scenes, then of all but one, where there are several.
pub type OfTracer<'a> = (&'a NeedCurve, Vec<Tried<'a>>, Vec<Thumb<'a>>);

impl<'a> Tried<'a> {
    /// What came of it in every case; none where it was not measured.
    pub fn outcomes(&self) -> impl Iterator<Item = Option<Outcome>> {
        self.cases.iter().map(|(_, step)| step.and_then(Step::outcome))
    }

    /// The worst of that; none where any is missing.
    pub fn outcome(&self) -> Option<Outcome> {
        self.outcomes().collect::<Option<Vec<_>>>()?.into_iter().max()
    }

    /// The one that loses the most of those that were measured, by the upper end of the interval.
    pub fn worst(&self) -> Option<&'a Step<'a>> {
        let upper = |step: &Step<'_>| step.lost().map_or(f64::NEG_INFINITY, |(_, [_, upper])| upper);
        self.cases.iter().filter_map(|(_, step)| *step).max_by(|one, other| upper(one).total_cmp(&upper(other)))
    }

    /// The most times as long that traces take, of those that were timed.
    pub fn slowest(&self) -> Option<Ratio> {
        let ratios = self.cases.iter().filter_map(|(_, step)| (*step)?.times_as_long);
        ratios.max_by(|one, other| one.value.total_cmp(&other.value))
    }

    /// Its bytes as a share of the whole structure's, the geometric mean over all cases; none where any is missing.
    pub fn share(&self) -> Option<f64> {
        let share = |curve: &Curve<'_>, step: &Step<'_>| Some(step.bytes()? as f64 / curve.whole.bytes()? as f64);
        let shares = self.cases.iter().map(|(curve, step)| Some(share(curve, (*step)?)?.ln()));
        Some((shares.sum::<Option<f64>>()? / self.cases.len() as f64).exp())
    }

    /// The same in some scenes alone.
    fn within(&self, is_wanted: impl Fn(&NeedCurve) -> bool) -> Self {
        let cases = self.cases.iter().filter(|(curve, _)| is_wanted(curve.section));
        Self { values: self.values, cases: cases.copied().collect() }
    }
}

/// What holds of every tracer that has smaller structures.
pub fn rules<'a>(curves: &'a [Curve<'a>]) -> Vec<OfTracer<'a>> {
    let config = |curve: &Curve<'_>| (curve.section.tracer.clone(), curve.section.preset.clone());
    let of_tracer = |first: &'a Curve<'a>| {
        let own = curves.iter().filter(|curve| config(curve) == config(first)).collect_vec();
        let of = |values: &'a BTreeMap<String, String>| {
            let there = |curve: &'a Curve<'a>| curve.steps().find(|step| step.point.shrunk == *values);
            Tried { values, cases: own.iter().map(|curve| (*curve, there(curve))).collect() }
        };
        let steps = own.iter().flat_map(|curve| curve.steps().map(|step| &step.point.shrunk));
        let all = steps.unique().map(of).collect_vec();
        let rule = |held_out: Option<&'a NeedCurve>| {
            let is_there = |curve: &NeedCurve| held_out.is_none_or(|scene| scene.scene_sha256 == curve.scene_sha256);
            let smaller = |tried: &Tried<'a>| {
                let made = tried.within(|curve| held_out.is_none() || !is_there(curve));
                made.share().filter(|share| *share < 1.0 && made.outcome() == Some(Outcome::Enough))
            };
            let found = all.iter().filter_map(|tried| Some((smaller(tried)?, tried)));
            let smallest = found.min_by(|(one, _), (other, _)| one.total_cmp(other));
            (held_out, smallest.map(|(_, tried)| tried.within(is_there)))
        };
        let scenes = own.iter().map(|curve| curve.section).unique_by(|curve| &curve.scene_sha256).collect_vec();
        let held_out = scenes.iter().filter(|_| scenes.len() > 1).map(|scene| Some(*scene));
        let rules = std::iter::once(None).chain(held_out).map(rule).collect_vec();
        (first.section, all, rules)
    };
    let tracers = curves.iter().unique_by(|curve| config(curve)).map(of_tracer);
    tracers.filter(|(_, all, _)| !all.is_empty()).collect()
}
