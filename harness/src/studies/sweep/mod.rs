//! One tracer over values of its parameters and over resolutions: what each costs, and what it gets wrong.

mod axis;
mod record;
#[cfg(test)]
mod tests;

use std::collections::BTreeMap;

use tracebench_api::{ParameterError, RayBuffer};

pub use axis::{MOST_VALUES, Multiple, RESOLUTION, parameter_axis, resolution_axis};
pub use record::{AxisRecord, PointRecord, SweepRecord};

use crate::measure::records;
use crate::measure::{self, Refused, RunError};
use crate::plan::{Plan, Resolution, RunPreset, TracerRequest};
use crate::progress::Progress;
use crate::registry::Device;
use crate::results::{Run, Skipped};
use crate::truth::Cache;

/// The most points of a sweep: every structure is held at once.
pub const MOST_POINTS: usize = 128;

/// Why a sweep cannot be planned. All are faults of what was asked for.
#[derive(Debug, thiserror::Error)]
pub enum SweepError {
    /// A value is not one of the parameter's.
    #[error(transparent)]
    Parameter(ParameterError),
    /// No multiple of a resolution.
    #[error("resolution = '{0}' is not allowed: N or 1/N, with N from 1 to 64")]
    Multiple(String),
    /// A multiple that the preset's resolution does not have.
    #[error(
        "resolution = '{multiple}' of frame {}x{} and faces of {face} has edges that are no whole pixels or too large; \
         choose others with --frame and --face",
        frame[0], frame[1]
    )]
    Resolution {
        /// The multiple.
        multiple: String,
        /// The preset's frame.
        frame: [u32; 2],
        /// The preset's faces.
        face: u32,
    },
    /// A parameter whose description names no values, and none were given.
    #[error("{0} has no values worth sweeping; give some as {0}=...")]
    NothingToSweep(String),
    /// More values than a chart has room for.
    #[error("{name} has {values} values, {MOST_VALUES} are the most")]
    TooManyValues {
        /// The axis.
        name: String,
        /// Its number of values.
        values: usize,
    },
    /// More points than can be held.
    #[error("{0} points, {MOST_POINTS} are the most; sweep fewer values")]
    TooManyPoints(usize),
}

/// A sweep that is ready to run.
pub struct Sweep {
    /// A contender for every point, in their order.
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
        // Not being able to measure a point is no error.
        let mut request = TracerRequest { required: false, ..request.clone() };
        let mut preset = self.plan.preset;
        for axis in &self.record.axes {
            let value = values.get(&axis.name).unwrap_or(&axis.own);
            if axis.name == RESOLUTION {
                let multiple = Multiple::parse(value).ok_or_else(|| SweepError::Multiple(value.clone()))?;
                preset = multiple.scale(self.plan.preset)?;
            } else if *value != axis.own {
                request.set(&axis.name, value).map_err(SweepError::Parameter)?;
            }
        }
        let RunPreset { frame, face, .. } = preset;
        request.resolution = Some(Resolution { frame, face });
        let parameters = records::json_values(&request.parameters);
        self.record.points.push(PointRecord { values, parameters, frame, face, skipped: BTreeMap::new() });
        self.plan.tracers.push(request);
        Ok(())
    }

    /// The number of points.
    pub fn len(&self) -> usize {
        self.record.points.len()
    }

    /// Whether there is nothing to measure.
    pub fn is_empty(&self) -> bool {
        self.record.points.is_empty()
    }

    /// Measures every point in every scene. What fails beside others is tried once more alone, since all structures are
    /// held at once; what fails then is skipped with the reason.
    ///
    /// # Errors
    /// As [`measure::execute`].
    pub fn execute(
        mut self,
        required: bool,
        device: &Device,
        cache: &Cache,
        progress: &Progress,
    ) -> Result<Run, RunError> {
        if let Some(gpu) = device.as_ref().ok().filter(|_| required) {
            let [width, height] = self.plan.preset.ray_image.map(u64::from);
            RayBuffer::check_fits(gpu, width * height)?;
        }
        let plan = &self.plan;
        let mut run = measure::begin(std::slice::from_ref(plan), device);
        let mut refused = measure::execute_into(&mut run, std::slice::from_ref(plan), device, cache, progress)?;
        if plan.tracers.len() > 1 {
            let mut still = Vec::new();
            for one in refused {
                let tracers = vec![plan.tracers[one.contender].clone()];
                let alone = Plan { tracers, scenes: vec![plan.scenes[one.scene_index].clone()], ..plan.clone() };
                let again = measure::execute_into(&mut run, &[alone], device, cache, progress)?;
                still.extend(again.into_iter().map(|again| Refused { contender: one.contender, ..again }));
            }
            refused = still;
        }
        for one in refused {
            self.record.points[one.contender].skipped.insert(one.scene, one.error.to_string());
        }
        self.say_skipped(&mut run);
        if run.runs.is_empty() {
            return Err(measure::nothing(&run));
        }
        run.sweep = Some(self.record);
        Ok(run)
    }

    /// In place of what was said while points were tried: each that is left out once, by its values.
    fn say_skipped(&self, run: &mut Run) {
        run.skipped.retain(|skipped| skipped.tracer.is_none());
        let mut said: Vec<Skipped> = Vec::new();
        for skipped in run.skipped.drain(..) {
            if !said.contains(&skipped) {
                said.push(skipped);
            }
        }
        for point in &self.record.points {
            let label = point.label(&self.record.axes);
            for (scene, reason) in &point.skipped {
                let reason = if label.is_empty() { reason.clone() } else { format!("{label}: {reason}") };
                let tracer = Some(self.record.tracer.clone());
                said.push(Skipped { tracer, scene: scene.clone(), rays: None, reason });
            }
        }
        run.skipped = said;
    }
}

fn check_count(points: usize) -> Result<(), SweepError> {
    if points > MOST_POINTS { Err(SweepError::TooManyPoints(points)) } else { Ok(()) }
}
