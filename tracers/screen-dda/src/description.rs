//! The parameters of `screen-dda`.

use tracebench_api::ParameterScope::{Build, Trace};
use tracebench_api::{Parameter, TracerDescription, choice, parameters};
use tracebench_kit::{MemoryAccess, RasterBackend, build_parameter, memory_access_parameter, rays_per_lane_parameter};

choice! {
    /// Where in its step a hit is placed; in the order of the shader's codes.
    pub(crate) enum HitPoint { Step = "step", Depth = "depth" }
    /// How a ray goes over its samples.
    pub(crate) enum March { Pixels = "pixels", HiZ = "hi-z", Cells = "cells" }
    /// What says how thick a stored surface is.
    pub(crate) enum ThicknessFrom { Assumed = "assumed", BackFaces = "back_faces" }
    /// What thickness is a share of.
    pub(crate) enum ThicknessUnit { Diagonals = "diagonals", Depth = "depth" }
    /// Whether rays hit what they meet from the side that the view does not see.
    pub(crate) enum FromBehind { Hit = "hit", Pass = "pass" }
    /// Whether something is done.
    pub(crate) enum Switch { Off = "off", On = "on" }
}

/// Most layers, as many as the authors' released code has.
pub(crate) const MAX_LAYERS: u32 = 4;

parameters! {
    /// What `screen-dda` is told.
    pub(crate) struct DdaParameters {
        /// pixels along the major axis between depth samples: larger is faster and skips thin things
        stride: u32 = Parameter::integer(Trace, 1..=256, 1).unit("pixels").sweep([1, 2, 4, 8, 16]),
        /// depth samples of its way after which a ray is given up with status step_cap, those that march=hi-z skips among them; with
        /// march=cells pixels and cells of the pyramid that it visits; WKP15 set 200 for stereo, 500 for temporal and 25 for lens rays
        max_steps: u32 = Parameter::integer(Trace, 1..=65_536, 4096)
            .unit("samples")
            .sweep([16, 25, 64, 200, 256, 500, 1024, 4096]),
        /// depth that every stored surface is taken to have: small loses hits, large invents them
        thickness: f64 = Parameter::real(Trace, 0.0..=10.0, 0.005)
            .improved(0.02)
            .unit("scene diagonals, or shares of depth")
            .sweep([0.0, 0.0005, 0.001, 0.002, 0.005, 0.01, 0.02, 0.05]),
        /// what thickness is a share of: the diagonal of the scene's bounds, or the stored depth
        thickness_in: ThicknessUnit =
            Parameter::choice(Trace, ThicknessUnit::Diagonals).improved(ThicknessUnit::Depth),
        /// whether a ray hits a surface that it does not come to from before (march=cells): pass leaves out what it meets from behind, or
        /// starts in
        from_behind: FromBehind = Parameter::choice(Trace, FromBehind::Hit).improved(FromBehind::Pass),
        /// pixels along the major axis skipped by rays that start in the view: small finds the surface that a ray starts on, large misses
        /// what lies close to it
        start_bias: f64 = Parameter::real(Trace, 0.0..=64.0, 1.0).unit("pixels").sweep([0.0, 0.5, 1.0, 2.0, 4.0]),
        /// where in its step a hit is placed: at the step's position (listing 1), or at the stored eye depth; rays that fall on one pixel
        /// always at the stored depth
        hit_point: HitPoint = Parameter::choice(Trace, HitPoint::Step).improved(HitPoint::Depth),
        /// depths stored at a pixel, the nearest and those behind it: more find what is hidden, for more to draw and to look at
        layers: u32 = Parameter::integer(Build, 1..=MAX_LAYERS, 1).unit("layers").sweep([1, 2, 4]),
        /// least distance in eye depth of a layer from the one before: more keeps close surfaces from filling all layers, and loses them
        layer_separation: f64 = Parameter::real(Build, 0.0..=1.0, 0.0)
            .unit("scene diagonals")
            .sweep([0.0, 0.002, 0.01, 0.05]),
        /// what says how thick a stored surface is: thickness alone, or the nearest back face behind it and thickness where there is none
        thickness_from: ThicknessFrom = Parameter::choice(Build, ThicknessFrom::Assumed),
        /// how a ray goes over its samples: one after the other, or up and down a pyramid of depth bounds, built for it, which skips
        /// samples that cannot hit; the hits are the same. cells: up and down the pyramid over every pixel that it crosses
        march: March = Parameter::choice(Build, March::Pixels).improved(March::Cells),
        /// whether rays are cut to the depths between which the view has surfaces (march=cells); the hits are the same
        depth_clip: Switch = Parameter::choice(Trace, Switch::Off).improved(Switch::On),
        build: RasterBackend = build_parameter(),
        memory_access: MemoryAccess = memory_access_parameter(),
        rays_per_lane: u32 = rays_per_lane_parameter(),
    }
}

/// Why there is no refit.
pub(crate) const NO_REFIT: &str = "screen-dda has no shape to keep: its depth buffer is rebuilt or reused";

/// What `screen-dda` is and takes.
pub fn description() -> TracerDescription {
    TracerDescription {
        name: "screen-dda",
        citation: "McGuire, Mara: Efficient GPU Screen-Space Ray Tracing, JCGT 3(4), 2014",
        summary: "perspective-correct DDA over the depth buffer of one view, or over several depth layers",
        ..TracerDescription::of_views(NO_REFIT, DdaParameters::describe())
    }
}
