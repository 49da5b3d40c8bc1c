//! How two verdicts on the same rays differ.

use serde::Serialize;

use crate::results::{Accuracy as Right, Judgement};

/// Which way an accuracy moved.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Shift {
    /// The same share.
    Same,
    /// Another share, but the intervals overlap: other rays of the same kind might have it the other way.
    Within,
    /// More accurate: the 95 % intervals are disjoint.
    Better,
    /// Less accurate: the 95 % intervals are disjoint.
    Worse,
}

/// An accuracy in both runs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Accuracy {
    /// By which rule: `hit_miss`, `tight`, `footprint`, or `balanced accuracy` of an any-hit set.
    pub rule: &'static str,
    /// Share of the first; `None` if every ray is an ambiguous ray.
    pub a: Option<f64>,
    /// Share of the second.
    pub b: Option<f64>,
    /// Wrong rays of the first.
    pub a_wrong: u64,
    /// Wrong rays of the second.
    pub b_wrong: u64,
    /// Rays that count, of the first: those of both if their ambiguous rays are the same, as they are by the same truth.
    pub rays: u64,
    /// What is to be said of it.
    pub shift: Shift,
}

impl Accuracy {
    /// By every rule; nothing for verdicts on different queries.
    pub(super) fn of_both(a: &Judgement, b: &Judgement) -> Vec<Self> {
        let rules: &[_] = match (a, b) {
            (Judgement::Closest(_), Judgement::Closest(_)) => &["hit_miss", "tight", "footprint"],
            (Judgement::Any(_), Judgement::Any(_)) => &["balanced accuracy"],
            _ => return Vec::new(),
        };
        let rays = a.true_hits_and_misses().into_iter().sum();
        let both = a.accuracies(rays).into_iter().zip(b.accuracies(rays));
        rules.iter().zip(both).map(|(rule, (a, b))| Self::of(rule, &a, &b)).collect()
    }

    fn of(rule: &'static str, a: &Right, b: &Right) -> Self {
        // A share that says nothing is none.
        let share = |of: &Right| of.share.filter(|_| of.one_sided.is_none());
        let shift = match (a.interval.zip(share(a)), b.interval.zip(share(b))) {
            (Some((_, one)), Some((_, other))) if one == other && a.wrong == b.wrong => Shift::Same,
            (Some(([_, high], _)), Some(([low, _], _))) if low > high => Shift::Better,
            (Some(([low, _], _)), Some(([_, high], _))) if high < low => Shift::Worse,
            (None, None) if a.wrong == b.wrong => Shift::Same,
            _ => Shift::Within,
        };
        Self { rule, a: share(a), b: share(b), a_wrong: a.wrong, b_wrong: b.wrong, rays: a.trials, shift }
    }
}
