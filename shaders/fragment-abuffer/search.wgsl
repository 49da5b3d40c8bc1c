#define_import_path tracebench::fragment_search

// The search among the fragments of a pixel, a piece of the s-buffer or lists, for the first that the ray meets between two
// depths.

#import tracebench::depth_bounds::bucket_share
#import tracebench::lanes::open
#import tracebench::fragment_store::{shape, search, traced, found, found_depth, work, load_id, test_depth, word_of, bounds_of, misses, depth_slack, take, has_pieces, has_planes}
#import tracebench::fragment_planes::meet

// Whether a fragment of this least depth, and all behind it in its list, lie beyond what the ray may still meet.
fn is_beyond(depth: f32, most: f32, forwards: bool) -> bool {
    return depth > most || (forwards && found && depth > found_depth + depth_slack(found_depth));
}

// A pixel's piece of the s-buffer, in the order in which planes begin.
fn search_piece_of_planes(pixel: u32, most: f32, forwards: bool) {
#ifdef COUNTERS
    work[5] += 1u;
#endif
    var node = word_of(pixel, 0u);
    let end = min(node + word_of(pixel, 1u), traced.node_capacity);
    let leaves = search.skip_lists == 1u;
    open += 1u;
    loop {
        if (node >= end) {
            open -= 1u;
            break;
        }
        let depth = test_depth(node);
        if (leaves && is_beyond(depth, most, forwards)) {
            open -= 1u;
            break;
        }
        meet(node, depth);
        node += 1u;
    }
}

// A list from its head, in the order in which planes begin.
fn search_list_of_planes(pixel: u32, bucket: u32, most: f32, forwards: bool) {
#ifdef COUNTERS
    work[5] += 1u;
#endif
    var link = word_of(pixel, bucket);
    let leaves = search.skip_lists == 1u;
    open += 1u;
    loop {
        if (link == 0u) {
            open -= 1u;
            break;
        }
        let node = link - 1u;
        let depth = test_depth(node);
        if (leaves && is_beyond(depth, most, forwards)) {
            open -= 1u;
            break;
        }
        meet(node, depth);
        link = load_id(node * shape.node_words + 1u);
    }
}

// The buckets of a pixel up to the last that the ray's depths overlap: a plane is in the one in which it begins, and may reach into others.
fn search_lists_of_planes(pixel: u32, most: f32, forwards: bool) {
    var last = shape.buckets - 1u;
    if (shape.bounds_word > 0u && search.skip_buckets == 1u && last > 0u) {
        // A little more than what is asked for: fragments were put into buckets by another shader.
        last = min(u32(max(bucket_share(most, bounds_of(pixel)) * f32(shape.buckets) + 1e-3, 0.0)), last);
    }
    var opened = 0u;
    open += 1u;
    loop {
        if (opened > last) {
            open -= 1u;
            break;
        }
        search_list_of_planes(pixel, opened, most, forwards);
        opened += 1u;
    }
}

// The first node of a piece with at least this depth, its end if there is none.
fn first_not_before(begin: u32, end: u32, depth: f32) -> u32 {
    var low = begin;
    var high = end;
    open += 1u;
    loop {
        if (low >= high) {
            open -= 1u;
            break;
        }
        let middle = low + (high - low) / 2u;
        if (test_depth(middle) < depth) {
            low = middle + 1u;
        } else {
            high = middle;
        }
    }
    return low;
}

// A pixel's piece of the s-buffer: from the side that the ray comes from, by halving where it is long. Of equal depths the first.
fn search_piece(pixel: u32, least: f32, most: f32, forwards: bool) {
#ifdef COUNTERS
    work[5] += 1u;
#endif
    let begin = word_of(pixel, 0u);
    let count = word_of(pixel, 1u);
    let end = min(begin + count, traced.node_capacity);
    if (begin >= end) {
        return;
    }
    if (search.skip_bounds == 1u && misses(vec2<f32>(test_depth(begin), test_depth(end - 1u)), least, most)) {
        return;
    }
    let leaves = search.skip_lists == 1u;
    if (count > search.binary_search_above) {
        if (!forwards) {
            // The last before `most`, and of its depth the first.
            let behind = first_not_before(begin, end, most);
            if (behind > begin) {
                let depth = test_depth(behind - 1u);
                if (depth >= least) {
                    take(first_not_before(begin, behind, depth), depth);
                }
            }
            return;
        }
        let at = first_not_before(begin, end, least);
        if (at < end) {
            let depth = test_depth(at);
            if (depth < most) {
                take(at, depth);
            }
        }
        return;
    }
    var step = 0u;
    open += 1u;
    loop {
        if (step >= end - begin) {
            open -= 1u;
            break;
        }
        let node = select(end - 1u - step, begin + step, forwards);
        let depth = test_depth(node);
        let inside = depth >= least && depth < most;
        let passed = select((depth < least), (depth >= most), forwards);
        if ((found && (forwards || depth != found_depth)) || (leaves && passed)) {
            open -= 1u;
            break;
        }
        if (inside) {
            take(node, depth);
        }
        step += 1u;
    }
}

// A list, from its head or, where it is linked both ways, from the end that the ray comes from. Of equal depths the first.
fn search_list(pixel: u32, bucket: u32, least: f32, most: f32, forwards: bool) {
    let backwards = !forwards && shape.double == 1u;
#ifdef COUNTERS
    work[5] += 1u;
#endif
    var link = word_of(pixel, bucket + select(0u, shape.buckets, backwards));
    if (link == 0u) {
        return;
    }
    let leaves = search.skip_lists == 1u;
    // A list without bounds and without a tail has its first fragment for a near bound, and nothing for a far one (4.3).
    var skips = leaves || (search.skip_bounds == 1u && shape.bounds_word == 0u && shape.double == 0u);
    open += 1u;
    loop {
        let node = link - 1u;
        let depth = test_depth(node);
        let inside = depth >= least && depth < most;
        if (backwards) {
            if ((found && depth != found_depth) || (leaves && depth < least)) {
                open -= 1u;
                break;
            }
            if (inside) {
                take(node, depth);
            }
        } else {
            if (inside && (!found || depth > found_depth)) {
                take(node, depth);
            }
            if ((found && forwards) || (skips && depth >= most)) {
                open -= 1u;
                break;
            }
        }
        skips = leaves;
        link = load_id(node * shape.node_words + select(1u, 2u, backwards));
        if (link == 0u) {
            open -= 1u;
            break;
        }
    }
}

// The buckets of a pixel that the ray's depths overlap (step b), in the order in which it meets them, up to the first with a
// hit (step c).
fn search_lists(pixel: u32, least: f32, most: f32, forwards: bool) {
    var first = 0u;
    var last = shape.buckets - 1u;
    if (shape.bounds_word > 0u) {
        if (search.skip_buckets == 1u && last > 0u) {
            let bounds = bounds_of(pixel);
            // A little more than what is asked for: fragments were put into buckets by another shader.
            let shares = vec2<f32>(bucket_share(least, bounds), bucket_share(most, bounds)) * f32(shape.buckets);
            let held = clamp(floor(shares + vec2<f32>(-1e-3, 1e-3)), vec2<f32>(0.0), vec2<f32>(f32(last)));
            first = u32(held.x);
            last = u32(held.y);
        }
    } else if (search.skip_bounds == 1u && shape.double == 1u) {
        let head = word_of(pixel, 0u);
        if (head == 0u) {
            return;
        }
        let tail = word_of(pixel, 1u);
        if (misses(vec2<f32>(test_depth(head - 1u), test_depth(tail - 1u)), least, most)) {
            return;
        }
    }
    var opened = first;
    open += 1u;
    loop {
        search_list(pixel, select(last + first - opened, opened, forwards), least, most, forwards);
        opened += 1u;
        if (opened > last || found) {
            open -= 1u;
            break;
        }
    }
}

// The fragments of a pixel, as they are stored.
fn search_fragments(pixel: u32, least: f32, most: f32, forwards: bool) {
    if (has_planes() && has_pieces()) {
        search_piece_of_planes(pixel, most, forwards);
    } else if (has_planes()) {
        search_lists_of_planes(pixel, most, forwards);
    } else if (has_pieces()) {
        search_piece(pixel, least, most, forwards);
    } else {
        search_lists(pixel, least, most, forwards);
    }
}
