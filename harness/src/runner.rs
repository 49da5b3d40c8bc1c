//! Runs a plan: builds and traces interleaved over the contenders, judges, and writes everything down.

mod race;

use tracebench_api::{Geometry, RayBuffer, TracerError};
use tracebench_scenes::{Camera, Material, Mesh, Scene, SceneError};

use crate::plan::{Plan, Resolution, SceneSource, TracerRequest, ViewRequest};
use crate::progress::Progress;
use crate::records;
use crate::registry::Device;
use crate::results::{Provenance, Run, SCHEMA, SceneRecord, Skipped, TracerRun, ViewpointRecord};
use crate::session::{Contender, RayRequest, Session, SessionError};
use crate::truth::{Cache, Truth};
use crate::viewpoint::{self, Pose};

pub(crate) use race::{Entry, sample_builds, sample_traces, validate};

/// Why a run could not be finished.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// A scene could not be loaded.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The scene has no such camera.
    #[error("scene {scene} has no viewpoint '{name}'; there are: {known}. A pose can be given as ex,ey,ez:tx,ty,tz")]
    UnknownView {
        /// The scene.
        scene: String,
        /// The name given.
        name: String,
        /// The names that exist.
        known: String,
    },
    /// The scene cannot be seen from elsewhere.
    #[error("scene {scene} has no other viewpoint than '{own}': nothing is seen from anywhere that the rule finds")]
    NoOtherView {
        /// The scene.
        scene: String,
        /// The own viewpoint.
        own: String,
    },
    /// A tracer that was asked for by name cannot do it.
    #[error("{tracer}: {error}")]
    Tracer {
        /// The tracer.
        tracer: String,
        /// What it says.
        error: TracerError,
    },
    /// The device cannot hold scene or rays, or failed.
    #[error(transparent)]
    Device(#[from] TracerError),
    /// Truth or judge failed.
    #[error(transparent)]
    Session(#[from] SessionError),
    /// A control failed.
    #[error("the run is void: {0}")]
    Control(String),
    /// No tracer was left to run.
    #[error("no tracer could run: {0}")]
    Nothing(String),
}

impl RunError {
    /// Whether the arguments are to blame rather than files, devices or memory.
    pub fn is_argument(&self) -> bool {
        match self {
            Self::Scene(error) => error.is_argument(),
            Self::UnknownView { .. } => true,
            _ => false,
        }
    }
}

/// Loads a scene.
///
/// # Errors
/// What the scenes crate says.
pub fn load_scene(source: &SceneSource, scale: f64) -> Result<Scene, SceneError> {
    match source {
        SceneSource::Catalogue(name) => tracebench_scenes::procedural(name, scale),
        SceneSource::File(path) => tracebench_scenes::import(path),
    }
}

/// The pose that a request means in a scene.
///
/// # Errors
/// [`RunError::UnknownView`] for a name that the scene does not have, [`RunError::NoOtherView`] where there is no other.
pub fn choose_pose(request: &ViewRequest, scene: &str, cameras: &[Camera], truth: &Truth) -> Result<Pose, RunError> {
    match request {
        ViewRequest::Given(pose) => Ok(pose.clone()),
        ViewRequest::Default => Ok(cameras.first().map_or_else(|| viewpoint::find(truth), Pose::from)),
        ViewRequest::Named(name) => named_pose(name, scene, cameras),
        ViewRequest::Other(than) => {
            let own = choose_pose(than, scene, cameras, truth)?;
            viewpoint::other(&own, cameras, truth)
                .ok_or_else(|| RunError::NoOtherView { scene: scene.to_owned(), own: own.name })
        }
    }
}

fn named_pose(name: &str, scene: &str, cameras: &[Camera]) -> Result<Pose, RunError> {
    let camera = cameras.iter().find(|camera| camera.name == name);
    camera.map(Pose::from).ok_or_else(|| RunError::UnknownView {
        scene: scene.to_owned(),
        name: name.to_owned(),
        known: match cameras {
            [] => "none".to_owned(),
            cameras => cameras.iter().map(|camera| camera.name.as_str()).collect::<Vec<_>>().join(", "),
        },
    })
}

/// A scene that is ready to be measured.
pub struct LoadedScene {
    /// Its record.
    pub record: SceneRecord,
    /// The pose chosen.
    pub pose: Pose,
    /// Its rays and truth.
    pub session: Session,
}

/// Loads the plan's scenes and looks whether they have the viewpoint, so that what is wrong with the last one is said
/// before the first is measured.
///
/// # Errors
/// [`RunError`] as its variants say.
pub fn load(plan: &Plan, progress: &Progress) -> Result<Vec<Scene>, RunError> {
    let load = |source: &SceneSource| {
        if let SceneSource::File(path) = source {
            progress.say(&format!("loading {}", path.display()));
        }
        let mut scene = load_scene(source, plan.preset.scene_scale)?;
        scene.set_time(plan.time_s)?;
        if let ViewRequest::Named(name) = &plan.view {
            named_pose(name, &scene.name, &scene.cameras)?;
        }
        Ok(scene)
    };
    plan.scenes.iter().map(load).collect()
}

/// Chooses the viewpoint of a scene, makes rays and truth.
///
/// # Errors
/// [`RunError`] as its variants say.
pub fn prepare(
    plan: &Plan,
    scene: Scene,
    device: &Device,
    cache: &Cache,
    progress: &Progress,
) -> Result<LoadedScene, RunError> {
    progress.say(&format!("scene {}: {} triangles", scene.name, scene.mesh.triangles.len()));
    let gpu = device.as_ref().ok();
    let record = records::scene_record(&scene);
    progress.say("  ground truth");
    let mirrors: Vec<bool> = scene.mesh.materials.iter().map(Material::is_mirror).collect();
    let mirrors: Vec<bool> = scene.mesh.triangle_materials.iter().map(|material| mirrors[*material as usize]).collect();
    let Mesh { positions, triangles, triangle_materials, .. } = scene.mesh;
    let geometry = Geometry::with_materials(positions, triangles, triangle_materials, gpu.map(AsRef::as_ref))?;
    let truth = Truth::new(&geometry, &scene.sha256);
    let pose = choose_pose(&plan.view, &scene.name, &scene.cameras, &truth)?;
    let viewpoint = pose.viewpoint(&geometry, plan.preset.frame, plan.preset.face);
    let request = RayRequest {
        sets: &plan.ray_sets,
        image: plan.preset.ray_image,
        seed: plan.seed,
        parameters: &plan.ray_parameters,
        path: scene.camera_path.as_ref(),
        mirrors: &mirrors,
    };
    let session = Session::new(&scene.name, truth, viewpoint, request, gpu.cloned(), cache, progress)?;
    Ok(LoadedScene { record, pose, session: session.ending_at(plan.end) })
}

/// Runs everything.
///
/// # Errors
/// [`RunError`] as its variants say; nothing has been written then.
pub fn execute(plan: &Plan, device: &Device, cache: &Cache, progress: &Progress) -> Result<Run, RunError> {
    execute_all(std::slice::from_ref(plan), device, cache, progress)
}

/// Runs plans one after the other into one run, for what no single plan has: several resolutions. The first tells what is
/// said of the run as a whole. Contenders are interleaved within a plan.
///
/// # Errors
/// [`RunError`] as its variants say; nothing has been written then.
pub fn execute_all(plans: &[Plan], device: &Device, cache: &Cache, progress: &Progress) -> Result<Run, RunError> {
    let mut run = begin(plans, device);
    execute_into(&mut run, plans, device, cache, progress)?;
    if run.runs.is_empty() { Err(nothing(&run)) } else { Ok(run) }
}

/// A contender that could not be measured in a scene.
pub(crate) struct Refused {
    /// Its place among the plan's tracers.
    pub(crate) contender: usize,
    /// The scene's place among the plan's scenes.
    pub(crate) scene_index: usize,
    /// The scene's name.
    pub(crate) scene: String,
    /// Why.
    pub(crate) error: TracerError,
}

/// A run without anything measured yet; the first plan tells what is said of it as a whole.
pub(crate) fn begin(plans: &[Plan], device: &Device) -> Run {
    let mut requests = plans.iter().flat_map(|plan| &plan.tracers);
    let needs_adapter = requests.any(|request| request.registration.needs_device());
    let adapter = device.as_ref().ok().filter(|_| needs_adapter).map(|gpu| gpu.listing.clone());
    let first = plans.first();
    Run {
        schema: SCHEMA,
        provenance: Provenance::now(adapter),
        seed: first.map_or(0, |plan| plan.seed),
        preset: first.map_or("", |plan| plan.preset.name).to_owned(),
        table: first.and_then(|plan| plan.table).map(str::to_owned),
        sweep: None,
        ray_parameters: first.map(|plan| records::json_values(&plan.ray_parameters)).unwrap_or_default(),
        controls: Vec::new(),
        runs: Vec::new(),
        skipped: Vec::new(),
    }
}

/// Runs plans one after the other and adds what they measure to a run; gives what could not be measured.
///
/// # Errors
/// [`RunError`] as its variants say.
pub(crate) fn execute_into(
    run: &mut Run,
    plans: &[Plan],
    device: &Device,
    cache: &Cache,
    progress: &Progress,
) -> Result<Vec<Refused>, RunError> {
    // Known before the truth is told, which takes long for many rays.
    for plan in plans {
        let gpu = device.as_ref().ok().filter(|_| plan.tracers.iter().any(TracerRequest::must_have_device));
        if let Some(gpu) = gpu {
            let [width, height] = plan.preset.ray_image.map(u64::from);
            RayBuffer::check_fits(gpu, width * height)?;
        }
    }
    let mut refused = Vec::new();
    for plan in plans {
        for (scene_index, scene) in load(plan, progress)?.into_iter().enumerate() {
            let loaded = prepare(plan, scene, device, cache, progress)?;
            for (contender, error) in measure_scene(plan, &loaded, device, progress, run)? {
                let scene = loaded.record.name.clone();
                refused.push(Refused { contender, scene_index, scene, error });
            }
        }
    }
    Ok(refused)
}

/// The error of a run in which nothing could run, with every reason once.
pub(crate) fn nothing(run: &Run) -> RunError {
    let mut reasons: Vec<&str> = Vec::new();
    for skipped in &run.skipped {
        if !reasons.contains(&skipped.reason.as_str()) {
            reasons.push(&skipped.reason);
        }
    }
    RunError::Nothing(reasons.join("; "))
}

/// Measures one scene, and gives the places of the contenders that could not be, with the reason.
fn measure_scene(
    plan: &Plan,
    loaded: &LoadedScene,
    device: &Device,
    progress: &Progress,
    run: &mut Run,
) -> Result<Vec<(usize, TracerError)>, RunError> {
    let LoadedScene { record: scene, pose, session } = loaded;
    run.skipped.extend(session.skipped.iter().cloned());
    let mut entries: Vec<Entry> = Vec::new();
    // Of every entry its place among the plan's tracers.
    let mut places: Vec<Option<usize>> = Vec::new();
    let mut refused = Vec::new();
    for (control, contender) in session.controls() {
        entries.push(Entry::new(contender, None, Some(control)));
        places.push(None);
    }
    for (place, request) in plan.tracers.iter().enumerate() {
        let description = (request.registration.describe)();
        let name = description.name;
        let created =
            Contender::create(description, request.parameters.clone(), || request.registration.create(device));
        match created {
            Ok(contender) => {
                entries.push(Entry::new(contender, Some(request.clone()), None));
                places.push(Some(place));
            }
            Err(error) => refused.push((place, refuse(run, scene, name, request.required, error)?)),
        }
    }
    let samples = plan.preset.samples;
    sample_builds(session, &mut entries, samples, progress);
    validate(session.geometry(), &mut entries, progress);
    for rays in &session.rays {
        sample_traces(session, rays, &mut entries, samples, progress)?;
    }
    let viewpoint = records::viewpoint_record(plan, pose, session);
    for (entry, place) in entries.into_iter().zip(places) {
        let required = entry.control.is_some() || entry.request.as_ref().is_some_and(|request| request.required);
        if let Some(error) = entry.failure {
            let error = refuse(run, scene, entry.contender.description.name, required, error)?;
            refused.extend(place.map(|place| (place, error)));
            continue;
        }
        let list = if entry.control.is_some() { &mut run.controls } else { &mut run.runs };
        list.push(tracer_run(entry, scene, &viewpoint)?);
    }
    Ok(refused)
}

/// Notes what was skipped and gives the reason back, unless it was required.
fn refuse(
    run: &mut Run,
    scene: &SceneRecord,
    name: &str,
    required: bool,
    error: TracerError,
) -> Result<TracerError, RunError> {
    if required {
        return Err(RunError::Tracer { tracer: name.to_owned(), error });
    }
    run.skipped.push(Skipped {
        tracer: Some(name.to_owned()),
        scene: scene.name.clone(),
        rays: None,
        reason: error.to_string(),
    });
    Ok(error)
}

/// What was measured of a contender on a scene.
///
/// # Errors
/// If it has built nothing.
pub(crate) fn tracer_run(
    entry: Entry,
    scene: &SceneRecord,
    viewpoint: &ViewpointRecord,
) -> Result<TracerRun, RunError> {
    let mut viewpoint = viewpoint.clone();
    if let Some(Resolution { frame, face }) = entry.request.as_ref().and_then(|request| request.resolution) {
        (viewpoint.frame, viewpoint.face) = (frame, face);
    }
    let end = entry.traces.first().map(|trace| trace.end).unwrap_or_default();
    Ok(TracerRun {
        scene: scene.clone(),
        viewpoint,
        tracer: entry.record(),
        memory: records::memory_record(entry.contender.structure()?.memory(), end),
        structure_statistics: entry.statistics,
        build: records::build_record(&entry.builds, entry.contender.setup_ms),
        traces: entry.traces,
    })
}

#[cfg(test)]
mod tests;
