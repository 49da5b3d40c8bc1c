//! The parameters of `screen-dda`.

use tracebench_api::ParameterScope::Trace;
use tracebench_api::{Description, EndPoint, Invalidation, Parameter, Query, Residency, choice, parameters};
use tracebench_kit::{Reads, rays_per_lane_parameter, reads_parameter};

use crate::structure::layouts;

choice! {
    /// Where in its step a hit is placed; in the order of the shader's codes.
    pub(crate) enum HitPoint { Step = "step", Depth = "depth" }
}

parameters! {
    /// What `screen-dda` is told.
    pub(crate) struct DdaParameters {
        stride: u32 = Parameter::integer(
            Trace,
            1..=256,
            1,
            "pixels along the major axis between depth samples: larger is faster and skips thin things",
        )
        .unit("pixels")
        .sweep([1, 2, 4, 8, 16]),
        max_steps: u32 = Parameter::integer(
            Trace,
            1..=65_536,
            4096,
            "depth samples after which a ray is given up with status step_cap",
        )
        .unit("samples")
        .sweep([16, 64, 256, 1024, 4096]),
        thickness: f64 = Parameter::real(
            Trace,
            0.0..=10.0,
            0.005,
            "depth that every stored surface is taken to have: small loses hits, large invents them",
        )
        .unit("scene diagonals")
        .sweep([0.0, 0.0005, 0.001, 0.002, 0.005, 0.01, 0.02, 0.05]),
        start_bias: f64 = Parameter::real(
            Trace,
            0.0..=64.0,
            1.0,
            "pixels along the major axis skipped by rays that start in the view: small finds the surface that a \
             ray starts on, large misses what lies close to it",
        )
        .unit("pixels")
        .sweep([0.0, 0.5, 1.0, 2.0, 4.0]),
        hit_point: HitPoint = Parameter::choice(
            Trace,
            HitPoint::Step,
            "where in its step a hit is placed: at the step's position (listing 1), or at the stored eye depth; rays that \
             fall on one pixel always at the stored depth",
        ),
        reads: Reads = reads_parameter(),
        rays_per_lane: u32 = rays_per_lane_parameter(),
    }
}

/// Why there is no refit.
pub(crate) const NO_REFIT: &str = "screen-dda has no shape to keep: its depth buffer is rebuilt or reused";

/// What `screen-dda` is and takes.
pub fn description() -> Description {
    Description {
        name: "screen-dda",
        citation: "McGuire, Mara: Efficient GPU Screen-Space Ray Tracing, JCGT 3(4), 2014",
        summary: "perspective-correct DDA over the depth buffer of one view",
        residency: Residency::Device,
        invalidated_by: &[Invalidation::Geometry, Invalidation::Viewpoint, Invalidation::Resolution],
        names_primitives: false,
        ends: &EndPoint::ALL,
        queries: &Query::ALL,
        no_refit: Some(NO_REFIT),
        parameters: DdaParameters::describe(),
        layouts: layouts(),
    }
}
