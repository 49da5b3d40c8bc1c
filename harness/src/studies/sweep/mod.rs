//! One tracer over values of its parameters and over resolutions: what each costs, and what it gets wrong. Or, untimed and from another
//! viewpoint, too: what a value that someone has to choose gets wrong.

mod axis;
#[cfg(test)]
mod tests;

use std::collections::BTreeMap;

use itertools::Itertools as _;
use tracebench_api::ParameterError;

pub use axis::{MAX_VALUES, Multiple, RESOLUTION, parameter_axis, place, resolution_axis, with_values};

use crate::judge::Rule;
use crate::measure::{self, Context, MeasureOptions, RunError, records};
use crate::plan::{Plan, Resolution, TracerRequest, ViewRequest};
use crate::results::{AxisRecord, PointRecord, Record, Skipped, SweepRecord, TunedScene, TuningRecord, place_name};

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
    requests: Vec<TracerRequest>,
    record: SweepRecord,
    /// Of one by which a value is chosen.
    tuning: Option<TuningRecord>,
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
        let record = SweepRecord { tracer, grid, axes, points };
        Ok(Self { plan: plan.clone(), requests, record, tuning: None })
    }

    /// The same for a value to be chosen by a rule: every scene is seen from another viewpoint, too, and nothing is timed.
    #[must_use]
    pub fn choosing(self, rule: Rule) -> Self {
        let tracer = self.plan.tracers.first().map(records::request_record);
        Self { tuning: tracer.map(|tracer| TuningRecord { tracer, rule, scenes: Vec::new() }), ..self }
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
        let own = self.plan.view.clone();
        let (options, views) = match &self.tuning {
            None => (MeasureOptions::timed(&self.plan), vec![own]),
            Some(_) => (MeasureOptions::untimed(), vec![own.clone(), ViewRequest::Other(Box::new(own))]),
        };
        let scenes = measure::load(&self.plan, context.progress)?.into_iter().enumerate();
        for (place, scene) in scenes.filter(|(place, _)| context.takes(*place)) {
            for ((view, request), scene) in views.iter().enumerate().zip(std::iter::repeat_n(scene, views.len())) {
                let (index, name) = (views.len() * place + view, scene.name.clone());
                let plan = Plan { view: request.clone(), ..self.plan.clone() };
                let found = match measure::measure_scene(index, &plan, scene, &self.requests, options, None, context) {
                    Err(error @ RunError::NoOtherView(..)) => {
                        let reason = error.to_string();
                        record.skipped.push(Skipped { tracer: None, scene: name, rays: None, reason });
                        break;
                    }
                    found => found?,
                };
                let (scene, viewpoint, before) = (found.scene.clone(), found.viewpoint.clone(), record.rows.len());
                let place = place_name(&scene, &viewpoint, view);
                for (point, refusal) in measure::add(&mut record, found) {
                    self.record.points[point].skipped.insert(place.clone(), refusal.reason);
                }
                // Another viewpoint stands beside the own one or nowhere.
                if record.rows.len() == before {
                    break;
                }
                if let Some(tuning) = &mut self.tuning {
                    match tuning.scenes.last_mut().filter(|_| view > 0) {
                        Some(last) => last.viewpoints.push(viewpoint),
                        None => tuning.scenes.push(TunedScene { scene, viewpoints: vec![viewpoint] }),
                    }
                }
            }
        }
        // Of each point that is left out it is said once, by its values.
        for point in &self.record.points {
            let label = point.label(&self.record.axes);
            for (scene, reason) in &point.skipped {
                let reason = if label.is_empty() { reason.clone() } else { format!("{label}: {reason}") };
                let tracer = Some(self.record.tracer.clone());
                record.skipped.push(Skipped { tracer, scene: scene.clone(), rays: None, reason });
            }
        }
        (record.sweep, record.tuning) = (Some(self.record), self.tuning);
        measure::filled(record, context)
    }
}

fn check_count(points: usize) -> Result<(), SweepError> {
    if points > MAX_POINTS { Err(SweepError::TooManyPoints(points)) } else { Ok(()) }
}
