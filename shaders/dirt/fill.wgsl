// The two geometry passes of DIRT (sections 4.1.1 and 4.1.2): every triangle's part in every tile that it covers, first
// into the tile's depth bounds, then into the lists of the buckets that the part's depths overlap. In compute (`draw`) without the
// rasterizer: what a triangle touches is found the same, bit for bit; which centres it covers by the rule of tracebench::coverage.

#import tracebench::view::{View, to_eye_space, clip_position}
#import tracebench::tile_clip::{DepthRange, TileFrustum, TileRectangle, tile_margin, tile_frustum, polygon_range, plane_range, joined, rectangle_corner}
#import tracebench::depth_bounds::{near_code, far_code, depths_of, bucket_of}
#import tracebench::dirt_grid::{TileGrid, Node, bounds_index, head_index}
#import tracebench::dirt_drawn::{DrawnTriangles, NOTHING_DRAWN}
#import tracebench::dirt_vertices::corner_of
#import tracebench::dispatch::Invocation
#import tracebench::raster_work::{RasterPart, part_of}
#import tracebench::tile_clip::{tile_rectangle, tiles_frustum}
#import tracebench::coverage::{outline_in_view, rows_of_outline, span_of_row}

struct FillPass {
    view: View,
    // 1: depths by the triangle's plane.
    by_plane: u32,
    // The view's number, and the first entry of its list of triangles.
    view_index: u32,
    first_entry: u32,
    padding: u32,
}

@group(0) @binding(0) var<uniform> grid: TileGrid;
@group(0) @binding(1) var<uniform> drawn: FillPass;
// Of the rasterizer alone.
@group(0) @binding(3) var<storage, read> listed: DrawnTriangles;
// Of depth bounds and heads, the drawn view's part.
#ifdef PRIMITIVES
@group(0) @binding(4) var<storage, read> bounds: array<vec2<u32>>;
@group(0) @binding(5) var<storage, read_write> heads: array<atomic<u32>>;
@group(0) @binding(6) var<storage, read_write> nodes: array<Node>;
// Nodes taken.
@group(0) @binding(7) var<storage, read_write> taken: array<atomic<u32>>;
#ifdef COUNTERS
// Parts stored, and additions to the nodes taken.
@group(0) @binding(8) var<storage, read_write> counted: array<atomic<u32>>;
#endif
#ifdef SPLIT
// Further nodes, where one binding does not hold all.
@group(0) @binding(8) var<storage, read_write> nodes_1: array<Node>;
@group(0) @binding(9) var<storage, read_write> nodes_2: array<Node>;
@group(0) @binding(10) var<storage, read_write> nodes_3: array<Node>;
@group(0) @binding(11) var<storage, read_write> nodes_4: array<Node>;
@group(0) @binding(12) var<storage, read_write> nodes_5: array<Node>;
@group(0) @binding(13) var<storage, read_write> nodes_6: array<Node>;
@group(0) @binding(14) var<storage, read_write> nodes_7: array<Node>;
#endif
#else
@group(0) @binding(4) var<storage, read_write> bounds: array<atomic<u32>>;
#endif

// Whether all tiles that a triangle touches are its own, or those whose centres it covers.
override CONSERVATIVE: bool;

// More nodes than any device holds, and far enough from 2^32 for what runs at the same time.
const MAX_NODES: u32 = 0xf0000000u;

// A relative slack of depths: what clipping in f32 may be off by.
const DEPTH_SLACK: f32 = 9.5367431640625e-7;

fn eye_point(triangle: u32, corner: u32) -> vec3<f32> {
    return to_eye_space(drawn.view, corner_of(triangle, corner));
}

#ifdef PRIMITIVES
// Takes nodes in a row, one addition for all copies of a part, and gives the first.
fn take_nodes(count: u32) -> u32 {
    let first = atomicAdd(&taken[0], count);
#ifdef COUNTERS
    atomicAdd(&counted[1], 1u);
#endif
    // Where further counts could wrap they are taken back.
    if (first >= MAX_NODES) {
        atomicSub(&taken[0], count);
        return MAX_NODES;
    }
    return first;
}

fn store_node(index: u32, node: Node) {
#ifdef SPLIT
    let within = index % grid.nodes_per_part;
    switch (index / grid.nodes_per_part) {
        case 0u: {
            nodes[within] = node;
        }
        case 1u: {
            nodes_1[within] = node;
        }
        case 2u: {
            nodes_2[within] = node;
        }
        case 3u: {
            nodes_3[within] = node;
        }
        case 4u: {
            nodes_4[within] = node;
        }
        case 5u: {
            nodes_5[within] = node;
        }
        case 6u: {
            nodes_6[within] = node;
        }
        default: {
            nodes_7[within] = node;
        }
    }
#else
    nodes[index] = node;
#endif
}
#endif

// A triangle's part in a tile.
fn put_part(tile: vec2<u32>, triangle: u32) {
    let a = eye_point(triangle, 0u);
    let b = eye_point(triangle, 1u);
    let c = eye_point(triangle, 2u);
    let frustum = tile_frustum(drawn.view, tile, tile_margin(drawn.view.size));
    var range = polygon_range(frustum, a, b, c);
    if (range.least > range.greatest || any(tile >= grid.tiles)) {
        return;
    }
    if (drawn.by_plane == 1u) {
        // Never less than the polygon's: of a plane through the view's centre the corner lines tell nothing.
        range = joined(range, plane_range(frustum, a, b, c));
    }
    let least = range.least * (1.0 - DEPTH_SLACK);
    let greatest = range.greatest * (1.0 + DEPTH_SLACK);
    let index = bounds_index(grid, grid.level_offsets[0].x, 0u, 0u, tile);
#ifdef PRIMITIVES
    let depths = depths_of(bounds[index]);
    let first = bucket_of(least, depths, grid.buckets);
    let last = bucket_of(greatest, depths, grid.buckets);
#ifdef COUNTERS
    atomicAdd(&counted[0], 1u);
#endif
    let first_node = take_nodes(last - first + 1u);
    for (var bucket = first; bucket <= last; bucket++) {
        // Beyond the capacity nothing is stored and the count goes on: the host sees what is missing.
        let node = first_node + bucket - first;
        if (node < grid.node_capacity) {
            let head = head_index(grid, 0u, tile, bucket);
            store_node(node, Node(atomicExchange(&heads[head], node + 1u), triangle));
        }
    }
#else
    atomicMax(&bounds[2u * index], near_code(least));
    atomicMax(&bounds[2u * index + 1u], far_code(greatest));
#endif
}

const WORKGROUP_SIZE: u32 = 64u;

// Rows with fewer tiles are not asked whether the triangle touches them.
const SHORT_ROW: i32 = 4;

fn put_touched(part: RasterPart) {
    let a = eye_point(part.triangle, 0u);
    let b = eye_point(part.triangle, 1u);
    let c = eye_point(part.triangle, 2u);
    let touched = tile_rectangle(drawn.view, grid.tiles, a, b, c);
    let low = max(vec2<i32>(touched.first), part.low);
    let high = min(vec2<i32>(touched.last), part.high);
    for (var row = low.y; row < high.y; row++) {
        if (high.x - low.x > SHORT_ROW) {
            let frustum = tiles_frustum(drawn.view, vec2<i32>(low.x, row), vec2<i32>(high.x, row + 1));
            let range = polygon_range(frustum, a, b, c);
            if (range.least > range.greatest) {
                continue;
            }
        }
        for (var column = low.x; column < high.x; column++) {
            put_part(vec2<u32>(vec2<i32>(column, row)), part.triangle);
        }
    }
}

fn put_covered(part: RasterPart) {
    let a = corner_of(part.triangle, 0u);
    let b = corner_of(part.triangle, 1u);
    let c = corner_of(part.triangle, 2u);
    if (!outline_in_view(drawn.view, a, b, c)) {
        return;
    }
    let rows = rows_of_outline();
    for (var row = max(rows.x, part.low.y); row < min(rows.y, part.high.y); row++) {
        let span = span_of_row(row);
        for (var column = max(span.x, part.low.x); column < min(span.y, part.high.x); column++) {
            put_part(vec2<u32>(vec2<i32>(column, row)), part.triangle);
        }
    }
}

@compute @workgroup_size(WORKGROUP_SIZE)
fn draw(invocation: Invocation) {
    let part = part_of(invocation);
    if (all(part.low < part.high)) {
        if (CONSERVATIVE) {
            put_touched(part);
        } else {
            put_covered(part);
        }
    }
}

struct Corner {
    @builtin(position) position: vec4<f32>,
    @location(0) @interpolate(flat) triangle: u32,
}

fn unpacked(tile: u32) -> vec2<f32> {
    return vec2<f32>(vec2<u32>(tile & 0xffffu, tile >> 16u));
}

// Two triangles a triangle: the rectangle of tiles that it may touch; or one of the tiles whose centres it covers, by the rasterizer's own
// rule.
@vertex
fn vertex(@builtin(vertex_index) index: u32) -> Corner {
    let number = index / select(3u, 6u, CONSERVATIVE);
    if (number >= listed.counts[drawn.view_index]) {
        return Corner(NOTHING_DRAWN, 0u);
    }
    let entry = listed.entries[drawn.first_entry + number];
    if (CONSERVATIVE) {
        let rectangle = TileRectangle(unpacked(entry.first), unpacked(entry.last));
        return Corner(rectangle_corner(rectangle, grid.tiles, index), entry.triangle);
    }
    let position = clip_position(drawn.view, eye_point(entry.triangle, index % 3u));
    // The last column and row of tiles may reach beyond the view, and the attachment with them.
    let scale = drawn.view.size / vec2<f32>(grid.tiles);
    let x = (position.x + position.w) * scale.x - position.w;
    let y = position.w - (position.w - position.y) * scale.y;
    return Corner(vec4<f32>(x, y, position.zw), entry.triangle);
}

@fragment
fn fragment(in: Corner) -> @location(0) vec4<f32> {
    put_part(vec2<u32>(in.position.xy), in.triangle);
    return vec4<f32>(0.0);
}
