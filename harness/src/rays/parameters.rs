//! What can be said about ray sets: `--set rays.NAME=VALUE`.

use tracebench_api::ParameterScope::Trace;
use tracebench_api::{Parameter, ParameterDescription, ParameterError, Parameters, Preset, Value, choice, parameters};

choice! {
    /// The order in which a set's rays are handed to tracers.
    pub enum Order { Scanline = "scanline", Tile = "tile", Shuffled = "shuffled" }
}

choice! {
    /// Which of its two targets `visibility` aims at.
    pub enum Target { Both = "both", Outside = "outside", Inside = "inside" }
}

parameters! {
    /// What ray sets are told. One value each: presets of tracers do not concern rays.
    pub struct RayParameters {
        /// order of every set's rays; tiles are 8x8 pixels
        order: Order = Parameter::choice(Trace, Order::Scanline).sweep([]),
        /// where `visibility` rays end
        visibility_target: Target = Parameter::choice(Trace, Target::Both).sweep([]),
        /// width of the lobe of `glossy`, `glossy2` and `glossy3`; 1 is nearly diffuse
        glossy_roughness: f64 = Parameter::real(Trace, 0.001..=1.0, 0.25).unit("GGX alpha"),
        /// how much denser solids are than air, for `refraction`
        refractive_index: f64 = Parameter::real(Trace, 1.0..=4.0, 1.5),
        /// rays that `pixel-random` starts from every primary hit
        pixel_random_count: u32 = Parameter::integer(Trace, 1..=1024, 20).unit("rays a pixel"),
        /// how far the second eye of `stereo` lies to the right: half of 6.4 cm in scenes in metres
        stereo_offset: f64 = Parameter::real(Trace, -1e6..=1e6, 0.032).unit("scene units"),
        /// how much later on the camera path `temporal` starts; at most the path's end
        temporal_shift_s: f64 = Parameter::real(Trace, 0.0..=1e4, 0.5).unit("s"),
        /// rays that `lens` starts at every pixel
        lens_count: u32 = Parameter::integer(Trace, 1..=64, 1).unit("rays a pixel"),
        /// diameter of the thin lens of `lens`, in scene diagonals
        lens_aperture: f64 = Parameter::real(Trace, 0.0..=1.0, 0.01).unit("diagonals"),
        /// eye depth in focus, in scene diagonals, 0.001 or more; 0 is that of what the image's centre shows
        lens_focus: f64 = Parameter::real(Trace, 0.0..=1e3, 0.0).unit("diagonals"),
        /// edge of the square of cameras of `light-field`
        light_field_cameras: u32 = Parameter::integer(Trace, 1..=64, 4).unit("cameras a side"),
        /// distance between the outer cameras of `light-field`, in scene diagonals
        light_field_width: f64 = Parameter::real(Trace, 0.0..=1.0, 0.05).unit("diagonals"),
    }
}

/// Every parameter of the ray sets.
pub fn ray_parameters() -> Vec<ParameterDescription> {
    RayParameters::describe()
}

/// The values that count where nothing is set.
pub fn default_parameters() -> Parameters {
    Parameters::preset(&ray_parameters(), Preset::Published)
}

/// The least eye depth in focus: what lies nearer than near planes no view shows.
const MIN_FOCUS: f64 = 1e-3;

/// Refuses values that lie within their ranges and mean nothing all the same.
///
/// # Errors
/// [`ParameterError::Value`] with what is allowed.
pub fn check_ray_parameters(parameters: &Parameters) -> Result<(), ParameterError> {
    let name = "lens_focus";
    match parameters.value(name) {
        Some(Value::Real(focus)) if *focus > 0.0 && *focus < MIN_FOCUS => Err(ParameterError::Value {
            name: name.to_owned(),
            given: focus.to_string(),
            expected: format!("0, or a number from {MIN_FOCUS} on"),
        }),
        _ => Ok(()),
    }
}
