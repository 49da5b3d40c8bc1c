//! The parameters of `screen-dda`.

use tracebench_api::{Description, Domain, Invalidation, ParameterDescription, ParameterScope, Residency, Value};

/// The names of the ways to place a hit, in the order of the shader's codes.
pub(crate) const HIT_POINTS: &[&str] = &["step", "depth"];

/// What `screen-dda` is and takes.
pub fn description() -> Description {
    let reals = |values: &[f64]| values.iter().copied().map(Value::Real).collect();
    let integers = |values: &[i64]| values.iter().copied().map(Value::Integer).collect();
    let choice = |name: &str| Value::Choice(name.to_owned());
    let parameter = |name, unit, domain, value: Value, effect, sweep| ParameterDescription {
        name,
        unit,
        scope: ParameterScope::Trace,
        domain,
        published: value.clone(),
        improved: value,
        effect,
        sweep,
    };
    Description {
        name: "screen-dda",
        citation: "McGuire, Mara: Efficient GPU Screen-Space Ray Tracing, JCGT 3(4), 2014",
        summary: "perspective-correct DDA over the depth buffer of one view",
        residency: Residency::Device,
        invalidated_by: &[Invalidation::Geometry, Invalidation::Viewpoint, Invalidation::Resolution],
        names_primitives: false,
        parameters: vec![
            parameter(
                "stride",
                "pixels",
                Domain::Integer { least: 1, greatest: 256 },
                Value::Integer(1),
                "pixels along the major axis between depth samples: larger is faster and skips thin things",
                integers(&[1, 2, 4, 8, 16]),
            ),
            parameter(
                "max_steps",
                "samples",
                Domain::Integer { least: 1, greatest: 65_536 },
                Value::Integer(4096),
                "depth samples after which a ray is given up with status step_cap",
                integers(&[16, 64, 256, 1024, 4096]),
            ),
            parameter(
                "thickness",
                "scene diagonals",
                Domain::Real { least: 0.0, greatest: 10.0 },
                Value::Real(0.005),
                "depth that every stored surface is taken to have: small loses hits, large invents them",
                reals(&[0.0, 0.0005, 0.001, 0.002, 0.005, 0.01, 0.02, 0.05]),
            ),
            parameter(
                "start_bias",
                "pixels",
                Domain::Real { least: 0.0, greatest: 64.0 },
                Value::Real(1.0),
                "pixels along the major axis skipped by rays that start in the view: small finds the surface that a \
                 ray starts on, large misses what lies close to it",
                reals(&[0.0, 0.5, 1.0, 2.0, 4.0]),
            ),
            parameter(
                "hit_point",
                "",
                Domain::Choice(HIT_POINTS),
                choice("step"),
                "where in its step a hit is placed: at the step's position (listing 1), or at the stored eye depth; rays that \
                 fall on one pixel always at the stored depth",
                HIT_POINTS.iter().map(|name| choice(name)).collect(),
            ),
        ],
    }
}
