//! Structures that are read back and checked: what they say of themselves, or what is wrong in words that a user can follow.

use glam::Vec3;
use tracebench_api::{Geometry, Structure, TracerError};
use tracebench_scenes::is_far;

/// What a structure says of itself, if it holds what it should.
pub(super) fn statistics(
    structure: &dyn Structure,
    geometry: &Geometry,
) -> Result<Vec<(&'static str, f64)>, TracerError> {
    let found = structure.validate(geometry).map_err(|error| match error {
        // In full: what is wrong, and what it means for who asked.
        TracerError::Failed(what) => {
            let advice = match is_far(geometry.diagonal(), geometry.farthest_corner(Vec3::ZERO)) {
                true => "the scene lies too far from the origin for its positions in f32: move it towards the origin",
                false => "the tracer is wrong here, and not the scene",
            };
            TracerError::Failed(format!(
                "{what}; its structure does not hold what the triangles give, so it is not measured in this scene ({advice})"
            ))
        }
        other => other,
    })?;
    match found.iter().find(|(_, value)| !value.is_finite()) {
        Some((name, value)) => Err(TracerError::Failed(format!("its structure says that {name} is {value}"))),
        None => Ok(found),
    }
}
