// Search of a binary hierarchy, nearer child first, as Aila and Laine's while-while loop ("Understanding the Efficiency of
// Ray Traversal on GPUs", HPG 2009), with several rays a lane. Siblings stand together, and a visit tests both.

#import tracebench::types::{Ray, Hit}
#import tracebench::dispatch::linear_invocation
#import tracebench::bvh_search::{SearchSettings, Triangle, Search, begin_search, test_triangle, finish_search}

struct BinaryNode {
    low: vec3<f32>,
    // The first of two siblings, or the first triangle.
    first: u32,
    high: vec3<f32>,
    // Triangles of a leaf, or INNER.
    count: u32,
}

@group(0) @binding(0) var<uniform> settings: SearchSettings;
@group(0) @binding(1) var<storage, read> nodes: array<BinaryNode>;
@group(0) @binding(2) var<storage, read> triangles: array<Triangle>;
@group(0) @binding(3) var<storage, read> rays: array<Ray>;
@group(0) @binding(4) var<storage, read_write> hits: array<Hit>;
#ifdef COUNTERS
// Of every ray: pairs of siblings visited, triangles tested.
@group(0) @binding(5) var<storage, read_write> counts: array<vec2<u32>>;
#ifdef DEEP
@group(0) @binding(6) var<storage, read_write> stacks: array<u32>;
#endif
#else
#ifdef DEEP
@group(0) @binding(5) var<storage, read_write> stacks: array<u32>;
#endif
#endif

const WORKGROUP_SIZE: u32 = 64u;
// Entries of the private stack. A level pushes once at most; the host takes the deep variant for more levels.
const PRIVATE_STACK: u32 = 64u;
const INNER: u32 = 0xffffffffu;
// As in cwbvh.wgsl: a bound on the rounding of a plane's ray parameter, over its size.
const PLANE_SLACK: f32 = 4.76837158e-7;

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
fn trace(
    @builtin(workgroup_id) workgroup: vec3<u32>,
    @builtin(num_workgroups) workgroups: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let lane = linear_invocation(workgroup, workgroups, local, WORKGROUP_SIZE);
    // Neighbours take neighbouring rays: a workgroup's rays are a block, dealt out in turn.
    let block = (lane - local) * settings.rays_per_lane;
    let end = settings.first_ray + min(block + WORKGROUP_SIZE * settings.rays_per_lane, settings.ray_count);
    var index = settings.first_ray + block + local;
    if (index >= end) {
        return;
    }
#ifdef DEEP
    let stack_base = lane * settings.stack_entries;
#else
    var stack: array<u32, PRIVATE_STACK>;
#endif
    var stack_size = 0u;
    var search = begin_search(settings, rays[index]);
    var pair = 0u;
#ifdef COUNTERS
    var work = vec2<u32>(0u);
#endif
    loop {
        var nearer = nodes[pair];
        var farther = nodes[pair + 1u];
        var first = meet_box(nearer, &search);
        var second = meet_box(farther, &search);
#ifdef COUNTERS
        work.x += 1u;
#endif
        if (second.met && (!first.met || second.enter < first.enter)) {
            let node = nearer;
            nearer = farther;
            farther = node;
            let meeting = first;
            first = second;
            second = meeting;
        }
        var next = INNER;
        if (first.met) {
            if (nearer.count == INNER) {
                next = nearer.first;
            } else {
                for (var slot = nearer.first; slot < nearer.first + nearer.count; slot++) {
                    test_triangle(&search, triangles[slot]);
#ifdef COUNTERS
                    work.y += 1u;
#endif
                    if (settings.any_hit == 1u && search.found) {
                        break;
                    }
                }
            }
        }
        // A hit in the nearer child may lie before the farther one.
        if (second.met && second.enter <= search.t_max) {
            if (farther.count != INNER) {
                for (var slot = farther.first; slot < farther.first + farther.count; slot++) {
                    if (settings.any_hit == 1u && search.found) {
                        break;
                    }
                    test_triangle(&search, triangles[slot]);
#ifdef COUNTERS
                    work.y += 1u;
#endif
                }
            } else if (next == INNER) {
                next = farther.first;
            } else {
#ifdef DEEP
                stacks[stack_base + stack_size] = farther.first;
#else
                stack[stack_size] = farther.first;
#endif
                stack_size += 1u;
            }
        }
        let done = settings.any_hit == 1u && search.found;
        if (next != INNER && !done) {
            pair = next;
        } else if (stack_size > 0u && !done) {
            stack_size -= 1u;
#ifdef DEEP
            pair = stacks[stack_base + stack_size];
#else
            pair = stack[stack_size];
#endif
        } else {
            hits[index] = finish_search(settings, search);
#ifdef COUNTERS
            counts[index] = work;
            work = vec2<u32>(0u);
#endif
            index += WORKGROUP_SIZE;
            if (index >= end) {
                break;
            }
            search = begin_search(settings, rays[index]);
            pair = 0u;
            stack_size = 0u;
        }
    }
}
