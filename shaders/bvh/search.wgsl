#define_import_path tracebench::bvh_search

// What the searches of bounding volume hierarchies share: rays scaled to the hierarchy, triangles read and tested, hits. Nodes
// are read as quads 0, triangles as quads 1.

#import tracebench::types::{Ray, Hit, miss, STATUS_HIT, STATUS_MISS}
#import tracebench::triangle::{RayFrame, ray_frame, cross_triangle}
#import tracebench::reads::quad_1
#import tracebench::bvh_triangle::Triangle

struct SearchSettings {
    // Rays from the first one on that this dispatch answers.
    first_ray: u32,
    ray_count: u32,
    // Rays that one invocation answers one after the other, >= 1.
    rays_per_lane: u32,
    // 1: any hit ends the search.
    any_hit: u32,
    // Entries of a lane's stack in device memory; 0 where stacks are private.
    stack_entries: u32,
    // From scene units to those of the hierarchy, and back: powers of two.
    scale: f32,
    unscale: f32,
    // The largest t in scene units that the scale keeps finite.
    max_t: f32,
}

// What is counted of a ray.
struct Work {
    // Of a binary hierarchy, pairs of siblings.
    nodes_visited: u32,
    triangle_tests: u32,
    // Rounds in which it had something to do.
    search_rounds: u32,
}

fn load_triangle(slot: u32) -> Triangle {
    let first = quad_1(3u * slot);
    let second = quad_1(3u * slot + 1u);
    let third = quad_1(3u * slot + 2u);
    return Triangle(
        bitcast<vec3<f32>>(first.xyz),
        first.w,
        bitcast<vec3<f32>>(second.xyz),
        second.w,
        bitcast<vec3<f32>>(third.xyz),
        third.w,
    );
}

// A ray on its way through a hierarchy, in the hierarchy's units.
struct Search {
    frame: RayFrame,
    // One over the direction; large and finite where a component is 0.
    inverse: vec3<f32>,
    t_min: f32,
    // Of the hit found, else the ray's.
    t_max: f32,
    primitive: u32,
    u: f32,
    v: f32,
    found: bool,
}

// Directions' components below this count as it, with their sign: one over it times any scaled length is finite.
const MIN_COMPONENT: f32 = 1e-18;

fn safe_inverse(direction: vec3<f32>) -> vec3<f32> {
    let least = select(vec3<f32>(MIN_COMPONENT), vec3<f32>(-MIN_COMPONENT), (direction < vec3<f32>(0.0)));
    return 1.0 / select(direction, least, (abs(direction) < vec3<f32>(MIN_COMPONENT)));
}

fn begin_search(settings: SearchSettings, ray: Ray) -> Search {
    return Search(
        ray_frame(ray.origin * settings.scale, ray.direction),
        safe_inverse(ray.direction),
        ray.t_min * settings.scale,
        min(ray.t_max, settings.max_t) * settings.scale,
        0xffffffffu,
        0.0,
        0.0,
        false,
    );
}

// Tests a triangle; of equal t the lower primitive is kept.
fn test_triangle(search: ptr<function, Search>, triangle: Triangle) {
    let crossing = cross_triangle((*search).frame, triangle.first, triangle.second, triangle.third);
    let nearer = crossing.t < (*search).t_max;
    // Without a hit so far the primitive is the largest there is.
    let wins_tie = crossing.t == (*search).t_max && triangle.primitive < (*search).primitive;
    if (crossing.t >= (*search).t_min && (nearer || wins_tie)) {
        (*search).t_max = crossing.t;
        (*search).primitive = triangle.primitive;
        (*search).u = crossing.u;
        (*search).v = crossing.v;
        (*search).found = true;
    }
}

fn finish_search(settings: SearchSettings, search: Search) -> Hit {
    if (!search.found) {
        return miss(STATUS_MISS);
    }
    return Hit(search.t_max * settings.unscale, search.primitive, search.u, search.v, STATUS_HIT);
}
