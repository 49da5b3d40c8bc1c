// Search of a binary hierarchy, nearer child first, with several rays a lane (Aila, Laine, "Understanding the Efficiency of
// Ray Traversal on GPUs", HPG 2009), in rounds of one triangle and one visit as in cwbvh.wgsl. Siblings stand together, and
// a visit tests both.

#import tracebench::types::{Ray, Hit}
#import tracebench::dispatch::{Invocation, linear_invocation}
#import tracebench::lanes::{WORKGROUP_SIZE, block_of, take_ray}
#import tracebench::reads::quad_0
#import tracebench::bvh_search::{
    SearchSettings, Search, begin_search, load_triangle, test_triangle, finish_search, Work
}

// Two quads.
struct BinaryNode {
    low: vec3<f32>,
    // The first of two siblings, or the first triangle.
    first: u32,
    high: vec3<f32>,
    // Triangles of a leaf, or INNER.
    count: u32,
}

@group(0) @binding(0) var<uniform> settings: SearchSettings;
@group(0) @binding(1) var<storage, read> rays: array<Ray>;
@group(0) @binding(2) var<storage, read_write> hits: array<Hit>;
#ifdef COUNTERS
@group(0) @binding(3) var<storage, read_write> counts: array<Work>;
// A bit each: visited, and tested, by any ray.
@group(0) @binding(4) var<storage, read_write> nodes_touched: array<atomic<u32>>;
@group(0) @binding(5) var<storage, read_write> references_touched: array<atomic<u32>>;
#ifdef DEEP
@group(0) @binding(6) var<storage, read_write> stacks: array<u32>;
#endif
#else
#ifdef DEEP
@group(0) @binding(3) var<storage, read_write> stacks: array<u32>;
#endif
#endif

// Entries of the private stack. A level pushes once at most; the host takes the deep variant for more levels.
const PRIVATE_STACK: u32 = 64u;
const INNER: u32 = 0xffffffffu;
// No pair of siblings.
const NONE: u32 = 0xffffffffu;
// As in cwbvh.wgsl: rounds after which a lane that has done with its ray gets the next one. A ray takes three times as many
// here.
const ROUNDS: u32 = 8u;
// As in cwbvh.wgsl: a bound on the rounding of a plane's ray parameter, over its size.
const PLANE_SLACK: f32 = 4.76837158e-7;

fn load_node(index: u32) -> BinaryNode {
    let low = quad_0(2u * index);
    let high = quad_0(2u * index + 1u);
    return BinaryNode(bitcast<vec3<f32>>(low.xyz), low.w, bitcast<vec3<f32>>(high.xyz), high.w);
}

// Where a ray enters a box, and whether it meets it between t_min and t_max.
struct Meeting {
    enter: f32,
    met: bool,
}

fn meet_box(node: BinaryNode, search: ptr<function, Search>) -> Meeting {
    let low = (node.low - (*search).frame.origin) * (*search).inverse;
    let high = (node.high - (*search).frame.origin) * (*search).inverse;
    let near = min(low, high);
    let far = max(low, high);
    let widened_near = near - abs(near) * PLANE_SLACK;
    let widened_far = far + abs(far) * PLANE_SLACK;
    let enter = max(max(widened_near.x, widened_near.y), max(widened_near.z, (*search).t_min));
    let leave = min(min(widened_far.x, widened_far.y), min(widened_far.z, (*search).t_max));
    return Meeting(enter, enter <= leave);
}

@compute @workgroup_size(WORKGROUP_SIZE)
fn trace(invocation: Invocation) {
    let block = block_of(invocation, settings.first_ray, settings.ray_count, settings.rays_per_lane);
    var ray = take_ray(block, invocation.local);
    if (ray >= block.end) {
        return;
    }
#ifdef DEEP
    let stack_base = linear_invocation(invocation, WORKGROUP_SIZE) * settings.stack_entries;
#else
    var stack: array<u32, PRIVATE_STACK>;
#endif
    var stack_size = 0u;
    var search = begin_search(settings, rays[ray]);
    // Siblings to visit next.
    var pair = 0u;
    // Triangles to test: those of a leaf, and of its sibling if that is one too.
    var slot = 0u;
    var leaf_end = 0u;
    var sibling_slot = 0u;
    var sibling_end = 0u;
#ifdef COUNTERS
    var work = Work();
#endif
    loop {
        var busy = true;
        var round = 0u;
        loop {
            if (slot < leaf_end) {
                test_triangle(&search, load_triangle(slot));
#ifdef COUNTERS
                work.triangle_tests += 1u;
                atomicOr(&references_touched[slot >> 5u], 1u << (slot & 31u));
#endif
                slot += 1u;
            }
            if (settings.any_hit == 1u && search.found) {
                leaf_end = slot;
                sibling_end = sibling_slot;
                pair = NONE;
                stack_size = 0u;
            }
            var waiting = NONE;
            let visits = slot == leaf_end && sibling_slot == sibling_end && pair != NONE;
            if (visits) {
                var nearer = load_node(pair);
                var farther = load_node(pair + 1u);
                let first = meet_box(nearer, &search);
                let second = meet_box(farther, &search);
#ifdef COUNTERS
                work.nodes_visited += 1u;
                // Both siblings: a pair begins at an even place, so both bits are in one word.
                atomicOr(&nodes_touched[pair >> 5u], 3u << (pair & 31u));
#endif
                // Leaves without triangles stand for what is not met.
                nearer.count = select(0u, nearer.count, first.met);
                farther.count = select(0u, farther.count, second.met);
                if (second.met && (!first.met || second.enter < first.enter)) {
                    let node = nearer;
                    nearer = farther;
                    farther = node;
                }
                let nearer_inner = nearer.count == INNER;
                let farther_inner = farther.count == INNER;
                slot = nearer.first;
                leaf_end = nearer.first + select(nearer.count, 0u, nearer_inner);
                sibling_slot = farther.first;
                sibling_end = farther.first + select(farther.count, 0u, farther_inner);
                pair = select(select(NONE, farther.first, farther_inner), nearer.first, nearer_inner);
                waiting = select(NONE, farther.first, nearer_inner && farther_inner);
            }
            // Written whether or not it is kept, where there is always room: one branch fewer.
#ifdef DEEP
            stacks[stack_base + stack_size] = waiting;
#else
            stack[stack_size] = waiting;
#endif
            stack_size += select(0u, 1u, waiting != NONE);
            if (pair == NONE && stack_size > 0u) {
                stack_size -= 1u;
#ifdef DEEP
                pair = stacks[stack_base + stack_size];
#else
                pair = stack[stack_size];
#endif
            }
            let moves_up = slot == leaf_end;
            slot = select(slot, sibling_slot, moves_up);
            leaf_end = select(leaf_end, sibling_end, moves_up);
            sibling_end = select(sibling_end, sibling_slot, moves_up);
            busy = slot != leaf_end || pair != NONE;
            round += 1u;
#ifdef COUNTERS
            work.search_rounds += 1u;
#endif
            continuing {
                break if !busy || round == ROUNDS;
            }
        }
        if (!busy) {
            hits[ray] = finish_search(settings, search);
#ifdef COUNTERS
            counts[ray] = work;
            work = Work();
#endif
            ray = take_ray(block, invocation.local);
            if (ray >= block.end) {
                break;
            }
            search = begin_search(settings, rays[ray]);
            pair = 0u;
        }
    }
}
