#define_import_path tracebench::voxel_store

// What a trace reads of the grid and of the A-buffers, and the state of a lane's ray while it is traced.

#import tracebench::types::Ray
#import tracebench::reads::{quad_0, pair_0, word_0, word_1}
#import tracebench::image_walk::Span
#import tracebench::lanes::open
#import tracebench::unit_space::{to_unit, voxel_index}
#import tracebench::voxel_walk::span_in_cube
#import tracebench::voxel_settings::VoxelSearch

@group(0) @binding(0) var<uniform> search: VoxelSearch;
#ifdef COUNTERS
// All that is counted, in one buffer since WebGPU grants eight: a bit a node that any ray tested, a bit a node whose data any ray
// read, and of every ray COUNTS numbers.
@group(0) @binding(4) var<storage, read_write> counted: array<atomic<u32>>;
#endif
// Of the arrays that are read at unrelated places, words 0 are heads, words 1 the voxels' codes, pairs 0 the nodes, quads 0 their data.
#ifdef SPLIT
// Where one binding does not hold all, each axis has buffers of its own: these are the further ones.
@group(2) @binding(0) var<storage, read> nodes_y: array<vec2<u32>>;
@group(2) @binding(1) var<storage, read> nodes_z: array<vec2<u32>>;
// Data are read by traces to surfaces and by planes.
@group(2) @binding(2) var<storage, read> further_data_x: array<vec4<u32>>;
@group(2) @binding(3) var<storage, read> data_y: array<vec4<u32>>;
@group(2) @binding(4) var<storage, read> further_data_y: array<vec4<u32>>;
@group(2) @binding(5) var<storage, read> data_z: array<vec4<u32>>;
@group(2) @binding(6) var<storage, read> further_data_z: array<vec4<u32>>;
#endif

// Of every ray: voxels stepped through, voxels opened, searches in an image, depths compared with a texel's, layers tested for that,
// and whether it starts inside.
const COUNTS: u32 = 6u;
const STEPPED: u32 = 0u;
const OPENED: u32 = 1u;
const SEARCHES: u32 = 2u;
const COMPARED: u32 = 3u;
const LAYERS: u32 = 4u;
const STARTS_INSIDE: u32 = 5u;

// What a voxel's code says: nothing is there, an axis of x, y, z from 1 on, or that opposite normals have cancelled.
const EMPTY: u32 = 0u;
const CANCELLED: u32 = 4u;

// The ray, and the same in the cube, where it has the same parameters.
var<private> ray: Ray;
var<private> origin: vec3<f32>;
var<private> direction: vec3<f32>;
#ifdef COUNTERS
var<private> work: array<u32, 6>;
#endif

// Begins with a ray; the part of it that lies in the cube.
fn begin_ray(given: Ray) -> Span {
    // Nothing is left of the ray before.
    open = 0u;
#ifdef COUNTERS
    work = array<u32, 6>();
#endif
    ray = given;
    origin = to_unit(search.space, ray.origin);
    direction = ray.direction * search.space.scale;
    return span_in_cube(origin, direction, Span(ray.t_min, ray.t_max));
}

fn code_of(voxel: vec3<i32>) -> u32 {
    let index = voxel_index(search.space, voxel);
    return (word_1(index >> 3u) >> ((index & 7u) * 4u)) & 15u;
}

// The first link of a texel's list.
fn head_of(axis: u32, texel: vec2<u32>) -> u32 {
    return word_0(axis * search.head_stride + texel.y * search.space.image + texel.x);
}

// A layer's code and the next link.
fn load_node(axis: u32, node: u32) -> vec2<u32> {
#ifdef COUNTERS
    work[LAYERS] += 1u;
    let bit = search.first_bits[axis] + node;
    atomicOr(&counted[bit >> 5u], 1u << (bit & 31u));
#endif
#ifdef SPLIT
    switch (axis) {
        case 0u: {
            return pair_0(node);
        }
        case 1u: {
            return nodes_y[node];
        }
        default: {
            return nodes_z[node];
        }
    }
#else
    return pair_0(search.first_nodes[axis] + node);
#endif
}

// A layer's normal and material.
fn load_data(axis: u32, node: u32) -> vec4<u32> {
#ifdef COUNTERS
    let bit = search.first_bits[axis] + node;
    atomicOr(&counted[search.touched_words + (bit >> 5u)], 1u << (bit & 31u));
#endif
    let is_further = node >= search.half_nodes;
#ifdef SPLIT
    let place = select(node, node - search.half_nodes, is_further);
    switch (axis * 2u + select(0u, 1u, is_further)) {
        case 0u: {
            return quad_0(place);
        }
        case 1u: {
            return further_data_x[place];
        }
        case 2u: {
            return data_y[place];
        }
        case 3u: {
            return further_data_y[place];
        }
        case 4u: {
            return data_z[place];
        }
        default: {
            return further_data_z[place];
        }
    }
#else
    if (is_further) {
        return quad_0(search.first_further_data[axis] + node - search.half_nodes);
    }
    return quad_0(search.first_data[axis] + node);
#endif
}
