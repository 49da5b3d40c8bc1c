//! Layouts of what shaders share with the tracers of this crate.

use std::mem::offset_of;

use obvhs::cwbvh::node::CwBvhNode;
use tracebench_api::SharedLayout;

use crate::binary::BinaryNode;
use crate::gpu::{DeviceTriangle, SearchSettings};
use crate::lbvh::{BuildSettings, ClusterIteration, ConversionLevel, RefitStage};
use crate::ray_query::QuerySettings;

// obvhs keeps the exponents and the mask of nodes as four bytes, the planes of an axis as two arrays of eight.
const _: () = {
    assert!(offset_of!(CwBvhNode, imask) == offset_of!(CwBvhNode, e) + 3);
    assert!(offset_of!(CwBvhNode, child_max_x) == offset_of!(CwBvhNode, child_min_x) + 8);
    assert!(offset_of!(CwBvhNode, child_max_y) == offset_of!(CwBvhNode, child_min_y) + 8);
    assert!(offset_of!(CwBvhNode, child_max_z) == offset_of!(CwBvhNode, child_min_z) + 8);
};

/// All of them.
pub(crate) fn layouts() -> Vec<SharedLayout> {
    let mut layouts = tracebench_api::layouts! {
        SearchSettings { first_ray, ray_count, rays_per_lane, any_hit, stack_entries, scale, unscale, greatest_t }
        QuerySettings { ray_count, any_hit, lowest_of_equal, scale, unscale, greatest_t }
        BuildSettings { low, triangle_count, cells_per_unit, scale }
        ClusterIteration as Iteration { index, allowed, search_radius }
        ConversionLevel as Level { index, tallest }
        RefitStage as Stage { index, triangle_count }
        DeviceTriangle as Triangle { first, primitive, second, after_second, third, after_third }
        BinaryNode { low, first, high, count }
    };
    layouts.push(SharedLayout {
        name: "WideNode",
        members: vec![
            ("origin", offset_of!(CwBvhNode, p)),
            ("exponents_and_nodes", offset_of!(CwBvhNode, e)),
            ("first_child", offset_of!(CwBvhNode, child_base_idx)),
            ("first_triangle", offset_of!(CwBvhNode, primitive_base_idx)),
            ("children", offset_of!(CwBvhNode, child_meta)),
            ("x", offset_of!(CwBvhNode, child_min_x)),
            ("y", offset_of!(CwBvhNode, child_min_y)),
            ("z", offset_of!(CwBvhNode, child_min_z)),
        ],
        size: size_of::<CwBvhNode>(),
    });
    layouts
}
