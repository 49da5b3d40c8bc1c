//! The parameters of `quadtree`.

use tracebench_api::ParameterScope::{Build, Trace};
use tracebench_api::{Invalidation, Parameter, Query, Residency, TraceTo, TracerDescription, choice, parameters};
use tracebench_kit::{MemoryAccess, RasterBackend, build_parameter, memory_access_parameter, rays_per_lane_parameter};

/// Layers of a view at most.
pub(crate) const MAX_LAYERS: u32 = 4;

/// Levels above the pixels at most (WKP15, section 3.2).
pub(crate) const MAX_TREE_LEVELS: u32 = 9;

choice! {
    /// How layers are caught.
    pub(crate) enum Capture { KBuffer = "k-buffer", Peeling = "peeling" }
}

choice! {
    /// Whether surfaces count that face away from the eye.
    pub(crate) enum BackFaces { Kept = "kept", Culled = "culled" }
}

choice! {
    /// Which views there are.
    pub(crate) enum Views { Frame = "frame", Six = "six" }
}

choice! {
    /// Where the normals of the bottom level come from; in the order of the shader's codes.
    pub(crate) enum Normals { Depth = "depth", Geometry = "geometry" }
}

choice! {
    /// The unit of `gamma_dist`; in the order of the shader's codes.
    pub(crate) enum DistanceIn { Cube = "cube", Pixels = "pixels" }
}

choice! {
    /// Which planes reach beyond their nodes; in the order of the shader's codes.
    pub(crate) enum Dilated { None = "none", Continuous = "continuous", Flagged = "flagged", All = "all" }
}

choice! {
    /// What a pixel's plane is taken for where an edge crosses its pixel.
    pub(crate) enum Patches { Squares = "squares", Joined = "joined" }
}

choice! {
    /// How the successor of a node is found.
    pub(crate) enum Traversal { Xor = "xor", Stack = "stack" }
}

choice! {
    /// The node at which a walk begins.
    pub(crate) enum WalkFrom { Root = "root", Ancestor = "ancestor" }
}

choice! {
    /// When the next layer is asked; in the order of the shader's codes.
    pub(crate) enum NextLayer { Volumes = "volumes", Misses = "misses", Always = "always" }
}

choice! {
    /// Where holes are filled.
    pub(crate) enum Inpainting { OneLayer = "one_layer", Never = "never", Always = "always" }
}

choice! {
    /// Where inpainted hits lie; in the order of the shader's codes.
    pub(crate) enum InpaintedAt { Volume = "volume", Plane = "plane" }
}

parameters! {
    /// What `quadtree` is told.
    pub(crate) struct QuadtreeParameters {
        /// depth layers of a view: more know more of what is hidden, take as much more memory, and with one holes are inpainted
        layers: u32 = Parameter::integer(Build, 1..=MAX_LAYERS, 2).unit("layers").improved(4).sweep([1, 2, 3, 4]),
        /// how layers are caught: in one pass by a k-buffer of cascaded atomic minima (section 3.1), or by peeling, a pass a layer; without
        /// a minimum separation both catch the same
        capture: Capture = Parameter::choice(Build, Capture::KBuffer),
        /// whether surfaces that face away from the eye are layers: the back of a thing fills the layer behind its front
        back_faces: BackFaces = Parameter::choice(Build, BackFaces::Kept),
        /// how far a layer lies behind the one before at least: more leaves out what is close behind, so that the next layer shows what is
        /// farther; peeling finds it, a k-buffer has caught twice as many depths as there are layers and keeps what it can
        minimum_separation: f64 = Parameter::real(Build, 0.0..=1.0, 0.0)
            .unit("scene diagonals")
            .sweep([0.0, 0.001, 0.005, 0.02, 0.05]),
        /// the camera's view, or six faces of a cube round the eye (section 5.4)
        views: Views = Parameter::choice(Build, Views::Frame),
        /// where the bottom level's normals come from (section 3.2): from the depths round a pixel, or from the triangles
        normals: Normals = Parameter::choice(Build, Normals::Depth).improved(Normals::Geometry),
        /// by how much a neighbour's depth differs from what a pixel's plane foretells before the pixel is flagged as lying near a
        /// discontinuity, and its normal not taken from that side
        discontinuity: f64 = Parameter::real(Build, 0.0..=1e4, 2.0)
            .unit("pixel heights at that depth")
            .improved(0.5)
            .sweep([0.5, 1.0, 2.0, 4.0, 8.0]),
        /// levels above the pixels at most (section 3.2); where they do not reach one root there is a grid of roots
        levels: u32 = Parameter::integer(Build, 0..=MAX_TREE_LEVELS, MAX_TREE_LEVELS)
            .unit("levels")
            .sweep([0, 3, 6, 8, 9]),
        /// angle in the unit cube by which a child's normal may be off the plane that stands for it (section 3.3); with 0 nothing is merged
        gamma_norm: f64 = Parameter::real(Build, 0.0..=90.0, 3.0)
            .unit("degrees")
            .sweep([0.0, 1.0, 3.0, 8.0, 15.0, 25.0]),
        /// distance by which a child's corners may be off the plane that stands for it (section 3.3); with 0 nothing is merged
        gamma_dist: f64 = Parameter::real(Build, 0.0..=1e3, 1e-5)
            .unit("unit cubes, or pixel heights at that depth")
            .improved(0.25)
            .sweep([0.0, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1]),
        /// the unit of gamma_dist: edges of the unit cube, as in the paper, or heights of a pixel at the plane's depth
        gamma_dist_in: DistanceIn = Parameter::choice(Build, DistanceIn::Cube).improved(DistanceIn::Pixels),
        /// by how many times themselves both gammas grow from the eye to far, linear in a node's mean depth (section 6); 0 for fixed ones
        gamma_growth: f64 = Parameter::real(Build, 0.0..=1e4, 0.0).sweep([0.0, 1.0, 4.0, 16.0, 64.0]),
        /// how far planes reach beyond their nodes, so that rays do not slip through cracks between planes of different orientation
        /// (section 3.2)
        dilation: f64 = Parameter::real(Build, 0.0..=16.0, 0.5).unit("pixels").sweep([0.0, 0.25, 0.5, 1.0, 2.0]),
        /// which planes reach beyond their nodes: those that no discontinuity lies near, those that one does, all, or none
        dilated: Dilated = Parameter::choice(Build, Dilated::Continuous),
        /// where a flagged pixel's plane ends: at the pixel's sides, as the others, or where it meets that of a pixel beside it at an edge
        /// towards the eye, behind which the neighbour's goes on; pixels whose planes end are then not merged and reach beyond nothing, and
        /// a trace reads the nodes beside every such pixel whose plane it gets behind
        patches: Patches = Parameter::choice(Build, Patches::Squares).improved(Patches::Joined),
        /// how the next node on a ray's way is found: from the highest bit in which the nodes' places differ (section 4), or from a stack
        /// of the nodes above; the hits are the same
        traversal: Traversal = Parameter::choice(Trace, Traversal::Xor),
        /// the node at which a walk begins: the root over the ray's begin, or the child there of the last node that holds both of its ends;
        /// the hits are the same
        walk_from: WalkFrom = Parameter::choice(Trace, WalkFrom::Root).improved(WalkFrom::Ancestor),
        /// when the next layer is asked: where a ray passed an occlusion volume before its hit (section 4.1), where it hit nothing (section
        /// 2.3), or always
        next_layer: NextLayer = Parameter::choice(Trace, NextLayer::Volumes),
        /// whether a ray ends with a hit where it enters an occlusion volume of the last layer (section 4.1): where there is one layer
        /// alone, never, or always
        inpainting: Inpainting = Parameter::choice(Trace, Inpainting::OneLayer),
        /// where an inpainted hit lies: half a pixel before the volume (section 4.1), or farther on, where the ray gets behind the plane of
        /// the pixel there, if it does
        inpainted_at: InpaintedAt = Parameter::choice(Trace, InpaintedAt::Volume).improved(InpaintedAt::Plane),
        /// how far a ray must lie behind a plane to lie in its occlusion volume; nearer it hits the plane if it comes from as near before
        /// the one beside it
        occlusion_bias: f64 = Parameter::real(Trace, 0.0..=64.0, 1.0)
            .unit("pixel heights at that depth")
            .improved(0.25)
            .sweep([0.0, 0.25, 0.5, 1.0, 2.0, 4.0]),
        /// how far from its start a ray that starts in a view begins to look: small finds the surface that a ray starts on, large misses
        /// what lies close to it
        start_bias: f64 = Parameter::real(Trace, 0.0..=64.0, 1.0)
            .unit("pixel heights at that depth")
            .improved(0.1)
            .sweep([0.0, 0.5, 1.0, 2.0, 4.0]),
        /// rays beside every ray that are not traced but tested against the plane that it hit, weighed by the depth buffer (section 5.2);
        /// the sum of their weights is written
        secondary_samples: u32 = Parameter::integer(Trace, 0..=64, 0).unit("samples a ray").sweep([0, 3, 4, 7, 8]),
        /// the radius of the disk round a ray in which its secondary samples lie
        secondary_jitter: f64 = Parameter::real(Trace, 0.0..=64.0, 1.0).unit("pixels").sweep([0.5, 1.0, 2.0, 4.0]),
        /// sigma of the weight of a secondary sample, by the difference between its depth and the depth buffer's in the unit cube
        secondary_sigma: f64 = Parameter::real(Trace, 1e-9..=1.0, 1e-4).unit("unit cubes").sweep([1e-5, 1e-4, 1e-3]),
        /// nodes after which a ray is given up with status step_cap, as one is that the driver's own limit of loops cuts off
        max_steps: u32 = Parameter::integer(Trace, 1..=1 << 20, 1 << 14)
            .unit("nodes")
            .sweep([64, 256, 1024, 4096, 16_384]),
        build: RasterBackend = build_parameter(),
        memory_access: MemoryAccess = memory_access_parameter(),
        rays_per_lane: u32 = rays_per_lane_parameter(),
    }
}

/// Why there is no refit.
pub(crate) const NO_REFIT: &str = "quadtree has no shape to keep: its layers are drawn again or reused";

/// What `quadtree` is and takes.
pub fn description() -> TracerDescription {
    TracerDescription {
        name: "quadtree",
        citation: "Widmer, Pajak, Schulz, Pulli, Kautz, Goesele, Luebke: An Adaptive Acceleration Structure for Screen-space Ray \
                   Tracing, HPG 2015",
        summary: "quad-trees of planes and boxes over the depth layers of one view or six, searched without a stack",
        residency: Residency::Device,
        invalidated_by: &[Invalidation::Geometry, Invalidation::Viewpoint, Invalidation::Resolution],
        names_primitives: false,
        ends: &TraceTo::ALL,
        queries: &Query::ALL,
        no_refit: Some(NO_REFIT),
        parameters: QuadtreeParameters::describe(),
    }
}
