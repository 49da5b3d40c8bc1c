//! The parameters of `bvh-gpu`.

use tracebench_api::{Description, Domain, Invalidation, ParameterDescription, ParameterScope, Residency, Value};

use crate::input::build_description;

/// Values of `node`.
const NODES: &[&str] = &["cwbvh", "bvh2"];

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
        parameters: vec![build_description(), node_description(), rays_per_lane_description()],
    }
}

/// The parameter `node`.
pub(crate) fn node_description() -> ParameterDescription {
    let choice = |name: &str| Value::Choice(name.to_owned());
    ParameterDescription {
        name: "node",
        unit: "",
        scope: ParameterScope::Build,
        domain: Domain::Choice(NODES),
        published: choice("cwbvh"),
        improved: choice("cwbvh"),
        effect: "kind of node: compressed with eight children, or binary",
        sweep: NODES.iter().map(|name| choice(name)).collect(),
    }
}

/// The parameter `rays_per_lane`.
pub(crate) fn rays_per_lane_description() -> ParameterDescription {
    ParameterDescription {
        name: "rays_per_lane",
        unit: "rays",
        scope: ParameterScope::Trace,
        domain: Domain::Integer { least: 1, greatest: 256 },
        published: Value::Integer(32),
        improved: Value::Integer(32),
        effect: "rays that a lane answers one after the other (persistent lanes), so that lanes with short searches \
                 need not wait for others: many suit incoherent rays and few cores, few suit coherent rays and \
                 many cores; hierarchies too deep for private stacks take one",
        sweep: [1, 2, 4, 8, 16, 32, 64].map(Value::Integer).to_vec(),
    }
}
