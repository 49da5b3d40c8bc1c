// The geometry passes of the fragment A-buffer (section 3.3), by the rasterizer's own sample rule: the depth bounds of every
// pixel; of the s-buffer the number of its fragments; the fragments themselves. In compute (`draw`) by the rule of tracebench::coverage.
// With CLIPPED of triangles as they are clipped to pixels: fragments that are planes, or that all have which a triangle touches, or both.

#import tracebench::scene::load_position
#import tracebench::view::{to_eye_space, clip_position}
#import tracebench::plane_depth::{FlatTriangle, flat_triangle, plane_depth}
#ifdef CLIPPED
#import tracebench::plane_depth::{facet, size_of}
#import tracebench::tile_clip::{DepthRange, tile_margin, tile_frustum, polygon_range, tile_rectangle}
#import tracebench::tile_clip::{tiles_frustum, rectangle_corner}
#else
#import tracebench::surface::unit_normal
#endif
#import tracebench::depth_bounds::{near_code, far_code, depths_of, bucket_of}
#import tracebench::fragment_layout::{Storage, RasterizedView, word_index, BOUNDS_SLACK}
#ifdef CLIPPED
#ifdef STORE
#import tracebench::tile_clip::{TileRectangle, include_edge}
#import tracebench::fragment_layout::{OUTLINE_PARTS, WHOLE_OUTLINE, has_outline}
#endif
#endif
#import tracebench::dispatch::Invocation
#import tracebench::coverage::{outline_in_view, rows_of_outline, span_of_row}
#import tracebench::raster_work::part_of

@group(0) @binding(0) var<uniform> shape: Storage;
@group(0) @binding(3) var<uniform> drawn: RasterizedView;
@group(0) @binding(4) var<storage, read_write> pixels: array<atomic<u32>>;
#ifndef BOUNDS
// Fragments, lists that could not be ordered.
@group(0) @binding(5) var<storage, read_write> taken: array<atomic<u32>>;
#endif
#ifdef STORE
@group(0) @binding(6) var<storage, read_write> ids: array<u32>;
#ifdef DECOUPLED
@group(0) @binding(7) var<storage, read_write> payloads: array<u32>;
#endif
@group(0) @binding(8) var<storage, read> materials: array<u32>;
#endif

// A triangle as its fragments need it, the same at all of them.
struct Facing {
    plane: FlatTriangle,
#ifdef CLIPPED
    // The corners in eye space.
    a: vec3<f32>,
    b: vec3<f32>,
    c: vec3<f32>,
    // 0 of a triangle without area, which conservative coverage leaves out.
    normal: vec3<f32>,
    // How far the plane lies from the eye along the normal.
    offset: f32,
#endif
#ifdef STORE
#ifndef CLIPPED
    normal: vec3<f32>,
#endif
    material: u32,
#endif
}

// By its first of three corners.
fn facing_of(first: u32) -> Facing {
    let a = load_position(first);
    let b = load_position(first + 1u);
    let c = load_position(first + 2u);
    var facing: Facing;
    facing.plane = flat_triangle(drawn.view, a, b, c);
#ifdef CLIPPED
    facing.a = to_eye_space(drawn.view, a);
    facing.b = to_eye_space(drawn.view, b);
    facing.c = to_eye_space(drawn.view, c);
    let plane = facet(a, b, c);
    let size = max(abs(plane.across.x), max(abs(plane.across.y), abs(plane.across.z)));
    // Of equal corners it is no number.
    if (size > 0.0) {
        facing.normal = normalize(plane.across / size);
        facing.offset = dot(facing.normal, plane.at - drawn.view.eye);
    }
#endif
#ifdef STORE
#ifndef CLIPPED
    facing.normal = unit_normal(b - a, c - a);
#endif
    facing.material = materials[first / 3u];
#endif
    return facing;
}

#ifdef CLIPPED
// By how much depths are held apart that clipping in f32 may be off by, relative.
const DEPTH_SLACK: f32 = 9.5367431640625e-7;

// The eye depths of a triangle in a pixel, grown by what f32 loses of borders; least > greatest where it has no fragment there.
fn depths_in(pixel: vec2<u32>, facing: Facing) -> DepthRange {
    let frustum = tile_frustum(drawn.view, pixel, tile_margin(drawn.view.size));
    var range = polygon_range(frustum, facing.a, facing.b, facing.c);
    if (shape.conservative == 1u) {
        return range;
    }
    if (range.least > range.greatest) {
        // The rule of coverage rounds corners: what covers a centre by it may touch no part of the pixel.
        let depth = plane_depth(drawn.view, facing.plane, vec2<f32>(pixel) + 0.5);
        range = DepthRange(depth, depth);
    }
    return range;
}
#endif

#ifdef STORE
fn store_payload(at: u32, normal: vec3<f32>, material: u32) {
    let words = vec4<u32>(bitcast<vec3<u32>>(normal), material);
    for (var word = 0u; word < 4u; word++) {
#ifdef DECOUPLED
        payloads[at + word] = words[word];
#else
        ids[at + word] = words[word];
#endif
    }
}

#ifdef CLIPPED
// By how much parts of a pixel are grown on every side where an outline is asked whether it touches them, pixels: a hit's place is a sum
// of coordinates that may be far larger than it.
const OUTLINE_MARGIN: f32 = 0.015625;

// What f32 loses of a product of two coordinates, relative to their sizes.
const PRODUCT_LOSS: f32 = 4.76837158e-7;

// The greater of both along x and along y, added.
fn max_of_pair(a: vec2<f32>, b: vec2<f32>) -> f32 {
    let max_second_if_nan = max(a, b);
    return max_second_if_nan.x + max_second_if_nan.y;
}

// The parts of a pixel that a triangle touches, as bits, and by rounding some more: those that lie on the inner sides of its three edges,
// in front of the eye or behind it, and within the rectangle about it.
fn outline_in(pixel: vec2<u32>, facing: Facing) -> u32 {
    let view = drawn.view;
    let parts = vec2<f32>(OUTLINE_PARTS);
    let frustum = tile_frustum(view, pixel, 0.0);
    let part = (frustum.high - frustum.low) / parts;
    let half = part * 0.5 + (frustum.high - frustum.low) * OUTLINE_MARGIN;
    let sides = array<vec3<f32>, 3>(
        cross(facing.b, facing.c - facing.b), cross(facing.c, facing.a - facing.c), cross(facing.a, facing.b - facing.a),
    );
    let losses = PRODUCT_LOSS * vec3<f32>(
        size_of(facing.b) * size_of(facing.c - facing.b),
        size_of(facing.c) * size_of(facing.a - facing.c),
        size_of(facing.a) * size_of(facing.b - facing.a),
    );
    // A side is a sum over three components, each off by its loss times how far the pixel lies across, upward, and along.
    let reach = 1.0 + max_of_pair(abs(frustum.low), abs(frustum.high));
    var before = WHOLE_OUTLINE;
    var behind = WHOLE_OUTLINE;
    for (var edge = 0u; edge < 3u; edge++) {
        let side = sides[edge];
        let room = dot(abs(side.xy), half) + reach * losses[edge];
        // At the middle of the upper left part.
        let first = dot(side, vec3<f32>(frustum.low.x + 0.5 * part.x, frustum.high.y - 0.5 * part.y, 1.0));
        let along = side.xy * part;
        var bit = 1u;
        for (var row = 0u; row < OUTLINE_PARTS.y; row++) {
            for (var column = 0u; column < OUTLINE_PARTS.x; column++) {
                let at = first + along.x * f32(column) - along.y * f32(row);
                before &= select(WHOLE_OUTLINE, ~bit, (at < -room));
                behind &= select(WHOLE_OUTLINE, ~bit, (at > room));
                bit <<= 1u;
            }
        }
    }
    var rectangle = TileRectangle(vec2<f32>(1e30), vec2<f32>(-1e30));
    rectangle = include_edge(rectangle, view, facing.a, facing.b);
    rectangle = include_edge(rectangle, view, facing.b, facing.c);
    rectangle = include_edge(rectangle, view, facing.c, facing.a);
    let low = floor((rectangle.first - OUTLINE_MARGIN - vec2<f32>(pixel)) * parts);
    let high = floor((rectangle.last + OUTLINE_MARGIN - vec2<f32>(pixel)) * parts);
    var within = 0u;
    var bit = 1u;
    for (var row = 0u; row < OUTLINE_PARTS.y; row++) {
        for (var column = 0u; column < OUTLINE_PARTS.x; column++) {
            let at = vec2<f32>(vec2<u32>(column, row));
            within |= select(0u, bit, all(at >= low) && all(at <= high));
            bit <<= 1u;
        }
    }
    let outline = (before | behind) & within;
    // Of one that rounding leaves nothing of nothing is known.
    return select(outline, WHOLE_OUTLINE, (outline == 0u));
}

fn store_plane(node: u32, place: vec2<u32>, greatest: f32, facing: Facing) {
    let at = node * shape.node_words + shape.plane_word;
    ids[at] = bitcast<u32>(greatest);
    ids[at + 1u] = bitcast<u32>(facing.offset);
    if (has_outline(shape)) {
        ids[at + 2u] = outline_in(place, facing);
    }
    for (var axis = 0u; axis < 3u; axis++) {
        ids[node * shape.node_words + shape.normal_word + axis] = bitcast<u32>(facing.normal[axis]);
    }
}
#endif

fn store_fragment(pixel: u32, place: vec2<u32>, depth: f32, greatest: f32, facing: Facing) {
    // Beyond the capacity nothing is stored and the count goes on: the host sees what is missing.
    if (shape.contiguous == 1u) {
        let begin = atomicLoad(&pixels[word_index(shape, pixel, 0u)]);
        let slot = begin + atomicAdd(&pixels[word_index(shape, pixel, 1u)], 1u);
        if (slot < shape.node_capacity) {
#ifdef CLIPPED
            if (shape.plane_word > 0u) {
                store_plane(slot, place, greatest, facing);
            }
#endif
            ids[slot * shape.node_words] = bitcast<u32>(depth);
#ifdef DECOUPLED
            ids[slot * shape.node_words + 1u] = slot;
#endif
            store_payload(slot * shape.data_words + shape.data_offset, facing.normal, facing.material);
        }
        return;
    }
    let node = atomicAdd(&taken[0], 1u);
    if (node < shape.node_capacity) {
        var bucket = 0u;
        if (shape.buckets > 1u) {
            let near = atomicLoad(&pixels[word_index(shape, pixel, shape.bounds_word)]);
            let far = atomicLoad(&pixels[word_index(shape, pixel, shape.bounds_word + 1u)]);
            bucket = bucket_of(depth, depths_of(vec2<u32>(near, far)), shape.buckets);
        }
        let link = atomicExchange(&pixels[word_index(shape, pixel, bucket)], node + 1u);
        ids[node * shape.node_words] = bitcast<u32>(depth);
        ids[node * shape.node_words + 1u] = link;
#ifdef CLIPPED
        if (shape.plane_word > 0u) {
            store_plane(node, place, greatest, facing);
        }
#endif
        store_payload(node * shape.data_words + shape.data_offset, facing.normal, facing.material);
    }
}
#endif

// What a pass does with a fragment, by its pixel's centre.
fn put_fragment(centre: vec2<f32>, facing: Facing) {
    let at = vec2<u32>(centre);
#ifdef CLIPPED
    let range = depths_in(at, facing);
    if (range.least > range.greatest || (shape.conservative == 1u && all(facing.normal == vec3<f32>(0.0)))) {
        return;
    }
#endif
#ifdef TALLY
    // How many fragments a view has, before there is room for any.
    atomicAdd(&taken[0], 1u);
#else
    let pixel = drawn.first_pixel + at.y * drawn.width + at.x;
    var depth = plane_depth(drawn.view, facing.plane, centre);
#ifdef CLIPPED
    // A point is the nearest that the triangle comes to the centre, a plane begins and ends with what is clipped.
    depth = clamp(depth, range.least, range.greatest);
    var greatest = depth;
    if (shape.plane_word > 0u) {
        depth = range.least * (1.0 - DEPTH_SLACK);
        greatest = range.greatest * (1.0 + DEPTH_SLACK);
    }
#else
    var greatest = depth;
#endif
#ifdef BOUNDS
    atomicMax(&pixels[word_index(shape, pixel, shape.bounds_word)], near_code(depth));
    atomicMax(&pixels[word_index(shape, pixel, shape.bounds_word + 1u)], far_code(greatest));
#else
    if (shape.one_layer == 1u) {
        let nearest = bitcast<f32>(~atomicLoad(&pixels[word_index(shape, pixel, shape.bounds_word)]));
        if (depth > nearest * (1.0 + BOUNDS_SLACK)) {
            return;
        }
    }
#endif
#ifdef COUNT
    atomicAdd(&taken[0], 1u);
    atomicAdd(&pixels[word_index(shape, pixel, 0u)], 1u);
#endif
#ifdef STORE
    if (shape.bounds_word > 0u) {
        // Drivers round in each pass as they like, so that a sliver's depth may differ from that in the pass of the bounds.
        let near = atomicLoad(&pixels[word_index(shape, pixel, shape.bounds_word)]);
        let far = atomicLoad(&pixels[word_index(shape, pixel, shape.bounds_word + 1u)]);
        let bounds = depths_of(vec2<u32>(near, far));
        depth = clamp(depth, bounds.x, bounds.y);
        greatest = clamp(greatest, bounds.x, bounds.y);
    }
    store_fragment(pixel, at, depth, greatest, facing);
#endif
#endif
}

const WORKGROUP_SIZE: u32 = 64u;

#ifdef CLIPPED
// Rows with fewer pixels are not asked whether the triangle touches them.
const SHORT_ROW: i32 = 4;

// Every pixel of a part that a triangle touches.
fn put_touched(low: vec2<i32>, high: vec2<i32>, facing: Facing) {
    let touched = tile_rectangle(drawn.view, vec2<u32>(drawn.view.size), facing.a, facing.b, facing.c);
    let first = max(vec2<i32>(touched.first), low);
    let last = min(vec2<i32>(touched.last), high);
    for (var row = first.y; row < last.y; row++) {
        if (last.x - first.x > SHORT_ROW) {
            let frustum = tiles_frustum(drawn.view, vec2<i32>(first.x, row), vec2<i32>(last.x, row + 1));
            let range = polygon_range(frustum, facing.a, facing.b, facing.c);
            if (range.least > range.greatest) {
                continue;
            }
        }
        for (var column = first.x; column < last.x; column++) {
            put_fragment(vec2<f32>(vec2<i32>(column, row)) + 0.5, facing);
        }
    }
}
#endif

@compute @workgroup_size(WORKGROUP_SIZE)
fn draw(invocation: Invocation) {
    let part = part_of(invocation);
    if (any(part.high <= part.low)) {
        return;
    }
    let first = part.triangle * 3u;
#ifdef CLIPPED
    if (shape.conservative == 1u) {
        put_touched(part.low, part.high, facing_of(first));
        return;
    }
#endif
    if (!outline_in_view(drawn.view, load_position(first), load_position(first + 1u), load_position(first + 2u))) {
        return;
    }
    let facing = facing_of(first);
    let rows = rows_of_outline();
    for (var row = max(rows.x, part.low.y); row < min(rows.y, part.high.y); row++) {
        let span = span_of_row(row);
        for (var column = max(span.x, part.low.x); column < min(span.y, part.high.x); column++) {
            put_fragment(vec2<f32>(vec2<i32>(column, row)) + 0.5, facing);
        }
    }
}

struct Corner {
    @builtin(position) position: vec4<f32>,
#ifdef CLIPPED
    @location(0) @interpolate(flat) triangle: u32,
#else
    @location(0) @interpolate(flat) plane: vec4<f32>,
    @location(1) @interpolate(flat) depths: vec2<f32>,
#ifdef STORE
    @location(2) @interpolate(flat) normal: vec3<f32>,
    @location(3) @interpolate(flat) material: u32,
#endif
#endif
}

#ifdef CLIPPED
// A triangle as it is, or the rectangle of pixels that it may touch, of two triangles.
@vertex
fn vertex(@builtin(vertex_index) index: u32) -> Corner {
    if (shape.conservative == 1u) {
        let facing = facing_of(index / 6u * 3u);
        let pixels_across = vec2<u32>(drawn.view.size);
        let rectangle = tile_rectangle(drawn.view, pixels_across, facing.a, facing.b, facing.c);
        return Corner(rectangle_corner(rectangle, pixels_across, index), index / 6u);
    }
    return Corner(clip_position(drawn.view, to_eye_space(drawn.view, load_position(index))), index / 3u);
}

@fragment
fn fragment(in: Corner) -> @location(0) vec4<f32> {
    put_fragment(in.position.xy, facing_of(in.triangle * 3u));
    return vec4<f32>(0.0);
}
#else
@vertex
fn vertex(@builtin(vertex_index) index: u32) -> Corner {
    var corner: Corner;
    corner.position = clip_position(drawn.view, to_eye_space(drawn.view, load_position(index)));
    // A triangle's first corner speaks for it.
    if (index % 3u == 0u) {
        let facing = facing_of(index);
        corner.plane = facing.plane.plane;
        corner.depths = facing.plane.depths;
#ifdef STORE
        corner.normal = facing.normal;
        corner.material = facing.material;
#endif
    }
    return corner;
}

@fragment
fn fragment(in: Corner) -> @location(0) vec4<f32> {
    var facing: Facing;
    facing.plane = FlatTriangle(in.plane, in.depths);
#ifdef STORE
    facing.normal = in.normal;
    facing.material = in.material;
#endif
    put_fragment(in.position.xy, facing);
    return vec4<f32>(0.0);
}
#endif
