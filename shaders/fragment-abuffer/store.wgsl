#define_import_path tracebench::fragment_store

// What a trace reads of the fragments that are stored, and the state of a lane's ray while it is traced.

#import tracebench::types::Ray
#import tracebench::image_walk::{EyeRay, Span}
#import tracebench::depth_bounds::depths_of
#import tracebench::reads::{word_0, word_1}
#ifdef SURFACES
#import tracebench::reads::word_3
#endif
#import tracebench::fragment_layout::{Storage, TracedView, BOUNDS_SLACK}

struct MarchSettings {
    ray_count: u32,
    view_count: u32,
    // 0: a number of steps a view, 1: every pixel, 2: up and down the pyramid.
    march: u32,
    // Steps a view; steps after which a ray is given up.
    steps: u32,
    max_steps: u32,
    // 1: steps look at their middle.
    centred: u32,
    // 1: a step asks for depths within its pixel alone.
    span_by_pixel: u32,
    binary_search_above: u32,
    // Scene units, and widths of a pixel: one of both is 0. Behind a fragment's depth; below 0 before it.
    thickness: f32,
    thickness_in_pixels: f32,
    // Pixels along the major axis.
    start_bias: f32,
    // 1: pixels whose depth bounds the ray misses are skipped (step a), buckets that it does not meet (step b), and rests of
    // lists beyond it.
    skip_bounds: u32,
    skip_buckets: u32,
    skip_lists: u32,
    rays_per_lane: u32,
    // Words of bits a node.
    touched_words: u32,
}

@group(0) @binding(0) var<uniform> shape: Storage;
@group(0) @binding(1) var<uniform> search: MarchSettings;
@group(0) @binding(2) var<uniform> views: array<TracedView, 7>;
#ifdef COUNTERS
// All that is counted, in one buffer since WebGPU grants eight: a bit a node that any ray tested, a bit a node whose data any ray
// read, and of every ray COUNTS numbers.
@group(0) @binding(6) var<storage, read_write> counted: array<atomic<u32>>;
#endif
// Of the arrays that are read at unrelated places, words 0 are the pixels', 1 the nodes, 2 the pyramid, 3 the data.
#ifdef SPLIT
// Where one binding does not hold all, each view has buffers of its own: these are the further views'.
@group(2) @binding(0) var<storage, read> pixels_1: array<u32>;
@group(2) @binding(1) var<storage, read> pixels_2: array<u32>;
@group(2) @binding(2) var<storage, read> pixels_3: array<u32>;
@group(2) @binding(3) var<storage, read> pixels_4: array<u32>;
@group(2) @binding(4) var<storage, read> pixels_5: array<u32>;
@group(2) @binding(5) var<storage, read> pixels_6: array<u32>;
@group(2) @binding(6) var<storage, read> ids_1: array<u32>;
@group(2) @binding(7) var<storage, read> ids_2: array<u32>;
@group(2) @binding(8) var<storage, read> ids_3: array<u32>;
@group(2) @binding(9) var<storage, read> ids_4: array<u32>;
@group(2) @binding(10) var<storage, read> ids_5: array<u32>;
@group(2) @binding(11) var<storage, read> ids_6: array<u32>;
#ifdef SURFACES
@group(2) @binding(12) var<storage, read> payloads_1: array<u32>;
@group(2) @binding(13) var<storage, read> payloads_2: array<u32>;
@group(2) @binding(14) var<storage, read> payloads_3: array<u32>;
@group(2) @binding(15) var<storage, read> payloads_4: array<u32>;
@group(2) @binding(16) var<storage, read> payloads_5: array<u32>;
@group(2) @binding(17) var<storage, read> payloads_6: array<u32>;
#endif
#endif

// Whether fragments are pieces of the s-buffer, and whether they are planes. (naga_oil imports functions, no overrides.)
override CONTIGUOUS: bool;
override PLANES: bool;

fn has_pieces() -> bool {
    return CONTIGUOUS;
}

fn has_planes() -> bool {
    return PLANES;
}

// The state of this lane's ray.
var<private> ray: Ray;
var<private> eye_ray: EyeRay;
var<private> number: u32;
// That view: of a uniform array every lane would read its own element.
var<private> traced: TracedView;
var<private> found: bool;
var<private> found_node: u32;
var<private> found_depth: f32;
var<private> found_t: f32;
// Of planes: the pixel that is looked at, and the part of the ray that lies in it.
var<private> looked_at: vec2<u32>;
var<private> part: Span;
var<private> capped: bool;
var<private> steps: u32;
#ifdef COUNTERS
// As in the counts of a ray.
var<private> work: array<u32, 6>;
#endif

fn load_pixel(index: u32) -> u32 {
#ifdef SPLIT
    switch (number) {
        case 0u: {
            return word_0(index);
        }
        case 1u: {
            return pixels_1[index];
        }
        case 2u: {
            return pixels_2[index];
        }
        case 3u: {
            return pixels_3[index];
        }
        case 4u: {
            return pixels_4[index];
        }
        case 5u: {
            return pixels_5[index];
        }
        default: {
            return pixels_6[index];
        }
    }
#else
#ifdef TEXTURES
    return word_0(traced.begins.x + index);
#else
    return word_0(index);
#endif
#endif
}

fn load_id(index: u32) -> u32 {
#ifdef SPLIT
    switch (number) {
        case 0u: {
            return word_1(index);
        }
        case 1u: {
            return ids_1[index];
        }
        case 2u: {
            return ids_2[index];
        }
        case 3u: {
            return ids_3[index];
        }
        case 4u: {
            return ids_4[index];
        }
        case 5u: {
            return ids_5[index];
        }
        default: {
            return ids_6[index];
        }
    }
#else
#ifdef TEXTURES
    return word_1(traced.begins.y + index);
#else
    return word_1(index);
#endif
#endif
}

#ifdef SURFACES
fn load_payload(index: u32) -> u32 {
#ifdef SPLIT
    switch (number) {
        case 0u: {
            return word_3(index);
        }
        case 1u: {
            return payloads_1[index];
        }
        case 2u: {
            return payloads_2[index];
        }
        case 3u: {
            return payloads_3[index];
        }
        case 4u: {
            return payloads_4[index];
        }
        case 5u: {
            return payloads_5[index];
        }
        default: {
            return payloads_6[index];
        }
    }
#else
#ifdef TEXTURES
    return word_3(traced.begins.z + index);
#else
    return word_3(index);
#endif
#endif
}

// Where what shading needs of a fragment is, among the data.
fn data_of(node: u32) -> u32 {
    // In the s-buffer nodes are put into their order and data stays.
    if (CONTIGUOUS && shape.data_offset == 0u) {
        return load_id(node * shape.node_words + 1u);
    }
    return node;
}
#endif

// The depth of a fragment that is tested.
fn test_depth(node: u32) -> f32 {
#ifdef COUNTERS
    work[2] += 1u;
    let bit = traced.first_node + node;
    atomicOr(&counted[bit >> 5u], 1u << (bit & 31u));
#endif
    return bitcast<f32>(load_id(node * shape.node_words));
}

fn take(node: u32, depth: f32) {
    found = true;
    found_node = node;
    found_depth = depth;
}

fn word_of(pixel: u32, word: u32) -> u32 {
    return load_pixel(word * traced.pixel_count + pixel);
}

fn bounds_of(pixel: u32) -> vec2<f32> {
    return depths_of(vec2<u32>(word_of(pixel, shape.bounds_word), word_of(pixel, shape.bounds_word + 1u)));
}

// By how much a depth on the ray may be off: of sums, by f32's precision at the terms.
fn depth_slack(depth: f32) -> f32 {
    return BOUNDS_SLACK * max(abs(eye_ray.origin.z), depth);
}

// Whether a ray with these depths passes outside of depth bounds (step a).
fn misses(bounds: vec2<f32>, least: f32, most: f32) -> bool {
    return most <= bounds.x * (1.0 - BOUNDS_SLACK) || least > bounds.y * (1.0 + BOUNDS_SLACK);
}
