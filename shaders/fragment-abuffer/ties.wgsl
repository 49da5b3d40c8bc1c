#define_import_path tracebench::fragment_ties

// Fragments of a list or piece whose depths are equal. Searches take the first of them: that is the one whose payload is least, so that
// hits do not depend on the order in which fragments came.

#import tracebench::list_order::{ids, open, depth_bits}
#import tracebench::fragment_layout::Storage

@group(0) @binding(0) var<uniform> shape: Storage;
#ifdef DECOUPLED
@group(0) @binding(4) var<storage, read_write> payloads: array<u32>;
#endif

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
fn swap_word(a: u32, b: u32) {
    let kept = ids[a];
    ids[a] = ids[b];
    ids[b] = kept;
}

// Swaps two nodes; four words a round, since a driver's limit counts rounds.
fn swap(a: u32, b: u32) {
    let words = shape.node_words;
    for (var word = 0u; word < words; word += 4u) {
        let one = a * words + word;
        let other = b * words + word;
        swap_word(one, other);
        if (word + 1u < words) {
            swap_word(one + 1u, other + 1u);
        }
        if (word + 2u < words) {
            swap_word(one + 2u, other + 2u);
        }
        if (word + 3u < words) {
            swap_word(one + 3u, other + 3u);
        }
    }
}

// Settles the ties of a piece that is in order.
fn settle_piece(begin: u32, count: u32) {
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
