#define_import_path tracebench::voxel_fragments

// What the passes over the geometry of an axis bind, and how they store a fragment.

#import tracebench::voxel_space::RasterizedAxis

@group(0) @binding(0) var<uniform> drawn: RasterizedAxis;
// Fragments of every axis.
@group(0) @binding(5) var<storage, read_write> taken: array<atomic<u32>>;
#ifdef STORE
@group(0) @binding(4) var<storage, read_write> heads: array<atomic<u32>>;
@group(0) @binding(6) var<storage, read_write> nodes: array<vec2<u32>>;
@group(0) @binding(7) var<storage, read_write> data: array<vec4<u32>>;
#ifdef HALVES
@group(0) @binding(8) var<storage, read_write> further_data: array<vec4<u32>>;
#endif

fn store_fragment(texel: vec2<u32>, code: u32, record: vec4<u32>) {
    // Beyond the capacity nothing is stored and the count goes on: the host sees what is missing.
    let node = atomicAdd(&taken[drawn.axis], 1u);
    if (node >= drawn.capacity) {
        return;
    }
    let link = atomicExchange(&heads[texel.y * drawn.space.image + texel.x], node + 1u);
    nodes[node] = vec2<u32>(code, link);
#ifdef HALVES
    if (node >= drawn.half_nodes) {
        further_data[node - drawn.half_nodes] = record;
        return;
    }
#endif
    data[node] = record;
}
#endif
