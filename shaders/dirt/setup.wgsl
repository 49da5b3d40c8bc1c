// Triangle setup, the beginning of DIRT's build: the vertex buffer (section 4.1.2), and of every view the triangles that may
// be seen in it, each with the rectangle of tiles that it may touch. The geometry passes draw these, so that no pass of no view
// asks again which triangles it sees, and where.
//
// Lists keep the order of triangles: bits tell which triangles of a block a view sees, and a prefix sum over the blocks' counts
// (those of the first view, then those of the next one) where in the view's list a block begins.

#import tracebench::dispatch::{Invocation, linear_workgroup}
#import tracebench::view::{View, to_eye_space}
#import tracebench::tile_clip::{TileRectangle, tile_rectangle}
#import tracebench::dirt_drawn::{RasterizedTriangle, DrawnTriangles}

struct SetupPass {
    // Of a view.
    tiles: vec2<u32>,
    triangle_count: u32,
    view_count: u32,
    // Of BLOCK triangles.
    block_count: u32,
    padding_a: u32,
    padding_b: u32,
    padding_c: u32,
    // Of each view: the first entry of its list, and the entries that there is room for.
    capacities: array<vec4<u32>, 6>,
}

@group(0) @binding(0) var<uniform> setup: SetupPass;
// Their sizes count tiles.
@group(0) @binding(1) var<uniform> views: array<View, 6>;
@group(0) @binding(2) var<storage, read> positions: array<f32>;
@group(0) @binding(3) var<storage, read> indices: array<u32>;
@group(0) @binding(4) var<storage, read_write> vertices: array<f32>;
// A bit for each of a block's triangles, all blocks of the first view first.
@group(0) @binding(5) var<storage, read_write> seen: array<vec2<u32>>;
// As many of each block, then, by the prefix sum, as many before it; and one more for the sum of all.
@group(0) @binding(6) var<storage, read_write> blocks: array<u32>;
@group(0) @binding(7) var<storage, read_write> listed: DrawnTriangles;

// Triangles of a block, a bit each: two words.
const BLOCK: u32 = 64u;

// Two words a view.
var<workgroup> seen_here: array<atomic<u32>, 12>;

fn rectangle_in(view: View, a: vec3<f32>, b: vec3<f32>, c: vec3<f32>) -> TileRectangle {
    return tile_rectangle(view, setup.tiles, to_eye_space(view, a), to_eye_space(view, b), to_eye_space(view, c));
}

// Corners into their record, and which views see the triangle.
@compute @workgroup_size(BLOCK)
fn see(invocation: Invocation) {
    let block = linear_workgroup(invocation);
    let triangle = block * BLOCK + invocation.local;
    if (triangle < setup.triangle_count) {
        var corners: array<vec3<f32>, 3>;
        for (var corner = 0u; corner < 3u; corner++) {
            let vertex = indices[triangle * 3u + corner] * 3u;
            corners[corner] = vec3<f32>(positions[vertex], positions[vertex + 1u], positions[vertex + 2u]);
            for (var axis = 0u; axis < 3u; axis++) {
                vertices[triangle * 9u + corner * 3u + axis] = corners[corner][axis];
            }
        }
        for (var view = 0u; view < setup.view_count; view++) {
            let rectangle = rectangle_in(views[view], corners[0], corners[1], corners[2]);
            if (all(rectangle.last > rectangle.first)) {
                atomicOr(&seen_here[2u * view + (invocation.local >> 5u)], 1u << (invocation.local & 31u));
            }
        }
    }
    workgroupBarrier();
    if (invocation.local < setup.view_count && block < setup.block_count) {
        let bits = vec2<u32>(atomicLoad(&seen_here[2u * invocation.local]), atomicLoad(&seen_here[2u * invocation.local + 1u]));
        let place = invocation.local * setup.block_count + block;
        seen[place] = bits;
        blocks[place] = countOneBits(bits.x) + countOneBits(bits.y);
    }
}

fn corner_of(triangle: u32, corner: u32) -> vec3<f32> {
    let first = triangle * 9u + corner * 3u;
    return vec3<f32>(vertices[first], vertices[first + 1u], vertices[first + 2u]);
}

fn packed(tile: vec2<f32>) -> u32 {
    let at = vec2<u32>(tile);
    return at.x | (at.y << 16u);
}

// Every triangle into the lists of the views that see it.
@compute @workgroup_size(BLOCK)
fn list(invocation: Invocation) {
    let block = linear_workgroup(invocation);
    let triangle = block * BLOCK + invocation.local;
    if (block == 0u && invocation.local < setup.view_count) {
        listed.counts[invocation.local] = blocks[(invocation.local + 1u) * setup.block_count] - blocks[invocation.local * setup.block_count];
    }
    if (triangle >= setup.triangle_count) {
        return;
    }
    let upper = invocation.local >= 32u;
    let bit = 1u << (invocation.local & 31u);
    for (var view = 0u; view < setup.view_count; view++) {
        let place = view * setup.block_count + block;
        let bits = seen[place];
        let word = select(bits.x, bits.y, upper);
        if ((word & bit) != 0u) {
            let in_block = countOneBits(word & (bit - 1u)) + select(0u, countOneBits(bits.x), upper);
            let in_view = blocks[place] - blocks[view * setup.block_count] + in_block;
            let room = setup.capacities[view];
            if (in_view < room.y) {
                let rectangle =
                    rectangle_in(views[view], corner_of(triangle, 0u), corner_of(triangle, 1u), corner_of(triangle, 2u));
                listed.entries[room.x + in_view] = RasterizedTriangle(triangle, packed(rectangle.first), packed(rectangle.last));
            }
        }
    }
}
