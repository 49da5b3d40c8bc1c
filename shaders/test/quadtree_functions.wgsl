// Calls the functions of the quad-tree on given numbers, so that a test can compare them with f64.

#import tracebench::view::View
#import tracebench::image_walk::{EyeRay, Span}
#import tracebench::quadtree_forest::{Forest, z_of_depth, depth_of_z, z_of_pixels, levels_apart}
#import tracebench::quadtree_node::{plane_of, plane_words, slope_words, range_of, z_on, box_of, box_words, is_plane, is_empty, Box}
#import tracebench::quadtree_proxy::{merged, thresholds_at}
#import tracebench::quadtree_reconstruct::{axis_slope, is_apart}
#import tracebench::quadtree_track::{track_of, bounds_of, z_along, enters_at, leaves_at, part_near, cell_at, successor}

@group(0) @binding(0) var<uniform> forest: Forest;
@group(0) @binding(1) var<storage, read> given: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read_write> results: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read> words: array<vec2<u32>>;
@group(0) @binding(4) var<storage, read_write> nodes: array<vec2<u32>>;
@group(0) @binding(5) var<uniform> view: View;

// Depths and numbers of pixels: z, depth of that z, z of the pixels, and both thresholds at z.
@compute @workgroup_size(64)
fn convert(@builtin(global_invocation_id) id: vec3<u32>) {
    if (id.x >= arrayLength(&given)) {
        return;
    }
    let z = z_of_depth(forest, given[id.x].x);
    let thresholds = thresholds_at(forest, z);
    results[2u * id.x] = vec4<f32>(z, depth_of_z(forest, z), z_of_pixels(forest, z, given[id.x].y), 0.0);
    results[2u * id.x + 1u] = vec4<f32>(thresholds, 0.0, 0.0);
}

// z, slopes over the cube and a reach in pixels, flagged below 0: the node, what it says, and its range; and z as a box with the
// reach's z.
@compute @workgroup_size(64)
fn encode(@builtin(global_invocation_id) id: vec3<u32>) {
    if (id.x >= arrayLength(&given)) {
        return;
    }
    let asked = given[id.x];
    let node = plane_words(asked.x, slope_words(asked.yz), asked.w < 0.0);
    let plane = plane_of(node, vec2<f32>(forest.size));
    let reach = abs(asked.w);
    nodes[2u * id.x] = node;
    results[2u * id.x] = vec4<f32>(plane.z, plane.slope, select(0.0, 1.0, plane.flagged));
    results[2u * id.x + 1u] = vec4<f32>(range_of(plane, reach), z_on(plane, vec2<f32>(reach, -reach)), select(0.0, 1.0, is_plane(node)));
    let box = box_words(Box(asked.x, min(asked.x + reach * 0.01, 1.0), asked.w < 0.0));
    let told = box_of(box);
    let says_so = told.holes == (asked.w < 0.0) && !is_plane(box) && !is_empty(box);
    nodes[2u * id.x + 1u] = select(vec2<u32>(0u), box, says_so);
}

// Four words of children, then which exist and their level.
@compute @workgroup_size(64)
fn merge_children(@builtin(global_invocation_id) id: vec3<u32>) {
    if (id.x >= arrayLength(&nodes)) {
        return;
    }
    let at = 5u * id.x;
    let children = array<vec2<u32>, 4>(words[at], words[at + 1u], words[at + 2u], words[at + 3u]);
    nodes[id.x] = merged(forest, children, words[at + 4u].x, words[at + 4u].y);
}

// Pairs of cells.
@compute @workgroup_size(64)
fn tell_levels(@builtin(global_invocation_id) id: vec3<u32>) {
    if (id.x >= arrayLength(&nodes)) {
        return;
    }
    nodes[id.x] = vec2<u32>(levels_apart(words[2u * id.x], words[2u * id.x + 1u]), 0u);
}

// Five z of pixels side by side and a tolerance, in two vectors.
@compute @workgroup_size(64)
fn find_slopes(@builtin(global_invocation_id) id: vec3<u32>) {
    if (2u * id.x >= arrayLength(&given)) {
        return;
    }
    let first = given[2u * id.x];
    let second = given[2u * id.x + 1u];
    let found = axis_slope(first.x, first.y, first.z, first.w, second.x, second.y);
    let apart = is_apart(first.w, first.z + found.slope, second.y);
    results[id.x] = vec4<f32>(found.slope, select(0.0, 1.0, found.found), select(0.0, 1.0, apart), 0.0);
}

// Origins and directions of rays in eye space with a span: of every cell of a level on the way its place, and what the ray has there.
const MAX_CELLS: u32 = 64u;

@compute @workgroup_size(64)
fn cross_cells(@builtin(global_invocation_id) id: vec3<u32>) {
    if (3u * id.x >= arrayLength(&given)) {
        return;
    }
    let origin = given[3u * id.x].xyz;
    let direction = given[3u * id.x + 1u].xyz;
    let asked = given[3u * id.x + 2u];
    let level = u32(asked.z);
    let track = track_of(forest, view, EyeRay(origin, direction), Span(asked.x, asked.y));
    let last = (vec2<i32>(forest.size) - 1) >> vec2<u32>(level);
    var cell = cell_at(track, 0.0, level, last);
    var place = 0.0;
    var count = 0u;
    for (; count < MAX_CELLS; count++) {
        let bounds = bounds_of(cell, level);
        let leaves = leaves_at(track, bounds, place);
        let exit = min(min(leaves.x, leaves.y), 1.0);
        let near = part_near(track, asked.w, vec2<f32>(place, exit), 0.0, 1.0);
        let at = 2u * (id.x * MAX_CELLS + count);
        results[at] = vec4<f32>(vec2<f32>(cell), enters_at(track, bounds, 0.0), exit);
        results[at + 1u] = vec4<f32>(near, z_along(track, place), 1.0);
        if (exit >= 1.0) {
            break;
        }
        cell = successor(track, leaves, cell);
        if (any(cell < vec2<i32>(0)) || any(cell > last)) {
            break;
        }
        place = exit;
    }
}
