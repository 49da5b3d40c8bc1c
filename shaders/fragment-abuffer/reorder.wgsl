// The reorder stage (section 3.3): the fragments of every list, or of every piece of the s-buffer, by depth. An invocation a list;
// pieces that are too long for one are listed for `reorder_long`.

#import tracebench::dispatch::{Invocation, linear_invocation}
#import tracebench::list_order::{node_words, open, in_order, next_of, ordered_list, ids}
#import tracebench::fragment_layout::word_index
#import tracebench::fragment_ties::{shape, Tie, settle, finish, swap, settle_piece}

@group(0) @binding(1) var<storage, read_write> pixels: array<u32>;
// Binding 2: the nodes.
// Fragments, and lists that could not be ordered.
@group(0) @binding(3) var<storage, read_write> taken: array<atomic<u32>>;
// Binding 4: payloads.
#ifdef CONTIGUOUS
// As many workgroups as there are long pieces, along three dimensions; then those pieces.
@group(0) @binding(5) var<storage, read_write> long_pieces: array<atomic<u32>>;

// Nodes that an invocation orders alone. A Shell sort of eight such pieces, which is what a lane is to Mesa's software driver, stays
// within its 65,535 rounds.
const MAX_ALONE: u32 = 128u;
#endif

const WORKGROUP_SIZE: u32 = 64u;

#ifdef CONTIGUOUS
// Shell sort.
fn sort_piece(begin: u32, count: u32) {
    var gap = count / 2u;
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
    settle_piece(begin, count);
}

// Lists a piece for a workgroup of its own.
fn leave_piece(index: u32) {
    let room = arrayLength(&long_pieces) - 3u;
    let place = atomicAdd(&long_pieces[0], 1u);
    if (place < room) {
        atomicStore(&long_pieces[3u + place], index);
    } else {
        atomicMin(&long_pieces[0], room);
        atomicAdd(&taken[1], 1u);
    }
}
#endif

@compute @workgroup_size(WORKGROUP_SIZE)
fn reorder(invocation: Invocation) {
    let index = linear_invocation(invocation, WORKGROUP_SIZE);
    if (index >= shape.pixel_count * shape.buckets) {
        return;
    }
    node_words = shape.node_words;
#ifdef CONTIGUOUS
    let begin = pixels[word_index(shape, index, 0u)];
    let count = pixels[word_index(shape, index, 1u)];
    // What found no room is not there to be ordered.
    let end = min(begin + count, shape.node_capacity);
    if (index == 0u) {
        atomicStore(&long_pieces[1], 1u);
        atomicStore(&long_pieces[2], 1u);
    }
    if (end > begin + MAX_ALONE) {
        leave_piece(index);
    } else if (end > begin + 1u) {
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
