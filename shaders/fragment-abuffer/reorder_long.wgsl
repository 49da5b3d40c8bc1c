// The reorder stage (section 3.3) of pieces that are too long for one invocation: a workgroup orders each, by a bitonic sort of which every
// exchange puts the nearer fragment first, so that a piece of any length is sorted as if fragments beyond its end were farthest.

#import tracebench::list_order::{node_words, open, in_order}
#import tracebench::fragment_layout::word_index
#import tracebench::fragment_ties::{shape, swap, settle_piece}

@group(0) @binding(1) var<storage, read_write> pixels: array<u32>;
// Binding 2: the nodes.
// Fragments, and lists that could not be ordered.
@group(0) @binding(3) var<storage, read_write> taken: array<atomic<u32>>;
// Binding 4: payloads.
// As many workgroups as there are long pieces, along three dimensions; then those pieces.
@group(0) @binding(5) var<storage, read> long_pieces: array<u32>;

const WORKGROUP_SIZE: u32 = 256u;

// Nodes of a piece: 120 steps of 64 exchanges an invocation, of three rounds each, are within the 65,535 rounds of Mesa's software driver,
// whose invocations are to meet at the same barriers.
const MAX_NODES: u32 = 32768u;

// Where the piece begins, and how many it has.
var<workgroup> piece: vec2<u32>;

fn exchange(begin: u32, count: u32, near: u32, far: u32) {
    if (far < count && !in_order(begin + near, begin + far)) {
        swap(begin + near, begin + far);
    }
}

@compute @workgroup_size(WORKGROUP_SIZE)
fn reorder_long(@builtin(workgroup_id) workgroup: vec3<u32>, @builtin(local_invocation_index) local: u32) {
    node_words = shape.node_words;
    if (local == 0u) {
        let index = long_pieces[3u + workgroup.x];
        let begin = pixels[word_index(shape, index, 0u)];
        let count = pixels[word_index(shape, index, 1u)];
        piece = vec2<u32>(begin, min(begin + count, shape.node_capacity) - begin);
    }
    let whole = workgroupUniformLoad(&piece);
    let begin = whole.x;
    let count = whole.y;
    if (count > MAX_NODES) {
        if (local == 0u) {
            atomicAdd(&taken[1], 1u);
        }
        return;
    }
    // Sorted runs of 2, 4, 8, ... nodes: of two of half the length each is the other's mirror at first.
    var run = 2u;
    loop {
        let half = run / 2u;
        for (var pair = local; pair / half * run < count; pair += WORKGROUP_SIZE) {
            let first = pair / half * run;
            let place = pair % half;
            exchange(begin, count, first + place, first + run - 1u - place);
        }
        storageBarrier();
        var stride = half / 2u;
        loop {
            if (stride == 0u) {
                break;
            }
            for (var pair = local; pair / stride * 2u * stride < count; pair += WORKGROUP_SIZE) {
                let near = pair / stride * 2u * stride + pair % stride;
                exchange(begin, count, near, near + stride);
            }
            storageBarrier();
            stride /= 2u;
        }
        if (run >= count) {
            break;
        }
        run *= 2u;
    }
    if (local == 0u) {
        settle_piece(begin, count);
        if (open > 0u) {
            atomicAdd(&taken[1], 1u);
        }
    }
}
