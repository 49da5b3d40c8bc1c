//! The parameters of `bvh-gpu`.

use tracebench_api::{
    Description, EndPoint, Invalidation, Parameter, ParameterScope, Query, Residency, choice, parameters,
};

use crate::input::{BuildPreset, build_parameter};
use crate::layouts::layouts;

choice! {
    /// The two kinds of node.
    pub(crate) enum NodeKind { Wide = "cwbvh", Binary = "bvh2" }
}

parameters! {
    /// What `bvh-gpu` is told.
    pub(crate) struct GpuParameters {
        build: BuildPreset = build_parameter(),
        node: NodeKind = node_parameter(),
        rays_per_lane: u32 = rays_per_lane_parameter(),
    }
}

/// What `bvh-gpu` is and takes.
pub fn description() -> Description {
    Description {
        name: "bvh-gpu",
        citation: "Ylitie, Karras, Laine: Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs, \
                   HPG 2017; built by the obvhs crate",
        summary: "BVH (compressed eight-wide, or binary) built on all cores of the host, uploaded, traversed in compute",
        residency: Residency::Device,
        invalidated_by: &[Invalidation::Geometry],
        names_primitives: true,
        ends: &EndPoint::ALL,
        queries: &Query::ALL,
        no_refit: None,
        parameters: GpuParameters::describe(),
        layouts: layouts(),
    }
}

/// The parameter `node`.
pub(crate) fn node_parameter() -> Parameter<NodeKind> {
    let effect = "kind of node: compressed with eight children, or binary";
    Parameter::choice(ParameterScope::Build, NodeKind::Wide, effect)
}

/// The parameter `rays_per_lane`.
pub(crate) fn rays_per_lane_parameter() -> Parameter<u32> {
    Parameter::integer(
        ParameterScope::Trace,
        1..=256,
        32,
        "rays that a lane answers one after the other (persistent lanes), so that lanes with short searches \
         need not wait for others: many suit incoherent rays and few cores, few suit coherent rays and \
         many cores; hierarchies too deep for private stacks take one",
    )
    .unit("rays")
    .sweep([1, 2, 4, 8, 16, 32, 64])
}
