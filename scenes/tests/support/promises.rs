//! What holds of every answer of the import, whatever the bytes.

use tracebench_scenes::{MAX_COORDINATE, Scene, SceneError, import_bytes};

/// What became of a file that was imported without breaking a promise.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Outcome {
    /// Refused with a message.
    Refused,
    /// A scene that stands still.
    Still,
    /// A scene that moves.
    Moving,
}

/// Imports `bytes` and checks all promises, at a few times if the scene moves.
pub fn check(bytes: &[u8]) -> Result<Outcome, String> {
    match import_bytes(bytes, None, "promised") {
        Ok(scene) => check_scene(&scene),
        Err(error) => check_error(&error).map(|()| Outcome::Refused),
    }
}

/// Checks an imported scene.
pub fn check_scene(scene: &Scene) -> Result<Outcome, String> {
    check_mesh(scene)?;
    for camera in &scene.cameras {
        demand(sound(&[camera.eye, camera.target, camera.up]), "cameras in range")?;
        demand(camera.eye != camera.target, "cameras that look somewhere")?;
    }
    let Some(animation) = &scene.animation else {
        return Ok(Outcome::Still);
    };
    let end = animation.duration_s;
    demand(end.is_finite() && end > 0.0, "an animation has a length")?;
    let start = animation.positions_at(0.0).map_err(|error| format!("time 0 fails: {error}"))?;
    let bits = |positions: &[[f32; 3]]| -> Vec<u32> { positions.iter().flatten().map(|x| x.to_bits()).collect() };
    demand(bits(&start) == bits(&scene.mesh.positions), "the mesh is the state at time 0")?;
    for time in [0.3 * end, 0.5 * end, end, 2.0 * end, f64::INFINITY, f64::NAN] {
        match animation.positions_at(time) {
            Ok(positions) => {
                demand(positions.len() == scene.mesh.positions.len(), "as many positions at any time")?;
                demand(sound(&positions), "positions in range at any time")?;
            }
            Err(error) => check_error(&error)?,
        }
        let mut scene = scene.clone();
        match scene.drop_zero_area(&[time, 0.2 * end]) {
            Ok(()) => check_mesh(&scene)?,
            Err(error) => check_error(&error)?,
        }
    }
    Ok(Outcome::Moving)
}

/// Checks the mesh of an imported scene as it stands.
pub fn check_mesh(scene: &Scene) -> Result<(), String> {
    let mesh = &scene.mesh;
    demand(!mesh.triangles.is_empty(), "at least one triangle")?;
    demand(!mesh.materials.is_empty() && !mesh.objects.is_empty(), "a material and an object")?;
    demand(mesh.triangles.len() == mesh.triangle_materials.len(), "a material a triangle")?;
    demand(mesh.triangles.len() == mesh.triangle_objects.len(), "an object a triangle")?;
    let in_range = |list: &[u32], end: usize| list.iter().all(|&index| (index as usize) < end);
    demand(in_range(&mesh.triangle_materials, mesh.materials.len()), "materials in range")?;
    demand(in_range(&mesh.triangle_objects, mesh.objects.len()), "objects in range")?;
    let mut used = vec![false; mesh.positions.len()];
    for &index in mesh.triangles.iter().flatten() {
        *used.get_mut(index as usize).ok_or("broken promise: vertices in range")? = true;
    }
    demand(used.iter().all(|&used| used), "no vertex without a triangle")?;
    demand(sound(&mesh.positions), "positions in range")?;
    demand(sound(&[scene.bounds_min, scene.bounds_max]), "bounds in range")
}

fn demand(holds: bool, what: &str) -> Result<(), String> {
    if holds { Ok(()) } else { Err(format!("broken promise: {what}")) }
}

fn check_error(error: &SceneError) -> Result<(), String> {
    if error.is_argument() || error.to_string().len() <= 20 {
        return Err(format!("an error that does not say what is wrong with the file: {error}"));
    }
    Ok(())
}

/// Finite and not beyond the greatest coordinate, but for the rounding to f32.
fn sound(positions: &[[f32; 3]]) -> bool {
    positions.iter().flatten().all(|&value| f64::from(value.abs()) <= MAX_COORDINATE * (1.0 + 1e-6))
}
