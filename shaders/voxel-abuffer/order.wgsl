// The pass that orders the lists of an axis by depth (section 3.1). An invocation a list. Layers of equal depth and facing are one:
// a surface that is there twice would cancel itself where layers tell inside from outside. The one that stays has the least data, so
// that nothing hangs on the order in which fragments came. By nesting they are walls of objects that are counted, and stay. Fragments that are ORIENTED planes stay all: those of one depth at their
// texel's centre are parts of it side by side.

#import tracebench::dispatch::{Invocation, linear_invocation}
#import tracebench::list_order::{node_words, open, depth_bits, next_of, set_next, ordered_list}
#import tracebench::voxel_space::{RasterizedAxis, is_less}

@group(0) @binding(0) var<uniform> drawn: RasterizedAxis;
@group(0) @binding(1) var<storage, read_write> heads: array<u32>;
// Binding 2: the nodes.
@group(0) @binding(3) var<storage, read_write> taken: array<atomic<u32>>;
#ifndef ORIENTED
@group(0) @binding(4) var<storage, read_write> data: array<vec4<u32>>;
#endif
#ifdef HALVES
@group(0) @binding(5) var<storage, read_write> further_data: array<vec4<u32>>;
#endif

const WORKGROUP_SIZE: u32 = 64u;

// Of `taken`: lists that could not be ordered, and layers that were left out.
const UNORDERED: u32 = 3u;
const COPIES: u32 = 4u;

#ifndef ORIENTED
fn load_data(node: u32) -> vec4<u32> {
#ifdef HALVES
    if (node >= drawn.half_nodes) {
        return further_data[node - drawn.half_nodes];
    }
#endif
    return data[node];
}

fn store_data(node: u32, record: vec4<u32>) {
#ifdef HALVES
    if (node >= drawn.half_nodes) {
        further_data[node - drawn.half_nodes] = record;
        return;
    }
#endif
    data[node] = record;
}
#endif

@compute @workgroup_size(WORKGROUP_SIZE)
fn order(invocation: Invocation) {
    let texel = linear_invocation(invocation, WORKGROUP_SIZE);
    if (texel >= drawn.space.image * drawn.space.image) {
        return;
    }
    node_words = 2u;
    let first = heads[texel];
    if (first == 0u || next_of(first) == 0u) {
        return;
    }
    var kept = ordered_list(first);
    heads[texel] = kept;
#ifndef ORIENTED
    var link = next_of(kept);
    open += 1u;
    loop {
        if (link == 0u) {
            open -= 1u;
            break;
        }
        let next = next_of(link);
        if (drawn.nesting == 0u && depth_bits(link - 1u) == depth_bits(kept - 1u)) {
            let record = load_data(link - 1u);
            if (is_less(record, load_data(kept - 1u))) {
                store_data(kept - 1u, record);
            }
            set_next(kept, next);
            atomicAdd(&taken[COPIES], 1u);
        } else {
            kept = link;
        }
        link = next;
    }
#endif
    if (open > 0u) {
        atomicAdd(&taken[UNORDERED], 1u);
    }
}
