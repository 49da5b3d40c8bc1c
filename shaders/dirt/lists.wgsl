#define_import_path tracebench::dirt_lists

// What the trace reads of the structure: depth bounds, heads of lists, nodes, corners of triangles.

#import tracebench::depth_bounds::depths_of
#import tracebench::dirt_grid::{TileGrid, Node, bounds_index, head_index}
#import tracebench::reads::{quad_0, pair_0, pair_1, word_0}

@group(0) @binding(0) var<uniform> grid: TileGrid;
#ifdef SPLIT
// Where one binding does not hold all, by views and by parts: depth bounds and heads of the views one after the other, nodes.
@group(0) @binding(4) var<storage, read> bounds: array<vec2<u32>>;
@group(0) @binding(5) var<storage, read> heads: array<u32>;
@group(0) @binding(6) var<storage, read> nodes: array<Node>;
@group(2) @binding(0) var<storage, read> bounds_1: array<vec2<u32>>;
@group(2) @binding(1) var<storage, read> bounds_2: array<vec2<u32>>;
@group(2) @binding(2) var<storage, read> bounds_3: array<vec2<u32>>;
@group(2) @binding(3) var<storage, read> bounds_4: array<vec2<u32>>;
@group(2) @binding(4) var<storage, read> bounds_5: array<vec2<u32>>;
@group(2) @binding(5) var<storage, read> heads_1: array<u32>;
@group(2) @binding(6) var<storage, read> heads_2: array<u32>;
@group(2) @binding(7) var<storage, read> heads_3: array<u32>;
@group(2) @binding(8) var<storage, read> heads_4: array<u32>;
@group(2) @binding(9) var<storage, read> heads_5: array<u32>;
@group(2) @binding(10) var<storage, read> nodes_1: array<Node>;
@group(2) @binding(11) var<storage, read> nodes_2: array<Node>;
@group(2) @binding(12) var<storage, read> nodes_3: array<Node>;
@group(2) @binding(13) var<storage, read> nodes_4: array<Node>;
@group(2) @binding(14) var<storage, read> nodes_5: array<Node>;
@group(2) @binding(15) var<storage, read> nodes_6: array<Node>;
@group(2) @binding(16) var<storage, read> nodes_7: array<Node>;
#endif

fn load_node(index: u32) -> Node {
#ifdef SPLIT
    let within = index % grid.nodes_per_part;
    switch (index / grid.nodes_per_part) {
        case 0u: {
            return nodes[within];
        }
        case 1u: {
            return nodes_1[within];
        }
        case 2u: {
            return nodes_2[within];
        }
        case 3u: {
            return nodes_3[within];
        }
        case 4u: {
            return nodes_4[within];
        }
        case 5u: {
            return nodes_5[within];
        }
        case 6u: {
            return nodes_6[within];
        }
        default: {
            return nodes_7[within];
        }
    }
#else
    let node = pair_0(index);
    return Node(node.x, node.y);
#endif
}

// The depth bounds of a cell.
fn load_depths(view: u32, level: u32, cell: vec2<u32>) -> vec2<f32> {
    let offset = grid.level_offsets[level >> 2u][level & 3u];
#ifdef SPLIT
    return depths_of(load_codes(view, bounds_index(grid, offset, 0u, level, cell)));
#else
    return depths_of(pair_1(bounds_index(grid, offset, view, level, cell)));
#endif
}

#ifdef SPLIT
fn load_codes(view: u32, within: u32) -> vec2<u32> {
    switch (view) {
        case 0u: {
            return bounds[within];
        }
        case 1u: {
            return bounds_1[within];
        }
        case 2u: {
            return bounds_2[within];
        }
        case 3u: {
            return bounds_3[within];
        }
        case 4u: {
            return bounds_4[within];
        }
        default: {
            return bounds_5[within];
        }
    }
}
#endif

// The first link of a list.
fn load_head(view: u32, tile: vec2<u32>, bucket: u32) -> u32 {
#ifdef SPLIT
    let within = head_index(grid, 0u, tile, bucket);
    switch (view) {
        case 0u: {
            return heads[within];
        }
        case 1u: {
            return heads_1[within];
        }
        case 2u: {
            return heads_2[within];
        }
        case 3u: {
            return heads_3[within];
        }
        case 4u: {
            return heads_4[within];
        }
        default: {
            return heads_5[within];
        }
    }
#else
    return word_0(head_index(grid, view, tile, bucket));
#endif
}

struct Corners {
    a: vec3<f32>,
    b: vec3<f32>,
    c: vec3<f32>,
}

// The corners of a triangle: nine floats in a row of the vertex buffer, which begin at any word of three quads.
fn load_corners(triangle: u32) -> Corners {
    let first = triangle * 9u;
    let quad = first >> 2u;
    let p = bitcast<vec4<f32>>(quad_0(quad));
    let q = bitcast<vec4<f32>>(quad_0(quad + 1u));
    let r = bitcast<vec4<f32>>(quad_0(quad + 2u));
    switch (first & 3u) {
        case 0u: {
            return Corners(p.xyz, vec3<f32>(p.w, q.xy), vec3<f32>(q.zw, r.x));
        }
        case 1u: {
            return Corners(p.yzw, q.xyz, vec3<f32>(q.w, r.xy));
        }
        case 2u: {
            return Corners(vec3<f32>(p.zw, q.x), q.yzw, r.xyz);
        }
        default: {
            return Corners(vec3<f32>(p.w, q.xy), vec3<f32>(q.zw, r.x), r.yzw);
        }
    }
}
