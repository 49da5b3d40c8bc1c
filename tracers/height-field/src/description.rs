//! The parameters of `height-field`.

use tracebench_api::ParameterScope::{Build, Trace};
use tracebench_api::{Parameter, TracerDescription, choice, parameters};
use tracebench_kit::{MemoryAccess, RasterBackend, build_parameter, memory_access_parameter, rays_per_lane_parameter};

choice! {
    /// What the pyramid has of a cell.
    pub(crate) enum Pyramid { MinMax = "min-max", Max = "max" }
    /// How it is found where in its pixel a ray comes behind the surface.
    pub(crate) enum Search { Halvings = "halvings", Closed = "closed" }
    /// Whether something is done.
    pub(crate) enum Switch { Off = "off", On = "on" }
}

parameters! {
    /// What `height-field` is told.
    pub(crate) struct HeightParameters {
        /// what is kept of a cell: both of its depth bounds, or the greatest height alone (the nearest depth), half as much memory; the
        /// hits are the same
        pyramid: Pyramid = Parameter::choice(Build, Pyramid::MinMax),
        /// how it is found where in its pixel a ray comes behind the surface: by halvings, or at once, as the surface is level there
        search: Search = Parameter::choice(Trace, Search::Halvings).improved(Search::Closed),
        /// whether rays are cut before the nearest depth that the view has; the hits are the same
        depth_clip: Switch = Parameter::choice(Trace, Switch::Off).improved(Switch::On),
        /// halvings of a ray's part in the pixel where it comes behind the surface: fewer place hits farther behind it
        refinement: u32 = Parameter::integer(Trace, 0..=32, 24).unit("halvings").sweep([0, 4, 8, 16, 24]),
        /// pixels along the major axis skipped by rays that start in the view: with none a ray that starts behind the stored depth of its
        /// pixel hits at its start
        start_bias: f64 = Parameter::real(Trace, 0.0..=64.0, 0.0).unit("pixels").sweep([0.0, 0.5, 1.0, 2.0, 4.0]),
        build: RasterBackend = build_parameter(),
        memory_access: MemoryAccess = memory_access_parameter(),
        rays_per_lane: u32 = rays_per_lane_parameter(),
    }
}

/// Why there is no refit.
pub(crate) const NO_REFIT: &str = "height-field has no shape to keep: its depth buffer is rebuilt or reused";

/// What `height-field` is and takes.
pub fn description() -> TracerDescription {
    TracerDescription {
        name: "height-field",
        citation: "Tevs, Ihrke, Seidel: Maximum Mipmaps for Fast, Accurate, and Scalable Dynamic Height Field Rendering, I3D 2008",
        summary: "the depth buffer of one view as a height field with a pyramid, all behind it solid",
        ..TracerDescription::of_views(NO_REFIT, HeightParameters::describe())
    }
}
