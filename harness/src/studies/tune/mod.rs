//! Tuning a parameter that someone has to choose, so that it shows what the choice costs: its values are judged from a scene's
//! own viewpoint and from another one, and the value that is best on the judged rays stands beside the tracer's default and
//! the value that is best elsewhere.

mod choice;
mod record;
#[cfg(test)]
mod tests;

pub use choice::{choose, interval, score};
pub use record::{Choice, Judged, Label, SCHEMA, SceneTuned, SetTuned, Tuning, ValueTuned, ViewTuned};

use crate::judge::Rule;
use crate::measure::records;
use crate::measure::{self, RunError};
use crate::plan::{Plan, RunPreset, SceneSource, TracerRequest, ViewRequest};
use crate::progress::Progress;
use crate::registry::Device;
use crate::results::{Run, Skipped, TracerRun};
use crate::studies::sweep::{AxisRecord, Sweep, SweepError};
use crate::truth::Cache;

/// A parameter of a plan's only tracer, to be tuned.
pub struct Tune {
    plan: Plan,
    request: TracerRequest,
    axis: AxisRecord,
    rule: Rule,
}

impl Tune {
    /// Takes the tracer of a plan and the values of one parameter. Nothing is timed, so every trace is counted once.
    ///
    /// # Errors
    /// [`SweepError`] as its variants say.
    pub fn new(plan: &Plan, request: &TracerRequest, axis: AxisRecord, rule: Rule) -> Result<Self, SweepError> {
        let plan =
            Plan { tracers: vec![request.clone()], preset: RunPreset { samples: 1, ..plan.preset }, ..plan.clone() };
        Sweep::new(&plan, vec![axis.clone()], false)?;
        Ok(Self { plan, request: request.clone(), axis, rule })
    }

    /// Judges every value in every scene from both viewpoints: all values of a scene and viewpoint in turn, over the same rays.
    /// What fails is skipped with the reason.
    ///
    /// # Errors
    /// [`RunError`] as its variants say.
    pub fn execute(self, device: &Device, cache: &Cache, progress: &Progress) -> Result<Tuning, RunError> {
        // What is wrong with the last scene is said before the first is measured.
        drop(measure::load(&self.plan, progress)?);
        let begun = measure::begin(std::slice::from_ref(&self.plan), device);
        let mut tuning = Tuning {
            schema: SCHEMA,
            provenance: begun.provenance,
            seed: begun.seed,
            preset: begun.preset,
            ray_parameters: begun.ray_parameters,
            tracer: records::request_record(&self.request),
            axis: self.axis.clone(),
            rule: self.rule,
            scenes: Vec::new(),
            skipped: Vec::new(),
        };
        let own = &self.plan.view;
        for source in &self.plan.scenes {
            for view in [own.clone(), ViewRequest::Other(Box::new(own.clone()))] {
                let is_own = view == *own;
                let plan = Plan { scenes: vec![source.clone()], view, ..self.plan.clone() };
                match self.measure(&plan, device, cache, progress) {
                    Ok(run) => add(&mut tuning, run, is_own),
                    Err(error @ (RunError::Nothing(_) | RunError::NoOtherView { .. })) => {
                        let (scene, reason) = (name_of(source), error.to_string());
                        tuning.skipped.push(Skipped { tracer: None, scene, rays: None, reason });
                        // Another viewpoint stands beside the own one or nowhere.
                        break;
                    }
                    Err(error) => return Err(error),
                }
            }
        }
        if tuning.scenes.is_empty() {
            let reasons: Vec<_> = tuning.skipped.iter().map(|skipped| skipped.reason.as_str()).collect();
            return Err(RunError::Nothing(reasons.join("; ")));
        }
        choose(&mut tuning.scenes, &self.axis.own, self.rule);
        Ok(tuning)
    }

    fn measure(&self, plan: &Plan, device: &Device, cache: &Cache, progress: &Progress) -> Result<Run, RunError> {
        // Looked at when this was made: with the same plan but for scene and viewpoint it cannot fail.
        let sweep =
            Sweep::new(plan, vec![self.axis.clone()], false).map_err(|error| RunError::Nothing(error.to_string()))?;
        sweep.execute(self.request.must_have_device(), device, cache, progress)
    }
}

fn name_of(source: &SceneSource) -> String {
    match source {
        SceneSource::Catalogue(name) => name.clone(),
        SceneSource::File(path) => path.display().to_string(),
    }
}

/// Adds what a sweep in one scene from one viewpoint has measured.
fn add(tuning: &mut Tuning, run: Run, is_own: bool) {
    let Some(first) = run.controls.first().or(run.runs.first()) else { return };
    let (scene, viewpoint) = (first.scene.clone(), first.viewpoint.clone());
    let sets = first.traces.iter().map(|trace| SetTuned {
        rays: trace.rays.clone(),
        rays_sha256: trace.rays_sha256.clone(),
        query: trace.query,
        count: trace.count,
        values: tuning.axis.values.iter().map(|value| judged(&run, &tuning.axis, value, &trace.rays_sha256)).collect(),
        choices: Vec::new(),
    });
    let sets = sets.collect();
    let mut controls: Vec<TracerRun> = Vec::new();
    for control in &run.controls {
        // Points that were tried alone had controls of their own.
        if controls.iter().all(|other| other.tracer != control.tracer) {
            controls.push(control.clone());
        }
    }
    for mut skipped in run.skipped {
        skipped.reason = format!("viewpoint {}: {}", viewpoint.name, skipped.reason);
        tuning.skipped.push(skipped);
    }
    let view = ViewTuned { viewpoint, sets, controls };
    match tuning.scenes.last_mut().filter(|_| !is_own) {
        Some(last) => last.views.push(view),
        None => tuning.scenes.push(SceneTuned { scene, views: vec![view] }),
    }
}

/// What a sweep has judged of a value on a ray set.
fn judged(run: &Run, axis: &AxisRecord, value: &str, rays_sha256: &str) -> ValueTuned {
    let point = run.sweep.as_ref().and_then(|sweep| sweep.point(&axis.name, value, &[]));
    let found = point.and_then(|point| run.runs.iter().find(|one| point.is_of(one)));
    let trace = found.and_then(|one| one.traces.iter().find(|trace| trace.rays_sha256 == rays_sha256));
    let skipped = point.and_then(|point| point.skipped.values().next().cloned());
    let judged = trace.map(|trace| {
        let mut judgement = trace.judgement.clone();
        judgement.wrong_rays_mut().clear();
        Judged { hits_sha256: trace.hits_sha256.clone(), statuses: trace.statuses.clone(), judgement }
    });
    ValueTuned { value: value.to_owned(), judged, skipped }
}
