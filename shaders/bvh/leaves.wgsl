// From the scene's triangles to leaves along a Morton curve, and to triangles in the order of leaves.

#import tracebench::dispatch::{Invocation, linear_invocation}
#import tracebench::bvh_build::{BuildSettings, BinaryNode, Box, CROWDED, LEVELS}
#import tracebench::bvh_triangle::Triangle

@group(0) @binding(0) var<uniform> settings: BuildSettings;
@group(0) @binding(1) var<storage, read> positions: array<f32>;
@group(0) @binding(2) var<storage, read> indices: array<u32>;
@group(0) @binding(3) var<storage, read_write> codes: array<u32>;
// The triangle in each place along the curve, once sorted.
@group(0) @binding(4) var<storage, read_write> order: array<u32>;
@group(0) @binding(5) var<storage, read_write> clusters: array<BinaryNode>;
@group(0) @binding(6) var<storage, read_write> nodes: array<BinaryNode>;
@group(0) @binding(7) var<storage, read_write> triangles: array<Triangle>;
@group(0) @binding(8) var<storage, read_write> progress: array<atomic<u32>>;

const WORKGROUP_SIZE: u32 = 64u;
// Cells along an axis: 10 bits.
const LAST_CELL: f32 = 1023.0;
// Half the edge of the inside-out box of an empty leaf: the scene's diagonal, as it is scaled.
const INSIDE_OUT: f32 = 131072.0;

fn corner(triangle: u32, which: u32) -> vec3<f32> {
    let vertex = indices[3u * triangle + which];
    return vec3<f32>(positions[3u * vertex], positions[3u * vertex + 1u], positions[3u * vertex + 2u]) * settings.scale;
}

fn box_of(triangle: u32) -> Box {
    let a = corner(triangle, 0u);
    let b = corner(triangle, 1u);
    let c = corner(triangle, 2u);
    return Box(min(min(a, b), c), max(max(a, b), c));
}

// Ten bits with two zeros before each.
fn spread(cell: u32) -> u32 {
    var bits = (cell | (cell << 16u)) & 0x030000ffu;
    bits = (bits | (bits << 8u)) & 0x0300f00fu;
    bits = (bits | (bits << 4u)) & 0x030c30c3u;
    return (bits | (bits << 2u)) & 0x09249249u;
}

// The Morton code of the centre of every triangle's box.
@compute @workgroup_size(WORKGROUP_SIZE)
fn encode(invocation: Invocation) {
    let triangle = linear_invocation(invocation, WORKGROUP_SIZE);
    if (triangle >= settings.triangle_count) {
        return;
    }
    let bounds = box_of(triangle);
    let centre = 0.5 * (bounds.low + bounds.high);
    let place = (centre - settings.low) * settings.cells_per_unit;
    let cell = vec3<u32>(clamp(place, vec3<f32>(0.0), vec3<f32>(LAST_CELL)));
    codes[triangle] = (spread(cell.x) << 2u) | (spread(cell.y) << 1u) | spread(cell.z);
    order[triangle] = triangle;
}

// Triangles that coincide stand beside each other along the curve. Where two this far apart do, there are many.
const CROWD: u32 = 256u;

// A leaf in every place along the curve: the first clusters.
@compute @workgroup_size(WORKGROUP_SIZE)
fn place(invocation: Invocation) {
    let slot = linear_invocation(invocation, WORKGROUP_SIZE);
    if (slot >= settings.triangle_count) {
        return;
    }
    let triangle = order[slot];
    let bounds = box_of(triangle);
    let leaf = BinaryNode(bounds.low, slot, bounds.high, 1u);
    clusters[slot] = leaf;
    let later = slot + CROWD;
    if (later < settings.triangle_count && codes[slot] == codes[min(later, settings.triangle_count - 1u)]) {
        let other = box_of(order[later]);
        if (all(other.low == bounds.low) && all(other.high == bounds.high)) {
            atomicStore(&progress[CROWDED], 1u);
        }
    }
    triangles[slot].primitive = triangle;
    if (slot == 0u) {
        atomicStore(&progress[0], settings.triangle_count);
        atomicStore(&progress[LEVELS], 1u);
        // A single triangle is never merged: beside it stands a leaf that nothing meets and that has no triangle.
        if (settings.triangle_count == 1u) {
            nodes[0] = leaf;
            nodes[1] = BinaryNode(vec3<f32>(INSIDE_OUT), 0u, vec3<f32>(-INSIDE_OUT), 0u);
        }
    }
}

// The corners of the triangle that every slot names.
@compute @workgroup_size(WORKGROUP_SIZE)
fn fill(invocation: Invocation) {
    let slot = linear_invocation(invocation, WORKGROUP_SIZE);
    if (slot >= settings.triangle_count) {
        return;
    }
    let triangle = triangles[slot].primitive;
    triangles[slot] = Triangle(corner(triangle, 0u), triangle, corner(triangle, 1u), 0u, corner(triangle, 2u), 0u);
}
