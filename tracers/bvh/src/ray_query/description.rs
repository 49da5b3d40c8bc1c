//! The parameters of `ray-query`.

use tracebench_api::{Parameter, ParameterScope, TracerDescription, choice, parameters};

choice! {
    /// What the driver favours.
    pub(crate) enum Preference { FastTrace = "fast_trace", FastBuild = "fast_build" }
    /// Which of the triangles at equal t a closest hit names.
    pub(crate) enum EqualT { Lowest = "lowest", FirstMet = "first_met" }
}

parameters! {
    /// What `ray-query` is told.
    pub(crate) struct QueryParameters {
        /// what the driver is asked to favour; it may build the same either way
        prefer: Preference = Parameter::choice(ParameterScope::Build, Preference::FastTrace),
        /// which of the triangles at equal t a closest hit names: the lowest, as every tracer here, by a second query close round the hit,
        /// or the first that the driver meets, without it
        equal_t: EqualT = Parameter::choice(ParameterScope::Trace, EqualT::Lowest),
    }
}

/// Why there is no refit.
pub(crate) const NO_REFIT: &str = "wgpu 30 builds an acceleration structure anew where an update in place is asked for \
     (AccelerationStructureUpdateMode::PreferUpdate): rebuild it";

/// What `ray-query` is and takes.
pub fn description() -> TracerDescription {
    TracerDescription {
        name: "ray-query",
        citation: "Khronos Group: VK_KHR_acceleration_structure and VK_KHR_ray_query, 2020; through wgpu",
        summary: "the device's own acceleration structure, built by its driver and searched by ray queries in compute",
        no_refit: Some(NO_REFIT),
        ..TracerDescription::on_device(QueryParameters::describe())
    }
}
