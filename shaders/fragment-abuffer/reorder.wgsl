// The reorder stage (section 3.3): the fragments of every list, or of every piece of the s-buffer, by depth. An invocation a list.
// Of equal depths, of which searches take the first, that comes first whose payload is least, so that hits do not depend on the order
// in which fragments came.

#import tracebench::dispatch::linear_invocation
#import tracebench::list_order::{ids, node_words, open, depth_bits, in_order, next_of, ordered_list}
#import tracebench::fragment_layout::{Storage, word_index}

@group(0) @binding(0) var<uniform> shape: Storage;
@group(0) @binding(1) var<storage, read_write> pixels: array<u32>;
// Binding 2: the nodes.
// Fragments, and lists that could not be ordered.
@group(0) @binding(3) var<storage, read_write> taken: array<atomic<u32>>;
#ifdef DECOUPLED
@group(0) @binding(4) var<storage, read_write> payloads: array<u32>;
#endif

const WORKGROUP_SIZE: u32 = 64u;

// Where what shading needs of a fragment begins.
fn payload_at(node: u32) -> u32 {
#ifdef DECOUPLED
#ifdef CONTIGUOUS
    return ids[node * shape.node_words + 1u] * shape.data_words;
#else
    return node * shape.data_words;
#endif
#else
    return node * shape.data_words + shape.data_offset;
#endif
}

fn payload_word(at: u32) -> u32 {
#ifdef DECOUPLED
    return payloads[at];
#else
    return ids[at];
#endif
}

// Whether a node's payload is less than another's.
fn has_less(a: u32, b: u32) -> bool {
    let first = payload_at(a);
    let second = payload_at(b);
    for (var word = 0u; word < 4u; word++) {
        let one = payload_word(first + word);
        let other = payload_word(second + word);
        if (one != other) {
            return one < other;
        }
    }
    return false;
}

fn swap_payloads(a: u32, b: u32) {
    let first = payload_at(a);
    let second = payload_at(b);
    for (var word = 0u; word < 4u; word++) {
        let kept = payload_word(first + word);
#ifdef DECOUPLED
        payloads[first + word] = payloads[second + word];
        payloads[second + word] = kept;
#else
        ids[first + word] = ids[second + word];
        ids[second + word] = kept;
#endif
    }
}

// Nodes of equal depth, one after the other: the first of them, and the one of the least payload.
struct Tie {
    first: u32,
    least: u32,
}

// A tie with the node that comes next in order: the same one, or settled and a new one begun.
fn settle(tie: Tie, next: u32) -> Tie {
    if (depth_bits(next) != depth_bits(tie.first)) {
        finish(tie);
        return Tie(next, next);
    }
    return Tie(tie.first, select(tie.least, next, has_less(next, tie.least)));
}

// Of planes searches tell equal hits apart themselves: their data goes with the plane.
fn finish(tie: Tie) {
    if (tie.least != tie.first && shape.plane_word == 0u) {
        swap_payloads(tie.first, tie.least);
    }
}

#ifdef CONTIGUOUS
fn swap(a: u32, b: u32) {
    for (var word = 0u; word < shape.node_words; word++) {
        let kept = ids[a * shape.node_words + word];
        ids[a * shape.node_words + word] = ids[b * shape.node_words + word];
        ids[b * shape.node_words + word] = kept;
    }
}

// Whether a piece is in order as it is: of equal triangles the longest ones are, which to sort would take too many rounds.
fn is_sorted(begin: u32, count: u32) -> bool {
    var at = 1u;
    open += 1u;
    loop {
        if (at >= count || !in_order(begin + at - 1u, begin + at)) {
            open -= 1u;
            break;
        }
        at += 1u;
    }
    return at >= count;
}

// Shell sort.
fn sort_piece(begin: u32, count: u32) {
    var gap = select(count / 2u, 0u, is_sorted(begin, count));
    open += 1u;
    loop {
        if (gap == 0u) {
            open -= 1u;
            break;
        }
        var next = gap;
        open += 1u;
        loop {
            if (next >= count) {
                open -= 1u;
                break;
            }
            var at = next;
            open += 1u;
            loop {
                if (at < gap || in_order(begin + at - gap, begin + at)) {
                    open -= 1u;
                    break;
                }
                swap(begin + at - gap, begin + at);
                at -= gap;
            }
            next += 1u;
        }
        gap = select(gap * 5u / 11u, 1u, (gap == 2u));
    }
    if (shape.plane_word > 0u) {
        return;
    }
    var tie = Tie(begin, begin);
    var at = 1u;
    open += 1u;
    loop {
        if (at >= count) {
            open -= 1u;
            break;
        }
        tie = settle(tie, begin + at);
        at += 1u;
    }
    finish(tie);
}
#endif

@compute @workgroup_size(WORKGROUP_SIZE)
fn reorder(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let index = linear_invocation(workgroup, workgroups, local, WORKGROUP_SIZE);
    if (index >= shape.pixel_count * shape.buckets) {
        return;
    }
    node_words = shape.node_words;
#ifdef CONTIGUOUS
    let begin = pixels[word_index(shape, index, 0u)];
    let count = pixels[word_index(shape, index, 1u)];
    // What found no room is not there to be ordered.
    let end = min(begin + count, shape.node_capacity);
    if (end > begin + 1u) {
        sort_piece(begin, end - begin);
    }
#else
    // Images of heads lie one behind the other, those of tails behind them.
    let first = pixels[index];
    if (first == 0u) {
        return;
    }
    let tail = index + shape.buckets * shape.pixel_count;
    if (next_of(first) == 0u) {
        if (shape.double == 1u) {
            ids[(first - 1u) * shape.node_words + 2u] = 0u;
            pixels[tail] = first;
        }
        return;
    }
    var link = ordered_list(first);
    pixels[index] = link;
    var tie = Tie(link - 1u, link - 1u);
    var previous = 0u;
    open += 1u;
    loop {
        if (link == 0u) {
            open -= 1u;
            break;
        }
        if (shape.double == 1u) {
            ids[(link - 1u) * shape.node_words + 2u] = previous;
        }
        if (previous != 0u) {
            tie = settle(tie, link - 1u);
        }
        previous = link;
        link = next_of(link);
    }
    finish(tie);
    if (shape.double == 1u) {
        pixels[tail] = previous;
    }
#endif
    if (open > 0u) {
        atomicAdd(&taken[1], 1u);
    }
}
