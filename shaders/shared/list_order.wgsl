#define_import_path tracebench::list_order

// Linked lists by depth: of nodes that fragments were put before in whatever order they came. A node is its depth, the next link and
// whatever else; a link is one more than a node's index, 0 the end.

@group(0) @binding(2) var<storage, read_write> ids: array<u32>;

// Words from a node to the next; to be set first.
var<private> node_words: u32;

// Loops that were begun and not ended by themselves: Mesa's software driver ends the loops of eight lanes together after
// 65,535 rounds in all.
var<private> open: u32;

// Nodes of a list that are ordered by insertion; longer lists are merged, which is less work.
const MAX_INSERTED: u32 = 16u;

// Depths are positive, so that their bits are in their order.
fn depth_bits(node: u32) -> u32 {
    return ids[node * node_words];
}

// Whether a node may stand before another.
fn in_order(a: u32, b: u32) -> bool {
    return depth_bits(a) <= depth_bits(b);
}

fn next_of(link: u32) -> u32 {
    return ids[(link - 1u) * node_words + 1u];
}

fn set_next(link: u32, next: u32) {
    ids[(link - 1u) * node_words + 1u] = next;
}

// A list of which the first nodes are in order, and whether those are all.
struct Sorted {
    list: u32,
    whole: bool,
}

// The first nodes of a list by insertion (VVP16, section 3.3), up to as many as are no work: each stays where it is if it is not before
// the last, else it goes to its place from the front. Whatever follows them stays linked behind them. Of equal depths the order stays.
fn insert_first(first: u32) -> Sorted {
    var list = first;
    var last = first;
    var last_bits = depth_bits(first - 1u);
    var link = next_of(first);
    var count = 1u;
    open += 1u;
    loop {
        if (link == 0u || count == MAX_INSERTED) {
            open -= 1u;
            break;
        }
        count += 1u;
        let next = next_of(link);
        let bits = depth_bits(link - 1u);
        if (bits >= last_bits) {
            last = link;
            last_bits = bits;
        } else {
            set_next(last, next);
            var before = 0u;
            var after = list;
            open += 1u;
            loop {
                if (bits < depth_bits(after - 1u)) {
                    open -= 1u;
                    break;
                }
                before = after;
                after = next_of(after);
            }
            set_next(link, after);
            if (before == 0u) {
                list = link;
            } else {
                set_next(before, link);
            }
        }
        link = next;
    }
    return Sorted(list, link == 0u);
}

// Merge sort from the bottom up: runs of 1, 2, 4, ... nodes, relinked in place. Its n log n rounds stay within the driver's limit
// for some thousand fragments, insertion alone for some hundred.
fn sort_list(first: u32) -> u32 {
    var list = first;
    var run = 1u;
    open += 1u;
    loop {
        var left = list;
        list = 0u;
        var tail = 0u;
        var merges = 0u;
        open += 1u;
        loop {
            if (left == 0u) {
                open -= 1u;
                break;
            }
            merges += 1u;
            var right = left;
            var left_size = 0u;
            open += 1u;
            loop {
                if (left_size == run || right == 0u) {
                    open -= 1u;
                    break;
                }
                left_size += 1u;
                right = next_of(right);
            }
            var right_size = run;
            open += 1u;
            loop {
                let no_right = right_size == 0u || right == 0u;
                if (left_size == 0u && no_right) {
                    open -= 1u;
                    break;
                }
                var taken_link = left;
                if (left_size > 0u && (no_right || in_order(left - 1u, right - 1u))) {
                    left = next_of(left);
                    left_size -= 1u;
                } else {
                    taken_link = right;
                    right = next_of(right);
                    right_size -= 1u;
                }
                if (tail == 0u) {
                    list = taken_link;
                } else {
                    set_next(tail, taken_link);
                }
                tail = taken_link;
            }
            left = right;
        }
        set_next(tail, 0u);
        if (merges <= 1u) {
            open -= 1u;
            break;
        }
        run *= 2u;
    }
    return list;
}

// A list of one node at least, in order; gives its first link.
fn ordered_list(first: u32) -> u32 {
    let inserted = insert_first(first);
    if (inserted.whole) {
        return inserted.list;
    }
    return sort_list(inserted.list);
}
