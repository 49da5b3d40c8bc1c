//! One tracer over values of its parameters and over resolutions: what each costs, and what it gets wrong.

mod axis;
#[cfg(test)]
mod tests;

use std::collections::BTreeMap;

use tracebench_api::ParameterError;
use tracebench_scenes::Scene;

pub use axis::{MAX_VALUES, Multiple, RESOLUTION, parameter_axis, resolution_axis, with_values};

use crate::measure::{self, Context, MeasureOptions, Measured, Request, RunError, records};
use crate::plan::{Plan, Resolution, TracerRequest};
use crate::results::{AxisRecord, PointRecord, Record, SceneRecord, Skipped, SweepRecord, ViewpointRecord};

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

/// Where points are measured.
pub(super) struct PreparedWorkload<'a> {
    /// Its place in the plan.
    pub index: usize,
    /// The plan with the viewpoint.
    pub plan: &'a Plan,
    /// The scene.
    pub scene: Scene,
    /// How much is done for every point.
    pub options: MeasureOptions,
}

/// A sweep that is ready to run.
pub struct Sweep {
    /// A configuration for every point, in their order.
    plan: Plan,
    record: SweepRecord,
}

impl Sweep {
    /// Lays out the points of a plan's only tracer: one axis at a time from the tracer's own values, or all combinations.
    ///
    /// # Errors
    /// [`SweepError`] as its variants say.
    pub fn new(plan: &Plan, axes: Vec<AxisRecord>, grid: bool) -> Result<Self, SweepError> {
        let own: BTreeMap<String, String> = axes.iter().map(|axis| (axis.name.clone(), axis.own.clone())).collect();
        let mut wanted = vec![own.clone()];
        if grid {
            let count = axes.iter().map(|axis| axis.values.len()).product();
            check_count(count)?;
            let mut combined = vec![own];
            for axis in &axes {
                let with = |point: &BTreeMap<String, String>, value: &String| {
                    point.clone().into_iter().chain([(axis.name.clone(), value.clone())]).collect()
                };
                combined = combined.iter().flat_map(|point| axis.values.iter().map(move |v| with(point, v))).collect();
            }
            wanted.extend(combined);
        } else {
            for axis in &axes {
                let with = |value: &String| [(axis.name.clone(), value.clone())];
                wanted.extend(axis.values.iter().map(|value| own.clone().into_iter().chain(with(value)).collect()));
            }
        }
        let mut sweep = Self {
            plan: Plan { tracers: Vec::new(), ..plan.clone() },
            record: SweepRecord { tracer: String::new(), grid, axes, points: Vec::new() },
        };
        let Some(request) = plan.tracers.first() else { return Ok(sweep) };
        sweep.record.tracer = request.name().to_owned();
        for values in wanted {
            if sweep.record.points.iter().all(|point| point.values != values) {
                sweep.add(request, values)?;
            }
        }
        check_count(sweep.record.points.len())?;
        Ok(sweep)
    }

    fn add(&mut self, request: &TracerRequest, values: BTreeMap<String, String>) -> Result<(), SweepError> {
        let others = self.record.axes.iter().filter_map(|axis| {
            let value = values.get(&axis.name)?;
            (*value != axis.own).then_some((&axis.name, value))
        });
        let (request, Resolution { frame, face }) = with_values(request, self.plan.preset, others)?;
        let parameters = records::json_values(&request.parameters);
        self.record.points.push(PointRecord { values, parameters, frame, face, skipped: BTreeMap::new() });
        self.plan.tracers.push(request);
        Ok(())
    }

    /// The number of points.
    pub fn size(&self) -> usize {
        self.record.points.len()
    }

    /// Measures every point in every scene; what could not be is skipped with the reason.
    ///
    /// # Errors
    /// As [`measure::execute`].
    pub fn execute(mut self, required: bool, context: &Context<'_>) -> Result<Record, RunError> {
        context.check_rays(&self.plan, required)?;
        let mut record = measure::begin(std::slice::from_ref(&self.plan), context);
        for (index, scene) in measure::load(&self.plan, context.progress)?.into_iter().enumerate() {
            if context.takes(index) {
                let (plan, options) = (self.plan.clone(), MeasureOptions::timed(&self.plan));
                let prepared = PreparedWorkload { index, plan: &plan, scene, options };
                self.measure(prepared, &|found| found.scene.name.clone(), &mut record, context)?;
            }
        }
        self.finish(record, context)
    }

    /// Measures every point in one place, and gives scene and viewpoint. `place` names it where a point is skipped.
    pub(super) fn measure(
        &mut self,
        PreparedWorkload { index, plan, scene, options }: PreparedWorkload<'_>,
        place: &dyn Fn(&Measured) -> String,
        run: &mut Record,
        context: &Context<'_>,
    ) -> Result<(SceneRecord, ViewpointRecord), RunError> {
        let requests: Vec<Request> = self.plan.tracers.iter().map(Request::of).collect();
        let found = measure::measure_scene(index, plan, (scene, None), &requests, options, None, context)?;
        let (told, name) = ((found.scene.clone(), found.viewpoint.clone()), place(&found));
        for (point, (_, refusal)) in measure::add(run, found) {
            self.record.points[point].skipped.insert(name.clone(), refusal.reason);
        }
        Ok(told)
    }

    /// The record of what was measured.
    pub(super) fn finish(self, mut record: Record, context: &Context<'_>) -> Result<Record, RunError> {
        self.say_skipped(&mut record);
        if record.rows.is_empty() && context.shard.is_none() {
            return Err(measure::nothing(&record));
        }
        record.sweep = Some(self.record);
        Ok(record)
    }

    /// Says of each point that is left out so once, by its values.
    fn say_skipped(&self, record: &mut Record) {
        for point in &self.record.points {
            let label = point.label(&self.record.axes);
            for (scene, reason) in &point.skipped {
                let reason = if label.is_empty() { reason.clone() } else { format!("{label}: {reason}") };
                let tracer = Some(self.record.tracer.clone());
                record.skipped.push(Skipped { tracer, scene: scene.clone(), rays: None, reason });
            }
        }
    }
}

fn check_count(points: usize) -> Result<(), SweepError> {
    if points > MAX_POINTS { Err(SweepError::TooManyPoints(points)) } else { Ok(()) }
}
