//! Scenes as they are measured: loaded, with a viewpoint, rays and truth.

use std::convert::identity;
use std::sync::Arc;

use tracebench_api::{Geometry, Gpu, TracerError};
use tracebench_scenes::{Camera, CameraPath, Material, Mesh, Scene, SceneError};

use super::session::Session;
use super::workload::PreparedWorkload;
use super::{RunError, records};
use crate::plan::{Plan, SceneSource, ViewRequest};
use crate::progress::Progress;
use crate::rays::{RayParameters, RayScene};
use crate::registry::Device;
use crate::results::SceneRecord;
use crate::truth::{Cache, Truth};
use crate::viewpoint::{self, Pose};

/// Loads a scene.
///
/// # Errors
/// What the scenes crate says.
pub fn load_scene(source: &SceneSource, scale: f64) -> Result<Scene, SceneError> {
    match source {
        SceneSource::Catalogue(name) => tracebench_scenes::procedural(name, scale),
        SceneSource::File { path, name } => Ok(Scene { name: name.clone(), ..tracebench_scenes::import(path)? }),
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
            viewpoint::other(&own, cameras, truth).ok_or_else(|| RunError::NoOtherView(scene.to_owned(), own.name))
        }
        ViewRequest::Nth(place, of) => match cameras.get(*place) {
            Some(camera) => Ok(Pose::from(camera)),
            None => {
                let own = choose_pose(&ViewRequest::Default, scene, cameras, truth)?;
                Ok(if *place == 0 { own } else { own.turned(truth.geometry().diagonal(), *place, *of) })
            }
        },
    }
}

fn named_pose(name: &str, scene: &str, cameras: &[Camera]) -> Result<Pose, RunError> {
    if let Some(camera) = cameras.iter().find(|camera| camera.name == name) {
        return Ok(Pose::from(camera));
    }
    Pose::parse(name).map_err(|error| {
        let known = cameras.iter().map(|camera| camera.name.as_str()).collect::<Vec<_>>().join(", ");
        let known = if known.is_empty() { "none".to_owned() } else { known };
        RunError::UnknownView(scene.to_owned(), name.to_owned(), error, known)
    })
}

/// Loads the plan's scenes and looks whether they have the viewpoint, so that what is wrong with the last one is said
/// before the first is measured.
///
/// # Errors
/// [`RunError`] as its variants say.
pub fn load(plan: &Plan, progress: &Progress) -> Result<Vec<Scene>, RunError> {
    load_at(plan, Some(plan.time_s), progress)
}

/// As [`load`] at a time in seconds; without one a study has the times.
///
/// # Errors
/// [`RunError`] as its variants say.
pub fn load_at(plan: &Plan, time_s: Option<f64>, progress: &Progress) -> Result<Vec<Scene>, RunError> {
    let load = |source: &SceneSource| {
        if let SceneSource::File { path, .. } = source {
            progress.say(&format!("loading {}", path.display()));
        }
        let mut scene = load_scene(source, plan.preset.scene_scale)?;
        if let Some(time_s) = time_s {
            scene.drop_zero_area(&[time_s])?;
        }
        if let ViewRequest::Named(name) = &plan.view {
            named_pose(name, &scene.name, &scene.cameras)?;
        }
        Ok(scene)
    };
    plan.scenes.iter().map(load).collect()
}

/// Chooses the viewpoint of a scene by a plan, makes rays and truth.
///
/// # Errors
/// [`RunError`] as its variants say.
pub fn prepare(
    plan: &Plan,
    scene: Scene,
    device: &Device,
    cache: &Cache,
    progress: &Progress,
) -> Result<PreparedWorkload, RunError> {
    progress.say(&format!("scene {}: {} triangles", scene.name, scene.mesh.triangles.len()));
    for warning in &scene.notes.warnings {
        progress.say(&format!("  warning: {warning}"));
    }
    progress.say("  ground truth");
    let scene = SceneTruth::new(scene, device, identity)?;
    let pose = choose_pose(&plan.view, &scene.record.name, &scene.cameras, &scene.truth)?;
    scene.seen_from(plan, pose, cache, progress)
}

/// For every triangle whether it is a mirror.
pub(crate) fn mirrors(mesh: &Mesh) -> Vec<bool> {
    let of_materials: Vec<bool> = mesh.materials.iter().map(Material::is_mirror).collect();
    mesh.triangle_materials.iter().map(|material| of_materials[*material as usize]).collect()
}

/// A scene with its truth, to be seen from any number of poses.
pub(crate) struct SceneTruth {
    /// Its record.
    pub record: SceneRecord,
    /// Its triangles and their truth.
    pub truth: Arc<Truth>,
    /// Its cameras.
    pub cameras: Vec<Camera>,
    /// For every triangle whether it is a mirror.
    mirrors: Vec<bool>,
    path: Option<CameraPath>,
    gpu: Option<Arc<Gpu>>,
}

impl SceneTruth {
    /// Uploads a scene where there is a device, and makes what its truth is told from, as `audited` says.
    ///
    /// # Errors
    /// [`RunError::Device`] if it is no scene for it.
    pub(crate) fn new(scene: Scene, device: &Device, audited: fn(Truth) -> Truth) -> Result<Self, RunError> {
        let gpu = device.as_ref().ok().cloned();
        let record = records::scene_record(&scene);
        let mirrors = mirrors(&scene.mesh);
        let Mesh { positions, triangles, triangle_materials, .. } = scene.mesh;
        let geometry = Geometry::with_materials(positions, triangles, triangle_materials, gpu.as_deref())?;
        let truth = Arc::new(audited(Truth::new(&geometry, &scene.sha256)));
        Ok(Self { record, truth, cameras: scene.cameras, mirrors, path: scene.camera_path, gpu })
    }

    /// The scene from a pose, with the plan's rays and their truth.
    pub(crate) fn seen_from(
        &self,
        plan: &Plan,
        pose: Pose,
        cache: &Cache,
        progress: &Progress,
    ) -> Result<PreparedWorkload, RunError> {
        let viewpoint = pose.viewpoint(self.truth.geometry(), plan.preset.frame, plan.preset.face);
        let parameters = RayParameters::try_from(&plan.ray_parameters).map_err(TracerError::from)?;
        let scene = RayScene {
            truth: &self.truth,
            viewpoint: &viewpoint,
            path: self.path.as_ref(),
            mirrors: &self.mirrors,
            image: plan.preset.ray_image,
            seed: plan.seed,
            parameters: &parameters,
        };
        let (name, truth, gpu) = (&self.record.name, Arc::clone(&self.truth), self.gpu.clone());
        let session = Session::new(name, truth, &plan.ray_sets, &scene, gpu, cache, progress)?;
        let Plan { trace_to, wrong_rays_per_cause, .. } = *plan;
        Ok(PreparedWorkload {
            scene: self.record.clone(),
            viewpoint: records::viewpoint_of(&pose.name, &viewpoint, plan.preset.ray_image, plan.time_s),
            difficulty_level: None,
            session: Session { trace_to, wrong_rays_per_cause, ..session },
        })
    }
}
