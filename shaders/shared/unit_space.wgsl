#define_import_path tracebench::unit_space

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
