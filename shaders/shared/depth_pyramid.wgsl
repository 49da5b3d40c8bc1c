// Makes one level of the pyramid over an image of eye depth: of every cell the nearest depth of the pixels below it and, with FAR, the
// farthest one too (Tevs, Ihrke, Seidel, "Maximum Mipmaps for Fast, Accurate, and Scalable Dynamic Height Field Rendering", I3D 2008;
// Uludag, "Hi-Z Screen-Space Cone-Traced Reflections", GPU Pro 5, 2014).

#import tracebench::dispatch::{Invocation, linear_invocation}
#import tracebench::pyramid::{level_size, index_in_level, cell_below}
#import tracebench::depth_cells::NO_SURFACE

struct PyramidLevel {
    // Pixels.
    size: vec2<u32>,
    // The level to make; 0 are the pixels themselves, as cells.
    level: u32,
    image: u32,
    // The first cell of the level, and of the one below it.
    begin: u32,
    begin_below: u32,
    // 1: pixels without a surface have no farthest depth.
    covered_only: u32,
    padding: u32,
}

@group(0) @binding(0) var<uniform> made: PyramidLevel;
@group(0) @binding(1) var eye_depths: texture_2d_array<f32>;
#ifdef FAR
// Near and far.
@group(0) @binding(2) var<storage, read_write> cells: array<vec2<f32>>;
#else
@group(0) @binding(2) var<storage, read_write> cells: array<f32>;
#endif

const WORKGROUP_SIZE: u32 = 64u;

// Near and far of a cell of the level below.
fn bounds_below(below: vec2<u32>) -> vec2<f32> {
    if (made.level <= 1u) {
        let depth = textureLoad(eye_depths, vec2<i32>(below), i32(made.image), 0).x;
        return vec2<f32>(depth, select(depth, 0.0, (made.covered_only == 1u && depth >= NO_SURFACE)));
    }
    let index = made.begin_below + index_in_level(made.size, made.level - 1u, below);
#ifdef FAR
    return cells[index];
#else
    return vec2<f32>(cells[index], 0.0);
#endif
}

@compute @workgroup_size(WORKGROUP_SIZE)
fn reduce(invocation: Invocation) {
    let size = level_size(made.size, made.level);
    let index = linear_invocation(invocation, WORKGROUP_SIZE);
    if (index >= size.x * size.y) {
        return;
    }
    let cell = vec2<u32>(index % size.x, index / size.x);
    var bounds = vec2<f32>(NO_SURFACE, 0.0);
    for (var child = 0u; child < select(4u, 1u, made.level == 0u); child++) {
        let below = bounds_below(select(cell_below(made.size, max(made.level, 1u), cell, child), cell, made.level == 0u));
        bounds = vec2<f32>(min(bounds.x, below.x), max(bounds.y, below.y));
    }
#ifdef FAR
    cells[made.begin + index] = bounds;
#else
    cells[made.begin + index] = bounds.x;
#endif
}
