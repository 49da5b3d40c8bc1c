#define_import_path tracebench::voxel_space

// What is drawn of the unit cube, and how its layers are told apart.

#import tracebench::unit_space::UnitSpace

// What a pass over the geometry draws: the image along an axis.
struct RasterizedAxis {
    space: UnitSpace,
    axis: u32,
    // Nodes that there is room for, and how many of them have their data in its first half.
    capacity: u32,
    half_nodes: u32,
    // Which fragments feed the average normals: 0: all, 1: those of a triangle's dominant axis.
    fed_by: u32,
    // 1: normals are averaged as lines.
    as_lines: u32,
    // 1: layers of equal depth and facing are of several objects, and stay.
    nesting: u32,
    padding_b: u32,
    padding_c: u32,
}

// Layers of equal depth and facing are one, so the last bit of a depth's tells the facing: 1 where the normal points along the axis,
// as of a layer by which a ray along the axis leaves something. Depths lie in (0, 1): their bits are in their order, and that
// one is far below a texel.
fn layer_code(depth: f32, faces_along: bool) -> u32 {
    return (bitcast<u32>(depth) & 0xfffffffeu) | select(0u, 1u, faces_along);
}

// The code that layers before a depth do not exceed.
fn depth_code(depth: f32) -> u32 {
    return bitcast<u32>(clamp(depth, 1e-30, 1.0)) | 1u;
}

// An order of layers' data that hangs on nothing else.
fn is_less(one: vec4<u32>, other: vec4<u32>) -> bool {
    if (one.x != other.x) {
        return one.x < other.x;
    }
    if (one.y != other.y) {
        return one.y < other.y;
    }
    if (one.z != other.z) {
        return one.z < other.z;
    }
    return one.w < other.w;
}
