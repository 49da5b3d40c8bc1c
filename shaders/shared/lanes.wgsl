#define_import_path tracebench::lanes

// Which rays a lane answers, one after the other (persistent lanes; Aila, Laine, "Understanding the Efficiency of Ray Traversal
// on GPUs", HPG 2009). A lane whose search was short need not wait for others. With a ray a lane there is one turn.

#import tracebench::dispatch::linear_invocation

// Lanes of a workgroup.
const WORKGROUP_SIZE: u32 = 64u;

struct Turns {
    // The ray of this turn; that of the next one is WORKGROUP_SIZE further.
    ray: u32,
    // The lane has done where `ray` reaches it.
    end: u32,
}

// The turns of a lane that answers `rays_per_lane` of the `ray_count` rays from `first_ray` on. Neighbours take neighbouring
// rays: those of a workgroup are a block, dealt out in turn. For searches that answer a ray before they begin the next: lanes that run
// together wait for one another there, and have done together.
fn turns_of(
    workgroup: vec3<u32>,
    workgroups: vec3<u32>,
    local: u32,
    first_ray: u32,
    ray_count: u32,
    rays_per_lane: u32,
) -> Turns {
    let lane = linear_invocation(workgroup, workgroups, local, WORKGROUP_SIZE);
    let block = (lane - local) * rays_per_lane;
    let end = first_ray + min(block + WORKGROUP_SIZE * rays_per_lane, ray_count);
    return Turns(first_ray + block + local, end);
}

// Lanes that take their rays from one pool: as many as Mesa's software driver runs together. They wait for the one that has done last;
// where each had its share dealt out beforehand, traces of diffuse rays took 11 to 18 % longer there. With more of them the driver would
// give all rays of a workgroup to its first eight lanes, whose rounds it counts (packed_ray.wgsl).
const POOL_LANES: u32 = 8u;
const POOLS: u32 = 8u;

// Rays of the workgroup's pools that lanes have taken.
var<workgroup> taken: array<atomic<u32>, POOLS>;

// Rays that some lanes answer.
struct Pool {
    // Of the workgroup's.
    number: u32,
    first: u32,
    end: u32,
}

// The pool of a lane where lanes answer, at the mean, `rays_per_lane` of the `ray_count` rays from `first_ray` on. For searches in rounds,
// in which a lane begins its next ray while others go on.
fn pool_of(
    workgroup: vec3<u32>,
    workgroups: vec3<u32>,
    local: u32,
    first_ray: u32,
    ray_count: u32,
    rays_per_lane: u32,
) -> Pool {
    let number = local / POOL_LANES;
    let lane = linear_invocation(workgroup, workgroups, number * POOL_LANES, WORKGROUP_SIZE);
    let first = lane * rays_per_lane;
    return Pool(number, first_ray + first, first_ray + min(first + POOL_LANES * rays_per_lane, ray_count));
}

// The next ray of a pool; there is none where it is not before the pool's end.
fn take_ray(pool: Pool) -> u32 {
    return pool.first + atomicAdd(&taken[pool.number], 1u);
}
