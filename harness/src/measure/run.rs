//! Plain runs: every configuration of a plan in every scene.

use std::cell::{OnceCell, RefCell};

use itertools::Itertools as _;
use serde::Serialize;
use serde::de::DeserializeOwned;
use tracebench_api::{RayBuffer, TracerError};
use tracebench_scenes::Scene;

use super::controls::Control;
use super::kernels::Kernels;
use super::resident_batch::measure;
use super::workload::{AnimationFrames, Hook, MeasureOptions, Measured, PreparedWorkload, Refusal, Request, Workload};
use super::{Journal, RunError, TracerCache, TracerConfig, load, prepare, records};
use crate::plan::{Plan, Shard, TracerRequest};
use crate::progress::Progress;
use crate::rays::RaySet;
use crate::registry::Device;
use crate::results::{LaunchRecord, Provenance, Record, Row, SCHEMA, Skipped};
use crate::truth::Cache;

/// What everything is measured with.
pub struct Context<'a> {
    /// The device, or why there is none.
    pub device: &'a Device,
    /// Truth that was told before.
    pub cache: &'a Cache,
    /// Who is told what happens.
    pub progress: &'a Progress,
    /// What has ended.
    pub journal: &'a Journal,
    /// Which of the plan's places are measured; all without one.
    pub shard: Option<Shard>,
    /// How searches read and are launched where nothing is set: what the requests have taken.
    pub launch: Option<LaunchRecord>,
    pub(super) tracer_cache: RefCell<TracerCache>,
    kernels: OnceCell<Kernels>,
}

impl<'a> Context<'a> {
    /// Everything, and nothing is kept before all has ended.
    pub fn new(device: &'a Device, cache: &'a Cache, progress: &'a Progress, journal: &'a Journal) -> Self {
        let (tracer_cache, kernels) = (RefCell::default(), OnceCell::new());
        Self { device, cache, progress, journal, shard: None, launch: None, tracer_cache, kernels }
    }

    /// The fixed kernels, made for the first interleaved set that is timed.
    pub(super) fn kernels(&self) -> Result<&Kernels, TracerError> {
        if let Some(made) = self.kernels.get() {
            return Ok(made);
        }
        let made = Kernels::new(self.device.as_ref().ok().map(|gpu| &**gpu))?;
        Ok(self.kernels.get_or_init(|| made))
    }

    /// What the journal keeps under a name, or what is found now, which it keeps then.
    ///
    /// # Errors
    /// What the work says; [`RunError::Journal`] if it cannot be kept.
    pub(crate) fn kept<T: Serialize + DeserializeOwned>(
        &self,
        name: &str,
        work: impl FnOnce() -> Result<T, RunError>,
    ) -> Result<T, RunError> {
        if let Some(kept) = self.journal.read(name)? {
            return Ok(kept);
        }
        let found = work()?;
        self.journal.keep(name, &found)?;
        Ok(found)
    }

    /// Whether a place is measured here.
    pub fn takes(&self, place: usize) -> bool {
        self.shard.as_ref().is_none_or(|shard| shard.takes(place))
    }

    /// Creates a tracer that will be asked for.
    ///
    /// # Errors
    /// What the tracer says.
    pub(crate) fn create(&self, request: &TracerRequest) -> Result<(), TracerError> {
        self.config(request).map(drop)
    }

    /// A tracer without a structure.
    ///
    /// # Errors
    /// What the tracer says.
    pub(crate) fn config(&self, request: &TracerRequest) -> Result<TracerConfig, TracerError> {
        self.tracer_cache.borrow_mut().config(request, self.device)
    }

    /// A device that was lost ends the run: what it did not answer is no property of tracers.
    pub(super) fn check_device(&self) -> Result<(), RunError> {
        match self.device {
            Ok(gpu) if gpu.is_lost() => Err(RunError::Device(TracerError::Failed("the device was lost".to_owned()))),
            _ => Ok(()),
        }
    }

    /// A stand-in for a configuration that cannot be created.
    pub(super) fn absent(&self, request: &TracerRequest) -> TracerConfig {
        let nothing = Control::AlwaysMiss.tracer(Vec::new(), 1.0);
        TracerConfig::ready(request.registration.describe(), request.parameters.clone(), nothing)
    }

    /// That the device can hold the rays of requests which must have one: known before the truth is told, which takes long for
    /// many rays.
    ///
    /// # Errors
    /// [`RunError::Device`] with what to turn down.
    pub(crate) fn check_rays(&self, plan: &Plan, required: bool) -> Result<(), RunError> {
        if let Some(gpu) = self.device.as_ref().ok().filter(|_| required) {
            let [width, height] = plan.preset.ray_image.map(u64::from);
            let saved = plan.ray_sets.iter().filter_map(RaySet::saved).map(|saved| saved.rays.len() as u64).max();
            RayBuffer::check_fits(gpu, saved.unwrap_or(0).max(width * height))?;
        }
        Ok(())
    }
}

/// Runs everything.
///
/// # Errors
/// [`RunError`] as its variants say; interleaved sets that ended are in the journal.
pub fn execute(plan: &Plan, context: &Context<'_>) -> Result<Record, RunError> {
    execute_all(std::slice::from_ref(plan), context)
}

/// Runs plans one after the other into one run, for what no single plan has: several resolutions, or several values of what is said
/// about ray sets. The first tells what is said of the run as a whole. Configurations are interleaved within a plan.
///
/// # Errors
/// [`RunError`] as its variants say; interleaved sets that ended are in the journal.
pub fn execute_all(plans: &[Plan], context: &Context<'_>) -> Result<Record, RunError> {
    let mut record = begin(plans, context);
    for plan in plans {
        context.check_rays(plan, plan.tracers.iter().any(TracerRequest::must_have_device))?;
    }
    let mut index = 0;
    for plan in plans {
        let requests: Vec<Request> = plan.tracers.iter().map(Request::of).collect();
        let mut said = records::json_values(&plan.ray_parameters);
        said.retain(|name, value| record.ray_parameters.get(name) != Some(&*value));
        for (place, scene) in load(plan, context.progress)?.into_iter().enumerate() {
            if context.takes(place) {
                let options = MeasureOptions::timed(plan);
                let found = measure_scene(index, plan, (scene, None), &requests, options, None, context)?.saying(&said);
                for (request, refused) in add(&mut record, found) {
                    refuse(&mut record, &records::request_record(&requests[request].tracer).label(), None, refused);
                }
            }
            index += 1;
        }
    }
    if record.rows.is_empty() && context.shard.is_none() { Err(nothing(&record)) } else { Ok(record) }
}

/// Measures requests from the plan's viewpoint in a scene, which is the last frame of a film, if there is one.
///
/// # Errors
/// [`RunError`] as its variants say.
pub(crate) fn measure_scene(
    index: usize,
    plan: &Plan,
    frame: (Scene, Option<AnimationFrames>),
    requests: &[Request],
    options: MeasureOptions,
    hook: Option<Hook<'_>>,
    context: &Context<'_>,
) -> Result<Measured, RunError> {
    let sha256 = frame.0.sha256.clone();
    let frame = RefCell::new(Some(frame));
    let prepare = || match frame.take() {
        Some((scene, film)) => Ok(PreparedWorkload { film, ..placed(plan, scene, context)? }),
        None => Err(RunError::Nothing("a scene was prepared twice".to_owned())),
    };
    measure(&Workload { index, scene_sha256: Some(&sha256), prepare: &prepare, requests, options, hook }, context)
}

/// A scene from the plan's viewpoint, ready to be measured.
///
/// # Errors
/// [`RunError`] as its variants say.
pub(super) fn placed(plan: &Plan, scene: Scene, context: &Context<'_>) -> Result<PreparedWorkload, RunError> {
    let loaded = prepare(plan, scene, context.device, context.cache, context.progress)?;
    let viewpoint = records::viewpoint_record(plan, &loaded.pose, &loaded.session);
    Ok(PreparedWorkload {
        scene: loaded.record,
        viewpoint,
        difficulty_level: None,
        session: loaded.session,
        film: None,
        told: serde_json::Value::Null,
    })
}

/// A run without anything measured yet; the first plan tells what is said of it as a whole.
pub(crate) fn begin(plans: &[Plan], context: &Context<'_>) -> Record {
    let requests = || plans.iter().flat_map(|plan| &plan.tracers);
    let first = plans.first();
    Record {
        seed: first.map_or(0, |plan| plan.seed),
        preset: first.map_or("", |plan| plan.preset.name).to_owned(),
        table: first.and_then(|plan| plan.table).map(str::to_owned),
        ray_parameters: first.map(|plan| records::json_values(&plan.ray_parameters)).unwrap_or_default(),
        ..empty(requests(), context)
    }
}

/// A record of requests without a plan.
pub(crate) fn empty<'r>(requests: impl IntoIterator<Item = &'r TracerRequest>, context: &Context<'_>) -> Record {
    let needs_adapter = requests.into_iter().any(|request| request.registration.needs_device());
    let gpu = context.device.as_deref().ok().filter(|_| needs_adapter);
    let mut provenance = Provenance::now(gpu);
    let (started, resumed) = context.journal.times();
    if let Some(started) = started {
        started.clone_into(&mut provenance.started);
    }
    provenance.resumed = resumed.to_vec();
    provenance.launch.clone_from(&context.launch);
    provenance.shard = context.shard.as_ref().map(Shard::record);
    Record { schema: SCHEMA, provenance, control_names: Control::names(), ..Record::default() }
}

/// Adds what was measured in a place, and gives who could not be, by request.
pub(crate) fn add(record: &mut Record, found: Measured) -> Vec<(usize, (String, Refusal))> {
    let Measured { scene, controls, rows, anchors, interleaved_sets, skipped, .. } = found;
    let before = record.interleaved_sets.len() as u32;
    let placed = |row: Row| row.with_races_after(before);
    record.skipped.extend(skipped);
    record.controls.extend(controls.into_iter().map(placed));
    record.anchors.extend(anchors.into_iter().map(placed));
    record.interleaved_sets.extend(interleaved_sets);
    let mut refused = Vec::new();
    for (request, row) in rows.into_iter().enumerate() {
        match row {
            Ok(row) => record.rows.push(placed(row)),
            Err(refusal) => refused.push((request, (scene.name.clone(), refusal))),
        }
    }
    refused
}

/// Notes what could not be measured in a scene.
pub(crate) fn refuse(record: &mut Record, tracer: &str, what: Option<&str>, (scene, refusal): (String, Refusal)) {
    let tracer = Some(what.map_or_else(|| tracer.to_owned(), |what| format!("{tracer} ({what})")));
    record.skipped.push(Skipped { tracer, scene, rays: None, reason: refusal.reason });
}

/// The error of a run in which nothing could run, with every reason once.
pub(crate) fn nothing(record: &Record) -> RunError {
    let reason = |skipped: &Skipped| match &skipped.tracer {
        Some(tracer) => format!("{tracer}: {}", skipped.reason),
        None => skipped.reason.clone(),
    };
    RunError::Nothing(record.skipped.iter().map(reason).unique().join("; "))
}
