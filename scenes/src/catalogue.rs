//! The catalogue of procedural scenes: what catalogue.json says of each (`way` tells readers where the path leads), and what makes it.

use std::sync::{Arc, LazyLock};

use serde::Deserialize;

use crate::error::SceneError;
use crate::procedural::{atrium, candy, cloth, foliage, hangar, room, smithy, solids};
use crate::scene::{Animation, Camera, CameraKey, CameraPath, ImportNotes, Mesh, Origin, Scene};

/// Least scale factor of a procedural scene.
pub const SCALE_MIN: f64 = 0.001;
/// Greatest scale factor of a procedural scene.
pub const SCALE_MAX: f64 = 64.0;

/// Full vertical field of view of all viewpoints: 60 degrees.
const VERTICAL_FOV_RADIANS: f32 = std::f32::consts::FRAC_PI_3;
/// Upright.
const UP: [f32; 3] = [0.0, 1.0, 0.0];

/// A procedural scene by name.
#[derive(Clone, Debug, Deserialize)]
pub struct CatalogueEntry {
    /// Stable name, as the command line takes it.
    pub name: &'static str,
    /// One sentence on what it holds.
    pub description: &'static str,
    /// Number of triangles at scale 1, exact.
    pub triangles_at_scale_1: u64,
    /// Whether every ray from any of its cameras hits something.
    pub closed: bool,
    /// Whether every surface is closed, so that "inside" has a meaning.
    pub watertight: bool,
    /// Length of the animation in seconds; `None` for a scene that stands still.
    #[serde(skip)]
    pub animation_s: Option<f64>,
    viewpoints: Vec<Pose>,
    /// A pose each second.
    path: Vec<Pose>,
}

/// Where one looks from, and at what.
#[derive(Clone, Debug, Deserialize)]
pub(crate) struct Pose {
    #[serde(default)]
    name: &'static str,
    pub(crate) eye: [f32; 3],
    pub(crate) target: [f32; 3],
}

/// Makes a scene for a valid scale factor at a time in seconds. The time moves vertices, never anything else.
type Build = fn(f64, f64) -> Mesh;

/// What makes the scenes, in the order of the catalogue, and how long they move.
const BUILDS: [(Build, Option<f64>); 8] = [
    (room::build, None),
    (solids::build, None),
    (cloth::build, Some(cloth::DURATION_S)),
    (hangar::build, Some(hangar::DURATION_S)),
    (candy::build, Some(candy::DURATION_S)),
    (atrium::build, None),
    (foliage::build, Some(foliage::DURATION_S)),
    (smithy::build, None),
];

static CATALOGUE: LazyLock<Vec<CatalogueEntry>> = LazyLock::new(|| {
    let entries: Vec<CatalogueEntry> =
        serde_json::from_str(include_str!("catalogue.json")).expect("the tests of the catalogue read it");
    let moving = entries.into_iter().zip(BUILDS);
    moving.map(|(entry, (_, animation_s))| CatalogueEntry { animation_s, ..entry }).collect()
});

/// All procedural scenes, in a fixed order.
pub fn catalogue() -> &'static [CatalogueEntry] {
    &CATALOGUE
}

/// The viewpoints of a scene; none of one that there is not.
pub(crate) fn viewpoints(name: &str) -> &'static [Pose] {
    CATALOGUE.iter().find(|entry| entry.name == name).map_or(&[], |entry| &entry.viewpoints)
}

/// The procedural scene `name` with about `scale` times its triangles at scale 1.
///
/// `scale` is in [[`SCALE_MIN`], [`SCALE_MAX`]]; curved parts are tessellated by its square root in either direction,
/// down to the least that still is a valid scene. The result is the same bit for bit on every machine.
///
/// # Errors
///
/// [`SceneError::Argument`].
pub fn procedural(name: &str, scale: f64) -> Result<Scene, SceneError> {
    let Some((entry, (build, _))) = CATALOGUE.iter().zip(BUILDS).find(|(entry, _)| entry.name == name) else {
        let known: Vec<&str> = CATALOGUE.iter().map(|entry| entry.name).collect();
        return Err(SceneError::Argument(format!(
            "there is no scene named '{name}': use one of {}, or a path that ends in .gltf or .glb",
            known.join(", ")
        )));
    };
    if !(SCALE_MIN..=SCALE_MAX).contains(&scale) {
        return Err(SceneError::Argument(format!(
            "scene scale {scale} is out of range: use a number from {SCALE_MIN} to {SCALE_MAX}"
        )));
    }
    let camera = |&Pose { name, eye, target }: &Pose| Camera {
        name: name.to_owned(),
        eye,
        target,
        up: UP,
        vertical_fov_radians: VERTICAL_FOV_RADIANS,
    };
    let cameras = entry.viewpoints.iter().map(camera).collect();
    let origin = Origin::Procedural { scale };
    let mut scene = Scene::assemble(name.to_owned(), origin, build(scale, 0.0), cameras, ImportNotes::default());
    let key = |(second, pose): (u32, &Pose)| CameraKey {
        time_s: f64::from(second),
        eye: pose.eye,
        target: pose.target,
        up: UP,
    };
    let keys = (0..).zip(&entry.path).map(key).collect();
    scene.camera_path = Some(CameraPath { keys, vertical_fov_radians: VERTICAL_FOV_RADIANS });
    scene.animation = entry.animation_s.map(|duration_s| Animation {
        duration_s,
        positions_at: Arc::new(move |time_s| {
            if time_s.is_nan() {
                let problem = "the time of an animation is not a number: give seconds".to_owned();
                return Err(SceneError::Invalid { scene: entry.name.to_owned(), problem });
            }
            Ok(build(scale, time_s).positions)
        }),
        left_out: None,
    });
    Ok(scene)
}
