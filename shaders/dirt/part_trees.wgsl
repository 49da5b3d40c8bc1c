// The build of the packed forms of DIRT from the sort on: where the parts of every tile begin and end; the masks' pyramid; of every eight
// parts in a row a node of eight boxes, and of every eight nodes another one, up to one a tile; or where the lists of its slices begin.
//
// No node is pointed to: first_leaf_of tells where nodes lie from the number of parts alone.

#import tracebench::dispatch::{Invocation, linear_invocation}
#import tracebench::pyramid::{level_size, cell_below}
#import tracebench::dirt_packed_grid::{
    PackedGrid, MISPLACED, FIRST_NEAR, FACES, cell_number, lowest_bits, first_leaf_of, node_count_of, depth_scale, depth_base, depth_step
}

struct MipmapLevel {
    // The level to make, from 1.
    level: u32,
    views: u32,
    padding: vec2<u32>,
}

@group(0) @binding(0) var<uniform> grid: PackedGrid;
@group(0) @binding(1) var<uniform> made: MipmapLevel;
@group(0) @binding(2) var<storage, read> keys: array<u32>;
@group(0) @binding(3) var<storage, read> places: array<u32>;
@group(0) @binding(4) var<storage, read> parts: array<vec4<u32>>;
// Four words a tile: its first reference, how many it has, its first node, the scale of its depths. While they are found, the end of its
// references in the second. (Words, not quads: two lanes write two of them.)
@group(0) @binding(5) var<storage, read_write> quads: array<u32>;
@group(0) @binding(6) var<storage, read_write> words: array<u32>;
@group(0) @binding(7) var<storage, read_write> masks: array<u32>;
// Of every tile its nodes, or lists, then, by the prefix sum, the first of them; and one more for the end of all.
@group(0) @binding(8) var<storage, read_write> node_counts: array<u32>;
// Three quads a node: boxes of eight children in bytes, least x, greatest x; y; depth codes, least w, greatest w.
@group(0) @binding(9) var<storage, read_write> nodes: array<vec4<u32>>;
// Where every list begins.
@group(0) @binding(10) var<storage, read_write> lists: array<u32>;

const WORKGROUP_SIZE: u32 = 64u;
// More parts in a tile are not built: drivers count a lane's rounds.
const MAX_PARTS: u32 = 2097152u;

fn tile_count() -> u32 {
    return FACES * grid.tiles * grid.tiles;
}

// One more than the tile of a place in the order; 0 where there is no part.
fn tile_code(place: u32) -> u32 {
    return keys[place] >> grid.order_bits;
}

// References, and where those of every tile begin and end.
@compute @workgroup_size(WORKGROUP_SIZE)
fn bound(invocation: Invocation) {
    let place = linear_invocation(invocation, WORKGROUP_SIZE);
    if (place >= grid.part_capacity) {
        return;
    }
    let code = tile_code(place);
    if (code == 0u) {
        return;
    }
    words[FIRST_NEAR + grid.triangle_count + place] = parts[places[place]].w;
    let is_first = place == 0u || tile_code(max(place, 1u) - 1u) != code;
    let is_last = place + 1u >= grid.part_capacity || tile_code(min(place + 1u, grid.part_capacity - 1u)) != code;
    if (is_first) {
        quads[4u * (code - 1u)] = place;
    }
    if (is_last) {
        quads[4u * (code - 1u) + 1u] = place + 1u;
    }
}

// How many parts, and nodes or lists, every tile has.
@compute @workgroup_size(WORKGROUP_SIZE)
fn size(invocation: Invocation) {
    let tile = linear_invocation(invocation, WORKGROUP_SIZE);
    if (tile >= tile_count()) {
        return;
    }
    let parts_here = quads[4u * tile + 1u] - quads[4u * tile];
    quads[4u * tile + 1u] = parts_here;
    let range = 2u * (FACES * grid.cells + tile);
    quads[4u * tile + 3u] = select(depth_scale(~masks[range + 1u], masks[range]), 0u, parts_here == 0u);
    if (parts_here > MAX_PARTS) {
        words[MISPLACED] = parts_here;
    }
#ifdef SLICES
    let mask = mask_of_tile(tile);
    node_counts[tile] = countOneBits(mask.x) + countOneBits(mask.y);
#else
    node_counts[tile] = node_count_of(parts_here);
#endif
}

fn mask_of_tile(tile: u32) -> vec2<u32> {
    let of_face = grid.tiles * grid.tiles;
    let within = tile % of_face;
    let cell = 2u * cell_number(grid, tile / of_face, 0u, vec2<u32>(within % grid.tiles, within / grid.tiles));
    return vec2<u32>(masks[cell], masks[cell + 1u]);
}

// Bytes of eight children.
struct Box {
    low_x: vec2<u32>,
    high_x: vec2<u32>,
    low_y: vec2<u32>,
    high_y: vec2<u32>,
    low_w: vec2<u32>,
    high_w: vec2<u32>,
}

// Of no child: its least is above its greatest, so that no ray meets it.
fn no_boxes() -> Box {
    let none = vec2<u32>(0u);
    let all = vec2<u32>(0xffffffffu);
    return Box(all, none, all, none, all, none);
}

// The bytes with another one of a child.
fn with_byte(bytes: vec2<u32>, child: u32, byte: u32) -> vec2<u32> {
    let shift = (child & 3u) * 8u;
    let changed = (bytes & vec2<u32>(~(0xffu << shift))) | vec2<u32>(byte << shift);
    return select(vec2<u32>(changed.x, bytes.y), vec2<u32>(bytes.x, changed.y), child >= 4u);
}

fn store_node(node: u32, box: Box) {
    if (node < grid.node_capacity) {
        nodes[3u * node] = vec4<u32>(box.low_x, box.high_x);
        nodes[3u * node + 1u] = vec4<u32>(box.low_y, box.high_y);
        nodes[3u * node + 2u] = vec4<u32>(box.low_w, box.high_w);
    }
}

// Of this workgroup: places where the parts of a last node begin.
var<workgroup> leaf_count: atomic<u32>;
var<workgroup> leaf_places: array<u32, WORKGROUP_SIZE>;

// The last nodes of every tile, eight parts each. One place in eight begins a node: these are gathered first, so that lanes that run
// together all make one.
@compute @workgroup_size(WORKGROUP_SIZE)
fn leaves(invocation: Invocation) {
    let place = linear_invocation(invocation, WORKGROUP_SIZE);
    if (place < grid.part_capacity) {
        let code = tile_code(place);
        if (code > 0u && ((place - quads[4u * max(code, 1u) - 4u]) & 7u) == 0u) {
            leaf_places[atomicAdd(&leaf_count, 1u)] = place;
        }
    }
    workgroupBarrier();
    if (invocation.local < atomicLoad(&leaf_count)) {
        make_leaf(leaf_places[invocation.local]);
    }
}

// The last node whose parts begin at a place. Depth codes are integers by integers: rounded down and up, nothing is lost.
fn make_leaf(place: u32) {
    let tile = tile_code(place) - 1u;
    let within = place - quads[4u * tile];
    let parts_here = quads[4u * tile + 1u];
    let scale = quads[4u * tile + 3u];
    let base = depth_base(scale);
    let step = max(depth_step(scale), 1u);
    var boxes = no_boxes();
    for (var child = 0u; child < min(parts_here - within, 8u); child++) {
        let part = parts[places[place + child]];
        boxes.low_x = with_byte(boxes.low_x, child, part.x & 0xffu);
        boxes.high_x = with_byte(boxes.high_x, child, (part.x >> 8u) & 0xffu);
        boxes.low_y = with_byte(boxes.low_y, child, (part.x >> 16u) & 0xffu);
        boxes.high_y = with_byte(boxes.high_y, child, part.x >> 24u);
        boxes.low_w = with_byte(boxes.low_w, child, min((part.y - base) / step, 255u));
        boxes.high_w = with_byte(boxes.high_w, child, min((part.z - base + step - 1u) / step, 255u));
    }
    store_node(node_counts[tile] + first_leaf_of(parts_here) + (within >> 3u), boxes);
}

// Least and greatest of eight bytes.
fn min_byte(bytes: vec2<u32>) -> u32 {
    let least = min(unpack4xU8(bytes.x), unpack4xU8(bytes.y));
    return min(min(least.x, least.y), min(least.z, least.w));
}

fn max_byte(bytes: vec2<u32>) -> u32 {
    let greatest = max(unpack4xU8(bytes.x), unpack4xU8(bytes.y));
    return max(max(greatest.x, greatest.y), max(greatest.z, greatest.w));
}

// The boxes with that round all boxes of a node, as one of its parent's children. All nodes of a tile have one grid.
fn with_node(boxes: Box, child: u32, node: u32) -> Box {
    let x = nodes[3u * node];
    let y = nodes[3u * node + 1u];
    let w = nodes[3u * node + 2u];
    return Box(
        with_byte(boxes.low_x, child, min_byte(x.xy)),
        with_byte(boxes.high_x, child, max_byte(x.zw)),
        with_byte(boxes.low_y, child, min_byte(y.xy)),
        with_byte(boxes.high_y, child, max_byte(y.zw)),
        with_byte(boxes.low_w, child, min_byte(w.xy)),
        with_byte(boxes.high_w, child, max_byte(w.zw)),
    );
}

// The other nodes of a tile from the last one up: children come behind their parents. A lane a tile, so nothing need be waited for; and
// a round a node, whose children are not gone over by a loop of their own, since drivers count rounds.
@compute @workgroup_size(WORKGROUP_SIZE)
fn join(invocation: Invocation) {
    let tile = linear_invocation(invocation, WORKGROUP_SIZE);
    if (tile >= tile_count()) {
        return;
    }
    let first = node_counts[tile];
    quads[4u * tile + 2u] = first;
#ifndef SLICES
    let parts_here = quads[4u * tile + 1u];
    let count = node_count_of(parts_here);
    if (count == 0u || first + count > grid.node_capacity) {
        return;
    }
    for (var left = first_leaf_of(parts_here); left > 0u; left--) {
        let node = left - 1u;
        let child = 8u * node + 1u;
        var boxes = no_boxes();
        if (child < count) {
            boxes = with_node(boxes, 0u, first + child);
        }
        if (child + 1u < count) {
            boxes = with_node(boxes, 1u, first + child + 1u);
        }
        if (child + 2u < count) {
            boxes = with_node(boxes, 2u, first + child + 2u);
        }
        if (child + 3u < count) {
            boxes = with_node(boxes, 3u, first + child + 3u);
        }
        if (child + 4u < count) {
            boxes = with_node(boxes, 4u, first + child + 4u);
        }
        if (child + 5u < count) {
            boxes = with_node(boxes, 5u, first + child + 5u);
        }
        if (child + 6u < count) {
            boxes = with_node(boxes, 6u, first + child + 6u);
        }
        if (child + 7u < count) {
            boxes = with_node(boxes, 7u, first + child + 7u);
        }
        store_node(first + node, boxes);
    }
#endif
}

// Where the lists of a tile's slices begin: in the order of slices, those that its mask has.
@compute @workgroup_size(WORKGROUP_SIZE)
fn list(invocation: Invocation) {
    let place = linear_invocation(invocation, WORKGROUP_SIZE);
    if (place >= grid.part_capacity) {
        return;
    }
    let key = keys[place];
    if (key == 0u || (place > 0u && keys[max(place, 1u) - 1u] == key)) {
        return;
    }
    let tile = (key >> grid.order_bits) - 1u;
    let slice = key & ((1u << grid.order_bits) - 1u);
    let before = mask_of_tile(tile) & lowest_bits(slice);
    let index = node_counts[tile] + countOneBits(before.x) + countOneBits(before.y);
    if (index < grid.node_capacity) {
        lists[index] = place;
    }
}

// The masks' pyramid: a cell has what any of the four below it has.
@compute @workgroup_size(WORKGROUP_SIZE)
fn join_masks(invocation: Invocation) {
    let cells = level_size(vec2<u32>(grid.tiles), made.level);
    let index = linear_invocation(invocation, WORKGROUP_SIZE);
    let face = index / (cells.x * cells.y);
    if (face >= made.views) {
        return;
    }
    let within = index % (cells.x * cells.y);
    let cell = vec2<u32>(within % cells.x, within / cells.x);
    var mask = vec2<u32>(0u);
    for (var child = 0u; child < 4u; child++) {
        let below = 2u * cell_number(grid, face, made.level - 1u, cell_below(vec2<u32>(grid.tiles), made.level, cell, child));
        mask |= vec2<u32>(masks[below], masks[below + 1u]);
    }
    let number = 2u * cell_number(grid, face, made.level, cell);
    masks[number] = mask.x;
    masks[number + 1u] = mask.y;
}
