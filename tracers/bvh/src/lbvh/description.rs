//! The parameters of `lbvh-gpu`.

use tracebench_api::{Description, Domain, Invalidation, ParameterDescription, ParameterScope, Residency, Value};

use crate::gpu::description::{node_description, rays_per_lane_description};

/// Most neighbours on each side. One workgroup merges the last clusters, 8 a lane, and Mesa's software driver ends a lane's
/// loops after 65,535 rounds in all: with these it gets through 256 iterations, twice as many as the deepest scene takes.
const MOST_NEIGHBOURS: i64 = 16;

/// What `lbvh-gpu` is and takes.
pub fn description() -> Description {
    Description {
        name: "lbvh-gpu",
        citation: "Benthin, Drabinski, Tessari, Dittebrandt: PLOC++: Parallel Locally-Ordered Clustering for Bounding \
                   Volume Hierarchy Construction Revisited, HPG 2022",
        summary: "BVH (compressed eight-wide, or binary) clustered along a Morton curve, built and traversed in compute",
        residency: Residency::Device,
        invalidated_by: &[Invalidation::Geometry],
        names_primitives: true,
        parameters: vec![
            node_description(),
            ParameterDescription {
                name: "search_radius",
                unit: "clusters",
                scope: ParameterScope::Build,
                domain: Domain::Integer { least: 1, greatest: MOST_NEIGHBOURS },
                published: Value::Integer(8),
                improved: Value::Integer(8),
                effect: "neighbours along the Morton curve on each side among which a cluster seeks its nearest: more build \
                         slower and trace faster",
                sweep: [1, 2, 4, 8, 16].map(Value::Integer).to_vec(),
            },
            ParameterDescription {
                name: "early_search_radius",
                unit: "clusters",
                scope: ParameterScope::Build,
                domain: Domain::Integer { least: 1, greatest: MOST_NEIGHBOURS },
                published: Value::Integer(8),
                improved: Value::Integer(2),
                effect: "the same in the first two iterations, which have the most clusters, of scenes of more than 2,048 \
                         triangles: few build faster, and often trace faster, too",
                sweep: [1, 2, 4, 8].map(Value::Integer).to_vec(),
            },
            rays_per_lane_description(),
        ],
    }
}
