//! The parameters of `ray-query`.

use tracebench_api::{Description, Domain, Invalidation, ParameterDescription, ParameterScope, Residency, Value};

/// Values of `prefer`.
const PREFERENCES: &[&str] = &["fast_trace", "fast_build"];

/// Values of `equal_t`.
const EQUAL_T: &[&str] = &["lowest", "first_met"];

/// What `ray-query` is and takes.
pub fn description() -> Description {
    let choice = |name: &str| Value::Choice(name.to_owned());
    Description {
        name: "ray-query",
        citation: "Khronos Group: VK_KHR_acceleration_structure and VK_KHR_ray_query, 2020; through wgpu",
        summary: "the device's own acceleration structure, built by its driver and searched by ray queries in compute",
        residency: Residency::Device,
        invalidated_by: &[Invalidation::Geometry],
        names_primitives: true,
        parameters: vec![
            ParameterDescription {
                name: "prefer",
                unit: "",
                scope: ParameterScope::Build,
                domain: Domain::Choice(PREFERENCES),
                published: choice("fast_trace"),
                improved: choice("fast_trace"),
                effect: "what the driver is asked to favour; it may build the same either way",
                sweep: PREFERENCES.iter().map(|name| choice(name)).collect(),
            },
            ParameterDescription {
                name: "equal_t",
                unit: "",
                scope: ParameterScope::Trace,
                domain: Domain::Choice(EQUAL_T),
                published: choice("lowest"),
                improved: choice("lowest"),
                effect: "which of the triangles at equal t a closest hit names: the lowest, as every tracer here, by a second \
                         query close round the hit, or the first that the driver meets, without it",
                sweep: EQUAL_T.iter().map(|name| choice(name)).collect(),
            },
        ],
    }
}
