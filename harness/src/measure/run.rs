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
use super::workload::{Hook, MeasureOptions, Measured, PreparedWorkload, Refusal, Workload};
use super::{Journal, RunError, TracerCache, TracerConfig, load, prepare, records};
use crate::plan::{Plan, TracerRequest};
use crate::progress::Progress;
use crate::rays::RaySet;
use crate::registry::Device;
use crate::results::{CONTROL_NAMES, LaunchRecord, Provenance, Record, Row, SCHEMA, ShardRecord, Skipped};
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
    pub shard: Option<ShardRecord>,
    /// How searches read and are launched where nothing is set: what the requests have taken.
    pub launch: Option<LaunchRecord>,
    tracer_cache: RefCell<TracerCache>,
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

    /// A tracer without a structure.
    ///
    /// # Errors
    /// What the tracer says.
    pub(crate) fn config(&self, request: &TracerRequest) -> Result<TracerConfig, TracerError> {
        self.tracer_cache.borrow_mut().config(request, self.device)
    }

    /// The same, or a stand-in for a tracer that cannot be created, with the reason.
    ///
    /// # Errors
    /// What a tracer says that must run, where no other one is asked for: then there is nothing left that could be measured.
    pub(super) fn config_or_refusal(
        &self,
        request: &TracerRequest,
        all: &[TracerRequest],
    ) -> Result<(TracerConfig, Option<Refusal>), RunError> {
        match self.config(request) {
            Ok(config) => Ok((config, None)),
            Err(error) if request.required && all.iter().all(|other| other.name() == request.name()) => {
                Err(RunError::Tracer(request.name().to_owned(), error))
            }
            Err(error) => {
                let nothing = Control::AlwaysMiss.tracer(Vec::new(), 1.0);
                let config = TracerConfig::ready(request.registration.describe(), request.parameters.clone(), nothing);
                Ok((config, Some(Refusal::of(&error, false))))
            }
        }
    }

    /// A device that was lost ends the run: what it did not answer is no property of tracers.
    pub(super) fn check_device(&self) -> Result<(), RunError> {
        match self.device {
            Ok(gpu) if gpu.is_lost() => Err(RunError::Device(TracerError::Failed("the device was lost".to_owned()))),
            _ => Ok(()),
        }
    }

    /// That the device can hold the rays of requests which must have one: known before the truth is told, which takes long for
    /// many rays.
    ///
    /// # Errors
    /// [`RunError::Device`] with what to turn down.
    pub(crate) fn check_rays(&self, plan: &Plan) -> Result<(), RunError> {
        let required = plan.tracers.iter().any(TracerRequest::must_have_device);
        if let Some(gpu) = self.device.as_ref().ok().filter(|_| required) {
            let [width, height] = plan.preset.ray_image.map(u64::from);
            let saved = plan.ray_sets.iter().filter_map(RaySet::saved).map(|saved| saved.rays.len() as u64).max();
            RayBuffer::check_fits(gpu, saved.unwrap_or(0).max(width * height))?;
        }
        Ok(())
    }
}

/// Runs plans one after the other into one run, for what no single plan has: several resolutions, or several values of what is said
/// about ray sets. The first tells what is said of the run as a whole. Configurations are interleaved within a plan.
///
/// # Errors
/// [`RunError`] as its variants say; interleaved sets that ended are in the journal.
pub fn execute_all(plans: &[Plan], context: &Context<'_>) -> Result<Record, RunError> {
    let mut record = begin(plans, context);
    for plan in plans {
        context.check_rays(plan)?;
    }
    let mut index = 0;
    for plan in plans {
        let mut said = records::json_values(&plan.ray_parameters);
        said.retain(|name, value| record.ray_parameters.get(name) != Some(&*value));
        for (place, scene) in load(plan, context.progress)?.into_iter().enumerate() {
            if context.takes(place) {
                let options = MeasureOptions::timed(plan);
                let found = measure_scene(index, plan, scene, &plan.tracers, options, None, context)?.saying(&said);
                add_or_skip(&mut record, found, &plan.tracers);
            }
            index += 1;
        }
    }
    filled(record, context)
}

/// Measures requests from the plan's viewpoint in a scene.
pub(crate) fn measure_scene(
    index: usize,
    plan: &Plan,
    scene: Scene,
    requests: &[TracerRequest],
    options: MeasureOptions,
    hook: Option<Hook<'_>>,
    context: &Context<'_>,
) -> Result<Measured, RunError> {
    let sha256 = scene.sha256.clone();
    let prepare = Box::new(|| placed(plan, scene, context));
    measure(Workload { index, scene_sha256: Some(&sha256), prepare, requests, options, hook }, context)
}

/// The same in the plan's only scene, which is loaded.
pub(crate) fn measure_plan(
    index: usize,
    plan: &Plan,
    requests: &[TracerRequest],
    options: MeasureOptions,
    hook: Option<Hook<'_>>,
    context: &Context<'_>,
) -> Result<Measured, RunError> {
    let scene = load(plan, context.progress)?.pop();
    let scene = scene.ok_or_else(|| RunError::Nothing("no scene was asked for".to_owned()))?;
    measure_scene(index, plan, scene, requests, options, hook, context)
}

/// A scene from the plan's viewpoint, ready to be measured.
pub(super) fn placed(plan: &Plan, scene: Scene, context: &Context<'_>) -> Result<PreparedWorkload, RunError> {
    prepare(plan, scene, context.device, context.cache, context.progress)
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
    provenance.shard.clone_from(&context.shard);
    let control_names = CONTROL_NAMES.map(str::to_owned).into();
    Record { schema: SCHEMA, provenance, control_names, ..Record::default() }
}

/// Adds what was measured in a place, and gives who could not be, by request.
pub(crate) fn add(record: &mut Record, found: Measured) -> Vec<(usize, Refusal)> {
    let Measured { controls, rows, anchors, interleaved_sets, skipped, .. } = found;
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
            Err(refusal) => refused.push((request, refusal)),
        }
    }
    refused
}

/// Adds what was measured in a place, and notes which tracers could not be.
pub(crate) fn add_or_skip(record: &mut Record, found: Measured, requests: &[TracerRequest]) {
    let scene = found.scene.name.clone();
    for (request, Refusal { reason, .. }) in add(record, found) {
        let tracer = Some(records::request_record(&requests[request]).label());
        record.skipped.push(Skipped { tracer, scene: scene.clone(), rays: None, reason });
    }
}

/// A record in which something ran; nothing may be left for a shard.
pub(crate) fn filled(record: Record, context: &Context<'_>) -> Result<Record, RunError> {
    if record.rows.is_empty() && context.shard.is_none() { Err(nothing(&record)) } else { Ok(record) }
}

/// The error of a run in which nothing could run, with every reason once.
pub(crate) fn nothing(record: &Record) -> RunError {
    let reason = |skipped: &Skipped| match &skipped.tracer {
        Some(tracer) => format!("{tracer}: {}", skipped.reason),
        None => skipped.reason.clone(),
    };
    RunError::Nothing(record.skipped.iter().map(reason).unique().join("; "))
}
