#define_import_path tracebench::quadtree_store

// What a trace reads of the quad-trees, and the state of a lane's ray while it is traced.

#import tracebench::view::View
#import tracebench::types::Ray
#import tracebench::image_walk::EyeRay
#import tracebench::pyramid::index_in_level
#import tracebench::reads::pair_0
#import tracebench::quadtree_forest::Forest
#import tracebench::quadtree_node::NOTHING

struct QuadtreeSettings {
    ray_count: u32,
    rays_per_lane: u32,
    view_count: u32,
    // 1: views are faces, connected by their sides.
    has_faces: u32,
    // When the next layer is asked: 0 where an occlusion volume was passed, 1 where nothing was hit, 2 always.
    next_layer: u32,
    // 1: any hit will do.
    any_hit: u32,
    // Where rays end at the last layer's occlusion volumes: 0 they do not, 1 just before, 2 on the plane of the pixel there.
    inpaints: u32,
    max_steps: u32,
    // Pixels by which a ray starts away from its origin, and by which it must lie behind a plane to lie in its occlusion volume.
    start_bias: f32,
    occlusion_bias: f32,
    // Samples beside every ray, how far beside it in pixels, and 1 / sigma of their weight.
    samples: u32,
    jitter: f32,
    inverse_sigma: f32,
    // Words of bits a node.
    touched_words: u32,
    // 1: walks begin below the last ancestor of a ray's both ends, 0: at the roots.
    from_ancestor: u32,
    padding: u32,
}

struct TreeView {
    view: View,
    // Views beyond the right, left, upper and lower side; `view_count` for none.
    beyond: vec4<u32>,
}

@group(0) @binding(0) var<uniform> forest: Forest;
@group(0) @binding(1) var<uniform> search: QuadtreeSettings;
@group(0) @binding(2) var<uniform> views: array<TreeView, 6>;
#ifdef COUNTERS
// All that is counted, in one buffer since WebGPU grants eight: a bit a node that any ray visited, a bit a pixel of every layer whose
// surface any ray read, and of every ray COUNTS numbers.
@group(0) @binding(6) var<storage, read_write> counted: array<atomic<u32>>;
#endif

// Whether planes of pixels are joined. (naga_oil imports functions, no overrides.)
override JOINED: bool;

fn is_joined() -> bool {
    return JOINED;
}

// The state of this lane's ray.
var<private> ray: Ray;
var<private> eye_ray: EyeRay;
var<private> capped: bool;
var<private> steps: u32;
#ifdef COUNTERS
// As in the counts of a ray.
var<private> work: array<u32, 8>;
#endif

// A node that is visited.
fn visit(image: u32, level: u32, cell: vec2<u32>) -> vec2<u32> {
    // By the uniform itself: by value all of it would be handed over.
    let offset = forest.level_offsets[level >> 2u][level & 3u];
    let index = image * forest.image_nodes + offset + index_in_level(forest.size, level, cell);
#ifdef COUNTERS
    work[0] += 1u;
    atomicOr(&counted[index >> 5u], 1u << (index & 31u));
#endif
    return pair_0(index);
}

// The node of a pixel beside one that is visited; NOTHING outside of the image.
fn neighbour_node(image: u32, pixel: vec2<i32>) -> vec2<u32> {
    if (any(pixel < vec2<i32>(0)) || any(pixel >= vec2<i32>(forest.size))) {
        return NOTHING;
    }
    let index = image * forest.image_nodes + index_in_level(forest.size, 0u, vec2<u32>(pixel));
#ifdef COUNTERS
    work[7] += 1u;
    atomicOr(&counted[index >> 5u], 1u << (index & 31u));
#endif
    return pair_0(index);
}

// A pixel's own node, looked up for its depth.
fn pixel_node(image: u32, pixel: vec2<u32>) -> vec2<u32> {
    return pair_0(image * forest.image_nodes + index_in_level(forest.size, 0u, pixel));
}
