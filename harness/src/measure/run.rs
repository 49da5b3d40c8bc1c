//! Plain runs: every contender of a plan in every scene.

use std::cell::{OnceCell, RefCell};

use itertools::Itertools as _;
use tracebench_api::{RayBuffer, TracerError};
use tracebench_scenes::Scene;

use super::controls::Control;
use super::kernels::Kernels;
use super::place::{Effort, Film, Hook, Measured, Place, Placed, Refusal, Request};
use super::window::measure;
use super::{Contender, Crew, Journal, RunError, load, prepare, records};
use crate::plan::{Plan, Shard, TracerRequest};
use crate::progress::Progress;
use crate::registry::Device;
use crate::results::{MeansRecord, Provenance, Run, SCHEMA, Skipped, TracerRun};
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
    pub means: Option<MeansRecord>,
    pub(super) crew: RefCell<Crew>,
    kernels: OnceCell<Kernels>,
}

impl<'a> Context<'a> {
    /// Everything, and nothing is kept before all has ended.
    pub fn new(device: &'a Device, cache: &'a Cache, progress: &'a Progress, journal: &'a Journal) -> Self {
        let (crew, kernels) = (RefCell::default(), OnceCell::new());
        Self { device, cache, progress, journal, shard: None, means: None, crew, kernels }
    }

    /// A part of the places alone.
    #[must_use]
    pub fn of_shard(self, shard: Option<Shard>) -> Self {
        Self { shard, ..self }
    }

    /// With means that the requests have taken.
    #[must_use]
    pub fn with_means(self, means: Option<MeansRecord>) -> Self {
        Self { means, ..self }
    }

    /// The fixed kernels, made for the first race that is timed.
    pub(super) fn kernels(&self) -> Result<&Kernels, TracerError> {
        if let Some(made) = self.kernels.get() {
            return Ok(made);
        }
        let made = Kernels::new(self.device.as_ref().ok().map(|gpu| &**gpu))?;
        Ok(self.kernels.get_or_init(|| made))
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
        self.crew.borrow_mut().contender(request, self.device).map(drop)
    }

    /// A stand-in for a contender that cannot be created.
    pub(super) fn absent(&self, request: &TracerRequest) -> Contender {
        let nothing = Control::AlwaysMiss.tracer(Vec::new(), 1.0);
        Contender::ready((request.registration.describe)(), request.parameters.clone(), nothing)
    }

    /// That the device can hold the rays of requests which must have one: known before the truth is told, which takes long for
    /// many rays.
    ///
    /// # Errors
    /// [`RunError::Device`] with what to turn down.
    pub(crate) fn check_rays(&self, plan: &Plan, required: bool) -> Result<(), RunError> {
        if let Some(gpu) = self.device.as_ref().ok().filter(|_| required) {
            let [width, height] = plan.preset.ray_image.map(u64::from);
            RayBuffer::check_fits(gpu, width * height)?;
        }
        Ok(())
    }
}

/// Runs everything.
///
/// # Errors
/// [`RunError`] as its variants say; races that ended are in the journal.
pub fn execute(plan: &Plan, context: &Context<'_>) -> Result<Run, RunError> {
    execute_all(std::slice::from_ref(plan), context)
}

/// Runs plans one after the other into one run, for what no single plan has: several resolutions, or several values of what is said
/// about ray sets. The first tells what is said of the run as a whole. Contenders are interleaved within a plan.
///
/// # Errors
/// [`RunError`] as its variants say; races that ended are in the journal.
pub fn execute_all(plans: &[Plan], context: &Context<'_>) -> Result<Run, RunError> {
    let mut run = begin(plans, context);
    for plan in plans {
        context.check_rays(plan, plan.tracers.iter().any(TracerRequest::must_have_device))?;
    }
    let mut index = 0;
    for plan in plans {
        let requests: Vec<Request> = plan.tracers.iter().map(Request::of).collect();
        let mut said = records::json_values(&plan.ray_parameters);
        said.retain(|name, value| run.ray_parameters.get(name) != Some(&*value));
        for (place, scene) in load(plan, context.progress)?.into_iter().enumerate() {
            if context.takes(place) {
                let effort = Effort::timed(plan);
                let found = measure_scene(index, plan, scene, &requests, effort, None, context)?.saying(&said);
                for (request, refused) in add(&mut run, found) {
                    refuse(&mut run, &records::request_record(&requests[request].tracer).label(), None, refused);
                }
            }
            index += 1;
        }
    }
    if run.runs.is_empty() && context.shard.is_none() { Err(nothing(&run)) } else { Ok(run) }
}

/// Measures requests in a scene from the plan's viewpoint.
///
/// # Errors
/// [`RunError`] as its variants say.
pub(crate) fn measure_scene(
    index: usize,
    plan: &Plan,
    scene: Scene,
    requests: &[Request],
    effort: Effort,
    hook: Option<Hook<'_>>,
    context: &Context<'_>,
) -> Result<Measured, RunError> {
    measure_film(index, plan, (scene, None), requests, effort, hook, context)
}

/// The same in a scene that is the last frame of a film, if there is one.
///
/// # Errors
/// [`RunError`] as its variants say.
pub(crate) fn measure_film(
    index: usize,
    plan: &Plan,
    frame: (Scene, Option<Film>),
    requests: &[Request],
    effort: Effort,
    hook: Option<Hook<'_>>,
    context: &Context<'_>,
) -> Result<Measured, RunError> {
    let sha256 = frame.0.sha256.clone();
    let frame = RefCell::new(Some(frame));
    let prepare = || match frame.take() {
        Some((scene, film)) => Ok(Placed { film, ..placed(plan, scene, context)? }),
        None => Err(RunError::Nothing("a scene was prepared twice".to_owned())),
    };
    measure(&Place { index, scene_sha256: Some(&sha256), prepare: &prepare, requests, effort, hook }, context)
}

/// A scene from the plan's viewpoint, ready to be measured.
///
/// # Errors
/// [`RunError`] as its variants say.
pub(super) fn placed(plan: &Plan, scene: Scene, context: &Context<'_>) -> Result<Placed, RunError> {
    let loaded = prepare(plan, scene, context.device, context.cache, context.progress)?;
    let viewpoint = records::viewpoint_record(plan, &loaded.pose, &loaded.session);
    Ok(Placed {
        scene: loaded.record,
        viewpoint,
        strength: None,
        session: loaded.session,
        film: None,
        told: serde_json::Value::Null,
    })
}

/// A run without anything measured yet; the first plan tells what is said of it as a whole.
pub(crate) fn begin(plans: &[Plan], context: &Context<'_>) -> Run {
    let requests = || plans.iter().flat_map(|plan| &plan.tracers);
    let first = plans.first();
    Run {
        seed: first.map_or(0, |plan| plan.seed),
        preset: first.map_or("", |plan| plan.preset.name).to_owned(),
        table: first.and_then(|plan| plan.table).map(str::to_owned),
        ray_parameters: first.map(|plan| records::json_values(&plan.ray_parameters)).unwrap_or_default(),
        ..empty(requests(), context)
    }
}

/// A record of requests without a plan.
pub(crate) fn empty<'r>(requests: impl IntoIterator<Item = &'r TracerRequest>, context: &Context<'_>) -> Run {
    let needs_adapter = requests.into_iter().any(|request| request.registration.needs_device());
    let gpu = context.device.as_deref().ok().filter(|_| needs_adapter);
    let mut provenance = Provenance::now(gpu);
    let (started, resumed) = context.journal.times();
    if let Some(started) = started {
        started.clone_into(&mut provenance.started);
    }
    provenance.resumed = resumed.to_vec();
    provenance.means.clone_from(&context.means);
    provenance.shard = context.shard.as_ref().map(Shard::record);
    Run {
        schema: SCHEMA,
        provenance,
        seed: 0,
        preset: String::new(),
        table: None,
        sweep: None,
        tuning: None,
        updates: None,
        cases: None,
        explanation: None,
        pareto: None,
        need: None,
        ray_parameters: Default::default(),
        control_names: Control::names(),
        controls: Vec::new(),
        runs: Vec::new(),
        anchors: Vec::new(),
        races: Vec::new(),
        skipped: Vec::new(),
    }
}

/// Adds what was measured in a place, and gives who could not be, by request.
pub(crate) fn add(run: &mut Run, found: Measured) -> Vec<(usize, (String, Refusal))> {
    let Measured { scene, controls, rows, anchors, races, skipped, .. } = found;
    let before = run.races.len() as u32;
    let placed = |row: TracerRun| row.with_races_after(before);
    run.skipped.extend(skipped);
    run.controls.extend(controls.into_iter().map(placed));
    run.anchors.extend(anchors.into_iter().map(placed));
    run.races.extend(races);
    let mut refused = Vec::new();
    for (request, row) in rows.into_iter().enumerate() {
        match row {
            Ok(row) => run.runs.push(placed(row)),
            Err(refusal) => refused.push((request, (scene.name.clone(), refusal))),
        }
    }
    refused
}

/// Notes what could not be measured in a scene.
pub(crate) fn refuse(run: &mut Run, tracer: &str, what: Option<&str>, (scene, refusal): (String, Refusal)) {
    let tracer = Some(what.map_or_else(|| tracer.to_owned(), |what| format!("{tracer} ({what})")));
    run.skipped.push(Skipped { tracer, scene, rays: None, reason: refusal.reason });
}

/// The error of a run in which nothing could run, with every reason once.
pub(crate) fn nothing(run: &Run) -> RunError {
    let reason = |skipped: &Skipped| match &skipped.tracer {
        Some(tracer) => format!("{tracer}: {}", skipped.reason),
        None => skipped.reason.clone(),
    };
    RunError::Nothing(run.skipped.iter().map(reason).unique().join("; "))
}
