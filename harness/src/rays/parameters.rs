//! What can be said about ray sets: `--set rays.NAME=VALUE`.

use tracebench_api::{Domain, ParameterDescription, ParameterScope, Parameters, Preset, Value};

use super::order::ORDERS;

/// Which of its two targets `visibility` aims at.
const TARGETS: &[&str] = &["both", "outside", "inside"];

fn describe(
    name: &'static str,
    unit: &'static str,
    domain: Domain,
    default: Value,
    effect: &'static str,
) -> ParameterDescription {
    let improved = default.clone();
    let scope = ParameterScope::Trace;
    ParameterDescription { name, unit, scope, domain, published: default, improved, effect, sweep: Vec::new() }
}

/// Every parameter of the ray sets. One value each: presets of tracers do not concern rays.
pub fn ray_parameters() -> Vec<ParameterDescription> {
    let real = |least: f64, greatest: f64| Domain::Real { least, greatest };
    let choice = |name: &str| Value::Choice(name.to_owned());
    vec![
        describe(
            "order",
            "",
            Domain::Choice(ORDERS),
            choice("scanline"),
            "order of every set's rays; tiles are 8x8 pixels",
        ),
        describe("visibility_target", "", Domain::Choice(TARGETS), choice("both"), "where `visibility` rays end"),
        describe(
            "glossy_roughness",
            "GGX alpha",
            real(0.001, 1.0),
            Value::Real(0.25),
            "width of the lobe of `glossy`; 1 is nearly diffuse",
        ),
        describe(
            "refractive_index",
            "",
            real(1.0, 4.0),
            Value::Real(1.5),
            "how much denser solids are than air, for `refraction`",
        ),
        describe(
            "pixel_random_count",
            "rays a pixel",
            Domain::Integer { least: 1, greatest: 1024 },
            Value::Integer(20),
            "rays that `pixel-random` starts from every primary hit",
        ),
        describe(
            "stereo_offset",
            "scene units",
            real(-1e6, 1e6),
            Value::Real(0.032),
            "how far the second eye of `stereo` lies to the right: half of 6.4 cm in scenes in metres",
        ),
        describe(
            "temporal_shift_s",
            "s",
            real(0.0, 1e4),
            Value::Real(0.5),
            "how much later on the camera path `temporal` starts; at most the path's end",
        ),
        describe(
            "lens_aperture",
            "diagonals",
            real(0.0, 1.0),
            Value::Real(0.01),
            "diameter of the thin lens of `lens`, in scene diagonals",
        ),
        describe(
            "lens_focus",
            "diagonals",
            real(0.0, 1e3),
            Value::Real(0.0),
            "eye depth in focus, in scene diagonals; 0 is that of what the image's centre shows",
        ),
        describe(
            "light_field_cameras",
            "cameras a side",
            Domain::Integer { least: 1, greatest: 64 },
            Value::Integer(4),
            "edge of the square of cameras of `light-field`",
        ),
        describe(
            "light_field_width",
            "diagonals",
            real(0.0, 1.0),
            Value::Real(0.05),
            "distance between the outer cameras of `light-field`, in scene diagonals",
        ),
    ]
}

/// The values that count where nothing is set.
pub fn default_parameters() -> Parameters {
    Parameters::preset(&ray_parameters(), Preset::Published)
}
