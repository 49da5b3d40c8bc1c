//! What follows from structures that were shrunk: how far each thing may shrink, and what is needed, stored and touched.

use super::Outcome;
use crate::registrations::Touch;
use crate::registry;
use crate::results::{
    ChangedRays, NeedCurve, NeedPoint, NeedRecord, Ratio, Record, Row, Rule, Timed, TraceRecord, gathered,
};
use crate::statistics::paired_difference;
use crate::studies::tune;
use itertools::Itertools as _;

/// One tracer's structures in one place over one ray set.
#[derive(Clone, Debug)]
pub struct Curve<'a> {
    /// Which.
    pub section: &'a NeedCurve,
    /// The ray set.
    pub rays: &'a str,
    /// The structure as it was asked for.
    pub whole: Step<'a>,
    /// What was shrunk, one thing at a time.
    pub axes: Vec<Axis<'a>>,
    /// Structures with less of several things.
    pub joint: Vec<Step<'a>>,
}

/// One thing of which there is less and less.
#[derive(Clone, Debug)]
pub struct Axis<'a> {
    /// A parameter, or `resolution`.
    pub name: &'a str,
    /// From the largest on; those that turned out larger than the whole structure are none.
    pub steps: Vec<Step<'a>>,
}

/// A structure.
#[derive(Clone, Debug)]
pub struct Step<'a> {
    /// As the record has it.
    pub point: &'a NeedPoint,
    /// Its row; none where it could not be measured.
    pub row: Option<&'a Row>,
    /// Its trace of the rays.
    pub trace: Option<&'a TraceRecord>,
    /// How its answers differ from those of the whole structure; none of the whole one itself, and of what was not measured.
    pub changed: Option<ChangedRays>,
    /// How many times as long as of the whole structure its traces take.
    pub times_as_long: Option<Ratio>,
    rule: Rule,
    /// Where a structure is too small.
    limits: &'a NeedRecord,
}

impl<'a> Step<'a> {
    /// The share of rays that are rightly answered by the curve's rule, with its interval; none where nothing was judged.
    pub fn right(&self) -> Option<(f64, [f64; 2])> {
        let right = tune::accuracy(&self.trace?.judgement, self.rule)?;
        right.share.zip(right.interval)
    }

    /// Newly wrong less newly right rays, a share with its 95 % interval.
    pub fn lost(&self) -> Option<(f64, [f64; 2])> {
        let ChangedRays { rays, newly_wrong, newly_right } = self.changed?;
        paired_difference(newly_wrong, newly_right, rays)
    }

    /// Whether the answers are as good as those of the whole structure, as far as so many rays can tell; `in_time`: and its traces do not
    /// take much longer.
    pub fn is_enough(&self, in_time: bool) -> bool {
        let is_quick = self.times_as_long.is_none_or(|ratio| ratio.value <= self.limits.max_slowdown);
        self.lost().is_some_and(|(_, [_, upper])| upper <= self.limits.max_lost_share) && (is_quick || !in_time)
    }

    /// The same by answers alone, where these were compared, and whether they tell.
    pub fn outcome(&self) -> Option<Outcome> {
        let (_, [lower, _]) = self.lost()?;
        Some(match self.is_enough(false) {
            true => Outcome::Enough,
            false if lower > self.limits.max_lost_share => Outcome::NotEnough,
            false => Outcome::Undecided,
        })
    }

    /// Allocated bytes of the structure.
    pub fn bytes(&self) -> Option<u64> {
        Some(self.row?.memory.structure_bytes)
    }

    /// Bytes of the structure that any of the rays touched, as far as counters tell; none where none does.
    pub fn touched_bytes(&self) -> Option<f64> {
        let (row, trace) = (self.row?, self.trace?);
        let touches = &registry::find(&row.tracer.name)?.touches;
        let mut told = touches.iter().filter_map(|touch| touched(row, trace, touch)).peekable();
        told.peek()?;
        Some(told.sum())
    }

    /// The value on an axis.
    fn value(&self, axis: &str) -> Option<&'a str> {
        self.point.shrunk.get(axis).map(String::as_str)
    }
}

/// The share of what is stored that was touched, of the bytes of what it lies in.
fn touched(row: &Row, trace: &TraceRecord, touch: &Touch) -> Option<f64> {
    let counter = trace.counters.get(touch.counter)?;
    let stored = row.structure_statistics.get(touch.stored).filter(|stored| **stored > 0.0)?;
    let part = |name: &&'static str| row.memory.structure.iter().find(|part| part.name == *name);
    let bytes = touch.parts.iter().find_map(part)?.used_bytes;
    Some((counter.total as f64 / stored).min(1.0) * bytes as f64)
}

impl<'a> Axis<'a> {
    /// How far it may shrink by answers alone; `in_time`: where traces must not take much longer, either. The smallest value that does, none
    /// if not even the first step does, and the value that does no longer, none if every step does.
    pub fn need(&self, in_time: bool) -> [Option<&'a str>; 2] {
        let too_small = self.measured().find(|step| !step.is_enough(in_time));
        [self.enough(in_time).last(), too_small].map(|step| step?.value(self.name))
    }

    /// Steps before the first that is not enough.
    fn enough(&self, in_time: bool) -> impl Iterator<Item = &Step<'a>> {
        self.measured().take_while(move |step| step.is_enough(in_time))
    }

    fn measured(&self) -> impl Iterator<Item = &Step<'a>> {
        self.steps.iter().filter(|step| step.changed.is_some())
    }
}

impl<'a> Curve<'a> {
    /// The most that may be lost without a single answer that changed, by the upper end of the interval over so many rays; where that is
    /// more than is allowed, steps may fail for want of rays.
    pub fn unseen_loss(&self) -> Option<(u64, f64)> {
        let rays = self.steps().find_map(|step| step.changed)?.rays;
        let (_, [_, upper]) = paired_difference(0, 0, rays)?;
        (upper > self.whole.limits.max_lost_share).then_some((rays, upper))
    }

    /// Every smaller structure.
    pub fn steps(&self) -> impl Iterator<Item = &Step<'a>> {
        self.axes.iter().flat_map(|axis| &axis.steps).chain(&self.joint)
    }

    /// The structure of the fewest bytes that is enough, the whole one among them.
    pub fn needed(&self, in_time: bool) -> &Step<'a> {
        let of_axes = self.axes.iter().flat_map(|axis| axis.enough(in_time));
        let enough = of_axes.chain(self.joint.iter().filter(|step| step.is_enough(in_time)));
        let bytes = |step: &&Step<'a>| step.bytes().unwrap_or(u64::MAX);
        std::iter::once(&self.whole).chain(enough).min_by_key(bytes).unwrap_or(&self.whole)
    }
}

/// Every curve of a record, by ray set.
pub fn curves<'a>(record: &'a Record, section: &'a NeedRecord) -> Vec<Curve<'a>> {
    section.curves.iter().flat_map(|curve| of_record(record, section, curve)).collect()
}

/// The curves of one tracer in one place.
pub(super) fn of_record<'a>(record: &'a Record, limits: &'a NeedRecord, curve: &'a NeedCurve) -> Vec<Curve<'a>> {
    let rows: Vec<&Row> = record.rows.iter().filter(|row| curve.holds(row)).collect();
    let Some(whole) = curve.points.first() else { return Vec::new() };
    let Some(own) = rows.iter().copied().find(|row| whole.is_of(row)) else { return Vec::new() };
    let step = |point: &'a NeedPoint, rays: &str| {
        let row = rows.iter().copied().find(|row| point.is_of(row));
        let trace = row.and_then(|row| trace_of(row, rays));
        let changed = point.changed.get(rays).copied().filter(|_| !point.shrunk.is_empty());
        // The whole structure that was timed beside it: it is in every place of the tracer.
        let times_as_long = row.zip(trace).and_then(|(row, trace)| {
            let wholes = rows.iter().copied().filter(|row| whole.is_of(row));
            let mut wholes = wholes.filter_map(|row| Some((row, trace_of(row, rays)?)));
            let (beside, other) =
                wholes.find(|(_, other)| other.times.interleaved_set == trace.times.interleaved_set)?;
            record.paired(&Timed::trace(row, trace), &Timed::trace(beside, other)).ratio
        });
        Step { point, row, trace, changed, times_as_long, rule: curve.rule, limits }
    };
    let of_set = |trace: &'a TraceRecord| {
        let rays = trace.rays.as_str();
        let alone = |point: &'a NeedPoint| Some((point.shrunk.keys().exactly_one().ok()?.as_str(), step(point, rays)));
        // Where a tracer works its own value out, what is smaller than that is told by its bytes.
        let is_larger = |step: &Step<'_>| step.bytes().is_some_and(|bytes| bytes > own.memory.structure_bytes);
        let alone = curve.points.iter().filter_map(alone).filter(|(_, step)| !is_larger(step));
        let axes = gathered(alone).into_iter().map(|(name, steps)| Axis { name, steps }).collect();
        let joint = curve.points.iter().filter(|point| point.shrunk.len() > 1).map(|point| step(point, rays)).collect();
        Curve { section: curve, rays, whole: step(whole, rays), axes, joint }
    };
    own.traces.iter().map(of_set).collect()
}

fn trace_of<'r>(row: &'r Row, rays: &str) -> Option<&'r TraceRecord> {
    row.traces.iter().find(|trace| trace.rays == rays)
}
