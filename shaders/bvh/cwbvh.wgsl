// Search of a compressed eight-wide hierarchy: Ylitie, Karras, Laine, "Efficient Incoherent Ray Traversal on GPUs Through
// Compressed Wide BVHs", HPG 2017, sections 3 and 4, over nodes as the obvhs crate lays them out (least and greatest
// planes of an axis stand together). Lanes take several rays each (persistent threads; Aila, Laine, "Understanding the
// Efficiency of Ray Traversal on GPUs", HPG 2009).
//
// A round tests one triangle and visits one node, for all lanes at once. A loop over a node's triangles would wait for the
// lane with most of them: of eight lanes, one or two are busy in it. Triangles that are left wait, as the paper postpones
// them, but for a fixed room (two nodes' triangles) instead of a vote of the lanes, which WGSL has no means for without an
// extension. Postponing costs 1 to 2 % more nodes and 5 to 7 % more triangles.

#import tracebench::types::{Ray, Hit}
#import tracebench::dispatch::{Invocation, linear_invocation}
#import tracebench::lanes::{WORKGROUP_SIZE, block_of, take_ray}
#import tracebench::reads::quad_0
#import tracebench::bvh_search::{
    SearchSettings, Search, begin_search, load_triangle, test_triangle, finish_search, Work
}

// Five quads.
struct WideNode {
    // Least corner of the children's grid.
    origin: vec3<f32>,
    // Bytes: exponents of the grid's step along x, y, z; which children are nodes.
    exponents_and_nodes: u32,
    first_child: u32,
    first_triangle: u32,
    // A byte a child. Nodes: 0b001 and 24 + slot; leaves: triangles in unary and offset; none: 0.
    children: vec2<u32>,
    // Grid planes of an axis, a byte a child: two words of the least, two of the greatest.
    x: vec4<u32>,
    y: vec4<u32>,
    z: vec4<u32>,
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
@group(0) @binding(6) var<storage, read_write> stacks: array<vec2<u32>>;
#endif
#else
#ifdef DEEP
@group(0) @binding(3) var<storage, read_write> stacks: array<vec2<u32>>;
#endif
#endif

// Entries of the private stack. A level pushes once at most; the host takes the deep variant for more levels.
const PRIVATE_STACK: u32 = 24u;
// Bits of a group of children to visit: which of them, in order, above; which of the node's children are nodes, below.
const PENDING: u32 = 0xff000000u;
// A group that holds the root alone.
const ROOT_GROUP: vec2<u32> = vec2<u32>(0u, 0x80000000u);
// A bound on the rounding of a plane's ray parameter, over the sum of its terms' sizes: two differences and products, and
// a division of 2.5 ulp, with room. Boxes are widened by it, so that no box that a ray meets is lost.
const PLANE_SLACK: f32 = 4.76837158e-7;

// Rounds after which a lane that has done with its ray gets the next one. Drivers that run a branch for all lanes where
// one takes it, or even where none does, pay for fetching rays and storing hits in every round; a lane that waits loses
// one and a half rounds of ten or more.
const ROUNDS: u32 = 4u;

fn load_node(index: u32) -> WideNode {
    let head = quad_0(5u * index);
    let references = quad_0(5u * index + 1u);
    return WideNode(
        bitcast<vec3<f32>>(head.xyz),
        head.w,
        references.x,
        references.y,
        references.zw,
        quad_0(5u * index + 2u),
        quad_0(5u * index + 3u),
        quad_0(5u * index + 4u),
    );
}

// Without the built-ins' promises for what is no number, which cost drivers two more operations; planes are finite.
fn min_second_if_nan(a: vec4<f32>, b: vec4<f32>) -> vec4<f32> {
    return select(b, a, (a < b));
}

fn max_second_if_nan(a: vec4<f32>, b: vec4<f32>) -> vec4<f32> {
    return select(b, a, (a > b));
}

fn bytes(word: u32) -> vec4<f32> {
    return vec4<f32>(unpack4xU8(word));
}

// The bits that four children set when their boxes are met.
fn child_bits(children: u32, octant: u32, met: vec4<bool>) -> u32 {
    // Of nodes, and of nothing else, both bits of 24 are set.
    let is_node = ((children & (children << 1u)) & 0x10101010u) >> 4u;
    let shift = unpack4xU8((children ^ (octant & (is_node * 0xffu))) & 0x1f1f1f1fu);
    let bits = unpack4xU8((children >> 5u) & 0x07070707u) << shift;
    let chosen = select(vec4<u32>(0u), bits, met);
    return (chosen.x | chosen.y) | (chosen.z | chosen.w);
}

struct Planes {
    near_factor: vec3<f32>,
    near: vec3<f32>,
    far: vec3<f32>,
}

// Which of four children a ray meets between t_min and t_max.
fn boxes_met(planes: Planes, near: vec3<u32>, far: vec3<u32>, t_min: f32, t_max: f32) -> vec4<bool> {
    let factor = planes.near_factor;
    let enter_x = bytes(near.x) * factor.x + planes.near.x;
    let enter_y = bytes(near.y) * factor.y + planes.near.y;
    let enter_z = bytes(near.z) * factor.z + planes.near.z;
    let leave_x = bytes(far.x) * factor.x + planes.far.x;
    let leave_y = bytes(far.y) * factor.y + planes.far.y;
    let leave_z = bytes(far.z) * factor.z + planes.far.z;
    let enter = max_second_if_nan(max_second_if_nan(enter_x, enter_y), max_second_if_nan(enter_z, vec4<f32>(t_min)));
    let leave = min_second_if_nan(min_second_if_nan(leave_x, leave_y), min_second_if_nan(leave_z, vec4<f32>(t_max)));
    return enter <= leave;
}

// Bits of the children that the ray meets: nodes above, triangles below.
fn meet_children(node: WideNode, search: ptr<function, Search>, octant: u32) -> u32 {
    let exponents = node.exponents_and_nodes;
    let step = bitcast<vec3<f32>>((vec3<u32>(exponents, exponents >> 8u, exponents >> 16u) & vec3<u32>(0xffu)) << vec3<u32>(23u));
    let factor = step * (*search).inverse;
    let base = (node.origin - (*search).frame.origin) * (*search).inverse;
    let slack = (abs(base) + 255.0 * abs(factor)) * PLANE_SLACK;
    let planes = Planes(factor, base - slack, base + slack);
    let backward = (*search).inverse < vec3<f32>(0.0);
    let near_x = select(node.x.xy, node.x.zw, backward.x);
    let near_y = select(node.y.xy, node.y.zw, backward.y);
    let near_z = select(node.z.xy, node.z.zw, backward.z);
    let far_x = select(node.x.zw, node.x.xy, backward.x);
    let far_y = select(node.y.zw, node.y.xy, backward.y);
    let far_z = select(node.z.zw, node.z.xy, backward.z);
    let t_min = (*search).t_min;
    let t_max = (*search).t_max;
    let low = boxes_met(planes, vec3<u32>(near_x.x, near_y.x, near_z.x), vec3<u32>(far_x.x, far_y.x, far_z.x), t_min, t_max);
    let high = boxes_met(planes, vec3<u32>(near_x.y, near_y.y, near_z.y), vec3<u32>(far_x.y, far_y.y, far_z.y), t_min, t_max);
    return child_bits(node.children.x, octant, low) | child_bits(node.children.y, octant, high);
}

// The order of children for a direction, in every byte: a bit of it is set where a component is not negative.
fn octant_of(inverse: vec3<f32>) -> u32 {
    let bits = select(vec3<u32>(4u, 2u, 1u), vec3<u32>(0u), (inverse < vec3<f32>(0.0)));
    return (bits.x | bits.y | bits.z) * 0x01010101u;
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
    var stack: array<vec2<u32>, PRIVATE_STACK>;
#endif
    var stack_size = 0u;
    var search = begin_search(settings, rays[ray]);
    var octant = octant_of(search.inverse);
    // Children to visit; those of their ancestors wait on the stack.
    var group = ROOT_GROUP;
    // Triangles to test, bits from the first one's slot on, of one node and of the one after it.
    var leaves = 0u;
    var first_triangle = 0u;
    var next_leaves = 0u;
    var next_first_triangle = 0u;
#ifdef COUNTERS
    var work = Work();
#endif
    loop {
        var busy = true;
        var round = 0u;
        loop {
            if (leaves != 0u) {
                let offset = firstLeadingBit(leaves);
                leaves &= ~(1u << offset);
                test_triangle(&search, load_triangle(first_triangle + offset));
#ifdef COUNTERS
                work.triangle_tests += 1u;
                let reference = first_triangle + offset;
                atomicOr(&references_touched[reference >> 5u], 1u << (reference & 31u));
#endif
            }
            if (settings.any_hit == 1u && search.found) {
                leaves = 0u;
                next_leaves = 0u;
                group.y = 0u;
                stack_size = 0u;
            }
            let pending = group.y;
            let bit = firstLeadingBit(pending);
            let rest = pending & ~(1u << bit);
            let visits = next_leaves == 0u && (pending & PENDING) != 0u;
            // Written whether or not it is kept, where there is always room: one branch fewer.
#ifdef DEEP
            stacks[stack_base + stack_size] = vec2<u32>(group.x, rest);
#else
            stack[stack_size] = vec2<u32>(group.x, rest);
#endif
            stack_size += select(0u, 1u, visits && (rest & PENDING) != 0u);
            if (visits) {
                let slot = (bit - 24u) ^ (octant & 0xffu);
                let node = load_node(group.x + countOneBits(pending & ~(0xffffffffu << slot)));
                let met = meet_children(node, &search, octant);
#ifdef COUNTERS
                work.nodes_visited += 1u;
                let visited = group.x + countOneBits(pending & ~(0xffffffffu << slot));
                atomicOr(&nodes_touched[visited >> 5u], 1u << (visited & 31u));
#endif
                group = vec2<u32>(node.first_child, (met & PENDING) | (node.exponents_and_nodes >> 24u));
                next_leaves = met & ~PENDING;
                next_first_triangle = node.first_triangle;
                if ((group.y & PENDING) == 0u && stack_size > 0u) {
                    stack_size -= 1u;
#ifdef DEEP
                    group = stacks[stack_base + stack_size];
#else
                    group = stack[stack_size];
#endif
                }
            }
            let moves_up = leaves == 0u;
            leaves = select(leaves, next_leaves, moves_up);
            first_triangle = select(first_triangle, next_first_triangle, moves_up);
            next_leaves = select(next_leaves, 0u, moves_up);
            busy = (leaves | (group.y & PENDING)) != 0u;
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
            octant = octant_of(search.inverse);
            group = ROOT_GROUP;
        }
    }
}
