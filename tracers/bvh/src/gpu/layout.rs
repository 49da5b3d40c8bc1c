//! Hierarchies as they are built, fitted and checked on the host, and as the device has them.

use glam::Vec3A;
use obvhs::aabb::Aabb;
use obvhs::cwbvh::CwBvh;
use obvhs::cwbvh::node::CwBvhNode;
use obvhs::triangle::Triangle;
use rayon::prelude::*;
use tracebench_api::{Ledger, PhaseClock, TracerError};

use crate::binary::{Binary, BinaryNode};
use crate::wide::{check_boxes, check_references, depth};
use crate::{hierarchy, refit, sah};

use super::description::{GpuParameters, NodeKind};
pub(crate) use tracebench_shaders::bvh::Triangle as DeviceTriangle;

fn device_triangle(triangle: &Triangle, primitive: u32) -> DeviceTriangle {
    let [first, second, third] = [triangle.v0, triangle.v1, triangle.v2].map(|corner| corner.to_array());
    DeviceTriangle { first, primitive, second, after_second: 0, third, after_third: 0 }
}

fn corners(triangle: &DeviceTriangle) -> Triangle {
    let [v0, v1, v2] = [triangle.first, triangle.second, triangle.third].map(Vec3A::from);
    Triangle { v0, v1, v2 }
}

impl NodeKind {
    /// Bytes of a node.
    pub(crate) fn node_bytes(self) -> u64 {
        match self {
            Self::Wide => size_of::<CwBvhNode>() as u64,
            Self::Binary => size_of::<BinaryNode>() as u64,
        }
    }

    /// What the nodes are called in ledgers and messages.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Wide => "CWBVH nodes",
            Self::Binary => "BVH2 nodes",
        }
    }
}

/// A hierarchy in host memory.
pub(crate) enum Tree {
    Wide(CwBvh),
    Binary(Binary),
}

impl Tree {
    /// Builds one over triangles in the scene's order.
    pub(crate) fn build(
        triangles: &[Triangle],
        parameters: &GpuParameters,
        ledger: &mut Ledger,
        clock: &mut PhaseClock<'_>,
    ) -> Self {
        let config = parameters.build.values();
        match parameters.node {
            NodeKind::Wide => Self::Wide(hierarchy::build_wide(triangles, config, ledger, clock)),
            NodeKind::Binary => {
                let binary = hierarchy::build_binary(triangles, config, ledger, clock);
                Self::Binary(clock.host_phase("order nodes", || Binary::new(&binary)))
            }
        }
    }

    /// One as read back from the device.
    pub(crate) fn from_device(kind: NodeKind, nodes: &[u8], triangles: &[DeviceTriangle], with_splits: bool) -> Self {
        let primitive_indices = triangles.iter().map(|triangle| triangle.primitive).collect();
        match kind {
            NodeKind::Wide => Self::Wide(CwBvh {
                nodes: bytemuck::pod_collect_to_vec::<u8, CwBvhNode>(nodes),
                primitive_indices,
                total_aabb: Aabb::empty(),
                exact_node_aabbs: None,
                uses_spatial_splits: with_splits,
            }),
            NodeKind::Binary => Self::Binary(Binary {
                nodes: bytemuck::pod_collect_to_vec::<u8, BinaryNode>(nodes),
                primitive_indices,
                with_splits,
            }),
        }
    }

    pub(crate) fn kind(&self) -> NodeKind {
        match self {
            Self::Wide(_) => NodeKind::Wide,
            Self::Binary(_) => NodeKind::Binary,
        }
    }

    /// The nodes as the device has them.
    pub(crate) fn node_bytes(&self) -> &[u8] {
        match self {
            Self::Wide(wide) => bytemuck::cast_slice(&wide.nodes),
            Self::Binary(binary) => bytemuck::cast_slice(&binary.nodes),
        }
    }

    pub(crate) fn node_count(&self) -> usize {
        match self {
            Self::Wide(wide) => wide.nodes.len(),
            Self::Binary(binary) => binary.nodes.len(),
        }
    }

    /// The triangle in each slot of the leaves.
    pub(crate) fn primitive_indices(&self) -> &[u32] {
        match self {
            Self::Wide(wide) => &wide.primitive_indices,
            Self::Binary(binary) => &binary.primitive_indices,
        }
    }

    pub(crate) fn with_splits(&self) -> bool {
        match self {
            Self::Wide(wide) => wide.uses_spatial_splits,
            Self::Binary(binary) => binary.with_splits,
        }
    }

    /// Levels, each of which pushes at most one entry onto a search's stack.
    pub(crate) fn depth(&self) -> Result<usize, TracerError> {
        match self {
            Self::Wide(wide) => depth(wide),
            Self::Binary(binary) => Ok(binary.depth()),
        }
    }

    /// What a search costs by the surface area heuristic.
    pub(crate) fn sah_cost(&self) -> f64 {
        match self {
            Self::Wide(wide) => sah::of_wide(wide),
            Self::Binary(binary) => sah::of_binary(&binary.nodes),
        }
    }

    /// Fits every box to triangles that moved, given in the scene's order.
    pub(crate) fn refit(&mut self, triangles: &[Triangle]) {
        match self {
            Self::Wide(wide) => refit::refit(wide, triangles),
            Self::Binary(binary) => binary.refit(triangles),
        }
    }

    /// The triangles in the order of the slots.
    pub(crate) fn order(&self, triangles: &[Triangle]) -> Vec<DeviceTriangle> {
        let of = |primitive: &u32| device_triangle(&triangles[*primitive as usize], *primitive);
        self.primitive_indices().par_iter().map(of).collect()
    }

    /// That every triangle is in exactly one leaf (in one at least, with splits) and every box bounds its subtree.
    /// `fitted`: every box holds whole triangles, splits or not.
    pub(crate) fn check(
        &self,
        ordered: &[DeviceTriangle],
        triangle_count: usize,
        fitted: bool,
    ) -> Result<(), TracerError> {
        check_references(self.primitive_indices(), triangle_count, self.with_splits())?;
        let corners: Vec<Triangle> = ordered.iter().map(corners).collect();
        let whole = fitted || !self.with_splits();
        match self {
            Self::Wide(wide) => depth(wide).and_then(|_| check_boxes(wide, &corners, whole)),
            Self::Binary(binary) => binary.check(&corners, whole),
        }
    }
}
