// One level of the quad-trees from the one below (WKP15, section 3.3): for every node the plane that stands for its children, or the
// box round them.

#import tracebench::dispatch::linear_invocation
#import tracebench::pyramid::level_size
#import tracebench::quadtree_forest::{Forest, node_index}
#import tracebench::quadtree_node::NOTHING
#import tracebench::quadtree_proxy::merged

@group(0) @binding(0) var<uniform> forest: Forest;
// The level to make, from 1 on.
@group(0) @binding(1) var<uniform> made: vec4<u32>;
@group(0) @binding(2) var<storage, read_write> nodes: array<vec2<u32>>;

const WORKGROUP_SIZE: u32 = 64u;

@compute @workgroup_size(WORKGROUP_SIZE)
fn merge(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let level = made.x;
    let cells = level_size(forest.size, level);
    let index = linear_invocation(workgroup, workgroups, local, WORKGROUP_SIZE);
    if (index >= cells.x * cells.y * forest.image_count) {
        return;
    }
    let image = index / (cells.x * cells.y);
    let place = index % (cells.x * cells.y);
    let cell = vec2<u32>(place % cells.x, place / cells.x);
    let below = level_size(forest.size, level - 1u);
    var children = array<vec2<u32>, 4>(NOTHING, NOTHING, NOTHING, NOTHING);
    var there = 0u;
    for (var child = 0u; child < 4u; child++) {
        let at = 2u * cell + vec2<u32>(child & 1u, child >> 1u);
        if (all(at < below)) {
            children[child] = nodes[node_index(forest, image, level - 1u, at)];
            there |= 1u << child;
        }
    }
    nodes[node_index(forest, image, level, cell)] = merged(forest, children, there, level - 1u);
}
