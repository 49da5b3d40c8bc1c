//! What every build starts from: obvhs's build presets, and the scene's triangles brought to a size that suits them.

use std::sync::Arc;

use glam::Vec3A;
use obvhs::BvhBuildParams;
use obvhs::triangle::Triangle;
use rayon::prelude::*;
use tracebench_api::{Geometry, Parameter, ParameterScope, PhaseClock, TracerError, choice};

choice! {
    /// obvhs's build presets.
    pub(crate) enum BuildPreset {
        Fastest = "fastest",
        VeryFast = "very_fast",
        Fast = "fast",
        Medium = "medium",
        Slow = "slow",
        VerySlow = "very_slow",
    }
}

/// Power of two to which a scene's diagonal is scaled; powers of two lose no bit. obvhs's CWBVH nodes drop everything
/// nearer than 1e-4 whatever the scene's size (at this size that is less than 1e-9 of the diagonal), its boxes have a
/// least extent, and third powers of lengths, which triangle tests are made of, stay within f32's range on the device.
const DIAGONAL_EXPONENT: i32 = 17;

/// The parameter `build`.
pub(crate) fn build_parameter() -> Parameter<BuildPreset> {
    let effect = "obvhs's build preset: slower builds trace faster; slow and very_slow split large triangles";
    Parameter::choice(ParameterScope::Build, BuildPreset::Medium).effect(effect).improved(BuildPreset::Slow)
}

impl BuildPreset {
    /// obvhs's values.
    pub(crate) fn values(self) -> BvhBuildParams {
        match self {
            Self::Fastest => BvhBuildParams::fastest_build(),
            Self::VeryFast => BvhBuildParams::very_fast_build(),
            Self::Fast => BvhBuildParams::fast_build(),
            Self::Medium => BvhBuildParams::medium_build(),
            Self::Slow => BvhBuildParams::slow_build(),
            Self::VerySlow => BvhBuildParams::very_slow_build(),
        }
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
