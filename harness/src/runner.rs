//! Runs a plan: builds and traces interleaved over the contenders, judges, and writes everything down.

mod race;

use tracebench_api::{Geometry, RayBuffer, TracerError};
use tracebench_scenes::{Camera, Material, Mesh, Scene, SceneError};

use crate::machine;
use crate::plan::{Plan, SceneSource, TracerRequest, ViewRequest};
use crate::progress::Progress;
use crate::records;
use crate::registry::Device;
use crate::results::{Run, SCHEMA, SceneRecord, Skipped, TracerRun, ViewpointRecord};
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
/// [`RunError::UnknownView`] for a name that the scene does not have.
pub fn choose_pose(request: &ViewRequest, scene: &str, cameras: &[Camera], truth: &Truth) -> Result<Pose, RunError> {
    match request {
        ViewRequest::Given(pose) => Ok(pose.clone()),
        ViewRequest::Default => Ok(cameras.first().map_or_else(|| viewpoint::find(truth), Pose::from)),
        ViewRequest::Named(name) => named_pose(name, scene, cameras),
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
    let Some(first) = plans.first() else { return Err(RunError::Nothing("nothing was asked for".to_owned())) };
    let gpu = device.as_ref().ok();
    // Known before the truth is told, which takes long for many rays.
    for plan in plans {
        if let Some(gpu) = gpu.filter(|_| plan.tracers.iter().any(TracerRequest::must_have_device)) {
            let [width, height] = plan.preset.ray_image.map(u64::from);
            RayBuffer::check_fits(gpu, width * height)?;
        }
    }
    let mut requests = plans.iter().flat_map(|plan| &plan.tracers);
    let needs_adapter = requests.any(|request| request.registration.needs_device());
    let adapter = gpu.filter(|_| needs_adapter).map(|gpu| gpu.listing.clone());
    let mut run = Run {
        schema: SCHEMA,
        machine: machine::this_machine(adapter),
        commit: machine::COMMIT.to_owned(),
        dirty: machine::dirty(),
        started: machine::utc_now(),
        seed: first.seed,
        preset: first.preset.name.to_owned(),
        table: first.table.map(|table| table.name.to_owned()),
        ray_parameters: records::json_values(&first.ray_parameters),
        controls: Vec::new(),
        runs: Vec::new(),
        skipped: Vec::new(),
    };
    for plan in plans {
        for scene in load(plan, progress)? {
            let loaded = prepare(plan, scene, device, cache, progress)?;
            measure_scene(plan, &loaded, device, progress, &mut run)?;
        }
    }
    if run.runs.is_empty() {
        let reasons: Vec<_> = run.skipped.iter().map(|skipped| skipped.reason.as_str()).collect();
        return Err(RunError::Nothing(reasons.join("; ")));
    }
    Ok(run)
}

fn measure_scene(
    plan: &Plan,
    loaded: &LoadedScene,
    device: &Device,
    progress: &Progress,
    run: &mut Run,
) -> Result<(), RunError> {
    let LoadedScene { record: scene, pose, session } = loaded;
    run.skipped.extend(session.skipped.iter().cloned());
    let mut entries: Vec<Entry> = Vec::new();
    for (control, contender) in session.controls() {
        entries.push(Entry::new(contender, None, Some(control)));
    }
    for request in &plan.tracers {
        let description = (request.registration.describe)();
        let name = description.name;
        let created =
            Contender::create(description, request.parameters.clone(), || request.registration.create(device));
        match created {
            Ok(contender) => entries.push(Entry::new(contender, Some(request.clone()), None)),
            Err(error) => refuse(run, scene, name, request.required, error)?,
        }
    }
    let samples = plan.preset.samples;
    sample_builds(session, &mut entries, samples, progress);
    validate(&mut entries, progress);
    for rays in &session.rays {
        sample_traces(session, rays, &mut entries, samples, progress)?;
    }
    let viewpoint = records::viewpoint_record(plan, pose, session);
    for entry in entries {
        let required = entry.control.is_some() || entry.request.as_ref().is_some_and(|request| request.required);
        if let Some(error) = entry.failure {
            refuse(run, scene, entry.contender.description.name, required, error)?;
            continue;
        }
        let list = if entry.control.is_some() { &mut run.controls } else { &mut run.runs };
        list.push(tracer_run(entry, scene, &viewpoint)?);
    }
    Ok(())
}

fn refuse(run: &mut Run, scene: &SceneRecord, name: &str, required: bool, error: TracerError) -> Result<(), RunError> {
    if required {
        return Err(RunError::Tracer { tracer: name.to_owned(), error });
    }
    run.skipped.push(Skipped {
        tracer: Some(name.to_owned()),
        scene: scene.name.clone(),
        rays: None,
        reason: error.to_string(),
    });
    Ok(())
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
    let end = entry.traces.first().map(|trace| trace.end).unwrap_or_default();
    Ok(TracerRun {
        scene: scene.clone(),
        viewpoint: viewpoint.clone(),
        tracer: entry.record(),
        memory: records::memory_record(entry.contender.structure()?.memory(), end),
        structure_statistics: entry.statistics,
        build: records::build_record(&entry.builds, entry.contender.setup_ms),
        traces: entry.traces,
    })
}

#[cfg(test)]
mod tests;
