// The trace through voxels alone, a bit each: what the paper's Figure 9 sets its method beside (Papaioannou et al. 2010). A ray ends
// where it enters a voxel that has anything; those that hold its start are left first.

#import tracebench::dispatch::Invocation
#import tracebench::types::{Ray, Hit, miss, NO_PRIMITIVE, STATUS_HIT, STATUS_MISS, STATUS_STEP_CAP}
#import tracebench::lanes::{WORKGROUP_SIZE, answer_rays}
#import tracebench::reads::word_1
#import tracebench::image_walk::Span
#import tracebench::unit_space::{to_unit, voxel_at, voxel_index}
#import tracebench::voxel_settings::VoxelSearch
#import tracebench::voxel_walk::{span_in_cube, leaves_voxel, next_voxel, is_in_grid}

@group(0) @binding(0) var<uniform> search: VoxelSearch;
@group(0) @binding(1) var<storage, read> rays: array<Ray>;
@group(0) @binding(2) var<storage, read_write> hits: array<Hit>;
#ifdef COUNTERS
// Of every ray: voxels stepped through.
@group(0) @binding(4) var<storage, read_write> counts: array<u32>;
#endif

fn is_occupied(voxel: vec3<i32>) -> bool {
    let index = voxel_index(search.space, voxel);
    return ((word_1(index >> 5u) >> (index & 31u)) & 1u) == 1u;
}

struct Answer {
    hit: Hit,
    stepped: u32,
}

fn find_hit(ray: Ray) -> Answer {
    let space = search.space;
    let origin = to_unit(space, ray.origin);
    let direction = ray.direction * space.scale;
    let span = span_in_cube(origin, direction, Span(ray.t_min, ray.t_max));
    if (!(span.begin <= span.end)) {
        return Answer(miss(STATUS_MISS), 0u);
    }
    let edge = f32(space.grid);
    let heading = vec3<i32>(sign(direction));
    var voxel = voxel_at(space, origin + direction * span.begin);
    var t = span.begin;
    var leaving_start = span.begin <= ray.t_min;
    var stepped = 0u;
    // No ray crosses more: what is beyond was cut off by the driver.
    let most = 3u * space.grid;
    loop {
        if (stepped > most) {
            return Answer(miss(STATUS_STEP_CAP), stepped);
        }
        stepped += 1u;
        let occupied = is_occupied(voxel);
        if (occupied && !leaving_start) {
            return Answer(Hit(clamp(t, ray.t_min, ray.t_max), NO_PRIMITIVE, 0.0, 0.0, STATUS_HIT), stepped);
        }
        leaving_start = leaving_start && occupied;
        let leaves = leaves_voxel(origin, direction, heading, voxel, edge);
        let exit = clamp(min(leaves.x, min(leaves.y, leaves.z)), t, span.end);
        voxel = next_voxel(voxel, heading, leaves);
        if (exit >= span.end || !is_in_grid(voxel, space.grid)) {
            return Answer(miss(STATUS_MISS), stepped);
        }
        t = exit;
    }
    return Answer(miss(STATUS_STEP_CAP), stepped);
}

override fn tracebench::lanes::answer_ray(index: u32) {
    let answer = find_hit(rays[index]);
    hits[index] = answer.hit;
#ifdef COUNTERS
    counts[index] = answer.stepped;
#endif
}

@compute @workgroup_size(WORKGROUP_SIZE)
fn trace(invocation: Invocation) {
    answer_rays(invocation, search.ray_count, search.rays_per_lane);
}
