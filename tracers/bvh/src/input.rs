//! What every build starts from: obvhs's build presets, and the scene's triangles brought to a size that suits them.

use std::sync::Arc;

use glam::Vec3A;
use obvhs::BvhBuildParams;
use obvhs::triangle::Triangle;
use rayon::prelude::*;
use tracebench_api::{Domain, Geometry, ParameterDescription, ParameterScope, PhaseClock, TracerError, Value};

/// Values of `build`.
pub(crate) const BUILDS: &[&str] = &["fastest", "very_fast", "fast", "medium", "slow", "very_slow"];

/// Power of two to which a scene's diagonal is scaled; powers of two lose no bit. obvhs's CWBVH nodes drop everything
/// nearer than 1e-4 whatever the scene's size (at this size that is less than 1e-9 of the diagonal), its boxes have a
/// least extent, and third powers of lengths, which triangle tests are made of, stay within f32's range on the device.
const DIAGONAL_EXPONENT: i32 = 17;

/// The parameter `build`.
pub(crate) fn build_description() -> ParameterDescription {
    let choice = |name: &str| Value::Choice(name.to_owned());
    ParameterDescription {
        name: "build",
        unit: "",
        scope: ParameterScope::Build,
        domain: Domain::Choice(BUILDS),
        published: choice("medium"),
        improved: choice("slow"),
        effect: "obvhs's build preset: slower builds trace faster; slow and very_slow split large triangles",
        sweep: BUILDS.iter().map(|name| choice(name)).collect(),
    }
}

/// obvhs's values for a value of `build`.
pub(crate) fn build_parameters(name: &str) -> BvhBuildParams {
    match name {
        "fastest" => BvhBuildParams::fastest_build(),
        "very_fast" => BvhBuildParams::very_fast_build(),
        "fast" => BvhBuildParams::fast_build(),
        "slow" => BvhBuildParams::slow_build(),
        "very_slow" => BvhBuildParams::very_slow_build(),
        _ => BvhBuildParams::medium_build(),
    }
}

/// The factor that brings a diagonal (scene units) to between a half and a whole of the wanted power of two.
pub(crate) fn scale_for(diagonal: f64) -> f32 {
    let exponent = if diagonal > 0.0 { DIAGONAL_EXPONENT - diagonal.log2().ceil() as i32 } else { 0 };
    // Within f32's normal range, for which coordinates of up to 1e15 leave room.
    2.0_f32.powi(exponent.clamp(-100, 100))
}

/// The scene's triangles in its order, scaled.
pub(crate) fn gather(geometry: &Geometry, scale: f32, clock: &mut PhaseClock<'_>) -> Vec<Triangle> {
    let positions = Arc::clone(&geometry.positions);
    clock.host_phase("gather triangles", || {
        let corner = |vertex: u32| Vec3A::from(positions[vertex as usize]) * scale;
        let gather = |&[a, b, c]: &[u32; 3]| Triangle { v0: corner(a), v1: corner(b), v2: corner(c) };
        geometry.triangles.par_iter().map(gather).collect()
    })
}

/// That a hierarchy over so many triangles can be fitted to a scene.
///
/// # Errors
/// [`TracerError::Failed`] if the scene has another number of them.
pub(crate) fn check_fits(triangle_count: usize, geometry: &Geometry) -> Result<(), TracerError> {
    if geometry.triangles.len() == triangle_count {
        return Ok(());
    }
    Err(TracerError::Failed(format!(
        "a hierarchy over {triangle_count} triangles cannot be fitted to {}: rebuild it",
        geometry.triangles.len()
    )))
}
