// Triangles to fragments: a voxel's key and the triangle that touches it, one after the other in the order of triangles, so that nothing
// hangs on the order of lanes. Crassin, Green, "Octree-Based Sparse Voxelization Using the GPU Hardware Rasterizer", OpenGL Insights 2012,
// draw every triangle along its dominant axis, conservatively; here lanes follow the rows of that projection, which is exact and asks
// nothing of a rasterizer.

#import tracebench::dispatch::{Invocation, linear_invocation}
#import tracebench::surface::unit_normal
#import tracebench::unit_space::{to_unit, on_image, from_image, dominant_axis}
#import tracebench::octree_settings::{OctreeBuild, WORKGROUP_SIZE, ROWS, FRAGMENTS, BROKEN, no_voxel}
#import tracebench::octree_rows::{cells_of, take_row, columns_of_row, depths_of_column}
#import tracebench::octree_morton::morton_key

@group(0) @binding(0) var<uniform> build: OctreeBuild;
@group(0) @binding(1) var<storage, read> positions: array<f32>;
@group(0) @binding(2) var<storage, read> indices: array<u32>;
// Rows of every triangle, and then the first of each.
@group(0) @binding(3) var<storage, read_write> row_starts: array<u32>;
// Fragments of every row, and then the first of each.
@group(0) @binding(4) var<storage, read_write> fragment_starts: array<u32>;
@group(0) @binding(5) var<storage, read_write> keys: array<u32>;
@group(0) @binding(6) var<storage, read_write> primitives: array<u32>;
@group(0) @binding(7) var<storage, read_write> taken: array<atomic<u32>>;

// The corners of a triangle in the scene.
var<private> corner_a: vec3<f32>;
var<private> corner_b: vec3<f32>;
var<private> corner_c: vec3<f32>;

fn load_position(corner: u32) -> vec3<f32> {
    let vertex = indices[corner] * 3u;
    return vec3<f32>(positions[vertex], positions[vertex + 1u], positions[vertex + 2u]);
}

fn load_triangle(triangle: u32) {
    corner_a = load_position(triangle * 3u);
    corner_b = load_position(triangle * 3u + 1u);
    corner_c = load_position(triangle * 3u + 2u);
}

// By its bits: what becomes of it in arithmetic is the driver's own.
fn is_number(point: vec3<f32>) -> bool {
    let bits = bitcast<vec3<u32>>(point) & vec3<u32>(0x7f800000u);
    return all(bits != vec3<u32>(0x7f800000u));
}

// A corner as the image along an axis has it, in voxels.
fn placed(axis: u32, corner: vec3<f32>) -> vec3<f32> {
    return on_image(axis, to_unit(build.space, corner) * f32(build.space.grid));
}

// Sums in 64 bits: more rows or fragments than 32 bits count are told as such.
fn count_up(word: u32, count: u32) {
    let before = atomicAdd(&taken[word], count);
    if (before + count < before) {
        atomicAdd(&taken[word + 1u], 1u);
    }
}

// The rows of every triangle; none of one without an area, which no ray hits.
@compute @workgroup_size(WORKGROUP_SIZE)
fn measure(invocation: Invocation) {
    let triangle = linear_invocation(invocation, WORKGROUP_SIZE);
    if (triangle > build.triangle_count) {
        return;
    }
    var rows = 0u;
    if (triangle < build.triangle_count) {
        load_triangle(triangle);
        let normal = unit_normal(corner_b - corner_a, corner_c - corner_a);
        if (!(is_number(corner_a) && is_number(corner_b) && is_number(corner_c))) {
            atomicAdd(&taken[BROKEN], 1u);
        } else if (any(normal != vec3<f32>(0.0))) {
            let axis = dominant_axis(normal);
            let down = vec3<f32>(placed(axis, corner_a).y, placed(axis, corner_b).y, placed(axis, corner_c).y);
            let cells = cells_of(min(down.x, min(down.y, down.z)), max(down.x, max(down.y, down.z)), build.space.grid);
            rows = u32(cells.y - cells.x + 1);
        }
    }
    row_starts[triangle] = rows;
    if (rows > 0u) {
        count_up(ROWS, rows);
    }
}

// Takes a row of all, and gives its triangle, the axis that it is seen along and its own row.
fn take(row: u32) -> vec3<u32> {
    // The last triangle that begins no later: those without rows begin where the next one does.
    var low = 0u;
    var high = build.triangle_count;
    while (high - low > 1u) {
        let middle = (low + high) / 2u;
        if (row_starts[middle] <= row) {
            low = middle;
        } else {
            high = middle;
        }
    }
    load_triangle(low);
    let axis = dominant_axis(unit_normal(corner_b - corner_a, corner_c - corner_a));
    let a = placed(axis, corner_a);
    let b = placed(axis, corner_b);
    let c = placed(axis, corner_c);
    let cells = cells_of(min(a.y, min(b.y, c.y)), max(a.y, max(b.y, c.y)), build.space.grid);
    let own = u32(cells.x) + row - row_starts[low];
    take_row(a, b, c, own);
    return vec3<u32>(low, axis, own);
}

fn is_row(row: u32) -> bool {
    return row < min(row_starts[build.triangle_count], build.row_capacity);
}

// The fragments of every row.
@compute @workgroup_size(WORKGROUP_SIZE)
fn count(invocation: Invocation) {
    let row = linear_invocation(invocation, WORKGROUP_SIZE);
    if (row > build.row_capacity) {
        return;
    }
    var fragments = 0u;
    if (is_row(row)) {
        take(row);
        let columns = columns_of_row(build.space.grid);
        for (var column = columns.x; column <= columns.y; column++) {
            let depths = depths_of_column(column, build.space.grid);
            fragments += u32(max(depths.y - depths.x + 1, 0));
        }
        count_up(FRAGMENTS, fragments);
    }
    fragment_starts[row] = fragments;
}

// The fragments themselves.
@compute @workgroup_size(WORKGROUP_SIZE)
fn emit(invocation: Invocation) {
    let row = linear_invocation(invocation, WORKGROUP_SIZE);
    if (!is_row(row)) {
        return;
    }
    let triangle = take(row);
    var place = fragment_starts[row];
    let columns = columns_of_row(build.space.grid);
    for (var column = columns.x; column <= columns.y; column++) {
        let depths = depths_of_column(column, build.space.grid);
        for (var depth = depths.x; depth <= depths.y; depth++) {
            // Beyond the capacity nothing is stored: the host sees from the count what is missing.
            if (place < build.fragment_capacity) {
                let voxel = from_image(triangle.y, vec3<f32>(f32(column), f32(triangle.z), f32(depth)));
                keys[place] = morton_key(vec3<u32>(voxel));
                primitives[place] = triangle.x;
            }
            place += 1u;
        }
    }
}

// Room that is left has the key of no voxel.
@compute @workgroup_size(WORKGROUP_SIZE)
fn pad(invocation: Invocation) {
    let place = linear_invocation(invocation, WORKGROUP_SIZE);
    if (place < build.fragment_capacity && place >= fragment_starts[build.row_capacity]) {
        keys[place] = no_voxel(build.levels);
        primitives[place] = 0u;
    }
}
