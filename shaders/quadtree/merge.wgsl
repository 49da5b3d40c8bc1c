// One level of the quad-trees from the one below (WKP15, section 3.3): for every node the plane that stands for its children, or the
// box round them.

#import tracebench::dispatch::{Invocation, linear_invocation}
#import tracebench::pyramid::level_size
#import tracebench::quadtree_forest::{Forest, node_index}
#import tracebench::quadtree_node::{NOTHING, SIDES, end_of, is_plane, plane_of, range_of, box_of, box_words, z_on}
#import tracebench::quadtree_patches::step_across
#import tracebench::quadtree_proxy::merged

@group(0) @binding(0) var<uniform> forest: Forest;
// The level to make, from 1 on.
@group(0) @binding(1) var<uniform> made: vec4<u32>;
@group(0) @binding(2) var<storage, read_write> nodes: array<vec2<u32>>;

const WORKGROUP_SIZE: u32 = 64u;

// The least z of what is joined in a pixel: there a plane ends at one beside it that goes farther than itself.
fn min_joined(image: u32, pixel: vec2<u32>, side: u32) -> f32 {
    let step = step_across(side);
    let beside = nodes[node_index(forest, image, 0u, vec2<u32>(vec2<i32>(pixel) + step))];
    var neighbour = plane_of(beside, vec2<f32>(forest.size));
    neighbour.z = z_on(neighbour, -vec2<f32>(step));
    return range_of(neighbour, 0.5).x;
}

@compute @workgroup_size(WORKGROUP_SIZE)
fn merge(invocation: Invocation) {
    let level = made.x;
    let cells = level_size(forest.size, level);
    let index = linear_invocation(invocation, WORKGROUP_SIZE);
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
    // What may end at a plane beside it stays a pixel: boxes above a plane of several would not know how far those beside them go.
    var words = merged(forest, children, there, level - 1u);
    if (level == 1u && !is_plane(words)) {
        var box = box_of(words);
        for (var child = 0u; child < 4u; child++) {
            let side = end_of(children[child]);
            if (side < SIDES) {
                let pixel = 2u * cell + vec2<u32>(child & 1u, child >> 1u);
                box.least = min(box.least, min_joined(image, pixel, side));
            }
        }
        // Of a box without anything that is shown nothing changed.
        words = box_words(box);
    }
    nodes[node_index(forest, image, level, cell)] = words;
}
