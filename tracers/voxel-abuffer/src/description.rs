//! The parameters of `voxel-abuffer`.

use tracebench_api::ParameterScope::{Build, Trace};
use tracebench_api::{Invalidation, Parameter, Query, Residency, TraceTo, TracerDescription, choice, parameters};
use tracebench_kit::{
    Fit, MemoryAccess, RasterBackend, build_parameter, memory_access_parameter, rays_per_lane_parameter,
};

choice! {
    /// What there is beside the grid.
    pub(crate) enum Held { TwoLevel = "two-level", VoxelsOnly = "voxels-only" }
}

choice! {
    /// What a fragment is.
    pub(crate) enum Fragments { Points = "points", Planes = "planes" }
}

choice! {
    /// Which fragments feed the average normals; in the order of the shader's codes.
    pub(crate) enum Fed { All = "all", Dominant = "dominant" }
}

choice! {
    /// What is averaged; in the order of the shader's codes.
    pub(crate) enum Averaged { Normals = "normals", Lines = "lines" }
}

choice! {
    /// Where a voxel's A-buffer is looked at.
    pub(crate) enum Looked { Dda2d = "dda2d", ThreeStep = "three-step", OneStep = "one-step" }
}

impl Looked {
    /// At how many points of a voxel; 0: in every texel.
    pub(crate) fn points(self) -> u32 {
        match self {
            Self::Dda2d => 0,
            Self::ThreeStep => 3,
            Self::OneStep => 1,
        }
    }
}

choice! {
    /// What is asked of a texel that a ray crosses.
    pub(crate) enum InTexel { Layers = "layers", Exit = "exit" }
}

choice! {
    /// Where in its texel a layer is how deep.
    pub(crate) enum Depths { Centre = "centre", Plane = "plane" }
}

choice! {
    /// How inside is told; in the order of the shader's codes.
    pub(crate) enum Inside { Parity = "parity", Nesting = "nesting" }
}

choice! {
    /// What ends a ray; in the order of the shader's codes.
    pub(crate) enum Crossing { State = "state", Change = "change" }
}

choice! {
    /// Along what a ray's start is moved.
    pub(crate) enum StartAlong { Ray = "ray", Normal = "normal" }
}

parameters! {
    /// What `voxel-abuffer` is told.
    pub(crate) struct VoxelParameters {
        /// edge of each of the three images: more are nearer to the surfaces and take memory by the square; 0: two and a half faces of the
        /// viewpoint, which is the paper's 1280 at faces of 512 (section 5)
        abuffer: u32 = Parameter::integer(Build, 0..=16_384, 0).unit("texels").sweep([160, 320, 640, 1280]),
        /// edge of the grid: coarse ones have several surfaces in a voxel, fine ones take steps and memory by the cube; 0: the root of
        /// three times the edge of an image (section 5), rounded up to a multiple of 8, which is the paper's 64 at 1280
        grid: u32 = Parameter::integer(Build, 0..=1024, 0).unit("voxels").sweep([16, 32, 64, 128]),
        /// grid and A-buffers, or a bit a voxel alone, where a ray ends as it enters a voxel that has anything (Figure 9); that has no
        /// surfaces to give
        structure: Held = Parameter::choice(Build, Held::TwoLevel),
        /// what is stored: points, which are samples at texels' centres of all three images, by which rays are told inside from outside
        /// (section 3), or oriented planes, each triangle's in the one image that it faces most, clipped to every texel that it touches: a
        /// hit is where a ray goes through one, so that nothing need be closed. With planes average, average_from, cancelled_below, search,
        /// in_texel, depths, binary_steps, inside and crossing say nothing, and a grid is no finer than the images
        fragments: Fragments = Parameter::choice(Build, Fragments::Points).improved(Fragments::Planes),
        /// what the scene's bounds are mapped to: a cube, by one scale, or the whole of it by a scale an axis, which wastes nothing of long
        /// and flat scenes and makes texels oblong
        fit: Fit = Parameter::choice(Build, Fit::Cube).improved(Fit::Box),
        /// which fragments feed a voxel's average normal: those of all three projections, or each triangle's own by the axis along which
        /// its normal is longest, which count area alike
        average_from: Fed = Parameter::choice(Build, Fed::All),
        /// what a voxel averages: normals (section 3.1), of which opposite ones cancel, or normals as lines, turned so that their longest
        /// component is positive, of which they do not
        average: Averaged = Parameter::choice(Build, Averaged::Normals),
        /// length of an average normal below which it says nothing, as opposite normals have cancelled: the image is then that along which
        /// the ray goes most
        cancelled_below: f64 = Parameter::real(Build, 0.0..=1.0, 0.1).sweep([0.0, 0.1, 0.25, 0.5]),
        /// where in a voxel a ray's side is asked: in every texel that it crosses, at three points or at one (section 3.2), which is faster
        /// and misses what lies between
        search: Looked = Parameter::choice(Trace, Looked::Dda2d),
        /// what dda2d asks of a texel that a ray crosses: the layers that it passes there and the side on which it enters, or the side on
        /// which it leaves alone, which does not see what it crosses twice in a texel: thin walls, and gaps between solids
        in_texel: InTexel = Parameter::choice(Trace, InTexel::Layers),
        /// how deep a layer is where it is compared with a ray: as at its texel's centre, so that slanted surfaces have steps, or as its
        /// plane is there, which reads the normal of every layer
        depths: Depths = Parameter::choice(Trace, Depths::Centre),
        /// halvings between the last two points of a search; none for any hit (section 3.2)
        binary_steps: u32 = Parameter::integer(Trace, 0..=32, 8).unit("halvings").sweep([0, 2, 4, 8, 16]),
        /// how the layers before a point tell whether it is inside: by their number's parity, or by their facings, an object entered where
        /// one faces the image and left where it does not, which takes objects in one another and asks for normals that point outwards;
        /// by parity layers of equal depth and facing are stored as one, by nesting each
        inside: Inside = Parameter::choice(Build, Inside::Parity),
        /// where a ray ends: at the first point that is not on the side on which it enters the voxels that are searched by one image
        /// (section 3.2 asks of the entry point), or not on the one on which it starts, so that a wrong start and what lies behind an open
        /// mesh end it
        crossing: Crossing = Parameter::choice(Trace, Crossing::Change),
        /// texels of its way that a ray leaves out which starts within the scene's bounds: small tells starts on the wrong side of the
        /// surface that they lie on, large misses what lies close to it; through planes none is needed
        start_bias: f64 = Parameter::real(Trace, 0.0..=64.0, 2.0)
            .unit("texels")
            .improved(0.0)
            .sweep([0.0, 0.5, 1.0, 2.0, 4.0]),
        /// along what start_bias goes: the ray, so that what lies near is left out, or the normal of the layer that the start lies on, by which
        /// the whole ray is lifted off that surface, towards where it goes; hits are put back on the ray by the planes of their layers.
        /// Rays that start on no layer leave nothing out then. Through planes along the ray alone
        start_along: StartAlong = Parameter::choice(Trace, StartAlong::Ray),
        build: RasterBackend = build_parameter(),
        memory_access: MemoryAccess = memory_access_parameter(),
        rays_per_lane: u32 = rays_per_lane_parameter(),
    }
}

/// Why there is no refit.
pub(crate) const NO_REFIT: &str = "voxel-abuffer has no shape to keep: its fragments are drawn again or reused";

/// What `voxel-abuffer` is and takes.
pub fn description() -> TracerDescription {
    TracerDescription {
        name: "voxel-abuffer",
        citation: "Hu, Huang, Zhang, Yuan, Li: Ray tracing via GPU rasterization, The Visual Computer 2014",
        summary: "a grid of averaged normals over every fragment of three orthographic images, rays told inside from outside",
        residency: Residency::Device,
        invalidated_by: &[Invalidation::Geometry, Invalidation::Resolution],
        names_primitives: false,
        ends: &TraceTo::ALL,
        queries: &Query::ALL,
        no_refit: Some(NO_REFIT),
        parameters: VoxelParameters::describe(),
    }
}
