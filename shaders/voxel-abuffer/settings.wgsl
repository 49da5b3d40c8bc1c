#define_import_path tracebench::voxel_settings

// What searches are told.

#import tracebench::unit_space::UnitSpace

struct VoxelSearch {
    space: UnitSpace,
    ray_count: u32,
    rays_per_lane: u32,
    // How a voxel's A-buffer is searched: 0: in every texel that the ray crosses, else at so many points.
    points: u32,
    // Halvings between the last two points.
    binary_steps: u32,
    // Inside is told, 0: by the parity of layers, 1: by their facings.
    nesting: u32,
    // A ray ends where its side is not, 0: that of its start, 1: that at the entry.
    by_change: u32,
    // Texels.
    start_bias: f32,
    // From the heads of an axis to those of the next.
    head_stride: u32,
    // Words of bits a node; nodes that have their data in their axis' first half.
    touched_words: u32,
    half_nodes: u32,
    // What is asked of a texel that the ray crosses, 0: the layers that it passes there, 1: the side on which it leaves.
    at_exits: u32,
    // 1: any hit will do, not the nearest.
    any_hit: u32,
    // Of each axis: its first node, and that node's bit among those that are counted.
    first_nodes: vec4<u32>,
    first_bits: vec4<u32>,
    // Its first data, and the first of the second half.
    first_data: vec4<u32>,
    first_further_data: vec4<u32>,
}
