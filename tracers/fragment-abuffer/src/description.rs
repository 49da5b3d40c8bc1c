//! The parameters of `fragment-abuffer`.

use tracebench_api::ParameterScope::{Build, Trace};
use tracebench_api::{Parameter, TracerDescription, choice, parameters};
use tracebench_kit::{MemoryAccess, RasterBackend, build_parameter, memory_access_parameter, rays_per_lane_parameter};

choice! {
    /// Whether something is done.
    pub(crate) enum Switch { On = "on", Off = "off" }
    /// How a pixel keeps its fragments (VVP16, section 4.3).
    pub(crate) enum Kind {
        /// A contiguous piece of the nodes, by count and prefix sum:
        SBuffer = "s-buffer",
        /// A list linked forwards:
        Ll = "ll",
        /// A list linked both ways:
        Dll = "dll",
        /// Lists linked forwards, in depth buckets:
        Llb = "llb",
        /// Lists linked both ways, in depth buckets:
        Dllb = "dllb",
    }
    /// What is kept of a triangle in a pixel.
    pub(crate) enum Fragments { Points = "points", Planes = "planes" }
    /// What a plane keeps of its triangle's outline.
    pub(crate) enum Outline { Filled = "filled", Masked = "masked" }
    /// Which pixels a triangle has fragments in.
    pub(crate) enum Coverage { Sample = "sample", Conservative = "conservative" }
    /// Which views there are.
    pub(crate) enum Views { Seven = "seven", Six = "six", Frame = "frame" }
    /// Which fragments of a pixel are kept.
    pub(crate) enum Layers { All = "all", One = "one" }
    /// What draws the depth bounds.
    pub(crate) enum Bounds { Geometry = "geometry", Boxes = "boxes" }
    /// Where the faces' centres lie.
    pub(crate) enum Centre { PulledBack = "pulled_back", Eye = "eye" }
    /// How a ray goes over a view; in the order of the shader's codes.
    pub(crate) enum March { Steps = "steps", Pixels = "pixels", HiZ = "hi-z" }
    /// The depths that a step asks for.
    pub(crate) enum Span { Step = "step", Pixel = "pixel" }
    /// The unit of thickness.
    pub(crate) enum ThicknessUnit { Diagonals = "diagonals", Pixels = "pixels" }
}

parameters! {
    /// What `fragment-abuffer` is told.
    pub(crate) struct FragmentParameters {
        /// what a pixel keeps of a triangle: the depth at the pixel's centre, which a ray meets where its depths span it (section 3.4), or
        /// the triangle's plane with the depths between which the triangle lies in the pixel, which a ray meets where it meets the plane
        fragments: Fragments = Parameter::choice(Build, Fragments::Points).improved(Fragments::Planes),
        /// which pixels a triangle has fragments in: those whose centres it covers, or all that it touches
        coverage: Coverage = Parameter::choice(Build, Coverage::Sample).improved(Coverage::Conservative),
        /// what a plane keeps of its triangle's outline in a pixel: nothing, so that it fills the pixel between its depths, or a bit for
        /// each of 30 parts of the pixel that the triangle touches
        outline: Outline = Parameter::choice(Build, Outline::Filled).improved(Outline::Masked),
        /// how a pixel keeps its fragments (section 4.3): s-buffer, a contiguous piece by count and prefix sum; ll and dll, a list linked
        /// one way or both; llb and dllb, such lists in depth buckets
        storage: Kind = Parameter::choice(Build, Kind::Dllb).improved(Kind::SBuffer),
        /// B, depth buckets of a pixel, uniform in eye depth, of llb and dllb: more have shorter lists and more pointers
        buckets: u32 = Parameter::integer(Build, 1..=64, 4).sweep([1, 2, 4, 8, 12, 16]),
        /// whether what shading needs lies in a buffer of its own (section 3.3), or in the nodes that searches read, where planes share its
        /// normal
        decoupled: Switch = Parameter::choice(Build, Switch::On).improved(Switch::Off),
        /// the camera's view and six cube faces, the faces alone, or the camera's view alone (Figures 7 to 9)
        views: Views = Parameter::choice(Build, Views::Seven),
        /// every fragment of a pixel, or the nearest alone (Figures 8 and 9)
        layers: Layers = Parameter::choice(Build, Layers::All),
        /// what draws the depth bounds that buckets divide (section 3.3): the scene, or the bounding boxes of its objects, which are looser
        bounds: Bounds = Parameter::choice(Build, Bounds::Geometry),
        /// where the faces' centres lie: pulled back by the near distance (section 3.2), or in the eye, which loses what lies before near
        centre: Centre = Parameter::choice(Build, Centre::PulledBack),
        /// how a ray goes over the pixels of a view: in a fixed number of steps, over each that it crosses, or up and down a pyramid of
        /// depth bounds, which is built for it (section 3.4)
        march: March = Parameter::choice(Build, March::Steps).improved(March::HiZ),
        /// steps of a ray in a view where march is steps, fewer where it crosses fewer pixels: fewer are faster and miss more
        view_steps: u32 = Parameter::integer(Trace, 1..=65_536, 100)
            .unit("steps a view")
            .sweep([12, 25, 50, 100, 200, 400, 800]),
        /// where in its steps a ray looks at the image: at an offset that is fixed for the ray, or in their middles
        jitter: Switch = Parameter::choice(Trace, Switch::On),
        /// the depths that a step asks for: those that the ray has along the step, or within the pixel that is looked at, which leaves out
        /// what lies between pixels looked at
        span: Span = Parameter::choice(Trace, Span::Step),
        /// whether pixels are skipped whose depth bounds the ray misses (section 3.4, step a; of s-buffer, ll and dll the depths at their
        /// ends, of ll the near one alone, none of planes); the hits are the same
        skip_bounds: Switch = Parameter::choice(Trace, Switch::On),
        /// whether buckets are skipped that the ray does not meet (section 3.4, step b); the hits are the same
        skip_buckets: Switch = Parameter::choice(Trace, Switch::On),
        /// whether a list is left where its fragments lie beyond the ray; section 3.4 goes through all of an intersected bucket (step c);
        /// the hits are the same
        skip_lists: Switch = Parameter::choice(Trace, Switch::Off).improved(Switch::On),
        /// how far behind its depth a fragment still counts, so that it is a voxel which begins at the surface, or, below 0, how far before
        /// it, so that a ray finds what lies ahead of it (of points; planes have none): 0 as section 3.4 has it, which lets rays through
        /// between fragments; more on either side closes gaps and invents hits
        thickness: f64 = Parameter::real(Trace, -1e4..=1e4, 0.0)
            .unit("scene diagonals, or pixels")
            .sweep([-0.1, -0.05, -0.02, -0.01, -0.003, -0.001, -0.0003, 0.0, 0.0003, 0.001, 0.003, 0.01, 0.02, 0.05, 0.1]),
        /// the unit of thickness: diagonals of the scene's bounds, or widths of a pixel where the ray is
        thickness_in: ThicknessUnit = Parameter::choice(Trace, ThicknessUnit::Diagonals),
        /// pixels along the major axis skipped by rays that start in a view: small finds the surface that a ray starts on, large misses
        /// what lies close to it
        start_bias: f64 = Parameter::real(Trace, 0.0..=64.0, 1.0)
            .improved(0.0)
            .unit("pixels")
            .sweep([0.0, 0.5, 1.0, 2.0, 4.0]),
        /// fragments of a pixel of the s-buffer beyond which they are searched by halving (section 4.3), up to which one by one; planes
        /// always are
        binary_search_above: u32 = Parameter::integer(Trace, 0..=1 << 20, 16)
            .unit("fragments")
            .sweep([0, 4, 16, 64, 1 << 20]),
        /// pixels, or cells of the pyramid, after which a ray is given up with status step_cap, as one is that the driver's own limit of
        /// loops cuts off
        max_steps: u32 = Parameter::integer(Trace, 1..=1 << 20, 1 << 14)
            .unit("pixels")
            .sweep([64, 256, 1024, 4096, 16_384]),
        build: RasterBackend = build_parameter().improved(RasterBackend::Compute),
        memory_access: MemoryAccess = memory_access_parameter(),
        rays_per_lane: u32 = rays_per_lane_parameter(),
    }
}

/// Why there is no refit.
pub(crate) const NO_REFIT: &str = "fragment-abuffer has no shape to keep: its fragments are drawn again or reused";

/// What `fragment-abuffer` is and takes.
pub fn description() -> TracerDescription {
    TracerDescription {
        name: "fragment-abuffer",
        citation: "Vardis, Vasilakis, Papaioannou: A Multiview and Multilayer Approach for Interactive Ray Tracing, I3D 2016",
        summary: "every fragment of the pixels of seven views, in lists by depth, rays marched over the images",
        ..TracerDescription::of_views(NO_REFIT, FragmentParameters::describe())
    }
}
