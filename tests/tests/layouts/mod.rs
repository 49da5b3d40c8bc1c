//! Layouts of the Rust structs that shaders share.

use std::collections::BTreeMap;
use std::mem::{offset_of, size_of};

use obvhs::cwbvh::node::CwBvhNode;
use tracebench_api::{Hit, Ray, Surface};
use tracebench_bvh::{
    BinaryNode, BuildSettings, ClusterIteration, ConversionLevel, DeviceTriangle, QuerySettings, RefitStage,
    SearchSettings,
};
use tracebench_dirt::{
    FetchPass, FillPass, HitNode, MaskSettings, MipmapLevel, StoreSettings, TileGrid, TraceSettings,
};
use tracebench_fragment_abuffer::{DrawnView, MarchSettings, Storage, TracedView};
use tracebench_kit::{GatherSettings, SortPass, ViewUniform};

/// Names with offsets in bytes, in order, and the whole size.
pub type Layout = (Vec<(String, u32)>, u32);

fn layout(members: &[(&str, usize)], size: usize) -> Layout {
    (members.iter().map(|(name, offset)| ((*name).to_owned(), *offset as u32)).collect(), size as u32)
}

/// Layouts of the Rust structs that shaders share. `Settings` of screen-dda is private to its crate: its six scalars
/// stand in the order that the shader documents.
pub fn shared() -> BTreeMap<&'static str, Layout> {
    let ray = [
        ("origin", offset_of!(Ray, origin)),
        ("t_min", offset_of!(Ray, t_min)),
        ("direction", offset_of!(Ray, direction)),
        ("t_max", offset_of!(Ray, t_max)),
    ];
    let hit = [
        ("t", offset_of!(Hit, t)),
        ("primitive", offset_of!(Hit, primitive)),
        ("u", offset_of!(Hit, u)),
        ("v", offset_of!(Hit, v)),
        ("status", offset_of!(Hit, status)),
    ];
    let surface = [
        ("position", offset_of!(Surface, position)),
        ("material", offset_of!(Surface, material)),
        ("normal", offset_of!(Surface, normal)),
        ("status", offset_of!(Surface, status)),
    ];
    let gather = [
        ("ray_count", offset_of!(GatherSettings, ray_count)),
        ("padding_a", offset_of!(GatherSettings, padding_a)),
        ("padding_b", offset_of!(GatherSettings, padding_b)),
        ("padding_c", offset_of!(GatherSettings, padding_c)),
    ];
    let view = [
        ("eye", offset_of!(ViewUniform, eye)),
        ("tan_half_width", offset_of!(ViewUniform, tan_half_width)),
        ("right", offset_of!(ViewUniform, right)),
        ("tan_half_height", offset_of!(ViewUniform, tan_half_height)),
        ("up", offset_of!(ViewUniform, up)),
        ("near", offset_of!(ViewUniform, near)),
        ("forward", offset_of!(ViewUniform, forward)),
        ("far", offset_of!(ViewUniform, far)),
        ("size", offset_of!(ViewUniform, size)),
        ("padding", offset_of!(ViewUniform, padding)),
    ];
    let settings =
        [("ray_count", 0), ("max_steps", 4), ("hit_point", 8), ("stride", 12), ("thickness", 16), ("start_bias", 20)];
    let search_settings = [
        ("first_ray", offset_of!(SearchSettings, first_ray)),
        ("ray_count", offset_of!(SearchSettings, ray_count)),
        ("rays_per_lane", offset_of!(SearchSettings, rays_per_lane)),
        ("any_hit", offset_of!(SearchSettings, any_hit)),
        ("stack_entries", offset_of!(SearchSettings, stack_entries)),
        ("scale", offset_of!(SearchSettings, scale)),
        ("unscale", offset_of!(SearchSettings, unscale)),
        ("greatest_t", offset_of!(SearchSettings, greatest_t)),
    ];
    let query_settings = [
        ("ray_count", offset_of!(QuerySettings, ray_count)),
        ("any_hit", offset_of!(QuerySettings, any_hit)),
        ("lowest_of_equal", offset_of!(QuerySettings, lowest_of_equal)),
        ("scale", offset_of!(QuerySettings, scale)),
        ("unscale", offset_of!(QuerySettings, unscale)),
        ("greatest_t", offset_of!(QuerySettings, greatest_t)),
    ];
    let build_settings = [
        ("low", offset_of!(BuildSettings, low)),
        ("triangle_count", offset_of!(BuildSettings, triangle_count)),
        ("cells_per_unit", offset_of!(BuildSettings, cells_per_unit)),
        ("scale", offset_of!(BuildSettings, scale)),
    ];
    let iteration = [
        ("index", offset_of!(ClusterIteration, index)),
        ("allowed", offset_of!(ClusterIteration, allowed)),
        ("search_radius", offset_of!(ClusterIteration, search_radius)),
    ];
    let level = [("index", offset_of!(ConversionLevel, index)), ("tallest", offset_of!(ConversionLevel, tallest))];
    let stage = [("index", offset_of!(RefitStage, index)), ("triangle_count", offset_of!(RefitStage, triangle_count))];
    let sort_pass = [
        ("count", offset_of!(SortPass, count)),
        ("blocks", offset_of!(SortPass, blocks)),
        ("shift", offset_of!(SortPass, shift)),
    ];
    let triangle = [
        ("first", offset_of!(DeviceTriangle, first)),
        ("primitive", offset_of!(DeviceTriangle, primitive)),
        ("second", offset_of!(DeviceTriangle, second)),
        ("after_second", offset_of!(DeviceTriangle, after_second)),
        ("third", offset_of!(DeviceTriangle, third)),
        ("after_third", offset_of!(DeviceTriangle, after_third)),
    ];
    let binary_node = [
        ("low", offset_of!(BinaryNode, low)),
        ("first", offset_of!(BinaryNode, first)),
        ("high", offset_of!(BinaryNode, high)),
        ("count", offset_of!(BinaryNode, count)),
    ];
    // obvhs keeps the exponents and the mask of nodes as four bytes, the planes of an axis as two arrays of eight.
    let wide_node = [
        ("origin", offset_of!(CwBvhNode, p)),
        ("exponents_and_nodes", offset_of!(CwBvhNode, e)),
        ("first_child", offset_of!(CwBvhNode, child_base_idx)),
        ("first_triangle", offset_of!(CwBvhNode, primitive_base_idx)),
        ("children", offset_of!(CwBvhNode, child_meta)),
        ("x", offset_of!(CwBvhNode, child_min_x)),
        ("y", offset_of!(CwBvhNode, child_min_y)),
        ("z", offset_of!(CwBvhNode, child_min_z)),
    ];
    assert_eq!(offset_of!(CwBvhNode, imask), offset_of!(CwBvhNode, e) + 3);
    assert_eq!(offset_of!(CwBvhNode, child_max_x), offset_of!(CwBvhNode, child_min_x) + 8);
    assert_eq!(offset_of!(CwBvhNode, child_max_y), offset_of!(CwBvhNode, child_min_y) + 8);
    assert_eq!(offset_of!(CwBvhNode, child_max_z), offset_of!(CwBvhNode, child_min_z) + 8);
    let grid = [
        ("tiles", offset_of!(TileGrid, tiles)),
        ("levels", offset_of!(TileGrid, levels)),
        ("buckets", offset_of!(TileGrid, buckets)),
        ("bounds_stride", offset_of!(TileGrid, bounds_stride)),
        ("heads_stride", offset_of!(TileGrid, heads_stride)),
        ("node_capacity", offset_of!(TileGrid, node_capacity)),
        ("nodes_per_part", offset_of!(TileGrid, nodes_per_part)),
        ("level_offsets", offset_of!(TileGrid, level_offsets)),
    ];
    let fill_pass = [
        ("view", offset_of!(FillPass, view)),
        ("by_plane", offset_of!(FillPass, by_plane)),
        ("padding_a", offset_of!(FillPass, padding_a)),
        ("padding_b", offset_of!(FillPass, padding_b)),
        ("padding_c", offset_of!(FillPass, padding_c)),
    ];
    let mipmap_level = [
        ("level", offset_of!(MipmapLevel, level)),
        ("views", offset_of!(MipmapLevel, views)),
        ("padding", offset_of!(MipmapLevel, padding)),
    ];
    let trace_settings = [
        ("ray_count", offset_of!(TraceSettings, ray_count)),
        ("view_count", offset_of!(TraceSettings, view_count)),
        ("any_hit", offset_of!(TraceSettings, any_hit)),
        ("by_distance", offset_of!(TraceSettings, by_distance)),
        ("all_buckets", offset_of!(TraceSettings, all_buckets)),
        ("max_steps", offset_of!(TraceSettings, max_steps)),
        ("padding", offset_of!(TraceSettings, padding)),
    ];
    let hit_node = [
        ("next", offset_of!(HitNode, next)),
        ("primitive", offset_of!(HitNode, primitive)),
        ("u", offset_of!(HitNode, u)),
        ("v", offset_of!(HitNode, v)),
        ("position", offset_of!(HitNode, position)),
        ("shading_and_view", offset_of!(HitNode, shading_and_view)),
    ];
    let store_settings = [
        ("ray_count", offset_of!(StoreSettings, ray_count)),
        ("view_count", offset_of!(StoreSettings, view_count)),
        ("pixels", offset_of!(StoreSettings, pixels)),
    ];
    let mask_settings = [("pixels", offset_of!(MaskSettings, pixels)), ("padding", offset_of!(MaskSettings, padding))];
    let fetch_pass = [
        ("view", offset_of!(FetchPass, view)),
        ("view_index", offset_of!(FetchPass, view_index)),
        ("padding", offset_of!(FetchPass, padding)),
        ("pixels", offset_of!(FetchPass, pixels)),
    ];
    let storage = [
        ("pixel_stride", offset_of!(Storage, pixel_stride)),
        ("word_stride", offset_of!(Storage, word_stride)),
        ("buckets", offset_of!(Storage, buckets)),
        ("double", offset_of!(Storage, double)),
        ("bounds_word", offset_of!(Storage, bounds_word)),
        ("node_words", offset_of!(Storage, node_words)),
        ("data_words", offset_of!(Storage, data_words)),
        ("data_offset", offset_of!(Storage, data_offset)),
        ("node_capacity", offset_of!(Storage, node_capacity)),
        ("one_layer", offset_of!(Storage, one_layer)),
        ("pixel_count", offset_of!(Storage, pixel_count)),
        ("contiguous", offset_of!(Storage, contiguous)),
    ];
    let drawn_view = [
        ("view", offset_of!(DrawnView, view)),
        ("first_pixel", offset_of!(DrawnView, first_pixel)),
        ("width", offset_of!(DrawnView, width)),
        ("padding", offset_of!(DrawnView, padding)),
    ];
    let traced_view = [
        ("view", offset_of!(TracedView, view)),
        ("first_pixel", offset_of!(TracedView, first_pixel)),
        ("first_node", offset_of!(TracedView, first_node)),
        ("levels", offset_of!(TracedView, levels)),
        ("is_face", offset_of!(TracedView, is_face)),
        ("beyond", offset_of!(TracedView, beyond)),
        ("word_stride", offset_of!(TracedView, word_stride)),
        ("node_capacity", offset_of!(TracedView, node_capacity)),
        ("padding", offset_of!(TracedView, padding)),
        ("level_offsets", offset_of!(TracedView, level_offsets)),
    ];
    let march_settings = [
        ("ray_count", offset_of!(MarchSettings, ray_count)),
        ("view_count", offset_of!(MarchSettings, view_count)),
        ("march", offset_of!(MarchSettings, march)),
        ("steps", offset_of!(MarchSettings, steps)),
        ("max_steps", offset_of!(MarchSettings, max_steps)),
        ("centred", offset_of!(MarchSettings, centred)),
        ("span_by_pixel", offset_of!(MarchSettings, span_by_pixel)),
        ("skipping", offset_of!(MarchSettings, skipping)),
        ("binary_search_above", offset_of!(MarchSettings, binary_search_above)),
        ("thickness", offset_of!(MarchSettings, thickness)),
        ("thickness_in_pixels", offset_of!(MarchSettings, thickness_in_pixels)),
        ("start_bias", offset_of!(MarchSettings, start_bias)),
        ("thick_before", offset_of!(MarchSettings, thick_before)),
        ("padding_a", offset_of!(MarchSettings, padding_a)),
        ("padding_b", offset_of!(MarchSettings, padding_b)),
        ("padding_c", offset_of!(MarchSettings, padding_c)),
    ];
    BTreeMap::from([
        ("Storage", layout(&storage, size_of::<Storage>())),
        ("DrawnView", layout(&drawn_view, size_of::<DrawnView>())),
        ("TracedView", layout(&traced_view, size_of::<TracedView>())),
        ("MarchSettings", layout(&march_settings, size_of::<MarchSettings>())),
        ("HitNode", layout(&hit_node, size_of::<HitNode>())),
        ("StoreSettings", layout(&store_settings, size_of::<StoreSettings>())),
        ("MaskSettings", layout(&mask_settings, size_of::<MaskSettings>())),
        ("FetchPass", layout(&fetch_pass, size_of::<FetchPass>())),
        ("TileGrid", layout(&grid, size_of::<TileGrid>())),
        ("FillPass", layout(&fill_pass, size_of::<FillPass>())),
        ("MipmapLevel", layout(&mipmap_level, size_of::<MipmapLevel>())),
        ("TraceSettings", layout(&trace_settings, size_of::<TraceSettings>())),
        ("QuerySettings", layout(&query_settings, size_of::<QuerySettings>())),
        ("SearchSettings", layout(&search_settings, size_of::<SearchSettings>())),
        ("BuildSettings", layout(&build_settings, size_of::<BuildSettings>())),
        ("Iteration", layout(&iteration, size_of::<ClusterIteration>())),
        ("Level", layout(&level, size_of::<ConversionLevel>())),
        ("Stage", layout(&stage, size_of::<RefitStage>())),
        ("SortPass", layout(&sort_pass, size_of::<SortPass>())),
        ("Triangle", layout(&triangle, size_of::<DeviceTriangle>())),
        ("BinaryNode", layout(&binary_node, size_of::<BinaryNode>())),
        ("WideNode", layout(&wide_node, size_of::<CwBvhNode>())),
        ("Ray", layout(&ray, size_of::<Ray>())),
        ("Hit", layout(&hit, size_of::<Hit>())),
        ("Surface", layout(&surface, size_of::<Surface>())),
        ("GatherSettings", layout(&gather, size_of::<GatherSettings>())),
        ("View", layout(&view, size_of::<ViewUniform>())),
        ("Settings", layout(&settings, 24)),
    ])
}
