// Fits the boxes of one level, or of the pairs of one iteration, to triangles that moved; levels follow each other from
// the leaves up.

#import tracebench::dispatch::{Invocation, linear_invocation}
#import tracebench::bvh_build::{BinaryNode, WideNode, Box, FINISHED, LEVELS, both, is_inner, grid_of, enter_box}
#import tracebench::bvh_triangle::Triangle

struct Stage {
    // Of iterations from the first one on, of levels from the root's on.
    index: u32,
    triangle_count: u32,
}

@group(0) @binding(0) var<uniform> stage: Stage;
@group(0) @binding(1) var<storage, read> progress: array<u32>;
@group(0) @binding(2) var<storage, read> triangles: array<Triangle>;
#ifdef WIDE
@group(0) @binding(3) var<storage, read_write> nodes: array<WideNode>;
// Of every node, not rounded.
@group(0) @binding(4) var<storage, read_write> boxes: array<Box>;
#else
@group(0) @binding(3) var<storage, read_write> nodes: array<BinaryNode>;
#endif

const WORKGROUP_SIZE: u32 = 64u;

fn box_of_triangle(slot: u32) -> Box {
    let triangle = triangles[slot];
    return Box(
        min(min(triangle.first, triangle.second), triangle.third),
        max(max(triangle.first, triangle.second), triangle.third),
    );
}

#ifdef WIDE
fn box_of_child(node: WideNode, slot: u32, code: u32) -> Box {
    let inner = node.exponents_and_nodes >> 24u;
    if ((inner & (1u << slot)) != 0u) {
        return boxes[node.first_child + countOneBits(inner & ((1u << slot) - 1u))];
    }
    let first = node.first_triangle + (code & 0x1fu);
    var whole = box_of_triangle(first);
    for (var more = 1u; more < countOneBits(code >> 5u); more++) {
        whole = both(whole, box_of_triangle(first + more));
    }
    return whole;
}

fn fit_node(index: u32) {
    var node = nodes[index];
    var children: array<Box, 8>;
    var whole = Box(vec3<f32>(3.4e38), vec3<f32>(-3.4e38));
    for (var slot = 0u; slot < 8u; slot++) {
        let code = (node.children[slot >> 2u] >> ((slot & 3u) * 8u)) & 0xffu;
        if (code != 0u) {
            children[slot] = box_of_child(node, slot, code);
            whole = both(whole, children[slot]);
        }
    }
    let grid = grid_of(whole.low, whole.high);
    node.origin = whole.low;
    node.exponents_and_nodes = (node.exponents_and_nodes & 0xff000000u)
        | grid.exponents.x | (grid.exponents.y << 8u) | (grid.exponents.z << 16u);
    node.x = vec4<u32>(0u);
    node.y = vec4<u32>(0u);
    node.z = vec4<u32>(0u);
    for (var slot = 0u; slot < 8u; slot++) {
        let code = (node.children[slot >> 2u] >> ((slot & 3u) * 8u)) & 0xffu;
        if (code != 0u) {
            enter_box(&node, grid, slot, children[slot].low, children[slot].high);
        }
    }
    nodes[index] = node;
    boxes[index] = whole;
}

@compute @workgroup_size(WORKGROUP_SIZE)
fn fit(
    @builtin(global_invocation_id) invocation: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
) {
    var first = 0u;
    for (var before = 0u; before < stage.index; before++) {
        first += progress[LEVELS + before];
    }
    let end = first + progress[LEVELS + stage.index];
    for (var index = first + invocation.x; index < end; index += workgroups.x * WORKGROUP_SIZE) {
        fit_node(index);
    }
}
#else
// The pair that was merged after so many others.
fn fit_pair(rank: u32) {
    let pair = 2u * (max(stage.triangle_count, 2u) - 2u - rank);
    for (var side = 0u; side < 2u; side++) {
        let node = nodes[pair + side];
        if (node.count == 0u) {
            continue;
        }
        var fitted: Box;
        if (is_inner(node.count)) {
            let below = nodes[node.first];
            let beside = nodes[node.first + 1u];
            fitted = Box(min(below.low, beside.low), max(below.high, beside.high));
        } else {
            fitted = box_of_triangle(node.first);
        }
        nodes[pair + side] = BinaryNode(fitted.low, node.first, fitted.high, node.count);
    }
}

@compute @workgroup_size(WORKGROUP_SIZE)
fn fit(invocation: Invocation) {
    let lane = linear_invocation(invocation, WORKGROUP_SIZE);
    let rank = stage.triangle_count - progress[stage.index] + lane;
    if (rank < stage.triangle_count - progress[stage.index + 1u]) {
        fit_pair(rank);
    }
}

const LAST_LANES: u32 = 256u;

var<workgroup> merged: vec2<u32>;

// One workgroup: the pairs of the last clusters, iteration by iteration.
@compute @workgroup_size(LAST_LANES)
fn fit_last(@builtin(local_invocation_index) local: u32) {
    if (stage.triangle_count == 1u && local == 0u) {
        // A single triangle was never merged, but is one of a pair.
        fit_pair(0u);
    }
    var iteration = FINISHED;
    loop {
        if (local == 0u) {
            merged = vec2<u32>(stage.triangle_count) - vec2<u32>(progress[iteration], progress[iteration + 1u]);
        }
        let ranks = workgroupUniformLoad(&merged);
        // After the last iteration there is one cluster, and no word was written beyond.
        if (ranks.x + 1u >= stage.triangle_count) {
            break;
        }
        for (var rank = ranks.x + local; rank < ranks.y; rank += LAST_LANES) {
            fit_pair(rank);
        }
        iteration += 1u;
        storageBarrier();
    }
}
#endif
