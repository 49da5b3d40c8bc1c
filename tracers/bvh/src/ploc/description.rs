//! The parameters of `ploc-gpu`.

use tracebench_api::ParameterScope::Build;
use tracebench_api::{Parameter, TracerDescription, choice, parameters};
use tracebench_kit::{MemoryAccess, memory_access_parameter, rays_per_lane_parameter};

use crate::gpu::description::{NodeKind, node_parameter};

/// Most neighbours on each side. One workgroup merges the last clusters, 8 a lane, and Mesa's software driver ends a lane's
/// loops after 65,535 rounds in all: with these it gets through 256 iterations, twice as many as the deepest scene takes.
const MAX_NEIGHBOURS: u32 = 16;

choice! {
    /// How triangles along the Morton curve become a binary tree, the quickest first.
    pub(crate) enum TreeKind { Radix = "lbvh", Clustered = "ploc" }
}

parameters! {
    /// What `ploc-gpu` is told.
    pub(crate) struct PlocParameters {
        node: NodeKind = node_parameter(),
        /// ploc clusters nearest neighbours along the Morton curve; lbvh splits the curve where codes differ: builds faster, traces slower
        tree: TreeKind = Parameter::choice(Build, TreeKind::Clustered),
        /// neighbours along the Morton curve on each side among which a cluster seeks its nearest: more build slower and trace faster
        search_radius: u32 = Parameter::integer(Build, 1..=MAX_NEIGHBOURS, 8).unit("clusters").sweep([1, 2, 4, 8, 16]),
        /// the same in the first two iterations, which have the most clusters, of scenes of more than 2,048 triangles: few build faster,
        /// and often trace faster, too
        early_search_radius: u32 = Parameter::integer(Build, 1..=MAX_NEIGHBOURS, 8)
            .unit("clusters")
            .improved(2)
            .sweep([1, 2, 4, 8]),
        memory_access: MemoryAccess = memory_access_parameter(),
        rays_per_lane: u32 = rays_per_lane_parameter(),
    }
}

/// What `ploc-gpu` is and takes.
pub fn description() -> TracerDescription {
    TracerDescription {
        name: "ploc-gpu",
        citation: "Benthin, Drabinski, Tessari, Dittebrandt: PLOC++: Parallel Locally-Ordered Clustering for Bounding \
                   Volume Hierarchy Construction Revisited, HPG 2022",
        summary: "BVH (compressed eight-wide, or binary) over a Morton curve, clustered or split, built and traversed in compute",
        ..TracerDescription::on_device(PlocParameters::describe())
    }
}
