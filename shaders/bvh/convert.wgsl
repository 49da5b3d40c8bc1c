// Converts one level of a binary hierarchy into compressed eight-wide nodes (Ylitie, Karras, Laine, "Efficient Incoherent
// Ray Traversal on GPUs Through Compressed Wide BVHs", HPG 2017). Children are taken from the binary hierarchy by opening
// the one with the largest surface until there are eight (the greedy form of the surface area heuristic; Wald, Benthin,
// Boulos, "Getting Rid of Packets", RT 2008), as Benthin et al. (H-PLOC, HPG 2024) do on the device. Levels follow
// each other in dispatches where the paper's lanes wait for work, which WGSL does not promise to end.

#import tracebench::bvh_build::{BinaryNode, WideNode, TAKEN_SLOTS, LEVELS}
#import tracebench::bvh_build::{is_inner, triangles_below, height, half_area, grid_of, enter_box, byte_at}
#import tracebench::bvh_triangle::Triangle

struct Level {
    index: u32,
    // Most levels of binary nodes below a child that the compressed levels below have room for: three for each.
    tallest: u32,
}

@group(0) @binding(0) var<uniform> level: Level;
@group(0) @binding(1) var<storage, read_write> progress: array<atomic<u32>>;
@group(0) @binding(2) var<storage, read> nodes: array<BinaryNode>;
// The triangle in each slot of the binary leaves.
@group(0) @binding(3) var<storage, read> order: array<u32>;
@group(0) @binding(4) var<storage, read_write> wide_nodes: array<WideNode>;
@group(0) @binding(5) var<storage, read_write> triangles: array<Triangle>;

const WORKGROUP_SIZE: u32 = 64u;
// Most triangles of a leaf.
const MAX_IN_LEAF: u32 = 3u;
// Testing a triangle costs this much of visiting a node, as in obvhs's conversion.
const TRIANGLE_COST: f32 = 0.3;
const NEVER: f32 = -1.0;
const AT_ONCE: f32 = 3.4e38;
const FAR: f32 = 1e30;

// Eagerness to open a child.
fn priority_of(node: BinaryNode) -> f32 {
    let area = half_area(node.low, node.high);
    let below = triangles_below(node.count);
    if (!is_inner(node.count)) {
        return NEVER;
    }
    if (below <= MAX_IN_LEAF) {
        return TRIANGLE_COST * area;
    }
    return select(area, AT_ONCE, (height(node.count) > level.tallest));
}

// How far a child's centre lies against the direction of each slot: of slots 0 to 3, and 4 to 7 with x turned round.
fn slot_costs(offset: vec3<f32>) -> vec4<f32> {
    return vec4<f32>(offset.y + offset.z, offset.y - offset.z, offset.z - offset.y, -offset.y - offset.z);
}

fn min_of(a: vec4<f32>, b: vec4<f32>) -> f32 {
    let least = min(a, b);
    return min(min(least.x, least.y), min(least.z, least.w));
}

fn name_triangle(slot: u32, leaf: BinaryNode) {
    triangles[slot].primitive = order[leaf.first];
}

// Gives a leaf's triangles the slots from one on.
fn name_triangles(first_slot: u32, node: BinaryNode) {
    if (!is_inner(node.count)) {
        name_triangle(first_slot, node);
        return;
    }
    var slot = first_slot;
    for (var side = 0u; side < 2u; side++) {
        let below = nodes[node.first + side];
        if (is_inner(below.count)) {
            // Of three triangles two are no deeper than this.
            name_triangle(slot, nodes[below.first]);
            name_triangle(slot + 1u, nodes[below.first + 1u]);
            slot += 2u;
        } else {
            name_triangle(slot, below);
            slot += 1u;
        }
    }
}

fn convert_node(index: u32, next_level: u32) {
    var children: array<u32, 8>;
    var priorities: array<f32, 8>;
    // What the root's place holds is of the build before.
    let pair = select(wide_nodes[index].first_child, 0u, (level.index == 0u));
    children[0] = pair;
    children[1] = pair + 1u;
    priorities[0] = priority_of(nodes[pair]);
    priorities[1] = priority_of(nodes[pair + 1u]);
    // The empty sibling of a single triangle is none.
    var count = select(2u, 1u, (nodes[pair + 1u].count == 0u));
    while (count < 8u) {
        var chosen = 0u;
        for (var child = 1u; child < count; child++) {
            chosen = select(chosen, child, (priorities[child] > priorities[chosen]));
        }
        if (priorities[chosen] == NEVER) {
            break;
        }
        let first = nodes[children[chosen]].first;
        children[chosen] = first;
        priorities[chosen] = priority_of(nodes[first]);
        children[count] = first + 1u;
        priorities[count] = priority_of(nodes[first + 1u]);
        count += 1u;
    }

    var low = nodes[children[0]].low;
    var high = nodes[children[0]].high;
    var triangle_count = 0u;
    var node_count = 0u;
    for (var child = 0u; child < count; child++) {
        let node = nodes[children[child]];
        low = min(low, node.low);
        high = max(high, node.high);
        let below = triangles_below(node.count);
        triangle_count += select(0u, below, (below <= MAX_IN_LEAF));
        node_count += select(1u, 0u, (below <= MAX_IN_LEAF));
    }
    let first_triangle = atomicAdd(&progress[TAKEN_SLOTS], triangle_count);
    let first_child = next_level + atomicAdd(&progress[LEVELS + level.index + 1u], node_count);
    let grid = grid_of(low, high);

    // Each child takes a slot of the octant that it lies in (section 3.2; greedily, where the paper has an auction).
    let centre = 0.5 * (low + high);
    var costs: array<vec4<f32>, 8>;
    var along_x: array<f32, 8>;
    for (var child = 0u; child < count; child++) {
        let node = nodes[children[child]];
        let offset = 0.5 * (node.low + node.high) - centre;
        costs[child] = slot_costs(offset);
        along_x[child] = offset.x;
    }
    var slots: array<u32, 8>;
    var taken_low = vec4<f32>(0.0);
    var taken_high = vec4<f32>(0.0);
    var placed = 0u;
    for (var round = 0u; round < count; round++) {
        var least = 3.4e38;
        var chosen = 0u;
        for (var child = 0u; child < count; child++) {
            let cost = min_of(costs[child] + along_x[child] + taken_low, costs[child] - along_x[child] + taken_high);
            if (cost < least && (placed & (1u << child)) == 0u) {
                least = cost;
                chosen = child;
            }
        }
        let is_low = costs[chosen] + along_x[chosen] + taken_low == vec4<f32>(least);
        let is_high = costs[chosen] - along_x[chosen] + taken_high == vec4<f32>(least);
        let low_bits = dot(select(vec4<u32>(0u), vec4<u32>(1u, 2u, 4u, 8u), is_low), vec4<u32>(1u));
        let high_bits = dot(select(vec4<u32>(0u), vec4<u32>(16u, 32u, 64u, 128u), is_high), vec4<u32>(1u));
        let slot = firstTrailingBit(low_bits | high_bits);
        slots[chosen] = slot;
        placed |= 1u << chosen;
        taken_low += select(vec4<f32>(0.0), vec4<f32>(FAR), (vec4<u32>(slot) == vec4<u32>(0u, 1u, 2u, 3u)));
        taken_high += select(vec4<f32>(0.0), vec4<f32>(FAR), (vec4<u32>(slot) == vec4<u32>(4u, 5u, 6u, 7u)));
    }

    var wide = WideNode(low, 0u, first_child, first_triangle, vec2<u32>(0u), vec4<u32>(0u), vec4<u32>(0u), vec4<u32>(0u));
    var inner = 0u;
    var offset = 0u;
    for (var child = 0u; child < count; child++) {
        let node = nodes[children[child]];
        let slot = slots[child];
        let below = triangles_below(node.count);
        enter_box(&wide, grid, slot, node.low, node.high);
        if (below <= MAX_IN_LEAF) {
            // The triangles' number in unary, and where they begin.
            wide.children |= byte_at(slot, (((1u << below) - 1u) << 5u) | offset);
            name_triangles(first_triangle + offset, node);
            offset += below;
        } else {
            wide.children |= byte_at(slot, 0x20u | (24u + slot));
            inner |= 1u << slot;
        }
    }
    for (var child = 0u; child < count; child++) {
        let slot = slots[child];
        if ((inner & (1u << slot)) != 0u) {
            let below = first_child + countOneBits(inner & ((1u << slot) - 1u));
            wide_nodes[below].first_child = nodes[children[child]].first;
        }
    }
    wide.exponents_and_nodes =
        grid.exponents.x | (grid.exponents.y << 8u) | (grid.exponents.z << 16u) | (inner << 24u);
    wide_nodes[index] = wide;
}

@compute @workgroup_size(WORKGROUP_SIZE)
fn convert(
    @builtin(global_invocation_id) invocation: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
) {
    // Lanes of levels that the hierarchy does not have end at once.
    if (atomicLoad(&progress[LEVELS + level.index]) == 0u) {
        return;
    }
    var first = 0u;
    for (var before = 0u; before < level.index; before++) {
        first += atomicLoad(&progress[LEVELS + before]);
    }
    let end = first + atomicLoad(&progress[LEVELS + level.index]);
    for (var index = first + invocation.x; index < end; index += workgroups.x * WORKGROUP_SIZE) {
        convert_node(index, end);
    }
}
