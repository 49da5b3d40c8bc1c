//! Tuning a parameter that someone has to choose, so that it shows what the choice costs: its values are judged from a scene's
//! own viewpoint and from another one, and the value that is best on the judged rays stands beside the tracer's default and
//! the value that is best elsewhere.

mod choice;
#[cfg(test)]
mod tests;
mod tuning;

pub use choice::{accuracy, choose};
pub use tuning::{Choice, Judged, Label, SceneTuned, SetTuned, Tuning, ValueTuned, ViewTuned};

use crate::judge::Rule;
use crate::measure::{self, Context, MeasureOptions, RunError, records};
use crate::plan::{Plan, RunPreset, TracerRequest, ViewRequest};
use crate::results::{AxisRecord, Record, SampleSchedule, Skipped, TunedScene, TuningRecord, place_name};
use crate::studies::sweep::{Sweep, SweepError};

/// A parameter of a plan's only tracer, to be tuned.
pub struct Tune {
    plan: Plan,
    request: TracerRequest,
    sweep: Sweep,
    rule: Rule,
}

impl Tune {
    /// Takes the tracer of a plan and the values of one parameter. Nothing is timed, so every trace is counted once.
    ///
    /// # Errors
    /// [`SweepError`] as its variants say.
    pub fn new(plan: &Plan, request: &TracerRequest, axis: AxisRecord, rule: Rule) -> Result<Self, SweepError> {
        let plan = Plan {
            tracers: vec![request.clone()],
            preset: RunPreset { sampling: SampleSchedule::rounds(1), ..plan.preset },
            ..plan.clone()
        };
        let sweep = Sweep::new(&plan, vec![axis], false)?;
        Ok(Self { plan, request: request.clone(), sweep, rule })
    }

    /// Judges every value in every scene from both viewpoints: all values of a scene and viewpoint over the same rays, by one
    /// structure where the parameter is one of the trace. What fails is skipped with the reason.
    ///
    /// # Errors
    /// [`RunError`] as its variants say.
    pub fn execute(mut self, context: &Context<'_>) -> Result<Record, RunError> {
        // What is wrong with the last scene is said before the first is measured.
        drop(measure::load(&self.plan, context.progress)?);
        context.check_rays(&self.plan)?;
        let mut record = measure::begin(std::slice::from_ref(&self.plan), context);
        let mut scenes: Vec<TunedScene> = Vec::new();
        for (index, source) in self.plan.scenes.iter().enumerate().filter(|(index, _)| context.takes(*index)) {
            let own = &self.plan.view;
            for (view, request) in [own.clone(), ViewRequest::Other(Box::new(own.clone()))].into_iter().enumerate() {
                let plan = Plan { scenes: vec![source.clone()], view: request, ..self.plan.clone() };
                let (index, options) = (2 * index + view, MeasureOptions::untimed());
                match measure::measure_plan(index, &plan, &self.sweep.requests, options, None, context) {
                    Ok(found) => {
                        let (before, scene, viewpoint) =
                            (record.rows.len(), found.scene.clone(), found.viewpoint.clone());
                        self.sweep.add(&mut record, found, &place_name(&scene, &viewpoint, view));
                        // Another viewpoint stands beside the own one or nowhere.
                        if record.rows.len() == before {
                            break;
                        }
                        match scenes.last_mut().filter(|_| view > 0) {
                            Some(last) => last.viewpoints.push(viewpoint),
                            None => scenes.push(TunedScene { scene, viewpoints: vec![viewpoint] }),
                        }
                    }
                    Err(error @ RunError::NoOtherView(..)) => {
                        let (scene, reason) = (source.to_string(), error.to_string());
                        record.skipped.push(Skipped { tracer: None, scene, rays: None, reason });
                        break;
                    }
                    Err(error) => return Err(error),
                }
            }
        }
        let tracer = records::request_record(&self.request);
        record.tuning = Some(TuningRecord { tracer, rule: self.rule, scenes });
        self.sweep.finish(record, context)
    }
}
