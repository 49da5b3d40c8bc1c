// The exact walk through a sparse voxel octree: from empty part to empty part, however large, until a leaf. What comes next is found from
// the root each time, as Crassin, Neyret, Lefebvre, Eisemann do ("GigaVoxels", I3D 2009, section 4.2.1, after kd-restart), or with STACK
// from the deepest node that holds it (Laine, Karras, "Efficient Sparse Voxel Octrees", I3D 2010). A ray is at a voxel of the finest grid
// all the time and goes on to a neighbour of the part that it leaves, across the side that it leaves it by, so that no rounding leads it
// past a voxel's edge.

#import tracebench::dispatch::Invocation
#import tracebench::types::{Ray, Hit, Surface, miss, no_surface, NO_PRIMITIVE, STATUS_HIT, STATUS_MISS, STATUS_STEP_CAP, SURFACE_NO_HIT, SURFACE_WRITTEN}
#import tracebench::lanes::{WORKGROUP_SIZE, answer_rays}
#import tracebench::reads::{pair_0, pair_1}
#import tracebench::image_walk::Span
#import tracebench::unit_space::{UnitSpace, to_unit, voxel_at}
#import tracebench::voxel_walk::{span_in_cube, leaves_voxel, next_voxel, is_in_grid}
#import tracebench::octree_morton::part_of
#import tracebench::octree_normal::unpacked_normal
#import tracebench::octree_settings::MAX_DEPTH

struct OctreeSearch {
    space: UnitSpace,
    ray_count: u32,
    rays_per_lane: u32,
    levels: u32,
    // A hit is, 0: where the ray enters the voxel, 1: where it is nearest to its centre.
    at_centre: u32,
    // Nodes that there is room for, each with a bit; and words of the bits of nodes and leaves.
    touched_words: u32,
    first_leaf_bit: u32,
    padding_a: u32,
    padding_b: u32,
}

@group(0) @binding(0) var<uniform> search: OctreeSearch;
@group(0) @binding(1) var<storage, read> rays: array<Ray>;
@group(0) @binding(2) var<storage, read_write> hits: array<Hit>;
#ifdef SURFACES
@group(0) @binding(3) var<storage, read_write> surfaces: array<Surface>;
#endif
#ifdef COUNTERS
// A bit a node and a bit a leaf that any ray met, and of every ray COUNTS numbers.
@group(0) @binding(4) var<storage, read_write> counted: array<atomic<u32>>;
#endif

// Whether nodes on the way down are kept on a stack.
override STACK: bool;

// Of every ray: nodes read, and parts of the cube stepped out of.
const COUNTS: u32 = 2u;
const VISITED: u32 = 0u;
const STEPPED: u32 = 1u;

// No leaf.
const NONE: u32 = 0xffffffffu;

struct Answer {
    hit: Hit,
    leaf: u32,
}

#ifdef COUNTERS
var<private> work: array<u32, 2>;

fn touch(bit: u32) {
    atomicOr(&counted[bit >> 5u], 1u << (bit & 31u));
}
#endif

fn answer_of(status: u32) -> Answer {
    return Answer(miss(status), NONE);
}

// Where a ray hits a voxel that it is in from `enter` to `leave`.
fn hit_in(ray: Ray, origin: vec3<f32>, direction: vec3<f32>, voxel: vec3<i32>, enter: f32, leave: f32) -> Hit {
    var t = enter;
    if (search.at_centre == 1u) {
        let centre = (vec3<f32>(voxel) + 0.5) / f32(search.space.grid);
        t = clamp(dot(centre - origin, direction) / dot(direction, direction), enter, leave);
    }
    return Hit(clamp(t, ray.t_min, ray.t_max), NO_PRIMITIVE, 0.0, 0.0, STATUS_HIT);
}

fn find_hit(ray: Ray) -> Answer {
#ifdef COUNTERS
    work = array<u32, 2>();
#endif
    let space = search.space;
    let levels = search.levels;
    let origin = to_unit(space, ray.origin);
    let direction = ray.direction * space.scale;
    let span = span_in_cube(origin, direction, Span(ray.t_min, ray.t_max));
    if (!(span.begin <= span.end)) {
        return answer_of(STATUS_MISS);
    }
    let heading = vec3<i32>(sign(direction));
    var voxel = voxel_at(space, origin + direction * span.begin);
    var t = span.begin;
    // Voxels that hold the start are left first.
    var leaving_start = span.begin <= ray.t_min;
    var node = 0u;
    var depth = 0u;
    var stack = array<u32, MAX_DEPTH>();
    // No ray takes more steps: what is beyond was cut off by the driver.
    let most = 3u * space.grid;
    for (var step = 0u; step <= most; step++) {
        var has_child = false;
        var child = 0u;
        // Down to a leaf or an empty part, which is stepped out of behind the loop: drivers may run every branch of one for all lanes.
        loop {
            let record = pair_0(node);
#ifdef COUNTERS
            work[VISITED] += 1u;
            touch(node);
#endif
            let part = part_of(voxel, levels - 1u - depth);
            has_child = ((record.y >> part) & 1u) == 1u;
            child = record.x + countOneBits(record.y & ((1u << part) - 1u));
            if (!has_child || depth + 1u >= levels) {
                break;
            }
            if (STACK) {
                stack[depth] = node;
            }
            node = child;
            depth += 1u;
        }
        // A leaf, or an empty part, at the level below the node.
        let shift = levels - 1u - depth;
        let cell = voxel >> vec3<u32>(shift);
        let edge = space.grid >> shift;
        let leaves = leaves_voxel(origin, direction, heading, cell, f32(edge));
        let exit = clamp(min(leaves.x, min(leaves.y, leaves.z)), t, span.end);
#ifdef COUNTERS
        work[STEPPED] += 1u;
#endif
        if (has_child) {
#ifdef COUNTERS
            touch(search.first_leaf_bit + child);
#endif
            if (!leaving_start) {
                return Answer(hit_in(ray, origin, direction, voxel, t, exit), child);
            }
        }
        leaving_start = leaving_start && has_child;
        let next = next_voxel(cell, heading, leaves);
        if (exit >= span.end || !is_in_grid(next, edge)) {
            return answer_of(STATUS_MISS);
        }
        // The voxel of the next part at the side that the ray enters it by, never behind the one that it was in.
        let low = next << vec3<u32>(shift);
        let high = low + vec3<i32>((1 << shift) - 1);
        let place = clamp(vec3<i32>(floor((origin + direction * exit) * f32(space.grid))), low, high);
        let ahead = select(select(voxel, min(place, voxel), heading < vec3<i32>(0)), max(place, voxel), heading > vec3<i32>(0));
        let entered = select(high, low, heading > vec3<i32>(0));
        let before = voxel;
        voxel = select(ahead, entered, next != cell);
        t = exit;
        if (STACK) {
            // The deepest node that holds both, none below that which was left.
            let differ = (before.x ^ voxel.x) | (before.y ^ voxel.y) | (before.z ^ voxel.z);
            let shared_depth = levels - 1u - u32(firstLeadingBit(differ));
            if (shared_depth < depth) {
                depth = shared_depth;
                node = stack[shared_depth];
            }
        } else {
            depth = 0u;
            node = 0u;
        }
    }
    return answer_of(STATUS_STEP_CAP);
}

#ifdef SURFACES
// The point of the ray, with the leaf's normal and material.
fn surface_of(ray: Ray, answer: Answer) -> Surface {
    if (answer.leaf == NONE) {
        return no_surface(SURFACE_NO_HIT);
    }
    let data = pair_1(answer.leaf);
    let position = ray.origin + ray.direction * answer.hit.t;
    return Surface(position, data.y, unpacked_normal(data.x), SURFACE_WRITTEN);
}
#endif

override fn tracebench::lanes::answer_ray(index: u32) {
    let answer = find_hit(rays[index]);
    hits[index] = answer.hit;
#ifdef SURFACES
    surfaces[index] = surface_of(rays[index], answer);
#endif
#ifdef COUNTERS
    for (var count = 0u; count < COUNTS; count++) {
        atomicStore(&counted[search.touched_words + index * COUNTS + count], work[count]);
    }
#endif
}

@compute @workgroup_size(WORKGROUP_SIZE)
fn trace(invocation: Invocation) {
    answer_rays(invocation, search.ray_count, search.rays_per_lane);
}
