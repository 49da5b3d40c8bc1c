#define_import_path tracebench::lanes

// Which rays a lane answers, one after the other (persistent lanes; Aila, Laine, "Understanding the Efficiency of Ray Traversal
// on GPUs", HPG 2009). A lane whose search was short need not wait for others. With a ray a lane there is one turn.

#import tracebench::dispatch::{Invocation, linear_workgroup}

// Lanes of a workgroup.
const WORKGROUP_SIZE: u32 = 64u;
// Lanes that share a block of rays: as many as Mesa's software driver runs together.
const BLOCK_LANES: u32 = 8u;
// Blocks of a workgroup.
const BLOCKS: u32 = WORKGROUP_SIZE / BLOCK_LANES;

// Rays in a row that BLOCK_LANES lanes answer.
struct Block {
    first: u32,
    end: u32,
}

// The block of a lane where lanes answer `rays_per_lane` of the `ray_count` rays from `first_ray` on. With several rays a lane those of a
// workgroup lie far apart: a driver may give each of its threads workgroups in a row, and parts of an image differ in what they cost. With
// one, neighbours stay neighbours.
fn block_of(invocation: Invocation, first_ray: u32, ray_count: u32, rays_per_lane: u32) -> Block {
    let group = linear_workgroup(invocation);
    let place = invocation.local / BLOCK_LANES;
    let apart = place * invocation.workgroups.x * invocation.workgroups.y + group;
    let number = select(apart, group * BLOCKS + place, rays_per_lane == 1u);
    let first = number * BLOCK_LANES * rays_per_lane;
    return Block(first_ray + min(first, ray_count), first_ray + min(first + BLOCK_LANES * rays_per_lane, ray_count));
}

struct Turns {
    // The ray of this turn; that of the next one is BLOCK_LANES further.
    ray: u32,
    // The lane has done where `ray` reaches it.
    end: u32,
}

// The turns of a lane: every eighth ray of its block. For searches that answer a ray before they begin the next: lanes that run together
// wait for one another there, and have done together.
fn turns_of(invocation: Invocation, first_ray: u32, ray_count: u32, rays_per_lane: u32) -> Turns {
    let block = block_of(invocation, first_ray, ray_count, rays_per_lane);
    return Turns(block.first + invocation.local % BLOCK_LANES, block.end);
}

// Loops of a lane that were begun and not ended by themselves. Drivers may cut loops off: Mesa's software driver ends those of eight lanes
// together after 65,535 rounds in all. A lane leaves a ray that was cut off without an answer, and those behind it; `trace_unanswered`
// answers them, a ray a lane. A ray that is alone in its lane is given up like one that ran out of steps. Searches whose rays take few
// rounds count no loops: they get as few rays a lane as no driver cuts off (`rays_within_rounds` of tracers/kit/src/lanes.rs).
var<private> open: u32;

// Whether a ray of the workgroup has no answer.
var<workgroup> unanswered: atomic<u32>;

virtual fn search_ray(index: u32) {
    // What a search that counts its open loops has of its own: what it found stays in private variables. (naga_oil joins `virtual` to the
    // line before, which must not be a comment.)
}

virtual fn answer_ray(index: u32) {
    // Writes the answer; a search that counts no loops is in here, whole.
}

// The rays of a lane, one after the other. The way out of the loop lies between search and answer: where it lay behind
// both, Mesa's software driver took 1.4 to 1.9 times as long over `voxel-abuffer`.
fn answer_rays(invocation: Invocation, ray_count: u32, rays_per_lane: u32) {
    var turns = turns_of(invocation, 0u, ray_count, rays_per_lane);
    while (turns.ray < turns.end) {
        search_ray(turns.ray);
        if (open > 0u && rays_per_lane > 1u) {
            break;
        }
        answer_ray(turns.ray);
        turns.ray += BLOCK_LANES;
    }
}

// A lane of `trace_unanswered`. In a workgroup that has a ray without an answer all are answered, so that the same ones run together, and
// are cut off, as where a lane has one ray from the first.
fn answer_again(index: u32, ray_count: u32, is_unanswered: bool) {
    if (is_unanswered) {
        atomicStore(&unanswered, 1u);
    }
    workgroupBarrier();
    if (atomicLoad(&unanswered) == 1u && index < ray_count) {
        search_ray(index);
        answer_ray(index);
    }
}

// Rays of the workgroup's blocks that lanes have taken.
var<workgroup> taken: array<atomic<u32>, BLOCKS>;

// The next ray of a lane's block that no lane has taken; there is none where it is not before the block's end. For searches in rounds, in
// which a lane begins its next ray while others go on: if rays were dealt out beforehand, as turns are, lanes would wait for the one with
// the longest searches. With more lanes a block the software driver would give all rays of a workgroup to its first eight lanes, whose
// rounds it counts (packed_ray.wgsl).
fn take_ray(block: Block, local: u32) -> u32 {
    return block.first + atomicAdd(&taken[local / BLOCK_LANES], 1u);
}
