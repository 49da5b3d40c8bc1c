// The geometry passes of the fragment A-buffer (section 3.3), by the rasterizer's own sample rule: the depth bounds of every
// pixel; of the s-buffer the number of its fragments; the fragments themselves. With COMPUTE by the rule of tracebench::coverage.

#import tracebench::view::{to_eye_space, clip_position}
#import tracebench::plane_depth::{FlatTriangle, flat_triangle, plane_depth}
#import tracebench::surface::unit_normal
#import tracebench::depth_bounds::{near_code, far_code, depths_of, bucket_of}
#import tracebench::fragment_layout::{Storage, DrawnView, word_index, BOUNDS_SLACK}
#ifdef COMPUTE
#import tracebench::dispatch::linear_workgroup
#import tracebench::coverage::{outline_in_view, rows_of_outline, span_of_row}
#import tracebench::raster_work::part_of
#endif

@group(0) @binding(0) var<uniform> shape: Storage;
@group(0) @binding(1) var<uniform> drawn: DrawnView;
@group(0) @binding(2) var<storage, read> positions: array<f32>;
@group(0) @binding(3) var<storage, read> indices: array<u32>;
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
#ifdef STORE
    normal: vec3<f32>,
    material: u32,
#endif
}

fn load_position(corner: u32) -> vec3<f32> {
    let vertex = indices[corner] * 3u;
    return vec3<f32>(positions[vertex], positions[vertex + 1u], positions[vertex + 2u]);
}

// By its first of three corners.
fn facing_of(first: u32) -> Facing {
    let a = load_position(first);
    let b = load_position(first + 1u);
    let c = load_position(first + 2u);
    var facing: Facing;
    facing.plane = flat_triangle(drawn.view, a, b, c);
#ifdef STORE
    facing.normal = unit_normal(b - a, c - a);
    facing.material = materials[first / 3u];
#endif
    return facing;
}

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

fn store_fragment(pixel: u32, depth: f32, facing: Facing) {
    // Beyond the capacity nothing is stored and the count goes on: the host sees what is missing.
    if (shape.contiguous == 1u) {
        let begin = atomicLoad(&pixels[word_index(shape, pixel, 0u)]);
        let slot = begin + atomicAdd(&pixels[word_index(shape, pixel, 1u)], 1u);
        if (slot < shape.node_capacity) {
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
        store_payload(node * shape.data_words + shape.data_offset, facing.normal, facing.material);
    }
}
#endif

// What a pass does with a fragment, by its pixel's centre.
fn put_fragment(centre: vec2<f32>, facing: Facing) {
#ifdef TALLY
    // How many fragments a view has, before there is room for any.
    atomicAdd(&taken[0], 1u);
#else
    let at = vec2<u32>(centre);
    let pixel = drawn.first_pixel + at.y * drawn.width + at.x;
    let depth = plane_depth(drawn.view, facing.plane, centre);
#ifdef BOUNDS
    atomicMax(&pixels[word_index(shape, pixel, shape.bounds_word)], near_code(depth));
    atomicMax(&pixels[word_index(shape, pixel, shape.bounds_word + 1u)], far_code(depth));
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
    store_fragment(pixel, depth, facing);
#endif
#endif
}

#ifdef COMPUTE
const WORKGROUP_SIZE: u32 = 64u;

@compute @workgroup_size(WORKGROUP_SIZE)
fn draw(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let part = part_of(linear_workgroup(workgroup, workgroups), local);
    if (any(part.high <= part.low)) {
        return;
    }
    let first = part.triangle * 3u;
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
#else
struct Corner {
    @builtin(position) position: vec4<f32>,
    @location(0) @interpolate(flat) plane: vec4<f32>,
    @location(1) @interpolate(flat) depths: vec2<f32>,
#ifdef STORE
    @location(2) @interpolate(flat) normal: vec3<f32>,
    @location(3) @interpolate(flat) material: u32,
#endif
}

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
