#define_import_path tracebench::dirt_tree_walk

// The walk of a leg over the tiles of a face of the packed forms of DIRT, with the trees of the tiles that it meets.
//
// It goes on by rounds: a round takes two steps over cells, visits two nodes and tests two parts. Lanes that run together do so whatever
// each of them needs: loops of their own, over cells, nodes and parts, would wait for the lane with most of them, and drivers may run
// every branch for all lanes. Steps go on to the next tile while the tree of this one is searched, and nodes are visited while parts wait.

#import tracebench::reads::quad_1
#import tracebench::dirt_packed_grid::first_leaf_of
#import tracebench::dirt_packed_ray::{
    search, leg, limit, steps, work, is_done, set_limit, triangle_of, corners_of, test_corners, note_reference
}
#import tracebench::dirt_packed_walk::{is_walking, entered, begin_steps, step_on, entered_number}
#import tracebench::dirt_tile_tree::{TilePlanes, planes_of, meet_node}

// The parent of the root, which is its last child.
const ABOVE: u32 = 0x1fffffffu;

// The tree that is searched: its first node, first reference and first node of the last level.
var<private> planes: TilePlanes;
var<private> first_node: u32;
var<private> first_reference: u32;
var<private> first_leaf: u32;
// Whether `entered` is a tile whose tree is to be searched next.
var<private> has_tile: bool;
// Children to visit: a byte a level, the lowest that of the node `parent`.
var<private> waiting: vec2<u32>;
var<private> parent: u32;
// Parts to test, of one node and of that after it: a bit each, from a reference on.
var<private> parts: u32;
var<private> parts_base: u32;
var<private> next_parts: u32;
var<private> next_base: u32;

// Whether there is anything left of the tree.
fn has_tree() -> bool {
    return ((waiting.x | waiting.y) | (parts | next_parts)) != 0u;
}

// Whether the leg is not done.
fn is_busy() -> bool {
    return is_walking | has_tile | has_tree();
}

fn begin_no_walk() {
    is_walking = false;
    has_tile = false;
    waiting = vec2<u32>(0u);
    parts = 0u;
    next_parts = 0u;
}

// Begins the walk of the leg in a face.
fn begin_walk(walked: u32) {
    begin_no_walk();
    begin_steps(walked);
}

// The first of some children or parts in the order in which the ray meets them: they are stored from the far end to the near one.
fn first_of(bits: u32) -> u32 {
    let recedes = (search.nearest_first == 1u) & (leg.change.z < 0.0);
    return select(countTrailingZeros(bits), firstLeadingBit(bits), recedes);
}

// The node of the lowest level with waiting children, above or at this one; these are the lowest byte then.
fn climb(node: u32) -> u32 {
    let low_level = countTrailingZeros(waiting.x) >> 3u;
    let high_level = 4u + (countTrailingZeros(waiting.y) >> 3u);
    let levels = select(low_level, high_level, waiting.x == 0u);
    // Nodes above a level: 1 + 8 + 64 and so on.
    let above = 0x49249249u & ((1u << (3u * levels)) - 1u);
    let shift = 8u * (levels & 3u);
    let crossed = select(waiting.y << (32u - shift), 0u, shift == 0u);
    let within = vec2<u32>((waiting.x >> shift) | crossed, waiting.y >> shift);
    waiting = select(within, vec2<u32>(waiting.y >> shift, 0u), levels >= 4u);
    return (node - above) >> (3u * levels);
}

// Steps on to the next cell, unless a tile waits to be searched; and if it is one too many, unless the ray may not need it.
fn walk_on() {
    let finds = step_on(is_walking & !has_tile & ((steps < search.max_steps) | !has_tree()));
    has_tile = has_tile | finds;
}

// Begins the tree of the tile that waits where the one before it is done.
fn begin_tree() {
    let begins = has_tile & all(waiting == vec2<u32>(0u));
    let header = quad_1(entered_number());
    let entered_planes = planes_of(entered.tile, entered.begin, entered.end, entered.w_most, header.w);
    if (begins) {
        planes = entered_planes;
        first_reference = header.x;
        first_leaf = first_leaf_of(header.y);
        first_node = header.z;
        parent = ABOVE;
        // Unless the best hit was found before it since.
        waiting.x = select(0u, 0x80u, entered.begin <= limit);
    }
    has_tile = has_tile & !begins;
}

// Visits the next node, unless parts of two nodes wait.
fn visit() {
    let visits = (next_parts == 0u) & any(waiting != vec2<u32>(0u));
    let kept = waiting;
    let climbed = climb(parent);
    let child = first_of(waiting.x & 0xffu) & 31u;
    let rest = vec2<u32>(waiting.x & ~(1u << child), waiting.y);
    let node = 8u * climbed + 1u + child;
    let met = meet_node(planes, select(0u, first_node + node, visits));
#ifdef COUNTERS
    work.nodes_visited += select(0u, 1u, visits);
#endif
    let is_leaf = visits & (node >= first_leaf);
    let is_inner = visits & (node < first_leaf);
    next_parts = select(next_parts, met, is_leaf);
    next_base = select(next_base, first_reference + 8u * (node - first_leaf), is_leaf);
    let pushed = vec2<u32>((rest.x << 8u) | met, (rest.y << 8u) | (rest.x >> 24u));
    waiting = select(select(kept, rest, visits), pushed, is_inner);
    parent = select(select(parent, climbed, visits), node, is_inner);
    take_next_parts();
}

// Takes the parts that wait behind those to test, where these are done.
fn take_next_parts() {
    let is_next = parts == 0u;
    parts = select(parts, next_parts, is_next);
    parts_base = select(parts_base, next_base, is_next);
    next_parts = select(next_parts, 0u, is_next);
}

// A part to test next, where `asked`.
struct Part {
    reference: u32,
    asked: bool,
}

fn take_part() -> Part {
    let asked = parts != 0u;
    let part = first_of(parts) & 31u;
    parts &= ~(1u << part);
    return Part(select(0u, parts_base + part, asked), asked);
}

// Tests the next two parts. Both are read before either is tested: a lane waits once for what lies far away in memory.
fn test_two() {
    let a = take_part();
    take_next_parts();
    let b = take_part();
    let triangle_a = triangle_of(a.reference);
    let triangle_b = triangle_of(b.reference);
    let corners_a = corners_of(triangle_a);
    let corners_b = corners_of(triangle_b);
    test_corners(triangle_a, corners_a, a.asked);
    let asks_b = b.asked & !is_done();
    test_corners(triangle_b, corners_b, asks_b);
#ifdef COUNTERS
    note_reference(a.reference, a.asked);
    note_reference(b.reference, asks_b);
#endif
    if ((a.asked | b.asked) & is_done()) {
        begin_no_walk();
    }
}

// A round. What a tile's first nodes hold is tested in the round that finds the tile.
fn go_on() {
#ifdef COUNTERS
    work.search_rounds += select(0u, 1u, is_busy());
#endif
    walk_on();
    walk_on();
    begin_tree();
    visit();
    visit();
    test_two();
    set_limit();
}
