//! The parameters of `mesh-warp`.

use tracebench_api::ParameterScope::Build;
use tracebench_api::{Parameter, TracerDescription, choice, parameters};
use tracebench_kit::{RasterBackend, build_parameter};

choice! {
    /// What becomes of triangles over a step in depth.
    pub(crate) enum Discontinuity { Keep = "keep", Cut = "cut" }
}

parameters! {
    /// What `mesh-warp` is told.
    pub(crate) struct WarpParameters {
        /// what becomes of triangles over a step in depth: they are kept, stretched between foreground and background (Figure 6b), or cut out,
        /// which leaves holes
        discontinuity: Discontinuity = Parameter::choice(Build, Discontinuity::Keep),
        /// by how much the vertices of a triangle must differ in depth for it to lie over a step: less takes surfaces that are seen at a slant
        /// for steps, more takes steps for surfaces, whose planes go on beside their triangles
        step_from: f64 = Parameter::real(Build, 0.0..=1e4, 16.0)
            .unit("pixel heights at that depth")
            .sweep([2.0, 4.0, 8.0, 16.0, 32.0, 64.0]),
        build: RasterBackend = build_parameter(),
    }
}

/// Why there is no refit.
pub(crate) const NO_REFIT: &str = "mesh-warp has no shape to keep: its mesh is made again or reused";

/// What `mesh-warp` is and takes.
pub fn description() -> TracerDescription {
    TracerDescription {
        name: "mesh-warp",
        citation: "Bowles, Mitchell, Sumner, Moore, Gross: Iterative Image Warping, CGF 31(2), 2012; Didyk, Eisemann, Ritschel, \
                   Myszkowski, Seidel: Perceptually-motivated Real-time Temporal Upsampling of 3D Content, CGF 29(2), 2010",
        summary: "the depth buffer of one view as a mesh, drawn from the one point that rays start in",
        ..TracerDescription::of_views(NO_REFIT, WarpParameters::describe())
    }
}
