// DIRT's fetch pass (section 4.2.2): the scene is drawn into every view, and where a triangle covers a pixel whose list
// holds hits on it, their surfaces are written to the shading buffer.

#import tracebench::types::{Surface, NO_PRIMITIVE}
#import tracebench::view::{View, to_eye_space, clip_position}
#import tracebench::surface::surface_at
#import tracebench::dirt_hit_buffer::{HitNode, shading_of, view_of}
#import tracebench::dirt_drawn::{DrawnTriangles, NOTHING_DRAWN}
#import tracebench::dirt_vertices::corner_of
#import tracebench::tile_clip::{tile_margin, tile_frustum, polygon_range, tile_rectangle, rectangle_corner}

struct FetchPass {
    // The view that is drawn, its size in pixels.
    view: View,
    // Its number, and the first entry of its list of triangles.
    view_index: u32,
    first_entry: u32,
    // Of a view.
    pixels: vec2<u32>,
}

@group(0) @binding(0) var<uniform> drawn: FetchPass;
@group(0) @binding(1) var<storage, read> materials: array<u32>;
@group(0) @binding(3) var<storage, read> listed: DrawnTriangles;
@group(0) @binding(4) var<storage, read> heads: array<u32>;
@group(0) @binding(5) var<storage, read> nodes: array<HitNode>;
@group(0) @binding(6) var<storage, read_write> surfaces: array<Surface>;

// Whether all pixels that a triangle touches are its own.
override CONSERVATIVE: bool;

struct Corner {
    @builtin(position) position: vec4<f32>,
    @location(0) @interpolate(flat) triangle: u32,
}

// A triangle that may be seen in the view, or none: what touches a pixel touches its tile.
fn drawn_triangle(number: u32) -> u32 {
    if (number >= listed.counts[drawn.view_index]) {
        return NO_PRIMITIVE;
    }
    return listed.entries[drawn.first_entry + number].triangle;
}

// Two triangles a triangle: the rectangle of pixels that it may touch; or one of the pixels whose centres it covers, by the rasterizer's
// own rule.
@vertex
fn vertex(@builtin(vertex_index) index: u32) -> Corner {
    let triangle = drawn_triangle(index / select(3u, 6u, CONSERVATIVE));
    if (triangle == NO_PRIMITIVE) {
        return Corner(NOTHING_DRAWN, 0u);
    }
    if (!CONSERVATIVE) {
        return Corner(clip_position(drawn.view, to_eye_space(drawn.view, corner_of(triangle, index % 3u))), triangle);
    }
    let a = to_eye_space(drawn.view, corner_of(triangle, 0u));
    let b = to_eye_space(drawn.view, corner_of(triangle, 1u));
    let c = to_eye_space(drawn.view, corner_of(triangle, 2u));
    let rectangle = tile_rectangle(drawn.view, drawn.pixels, a, b, c);
    return Corner(rectangle_corner(rectangle, drawn.pixels, index), triangle);
}

// Whether a triangle covers a pixel.
fn covers(triangle: u32, pixel: vec2<u32>) -> bool {
    if (!CONSERVATIVE) {
        return true;
    }
    let frustum = tile_frustum(drawn.view, pixel, tile_margin(drawn.view.size));
    let a = to_eye_space(drawn.view, corner_of(triangle, 0u));
    let b = to_eye_space(drawn.view, corner_of(triangle, 1u));
    let c = to_eye_space(drawn.view, corner_of(triangle, 2u));
    let range = polygon_range(frustum, a, b, c);
    return range.least <= range.greatest;
}

// Whether a hit is one on the triangle that is drawn: with conservative coverage any hit on it, in whatever view it was found;
// without, a hit that this view's own pixel holds (section 4.2.4).
fn is_sought(node: HitNode, triangle: u32) -> bool {
    return node.primitive == triangle && (CONSERVATIVE || view_of(node) == drawn.view_index);
}

@fragment
fn fragment(in: Corner) {
    let pixel = vec2<u32>(in.position.xy);
    if (any(pixel >= drawn.pixels)) {
        return;
    }
    var link = heads[pixel.y * drawn.pixels.x + pixel.x];
    var decided = false;
    while (link != 0u) {
        let node = nodes[link - 1u];
        link = node.next;
        if (is_sought(node, in.triangle)) {
            // Most pixels' lists are short and most triangles in none of them: coverage is asked for last.
            if (!decided && !covers(in.triangle, pixel)) {
                return;
            }
            decided = true;
            surfaces[shading_of(node)] = surface_at(
                corner_of(in.triangle, 0u), corner_of(in.triangle, 1u), corner_of(in.triangle, 2u),
                node.u, node.v, materials[in.triangle],
            );
        }
    }
}
