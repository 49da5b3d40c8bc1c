//! From classes to shares, curves and percentiles.

use std::collections::BTreeMap;

use rayon::prelude::*;
use tracebench_api::{Hit, Query, Status};

use super::{Class, Judge, Rule, count_causes, true_counts};
use crate::results::{
    AnyJudgement, ByRule, Classes, ClosestJudgement, OCCLUSION, Occlusion, Percentiles, StatusCounts,
};
use crate::statistics::wilson;
use crate::truth::{Ray64, RayFrame, TrueHit, intersect};

/// Tolerances of the curve, in scene diagonals: two a decade from 1e-8 to 1.
pub const CURVE_TOLERANCES: [f64; 17] =
    [1e-8, 3e-8, 1e-7, 3e-7, 1e-6, 3e-6, 1e-5, 3e-5, 1e-4, 3e-4, 1e-3, 3e-3, 1e-2, 3e-2, 1e-1, 3e-1, 1.0];

impl Judge<'_> {
    pub(super) fn judge_closest(&self, hits: &[Hit]) -> ClosestJudgement {
        let (ambiguous_rays, many_ambiguous_rays) = self.ambiguous();
        let by_rule = Rule::ALL.map(|rule| self.count(self.judged(), rule, hits));
        let without_ambiguous = Rule::ALL.map(|rule| agreement(&self.count(self.unambiguous(), rule, hits)));
        let wrong_tight = self.wrong(Rule::Tight, hits, &[]);
        let wrong_footprint =
            if self.eye.is_some() { self.wrong(Rule::Footprint, hits, &wrong_tight) } else { Vec::new() };
        let causes = [
            ("tight".to_owned(), count_causes(&wrong_tight)),
            ("footprint".to_owned(), count_causes(&wrong_footprint)),
        ];
        let errors = self.position_errors(hits);
        let (shares, intervals) = (by_rule.each_ref().map(agreement), by_rule.each_ref().map(interval));
        let [hit_miss, tight, footprint] = by_rule;
        let judged = ClosestJudgement {
            agreement: shares.into(),
            agreement_without_ambiguous: Some(without_ambiguous.into()),
            interval: intervals.into(),
            truth: Some(true_counts(self.answers)),
            curve: self.curve(&hit_miss, &errors),
            position_error: Percentiles::of(&errors),
            surface_distance: Some(self.surface_distance(hits)),
            identity: self.identity(hits),
            by_status: self.by_status(hits),
            causes: causes.into_iter().collect(),
            wrong_rays: self.wrong_rays(&wrong_tight, hits),
            classes: ByRule { tight, footprint },
            ambiguous_rays,
            many_ambiguous_rays,
        };
        if self.eye.is_some() { judged } else { judged.without_footprint() }
    }

    pub(super) fn judge_any(&self, hits: &[Hit]) -> AnyJudgement {
        let (ambiguous_rays, many_ambiguous_rays) = self.ambiguous();
        let classes = self.count(self.judged(), Rule::HitMiss, hits);
        let wrong = self.wrong(Rule::HitMiss, hits, &[]);
        AnyJudgement {
            occlusion: occlusion(&classes),
            ambiguous_rays,
            many_ambiguous_rays,
            by_status: self.by_status(hits),
            causes: [(OCCLUSION.to_owned(), count_causes(&wrong))].into_iter().collect(),
            wrong_rays: self.wrong_rays(&wrong, hits),
        }
    }

    /// Judged rays by the status of their answers, and the right ones among them.
    fn by_status(&self, hits: &[Hit]) -> BTreeMap<String, StatusCounts> {
        let is_any = self.query == Query::Any;
        let rules: &[Rule] = if is_any { &[Rule::HitMiss] } else { &Rule::ALL };
        let rights = |index: usize| {
            let right = |rule| self.class(rule, index, &hits[index]).is_right();
            if is_any { [right(Rule::HitMiss); 3] } else { Rule::ALL.map(right) }
        };
        let found: Vec<[bool; 3]> = self.judged().map(rights).collect();
        let mut counts = vec![(0, vec![0; rules.len()]); Status::ALL.len()];
        for (index, rights) in self.judged().collect::<Vec<_>>().into_iter().zip(found) {
            let (rays, right) = &mut counts[hits[index].status as usize];
            *rays += 1;
            right.iter_mut().zip(rights).for_each(|(count, is_right)| *count += u64::from(is_right));
        }
        let name = |rule: &Rule| if is_any { OCCLUSION } else { rule.name() }.to_owned();
        let of =
            |(rays, right): (u64, Vec<u64>)| StatusCounts { rays, right: rules.iter().map(name).zip(right).collect() };
        let named = Status::ALL.iter().zip(counts).filter(|(_, (rays, _))| *rays > 0);
        named.map(|(status, counts)| (status.name().to_owned(), of(counts))).collect()
    }

    fn count(&self, rays: impl ParallelIterator<Item = usize>, rule: Rule, hits: &[Hit]) -> Classes {
        let tally = |mut classes: Classes, class: Class| {
            let slot = match class {
                Class::TrueHit => &mut classes.true_hit,
                Class::TrueMiss => &mut classes.true_miss,
                Class::FalseHit => &mut classes.false_hit,
                Class::FalseMiss => &mut classes.false_miss,
                Class::Early => &mut classes.early,
                Class::Late => &mut classes.late,
            };
            *slot += 1;
            classes
        };
        let found: Vec<Class> = rays.map(|index| self.class(rule, index, &hits[index])).collect();
        found.into_iter().fold(Classes::default(), tally)
    }

    /// |t - t*| of every ray that truth and tracer both say hits, scene units; nothing where t lies between those of an ambiguous ray.
    fn position_errors(&self, hits: &[Hit]) -> Vec<f64> {
        self.judged()
            .filter(|index| hits[*index].is_hit())
            .filter_map(|index| {
                let (truth, t) = (self.truth_for(index, &hits[index])?, f64::from(hits[index].t));
                let between = self.answers[index].is_ambiguous() && self.answers[index].has_between(t);
                Some(if between { 0.0 } else { (t - truth.t).abs() })
            })
            .collect()
    }

    fn curve(&self, hit_miss: &Classes, errors: &[f64]) -> Vec<[f64; 2]> {
        let total = total(hit_miss);
        if total == 0 {
            return Vec::new();
        }
        let at = |tolerance: f64| {
            let limit = tolerance * self.truth.diagonal();
            let right = hit_miss.true_miss + errors.iter().filter(|error| **error <= limit).count() as u64;
            [tolerance, right as f64 / total as f64]
        };
        CURVE_TOLERANCES.iter().copied().map(at).collect()
    }

    fn identity(&self, hits: &[Hit]) -> Option<f64> {
        if !self.names_primitives {
            return None;
        }
        let named: Vec<bool> = self
            .judged()
            .filter(|index| self.class(Rule::Tight, *index, &hits[*index]) == Class::TrueHit)
            .map(|index| {
                self.answers[index].all().flatten().any(|truth| self.names(index, truth, hits[index].primitive))
            })
            .collect();
        let right = named.iter().filter(|right| **right).count();
        (!named.is_empty()).then(|| right as f64 / named.len() as f64)
    }

    /// Whether a triangle is the one that a ray truly hits, or one that lies in its place: where two overlap in a plane,
    /// which of them f64's rounding puts in front means nothing.
    pub(super) fn names(&self, index: usize, truth: TrueHit, primitive: u32) -> bool {
        if primitive == truth.primitive {
            return true;
        }
        let ray = Ray64::from(&self.rays[index]);
        let known = (primitive as usize) < self.truth.geometry().triangles.len();
        let t = RayFrame::new(&ray)
            .filter(|_| known)
            .and_then(|frame| intersect(&frame, &ray, self.truth.geometry().corners(primitive)));
        // To the precision that a t in f32 has.
        t.is_some_and(|t| (t - truth.t).abs() <= f64::from(f32::EPSILON) * truth.t)
    }
}

fn total(classes: &Classes) -> u64 {
    let Classes { true_hit, true_miss, false_hit, false_miss, early, late } = classes;
    true_hit + true_miss + false_hit + false_miss + early + late
}

fn agreement(classes: &Classes) -> Option<f64> {
    let total = total(classes);
    (total > 0).then(|| (classes.true_hit + classes.true_miss) as f64 / total as f64)
}

fn interval(classes: &Classes) -> Option<[f64; 2]> {
    wilson(classes.true_hit + classes.true_miss, total(classes))
}

fn occlusion(classes: &Classes) -> Occlusion {
    let (occluded, free) = (classes.true_hit + classes.false_miss, classes.true_miss + classes.false_hit);
    let share = |right: u64, of: u64| (of > 0).then(|| right as f64 / of as f64);
    let mean = |first: Option<f64>, second: Option<f64>| match (first, second) {
        (Some(first), Some(second)) => Some(f64::midpoint(first, second)),
        (one, other) => one.or(other),
    };
    let (occluded_interval, free_interval) = (wilson(classes.true_hit, occluded), wilson(classes.true_miss, free));
    let end = |index: usize| mean(occluded_interval.map(|pair| pair[index]), free_interval.map(|pair| pair[index]));
    Occlusion {
        true_occluded: classes.true_hit,
        true_free: classes.true_miss,
        false_occluded: classes.false_hit,
        false_free: classes.false_miss,
        balanced_accuracy: mean(share(classes.true_hit, occluded), share(classes.true_miss, free)),
        balanced_accuracy_interval: end(0).zip(end(1)).map(|(low, high)| [low, high]),
    }
}
