// The binary radix tree over triangles along a Morton curve, every pair of siblings by a lane of its own (Karras, "Maximizing
// Parallelism in the Construction of BVHs, Octrees, and k-d Trees", HPG 2012, sections 3 and 4).
//
// Deviation: Karras fits boxes from the leaves up in one launch: of two lanes that meet in a node the second goes on. It reads
// what another workgroup has just written, which WGSL does not show it for sure: atomics are relaxed, and barriers are a
// workgroup's. The triangles below a node stand in a row, though. So its box is put together from boxes of aligned blocks of
// 2, 4, 8... triangles (a segment tree), which dispatches before have made (`raise`).

#import tracebench::dispatch::{Invocation, linear_invocation}
#import tracebench::bvh_build::{BinaryNode, Box, both, inner_of}

struct Blocks {
    triangle_count: u32,
    // Blocks of two to this power are there.
    level: u32,
}

@group(0) @binding(0) var<uniform> settings: Blocks;
// Along the curve.
@group(0) @binding(1) var<storage, read> codes: array<u32>;
@group(0) @binding(2) var<storage, read> leaves: array<BinaryNode>;
// Whole ones of two, then of four, and so on.
@group(0) @binding(3) var<storage, read_write> blocks: array<Box>;
// Pair i is below Karras's inner node i: the root's children first, but others in no order of depth.
@group(0) @binding(4) var<storage, read_write> nodes: array<BinaryNode>;

const WORKGROUP_SIZE: u32 = 64u;
// Levels of blocks that a dispatch makes.
const RAISED: u32 = 4u;

fn leaf_box(place: u32) -> Box {
    return Box(leaves[place].low, leaves[place].high);
}

// Where the blocks of a level from 1 on begin.
fn start_of(level: u32) -> u32 {
    var start = 0u;
    for (var below = 1u; below < level; below++) {
        start += settings.triangle_count >> below;
    }
    return start;
}

@compute @workgroup_size(WORKGROUP_SIZE)
fn raise(invocation: Invocation) {
    let lane = linear_invocation(invocation, WORKGROUP_SIZE);
    var below = start_of(settings.level);
    for (var raised = 1u; raised <= RAISED; raised++) {
        let level = settings.level + raised;
        let start = start_of(level);
        let each = 1u << (RAISED - raised);
        for (var block = lane * each; block < min((lane + 1u) * each, settings.triangle_count >> level); block++) {
            let half = 2u * block;
            if (level == 1u) {
                blocks[start + block] = both(leaf_box(half), leaf_box(half + 1u));
            } else {
                blocks[start + block] = both(blocks[below + half], blocks[below + half + 1u]);
            }
        }
        below = start;
    }
}

// The box of all triangles from one place to another.
fn box_of(first: u32, last: u32) -> Box {
    var whole = both(leaf_box(first), leaf_box(last));
    var begin = (first + 1u) >> 1u;
    var end = (last + 1u) >> 1u;
    var start = 0u;
    var count = settings.triangle_count >> 1u;
    while (begin < end) {
        if ((begin & 1u) == 1u) {
            whole = both(whole, blocks[start + begin]);
        }
        if ((end & 1u) == 1u) {
            whole = both(whole, blocks[start + end - 1u]);
        }
        begin = (begin + 1u) >> 1u;
        end >>= 1u;
        start += count;
        count >>= 1u;
    }
    return whole;
}

// Bits from the highest on that two places' keys have in common. A key is a code, and the place where codes are equal.
fn common_bits(place: u32, other: i32) -> i32 {
    if (other < 0 || other >= i32(settings.triangle_count)) {
        return -1;
    }
    let differing = codes[place] ^ codes[other];
    let bits = select(countLeadingZeros(differing), 32u + countLeadingZeros(place ^ u32(other)), (differing == 0u));
    return i32(bits);
}

// Whether wide nodes are made of these.
override WIDE: bool;

fn child(first: u32, last: u32, pair: u32) -> BinaryNode {
    if (first == last) {
        return leaves[first];
    }
    let fitted = box_of(first, last);
    var count = 0xffffffffu;
    if (WIDE) {
        // No more levels than bits by which keys differ; places have none before those of the last one.
        let shared_bits = u32(common_bits(first, i32(last)));
        let unused = select(0u, countLeadingZeros(settings.triangle_count - 1u), (shared_bits < 32u));
        count = inner_of(64u - unused - shared_bits, last - first + 1u);
    }
    return BinaryNode(fitted.low, 2u * pair, fitted.high, count);
}

@compute @workgroup_size(WORKGROUP_SIZE)
fn link(invocation: Invocation) {
    let place = linear_invocation(invocation, WORKGROUP_SIZE);
    if (place + 1u >= settings.triangle_count) {
        return;
    }
    let own = i32(place);
    // The node's triangles begin or end here, and have more bits in common than with the one on the other side.
    let step = select(-1, 1, (common_bits(place, own + 1) > common_bits(place, own - 1)));
    let outside = common_bits(place, own - step);
    var reach = 2;
    while (common_bits(place, own + reach * step) > outside) {
        reach *= 2;
    }
    var length = 0;
    for (var more = reach / 2; more > 0; more /= 2) {
        if (common_bits(place, own + (length + more) * step) > outside) {
            length += more;
        }
    }
    // Where they are split: up to there they have more bits in common than all.
    let all = common_bits(place, own + length * step);
    var split = 0;
    for (var more = length; more > 1; ) {
        more = (more + 1) / 2;
        if (common_bits(place, own + (split + more) * step) > all) {
            split += more;
        }
    }
    let last_left = u32(own + split * step + min(step, 0));
    let other = u32(own + length * step);
    nodes[2u * place] = child(min(place, other), last_left, last_left);
    nodes[2u * place + 1u] = child(last_left + 1u, max(place, other), last_left + 1u);
}
