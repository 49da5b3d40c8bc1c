// A level of nodes from the one below: neighbours along the curve whose keys differ in the last three bits alone have one parent.

#import tracebench::dispatch::{Invocation, linear_invocation}
#import tracebench::octree_settings::{WORKGROUP_SIZE, OPENED}

struct OctreeLevel {
    // Of the level: the root's is 0.
    depth: u32,
    // What there is room for, of children and of nodes.
    child_capacity: u32,
    node_capacity: u32,
    // Where children lie among all nodes (leaves among all leaves), and where nodes do.
    first_child: u32,
    first_node: u32,
    padding_a: u32,
    padding_b: u32,
    padding_c: u32,
}

@group(0) @binding(0) var<uniform> level: OctreeLevel;
@group(0) @binding(1) var<storage, read> taken: array<u32>;
@group(0) @binding(2) var<storage, read> child_keys: array<u32>;
// 1 for the first child of every node, and then how many there are before each.
@group(0) @binding(3) var<storage, read_write> ranks: array<u32>;
@group(0) @binding(4) var<storage, read_write> node_keys: array<u32>;
// The first child, and a bit for every part that has one.
@group(0) @binding(5) var<storage, read_write> nodes: array<vec2<u32>>;

fn child_count() -> u32 {
    var count = 0u;
    for (var above = 0u; above <= level.depth; above++) {
        count += taken[OPENED + above];
    }
    return min(count, level.child_capacity);
}

fn is_first(child: u32, count: u32) -> bool {
    return child < count && (child == 0u || (child_keys[child] >> 3u) != (child_keys[child - 1u] >> 3u));
}

// Marks the first child of every node.
@compute @workgroup_size(WORKGROUP_SIZE)
fn mark(invocation: Invocation) {
    let child = linear_invocation(invocation, WORKGROUP_SIZE);
    if (child <= level.child_capacity) {
        ranks[child] = select(0u, 1u, is_first(child, child_count()));
    }
}

// Makes the nodes, each by the lane of its first child.
@compute @workgroup_size(WORKGROUP_SIZE)
fn join(invocation: Invocation) {
    let child = linear_invocation(invocation, WORKGROUP_SIZE);
    let count = child_count();
    if (!is_first(child, count)) {
        return;
    }
    let node = ranks[child];
    if (node >= level.node_capacity) {
        return;
    }
    let key = child_keys[child] >> 3u;
    var mask = 0u;
    for (var place = child; place < min(child + 8u, count); place++) {
        if ((child_keys[place] >> 3u) == key) {
            mask |= 1u << (child_keys[place] & 7u);
        }
    }
    node_keys[node] = key;
    nodes[level.first_node + node] = vec2<u32>(level.first_child + child, mask);
}
