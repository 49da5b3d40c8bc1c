//! One tracer over values of its parameters and over resolutions: what each costs, and what it gets wrong.

mod axis;
#[cfg(test)]
mod tests;

use std::collections::BTreeMap;

use itertools::Itertools as _;
use tracebench_api::ParameterError;

pub use axis::{MAX_VALUES, Multiple, RESOLUTION, parameter_axis, place, resolution_axis, with_values};

use crate::measure::{self, Context, MeasureOptions, Measured, RunError, records};
use crate::plan::{Plan, Resolution, TracerRequest};
use crate::results::{AxisRecord, PointRecord, Record, Skipped, SweepRecord};

/// The most points of a sweep: a page has room for no more.
pub const MAX_POINTS: usize = 128;

/// Why a sweep cannot be planned. All are faults of what was asked for.
#[derive(Debug, thiserror::Error)]
pub enum SweepError {
    /// A value is not one of the parameter's.
    #[error(transparent)]
    Parameter(ParameterError),
    /// No multiple of a resolution.
    #[error("resolution = '{0}' is not allowed: N or 1/N, with N from 1 to 64")]
    Multiple(String),
    /// A multiple that the preset's resolution, its frame and its faces, does not have.
    #[error(
        "resolution = '{0}' of frame {width}x{height} and faces of {2} has edges that are no whole pixels or too large; \
         choose others with --frame-size and --face-size",
        width = .1[0], height = .1[1]
    )]
    Resolution(String, [u32; 2], u32),
    /// A parameter whose description names no values, and none were given.
    #[error("{0} has no values worth sweeping; give some as {0}=...")]
    NothingToSweep(String),
    /// So many values of an axis: more than a chart has room for.
    #[error("{0} has {1} values, {MAX_VALUES} are the most")]
    TooManyValues(String, usize),
    /// More points than can be held.
    #[error("{0} points, {MAX_POINTS} are the most; sweep fewer values")]
    TooManyPoints(usize),
}

/// A sweep that is ready to run.
pub struct Sweep {
    plan: Plan,
    /// A configuration for every point, in their order.
    pub(super) requests: Vec<TracerRequest>,
    record: SweepRecord,
}

impl Sweep {
    /// Lays out the points of a plan's only tracer: one axis at a time from the tracer's own values, or all combinations.
    ///
    /// # Errors
    /// [`SweepError`] as its variants say.
    pub fn new(plan: &Plan, axes: Vec<AxisRecord>, grid: bool) -> Result<Self, SweepError> {
        let own: BTreeMap<String, String> = axes.iter().map(|axis| (axis.name.clone(), axis.own.clone())).collect();
        let values =
            |axis: &'_ AxisRecord| axis.values.iter().map(|value| (axis.name.clone(), value.clone())).collect();
        let values: Vec<Vec<(String, String)>> = axes.iter().map(values).collect();
        let changed: Vec<Vec<(String, String)>> = if grid {
            check_count(axes.iter().map(|axis| axis.values.len()).product())?;
            values.into_iter().multi_cartesian_product().collect()
        } else {
            values.into_iter().flatten().map(|one| vec![one]).collect()
        };
        let changed = changed.into_iter().map(|changed| own.clone().into_iter().chain(changed).collect());
        let wanted: Vec<BTreeMap<String, String>> = std::iter::once(own.clone()).chain(changed).unique().collect();
        let (mut points, mut requests) = (Vec::new(), Vec::new());
        for (request, values) in plan.tracers.iter().take(1).cartesian_product(wanted) {
            let others = axes.iter().filter(|axis| values[&axis.name] != axis.own);
            let others = others.map(|axis| (&axis.name, &values[&axis.name]));
            let (request, Resolution { frame, face }) = with_values(request, plan.preset, others)?;
            let parameters = records::json_values(&request.parameters);
            points.push(PointRecord { values, parameters, frame, face, skipped: BTreeMap::new() });
            requests.push(request);
        }
        check_count(points.len())?;
        let tracer = plan.tracers.first().map_or_else(String::new, |request| request.name().to_owned());
        Ok(Self { plan: plan.clone(), requests, record: SweepRecord { tracer, grid, axes, points } })
    }

    /// The number of points.
    pub fn size(&self) -> usize {
        self.record.points.len()
    }

    /// Measures every point in every scene; what could not be is skipped with the reason.
    ///
    /// # Errors
    /// As [`measure::execute_all`].
    pub fn execute(mut self, context: &Context<'_>) -> Result<Record, RunError> {
        context.check_rays(&self.plan)?;
        let mut record = measure::begin(std::slice::from_ref(&self.plan), context);
        for (index, scene) in measure::load(&self.plan, context.progress)?.into_iter().enumerate() {
            if context.takes(index) {
                let (plan, options) = (&self.plan, MeasureOptions::timed(&self.plan));
                let found = measure::measure_scene(index, plan, scene, &self.requests, options, None, context)?;
                let name = found.scene.name.clone();
                self.add(&mut record, found, &name);
            }
        }
        self.finish(record, context)
    }

    /// Adds what was measured of every point in one place, which names it where a point is skipped.
    pub(super) fn add(&mut self, record: &mut Record, found: Measured, place: &str) {
        for (point, refusal) in measure::add(record, found) {
            self.record.points[point].skipped.insert(place.to_owned(), refusal.reason);
        }
    }

    /// The record of what was measured, which says of each point that is left out so once, by its values.
    pub(super) fn finish(self, mut record: Record, context: &Context<'_>) -> Result<Record, RunError> {
        for point in &self.record.points {
            let label = point.label(&self.record.axes);
            for (scene, reason) in &point.skipped {
                let reason = if label.is_empty() { reason.clone() } else { format!("{label}: {reason}") };
                let tracer = Some(self.record.tracer.clone());
                record.skipped.push(Skipped { tracer, scene: scene.clone(), rays: None, reason });
            }
        }
        if record.rows.is_empty() && context.shard.is_none() {
            return Err(measure::nothing(&record));
        }
        record.sweep = Some(self.record);
        Ok(record)
    }
}

fn check_count(points: usize) -> Result<(), SweepError> {
    if points > MAX_POINTS { Err(SweepError::TooManyPoints(points)) } else { Ok(()) }
}
