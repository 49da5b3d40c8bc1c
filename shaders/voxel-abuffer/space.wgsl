#define_import_path tracebench::voxel_space

// The unit cube that the scene is mapped into, its voxels, and the images along its axes.

struct UnitSpace {
    // A point of the scene is at (point - low) * scale + begin.
    low: vec3<f32>,
    // Edge of an image, texels.
    image: u32,
    scale: vec3<f32>,
    // Edge of the grid, voxels.
    grid: u32,
    begin: vec3<f32>,
    padding: u32,
}

// What a pass over the geometry draws: the image along an axis.
struct DrawnAxis {
    space: UnitSpace,
    axis: u32,
    // Nodes that there is room for, and how many of them have their data in its first half.
    capacity: u32,
    half_nodes: u32,
    // Which fragments feed the average normals: 0: all, 1: those of a triangle's dominant axis.
    fed_by: u32,
    // 1: normals are averaged as lines.
    as_lines: u32,
    padding_a: u32,
    padding_b: u32,
    padding_c: u32,
}

fn to_unit(space: UnitSpace, point: vec3<f32>) -> vec3<f32> {
    return (point - space.low) * space.scale + space.begin;
}

// A point or direction as the image along an axis has it: across, down, and depth along the axis.
fn on_image(axis: u32, vector: vec3<f32>) -> vec3<f32> {
    if (axis == 0u) {
        return vector.yzx;
    }
    if (axis == 1u) {
        return vector.zxy;
    }
    return vector;
}

// Back from there.
fn from_image(axis: u32, vector: vec3<f32>) -> vec3<f32> {
    if (axis == 0u) {
        return vector.zxy;
    }
    if (axis == 1u) {
        return vector.yzx;
    }
    return vector;
}

// The axis along which a vector is longest; of equal ones the first.
fn dominant_axis(vector: vec3<f32>) -> u32 {
    let size = abs(vector);
    if (size.x >= max(size.y, size.z)) {
        return 0u;
    }
    return select(2u, 1u, (size.y >= size.z));
}

// The voxel of a point of the cube, held within the grid.
fn voxel_at(space: UnitSpace, point: vec3<f32>) -> vec3<i32> {
    let last = vec3<i32>(i32(space.grid) - 1);
    return clamp(vec3<i32>(floor(point * f32(space.grid))), vec3<i32>(0), last);
}

fn voxel_index(space: UnitSpace, voxel: vec3<i32>) -> u32 {
    let place = vec3<u32>(voxel);
    return (place.z * space.grid + place.y) * space.grid + place.x;
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
