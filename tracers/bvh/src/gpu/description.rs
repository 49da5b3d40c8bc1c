//! The parameters of `bvh-gpu`.

use tracebench_api::{Parameter, ParameterScope, TracerDescription, choice, parameters};
use tracebench_kit::{MemoryAccess, memory_access_parameter, rays_per_lane_parameter};

use crate::input::{BuildPreset, build_parameter};
choice! {
    /// The two kinds of node.
    pub(crate) enum NodeKind { Wide = "cwbvh", Binary = "bvh2" }
}

parameters! {
    /// What `bvh-gpu` is told.
    pub(crate) struct GpuParameters {
        build: BuildPreset = build_parameter(),
        node: NodeKind = node_parameter(),
        memory_access: MemoryAccess = memory_access_parameter(),
        rays_per_lane: u32 = rays_per_lane_parameter(),
    }
}

/// What `bvh-gpu` is and takes.
pub fn description() -> TracerDescription {
    TracerDescription {
        name: "bvh-gpu",
        citation: "Ylitie, Karras, Laine: Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs, \
                   HPG 2017; built by the obvhs crate",
        summary: "BVH (compressed eight-wide, or binary) built on all cores of the host, uploaded, traversed in compute",
        ..TracerDescription::on_device(GpuParameters::describe())
    }
}

/// The parameter `node`.
pub(crate) fn node_parameter() -> Parameter<NodeKind> {
    let effect = "kind of node: compressed with eight children, or binary";
    Parameter::choice(ParameterScope::Build, NodeKind::Wide).effect(effect)
}
