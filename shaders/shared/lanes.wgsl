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
// rays: those of a workgroup are a block, dealt out in turn.
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
