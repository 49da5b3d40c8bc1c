//! The catalogue of procedural scenes.

use std::sync::Arc;

use crate::error::SceneError;
use crate::procedural::{Built, atrium, candy, cloth, foliage, hangar, room, smithy, solids};
use crate::scene::{Animation, ImportNotes, Origin, Scene};

/// Least scale factor of a procedural scene.
pub const SCALE_MIN: f64 = 0.001;
/// Greatest scale factor of a procedural scene.
pub const SCALE_MAX: f64 = 64.0;

/// A procedural scene by name.
#[derive(Clone, Debug)]
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
    pub animation_s: Option<f64>,
    /// Makes the scene for a valid scale factor at a time in seconds. The time moves vertices, never anything else.
    build: fn(f64, f64) -> Built,
}

static CATALOGUE: [CatalogueEntry; 8] = [
    CatalogueEntry {
        name: "room",
        description: "a closed furnished room with a mirror floor, thin chair legs, a lamp on a cord and a dense statue",
        triangles_at_scale_1: room::TRIANGLES_AT_SCALE_1,
        closed: true,
        watertight: true,
        animation_s: None,
        build: room::build,
    },
    CatalogueEntry {
        name: "solids",
        description: "closed objects that stand apart in a glass dome, solids in solids among them, for refraction",
        triangles_at_scale_1: solids::TRIANGLES_AT_SCALE_1,
        closed: true,
        watertight: true,
        animation_s: None,
        build: solids::build,
    },
    CatalogueEntry {
        name: "cloth",
        description: "a cloth that falls over a mirror ball on a floor and is wound up as the ball turns",
        triangles_at_scale_1: cloth::TRIANGLES_AT_SCALE_1,
        closed: false,
        watertight: false,
        animation_s: Some(cloth::DURATION_S),
        build: cloth::build,
    },
    CatalogueEntry {
        name: "hangar",
        description: "a hall of lattice columns and trusses with crane, catwalks, crates and aircraft; rigid parts move",
        triangles_at_scale_1: hangar::TRIANGLES_AT_SCALE_1,
        closed: true,
        watertight: true,
        animation_s: Some(hangar::ANIMATION_S),
        build: hangar::build,
    },
    CatalogueEntry {
        name: "candy",
        description: "sweets in the open: canes, lollipops, jars, wrapped and ring sweets, and two figures that move",
        triangles_at_scale_1: candy::TRIANGLES_AT_SCALE_1,
        closed: false,
        watertight: true,
        animation_s: Some(candy::DURATION_S),
        build: candy::build,
    },
    CatalogueEntry {
        name: "atrium",
        description: "a court between two storeys of fluted columns, arches and balustrades, with drapes and a fountain",
        triangles_at_scale_1: atrium::TRIANGLES_AT_SCALE_1,
        closed: true,
        watertight: true,
        animation_s: None,
        build: atrium::build,
    },
    CatalogueEntry {
        name: "foliage",
        description: "a glade of trees, bushes and grass with a pool; leaves are single surfaces and sway in the wind",
        triangles_at_scale_1: foliage::TRIANGLES_AT_SCALE_1,
        closed: false,
        watertight: false,
        animation_s: Some(foliage::ANIMATION_S),
        build: foliage::build,
    },
    CatalogueEntry {
        name: "smithy",
        description: "a workshop full of tools, barrels, chains, wheels and nested vessels around a forge, deep in layers",
        triangles_at_scale_1: smithy::TRIANGLES_AT_SCALE_1,
        closed: true,
        watertight: true,
        animation_s: None,
        build: smithy::build,
    },
];

/// All procedural scenes, in a fixed order.
pub fn catalogue() -> &'static [CatalogueEntry] {
    &CATALOGUE
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
    let Some(entry) = CATALOGUE.iter().find(|entry| entry.name == name) else {
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
    let build = entry.build;
    let built = build(scale, 0.0);
    let origin = Origin::Procedural { scale };
    let mut scene = Scene::assemble(entry.name.to_owned(), origin, built.mesh, built.cameras, ImportNotes::default());
    scene.camera_path = Some(built.path);
    scene.animation = entry.animation_s.map(|duration_s| Animation {
        duration_s,
        positions_at: Arc::new(move |time_s| {
            if time_s.is_nan() {
                let problem = "the time of an animation is not a number: give seconds".to_owned();
                return Err(SceneError::Invalid { scene: entry.name.to_owned(), problem });
            }
            Ok(build(scale, time_s).mesh.positions)
        }),
        left_out: None,
    });
    Ok(scene)
}
