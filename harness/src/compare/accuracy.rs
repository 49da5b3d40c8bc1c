//! How two verdicts on the same rays differ.

use serde::Serialize;

use crate::results::{Classes, ClosestJudgement, Judgement, Occlusion};

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

/// What an accuracy of one run is made of.
struct Score {
    rule: &'static str,
    share: Option<f64>,
    interval: Option<[f64; 2]>,
    wrong: u64,
    rays: u64,
}

impl Accuracy {
    /// By every rule; nothing for verdicts on different queries.
    pub(super) fn of_both(a: &Judgement, b: &Judgement) -> Vec<Self> {
        let (a, b) = (scores(a), scores(b));
        let both = a.into_iter().zip(b).filter(|(a, b)| a.rule == b.rule);
        both.map(|(a, b)| Self::of(&a, &b)).collect()
    }

    fn of(a: &Score, b: &Score) -> Self {
        let shift = match (a.interval.zip(a.share), b.interval.zip(b.share)) {
            (Some((_, one)), Some((_, other))) if one == other && a.wrong == b.wrong => Shift::Same,
            (Some(([_, high], _)), Some(([low, _], _))) if low > high => Shift::Better,
            (Some(([low, _], _)), Some(([_, high], _))) if high < low => Shift::Worse,
            (None, None) if a.wrong == b.wrong => Shift::Same,
            _ => Shift::Within,
        };
        Self { rule: a.rule, a: a.share, b: b.share, a_wrong: a.wrong, b_wrong: b.wrong, rays: a.rays, shift }
    }
}

fn scores(judgement: &Judgement) -> Vec<Score> {
    let of_all = scores_of(judgement).into_iter();
    // A share that says nothing is none.
    of_all.map(|score| Score { share: score.share.filter(|_| judgement.one_sided().is_none()), ..score }).collect()
}

fn scores_of(judgement: &Judgement) -> Vec<Score> {
    match judgement {
        Judgement::Closest(closest) => closest_scores(closest),
        Judgement::Any(any) => {
            let Occlusion { true_occluded, true_free, false_occluded, false_free, .. } = any.occlusion;
            let wrong = false_occluded + false_free;
            vec![Score {
                rule: "balanced accuracy",
                share: any.occlusion.balanced_accuracy,
                interval: any.occlusion.balanced_accuracy_interval,
                wrong,
                rays: true_occluded + true_free + wrong,
            }]
        }
    }
}

fn closest_scores(closest: &ClosestJudgement) -> Vec<Score> {
    let ClosestJudgement { classes, agreement, interval, .. } = closest;
    let hit_or_miss = |classes: &Classes| classes.false_hit + classes.false_miss;
    let all = |classes: &Classes| hit_or_miss(classes) + classes.early + classes.late;
    let rays = all(&classes.tight) + classes.tight.true_hit + classes.tight.true_miss;
    let score = |rule, share, interval, wrong| Score { rule, share, interval, wrong, rays };
    vec![
        score("hit_miss", agreement.hit_miss, interval.hit_miss, hit_or_miss(&classes.tight)),
        score("tight", agreement.tight, interval.tight, all(&classes.tight)),
        score("footprint", agreement.footprint, interval.footprint, all(&classes.footprint)),
    ]
}
